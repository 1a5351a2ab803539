"""Constants of the motion: the separation constants as functions of q and p, under the names a physicist gives them.

In: a Stäckel matrix. Out: one ``Constant`` each: its formula, and what it means where it is a known integral.
Read ``constants.py`` first, then ``known_integrals.py``.
"""
