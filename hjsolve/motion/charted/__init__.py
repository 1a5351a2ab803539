"""Charted motions: started and expressed in the user's coordinates, computed in those in which the system separates.

In: a ``Solution`` with a ``Chart``, initial data in the user's coordinates. Out: a ``Motion`` whose states are the
user's. Read ``begin.py`` first, then ``initial_map.py`` (x, p to u, p_u) and ``state_map.py`` (back).
"""
