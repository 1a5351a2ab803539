"""What a live report computes beforehand: turning points and series as polynomials in the constants.

Inside a box of motions of one kind (``ranges.py``), turning points and statuses come from an ensemble, and the series
are smooth functions of the constants and parameters (``neighbours.py``). Sums of products of Chebyshev's polynomials
hold them, as many as are needed, and the page evaluates these (``page_numbers.py``). The bound that it shows is
measured against motions of the engine and the same quadratures at other points of the box, and doubled (``bounds.py``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.live.bounds import bounds_of, sizes_of
from hjsolve.reports.live.neighbours import WAVES, Neighbours, neighbours_of
from hjsolve.reports.live.page_numbers import PageMotion
from hjsolve.reports.live.ranges import SliderRange, shrunk, slider_ranges

MOST_SLIDERS = 4
_SIZES = {1: (6, 9, 13, 18, 24), 2: (6, 9, 13, 18, 24), 3: (6, 9, 12, 15), 4: (5, 7, 9)}
_GOOD, _ENOUGH, _COARSE = 1e-6, 1e-4, 1e-2
_DROPPED, _MOST_NUMBERS, _MOTIONS = (1e-9, 1e-8, 1e-7), 80_000, 4
Ranks = NDArray[np.int64]
Asked = Mapping[str, tuple[float, float] | None]
_FRACTIONS = (1.0, 0.75, 0.55, 0.4, 0.25)


@dataclass(frozen=True)
class LiveTables:
    """Everything the page computes with.

    Attributes:
        neighbours: the motions round the one that the page begins with.
        sliders: one to four.
        layout: (position of a coordinate, group) → where its numbers are in a row of ``table``, begin and end: one for
            ``a`` and ``b``, WAVES cosines and after them sines for a series, but see ``kept``.
        kept: the same → the rank (0 … WAVES − 1 cosines, WAVES … sines) of each of its numbers.
        degrees: of each product of Chebyshev's polynomials, shape (m, d).
        table: its coefficients, shape (m, columns).
        bounds: coordinate, ``p_`` coordinate → how far the page may be from ``Solution.motion`` during two periods.
    """

    neighbours: Neighbours
    sliders: tuple[SliderRange, ...]
    layout: Mapping[tuple[int, str], tuple[int, int]]
    kept: Mapping[tuple[int, str], Ranks]
    degrees: Ranks
    table: Array
    bounds: Mapping[str, float]

    def motion(self, values: Sequence[float]) -> PageMotion:
        """Return the motion that the page shows."""
        u = [(2 * v - s.low - s.high) / (s.high - s.low) for s, v in zip(self.sliders, values, strict=True)]
        T = [np.cos(self.degrees[:, k] * np.arccos(np.clip(x, -1, 1))) for k, x in enumerate(u)]
        row = np.prod(T, axis=0) @ self.table
        columns: dict[tuple[int, str], Array] = {}
        for key, (begin, end) in self.layout.items():
            whole = np.zeros(1 if key[1] in "ab" else 2 * WAVES - 1)
            whole[self.kept[key]] = row[begin:end]
            columns[key] = whole
        return PageMotion(self.neighbours.coordinates, self.neighbours.ignorable, columns)


def live_tables(motion: Motion, asked: Asked | None = None) -> LiveTables:
    """Compute the tables of a motion's neighbours.

    Args:
        motion: the one that the page begins with.
        asked: constants and parameters that are to have a slider, each with its range or None; the other constants
            have one as far as there is room. None: the constants.

    Raises:
        InvalidInputError: a coordinate neither librates nor rotates; a slider that is not possible.
        NotConvergedError: the tables stay too coarse.
    """
    motion, asked = motion.as_solved, dict(asked or {})
    refuse_kinks(motion.solution.system.kinks, "live")
    subject, whole = slider_ranges(neighbours_of(motion, _names(motion, asked)), asked)
    sizes = sizes_of(subject)
    for fraction in _FRACTIONS:
        found = _tables(subject, shrunk(whole, fraction), sizes)
        if _worst(found, sizes) <= _ENOUGH:
            break
    page = replace(found, bounds=bounds_of(subject, found.sliders, found.motion, _MOTIONS))
    if found.table.size > _MOST_NUMBERS or _worst(page, sizes) > _COARSE:
        raise NotConvergedError("live: its tables are not accurate enough; write this report without live=True")
    return page


def _names(motion: Motion, asked: Asked) -> tuple[str, ...]:
    """Return the sliders in the order of the page: momenta, separation constants, E, parameters."""
    solution = motion.solution
    parameters = [p.name for p in solution.system.parameters]
    for name, span in asked.items():
        if name not in (*solution.constants, *parameters):
            known = ", ".join((*solution.constants, *parameters))
            raise InvalidInputError(f"live: there is no constant or parameter {name} for a slider; there are {known}")
        now = _value(motion, name)
        if span is not None and not span[0] < now < span[1]:
            raise InvalidInputError(f"live: the range of {name} has to contain its value in the motion, {now:.6g}")
    if len(asked) > MOST_SLIDERS:
        raise InvalidInputError(f"live: at most {MOST_SLIDERS} sliders are possible, {len(asked)} are asked for")
    angles = [f"p_{c.name}" for c in solution.system.coordinates if c.domain.kind == "angle"][::-1]
    momenta = [n for n in solution.constants if n.startswith("p_")]
    momenta = [*(n for n in angles if n in momenta), *(n for n in momenta if n not in angles)]
    proper = time_name(solution.system) != "t" or solution.system.relativity is not None  # then E is −m²/2
    shell = ["E"] if "E" in solution.constants and not proper else []
    others = [n for n in solution.constants if n not in momenta and n != "E"]
    chosen = [*asked, *(n for n in (*shell, *momenta, *others) if n not in asked)][:MOST_SLIDERS]
    return tuple(n for n in (*momenta, *others, "E", *parameters) if n in chosen)


def _value(motion: Motion, name: str) -> float:
    values = {p.name: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}
    return float(sp.N({**values, **motion.initial.constants}[name], 30))


def _worst(tables: LiveTables, sizes: Mapping[str, float]) -> float:
    return max(value / sizes[name] for name, value in tables.bounds.items())


# ------------------------------------------------------------------------------------------------ the tables
def _tables(subject: Neighbours, sliders: tuple[SliderRange, ...], sizes: Mapping[str, float]) -> LiveTables:
    """Return the tables of a box with the fewest polynomials that are enough, and their bounds without the engine."""
    for size in _SIZES[len(sliders)]:
        values = _at_nodes(subject, sliders, size)
        for dropped in _DROPPED:
            found = _fitted(subject, sliders, values, size, dropped)
            if found.table.size <= _MOST_NUMBERS:
                break
        found = replace(found, bounds=bounds_of(subject, sliders, found.motion, 0))
        if _worst(found, sizes) <= _GOOD or found.table.size > _MOST_NUMBERS:
            break
    return found


def _at_nodes(subject: Neighbours, sliders: Sequence[SliderRange], size: int) -> dict[tuple[int, str], Array]:
    """Return every column at Chebyshev's points of the ranges, so many on each axis."""
    u = np.cos(np.pi * (np.arange(size) + 0.5) / size)
    places = [(s.low + s.high) / 2 + (s.high - s.low) / 2 * u for s in sliders]
    grid = np.stack([g.ravel() for g in np.meshgrid(*places, indexing="ij")], axis=1)
    return subject.series(grid)[0]


def _fitted(
    subject: Neighbours, sliders: tuple[SliderRange, ...], values: Mapping[tuple[int, str], Array], size: int,
    dropped: float,
) -> LiveTables:  # fmt: skip
    """Interpolate, and leave out numbers that are too small to be seen."""
    layout: dict[tuple[int, str], tuple[int, int]] = {}
    kept: dict[tuple[int, str], Ranks] = {}
    columns, scales = [], []
    for key, column in values.items():
        large = np.abs(column).max(axis=0)
        ranks = np.flatnonzero((large > dropped * large.max()) | (np.arange(len(large)) == 0))
        begin = sum([len(r) for r in kept.values()])
        layout[key], kept[key] = (begin, begin + len(ranks)), ranks
        columns.append(column[:, ranks])
        scales.append(np.full(len(ranks), large.max() or 1.0))
    d = len(sliders)
    whole = np.concatenate(columns, axis=1).reshape((size,) * d + (-1,))
    transform = np.cos(np.outer(np.arange(size), np.pi * (np.arange(size) + 0.5) / size)) * (2 / size)
    transform[0] /= 2
    for axis in range(d):
        whole = np.moveaxis(np.tensordot(transform, whole, axes=(1, axis)), 0, axis)
    table = whole.reshape(size**d, -1)
    degrees = np.stack([g.ravel() for g in np.meshgrid(*[np.arange(size)] * d, indexing="ij")], axis=1)
    seen = (np.abs(table) > dropped * np.concatenate(scales)).any(axis=1)
    return LiveTables(subject, sliders, layout, kept, degrees[seen], table[seen], {})
