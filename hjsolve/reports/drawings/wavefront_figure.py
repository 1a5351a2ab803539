"""The drawing of a family of motions: lines W = const, the orbits that cross them, and the caustics."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import sympy as sp

from hjsolve.mechanics.system import System
from hjsolve.rays.families import Wavefronts
from hjsolve.rays.family_curve import FamilyCurve
from hjsolve.reports.document import Figure, Mathematics, Text
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.cartesian_picture import embedding, place
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import spoken

_PLANE = 2


def plane_axes(system: System) -> tuple[str, ...]:
    """Name the two axes of the plane in which a family is drawn; none where its coordinates lie in no plane.

    Args:
        system: of two coordinates, or of two next to an ignorable one, which is 0 in the plane.
    """
    if found := _plane_of_three(system):
        return tuple(found)
    where = embedding(system)
    return where.axes[:2] if len(system.coordinates) == _PLANE and where.shape == "plane" else ()


@lru_cache(maxsize=64)
def _plane_of_three(system: System) -> dict[str, sp.Expr]:
    """Axis → formula of a space in which the ignorable third coordinate turns the plane."""
    from hjsolve.mechanics.energy_shell import reduce

    if len(system.coordinates) != _PLANE + 1 or not system.place:
        return {}
    still = {c.symbol: 0 for c in reduce(system).ignorable if c.domain.kind == "angle"}
    formulas = {axis: formula.subs(still) for axis, formula in system.place.items()}
    moving = {axis: formula for axis, formula in formulas.items() if formula != 0}
    return moving if len(still) == 1 and len(moving) == _PLANE else {}


def points_shown(family: Wavefronts, curve: FamilyCurve) -> tuple[Array, Array]:
    """Return the points of a curve in the plane.

    Args:
        family: it belongs to, with a plane.
        curve: one of its curves.
    """
    system = family.motion.solution.system
    axes = plane_axes(system)
    if len(system.coordinates) > _PLANE:
        there = curve.place
        return np.asarray(there[axes[0]], float), np.asarray(there[axes[1]], float)
    where = embedding(system)
    if where.kind == "place":
        there = curve.place
        return np.asarray(there[where.axes[0]], float), np.asarray(there[where.axes[1]], float)
    x, y = place(where, dict(curve.q))[:2]
    return x, y


def one_sheet(family: Wavefronts, curve: FamilyCurve) -> Array:
    """Mark the points of a curve at which both momenta have the sign that the motion starts with, or vanish."""
    start = family.motion.initial.values
    kept = np.ones(len(next(iter(curve.q.values()))), dtype=bool)
    for name in family.motion.solution.coordinates:
        momentum = float(sp.N(start[family.motion.solution.system.coordinate(name).momentum], 20))
        sense = -1.0 if momentum < 0 else 1.0
        size = np.nanmax(np.abs(curve.p[name]), initial=0.0)
        kept &= sense * curve.p[name] >= -1e-9 * size
    return kept


def figure_of_wavefronts(family: Wavefronts, key: str) -> Figure | None:
    """Draw a family; None where its coordinates lie in no plane.

    Args:
        family: from ``wavefronts``.
        key: a name that is unique on the page.
    """
    axes = plane_axes(family.motion.solution.system)
    if not axes:
        return None
    lines = [(c, *points_shown(family, c)) for c in (*family.fronts, *family.orbits, *family.caustics)]
    window = [np.concatenate([line[i] for line in lines]) for i in (1, 2)]
    frame = svg.square(svg.DrawingFrame(svg.spread(window[0], 0.03), svg.spread(window[1], 0.03), height=400.0))
    drawn = [_curves(family, frame, *line) for line in lines]
    inside = [part for layer in range(3) for parts in drawn for part in parts[layer]]
    x0, y0 = points_shown(family, family.orbits[0])
    here = svg.disc(frame, float(x0[0]), float(y0[0]), "ring") if np.isfinite(x0[0] + y0[0]) else ""
    names = [svg.label(name_box(a)) for a in axes]
    title = "Wavefronts, orbits and caustics"
    description = (
        f"Lines of equal W in the plane of {spoken(axes[0])} and {spoken(axes[1])}, {len(family.orbits)} orbits that "
        f"cross them at right angles, and {len(family.caustics)} caustics."
    )
    text = svg.assemble(frame, key, title, description, [svg.axes(frame, *names)], inside, [here])
    data = {f"front.{k}.{n}": svg.finite(v) for k, c in enumerate(family.fronts) for n, v in c.q.items()}
    return Figure(text, title, description, _caption(family), data)


def _curves(
    family: Wavefronts, frame: svg.DrawingFrame, curve: FamilyCurve, x: Array, y: Array
) -> tuple[list[str], list[str], list[str]]:
    """Return a curve on three layers: what is faint, wavefronts, orbits and caustics."""
    if curve.kind == "caustic":
        return [], [], [svg.curve(frame, x, y, "curve")]
    strong = one_sheet(family, curve) if family.family == "constants" else np.ones(len(x), dtype=bool)
    shown = np.where(strong, x, np.nan)
    if curve.kind == "front":
        faint = [] if strong.all() else [svg.curve(frame, np.where(_weak(strong), x, np.nan), y, "grid")]
        return faint, [svg.curve(frame, shown, y, "level")], []
    own = curve is family.orbits[0]
    return [], [], [svg.curve(frame, shown, y, "motion").replace("/>", "/>" if own else ' style="stroke-width:1"/>')]


def _weak(strong: Array) -> Array:
    """Return the other points, and their neighbours, so that the parts of a line meet."""
    other = ~strong.astype(bool)
    wider = other.copy()
    wider[1:] |= other[:-1]
    wider[:-1] |= other[1:]
    return wider


def _caption(family: Wavefronts) -> Text:
    W = Mathematics(Glyph("W"))
    if family.family == "place":
        return ("Blue: ", W, " = const from one place, at equal steps. Red: orbits. Heavy: their envelope.")
    caustics = ". Heavy: turning curves, the caustics." if family.caustics else "."
    return (
        "Blue: ", W, " = const at equal steps, faint on the other sheets of ", W,
        ". Red: orbits with the same constants, where they cross the blue lines at right angles", caustics,
    )  # fmt: skip
