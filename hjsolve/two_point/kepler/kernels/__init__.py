"""Lambert's problem as loops over numbers, compiled where numba is installed, else run as they stand.

In: λ, the time and the turns. Out: the x of all conics with errors.
Read ``lambert.py`` first.
"""
