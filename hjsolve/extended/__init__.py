"""Extended: systems that are no T + V in the coordinates given, each by the change that makes them one.

In: a frame that moves, a Hamiltonian linear in p, a linear gyroscopic system. Out: their solutions and motions,
expressed in the original variables with the same ``State``.
Read ``change_of_frame.py`` first; ``linear_hamiltonian.py`` and ``gyroscopic.py`` stand on their own.
"""
