"""The drawings of the motion itself: its orbit in space, and its coordinates against time.

``key`` is a name that is unique on the page, t are the times drawn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.mechanics.energy_shell import time_name
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import State
from hjsolve.reports.document import Figure, Mathematics, Text
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.cartesian_picture import Embedding, embedding, path_of, projected
from hjsolve.reports.drawings.effective_potential import Array
from hjsolve.reports.formulas.layout import Box, Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain, spoken

_POINTS_PER_CYCLE = 181
_MOST_POINTS = 2600


@dataclass(frozen=True)
class Trace:
    """Where a motion is at the times that are drawn.

    Attributes:
        t: the times, shape (n,).
        state: ``motion.at(t)``.
        closed: whether the motion repeats itself after the last time.
    """

    t: Array
    state: State
    closed: bool


def trace(motion: Motion) -> Trace:
    """Follow a motion over a time worth showing."""
    t, closed = times(motion)
    return Trace(t, motion.at(t), closed)


def span(motion: Motion) -> tuple[float, float, bool]:
    """Choose the time to show: a few cycles of a bounded motion, the passage of an unbounded one.

    Returns:
        (start, stop, closed): closed is True where the motion repeats itself after the span.
    """
    t0 = float(motion.t0)
    if motion.boundary_times:
        ends = sorted(float(e.value) for e in motion.boundary_times.values())
        later, earlier = [e for e in ends if e > t0], [e for e in ends if e < t0]
        stop = min(later) if later else t0 + (t0 - max(earlier))
        return (max(earlier) if earlier else t0), stop, False
    periods = [float(e.value) for name, e in motion.periods.items() if motion.kinds[name] != "equilibrium"]
    if any(kind in {"escape", "asymptotic"} for kind in motion.kinds.values()):
        reach = _reach(motion, t0)
        return t0 - reach, t0 + reach, False
    if not periods:
        return t0, t0 + 10.0, False
    longest = max(periods)
    repeats = all(abs(longest / p - round(longest / p)) < 1e-9 for p in periods)
    if repeats:
        return t0, t0 + longest, True
    essential = [float(motion.periods[n].value) for n in motion.solution.coordinates if n in motion.periods]
    return t0, t0 + 12 * max(essential or periods), False


def _reach(motion: Motion, t0: float) -> float:
    """Double the time until the running coordinates have gone several times their own size."""
    names = [n for n in motion.solution.coordinates if motion.kinds[n] in {"escape", "asymptotic"}]
    start = motion.at(t0)
    reach = max(_natural_time(motion, n, start) for n in names)
    for _ in range(40):
        state = motion.at([t0 - reach, t0 + reach])
        if all(_gone(motion, n, state, float(start.unwrapped(n))) for n in names):
            break
        reach *= 2.0
    return reach


def _size(motion: Motion, name: str, start: float) -> tuple[float, float]:
    """Return where a running coordinate starts from, and the length it should be measured by."""
    turning = [float(e.value) for e in motion.turning_points.get(name, ()) if e is not None]
    anchor = turning[0] if turning else start
    return anchor, max(abs(anchor), abs(start - anchor), 0.3)


def _natural_time(motion: Motion, name: str, state: State) -> float:
    speed = abs(float(state.velocity[name]))
    size = _size(motion, name, float(state.unwrapped(name)))[1]
    return size / speed if speed > 1e-3 * size else 1.0


def _gone(motion: Motion, name: str, state: State, start: float) -> bool:
    anchor, size = _size(motion, name, start)
    distances = np.abs(np.asarray(state.unwrapped(name), float) - anchor)
    if motion.kinds[name] == "asymptotic":
        return bool(np.min(np.abs(np.asarray(state.velocity[name], float))) < 1e-3)
    return bool(np.nanmax(distances) > 4.5 * size)


def times(motion: Motion) -> tuple[Array, bool]:
    """Sample the time shown densely enough for smooth curves.

    Returns:
        (times, closed).
    """
    start, stop, closed = span(motion)
    periods = [float(e.value) for e in motion.periods.values()]
    cycles = (stop - start) / min(periods) if periods else 2.0
    count = int(min(_MOST_POINTS, max(_POINTS_PER_CYCLE, cycles * _POINTS_PER_CYCLE))) + 1
    return np.linspace(start, stop, count), closed


def orbit(motion: Motion, trace: Trace, key: str) -> Figure | None:
    """Draw the path in space; None for one coordinate, whose path is its graph against time.

    Returns:
        The figure, or None.
    """
    where = embedding(motion.solution.system)
    if where.shape == "line":
        return None
    path = path_of(where, trace.state)
    draw = {"plane": _plane, "coordinates": _plane, "space": _space, "sphere": _sphere}[where.shape]
    return draw(motion, where, trace.t, path, trace.closed, key)


def first_cycle(motion: Motion, t: Array, closed: bool) -> int:
    """Count the samples of the first cycle, which is drawn strong; the rest is faint.

    Args:
        closed: whether the motion repeats itself after the last.
    """
    periods = [float(motion.periods[n].value) for n in motion.solution.coordinates if n in motion.periods]
    if closed or not periods or motion.boundary_times or "escape" in motion.kinds.values():
        return len(t)
    return int(np.searchsorted(t, t[0] + 1.5 * max(periods))) + 1


def _plane(motion: Motion, where: Embedding, t: Array, path: tuple[Array, ...], closed: bool, key: str) -> Figure:
    x, y = path[:2]
    centred = where.kind in {"polar", "parabolic"}
    xs, ys = (np.append(x, 0.0), np.append(y, 0.0)) if centred else (x, y)
    frame = svg.DrawingFrame(svg.spread(xs), svg.spread(ys), height=360.0)
    frame = svg.square(frame) if where.shape == "plane" else frame
    cut = first_cycle(motion, t, closed)
    inside = [svg.curve(frame, x, y, "faint")] if cut < len(t) else []
    inside.append(svg.curve(frame, x[:cut], y[:cut], "motion"))
    now = int(np.argmin(np.abs(t - float(motion.t0))))
    above = [svg.disc(frame, 0.0, 0.0, "centre", 3.2)] if centred else []
    above.append(svg.disc(frame, float(x[now]), float(y[now]), "ring"))
    names = [svg.label(name_box(a)) for a in where.axes[:2]]
    title = "Orbit"
    across, up = map(spoken, where.axes[:2])
    description = f"Path of the motion in the plane of {across} and {up}, {_from_to(motion, t)}."
    svg_text = svg.assemble(frame, key, title, description, [svg.axes(frame, *names)], inside, above)
    return Figure(
        svg_text,
        title,
        description,
        _caption(motion, t, closed, cut < len(t)),
        {where.axes[0]: svg.finite(x), where.axes[1]: svg.finite(y)},
    )


def _space(motion: Motion, where: Embedding, t: Array, path: tuple[Array, ...], closed: bool, key: str) -> Figure:
    across, up, _ = projected(*path)
    reach = 1.08 * float(np.max(np.hypot(across, up)))
    frame = svg.square(
        svg.DrawingFrame(svg.spread([*across, 0.0]), svg.spread([*up, 0.0]), height=360.0, left=16, top=16, bottom=16)
    )
    below, above = [], []
    for name, direction in zip("xyz", np.eye(3)):
        a, b, _ = projected(*(np.array([0.0, d * reach * 0.5]) for d in direction))
        below.append(svg.curve(frame, a, b, "grid"))
        above.append(svg.annotate(frame, float(a[1]), float(b[1]), svg.label(Glyph(name)), style="name", shift=(3, 0)))
    cut = first_cycle(motion, t, closed)
    inside = [svg.curve(frame, across, up, "faint")] if cut < len(t) else []
    inside.append(svg.curve(frame, across[:cut], up[:cut], "motion"))
    above.append(svg.disc(frame, 0.0, 0.0, "centre", 3.2))
    now = int(np.argmin(np.abs(t - float(motion.t0))))
    above.append(svg.disc(frame, float(across[now]), float(up[now]), "ring"))
    description = f"Path of the motion in space, seen from above the plane, {_from_to(motion, t)}."
    svg_text = svg.assemble(frame, key, "Orbit", description, below, inside, above)
    return Figure(
        svg_text,
        "Orbit",
        description,
        _caption(motion, t, closed, cut < len(t)),
        dict(zip(where.axes, map(svg.finite, path))),
    )


def _sphere(motion: Motion, where: Embedding, t: Array, path: tuple[Array, ...], closed: bool, key: str) -> Figure:
    """Draw a path of directions on the unit sphere; the far side is faint."""
    frame = svg.square(svg.DrawingFrame((-1.12, 1.12), (-1.08, 1.2), height=360.0, left=16, top=16, bottom=16))
    turn = np.linspace(0.0, 2 * np.pi, 181)
    below = [
        svg.area(frame, np.cos(turn[:91]), -np.sin(turn[:91]), np.sin(turn[:91]), "region"),
        svg.curve(frame, np.cos(turn), np.sin(turn), "grid"),
    ]
    for latitude in np.radians([-60, -30, 0, 30, 60]):
        a, b, near = projected(
            np.cos(latitude) * np.cos(turn), np.cos(latitude) * np.sin(turn), np.full_like(turn, np.sin(latitude))
        )
        below.append(svg.curve(frame, np.where(near > 0, a, np.nan), b, "grid"))
    across, up, near = projected(*path)
    cut = first_cycle(motion, t, closed)
    front = np.where(near >= 0, across, np.nan)
    inside = [svg.curve(frame, np.where(near < 0, across, np.nan), up, "faint"), svg.curve(frame, front, up, "motion")]
    pole = projected(np.zeros(2), np.zeros(2), np.array([1.0, 1.1]))
    above = [
        svg.curve(frame, pole[0], pole[1], "axis"),
        svg.annotate(frame, float(pole[0][1]), float(pole[1][1]), "up", anchor="middle", shift=(0, -4)),
    ]
    now = int(np.argmin(np.abs(t - float(motion.t0))))
    above.append(svg.disc(frame, float(across[now]), float(up[now]), "ring"))
    description = (
        f"Path of the direction ({', '.join(map(spoken, where.names))}) on the unit sphere, {_from_to(motion, t)}; "
        "the far side is drawn faint."
    )
    svg_text = svg.assemble(frame, key, "Orbit on the sphere", description, below, inside, above)
    return Figure(
        svg_text,
        "Orbit on the sphere",
        description,
        _caption(motion, t, closed, cut < len(t), sphere=True),
        dict(zip(where.axes, map(svg.finite, path))),
    )


def time_box(motion: Motion) -> Box:
    """Return the letter of the parameter of a motion."""
    return name_box(time_name(motion.solution.system))


def _from_to(motion: Motion, t: Array) -> str:
    letter = plain(time_box(motion))
    return f"from {letter} = {t[0]:.6g} to {letter} = {t[-1]:.6g}"


def _caption(motion: Motion, t: Array, closed: bool, faint: bool, *, sphere: bool = False) -> Text:
    ends = f" = {t[0]:.4g} to {t[-1]:.4g}".replace("-", "−")
    start: Text = ("Orbit over one period",) if closed else ("Orbit from ", Mathematics(time_box(motion)), ends)
    side = "; the far side of the sphere is faint" if sphere else "; the first cycle is drawn strong" if faint else ""
    return (*start, "; the ring is the start", side, ".")


def history(motion: Motion, trace: Trace, key: str) -> Figure:
    """Draw the separated coordinates against time, each in its own band.

    Returns:
        The figure.
    """
    names = motion.solution.coordinates or tuple(c.name for c in motion.solution.system.coordinates)
    names = tuple(names)[:3]
    keep = few_cycles(motion, trace.t)
    shown = trace.t[keep]
    whole = 360.0 if len(names) > 1 else 320.0
    band = (whole - 40.0 - 30.0 * len(names)) / len(names)
    parts_below, parts_inside, data = [], [], {time_name(motion.solution.system): svg.finite(shown)}
    for i, name in enumerate(names):
        values = np.asarray(trace.state.unwrapped(name), float)[keep]
        top = 28.0 + i * (band + 30.0)
        frame = svg.DrawingFrame(
            (float(shown[0]), float(shown[-1])),
            svg.spread(values, 0.1),
            height=whole,
            top=top,
            bottom=whole - top - band,
        )
        parts_below.append(_band_axes(frame, name, time_box(motion), last=i == len(names) - 1))
        parts_inside.append(svg.curve(frame, shown, values, "motion"))
        data[name] = svg.finite(values)
    own = time_name(motion.solution.system) == "t"
    title = "The coordinates against time" if own else "The coordinates along the path"
    across = "time" if own else "the parameter of the path"
    description = f"{', '.join(map(spoken, names))} against {across} {_from_to(motion, shown)}."
    board = svg.DrawingFrame((0.0, 1.0), (0.0, 1.0), height=whole)
    caption: Text = (
        f"Where the motion is at {across if own else 'the value'} ", Mathematics(time_box(motion)),
        "" if own else " of its parameter", ", from the time law alone.",
    )  # fmt: skip
    return Figure(
        svg.assemble(board, key, title, description, parts_below, parts_inside), title, description, caption, data
    )


def few_cycles(motion: Motion, t: Array) -> slice:
    """Choose the times of the first few cycles."""
    periods = [float(motion.periods[n].value) for n in motion.solution.coordinates if n in motion.periods]
    if not periods:
        return slice(None)
    return slice(0, int(np.searchsorted(t, t[0] + 4 * max(periods))) + 1)


def _band_axes(frame: svg.DrawingFrame, name: str, time: Box, *, last: bool) -> str:
    return svg.axes(frame, svg.label(time) if last else "", svg.label(name_box(name)), numbers=last)
