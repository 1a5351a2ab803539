"""The kernels of the orbit engine: compiled once, for all systems; a formula comes in as a program of the machine.

Each works on arrays of many orbits, allocates nothing and raises nothing: what it cannot do it leaves NaN, or not good.
Read ``outward_search.py``, then ``cycle_integrals.py`` with ``midpoint_rule.py`` and ``start_phase.py``.
"""
