"""Drawings of a system that does not separate: the lines of equal potential with a path, and a surface of section."""

from __future__ import annotations

import numpy as np

from hjsolve.mechanics.system import Coordinate
from hjsolve.reports.document import Figure, Inline, Mathematics
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.contours import drawn_level
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import spoken
from hjsolve.scenes.surface_of_section import AGREEMENT, PlaneMotion, SurfaceOfSection

_FINE, _LEVELS, _BETWEEN, _ROOM = 121, 12, 8, 0.25


def least_energy(plane: PlaneMotion, q: Array) -> Array:
    """Return the least energy at a place, that of the body at rest in it: V, with what ignorable momenta add.

    Args:
        plane: the equations of motion.
        q: places, shape (2, …).
    """
    zero = np.zeros_like(q)
    with np.errstate(all="ignore"):
        at = [plane.slopes(np.concatenate([q, p]))[:2] for p in (zero, _unit(zero, 0), _unit(zero, 1))]
        (a, c), (b, d) = at[1] - at[0], at[2] - at[0]
        u, v = at[0]
        p = np.array([-(d * u - b * v), -(a * v - c * u)]) / (a * d - b * c)
        return np.asarray(plane.energy(np.concatenate([q, p])))


def _unit(zero: Array, k: int) -> Array:
    p = zero.copy()
    p[k] = 1.0
    return p


def contour_figure(plane: PlaneMotion, times: Array, states: Array, key: str) -> Figure:
    """Draw lines of equal least energy, the edge of the motion, and a path.

    Args:
        plane: the equations of motion.
        times, states: of the path, shapes (n,) and (4, n).
        key: a name that is unique on the page.
    """
    x, y = _smooth(plane, times, states)
    first, second = plane.coordinates
    frame = svg.DrawingFrame(_range(first, x), _range(second, y))
    if "angle" not in (first.domain.kind, second.domain.kind):
        frame = svg.square(frame)
    across, up = np.linspace(*frame.x, _FINE), np.linspace(*frame.y, _FINE)
    V, E = least_energy(plane, np.array(np.meshgrid(across, up))), float(plane.energy(plane.start))
    finite = V[np.isfinite(V)]
    bottom = float(np.quantile(finite, 0.02))
    step = (min(float(np.quantile(finite, 0.95)), E + 2 * abs(E - bottom)) - bottom) / _LEVELS
    inside = [_lines(frame, across, up, V, bottom + step * (k + 0.5), "level") for k in range(_LEVELS)]
    inside += [svg.curve(frame, x, y, "faint"), _lines(frame, across, up, V, E, "curve")]
    names = [Mathematics(name_box(c.name)) for c in plane.coordinates]
    angles = (first.domain.kind == "angle", second.domain.kind == "angle")
    below = [svg.axes(frame, *(svg.label(name_box(c.name)) for c in plane.coordinates), angles=angles)]
    above = [svg.disc(frame, float(plane.start[0]), float(plane.start[1]), "ring")]
    title = f"Lines of equal potential over {spoken(first.name)} and {spoken(second.name)}"
    words = f"{title}; the motion at energy {E:.6g} stays inside one of them."
    caption: list[Inline] = [
        "Blue: contours of the effective potential over ", names[0], " and ", names[1],
        f", {step:.3g} apart. Heavy: ", Mathematics(Glyph("E")), f" = {E:.6g}, the limit of every "
        "motion of this energy. Red: the motion, starting at the ring.",
    ]  # fmt: skip
    data = {first.name: list(map(float, x)), second.name: list(map(float, y)), "E": [E]}
    return Figure(svg.assemble(frame, key, title, words, below, inside, above), title, words, tuple(caption), data)


def _range(coordinate: Coordinate, path: Array) -> tuple[float, float]:
    if coordinate.domain.kind == "angle":
        return -np.pi, np.pi
    low, high = float(np.nanmin(path)), float(np.nanmax(path))
    room = _ROOM * (high - low) or 1.0
    ends = (coordinate.domain.lower, coordinate.domain.upper)
    lower, upper = (None if end is None or end.free_symbols else float(end) for end in ends)
    low, high = low - room, high + room
    return low if lower is None else max(low, lower), high if upper is None else min(high, upper)


def _smooth(plane: PlaneMotion, times: Array, states: Array) -> tuple[Array, Array]:
    """Return the path between its steps by Hermite's cubics; angles in one turn, with a gap where they jump."""
    rates, h = plane.slopes(states)[:2], np.diff(times)
    s = (np.arange(_BETWEEN) / _BETWEEN)[:, None]
    rows = []
    for k, coordinate in enumerate(plane.coordinates):
        a, b, u, v = states[k, :-1], states[k, 1:], rates[k, :-1] * h, rates[k, 1:] * h
        q = a + s * (u + s * (3 * (b - a) - 2 * u - v + s * (2 * (a - b) + u + v)))
        line = np.append(q.T.ravel(), states[k, -1])
        if coordinate.domain.kind == "angle":
            line = np.remainder(line + np.pi, 2 * np.pi) - np.pi
        rows.append(line)
    jumps = np.flatnonzero(np.max(np.abs(np.diff(rows, axis=1)), axis=0) > 3) + 1
    if any(c.domain.kind == "angle" for c in plane.coordinates):
        rows = [np.insert(line, jumps, np.nan) for line in rows]
    return rows[0], rows[1]


def _lines(frame: svg.DrawingFrame, x: Array, y: Array, values: Array, level: float, style: str) -> str:
    return f'<path class="{style}" d="{drawn_level(frame, x, y, values, level)}"/>'


def section_figure(plane: PlaneMotion, found: SurfaceOfSection, key: str) -> Figure:
    """Draw a surface of section.

    Args:
        plane: the equations of motion.
        found: the section.
        key: a name that is unique on the page.
    """
    q, p, room = found.plane
    kept, fixed = plane.coordinates[found.across], plane.coordinates[found.along]
    angle = kept.domain.kind == "angle"
    frame = svg.DrawingFrame((float(q[0]), float(q[-1])), (float(p[0]), float(p[-1])))
    points = found.points
    places = np.remainder(points[0] + np.pi, 2 * np.pi) - np.pi if angle else points[0]
    number = np.arange(points.shape[2])
    sure = number < found.settled[:, None]
    own = np.zeros_like(sure)
    own[0] = True
    inside = [_lines(frame, q, p, room, 0.0, "curve")]
    for mask, colour, width in ((sure & ~own, "blue", 1.9), (~sure & ~own, "soft", 1.5), (own, "red", 2.6)):
        inside.append(_dots(frame, places[mask], points[1][mask], f"stroke:var(--{colour});stroke-width:{width}"))
    momentum = name_box(f"p_{kept.name}")
    below = [svg.axes(frame, svg.label(name_box(kept.name)), svg.label(momentum), angles=(angle, False), zero=True)]
    title = f"Surface of section at {spoken(fixed.name)} = {found.level:.6g}"
    counted = f"{int(np.isfinite(points[0]).sum())} returns of {points.shape[1]} motions at energy {found.energy:.6g}"
    words = f"{title}: {counted}. Points on closed curves are regular motions, scattered ones chaotic."
    caption: list[Inline] = [
        f"Poincaré's surface of section: {counted}, where ", Mathematics(name_box(fixed.name)),
        f" = {found.level:.6g} is passed upwards. Heavy: its edge. Red: the motion of this report.",
    ]  # fmt: skip
    if (~sure & np.isfinite(points[0])).any():
        caption.append(
            f" Grey: past where two runs, tolerances a hundred times apart, differ by {AGREEMENT:g} of the figure: "
            "returns of motions close by."
        )
    data = {kept.name: list(map(float, points[0].ravel())), f"p_{kept.name}": list(map(float, points[1].ravel()))}
    return Figure(svg.assemble(frame, key, title, words, below, inside), title, words, tuple(caption), data)


def _dots(frame: svg.DrawingFrame, x: Array, y: Array, style: str) -> str:
    good = np.isfinite(x) & np.isfinite(y)
    marks = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(frame.px(x[good]), frame.py(y[good])))
    return f'<path style="{style};stroke-linecap:round;fill:none" d="{marks}"/>' if marks else ""
