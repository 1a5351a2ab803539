"""The kernels of the orbit engine: compiled once, for all systems; a formula comes in as a program of the machine.

Each works on arrays of many orbits, allocates nothing and raises nothing: what it cannot do it leaves NaN, or not good.
Read ``turning_points.py``, then ``integrals.py`` with ``rule.py`` and ``phase.py``.
"""
