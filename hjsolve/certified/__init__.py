"""Certified integrals: the integrals of one coordinate in balls, with a proof of every digit; no sympy here.

In: p² of a coordinate as a tape, its parameters as balls. Out: proved turning points and proved enclosures of actions
and mean frequencies (extra ``certified``).
Read ``integrands.py`` first, then ``strip_bound.py``: the midpoint rule with its error bounded on a strip of
analyticity.
"""
