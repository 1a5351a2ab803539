"""The time law: Jacobi's equations inverted, from a time to the phases of all coordinates; no sympy here.

In: the motions of the single coordinates and the constants that couple them. Out: phases at given times, with
residuals. Read ``torus.py`` first (all coordinates bounded), then ``open_motion.py``; ``table.py`` serves many times at
once, and ``compiled.py`` says when compiled loops take over.
"""
