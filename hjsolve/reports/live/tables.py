"""What a live report computes beforehand: the time law and the orbit as series, their coefficients as polynomials.

A libration between a and b has q = (a + b)/2 − h cos χ, h = (b − a)/2, and P = h sin χ √R with
R(χ) = P²/((q − a)(b − q)) even and periodic, so that t = ∫ ½ ∂P²/∂E dq/P and every ignorable coordinate are a multiple
of χ and a short sine series (``one_coordinate.anomaly``). Ends and coefficients are smooth functions of the constants
inside a region of one kind of motion: Chebyshev's polynomials of one or two constants hold them, as many as are needed.
The bound that the page shows is measured against motions of the engine and against other points of the range, and
doubled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.tape import Tape
from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.energy_momentum_map import coordinate_kinds
from hjsolve.errors import InvalidInputError, NotConvergedError
from hjsolve.lowering import lower
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.svg import Array

_SIZES = (6, 9, 13, 18, 24)
_NODES, _TERMS, _DROPPED = 96, 48, 1e-9
_GOOD, _COARSE = 1e-5, 1e-2
_FIRST = (0.01, 0.003, 0.001)
_GROWTH, _ROOM, _WIDEST = 1.3, 1.15, 0.6
_CHECKS, _TIMES, _MOTIONS = 24, 33, 4


@dataclass(frozen=True)
class SliderRange:
    """The range of one constant.

    Attributes:
        name: of the constant.
        low, high: the ends.
        value: of the motion.
    """

    name: str
    low: float
    high: float
    value: float


@dataclass(frozen=True)
class LiveTables:
    """Everything the page computes with.

    Attributes:
        coordinate: the one that librates.
        angles: the ignorable coordinates.
        sliders: one or two.
        columns: quantity → coefficients of Chebyshev's polynomials, shape (Kx, Ky): ``a``, ``b``, ``t.0`` the mean of
            dt/dχ, ``t.k`` its cosine coefficients, ``<name>.k`` those of an ignorable coordinate, ``root.k`` of √R.
        bounds: coordinate, ``p_`` coordinate → how far the page may be from ``Solution.motion`` during two cycles.
    """

    coordinate: str
    angles: tuple[str, ...]
    sliders: tuple[SliderRange, ...]
    columns: Mapping[str, Array]
    bounds: Mapping[str, float]


def live_tables(motion: Motion) -> LiveTables:
    """Compute the tables of a motion's neighbours.

    Args:
        motion: the one that the page begins with.

    Raises:
        InvalidInputError: the motion has more than one separated coordinate, or its coordinate does not librate.
        NotConvergedError: the tables stay too coarse.
    """
    own, names = _subject(motion)
    point = [float(sp.N(motion.initial.constants[name], 20)) for name in names]
    sliders = _ranges(own, names, point)
    quadrature = _Quadrature(motion, own, len(names))
    for size in _SIZES:
        columns = _fitted(quadrature, sliders, size)
        bounds = _bounds(motion, quadrature, sliders, columns, 0)
        if max(bounds[n] / quadrature.sizes[n] for n in bounds) <= _GOOD or size == _SIZES[-1]:
            break
    bounds = _bounds(motion, quadrature, sliders, columns, _MOTIONS)
    if max(bounds[n] / quadrature.sizes[n] for n in bounds) > _COARSE:
        raise NotConvergedError("live: the tables of this motion stay too coarse; report it without live=True")
    return LiveTables(own.name, quadrature.angles, sliders, _short(columns), bounds)


def _subject(motion: Motion) -> tuple[CoordinateKinds, tuple[str, ...]]:
    solution = motion.solution
    if len(solution.coordinates) != 1 or motion.kinds[solution.coordinates[0]] != "libration":
        raise InvalidInputError(
            "live: the motion needs one separated coordinate, which librates; every other report is written without "
            "live=True"
        )
    name = solution.coordinates[0]
    if solution.shift[name] != 0:
        raise InvalidInputError("live: T has terms linear in the velocities; write this report without live=True")
    momenta = [n for n in solution.constants if n.startswith("p_")]
    angles = [f"p_{c.name}" for c in solution.system.coordinates if c.domain.kind == "angle"]
    likely = [n for n in (*angles[::-1], *momenta) if n in momenta]
    names = (likely[0], "E") if likely else ("E",)
    values: dict[sp.Symbol, sp.Expr] = {p.symbol: motion.initial.values[p.symbol] for p in solution.system.parameters}
    values |= {c.symbol: motion.initial.constants[n] for n, c in solution.constants.items() if n not in names}
    x = solution.constants[names[0]].symbol if len(names) == 2 else sp.Dummy("x", real=True)
    places = {name: motion.initial.values[solution.system.coordinate(name).symbol]}
    own = coordinate_kinds(solution, name, values, (x, solution.constants["E"].symbol), places)
    if own.polynomial is None:
        raise InvalidInputError("live: P² is no polynomial in a known variable; write this report without live=True")
    return own, names


# ------------------------------------------------------------------------------------------------ ranges of the sliders
def _ranges(own: CoordinateKinds, names: Sequence[str], point: Sequence[float]) -> tuple[SliderRange, ...]:
    """Ranges round the motion within which the kinds of motion stay the same: grown side by side."""
    kind = own.at(*_arrays(point)).kinds[0]
    scale = [abs(v) or 1.0 for v in point]
    starts = ([[first] * 2 for _ in point] for first in _FIRST)
    reach = next((start for start in starts if _all_alike(own, kind, point, scale, start)), None)
    if reach is None:
        raise InvalidInputError("live: this motion is too near to one of another kind for sliders beside it")
    growing = [(k, side) for k in range(len(point)) for side in (0, 1)]
    while growing:
        for k, side in tuple(growing):
            before = reach[k][side]
            reach[k][side] = min(_GROWTH * before, _WIDEST)
            if not _all_alike(own, kind, point, scale, reach):
                reach[k][side] = before
                growing.remove((k, side))
            elif reach[k][side] == _WIDEST:
                growing.remove((k, side))
    return tuple(
        SliderRange(n, v - r[0] * s, v + r[1] * s, v) for n, v, r, s in zip(names, point, reach, scale, strict=True)
    )


def _all_alike(
    own: CoordinateKinds, kind: tuple[str, ...], point: Sequence[float], scale: Sequence[float],
    reach: Sequence[Sequence[float]],
) -> bool:  # fmt: skip
    """Whether the kinds are the same in the ranges, and a little beyond them."""
    ends = [(v - _ROOM * r[0] * s, v + _ROOM * r[1] * s) for v, r, s in zip(point, reach, scale, strict=True)]
    grids = np.meshgrid(*(np.linspace(low, high, 12) for low, high in ends))
    return all(found == kind for found in own.at(*_arrays([g.ravel() for g in grids])).kinds)


def _arrays(values: Sequence[Any]) -> tuple[Array, Array]:
    y = np.atleast_1d(np.asarray(values[-1], float))
    return (np.atleast_1d(np.asarray(values[0], float)) if len(values) == 2 else np.zeros_like(y)), y


# ------------------------------------------------------------------------------------------------ the quadrature
class _Quadrature:
    """Turning points and series of the librations at many points."""

    def __init__(self, motion: Motion, own: CoordinateKinds, sliders: int):
        solution, self.own, self.motion = motion.solution, own, motion
        self.sliders = sliders
        self.angles = tuple(c.name for c in solution.system.coordinates if c.name != own.name)
        F = solution.momentum_squared[own.name]
        symbols = [solution.constants["E"].symbol, *(solution.system.coordinate(n).momentum for n in self.angles)]
        signs = [1, *(-1 for _ in self.angles)]
        self.known = dict(own.values)
        inputs = [solution.system.coordinate(own.name).symbol, *own.constants, *self.known]
        self.tape: Tape = lower([F, *(s * sp.diff(F, c) / 2 for s, c in zip(signs, symbols))], inputs)
        self.place = float(sp.N(own.place, 20))
        state = motion.at(np.linspace(0, float(motion.periods[own.name].value), 65))
        self.sizes = {own.name: float(np.ptp(np.asarray(state.q[own.name], float))), f"p_{own.name}": float(
            np.ptp(np.asarray(state.p[own.name], float)))} | dict.fromkeys(self.angles, 1.0)  # fmt: skip

    def series(self, x: Array, y: Array) -> dict[str, Array]:
        """Return a, b and the cosine coefficients of dt/dχ, dφ/dχ, √R, each of shape (m,)."""
        a, b = self._ends(x, y)
        χ = np.pi * (np.arange(_NODES) + 0.5) / _NODES
        m, h = (a + b) / 2, (b - a) / 2
        q = m[:, None] - h[:, None] * np.cos(χ)
        numbers = [float(sp.N(v, 30)) for v in self.known.values()]
        with np.errstate(all="ignore"):
            square, *kernels = (
                np.broadcast_to(np.asarray(v, float), q.shape)
                for v in self.tape.run(Float64(), [q, x[:, None], y[:, None], *numbers])
            )
            root = np.sqrt(square) / (h[:, None] * np.sin(χ))
        found: dict[str, Array] = {"a": a, "b": b}
        waves = np.cos(np.outer(np.arange(_TERMS), χ)) * (2 / _NODES)
        waves[0] /= 2
        for name, values in zip(("t", *self.angles, "root"), (*(k / root for k in kernels), root)):
            for k, column in enumerate((values @ waves.T).T):
                found[f"{name}.{k}"] = column
        return found

    def _ends(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Turning points of the well the motion is in."""
        found = self.own.at(x, y, every=False)
        a, b = found.well_round(self.place)
        if not (np.isfinite(a) & np.isfinite(b)).all():
            raise NotConvergedError("live: a turning point in the range of the sliders could not be had")
        return a, b


def _nodes(size: int) -> Array:
    return np.cos(np.pi * (np.arange(size) + 0.5) / size)


def _fitted(quadrature: _Quadrature, sliders: Sequence[SliderRange], size: int) -> dict[str, Array]:
    """Interpolate every quantity at Chebyshev's points of the ranges."""
    u = _nodes(size)
    places = [(s.low + s.high) / 2 + (s.high - s.low) / 2 * u for s in sliders]
    grid = np.meshgrid(*places, indexing="ij")
    found = quadrature.series(*_arrays([g.ravel() for g in grid]))
    transform = np.cos(np.outer(np.arange(size), np.pi * (np.arange(size) + 0.5) / size)) * (2 / size)
    transform[0] /= 2
    shape = (size,) * len(sliders)
    if len(sliders) == 1:
        return {name: (transform @ values.reshape(shape))[None, :] for name, values in found.items()}
    return {name: transform @ values.reshape(shape) @ transform.T for name, values in found.items()}


def evaluated_as_the_page_does(
    columns: Mapping[str, Array], sliders: Sequence[SliderRange], values: Sequence[float]
) -> dict[str, float]:
    """Evaluate the tables at a setting of the sliders, as the page does.

    Args:
        columns: of ``LiveTables``.
        sliders: of ``LiveTables``.
        values: one a slider.
    """
    u = [(2 * v - s.low - s.high) / (s.high - s.low) for s, v in zip(sliders, values)]
    u = [0.0, *u] if len(u) == 1 else u
    T = [np.cos(np.arange(max(c.shape[k] for c in columns.values())) * np.arccos(np.clip(u[k], -1, 1))) for k in (0, 1)]
    return {name: float(T[0][: c.shape[0]] @ c @ T[1][: c.shape[1]]) for name, c in columns.items()}


def state_from(series: Mapping[str, float], names: Sequence[str], coordinate: str, t: Array) -> dict[str, Array]:
    """Return q, p and the gains of the ignorable coordinates at times from the lower turning point.

    Args:
        series: a, b and coefficients at one point.
        names: of the ignorable coordinates.
        coordinate: the one that librates.
        t: times, shape (n,).
    """
    kinds = ("t", *names, "root")
    c = {name: np.array([series.get(f"{name}.{k}", 0.0) for k in range(_TERMS)]) for name in kinds}
    χ = t / c["t"][0]
    for _ in range(60):
        k = np.arange(1, len(c["t"]))
        value = c["t"][0] * χ + np.sin(np.outer(χ, k)) @ (c["t"][1:] / k)
        slope = c["t"][0] + np.cos(np.outer(χ, k)) @ c["t"][1:]
        χ = χ - np.clip((value - t) / slope, -0.5, 0.5)
    m, h = (series["a"] + series["b"]) / 2, (series["b"] - series["a"]) / 2
    root = np.cos(np.outer(χ, np.arange(len(c["root"])))) @ c["root"]
    found = {coordinate: m - h * np.cos(χ), f"p_{coordinate}": h * np.sin(χ) * root}
    for name in names:
        k = np.arange(1, len(c[name]))
        found[name] = c[name][0] * χ + np.sin(np.outer(χ, k)) @ (c[name][1:] / k)
    return found


# ------------------------------------------------------------------------------------------------ the bound
def _bounds(
    motion: Motion, quadrature: _Quadrature, sliders: Sequence[SliderRange], columns: Mapping[str, Array], motions: int
) -> dict[str, float]:
    """Twice the largest difference seen, of what the page shows in two cycles; from so many motions of the engine."""
    own, short = quadrature.own.name, _short(columns)
    rng = np.random.default_rng(12345)
    corners = np.array(np.meshgrid(*([0, 1] for _ in sliders))).reshape(len(sliders), -1).T
    shares = [*rng.random((_CHECKS, len(sliders))), *corners]
    points = [[s.low + (s.high - s.low) * u for s, u in zip(sliders, row)] for row in shares]
    exact = quadrature.series(*_arrays([np.array(v) for v in zip(*points)]))
    worst: dict[str, float] = {}
    for i, values in enumerate(points):
        series = {name: float(column[i]) for name, column in exact.items()}
        t = np.linspace(0, 4 * np.pi * series["t.0"], _TIMES)
        shown = state_from(evaluated_as_the_page_does(short, sliders, values), quadrature.angles, own, t)
        true = state_from(series, quadrature.angles, own, t)
        if i < motions:
            true = _by_the_engine(motion, sliders, values, series, t)
        for name, column in shown.items():
            worst[name] = max(worst.get(name, 0.0), float(np.abs(column - true[name]).max()))
    return {name: 2 * value + 1e-12 * quadrature.sizes[name] for name, value in worst.items()}


def _by_the_engine(
    motion: Motion, sliders: Sequence[SliderRange], values: Sequence[float], series: Mapping[str, float], t: Array
) -> dict[str, Array]:
    """The same motion as ``Solution.motion`` has it, from its lower turning point on."""
    solution, name = motion.solution, motion.solution.coordinates[0]
    constants = {**motion.initial.constants, **{s.name: float(v) for s, v in zip(sliders, values)}}
    parameters = {p.name: motion.initial.values[p.symbol] for p in solution.system.parameters}
    q = {c.name: 0 for c in solution.system.coordinates} | {name: (series["a"] + series["b"]) / 2}
    begun = solution.motion(q=q, constants=constants, signs={name: 1}, parameters=parameters)
    angles = [c.name for c in solution.system.coordinates if c.name != name]
    here = _at_the_middle(series, angles)
    state = begun.at(t - here["t"])
    found = {name: np.asarray(state.q[name], float), f"p_{name}": np.asarray(state.p[name], float)}
    return found | {n: np.asarray(state.unwrapped(n), float) + here[n] for n in angles}


def _at_the_middle(series: Mapping[str, float], angles: Sequence[str]) -> dict[str, float]:
    """The time and the gains of the ignorable coordinates from the lower turning point to χ = π/2."""
    k = np.arange(1, _TERMS)
    waves = np.sin(k * np.pi / 2) / k
    terms = {n: np.array([series[f"{n}.{i}"] for i in k]) for n in ("t", *angles)}
    return {n: series[f"{n}.0"] * np.pi / 2 + float(waves @ column) for n, column in terms.items()}


def _short(columns: Mapping[str, Array]) -> dict[str, Array]:
    """The same without coefficients that are too small to be seen."""
    size = {name.partition(".")[0]: 0.0 for name in columns}
    for name, column in columns.items():
        kind = name.partition(".")[0]
        size[kind] = max(size[kind], float(np.abs(column).max()))
    kept = {}
    for name, column in columns.items():
        small = np.abs(column) < _DROPPED * size[name.partition(".")[0]]
        if small.all() and not name.endswith(".0") and name not in ("a", "b"):
            continue
        rows = int(np.flatnonzero(~small.all(axis=1)).max(initial=0)) + 1
        across = int(np.flatnonzero(~small.all(axis=0)).max(initial=0)) + 1
        kept[name] = column[:rows, :across]
    return kept
