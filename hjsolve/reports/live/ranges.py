"""How far the sliders reach: boxes round a motion in which every neighbour is of the same kind.

No separatrix, no critical curve runs through such a box: on both sides of one the motions are different, tables that
reach across it would show a motion that does not exist. The sides of the box grow in turn until one of the motions on
a grid, which reaches a little beyond, is of another kind in an ensemble, or has a status other than ok there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hjsolve.errors import InvalidInputError
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.live.neighbours import SAME, Neighbours

INACCURATE = "inaccurate"
"""Word next to those of ``Neighbours.series``: the tables would not be accurate enough there."""
_FIRST = (0.01, 0.003, 0.001)
_ROOM, _WIDEST = 1.15, 0.6
_GROWTH = {1: 1.3, 2: 1.3, 3: 1.5, 4: 1.6}
_GRID = {1: 24, 2: 10, 3: 5, 4: 4}


@dataclass(frozen=True)
class SliderRange:
    """The range of one constant or parameter.

    Attributes:
        name: of it.
        low, high: the ends.
        value: of the motion.
        asked: the ends that were asked for, where any were.
        why: what neighbours just below and just above are: word → how many (``Neighbours.series``); empty where the
            range asked for, or the widest one, is covered.
    """

    name: str
    low: float
    high: float
    value: float
    asked: tuple[float, float] | None = None
    why: tuple[Mapping[str, int], Mapping[str, int]] = ({}, {})


def slider_ranges(
    subject: Neighbours, asked: Mapping[str, tuple[float, float] | None]
) -> tuple[Neighbours, tuple[SliderRange, ...]]:
    """Find the ranges; a constant that cannot change without changing the kind of motion has no slider.

    Args:
        subject: with the sliders wished for.
        asked: slider → the range asked for; these grow first, and no farther.

    Raises:
        InvalidInputError: nothing can be changed.
    """
    kept = tuple(s for s in subject.sliders if _first(replace(subject, sliders=(s,)), asked) is not None)
    for name in asked:
        if name not in kept:
            raise InvalidInputError(f"live: {name} cannot change here without changing the kind of motion")
    reach = None
    while kept and (reach := _first(replace(subject, sliders=kept), asked)) is None:
        kept = kept[1:] if kept[0] not in asked else kept[:-1]
    if reach is None:
        raise InvalidInputError(
            "live: this motion is too close to another kind of motion for sliders; write its report without live=True"
        )
    if lost := [name for name in asked if name not in kept]:
        raise InvalidInputError(f"live: {', '.join(lost)} cannot change together with {', '.join(kept)}; ask for fewer")
    found = replace(subject, sliders=kept)
    why: dict[tuple[int, int], Mapping[str, int]] = {}
    for group in ([s for s in kept if s in asked], [s for s in kept if s not in asked]):
        why |= _grow(found, reach, [kept.index(s) for s in group], asked)
    return found, tuple(
        SliderRange(
            name,
            float(v - r[0]),
            float(v + r[1]),
            float(v),
            asked.get(name),
            (why.get((k, 0), {}), why.get((k, 1), {})),
        )
        for k, (name, v, r) in enumerate(zip(kept, found.value, reach, strict=True))
    )


def shrunk(ranges: Sequence[SliderRange], fraction: float) -> tuple[SliderRange, ...]:
    """Return ranges of which a part is left on each side of the motion, since the tables are inaccurate beyond it."""
    why = ({INACCURATE: 1}, {INACCURATE: 1}) if fraction < 1 else None
    return tuple(
        replace(
            s,
            low=s.value - fraction * (s.value - s.low),
            high=s.value + fraction * (s.high - s.value),
            why=why or s.why,
        )
        for s in ranges
    )


def _first(subject: Neighbours, asked: Mapping[str, tuple[float, float] | None]) -> Array | None:
    """Return the first box whose motions are all alike, shape (d, 2): how far down and up; None where there is none."""
    size = np.array([abs(v) or 1.0 for v in subject.value])
    most = _most(subject, asked)
    boxes = (np.minimum(first * size[:, None] * np.ones(2), most) for first in _FIRST)
    return next((box for box in boxes if not _others(subject, box)), None)


def _most(subject: Neighbours, asked: Mapping[str, tuple[float, float] | None]) -> Array:
    """Return how far each side may grow, shape (d, 2)."""
    most = []
    for name, v in zip(subject.sliders, subject.value, strict=True):
        limits = asked.get(name)
        wide = _WIDEST * (abs(v) or 1.0)
        most.append((wide, wide) if limits is None else (v - limits[0], limits[1] - v))
    return np.array(most)


def _grow(
    subject: Neighbours, reach: Array, sliders: Sequence[int], asked: Mapping[str, tuple[float, float] | None]
) -> dict[tuple[int, int], Mapping[str, int]]:
    """Make the box wider on the sides of some sliders, in place, one after the other.

    Returns:
        (slider, side) that other motions stopped → what these are.
    """
    most = _most(subject, asked)
    why: dict[tuple[int, int], Mapping[str, int]] = {}
    growing = [(k, side) for k in sliders for side in (0, 1)]
    while growing:
        for k, side in tuple(growing):
            before = reach[k, side]
            reach[k, side] = min(_GROWTH[len(reach)] * before, most[k, side])
            if others := _others(subject, reach):
                reach[k, side], why[k, side] = before, others
                growing.remove((k, side))
            elif reach[k, side] == most[k, side]:
                growing.remove((k, side))
    return why


def _others(subject: Neighbours, reach: Array) -> Mapping[str, int]:
    """Return what motions in the box, and a little beyond it, are that are not of the kind of the one in it."""
    v, n = subject.value, _GRID[len(reach)]
    sides = [np.linspace(c - _ROOM * r[0], c + _ROOM * r[1], n) for c, r in zip(v, reach, strict=True)]
    points = np.stack([g.ravel() for g in np.meshgrid(*sides, indexing="ij")], axis=1)
    words = subject.series(points)[1]
    return {word: int((words == word).sum()) for word in sorted(set(words)) if word != SAME}
