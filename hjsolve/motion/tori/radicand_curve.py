"""p²(q; κ) of one coordinate in doubles, on samples of its domain: approximate actions, and their derivatives.

J = (1/π) ∫ p dq and ∂J/∂κⱼ = (1/π) ∫ (½ ∂p²/∂κⱼ)/p dq over a libration, by the midpoint rule in the anomaly
(Gauss–Chebyshev); over a rotation the means over a turn. At a maximum of p² that is zero or less, and where J is to be
zero, the libration is replaced by the harmonic one about the maximum: J = p²ₘₐₓ/√(−2 (p²)″). This continues J
analytically to negative values, so Newton's method may pass through J = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.arithmetic.root_finding import stationary
from hjsolve.arithmetic.tape import Tape
from hjsolve.lowering import momentum_squared_tapes, with_plain_exponents
from hjsolve.motion.initial_data import domain_ends, to_bits
from hjsolve.motion.tori.lengths import natural_length
from hjsolve.motion.winding import radians_of_a_unit
from hjsolve.solution.quadratures import Solution

_NODES = 64  # of the midpoint rule for an action that is a first guess
_REACH = np.concatenate([1e-13 * 1.3 ** np.arange(115), 2.0 ** np.arange(0, 100)])
"""Distances, relative to the natural length, at which p² is looked at on both sides of a maximum."""
_SMALL = 1e-10
"""Square of the relative amplitude below which a libration is taken for harmonic."""
_DEEP = 0.5
"""The part of the greatest p² so far below which a dip between samples may be a barrier: these lie 30 % apart."""
_ROUNDS, _TRIED = 4, 256
"""Rounds of bracketing a turning point, and samples of each; the last bracket is interpolated."""


@dataclass(frozen=True)
class RadicandCurve:
    """p² of one separated coordinate and its kernels.

    Attributes:
        name: of the coordinate.
        squared: tape of p²; inputs q, constants, parameters.
        kernels: tape of ½ ∂p²/∂κⱼ.
        parameters: values of the parameters, exact, and
        numbers: rounded.
        lower, upper: ends of the domain; infinite where there are none.
        turn: period of p² along q where the coordinate is an angle or a line along which p² repeats itself; else 0.
        walls: whether the lower and the upper end of the domain throw the coordinate back.
        length: on which p² bends along a line, a power of two: about 1e-10 for an atom in metres.
    """

    name: str
    squared: Tape
    kernels: Tape
    parameters: tuple[sp.Expr, ...]
    numbers: tuple[float, ...]
    lower: float
    upper: float
    turn: float
    walls: tuple[bool, bool] = (False, False)
    length: float = 1.0

    def value(self, q: Reals, κ: Reals) -> Reals:
        """Return p² at places, NaN where the formula has no real value.

        Args:
            q: places, shape (m,) or (s, m).
            κ: constants, shape (k,), or (k, s, 1) for as many sets of them.
        """
        with np.errstate(all="ignore"):
            found = self.squared.run(Float64(), [q, *κ, *self.numbers])[0]
        return np.broadcast_to(found, np.broadcast_shapes(np.shape(q), np.shape(κ)[1:]))

    def weights(self, q: Reals, κ: Reals) -> Reals:
        """Return ½ ∂p²/∂κⱼ at places, shape (k, m).

        Args:
            q: places, shape (m,).
            κ: constants, shape (k,).
        """
        with np.errstate(all="ignore"):
            rows = self.kernels.run(Float64(), [q, *κ, *self.numbers])
        return np.stack([np.broadcast_to(row, np.shape(q)) for row in rows])

    def bend(self, q: float, κ: Reals) -> tuple[float, float, float]:
        """Return p² and its first two derivatives at one place.

        Args:
            κ: constants, shape (k,).
        """
        known = [Jet(np.float64(x)) for x in (*κ, *self.numbers)]
        with np.errstate(all="ignore"):
            jet = self.squared.run(Jets(Float64()), [Jet(np.float64(q), np.float64(1.0)), *known])[0]
        value, slope, bend = (0.0 if part is None else float(part) for part in jet)
        return value, slope, bend

    def exactly(self, q: Mpf, κ: list[Mpf], bits: int) -> tuple[Mpf, Mpf, Mpf]:
        """Return p² and its first two derivatives in many digits.

        Args:
            κ: constants.
        """
        arithmetic = Multi(bits)
        known = [Jet(arithmetic.convert(x)) for x in κ] + [Jet(to_bits(x)(bits)) for x in self.parameters]
        jet = self.squared.run(Jets(arithmetic), [Jet(arithmetic.convert(q), arithmetic.rational(1, 1)), *known])[0]
        zero = arithmetic.rational(0, 1)
        value, slope, bend = (zero if part is None else part for part in jet)
        return value, slope, bend

    def samples(self) -> Reals:
        """Return places that show the domain at all scales, ascending."""
        if self.turn:
            return np.linspace(-self.turn, self.turn, 193)
        far = np.arange(-320.0, 321.0, 4.0)
        scales = np.unique(2.0 ** np.concatenate([np.linspace(-50, 60, 111), np.linspace(-6, 6, 97), far]))
        if np.isfinite(self.lower) and np.isfinite(self.upper):
            near = 1 / (1 + 2.0 ** np.linspace(-16, 16, 65))
            return self.lower + (self.upper - self.lower) * np.unique(
                np.concatenate([near, np.linspace(0, 1, 33)[1:-1]])
            )
        if np.isfinite(self.lower):
            return self.lower + scales
        if np.isfinite(self.upper):
            return self.upper - scales[::-1]
        # a line has no end next to which zeros crowd: fewer scales do
        half = np.unique(2.0 ** np.concatenate([np.linspace(-20, 30, 51), np.linspace(-5, 5, 61)]))
        return self.length * np.concatenate([-half[::-1], [0.0], half])


@dataclass(frozen=True)
class Cycle:
    """The approximate cycle of one coordinate for some constants.

    Attributes:
        kind: libration, rotation or equilibrium (the harmonic limit of a libration).
        low, high: turning points; the turn of a rotation.
        top: a place inside.
        action: J, without a sign; below zero where p² < 0 everywhere near the maximum.
        slopes: ∂J/∂κⱼ, shape (k,).
    """

    kind: str
    low: float
    high: float
    top: float
    action: float
    slopes: Reals


def curves_of(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], walls: Mapping[str, tuple[bool, bool]],
    action: float | None = None,
) -> list[RadicandCurve]:  # fmt: skip
    """Make the curves of all separated coordinates.

    Args:
        values: symbol of a parameter → exact number.
        walls: coordinate → which ends of its domain throw it back; none where left out.
        action: of the motions that are looked for, roughly, > 0; None where it is not known.
    """
    constants = tuple(c.symbol for c in solution.constants.values())
    parameters = tuple(p.symbol for p in solution.system.parameters)
    result = []
    for name in solution.coordinates:
        coordinate = solution.system.coordinate(name)
        F = with_plain_exponents(solution.momentum_squared[name], values)
        squared, kernels, _, periodic = momentum_squared_tapes(F, coordinate.symbol, constants, parameters)
        low, high = domain_ends(solution.system, name, values)
        ends = [
            infinite if end is None else float(to_bits(end)(64)) for end, infinite in ((low, -np.inf), (high, np.inf))
        ]
        turn = 0.0
        if coordinate.domain.kind == "angle":
            turn = 2 * np.pi if periodic else 0.0
        elif coordinate.domain.kind == "line":
            rate = radians_of_a_unit(F, coordinate.symbol, values)
            turn = 0.0 if rate is None else 2 * np.pi / float(to_bits(rate)(64))
        exact = tuple(values[p] for p in parameters)
        numbers = tuple(float(to_bits(x)(64)) for x in exact)
        hard = walls.get(name, (False, False))
        on_a_line = not turn and not np.isfinite(ends).any()
        length = natural_length((squared, kernels), exact, len(constants), action) if on_a_line else 1.0
        result.append(RadicandCurve(name, squared, kernels, exact, numbers, ends[0], ends[1], turn, hard, length))
    return result


def cycle_near(
    curve: RadicandCurve, κ: Reals, low: float, high: float, *, harmonic: bool, start: float | None = None
) -> Cycle | None:
    """Return the cycle about the maximum of p² next to an interval; None where the coordinate does not come back.

    Args:
        κ: constants, shape (k,).
        low, high: where the cycle was for other constants.
        harmonic: whether J is to be zero.
        start: place from where the maximum lies uphill; None for the highest of the interval.
    """
    # not the interval itself: after a step of Newton's method the well has moved
    top = place_of_maximum(curve, κ, low, high, start)
    value = float(curve.value(np.array([top]), κ)[0])
    if harmonic or not value > 0 or _is_small(curve, κ, top):
        return _harmonic(curve, κ, top)
    if curve.turn:
        # p² is periodic: equal steps converge geometrically, and p > 0 all round says that it rotates
        q = top + curve.turn * np.arange(4 * _NODES) / (4 * _NODES)
        squared = curve.value(q, κ)
        if np.all(squared > 0):
            p = np.sqrt(squared)
            radian = curve.turn / (2 * np.pi)
            slopes = np.mean(curve.weights(q, κ) / p, axis=1) * radian
            return Cycle("rotation", top, top + curve.turn, top, float(np.mean(p)) * radian, slopes)
    a, b = _turning_point(curve, κ, top, -1), _turning_point(curve, κ, top, 1)
    if a is None or b is None:
        return None
    # q = m − h cos χ: p dq/dχ is smooth and even at both turning points (Gauss and Chebyshev's rule)
    χ = (np.arange(_NODES) + 0.5) * np.pi / _NODES
    half = (b - a) / 2
    q = (a + b) / 2 - half * np.cos(χ)
    p = np.sqrt(np.maximum(curve.value(q, κ), 0))
    speed = half * np.sin(χ)
    with np.errstate(all="ignore"):
        # rounding may make p² ≤ 0 at a node next to a turning point: that node is left out
        slopes = np.mean(curve.weights(q, κ) * (speed / np.where(p > 0, p, np.inf)), axis=1)
    return Cycle("libration", a, b, top, float(np.mean(p * speed)), slopes)


def _is_small(curve: RadicandCurve, κ: Reals, top: float) -> bool:
    """Return whether a libration is so small that the rounding of p² matters more than what is anharmonic."""
    value, _, bend = curve.bend(top, κ)
    length = max(abs(top), curve.turn / (2 * np.pi))
    return bend < 0 and value < _SMALL * -bend * length**2


def _harmonic(curve: RadicandCurve, κ: Reals, top: float) -> Cycle | None:
    value, _, bend = curve.bend(top, κ)
    if not bend < 0:
        return None
    # p² ≈ v − (r q)² with r² = −(p²)″/2: an ellipse of half axes √v and √v/r, J its area over 2π = v/(2r)
    root = np.sqrt(-bend / 2)
    width = np.sqrt(abs(value)) / root
    return Cycle(
        "equilibrium", top - width, top + width, top, value / (2 * root), curve.weights(np.array([top]), κ)[:, 0] / root
    )


def place_of_maximum(curve: RadicandCurve, κ: Reals, low: float, high: float, start: float | None = None) -> float:
    """Return the maximum of p² in an interval, or uphill from there; any place inside where p² has none.

    Uphill only: next to the interval p² may be greater on the flank of another well, whose cycles are another family.
    So may it be in the interval, which may reach over a barrier that there was not for the constants before.

    Args:
        κ: constants, shape (k,).
        low, high: the interval.
        start: place from where the maximum lies uphill; None for the highest.
    """
    low, high = max(low, curve.lower), min(high, curve.upper)  # a harmonic cycle may be wider than the domain
    margin = (high - low) / 2 or 1e-3 * max(abs(low), 1e-3)
    first, last = max(low - margin, (low + curve.lower) / 2), min(high + margin, (high + curve.upper) / 2)
    if curve.turn:
        first, last = max(first, high - curve.turn), min(last, low + curve.turn)
    grid = curve.samples()
    q = np.unique(np.concatenate([np.linspace(first, last, 65), grid[(grid > first) & (grid < last)]]))
    values = curve.value(q, κ)
    if not np.isfinite(values).any():
        return (low + high) / 2
    values = np.where(np.isfinite(values), values, -np.inf)
    within = (q >= low) & (q <= high) & (values > -np.inf)
    best = int(np.argmax(np.where(within, values, -np.inf) if within.any() else values))
    if start is not None:
        nearest = int(np.argmin(np.abs(q - start)))
        best = nearest if values[nearest] > -np.inf else best
    # uphill to the next maximum; the highest sample of all may belong to another well
    for step in (-1, 1):
        while 0 <= best + step < len(q) and values[best + step] > values[best]:
            best += step
    top = float(q[best])
    # Newton's method on (p²)′ must not leave the hill: two samples on either side hold its top
    bottom, ceiling = float(q[max(best - 2, 0)]), float(q[min(best + 2, len(q) - 1)])
    place = stationary(
        lambda q: curve.bend(q, κ), top, lambda bend, q: bend < 0 and bottom <= q <= ceiling,
        lambda q: max(1e-16 * abs(q), 1e-9 * (high - low)), 30,
    )  # fmt: skip
    return top if place is None else place


def _turning_point(curve: RadicandCurve, κ: Reals, top: float, side: int) -> float | None:
    """Return the first zero of p² on one side of a place; None where p² > 0 as far as it was looked."""
    end = curve.upper if side > 0 else curve.lower
    natural = max(abs(top), 1e-3 * curve.length)
    natural = min(natural, abs(end - top)) if np.isfinite(end) else natural
    away = natural * _REACH
    if np.isfinite(end):
        # half the way by multiples, the rest by halves of what is left: zeros crowd at an end that is a pole
        gap = abs(end - top)
        away = np.unique(np.concatenate([away[away < gap / 2], gap * (1 - 2.0 ** -np.arange(1.0, 50.0))]))
    if curve.turn:
        away = np.unique(np.concatenate([away[away < curve.turn], curve.turn * np.arange(1, 129) / 128]))
    values = curve.value(top + side * away, κ)
    first = int(np.argmin(values > 0))
    # a barrier thinner than the samples lies before the first of them that is forbidden
    inside, outside = _thin_barrier(curve, κ, top, side, away, values)
    if outside == np.inf:
        if values[first] > 0:
            return end if curve.walls[side > 0] else None
        inside, outside = (float(away[first - 1]) if first else 0.0), float(away[first])
    for _ in range(_ROUNDS):
        trial = np.linspace(inside, outside, _TRIED + 1)
        values = curve.value(top + side * trial, κ)
        positive = values[1:-1] > 0
        first = int(np.argmin(positive)) if not positive.all() else len(positive)
        inside, outside = float(trial[first]), float(trial[first + 1])
        here, there = float(values[first]), float(values[first + 1])
        if outside - inside <= 1e-14 * abs(top):
            break
    # a chord of the last bracket; its middle where p² has no real value beyond the zero
    ratio = here / (here - there) if here > 0 > there else 0.5
    return top + side * (inside + (outside - inside) * ratio)


def _thin_barrier(
    curve: RadicandCurve, κ: Reals, top: float, side: int, away: Reals, values: Reals
) -> tuple[float, float]:
    """Return distances on either side of the first zero where p² dips below zero between samples of it; else infinite.

    Next to a separatrix the barrier between two wells is thin: samples lie on both sides of it.
    """
    deep = values[1:-1] < _DEEP * np.fmax.accumulate(values)[1:-1]  # next to the top rounding makes dips of its own
    dips = np.flatnonzero(deep & (values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])) + 1
    first = int(np.argmin(values > 0)) if (values <= 0).any() else len(values)
    for dip in dips[dips < first]:
        before, after = float(away[dip - 1]), float(away[dip + 1])
        for _ in range(_ROUNDS):
            trial = np.linspace(before, after, _TRIED + 1)
            seen = curve.value(top + side * trial, κ)
            below = np.flatnonzero(seen <= 0)
            if len(below):
                return float(trial[below[0] - 1]) if below[0] else before, float(trial[below[0]])
            lowest = int(np.argmin(np.where(np.isfinite(seen), seen, np.inf)))
            before, after = float(trial[max(lowest - 1, 0)]), float(trial[min(lowest + 1, _TRIED)])
    return np.inf, np.inf
