"""Carlson's R_C and R_J with a complex last argument a + ib, b ≠ 0, for arrays of doubles, in numpy alone.

Duplication (Carlson, Numer. Algorithms 10 (1995) 13, (2.17)–(2.26)): of x, y, z ≥ 0 and p off the negative axis every
root on the way is a principal one. What is outside the domain is nan.

Arguments are numbers or arrays that broadcast.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.carlson import Doubles, Numbers, broadcast, duplicated, series
from hjsolve.arithmetic.floats import EPS

Complexes = NDArray[np.complex128]


def carlson_rcre(x: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Re R_C(x, a + ib), x ≥ 0."""
    return _rc(x, a, b).real


def carlson_rcim(x: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Im R_C(x, a + ib), x ≥ 0."""
    return _rc(x, a, b).imag


def carlson_rjre(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Re R_J(x, y, z, a + ib), x, y, z ≥ 0, at most one of them zero."""
    return _rj(x, y, z, a, b).real


def carlson_rjim(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Im R_J(x, y, z, a + ib), x, y, z ≥ 0, at most one of them zero."""
    return _rj(x, y, z, a, b).imag


def _arc(w: Complexes, root: Doubles | float) -> Complexes:
    """arctan(w/root)/w; 1/root where w = 0."""
    ratio = np.array(w / root, dtype=complex)
    ratio[ratio == 0] = 1e-300  # where arctan is its argument
    value: Complexes = np.arctan(ratio) / ratio / root
    return value


def _rc(x: Numbers, a: Numbers, b: Numbers) -> Complexes:
    x, a, b = broadcast(x, a, b)
    with np.errstate(all="ignore"):
        w, root = np.sqrt(a - x + 1j * b), np.sqrt(x)
        value: Complexes = np.where(abs(w) < root, _arc(w, root), (np.pi / 2 - np.arctan(root / w)) / w)
        return value * np.where(x >= 0, 1.0, np.nan)


def _rj(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Complexes:
    x, y, z, a, b = broadcast(x, y, z, a, b)
    with np.errstate(all="ignore"):
        good, p = (x >= 0) & (y >= 0) & (z >= 0), a + 1j * b
        product = (p - x) * (p - y) * (p - z)

        def term(_: Sequence[Complexes], roots: Sequence[Complexes], _λ: Doubles, weight: Doubles) -> Complexes:
            sx, sy, sz, sp = roots
            d = (sp + sx) * (sp + sy) * (sp + sz)
            return weight / d * _arc(np.sqrt(product * weight**3 / (d * d)), 1.0)

        (x, y, z, p), A, weight, total = duplicated((x + y + z + 2 * p) / 5, (x, y, z, p), EPS / 4, term)
        X, Y, Z = (A - x) / A, (A - y) / A, (A - z) / A
        value = weight * series(X, Y, Z, -(X + Y + Z) / 2) / (A * np.sqrt(A)) + 6 * total
        return value * np.where(good, 1.0, np.nan)
