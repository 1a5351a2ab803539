"""Real roots of many polynomials on (0, 1), counted and kept apart: Descartes' rule in Bernstein form, in doubles.

The number of sign changes of the Bernstein coefficients of a polynomial on an interval is the number of its roots there
or more by an even number (Lane and Riesenfeld, BIT 21 (1981) 112); none and one are exact, and anything else is halved.
Halving is by convex combinations (de Casteljau), so that a bound on the error of the coefficients stays one: where a
sign is not proved by it, the polynomial is called doubtful and nothing is said of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import EPS

Reals = NDArray[np.float64]
_DEEPEST = 60
_FRACTIONS = (0.5, 0.4609375, 0.5703125, 0.390625)
"""Where an interval is divided: at its middle, or next to it where the polynomial may vanish there."""


@dataclass(frozen=True)
class IsolatedRoots:
    """The roots of m polynomials on (0, 1), all simple.

    Attributes:
        sign: of each polynomial right of 0, shape (m,).
        count: of its roots, shape (m,).
        doubtful: True where neither is known, shape (m,).
        owner: which polynomial each root belongs to, in order, shape (k,).
        low, high: an interval round each root that holds no other, in order of place for each polynomial.
    """

    sign: NDArray[np.int64]
    count: NDArray[np.int64]
    doubtful: NDArray[np.bool_]
    owner: NDArray[np.int64]
    low: Reals
    high: Reals


def isolated_roots(coefficients: Reals, errors: Reals) -> IsolatedRoots:
    """Isolate the roots of many polynomials on (0, 1).

    Args:
        coefficients: Bernstein coefficients of degree n, shape (m, n + 1).
        errors: bounds on their errors, of the same shape.
    """
    m = len(coefficients)
    b, e, owner = coefficients, errors, np.arange(m)
    low, high = np.zeros(m), np.ones(m)
    first = _signs(b[:, 0], e[:, 0])
    doubtful = (first == 0) | (_signs(b[:, -1], e[:, -1]) == 0)
    found: list[tuple[NDArray[np.int64], Reals, Reals]] = []
    for _ in range(_DEEPEST):
        changes, proved = _variations(b, e)
        one = proved & (changes == 1)
        found.append((owner[one], low[one], high[one]))
        left = ~(proved & (changes <= 1)) & ~doubtful[owner]
        if not left.any():
            break
        b, e, owner, low, high = b[left], e[left], owner[left], low[left], high[left]
        b, e, owner, low, high, lost = _halves(b, e, owner, low, high)
        doubtful[lost] = True
    else:
        doubtful[owner] = True
    which, begin, end = (np.concatenate(parts) for parts in zip(*found, strict=True))
    kept = ~doubtful[which]
    which, begin, end = which[kept], begin[kept], end[kept]
    order = np.lexsort((begin, which))
    return IsolatedRoots(
        first, np.bincount(which, minlength=m), doubtful, which[order], begin[order], end[order]
    )  # fmt: skip


def bernstein_value(coefficients: Reals, errors: Reals, place: Reals) -> tuple[Reals, Reals]:
    """Evaluate polynomials in Bernstein form.

    Args:
        coefficients, errors: as for ``isolated_roots``.
        place: one of (0, 1) for each, shape (m,).

    Returns:
        The values and bounds on their errors, shape (m,).
    """
    return at_place(coefficients, place), at_place(_widened(coefficients, errors), place)


def at_place(coefficients: Reals, place: Reals) -> Reals:
    """Evaluate polynomials in Bernstein form by de Casteljau's scheme, without bounds on the errors.

    Args:
        coefficients: Bernstein coefficients of degree n, shape (m, n + 1).
        place: one of (0, 1) for each, shape (m,).
    """
    row, s = coefficients, place[:, None]
    while row.shape[1] > 1:
        row = (1 - s) * row[:, :-1] + s * row[:, 1:]
    return row[:, 0]


def _signs(b: Reals, e: Reals) -> NDArray[np.int64]:
    return np.where(b > e, 1, np.where(b < -e, -1, 0))


def _variations(b: Reals, e: Reals) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the sign changes along each row, and whether that is their number whatever the signs not proved are."""
    signs = _signs(b, e)
    forward, backward = signs.copy(), signs.copy()
    for k in range(1, signs.shape[1]):
        forward[:, k] = np.where(forward[:, k] == 0, forward[:, k - 1], forward[:, k])
        backward[:, -1 - k] = np.where(backward[:, -1 - k] == 0, backward[:, -k], backward[:, -1 - k])
    open_ = ((signs == 0) & (forward == backward)) | (forward == 0) | (backward == 0)
    return (np.diff(forward, axis=1) != 0).sum(axis=1), ~open_.any(axis=1)


def _divided(b: Reals, e: Reals, fraction: Reals) -> tuple[tuple[Reals, Reals], tuple[Reals, Reals]]:
    """Both parts of each polynomial, and of the bounds on their errors."""
    return _parts(b, fraction), _parts(_widened(b, e), fraction)


def _widened(b: Reals, e: Reals) -> Reals:
    """Return the bounds on the errors with what de Casteljau's scheme rounds."""
    return e + 4 * b.shape[1] * EPS * np.abs(b).max(axis=1, keepdims=True)


def _parts(b: Reals, fraction: Reals) -> tuple[Reals, Reals]:
    left, right, row, s = [b[:, 0]], [b[:, -1]], b, fraction[:, None]
    while row.shape[1] > 1:
        row = (1 - s) * row[:, :-1] + s * row[:, 1:]
        left.append(row[:, 0])
        right.append(row[:, -1])
    return np.stack(left, axis=1), np.stack(right[::-1], axis=1)


def _halves(
    b: Reals, e: Reals, owner: NDArray[np.int64], low: Reals, high: Reals
) -> tuple[Reals, Reals, NDArray[np.int64], Reals, Reals, NDArray[np.int64]]:
    """Divide every interval where the polynomial is proved not to vanish; the owners of those with no such place."""
    fraction = np.full(len(b), _FRACTIONS[0])
    for other in (*_FRACTIONS[1:], None):
        value, uncertainty = bernstein_value(b, e, fraction)
        unresolved = ~(np.abs(value) > uncertainty)
        if other is None or not unresolved.any():
            break
        fraction = np.where(unresolved, other, fraction)
    lost, kept = owner[unresolved], ~unresolved
    b, e, owner, low, high, fraction = b[kept], e[kept], owner[kept], low[kept], high[kept], fraction[kept]
    (b0, b1), (e0, e1) = _divided(b, e, fraction)
    middle = low + fraction * (high - low)
    return (
        np.concatenate([b0, b1]), np.concatenate([e0, e1]), np.concatenate([owner, owner]),
        np.concatenate([low, middle]), np.concatenate([middle, high]), lost,
    )  # fmt: skip
