"""One coordinate: where p²(q) ≥ 0 lets it move, and the regular integrals of that motion; no sympy here.

In: p² of one separated coordinate as a tape, with the constants. Out: turning points, the kind of motion, and every
integral over it as a function of a phase: a Fourier series for a bounded motion, Chebyshev panels for an open one.
Read ``classify.py`` first; it calls ``turning_points.py``, then ``anomaly.py`` and ``kind_of_motion.py``.
"""
