"""Two places about a centre of force: all motions that join them, proved by enclosures over boxes of E and L.

In: a question about a mass in a potential V(r), in the plane or in space. Out: connections with a proof that they are
all, or the boxes that are not decided. Read ``radial_arcs.py`` first.
"""
