"""The neighbours of a motion: turning points and series of every separated coordinate at many values of the sliders.

A libration between a and b has q = (a + b)/2 − h cos χ, h = (b − a)/2, and P = h sin χ √R with
R(χ) = P²/((q − a)(b − q)) even and periodic; a rotation has q = ±χ and P = ±√R, R = P². So ∫ ½ ∂P²/∂κⱼ dq/P, of which
Jacobi's equations consist, are a multiple of χ and a short Fourier series (``one_coordinate.anomaly``). Turning points
are followed by Newton's method from those of the motion: as long as all is of one kind they are smooth functions of
the constants, and where they cease to be, P² between them has another zero or the series get long, which is refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.number_types import Mask
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import InvalidInputError
from hjsolve.lowering import lower, momentum_squared_tapes
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.svg import Array

NODES, WAVES = 96, 48
"""Places in half a turn of a libration, in a turn of a rotation one third more; harmonics kept of each series."""
_STEPS, _NEWTON, _TAIL, _CHUNK = 6, 7, 1e-6, 2048


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

    def series(self, settings: Array) -> tuple[dict[tuple[int, str], Array], Mask]:
        """Return every column of every coordinate.

        Args:
            settings: of the sliders, shape (m, d).

        Returns:
            (position of the coordinate, group) → (m, n): one number for a and b, else cosines 0 … and for a rotation
            sines 1 … after them. And which settings have a motion of the same kind, shape (m,).
        """
        parts = [self._series(settings[k : k + _CHUNK]) for k in range(0, len(settings), _CHUNK)]
        columns = {key: np.concatenate([found[key] for found, _ in parts]) for key in parts[0][0]}
        return columns, np.concatenate([good for _, good in parts])

    def _series(self, settings: Array) -> tuple[dict[tuple[int, str], Array], Mask]:
        good = np.ones(len(settings), dtype=bool)
        found: dict[tuple[int, str], Array] = {}
        with np.errstate(all="ignore"):
            for k, coordinate in enumerate(self.coordinates):
                columns, fine = self._one(coordinate, settings)
                good &= fine
                found |= {(k, group): column for group, column in columns.items()}
        return found, good

    def _inputs(self, settings: Array) -> list[Array | float]:
        place = {name: k for k, name in enumerate(self.sliders)}
        return [
            settings[:, place[n], None] if n in place else float(v) for n, v in zip(self.names, self.base, strict=True)
        ]

    def _one(self, own: LiveCoordinate, settings: Array) -> tuple[dict[str, Array], Mask]:
        inputs = self._inputs(settings)
        if own.direction:
            nodes = NODES * 4 // 3
            χ = 2 * np.pi * np.arange(nodes) / nodes
            q, ends = np.broadcast_to(own.direction * χ, (len(settings), nodes)), {}
            sine2, good = np.ones(nodes), np.ones(len(settings), dtype=bool)
        else:
            χ = np.pi * (np.arange(NODES) + 0.5) / NODES
            a, b, good = self._turning(own, settings)
            ends = {"a": a[:, None], "b": b[:, None]}
            h = (b - a)[:, None] / 2
            q, sine2 = (a + b)[:, None] / 2 - h * np.cos(χ), (h * np.sin(χ)) ** 2
        R = np.asarray(own.square.run(Float64(), [q, *inputs])[0], float) / sine2
        root = np.sqrt(np.broadcast_to(R, q.shape))
        kernels = own.kernels.run(Float64(), [q, *inputs])
        columns = {"root": root} | {str(j): k / root for j, k in enumerate(kernels) if not own.absent[j]}
        found = {group: _waves(np.broadcast_to(v, q.shape), χ, own.direction) for group, v in columns.items()}
        good = good & (R > 0).all(axis=1)
        for column in found.values():
            size = np.abs(column).max(axis=1)
            good &= np.isfinite(size) & (_last(column) <= _TAIL * size)
        return ends | found, good

    def _turning(self, own: LiveCoordinate, settings: Array) -> tuple[Array, Array, Mask]:
        """Follow both turning points from those of the motion, along straight ways to the settings."""
        begin, good = self.value, np.ones(len(settings), dtype=bool)
        found = []
        for end, sign in zip(own.ends, (1, -1), strict=True):
            q = np.full(len(settings), end)
            before = q
            for k in range(1, _STEPS + 1):
                inputs = self._inputs(begin + (settings - begin) * (k / _STEPS))
                q, before = 2 * q - before, q
                for _ in range(_NEWTON):
                    F, slope = (np.asarray(v, float) for v in own.square.run(Float64(), [q[:, None], *inputs]))
                    slope = np.broadcast_to(slope, F.shape)[:, 0]
                    step = np.clip(F[:, 0] / slope, -(own.ends[1] - own.ends[0]) / 4, (own.ends[1] - own.ends[0]) / 4)
                    q = q - step
                good &= (np.abs(step) <= 1e-11 * (own.ends[1] - own.ends[0] + np.abs(q))) & (sign * slope > 0)
            found.append(q)
        return found[0], found[1], good & (found[0] < found[1])


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
        raise InvalidInputError("live: every coordinate is ignorable, nothing but straight lines; leave live=True out")
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
