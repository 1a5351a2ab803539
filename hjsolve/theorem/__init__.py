"""The Hamilton–Jacobi theorem as tools: complete integrals, brackets, canonical maps (Greenwood, chapters 5 and 6).

In: a system, or variables and a map, and a formula of the user's own. Out: a proof with what follows from it, a
``Flaw`` with a witness, or ``Undecided``. Read ``complete_integral`` first.
"""
