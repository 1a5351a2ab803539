"""A motion on axes: its orbit, its coordinates in time, the phase plane and effective potential of a coordinate."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from hjsolve import catalog
from hjsolve.arguments import refuse_other
from hjsolve.errors import InvalidInputError
from hjsolve.motion.motion import Motion
from hjsolve.plots import style
from hjsolve.plots.wavefronts import plotted_wavefronts
from hjsolve.rays.families import wavefronts
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.drawings import phase_portrait as portrait
from hjsolve.reports.drawings.cartesian_picture import Embedding, embedding, path_of
from hjsolve.reports.drawings.effective_potential import EffectivePotential, effective_potential_of
from hjsolve.reports.drawings.motion_figures import (
    is_angle,
    level_box,
    levels_shown,
    loops_at,
    momenta_shown,
    own_loops,
    potential_name,
    spans_covered,
)
from hjsolve.reports.formulas.names import name_box
from hjsolve.solution.quadratures import Solution

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINDS = ("orbit", "time", "phase", "potential", "wavefronts")


def plotted(motion: Motion, kind: str, name: str | None, ax: Axes | None) -> Axes:
    """Draw a motion.

    Args:
        kind: one of ``KINDS``.
        name: the coordinate, for phase, potential and time; None for the first.
        ax: matplotlib's axes; None for new ones.

    Returns:
        The axes.

    Raises:
        InvalidInputError: another kind, a coordinate that is not separated, or axes that are none.
        MissingExtraError: matplotlib is not installed.
    """
    if kind not in KINDS:
        raise InvalidInputError(f'plot: kind is one of {", ".join(KINDS)}, not "{kind}"')
    if ax is not None and not hasattr(ax, "plot"):
        raise InvalidInputError(f"plot: ax must be axes of matplotlib, not {type(ax).__name__}")
    motion = motion.as_solved
    if kind == "wavefronts":
        return plotted_wavefronts(wavefronts(motion), ax)
    where = embedding(motion.solution.system)
    with style.drawing() as pyplot:
        if kind == "orbit" and where.shape != "line":
            return _orbit(motion, where, _axes(pyplot, ax, solid=where.shape in {"space", "sphere"}))
        if kind in {"orbit", "time"}:
            return _history(motion, name, _axes(pyplot, ax))
        well = effective_potential_of(motion, _separated(motion, name))
        draw = _phase if kind == "phase" else _potential
        return draw(motion, well, _axes(pyplot, ax))


def plotted_solution(
    solution: Solution, kind: str, name: str | None, ax: Axes | None, initial: Mapping[str, Any]
) -> Axes:
    """Start a motion and draw it.

    Args:
        kind, name, ax: as in ``plotted``.
        initial: keywords of ``Solution.motion``; empty for the default motion of the catalog's entry.

    Returns:
        The axes.

    Raises:
        InvalidInputError: no initial data, and the catalog has none.
    """
    if not initial:
        entry = catalog.entry_of(solution.system)
        if entry is None or "default" not in entry.motions:
            raise InvalidInputError('plot: which motion? give initial data: plot("phase", q={…}, velocity={…})')
        initial = entry.motions["default"].arguments
    return plotted(solution.motion(**initial), kind, name, ax)


def _axes(pyplot: ModuleType, ax: Axes | None, *, solid: bool = False) -> Axes:
    return ax if ax is not None else pyplot.figure().add_subplot(projection="3d" if solid else None)


def _separated(motion: Motion, name: str | None) -> str:
    names = motion.solution.coordinates
    if name is None:
        if not names:
            raise InvalidInputError("plot: every coordinate is ignorable; there is no potential and no phase plane")
        return names[0]
    refuse_other(name, str, "name", "the name of a coordinate is needed")
    if name not in names:
        raise InvalidInputError(f'plot: "{name}" is not separated; {", ".join(names) or "none"} can be drawn')
    return name


# ------------------------------------------------------------------------------------------------ where it goes
def _orbit(motion: Motion, where: Embedding, ax: Axes) -> Axes:
    trace = orbit_paths.trace(motion)
    path = path_of(where, trace.state)
    path = path[: 3 if hasattr(ax, "get_zlim") else 2]
    cut = orbit_paths.first_cycle(motion, trace.t, trace.closed)
    if cut < len(trace.t):
        ax.plot(*path, **style.FAINT)
    ax.plot(*(x[:cut] for x in path), **style.MOTION)
    now = int(np.argmin(np.abs(trace.t - float(motion.t0))))
    if where.kind in {"polar", "parabolic", "spherical"}:
        ax.plot(*([0.0] for _ in path), **style.CENTRE)
    ax.plot(*([float(x[now])] for x in path), **style.RING)
    for letter, axis in zip("xyz", where.axes[: len(path)]):
        getattr(ax, f"set_{letter}label")(style.mathematics(name_box(axis)))
    if where.shape != "coordinates":
        ax.set_aspect("equal")
    if len(path) == 3:
        _spatial(ax, sphere=where.shape == "sphere")
    return ax


def _spatial(ax: Any, *, sphere: bool) -> None:
    """Few marks on the axes; round a path on the unit sphere, the sphere."""
    for letter in "xyz":
        ax.locator_params(axis=letter, nbins=3)
        getattr(ax, f"{letter}axis").set_pane_color((1, 1, 1, 0))
    if sphere:
        θ, φ = np.meshgrid(np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 49))
        ball = np.sin(θ) * np.cos(φ), np.sin(θ) * np.sin(φ), np.cos(θ)
        ax.plot_wireframe(*ball, **style.GRID)
        ax.set_aspect("equal")


def _history(motion: Motion, name: str | None, ax: Axes) -> Axes:
    known = [c.name for c in motion.solution.system.coordinates]
    if name is not None and name not in known:
        raise InvalidInputError(f'plot: "{name}" is not a coordinate; they are {", ".join(known)}')
    chosen = name or (motion.solution.coordinates or known)[0]
    trace = orbit_paths.trace(motion)
    keep = orbit_paths.few_cycles(motion, trace.t)
    ax.plot(trace.t[keep], np.asarray(trace.state.unwrapped(chosen), float)[keep], **style.MOTION)
    ax.set_xlabel(style.mathematics(orbit_paths.time_box(motion)))
    ax.set_ylabel(style.mathematics(name_box(chosen)))
    return ax


# ------------------------------------------------------------------------------------------------ one coordinate
def _potential(motion: Motion, well: EffectivePotential, ax: Axes) -> Axes:
    several = len(motion.solution.coordinates) > 1
    plain = bool(sp.expand(well.formula - motion.solution.system.potential) == 0)
    q = portrait.window_places(well)
    V = well.potential(q)
    low, high = levels_shown(well, q, V)
    for begin, end in spans_covered(well):
        inside = np.linspace(begin, end, 400)
        bottom = well.potential(inside)
        bottom = np.where(np.isfinite(bottom), np.minimum(bottom, well.level), well.level)
        ax.fill_between(inside, bottom, well.level, **style.AREA)
        ax.plot([begin, end], [well.level] * 2, **style.MOTION)
    ax.plot(q, np.where(np.isfinite(V), V, np.nan), **style.CURVE)
    for level, _ in portrait.hills(well):
        if low < level < high:
            ax.plot(well.window, [level] * 2, **style.EDGE)
    ax.plot(well.window, [well.level] * 2, **style.ENERGY)
    ends = [end for end in well.ends if end is not None]
    ax.plot(ends, [well.level] * len(ends), **style.DOT)
    ax.annotate(
        style.mathematics(level_box(well)), (well.window[1], well.level), (-3, 4), textcoords="offset points",
        ha="right", color=style.RED, fontsize=12,
    )  # fmt: skip
    ax.set_ylim(low, high)
    return _labelled(ax, well, style.mathematics(potential_name(well, several=several, plain=plain)))


def _phase(motion: Motion, well: EffectivePotential, ax: Axes) -> Axes:  # noqa: ARG001 - as the others
    own = own_loops(well)
    others = [loop for level in portrait.levels(well) for loop in loops_at(well, level)]
    for loop in others:
        ax.plot(*loop, **style.LEVEL)
    for level, _ in portrait.hills(well):
        for loop in loops_at(well, level):
            ax.plot(*loop, **style.EDGE)
    for q, p in own:
        if well.kind == "libration":
            ax.fill(q, p, **style.AREA)
        ax.plot(q, p, **style.MOTION)
    if well.kind == "equilibrium":
        ax.plot([well.place], [-float(well.shift(well.place))], **style.DOT)
    ax.set_ylim(*momenta_shown(well, own, others))
    return _labelled(ax, well, style.mathematics(name_box(f"p_{well.name}")))


def _labelled(ax: Axes, well: EffectivePotential, upright: str) -> Axes:
    ax.set_xlim(*well.window)
    ax.set_xlabel(style.mathematics(name_box(well.name)))
    ax.set_ylabel(upright)
    if is_angle(well) and well.window[1] - well.window[0] > 3:
        halves = np.arange(np.ceil(2 * well.window[0] / np.pi), np.floor(2 * well.window[1] / np.pi) + 1)
        ax.set_xticks(np.asarray(halves * np.pi / 2), [_of_pi(int(n)) for n in halves])
    return ax


def _of_pi(halves: int) -> str:
    sign, size = ("−" if halves < 0 else ""), abs(halves)
    if size % 2:
        return f"{sign}{'' if size == 1 else size}π/2"
    return "0" if not size else f"{sign}{'' if size == 2 else size // 2}π"
