"""When a free motion has a coordinate at a place: once and for all, to be used at every bounce.

A coordinate with a clock of its own passes a place at times first + k·period (twice a period if it turns), or at one or
two times if it does not come back. An ignorable coordinate that one other carries, φ = φ₀ − [G(χ) − G(χ₀)], is a
monotone function of that one's phase χ, solved for by Newton's method; one at a constant rate needs nothing.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import newton
from hjsolve.errors import NotConvergedError, OutsideMotionError, required
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.positions import constant_index
from hjsolve.one_coordinate.clenshaw import Fixed
from hjsolve.scenes.crossing import bits_of, sharpened

_GRID, _MOST_STEPS = 513, 12


@dataclass(frozen=True, eq=False)
class Passes:
    """The times, from its start on, at which a free motion has a coordinate at a place.

    Attributes:
        times: all of one period, or all there are.
        period: None where the coordinate does not come back.
        error: a bound for each of the times, and for the period.
    """

    times: tuple[Mpf, ...]
    period: Mpf | None
    error: Mpf | int

    def beside(self, time: Mpf, direction: int, tolerance: Mpf) -> tuple[Mpf, int, int] | None:
        """Return the next one in a direction (1 later, −1 earlier), its index in ``times`` and the periods added to it.

        Args:
            time: where the search begins.
            direction: 1 for later, −1 for earlier.
            tolerance: passages no farther than this from ``time`` do not count.
        """
        best: tuple[Mpf, int, int] | None = None
        for index, first in enumerate(self.times):
            turns, there = 0, first
            if self.period is not None:
                away = direction * (time - first) + tolerance
                turns = direction * (int(away.context.floor(away / self.period)) + 1)
                there = first + turns * self.period
            if direction * (there - time) > tolerance and (best is None or direction * (there - best[0]) < 0):
                best = there, index, turns
        return best


def passes(motion: Motion, name: str, value: sp.Expr) -> Passes:
    """Find all passages of a separated coordinate through a place.

    A place that is only touched, at a turning point, is not passed.

    Args:
        motion: free, with many digits, started at t₀ = 0.
        name: of the coordinate, which has a clock of its own.
        value: the place, exact.

    Raises:
        NotConvergedError: a passage that could not be sharpened to the digits of the motion.
    """
    kind = motion.kinds[name]
    count = {"libration": 3, "rotation": 2}.get(kind)
    if count is not None:
        found = [one for k in range(count) if (one := _passage(motion, name, value, k)) is not None]
        if len(found) < count:
            return Passes((), None, 0)
        (*times, last), error = [t for t, _ in found], max(e for _, e in found)
        period = last - times[0]
        if len(times) == 2 and min(times[1] - times[0], last - times[1]) <= _tolerance(motion, last):
            return Passes((), None, 0)
        return Passes(tuple(times), period, 2 * error)
    there = [one for k in (-2, -1, 0, 1) if (one := _passage(motion, name, value, k)) is not None]
    several = sorted(there, key=lambda one: one[0])
    if any(b[0] - a[0] <= _tolerance(motion, b[0]) for a, b in itertools.pairwise(several)):
        return Passes((), None, 0)
    return Passes(tuple(t for t, _ in several), None, max((e for _, e in several), default=0))


def _tolerance(motion: Motion, time: Mpf) -> Mpf:
    return multiprecision(64).mpf(10) ** (8 - motion.digits) * max(1, abs(time))


def _passage(motion: Motion, name: str, value: sp.Expr, passage: int) -> tuple[Mpf, Mpf] | None:
    try:
        estimate = motion.time_at(name, value, passage)
    except OutsideMotionError:
        return None
    time = multiprecision(bits_of(motion.digits)).convert(estimate.value)
    tolerance = _tolerance(motion, time) / 1000
    if abs(estimate.error) <= tolerance:
        return time, abs(estimate.error)
    return sharpened(motion, name, value, time), tolerance


class Carried:
    """An ignorable coordinate as a function of the phase of the one that carries it.

    Args:
        motion: free, with many digits, started at t₀ = 0; all its coordinates are bounded.
        name: of the ignorable coordinate.
        carrier: of the separated one, which turns or goes round.
    """

    def __init__(self, motion: Motion, name: str, carrier: str):
        coordinate_motion = required(motion.separated.located[carrier].coordinate_motion.cycle)
        equations = required(motion.separated.torus)
        j, k = constant_index(motion.separated, name), list(motion.solution.coordinates).index(carrier)
        self.digits, self.context = motion.digits, multiprecision(bits_of(motion.digits) + 64)
        bits, convert = self.context.prec, self.context.convert
        self.begin = to_bits(motion.initial.values[motion.solution.system.coordinate(name).symbol])(bits)
        self.rate, self.start = convert(equations.rates[k]), convert(equations.starts[k])
        self.kernel, self.clock = Fixed(coordinate_motion.kernels[j], bits), Fixed(equations.oscillations[k][k], bits)
        self.mean, self.turn = (
            convert(coordinate_motion.growth(j)),
            -2 * self.context.pi * convert(coordinate_motion.growth(j)),
        )
        self.origin = self._integral(convert(coordinate_motion.start))
        self.noise = self.context.mpf(10) ** -motion.digits * (4 + self.clock.size * _GRID) / abs(self.rate)
        phases = [coordinate_motion.start + 2 * self.context.pi * n / (_GRID - 1) for n in range(_GRID)]
        self.phases = np.array([float(x) for x in phases])
        self.grid = np.array([float(self.angle(x) - self.begin) for x in phases])
        self.times = np.array([float(self.time_of(x)) for x in phases])
        steps = np.diff(self.grid)
        self.monotone = bool(np.all(steps > 0) or np.all(steps < 0))

    def _integral(self, χ: Mpf) -> Mpf:
        return self.mean * χ + self.kernel.oscillation(χ)

    def angle(self, χ: Mpf) -> Mpf:
        """Return the coordinate, with its whole turns, at a phase of the carrier."""
        return self.begin - (self._integral(χ) - self.origin)

    def time_of(self, χ: Mpf) -> Mpf:
        """Return the time of the free motion at a phase of the carrier, which has a clock of its own."""
        return (χ + self.clock.oscillation(χ) - self.start) / self.rate

    def near(self, time: Mpf) -> Mpf:
        """Return the coordinate, with its whole turns, at a time of the free motion, to a few digits."""
        period = self.times[-1] - self.times[0]
        whole = self.context.floor((time - self.times[0]) / period)
        return self.begin + whole * self.turn + float(np.interp(float(time - whole * period), self.times, self.grid))

    def time(self, angle: Mpf) -> tuple[Mpf, Mpf]:
        """When the coordinate, with its whole turns, has a value; and a bound on the error.

        Args:
            angle: value of the coordinate, with its whole turns, in radians.

        Raises:
            NotConvergedError: Newton's method did not settle.
        """
        whole = self.context.floor((angle - self.begin) / self.turn)
        rest = float(angle - self.begin - whole * self.turn)
        side = 1 if self.grid[-1] > 0 else -1
        guess = float(np.interp(side * rest, side * self.grid, self.phases))
        χ, goal = guess + 2 * self.context.pi * whole, self.context.mpf(10) ** (-self.digits // 2 - 2)
        # it converges quadratically: what the last step leaves is of the order of its square
        found = newton(lambda χ: (angle - self.angle(χ)) / self.kernel.value(χ), χ, goal, _MOST_STEPS)
        if found is None:
            raise NotConvergedError("the passage of an ignorable coordinate did not converge to the requested digits")
        left = abs((angle - self.angle(found)) / self.kernel.value(found))
        tolerance = (2 * left + self.noise) * (1 + abs(self.clock.size)) / abs(self.rate)
        return self.time_of(found), self.noise + tolerance
