"""Carlson's R_C and R_J with a complex last argument a + ib, b ≠ 0, for arrays of doubles, in numpy alone.

Duplication (Carlson, Numer. Algorithms 10 (1995) 13, (2.17)–(2.26)): of x, y, z ≥ 0 and p off the negative axis every
root on the way is a principal one. What is outside the domain is nan.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import EPS

Doubles = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Numbers = float | Doubles

_MOST = 60


def carlson_rcre(x: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Re R_C(x, a + ib), x ≥ 0.

    Args:
        x, a, b: numbers or arrays that broadcast.
    """
    return _rc(x, a, b).real


def carlson_rcim(x: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Im R_C(x, a + ib), x ≥ 0.

    Args:
        x, a, b: numbers or arrays that broadcast.
    """
    return _rc(x, a, b).imag


def carlson_rjre(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Re R_J(x, y, z, a + ib), x, y, z ≥ 0, at most one of them zero.

    Args:
        x, y, z, a, b: numbers or arrays that broadcast.
    """
    return _rj(x, y, z, a, b).real


def carlson_rjim(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Doubles:
    """Im R_J(x, y, z, a + ib), x, y, z ≥ 0, at most one of them zero.

    Args:
        x, y, z, a, b: numbers or arrays that broadcast.
    """
    return _rj(x, y, z, a, b).imag


def _broadcast(*arguments: Numbers) -> list[Doubles]:
    return [np.array(a) for a in np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in arguments))]


def _arc(w: Complexes, root: Doubles | float) -> Complexes:
    """arctan(w/root)/w; 1/root where w = 0."""
    ratio = np.array(w / root, dtype=complex)
    ratio[ratio == 0] = 1e-300  # where arctan is its argument
    value: Complexes = np.arctan(ratio) / ratio / root
    return value


def _rc(x: Numbers, a: Numbers, b: Numbers) -> Complexes:
    x, a, b = _broadcast(x, a, b)
    with np.errstate(all="ignore"):
        w, root = np.sqrt(a - x + 1j * b), np.sqrt(x)
        value: Complexes = np.where(abs(w) < root, _arc(w, root), (np.pi / 2 - np.arctan(root / w)) / w)
        return value * np.where(x >= 0, 1.0, np.nan)


def _rj(x: Numbers, y: Numbers, z: Numbers, a: Numbers, b: Numbers) -> Complexes:
    x, y, z, a, b = _broadcast(x, y, z, a, b)
    with np.errstate(all="ignore"):
        good, p = (x >= 0) & (y >= 0) & (z >= 0), a + 1j * b
        A = (x + y + z + 2 * p) / 5
        bound = np.max([abs(A - x), abs(A - y), abs(A - z), abs(A - p)], axis=0) / (EPS / 4) ** (1 / 6)
        product, total, weight = (p - x) * (p - y) * (p - z), np.zeros_like(p), np.ones_like(a)
        for _ in range(_MOST):
            open_ = bound > abs(A)
            if not open_.any():
                break
            sx, sy, sz, sp = np.sqrt(x), np.sqrt(y), np.sqrt(z), np.sqrt(p)
            λ = np.where(open_, sx * sy + sx * sz + sy * sz, 0.0)
            quarter = np.where(open_, 0.25, 1.0)
            d = (sp + sx) * (sp + sy) * (sp + sz)
            total += np.where(open_, weight / d * _arc(np.sqrt(product / (d * d)), 1.0), 0.0)
            weight, product, bound = weight * quarter, product * quarter**3, bound * quarter
            x, y, z = (x + λ) * quarter, (y + λ) * quarter, (z + λ) * quarter
            p, A = (p + λ) * quarter, (A + λ) * quarter
        X, Y, Z = (A - x) / A, (A - y) / A, (A - z) / A
        value = weight * _series(X, Y, Z, -(X + Y + Z) / 2) / (A * np.sqrt(A)) + 6 * total
        return value * np.where(good, 1.0, np.nan)


def _series(X: Complexes, Y: Complexes, Z: Complexes, P: Complexes) -> Complexes:
    """Carlson 1995, (2.26)."""
    E2 = X * Y + X * Z + Y * Z - 3 * P * P
    E3 = X * Y * Z + 2 * E2 * P + 4 * P**3
    E4 = (2 * X * Y * Z + E2 * P + 3 * P**3) * P
    E5 = X * Y * Z * P * P
    return 1 - 3 * E2 / 14 + E3 / 6 + 9 * E2 * E2 / 88 - 3 * E4 / 22 - 9 * E2 * E3 / 52 + 3 * E5 / 26
