"""Exact derivatives of a motion: how its numbers and its states change with initial data, constants and parameters.

In: a ``Motion``. Out: ``MotionDerivatives`` and transition matrices, every number with a bound on its error. The
integrals are those of the motion, differentiated under the integral sign on its own anomaly (``along_cycle.py``,
``along_branch.py``, ``at_rest.py``); ``canonical.py`` makes of them the matrix between Jacobi's constants and the
state. Read ``transition.py`` first.
"""
