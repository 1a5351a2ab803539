"""Families of motions in two coordinates: wavefronts, the orbits that cross them, and caustics.

In: a motion. Out: ``Wavefronts``: lines W = const of Hamilton's characteristic function, orbits orthogonal to them in
the kinetic metric, and the curves where the orbits of the family pile up. Read ``families.py`` first;
``same_constants.py`` makes the family of one complete integral, ``same_place.py`` that of one place.
"""
