"""A semiclassical level, and all of them up to an energy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.by_value import ByValue
from hjsolve.display.renderers import renderer
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.solution.quadratures import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, repr=False)
class Level(Shown):
    """One level: a torus whose actions are J = (n + μ/4) ħ.

    Attributes:
        energy: E, its error that of the torus; the error does not include its distance from the exact level.
        numbers: coordinate → quantum number; signed for rotations and for ignorable angles.
        kinds: coordinate → libration, rotation or ignorable.
        maslov: coordinate → Maslov index μ.
        actions: coordinate → J.
        wells: coordinate that librates → the interval in which it does, in doubles.
        near_separatrix: coordinates along which no torus of this family has J + ħ or J − ħ: a separatrix or the energy
            of escape is within ħ, and the level is only approximate.
    """

    energy: Estimate
    numbers: Mapping[str, int]
    kinds: Mapping[str, str]
    maslov: Mapping[str, int]
    actions: Mapping[str, Estimate]
    wells: Mapping[str, tuple[float, float]]
    near_separatrix: tuple[str, ...]

    def _label(self) -> str:
        return ", ".join(f"{name} {n}" for name, n in self.numbers.items())


@dataclass(frozen=True, repr=False, eq=False)
class Levels(ByValue, Shown):
    """The levels of a system up to an energy, lowest first; made by ``levels``.

    Attributes:
        found: every level.
        solution: of the system.
        hbar: ħ.
        up_to: the greatest energy; None where quantum numbers alone were given.
        skipped: what has no levels here, and why.
    """

    found: tuple[Level, ...]
    solution: Solution = field(repr=False)
    hbar: sp.Expr
    up_to: sp.Expr | None
    skipped: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.found)

    def __iter__(self) -> Iterator[Level]:
        """Return the levels, lowest first."""
        return iter(self.found)

    def __getitem__(self, key: int) -> Level:
        """One level, counted from the lowest.

        Args:
            key: its place.

        Raises:
            InvalidInputError: a key that is not a place.
        """
        if not isinstance(key, int):
            raise InvalidInputError("levels[…]: a whole number is needed; levels.of(n=…) picks by quantum numbers")
        return self.found[key]

    def of(self, **numbers: int) -> tuple[Level, ...]:
        """Return the levels with given quantum numbers, lowest first.

        Args:
            numbers: coordinate → quantum number; those left out are free.

        Raises:
            InvalidInputError: a coordinate that has none.
        """
        known = [c.name for c in self.solution.system.coordinates]
        for name in numbers:
            if name not in known:
                raise InvalidInputError(f"of: {name!r} has no quantum number; known are {', '.join(known)}")
        return tuple(level for level in self.found if all(level.numbers.get(k) == n for k, n in numbers.items()))

    def table(self) -> str:
        """Return the levels as text: energy, quantum numbers, Maslov indices, a mark next to a separatrix."""
        names = [c.name for c in self.solution.system.coordinates]
        rows = [["E", *names, "mu", ""]]
        for level in self.found:
            near = f"near a separatrix ({', '.join(level.near_separatrix)})" if level.near_separatrix else ""
            numbers = [_number(level, name) for name in names]
            indices = ",".join(str(level.maslov[name]) for name in names)
            rows.append([f"{float(level.energy.value):.10g}", *numbers, indices, near])
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = ["  ".join(cell.rjust(width) for cell, width in zip(row[:-1], widths, strict=False)) for row in rows]
        return "\n".join(f"{line}  {row[-1]}".rstrip() for line, row in zip(lines, rows, strict=True))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the levels as a ladder, one column for each set of kinds, with matplotlib (extra ``report``).

        Args:
            ax: axes to draw on; None for new ones.

        Returns:
            The axes. Levels next to a separatrix are dashed.

        Raises:
            InvalidInputError: axes that are none.
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").plotted_levels(self, ax)


def _number(level: Level, name: str) -> str:
    n = level.numbers[name]
    return f"{n:+d}" if level.kinds[name] != "libration" and n else str(n)
