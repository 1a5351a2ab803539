"""Algebra: exact arithmetic in the field of functions that a mechanical system lives in; nothing below it but sympy.

In: sympy expressions and the ranges of their symbols. Out: elements of a ``Field``, their derivatives, signs, zeros.
Read ``field.py`` first (elements with factored denominators), then ``reader.py`` (sympy in, sympy out).
"""
