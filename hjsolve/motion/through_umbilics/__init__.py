"""Through umbilics: two coordinates that tend together, in a finite time, to a place where only the coordinates branch.

In: a motion of two separated coordinates both of which tend to double zeros of p², or start at such a place, and a
metric that is regular there. Out: the same motion, arc after arc, expressed in the given coordinates.
Read ``branch_places.py`` first, then ``paths.py``, ``arcs.py`` and ``umbilic_motion.py``.
"""
