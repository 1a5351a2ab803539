"""A function next to points at which it and its derivative are known, to third order.

With f(xᵢ) and B(xᵢ) = ∂f/∂x at points xᵢ = x − dᵢ, and weights Σ λᵢ = 1, Σ λᵢ dᵢ = 0, it is

    f(x) = Σ λᵢ (f(xᵢ) + ½ B(xᵢ) dᵢ) + O(d³),

since both terms of second order are ½ f″dᵢdᵢ, of opposite signs, and what is left of first order is −½ B(x) Σ λᵢ dᵢ. Of
all such weights those are taken that are small, and smallest far away: least squares.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.compiling import helper, inlined, kernel
from hjsolve.arithmetic.number_types import Integers, Reals

_FLAT = 1e-4  # square of the part of all distances below which a dimension needs no Σ λᵢ dᵢ = 0
_LARGEST = 8.0  # sum of the sizes of the weights


class PlacesOfWells(NamedTuple):
    """Which points count for a place: those in its well, or those in others.

    Attributes:
        there, here: lower and upper ends of the wells of points and places, shapes (2 coordinates, points) and
            (2 coordinates, n); infinite or NaN ones leave a coordinate out.
        turns: periods of the coordinates, 0 for none; shape (coordinates,), none where all points count.
        apart: whether those in other wells count.
    """

    there: Reals
    here: Reals
    turns: Reals
    apart: bool


@inlined
def _apart(wells: PlacesOfWells, j: int, i: int) -> bool:
    """Tell whether a point and a place lie in different wells."""
    size, found = wells.turns.shape[0], False
    for k in range(size):
        low, high, turn = wells.here[k, i], wells.here[size + k, i], wells.turns[k]
        # an angle is the same a turn further on
        moved = (
            turn * np.rint((wells.there[k, j] + wells.there[size + k, j] - low - high) / (2 * turn)) if turn else 0.0
        )
        found = found or wells.there[size + k, j] <= low + moved or high + moved <= wells.there[k, j]
    return found


@helper
def _next(points: Reals, place: float, left: int, right: int) -> int:
    """Return which of two points, on either side of a place, is nearer along the first axis; −1 for none."""
    if left < 0:
        return right if right < points.shape[1] else -1
    if right == points.shape[1]:
        return left
    return left if place - points[0, left] < points[0, right] - place else right


@kernel
def nearest_points(points: Reals, wanted: Reals, wells: PlacesOfWells, found: Integers, squares: Reals) -> None:
    """Find the nearest points of each place, from the nearest along the first axis outward.

    Args:
        points: shape (dimensions, points), ascending along the first axis.
        wanted: places, shape (dimensions, n).
        wells: which points count.
        found: filled with the positions of the nearest points, the nearest one first, shape (neighbours, n); −1 for
            none.
        squares: filled with the squares of their distances, the same shape.
    """
    last, dimensions = found.shape[0] - 1, points.shape[0]
    for i in range(wanted.shape[1]):
        low, high = 0, points.shape[1]
        while low < high:
            middle = (low + high) // 2
            if points[0, middle] < wanted[0, i]:
                low = middle + 1
            else:
                high = middle
        for k in range(last + 1):
            found[k, i], squares[k, i] = -1, np.inf
        left, right = low - 1, low
        while True:
            j = _next(points, wanted[0, i], left, right)
            # points are met in the order of their first distances: once that alone exceeds the last one kept, all do
            if j < 0 or (points[0, j] - wanted[0, i]) ** 2 >= squares[last, i]:
                break
            left, right = min(left, j - 1), max(right, j + 1)
            square = 0.0
            for k in range(dimensions):
                square += (points[k, j] - wanted[k, i]) * (points[k, j] - wanted[k, i])
            if square < squares[last, i] and (not wells.turns.shape[0] or _apart(wells, j, i) == wells.apart):
                at = last
                while at > 0 and square < squares[at - 1, i]:
                    found[at, i], squares[at, i] = found[at - 1, i], squares[at - 1, i]
                    at -= 1
                found[at, i], squares[at, i] = j, square


@helper
def solve(matrix: Reals, right: Reals) -> None:
    """Solve a small system of linear equations by elimination; the right side becomes the solution.

    Args:
        matrix: changed.
        right: replaced.
    """
    n = right.shape[0]
    for c in range(n):
        # the largest pivot: ∂θ/∂φ of coupled phases, which is solved here, too, is not symmetric
        pivot = c
        for r in range(c + 1, n):
            if abs(matrix[r, c]) > abs(matrix[pivot, c]):
                pivot = r
        if pivot != c:
            for k in range(c, n):
                matrix[c, k], matrix[pivot, k] = matrix[pivot, k], matrix[c, k]
            right[c], right[pivot] = right[pivot], right[c]
        for r in range(c + 1, n):
            factor = matrix[r, c] / matrix[c, c]
            for k in range(c, n):
                matrix[r, k] -= factor * matrix[c, k]
            right[r] -= factor * right[c]
    for back in range(n):
        c = n - 1 - back
        for k in range(c + 1, n):
            right[c] -= matrix[c, k] * right[k]
        right[c] /= matrix[c, c]


@helper
def _placed(points: Reals, wanted: Reals, j: int, i: int, size: float, row: Reals) -> float:
    """Leave 1 and the distance from a point, over a size, in ``row``, and return how much that point counts."""
    square, row[0] = 0.0, 1.0
    for d in range(points.shape[0]):
        row[1 + d] = (wanted[d, i] - points[d, j]) / size
        square += row[1 + d] * row[1 + d]
    # w = d⁻⁴: Σ (λᵢ dᵢ²)² is least, so that far points have small weights; 1e-12 stands for a point that is met
    return 1.0 / (square * square + 1e-12)


@helper
def _size(points: Reals, wanted: Reals, near: Integers, i: int) -> float:
    """Return the largest distance, along any dimension."""
    size = 1e-300
    for d in range(points.shape[0]):
        for k in range(near.shape[0]):
            size = max(size, abs(wanted[d, i] - points[d, near[k, i]]))
    return size


@helper
def _weights(points: Reals, wanted: Reals, near: Integers, i: int, matrix: Reals, work: Reals) -> float:
    """Leave the weights in the third row of ``work`` and Σ λᵢ dᵢ in the fourth; return the sum of their sizes."""
    dimensions, count = points.shape[0], near.shape[0]
    right, row, weights, left = work[0, : dimensions + 1], work[1], work[2], work[3]
    size = _size(points, wanted, near, i)
    for a in range(dimensions + 1):
        right[a] = 1.0 if a == 0 else 0.0
        for b in range(dimensions + 1):
            matrix[a, b] = 0.0
    # least Σ λᵢ²/wᵢ with Σ λᵢ = 1, Σ λᵢ dᵢ = 0: λᵢ = wᵢ (1, dᵢ)·μ and Σ wᵢ (1, dᵢ)(1, dᵢ)ᵀ μ = (1, 0) (Lagrange)
    for k in range(count):
        counts = _placed(points, wanted, near[k, i], i, size, row)
        for a in range(dimensions + 1):
            for b in range(dimensions + 1):
                matrix[a, b] += counts * row[a] * row[b]
    # where all points lie at the place in one dimension its row is rounding: it gives way to μ = 0 there
    for a in range(1, dimensions + 1):
        matrix[a, a] += _FLAT * matrix[0, 0]
    solve(matrix, right)
    total, sizes = 0.0, 0.0
    for d in range(dimensions):
        left[d] = 0.0
    for k in range(count):
        counts, λ = _placed(points, wanted, near[k, i], i, size, row), 0.0
        for a in range(dimensions + 1):
            λ += counts * row[a] * right[a]
        for d in range(dimensions):
            left[d] += λ * row[1 + d] * size
        weights[k], total, sizes = λ, total + λ, sizes + abs(λ)
    # Σ λᵢ is 1 but for rounding, which is divided out: a constant comes back as it is
    for k in range(count):
        weights[k] /= total
    for d in range(dimensions):
        left[d] /= total
    return sizes / abs(total)


@kernel
def extrapolated(points: Reals, values: Reals, slopes: Reals, wanted: Reals, near: Integers, made: Reals,
                 matrix: Reals, work: Reals) -> None:  # fmt: skip
    """Work out a function at some places.

    Args:
        points: where it is known, shape (dimensions, points).
        values, slopes: f and ∂f/∂x there, shape (parts, points) and (parts, dimensions, points).
        wanted: places, shape (dimensions, n).
        near: the points that are used, the nearest one first, shape (neighbours, n).
        made: filled with f, shape (parts, n); with NaN where weights are not small.
        matrix, work: scratch, shape (1 + dimensions, 1 + dimensions), (4, at least that, and neighbours).
    """
    for i in range(wanted.shape[1]):
        sizes = _weights(points, wanted, near, i, matrix, work)
        for p in range(made.shape[0]):
            total = 0.0 if sizes <= _LARGEST else np.nan
            for k in range(near.shape[0]):
                j = near[k, i]
                part = values[p, j]
                for d in range(points.shape[0]):
                    # what is left of Σ λᵢ dᵢ counts with the mean of B
                    part += 0.5 * slopes[p, d, j] * (wanted[d, i] - points[d, j] + work[3, d])
                total += work[2, k] * part
            made[p, i] = total
