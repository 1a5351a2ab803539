"""The neighbours of a motion: an ensemble over the sliders' values, and the series of every separated coordinate.

Each setting starts one orbit at the top of P² in the well of the motion, and ``ensemble`` gives its status and turning
points. A libration between a and b has q = (a + b)/2 − h cos χ, h = (b − a)/2, and P = h sin χ √R with
R(χ) = P²/((q − a)(b − q)) even and periodic; a rotation has q = ±χ and P = ±√R, R = P². So ∫ ½ ∂P²/∂κⱼ dq/P, of which
Jacobi's equations consist, are a multiple of χ and a short Fourier series (``one_coordinate.anomaly``). As long as all
is of one kind they are smooth functions of the constants; each setting that is not says why.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Mask
from hjsolve.arithmetic.tape import Tape
from hjsolve.ensembles.orbits import ensemble
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import lower, momentum_squared_tapes
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.svg import Array

Words = NDArray[np.object_]
NODES, WAVES = 96, 48
"""Places in half a turn of a libration, in a turn of a rotation one third more; harmonics kept of each series."""
_TAIL, _CHUNK = 1e-6, 2048
_UPHILL, _FAR = 641, 8.0
SAME, OTHER_KIND, LONG_SERIES = "ok", "another kind", "long series"
"""Words next to those of ``Status``: of the same kind; of another one; its Fourier series need too many terms."""


@dataclass(frozen=True)
class LiveCoordinate:
    """One separated coordinate of the motion that a page begins with.

    Attributes:
        name: of it.
        direction: 0 of a libration, else the sign of P of a rotation.
        ends: turning points of the motion; of a rotation −π and π.
        phase: χ at the start.
        square: P² and ∂P²/∂q.
        kernels: ½ ∂P²/∂κⱼ, one a constant.
        absent: which of these are zero.
    """

    name: str
    direction: int
    ends: tuple[float, float]
    phase: float
    square: Tape
    kernels: Tape
    absent: tuple[bool, ...]


@dataclass(frozen=True)
class Neighbours:
    """Motions with other constants and parameters than the one given, of the same kind.

    Attributes:
        motion: in the coordinates of its solution.
        coordinates: the separated ones.
        ignorable: the others.
        names: of all constants and parameters, in the order of the tapes.
        base: their values in the motion.
        sliders: names of those that change.
    """

    motion: Motion
    coordinates: tuple[LiveCoordinate, ...]
    ignorable: tuple[str, ...]
    names: tuple[str, ...]
    base: Array
    sliders: tuple[str, ...]

    @property
    def value(self) -> Array:
        """Where the sliders stand in the motion."""
        return self.base[[self.names.index(s) for s in self.sliders]]

    def series(self, settings: Array) -> tuple[dict[tuple[int, str], Array], Words]:
        """Return every column of every coordinate.

        Args:
            settings: of the sliders, shape (m, d).

        Returns:
            (position of the coordinate, group) → (m, n): one number for a and b, else cosines 0 … and for a rotation
            sines 1 … after them. And what each setting is, shape (m,): ``ok`` where its motion is of the same kind,
            else the status of its orbit in the ensemble, ``another kind`` or ``long series``.
        """
        parts = [self._series(settings[k : k + _CHUNK]) for k in range(0, len(settings), _CHUNK)]
        columns = {key: np.concatenate([found[key] for found, _ in parts]) for key in parts[0][0]}
        return columns, np.concatenate([words for _, words in parts])

    def _series(self, settings: Array) -> tuple[dict[tuple[int, str], Array], Words]:
        found: dict[tuple[int, str], Array] = {}
        with np.errstate(all="ignore"):
            tops = [self._top(own, settings) for own in self.coordinates]
            turning, words = self._orbits(settings, tops)
            for k, (own, ends) in enumerate(zip(self.coordinates, turning, strict=True)):
                one_well = self._one_well(own, settings, ends)
                words = np.where((words == SAME) & ~one_well, OTHER_KIND, words)
                columns, short = self._one(own, settings, ends)
                words = np.where((words == SAME) & ~short, LONG_SERIES, words)
                found |= {(k, group): column for group, column in columns.items()}
        return found, words

    def _orbits(self, settings: Array, tops: Sequence[tuple[Array, Array]]) -> tuple[list[Array], Words]:
        """Return turning points, shape (2, m) a coordinate, and statuses of an ensemble with one orbit a setting."""
        solution = replace(self.motion.solution, chart=None)
        named = {
            n: np.broadcast_to(v, (len(settings), 1))[:, 0]
            for n, v in zip(self.names, self._inputs(settings), strict=True)
        }
        q: dict[str, Array | float] = dict.fromkeys(self.ignorable, 0.0)
        p = {n: named[f"p_{n}"] for n in self.ignorable}
        for own, (top, square) in zip(self.coordinates, tops, strict=True):
            q[own.name], p[own.name] = top, (own.direction or 1) * np.sqrt(square)
        ends = [np.full((2, len(settings)), np.nan) for _ in self.coordinates]
        words = np.full(len(settings), "forbidden", dtype=object)
        possible = np.all([np.isfinite(square) & (square > 0) for _, square in tops], axis=0)
        parameters = [x.name for x in solution.system.parameters]
        columns = np.array([np.zeros(len(settings)), *(named[n] for n in parameters)])
        groups, which = np.unique(columns[:, possible], axis=1, return_inverse=True)
        for k, values in enumerate(groups.T):
            rows = np.flatnonzero(possible)[np.ravel(which) == k]
            values_here = dict(zip(parameters, values[1:].tolist(), strict=True))
            batch = ensemble(
                solution,
                {n: np.broadcast_to(v, len(settings))[rows] for n, v in q.items()},
                {n: v[rows] for n, v in p.items()},
                want="turning_points", fallback=False, shown=False, parameters=values_here,
            )  # fmt: skip
            words[rows] = batch.status
            for found, own in zip(ends, self.coordinates, strict=True):
                found[:, rows] = [batch.columns[f"turning_points.{own.name}.{end}"] for end in ("lower", "upper")]
        for found, own in zip(ends, self.coordinates, strict=True):
            alike = np.isfinite(found).all(axis=0) if not own.direction else np.isnan(found).all(axis=0)
            words = np.where((words == SAME) & ~alike, OTHER_KIND, words)
        return ends, words

    def _top(self, own: LiveCoordinate, settings: Array) -> tuple[Array, Array]:
        """Return the place at which the orbit of each setting starts, and P² there, shapes (m,).

        It is the top of P² in the well of the motion, reached uphill from that of the motion itself.
        """
        (a, b), grid = own.ends, np.linspace(-_FAR, _FAR, _UPHILL)
        q = (a + b) / 2 + (b - a) / 2 * (grid / _FAR if own.direction else np.sinh(grid))
        if self.motion.solution.system.coordinate(own.name).domain.kind == "angle":
            q = q[np.abs(q - (a + b) / 2) <= np.pi]
        F = np.asarray(own.square.run(Float64(), [q[None, :], *self._inputs(settings)])[0], float)
        F = np.where(np.isfinite(F), np.broadcast_to(F, (len(settings), len(q))), -np.inf)
        here = np.asarray(own.square.run(Float64(), [q, *self.base])[0], float)
        within = (q >= a) & (q <= b) & np.isfinite(here)
        rows = np.arange(len(settings))
        at = np.full(len(settings), int(np.argmax(np.where(within, here, -np.inf))))
        for _ in range(len(q)):
            near = np.clip(at[:, None] + [-1, 0, 1], 0, len(q) - 1)
            onward = near[rows, np.argmax(F[rows[:, None], near], axis=1)]
            if (F[rows, onward] <= F[rows, at]).all():
                break
            at = np.where(F[rows, onward] > F[rows, at], onward, at)
        low, high = (q[np.clip(at + side, 0, len(q) - 1)] for side in (-1, 1))
        return self._finer(own, settings, low, high)

    def _finer(self, own: LiveCoordinate, settings: Array, low: Array, high: Array) -> tuple[Array, Array]:
        """Return the top of P² between two nodes, found again on finer nodes: narrow wells lie between those."""
        rows = np.arange(len(settings))
        for _ in range(3):
            q = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 33)
            F = np.asarray(own.square.run(Float64(), [q, *self._inputs(settings)])[0], float)
            F = np.where(np.isfinite(F), np.broadcast_to(F, q.shape), -np.inf)
            at = np.argmax(F, axis=1)
            low, high = q[rows, np.maximum(at - 1, 0)], q[rows, np.minimum(at + 1, 32)]
        return q[rows, at], F[rows, at]

    def _one_well(self, own: LiveCoordinate, settings: Array, ends: Array) -> Mask:
        """Return where the well of a setting and that of the motion are one: neither parts within both together."""
        if own.direction:
            return np.ones(len(settings), dtype=bool)
        low, high = np.minimum(ends[0], own.ends[0]), np.maximum(ends[1], own.ends[1])
        q = low[:, None] + (high - low)[:, None] * (np.arange(2 * NODES) + 0.5) / (2 * NODES)
        good = np.ones(len(settings), dtype=bool)
        for inputs in (self._inputs(settings), list(self.base)):
            open_ = np.broadcast_to(np.asarray(own.square.run(Float64(), [q, *inputs])[0], float) > 0, q.shape)
            begins = open_[:, :1].astype(int).sum(axis=1) + (open_[:, 1:] & ~open_[:, :-1]).sum(axis=1)
            good &= begins <= 1
        return good

    def _inputs(self, settings: Array) -> list[Array | float]:
        place = {name: k for k, name in enumerate(self.sliders)}
        return [
            settings[:, place[n], None] if n in place else float(v) for n, v in zip(self.names, self.base, strict=True)
        ]

    def _one(self, own: LiveCoordinate, settings: Array, turning: Array) -> tuple[dict[str, Array], Mask]:
        """Return the columns of one coordinate, and where they converge."""
        inputs = self._inputs(settings)
        if own.direction:
            nodes = NODES * 4 // 3
            χ = 2 * np.pi * np.arange(nodes) / nodes
            q, ends = np.broadcast_to(own.direction * χ, (len(settings), nodes)), {}
            sine2 = np.ones(nodes)
        else:
            χ = np.pi * (np.arange(NODES) + 0.5) / NODES
            a, b = turning
            ends = {"a": a[:, None], "b": b[:, None]}
            h = (b - a)[:, None] / 2
            q, sine2 = (a + b)[:, None] / 2 - h * np.cos(χ), (h * np.sin(χ)) ** 2
        R = np.asarray(own.square.run(Float64(), [q, *inputs])[0], float) / sine2
        root = np.sqrt(np.broadcast_to(R, q.shape))
        kernels = own.kernels.run(Float64(), [q, *inputs])
        columns = {"root": root} | {str(j): k / root for j, k in enumerate(kernels) if not own.absent[j]}
        found = {group: _waves(np.broadcast_to(v, q.shape), χ, own.direction) for group, v in columns.items()}
        good: Mask = np.asarray((R > 0).all(axis=1))
        for column in found.values():
            size = np.abs(column).max(axis=1)
            good &= np.isfinite(size) & (_last(column) <= _TAIL * size)
        return ends | found, good


def _waves(values: Array, χ: Array, rotates: int) -> Array:
    """Fourier coefficients from values at the nodes."""
    n = len(χ)
    cosines = np.cos(np.outer(np.arange(WAVES), χ)) * (2 / n)
    cosines[0] /= 2
    if not rotates:
        return np.asarray(values @ cosines.T)
    sines = np.sin(np.outer(np.arange(1, WAVES), χ)) * (2 / n)
    return np.concatenate([values @ cosines.T, values @ sines.T], axis=1)


def _last(column: Array) -> Array:
    """Return the largest of the last coefficients."""
    parts = (column[:, :WAVES], column[:, WAVES:])
    return np.max([np.abs(p[:, -6:]).max(axis=1, initial=0.0) for p in parts], axis=0)


def neighbours_of(motion: Motion, sliders: Sequence[str]) -> Neighbours:
    """Make a motion ready for its neighbours.

    Args:
        motion: in the coordinates of its solution.
        sliders: names of constants and parameters.

    Raises:
        InvalidInputError: a coordinate neither librates nor rotates, or T has terms linear in the velocities.
    """
    solution, system = motion.solution, motion.solution.system
    if not solution.coordinates:
        raise InvalidInputError("live: every coordinate is ignorable, so motions are straight lines; omit live=True")
    for name, kind in ((name, motion.kinds[name]) for name in solution.coordinates):
        if kind not in ("libration", "rotation"):
            raise InvalidInputError(
                f"live: the motion of {name} is of kind {kind}; only motions in which every separated coordinate "
                "librates or rotates have a live report; write this one without live=True"
            )
    if any(solution.shift[name] != 0 for name in solution.coordinates):
        raise InvalidInputError("live: T has terms linear in the velocities; write this report without live=True")
    values = motion.initial.values
    exact = {n: motion.initial.constants[n] for n in solution.constants} | {
        p.name: values[p.symbol] for p in system.parameters
    }
    ignorable = tuple(c.name for c in system.coordinates if c.name not in solution.coordinates)
    return Neighbours(
        motion, tuple(_coordinate(motion, name, values) for name in solution.coordinates), ignorable, tuple(exact),
        np.array([float(sp.N(v, 30)) for v in exact.values()]), tuple(sliders),
    )  # fmt: skip


def _coordinate(motion: Motion, name: str, values: Mapping[sp.Symbol, sp.Expr]) -> LiveCoordinate:
    solution = motion.solution
    coordinate, F = solution.system.coordinate(name), solution.momentum_squared[name]
    constants = tuple(c.symbol for c in solution.constants.values())
    parameters = tuple(p.symbol for p in solution.system.parameters)
    kernels, absent = momentum_squared_tapes(F, coordinate.symbol, constants, parameters)[1:3]
    square = lower([F, sp.diff(F, coordinate.symbol)], [coordinate.symbol, *constants, *parameters])
    q, p = (float(sp.N(values[s], 30)) for s in (coordinate.symbol, coordinate.momentum))
    if motion.kinds[name] == "rotation":
        sign = -1 if p < 0 else 1
        return LiveCoordinate(name, sign, (-np.pi, np.pi), sign * q, square, kernels, absent)
    ends = motion.turning_points[name]
    if ends[0] is None or ends[1] is None:
        raise InvalidInputError(f"live: {name} does not turn at both ends; write this report without live=True")
    a, b = float(ends[0].value), float(ends[1].value)
    turns = 2 * np.pi * np.round((q - (a + b) / 2) / (2 * np.pi)) if coordinate.domain.kind == "angle" else 0.0
    phase = float(np.arccos(np.clip((a + b - 2 * (q - turns)) / (b - a), -1, 1)))
    return LiveCoordinate(name, 0, (a, b), -phase if p < 0 else phase, square, kernels, absent)
