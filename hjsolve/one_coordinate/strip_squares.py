"""Squares of a strip along the real axis of a phase, and where they lie to each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Mask, Reals


class StripSquares(NamedTuple):
    """Squares of the strip [x, x + side] × i[y, y + side], arrays of one shape."""

    x: Reals
    y: Reals
    side: Reals

    @property
    def top(self) -> Reals:
        return self.y + self.side

    @staticmethod
    def none() -> StripSquares:
        return StripSquares(*(np.zeros(0) for _ in range(3)))

    def beside(self, others: StripSquares) -> StripSquares:
        """Return these squares and others.

        Args:
            others: put behind these.
        """
        return StripSquares(*(np.concatenate(pair) for pair in zip(self, others, strict=True)))

    def chosen(self, which: Mask | slice) -> StripSquares:
        """Return some of the squares.

        Args:
            which: True for those to be kept, or a range of them.
        """
        return StripSquares(*(part[which] for part in self))

    def divided(self) -> StripSquares:
        """Return the four quarters of every square."""
        half = self.side / 2
        return StripSquares(
            np.concatenate([self.x, self.x + half, self.x, self.x + half]),
            np.concatenate([self.y, self.y, self.y + half, self.y + half]),
            np.concatenate([half] * 4),
        )


def straight_above(squares: StripSquares) -> Mask:
    """Tell which squares have another one of them straight below.

    Args:
        squares: none of which overlap; their sides are powers of two of each other.
    """
    if not squares.x.size:
        return np.zeros(0, dtype=bool)
    unit = np.min(squares.side)
    left = np.rint((squares.x - np.min(squares.x)) / unit).astype(np.int64)
    # columns between the edges of all squares: one number, the lowest square, for each
    edges = np.unique(np.concatenate([left, left + np.rint(squares.side / unit).astype(np.int64)]))
    first = np.searchsorted(edges, left)
    last = np.searchsorted(edges, left + np.rint(squares.side / unit).astype(np.int64))
    spans = last - first  # of columns between neighbouring edges
    columns = np.repeat(first - np.cumsum(spans) + spans, spans) + np.arange(np.sum(spans))
    lowest = np.full(len(edges), np.inf)
    np.minimum.at(lowest, columns, np.repeat(squares.y, spans))
    return squares.y > np.minimum.reduceat(lowest, np.stack([first, last], axis=1).ravel())[::2]


def in_a_cone(squares: StripSquares, found: Reals) -> Mask:
    """Tell which squares lie in the cone over one of the obstacles found: y − yₖ > |x − xₖ|.

    Args:
        squares: to be told.
        found: xₖ and yₖ of the obstacles, shape (2, k).
    """
    if not found.shape[1]:
        return np.zeros(squares.x.shape, dtype=bool)
    x, y = found[:, np.argsort(found[0])]
    # y − yₖ > x − xₖ for xₖ left of x, and the mirror image: two running minima in place of all pairs
    rising = np.concatenate([[np.inf], np.minimum.accumulate(y - x)])
    falling = np.concatenate([np.minimum.accumulate((y + x)[::-1])[::-1], [np.inf]])
    middle = squares.x + squares.side / 2
    at = np.searchsorted(x, middle)
    return squares.y > np.minimum(rising[at] + middle, falling[at] - middle)
