"""Curved surfaces: all separable coordinates of a natural system on a sphere, whatever coordinates it is given in.

In: a ``System`` of two coordinates whose T has constant positive curvature. Out: its webs, certified.
Read ``sphere.py`` first; ``embedding.py`` proves that the surface is a sphere and says where its points are.
"""
