"""Exact arithmetic in the field a mechanical system lives in.

Below ``shell`` and ``separation``, above nothing but sympy.
"""
