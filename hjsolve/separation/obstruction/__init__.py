"""Obstructions: why a system does not separate, with a point that proves it, and what to try instead.

In: a shell that failed a form. Out: an ``Obstruction``: the pair, the part that does not vanish, how far from
separable, which blocks do separate, at which energy, and advice in words.
Read ``obstruction.py`` first, then ``diagnose.py``.
"""
