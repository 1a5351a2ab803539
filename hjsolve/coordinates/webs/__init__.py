"""Webs: the orthogonal separable webs of the plane and of space that a family of Killing or concircular tensors holds.

In: linear families of tensors. Out: webs with their parameters, one for every stratum of the family.
Read ``plane.py`` first, then ``space.py`` (the algorithm of Benenti, Eisenhart, Kalnins and Miller).
"""
