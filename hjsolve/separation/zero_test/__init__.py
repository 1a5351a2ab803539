"""The zero test: is an expression identically zero on the domain? Proved zero, proved not, or undecided.

In: an expression and the region it lives in. Out: ``Zero``, ``NonZero`` with a witness, or ``Unproved`` with its value.
Read ``zero_test.py`` first; the other files enclose expressions, jets and field elements at rational points.
"""
