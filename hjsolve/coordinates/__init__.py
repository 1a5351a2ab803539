"""Coordinates: in which coordinates would it separate? In the plane, in space, on a sphere, by normal modes.

In: a ``System`` in Cartesian coordinates, or on a sphere. Out: every orthogonal separable web, certified; normal modes
of small motion. Read ``find.py`` first, then ``killing`` (which webs), ``webs`` (their parameters), ``charts`` (their
coordinates); ``curved`` has the sphere.
"""
