"""Counting what was evaluated: p², its kernels, and places along a course, inside a ``with`` block.

    with counted() as work:
        motion = solution.motion(…, want={"periods"})
    work.kernels, work.places

Nothing is counted outside such a block, and a block sees only its own thread of execution.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass


@dataclass
class WorkCount:
    """Evaluations since the block began.

    Attributes:
        squares: of p², to find turning points and under the integrals.
        kernels: of the integrand's numerators ½ ∂p²/∂c, all constants together.
        places: phases turned into positions along the motion, the mark of a trajectory.
    """

    squares: int = 0
    kernels: int = 0
    places: int = 0


_OPEN: ContextVar[WorkCount | None] = ContextVar("hjsolve_work", default=None)


@contextmanager
def counted() -> Iterator[WorkCount]:
    """Count all evaluations of the block; blocks inside add to those around them."""
    outer, work = _OPEN.get(), WorkCount()
    token = _OPEN.set(work)
    try:
        yield work
    finally:
        _OPEN.reset(token)
        if outer is not None:
            outer.squares += work.squares
            outer.kernels += work.kernels
            outer.places += work.places


def count(*, squares: int = 0, kernels: int = 0, places: int = 0) -> None:
    """Add to the block that is open, if one is.

    Args:
        squares: evaluations of p².
        kernels: evaluations of its kernels.
        places: evaluations of positions.
    """
    work = _OPEN.get()
    if work is not None:
        work.squares += squares
        work.kernels += kernels
        work.places += places
