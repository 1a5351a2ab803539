"""The real roots of many polynomials at once, in doubles: by formulas to the fourth degree, then Newton's rule.

A formula finds roots to about the rounding of the largest of them divided by how far apart they are; two steps of
Newton's rule on the polynomial itself give the small ones their digits. Where roots nearly meet, or the steps did not
settle, the answer says so and the caller takes more digits.

Press et al., Numerical Recipes (3rd ed. 2007), eqs. 5.6.10 to 5.6.17 (cubics: cosines, or one cube root); Ferrari's
factors of a quartic, real ones by the largest root of the resolvent: Abramowitz and Stegun (1964), section 3.8.3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Booleans = NDArray[np.bool_]
_MEETING = 1e-3
"""Roots nearer than this part of the largest are found with more digits by the caller."""
_REAL = 1e-8
"""An imaginary part below this part of the largest root is rounding."""
_SETTLED = 1e-9
"""The second step of Newton's rule, by the root: what it leaves is of the order of its square."""


def real_roots(coefficients: Sequence[Doubles]) -> tuple[Doubles, Booleans]:
    """Return the real roots, ascending, inf after the last.

    And where neither their number nor their digits are certain.

    Args:
        coefficients: of the highest power first, arrays of one shape.

    Returns:
        Roots of shape (degree, *shape), right to a few roundings times their condition where they are certain; and
        where they are not.
    """
    with np.errstate(all="ignore"):
        return _real_roots([np.asarray(c, dtype=float) for c in coefficients])


def _real_roots(given: list[Doubles]) -> tuple[Doubles, Booleans]:
    unit = size_of_roots(given)
    degree = len(given) - 1
    monic = [c / given[0] * unit**-k for k, c in enumerate(given)][1:]
    unsure = ~np.isfinite(sum(abs(c) for c in monic))
    monic = [np.where(unsure, float(k == degree - 1), c) for k, c in enumerate(monic)]
    real, imaginary = _FORMULAS.get(degree, _eigenvalues)(monic)
    size = np.sqrt((real**2 + imaginary**2).max(axis=0))
    for one in range(degree):
        for other in range(one):
            apart = abs(real[one] - real[other]) + abs(imaginary[one] - imaginary[other])
            unsure = unsure | ~(apart > _MEETING * size)
    found = np.sort(np.where(abs(imaginary) <= _REAL * size, real, np.inf), axis=0)
    there = np.isfinite(found)
    roots = np.where(there, found, 0.0)
    step = np.zeros_like(roots)
    for _ in range(2):
        value, slope = roots + monic[0], np.ones_like(roots)
        for c in monic[1:]:
            slope = slope * roots + value
            value = value * roots + c
        step = np.where(slope == 0, 0.0, value / slope)
        roots = roots - step
    unsure = unsure | (there & ~(abs(step) <= _SETTLED * size)).any(axis=0)
    return np.where(there, roots * unit, np.inf), unsure


def size_of_roots(coefficients: Sequence[Doubles]) -> Doubles:
    """Return the geometric mean λ of the sizes of the roots: x/λ is about 1; 1 where a root is 0.

    Args:
        coefficients: of the highest power first, arrays of one shape.
    """
    ratio = abs(coefficients[-1] / np.where(coefficients[0] == 0, 1.0, coefficients[0]))
    return np.where((ratio > 0) & np.isfinite(ratio), ratio, 1.0) ** (1 / (len(coefficients) - 1))


def _linear(monic: Sequence[Doubles]) -> tuple[Doubles, Doubles]:
    (b,) = monic
    return -b[None], np.zeros_like(b)[None]


def _quadratic(monic: Sequence[Doubles]) -> tuple[Doubles, Doubles]:
    b, c = monic
    inside = b**2 / 4 - c
    width = np.sqrt(abs(inside))
    far = -b / 2 - np.copysign(np.where(inside >= 0, width, 0.0), b)
    near = np.where(inside >= 0, np.where(far == 0, 0.0, c / np.where(far == 0, 1.0, far)), far)
    imaginary = np.where(inside >= 0, 0.0, width)
    return np.stack([far, near]), np.stack([imaginary, -imaginary])


def _cubic(monic: Sequence[Doubles]) -> tuple[Doubles, Doubles]:
    a, b, c = monic
    Q, R = (a**2 - 3 * b) / 9, (2 * a**3 - 9 * a * b + 27 * c) / 54
    three = R**2 < Q**3
    spread = np.sqrt(np.where(three, Q, 1.0))
    angle = np.arccos(np.clip(np.where(three, R, 0.0) / spread**3, -1, 1)) / 3
    A = -np.copysign(np.cbrt(abs(R) + np.sqrt(np.where(three, 0.0, R**2 - Q**3))), R)
    B = np.where(A == 0, 0.0, Q / np.where(A == 0, 1.0, A))
    turns = [angle, angle + 2 * np.pi / 3, angle - 2 * np.pi / 3]
    alone = [A + B, -(A + B) / 2, -(A + B) / 2]
    aside = np.where(three, 0.0, np.sqrt(3) / 2 * (A - B))
    real = [np.where(three, -2 * spread * np.cos(t), r) - a / 3 for t, r in zip(turns, alone, strict=True)]
    return np.stack(real), np.stack([np.zeros_like(aside), aside, -aside])


def _quartic(monic: Sequence[Doubles]) -> tuple[Doubles, Doubles]:
    a, b, c, d = monic
    p = b - 3 * a**2 / 8
    q = c - a * b / 2 + a**3 / 8
    r = d - a * c / 4 + a**2 * b / 16 - 3 * a**4 / 256
    real, imaginary = _cubic([2 * p, p**2 - 4 * r, -(q**2)])
    z = np.maximum(np.where(imaginary == 0, real, -np.inf).max(axis=0), 0.0)
    s, w = np.sqrt(z), np.copysign(np.sqrt(np.maximum((p + z) ** 2 - 4 * r, 0.0)), q)
    first, second = _quadratic([s, (p + z - w) / 2]), _quadratic([-s, (p + z + w) / 2])
    return np.concatenate([first[0], second[0]]) - a / 4, np.concatenate([first[1], second[1]])


def _eigenvalues(monic: Sequence[Doubles]) -> tuple[Doubles, Doubles]:
    degree = len(monic)
    companion = np.zeros((*monic[0].shape, degree, degree))
    companion[..., range(1, degree), range(degree - 1)] = 1.0
    for k, c in enumerate(monic):
        companion[..., 0, k] = -c
    roots = np.moveaxis(np.linalg.eigvals(companion).astype(complex), -1, 0)
    return roots.real.copy(), roots.imag.copy()


_FORMULAS = {1: _linear, 2: _quadratic, 3: _cubic, 4: _quartic}
