"""Solution: Hamilton's characteristic function W and Jacobi's equations as quadratures, all exact.

In: a ``Separation``. Out: a frozen ``Solution`` of momenta, W, time law and orbit equations, integrals unevaluated.
Read ``quadratures.py`` first; ``laws.py`` tests on the printed formulas that they solve what they claim to solve.
"""
