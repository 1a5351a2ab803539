"""Matrices of numbers in many digits, each with a bound on its error in doubles.

Products carry the errors of their factors to first order, abs(δ(AB)) ≤ abs(δA) abs(B) + abs(A) abs(δB), and a solution
x of G x = r those of its equations, abs(δx) ≤ abs(G⁻¹) (abs(δr) + abs(δG) abs(x)) (Higham, Accuracy and Stability of
Numerical Algorithms, 2002, §7.1). What is of second order is covered by the factor ``SECOND_ORDER`` of a result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Context, Reals
from hjsolve.errors import NotConvergedError


@dataclass(frozen=True, eq=False)
class Bounded:
    """An array of ``mpf`` with absolute errors.

    Attributes:
        value: objects, of any shape.
        error: doubles, of the same shape.
    """

    value: NDArray[Any]
    error: Reals

    @classmethod
    def exact(cls, value: NDArray[Any]) -> Bounded:
        """Return numbers without an error.

        Args:
            value: of any shape.
        """
        return cls(value, np.zeros(value.shape))

    @property
    def size(self) -> Reals:
        """The absolute values, in doubles."""
        return np.asarray(np.abs(self.value), dtype=object).astype(float)

    @property
    def transposed(self) -> Bounded:
        """The last two axes changed."""
        return Bounded(np.swapaxes(self.value, -1, -2), np.swapaxes(self.error, -1, -2))

    def __getitem__(self, key: Any) -> Bounded:
        value, error = self.value[key], self.error[key]
        if isinstance(value, np.ndarray):
            return Bounded(value, error)
        return Bounded(np.array(value, dtype=object), np.array(error))

    def __neg__(self) -> Bounded:
        return Bounded(-self.value, self.error)

    def __add__(self, other: Bounded) -> Bounded:
        return Bounded(self.value + other.value, self.error + other.error)

    def __sub__(self, other: Bounded) -> Bounded:
        return self + -other

    def __mul__(self, other: Bounded) -> Bounded:
        """Return products of elements."""
        # δ(xy) = δx |y| + |x| δy: bounds are of first order
        return Bounded(self.value * other.value, self.error * other.size + self.size * other.error)

    def __matmul__(self, other: Bounded) -> Bounded:
        return Bounded(self.value @ other.value, self.error @ other.size + self.size @ other.error)


def zeros(shape: tuple[int, ...], context: Context) -> Bounded:
    """Return zeros.

    Args:
        shape: of the array.
    """
    return Bounded.exact(np.full(shape, context.mpf(0), dtype=object))


def stacked(rows: list[Bounded], axis: int = 0) -> Bounded:
    """Return arrays of one shape as one array with a new axis.

    Args:
        rows: of equal shape.
        axis: the new one.
    """
    return Bounded(np.stack([r.value for r in rows], axis), np.stack([r.error for r in rows], axis))


def inverse(matrix: Bounded, context: Context) -> Bounded:
    """Return the inverse of one square matrix, δ(G⁻¹) = −G⁻¹ δG G⁻¹.

    Args:
        matrix: shape (n, n).

    Raises:
        NotConvergedError: it is singular.
    """
    # an empty matrix has itself as inverse: every coordinate is ignorable
    n = len(matrix.value)
    if not n:
        return matrix
    try:
        found = context.matrix(matrix.value.tolist()) ** -1
    except ZeroDivisionError:
        raise NotConvergedError("the separated integrals are dependent: these derivatives do not exist") from None
    value = np.array([[found[i, j] for j in range(n)] for i in range(n)], dtype=object)
    # |δ(G⁻¹)| ≤ |G⁻¹| |δG| |G⁻¹|, element by element, in doubles: a bound needs no more digits
    size = np.abs(value).astype(float)
    return Bounded(value, size @ matrix.error @ size)


def converted(values: object, context: Context) -> NDArray[np.object_]:
    """Return numbers in one precision.

    Args:
        values: numbers of any kind.
    """
    found: Any = np.frompyfunc(context.convert, 1, 1)(np.asarray(values, dtype=object))
    return found if isinstance(found, np.ndarray) else np.array(found, dtype=object)
