"""Mechanics: a system is checked once, T and V, and reduced to its energy shell.

In: coordinates with domains, T and V, parameters. Out: a frozen ``System``; its momenta, Hamiltonian and ``Shell``.
Read ``system.py`` first, then ``energy_shell.py``; the other files are its parts: what may be declared, the kinetic
energy as a quadratic form, the proof that it is positive definite, the elimination of ignorable coordinates.
"""
