"""A method at one accuracy, ready to be run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from hjsolve.costs.answers import Answer
from hjsolve.scenes import Scene
from hjsolve.scenes.question import Times
from hjsolve.scenes.run import sampled
from hjsolve.solution.quadratures import Solution


@dataclass(frozen=True, eq=False)
class Task:
    """What all methods are asked.

    Attributes:
        scene: its quantities and times.
        solution: of its system, made once; None for a scene that is integrated.
        places: which of the scene's times are compared.
    """

    scene: Scene
    solution: Solution | None
    places: tuple[int, ...]

    @property
    def states(self) -> bool:
        """Whether states at times are wanted."""
        return "trajectory" in self.scene.want and self.scene.times is not None

    @cached_property
    def every(self) -> tuple[sp.Expr, ...]:
        """All times, exact: the doubles that evenly spaced times are rounded to, so that all methods have the same."""
        times = self.scene.times
        if times is None or not self.states:
            return ()
        return times.listed or tuple(sp.Rational(float(t)) for t in sampled(times, 15))

    @property
    def moments(self) -> tuple[sp.Expr, ...]:
        """The times that are compared."""
        return tuple(self.every[place] for place in self.places)

    def some(self, places: Sequence[int]) -> Times:
        """Return a few of the times.

        Args:
            places: numbers of the times, among all.
        """
        return Times(listed=tuple(self.every[place] for place in places))


@dataclass(frozen=True, eq=False)
class Trial:
    """One method at one accuracy.

    Attributes:
        method, digits, unit: as in ``Row``.
        compute: (times or None for the scene's own, deadline) ↦ whatever ``read`` understands; this is what is timed.
        read: (result, places of the times compared) ↦ the answer.
        prepare: done once before, not timed: compilation.
        thin: whether the time for all times can be told from a few of them.
        own: whether it is one of hjsolve's methods.
        covers, note: as in ``Row``.
    """

    method: str
    digits: float
    compute: Callable[[Times | None, float], Any]
    read: Callable[[Any, Sequence[int]], Answer]
    unit: str = "evaluations"
    prepare: Callable[[], object] = lambda: None
    thin: bool = False
    own: bool = False
    covers: str = "all"
    note: str = ""
