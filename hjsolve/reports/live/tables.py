"""What a live report computes beforehand: turning points and series as polynomials in the constants.

Inside a box of motions of one kind (``ranges.py``), turning points and statuses come from an ensemble, and the series
are smooth functions of the constants and parameters (``neighbours.py``). Sums of products of Chebyshev's polynomials
hold them, as many as are needed, and the page evaluates these (``page_numbers.py``). The bound that it shows is
measured against motions of the engine and the same quadratures at other points of the box, and doubled (``bounds_of``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.live.neighbours import WAVES, Neighbours, neighbours_of
from hjsolve.reports.live.page_numbers import PageMotion
from hjsolve.reports.live.ranges import SliderRange, shrunk, slider_ranges

_CHECKS, _TIMES = 24, 33
Page = Callable[[Sequence[float]], PageMotion]


def bounds_of(subject: Neighbours, sliders: Sequence[SliderRange], page: Page, motions: int) -> dict[str, float]:
    """Return twice the largest difference seen, of what the page shows in two periods of the slowest coordinate.

    Args:
        subject: the motions round the one given.
        sliders: their ranges.
        page: the page's motion at a setting.
        motions: at so many random settings motions of the engine are the measure, at the others the quadratures.
    """
    rng = np.random.default_rng(12345)
    low, high = (np.array([getattr(s, end) for s in sliders]) for end in ("low", "high"))
    corners = np.array(np.meshgrid(*([0.0, 1.0] for _ in sliders))).reshape(len(sliders), -1).T
    settings = low + (high - low) * np.concatenate([rng.random((_CHECKS, len(sliders))), corners])
    exact, _ = subject.series(settings)
    worst: dict[str, float] = {}
    for i, values in enumerate(settings):
        own = PageMotion(subject.coordinates, subject.ignorable, {key: v[i] for key, v in exact.items()})
        t = np.linspace(0, 4 * np.pi / np.abs(own.rates).min(), _TIMES)
        shown = page(values).state(t)
        true = by_the_engine(subject, values, own, t) if i < motions else own.state(t)
        for name, column in shown.items():
            worst[name] = max(worst.get(name, 0.0), float(np.abs(column - true[name]).max()))
    sizes = sizes_of(subject)
    return {name: 2 * value + 1e-12 * sizes[name] for name, value in worst.items()}


def sizes_of(subject: Neighbours) -> dict[str, float]:
    """Return how far each coordinate and momentum of the motion given goes; of an ignorable angle one radian."""
    motion, sizes = subject.motion, {}
    exact, _ = subject.series(subject.value[None, :])
    own = PageMotion(subject.coordinates, subject.ignorable, {key: v[0] for key, v in exact.items()})
    state = own.state(np.linspace(0, 2 * np.pi / np.abs(own.rates).min(), 65))
    for name, column in state.items():
        sizes[name] = float(np.ptp(column)) or 1.0
    for name in (*subject.ignorable, *(c.name for c in subject.coordinates if c.direction)):
        if motion.solution.system.coordinate(name).domain.kind == "angle":
            sizes[name] = 1.0
    return {name: max(size, 1e-300) for name, size in sizes.items()} | {
        f"p_{c.name}": float(np.abs(state[f"p_{c.name}"]).max()) for c in subject.coordinates if c.direction
    }


def by_the_engine(subject: Neighbours, values: Sequence[float], own: PageMotion, t: Array) -> dict[str, Array]:
    """Return the state at times as ``Solution.motion`` has it, started where the page's motion is away from turns.

    Args:
        subject: the motions round the one given.
        values: of the sliders.
        own: the page's motion with the quadratures' own numbers.
        t: times from the start of the page, shape (m,).
    """
    motion = subject.motion
    solution, system = replace(motion.solution, chart=None), motion.solution.system
    exact = {**motion.initial.constants, **{p.name: motion.initial.values[p.symbol] for p in system.parameters}}
    given = {**exact, **{name: float(v) for name, v in zip(subject.sliders, values, strict=True)}}
    tries = np.linspace(0, 2 * np.pi / np.abs(own.rates).min(), 40)
    libration = [k for k, c in enumerate(subject.coordinates) if not c.direction]
    room = np.abs(np.sin(own.phases(tries)[libration])).min(axis=0, initial=1.0)
    later = float(tries[np.argmax(room)])
    start = {name: float(v[0]) for name, v in own.state(np.array([later])).items()}
    names = [c.name for c in subject.coordinates]
    begun = solution.motion(
        q={n: start[n] for n in names} | dict.fromkeys(subject.ignorable, 0),
        constants={n: given[n] for n in solution.constants},
        signs={n: int(np.sign(start[f"p_{n}"])) for n in names},
        parameters={p.name: given[p.name] for p in system.parameters},
    )
    state, first = begun.at(t - later), begun.at(0.0)
    found: dict[str, Array] = {}
    for name in (*names, *subject.ignorable):
        unwrapped = np.asarray(state.unwrapped(name), float) - float(first.unwrapped(name))
        found[name] = unwrapped + start[name]
        if name in names:
            found[f"p_{name}"] = np.asarray(state.p[name], float)
    return found


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
