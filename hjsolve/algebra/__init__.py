"""Exact arithmetic in the field a mechanical system lives in; below ``shell`` and ``separation``, above nothing but sympy."""
