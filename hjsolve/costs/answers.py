"""The results in an answer, by name, and how far they are from other ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.scenes.run import Run

Value: TypeAlias = float | Mpf
"""A number of a method: a double, or one of many digits."""
Numbers = Mapping[str, tuple[tuple[Value, Value | None], ...]]
"""Name → (value, error claimed or None), one pair for each time compared; a single pair for a number of the motion."""
_SCALARS = ("constants", "turning_points", "actions", "frequencies", "periods", "boundary_times")


@dataclass(frozen=True)
class Answer:
    """What one run of a method gave.

    Attributes:
        numbers: by name: ``periods.r``, ``turning_points.r.0``, ``q.r``, ``p.r``; ``@k`` from the second arc on.
        count: evaluations.
        sizes: of the states' coordinates and momenta over all times, by name.
    """

    numbers: Numbers
    count: int
    sizes: Mapping[str, float]


def scalars(run: Run) -> Numbers:
    """Collect the results of every arc that are not states."""
    found: dict[str, tuple[tuple[Value, Value | None], ...]] = {}
    for place, arc in enumerate(run.arcs):
        suffix = f"@{place}" if place else ""
        for quantity in _SCALARS:
            for name, value in arc.quantities.get(quantity, {}).items():
                pair = value if isinstance(value, tuple) else None
                for k, estimate in enumerate(pair if pair is not None else (value,)):
                    if isinstance(estimate, Estimate):
                        key = f"{quantity}.{name}{'' if pair is None else f'.{k}'}{suffix}"
                        found[key] = ((estimate.value, estimate.error),)
    return found


@dataclass(frozen=True)
class Comparison:
    """The worst of all numbers, relative to sizes; ``held``: each error within its claim, None if none is claimed."""

    claimed: float | None
    error: float | None
    held: bool | None


@dataclass(frozen=True)
class Ruler:
    """Measures answers against a reference.

    Attributes:
        truth: name → values, mpf.
        digits: of the reference.
        sizes: what errors of states are relative to, by name.
        turning: names whose values are angles, compared modulo 2π.
    """

    truth: Mapping[str, tuple[Value, ...]]
    digits: int
    sizes: Mapping[str, float]
    turning: frozenset[str]

    def measure(self, numbers: Numbers) -> Comparison:
        """Compare.

        Returns:
            The worst; all None where nothing can be compared.
        """
        context = multiprecision(bits_for(self.digits, 64))
        claimed, error, held = list[float](), list[float](), list[bool]()
        for name, pairs in numbers.items():
            if name not in self.truth:
                continue
            for (value, claim), truth in zip(pairs, self.truth[name]):
                difference = abs(context.convert(value) - context.convert(truth))
                if name in self.turning:
                    turn = 2 * context.pi
                    difference = abs(difference - turn * context.nint(difference / turn))
                size = context.mpf(self.sizes.get(name) or 0) or abs(context.convert(truth)) or context.mpf(1)
                error.append(_float(difference / size))
                if claim is not None:
                    resolution = size * context.mpf(10) ** (5 - self.digits)
                    claimed.append(_float(context.convert(claim) / size))
                    held.append(bool(difference <= context.convert(claim) + resolution))
        return Comparison(max(claimed, default=None), max(error, default=None), all(held) if held else None)


def _float(value: Value) -> float:
    """Return a double; what is not a number counts as infinite."""
    result = float(value)
    return result if result == result else float("inf")
