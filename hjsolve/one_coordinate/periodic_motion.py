"""The motion of one coordinate that repeats itself: libration and rotation.

Gⱼ(χ) = ∫₀^χ kⱼ dq/p = ⟨gⱼ⟩ χ + Σ (cₖ/k) sin kχ, mean growth and oscillation, from the Fourier series of gⱼ = kⱼ
(dq/dχ)/p; p = (dq/dχ) exp(series of ln(p/(dq/dχ))), so that p keeps its relative accuracy where it is tiny.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self, cast

import numpy as np

from hjsolve.arithmetic.error_free import Pair, moved, split
from hjsolve.arithmetic.floats import Float64, Multi, context_of, multiprecision
from hjsolve.arithmetic.number_types import Counts, Elementwise, Mpf, Numbers, Reals
from hjsolve.arithmetic.work_counter import count
from hjsolve.errors import InternalError, required
from hjsolve.one_coordinate.anomaly import BarrierAnomaly, Libration, Rotation, TwoBarrierAnomaly
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.one_coordinate.kind_of_motion import Kind, KindOfMotion, Weights, arithmetic_of, elementwise, phase_times
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.stretched_anomaly import Stretched

Anomaly = Libration | BarrierAnomaly | Rotation | TwoBarrierAnomaly | Stretched


@dataclass(frozen=True)
class Periodic(KindOfMotion):
    """Libration or rotation: phases with period 2π.

    Attributes:
        kind: libration or rotation.
        anomaly: the map χ ↦ q in many digits.
        kernels: series of kⱼ (dq/dχ)/p.
        momentum: series of ln(p/(dq/dχ)), which may vary by many orders of magnitude.
        density: series of p dq/dχ; its mean is the action.
        start: χ of the initial place.
        radicand: p² and its kernels, functions of the angle that the anomaly gives.
        radian: what the coordinate moves by in a radian of a rotation: 1 of an angle, a length on a line.
        tabular: False where the inverse of the time law is not to be read from a table.
    """

    kind: Kind
    anomaly: Anomaly
    kernels: list[FourierSeries]
    momentum: FourierSeries
    density: FourierSeries | None
    start: Mpf
    radicand: MomentumSquared
    radian: Mpf | int = 1

    stable = True
    one_scale = True
    tabular: ClassVar[bool] = True

    @property
    def cycle(self) -> Periodic:
        """This motion."""
        return self

    @property
    def bounded(self) -> Periodic:
        """This motion."""
        return self

    @property
    def direction(self) -> int:
        """The sign of dq/dχ of a rotation; 1 of a libration."""
        return self.anomaly.direction

    @property
    def rotates(self) -> bool:
        """True of a rotation."""
        return not self.anomaly.even

    @property
    def nodes(self) -> int:
        return max((s.nodes for s in self.kernels), default=0)

    @property
    def action(self) -> Mpf | float | None:
        """(1/2π) ∮ p dq, positive; None where it was not integrated."""
        return None if self.density is None else self.density.mean

    @property
    def tail(self) -> float:
        """The largest of the last coefficients, relative to the size of its function."""
        own = (self.momentum,) if self.density is None else (self.momentum, self.density)
        return max(float(s.tail) for s in (*self.kernels, *own))

    @property
    def signed_action(self) -> Mpf | int:
        """(1/2π) ∮ P dq, signed like P for a rotation."""
        action: Elementwise = required(self.action)
        signed: Mpf = action * self.direction
        return signed

    def integral(self, j: int, χ: Numbers) -> Numbers:
        mean = self.kernels[j].mean
        return (float(mean) if χ.dtype == float else mean) * χ + self.kernels[j].oscillation(χ)

    def rate(self, j: int, χ: Numbers) -> Numbers:
        return self.kernels[j].value(χ)

    def growth(self, j: int) -> float | Mpf:
        """Return the growth of Gⱼ per unit phase, in the mean."""
        return self.kernels[j].mean

    def libration(self, j: int) -> float | Mpf:
        """Return the size of the values whose mean the growth of Gⱼ is."""
        growth: Elementwise = self.growth(j)
        size: float | Mpf = abs(growth) + self.kernels[j].size
        return size

    @property
    def turning_points(self) -> tuple[Mpf, Mpf]:
        """Lower and upper, of a libration."""
        if not isinstance(self.anomaly, Libration | BarrierAnomaly | Stretched):
            raise InternalError("a rotation has no turning points; please report it")
        return self.anomaly.lower, self.anomaly.upper

    def momentum_integral(self, χ: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return ∫ P dq from the phase 0 to χ, |P dq/dχ|, and the size that rounding refers to."""
        series = required(self.density)
        mean: Elementwise = float(series.mean) if χ.dtype == float else series.mean
        size = abs(mean) * abs(χ) + series.size
        return mean * χ + series.oscillation(χ), abs(series.value(χ)), size

    def rounding_size(self, weights: Weights, χ: Reals) -> Reals:
        """Return what the rounding of Σ wⱼ Gⱼ(χ) is relative to: the growth, and all the terms of the series."""
        used = [(j, abs(w)) for j, w in enumerate(weights) if w]
        size = cast("Reals", sum(w * phase_times(self.growth(j), χ) for j, w in used))
        for j, w in used:
            size = size + w * self.kernels[j].wave_size
        return size

    def rate_noise(self, j: int) -> float:
        series = self.kernels[j]
        return 2.0**-48 * (abs(float(series.mean)) + series.size)

    def distances(self, χ: Reals) -> tuple[Reals, Reals]:
        """Return distances from the lower and the upper turning point of a libration, each to relative accuracy."""
        rest: Elementwise = χ - 2 * np.pi * np.rint(χ / (2 * np.pi))
        # q − a and b − q by the map, not by subtraction: they keep their relative digits next to the ends
        place: Elementwise = self.anomaly.in_doubles().place(rest, Float64())
        return place.below, place.above

    def beside(self, below: Reals, above: Reals) -> Pair:
        """Return the place at these distances from the turning points, in two doubles: the nearer one and its distance.

        Args:
            below, above: distances from the lower and from the upper turning point, shape (m,).
        """
        (a, b), low = map(split, self.turning_points), below < above
        end = Pair(np.where(low, a.high, b.high), np.where(low, a.low, b.low))
        # the turning point in two doubles and the small distance: their sum has more digits than a double
        return moved(end, np.where(low, below, -above))

    def place_in_two_doubles(self, χ: Reals, approximate: Reals) -> Pair:
        """Return q in two doubles, at phases in doubles; the second is 0 of a rotation."""
        if self.rotates:
            return Pair(approximate, 0 * approximate)
        return self.beside(*self.distances(χ))

    def place_spacing(self, χ: Reals) -> Reals:
        if self.rotates:
            return np.abs(cast("Reals", self.place(χ)[0])) + np.pi * float(self.radian)
        return np.minimum(*self.distances(χ))

    def in_doubles(self) -> Self:
        series = self.momentum
        if series.cosines.dtype != object:
            return self
        sines = None if series.sines is None else series.sines.astype(float)
        return replace(
            self, momentum=FourierSeries(series.mean, series.cosines.astype(float), sines, series.nodes, series.tail)
        )

    def momentum_noise(self, χ: Reals) -> Reals:
        """Return the terms of ln(p/(dq/dχ)), which are rounded one by one, and what the rounding of χ does to it."""
        return 2 * self.momentum.size + 4 * self.in_doubles().crowding(χ)

    def phase_rounding(self, χ: Reals) -> Reals:
        """Return the rounding of the anomaly itself as an uncertainty of χ in doubles; 0 where it has none."""
        return self.anomaly.rounding(χ)

    def weighted_rate(self, weights: tuple[float, ...], χ: Reals) -> Reals:
        """Return Σ wⱼ dGⱼ/dχ for a float array |χ| ≤ π by the formula, not the series: small values keep digits.

        Args:
            weights: wⱼ, one a constant.
        """
        q, _ = self._inner_place(χ)
        count(kernels=q.size)
        numbers = [float(x) for x in self.radicand.inputs(64)]
        # next to a zero of the kernel the series has the rounding of its largest value, the formula its own
        kernels = self.radicand.kernels.run(Float64(), [q, *numbers])
        total: Elementwise = sum(w * k for w, k in zip(weights, kernels, strict=False) if w)
        return total / self.ratio(χ) * self.anomaly.slope_at(χ)

    def ratio(self, χ: Elementwise) -> Elementwise:
        """Return p/(dq/dχ) to full relative accuracy.

        Args:
            χ: phase; one ``mpf``, or an array of doubles or of ``mpf``.
        """
        if isinstance(χ, np.ndarray) and χ.dtype == object:
            return elementwise(lambda x: x.context.exp(x), self.momentum.value(χ), 1)
        if (context := context_of(χ)) is not None:
            return context.exp(self.momentum.value(χ))
        rest = replace(self.momentum, mean=0.0)
        # the mean of the logarithm may be hundreds: its exponential is taken once, in many digits
        return float(multiprecision(96).exp(self.momentum.mean)) * np.exp(rest.value(χ))

    def crowding(self, χ: Reals) -> Reals:
        """Return |χ d ln(p/(dq/dχ))/dχ| for a float array: how the rounding of χ comes out in p, relative to p.

        p is a product of two factors; next to a pole both change fast with χ, and p may not.
        """
        # a central difference: an estimate of an error needs no more
        h, series = 1e-5, replace(self.momentum, mean=0.0)
        return np.abs(χ * (series.value(χ + h) - series.value(χ - h)) / (2 * h))

    def phase(self, q: Mpf, arithmetic: Multi) -> Mpf:
        """Return χ in (−π, π] of a place on the way up, or of one that is passed in a rotation.

        Args:
            q: the place, between the turning points of a libration.
            arithmetic: in which χ is worked out.
        """
        return self.anomaly.phase(q / self.radian, 1, arithmetic)

    def length_of_turns(self, count: Counts, like: Numbers) -> Numbers:
        """Return what a rotation has gone in whole turns.

        Args:
            count: how many, whole numbers, shape (m,).
            like: of the numbers wanted: doubles, or ``mpf``.
        """
        if like.dtype == float:
            # whole turns times an exact length: multiplied once, not added turn by turn
            turn: Elementwise = 2 * np.pi if self.radian == 1 else float(2 * multiprecision(96).pi * self.radian)
            return self.direction * turn * count
        turn = 2 * arithmetic_of(like).pi() * self.radian
        return np.array([self.direction * turn * int(n) for n in count], dtype=object)

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        q, p = self._inner_place(χ)
        if self.radian == 1:
            return q, p
        radian: Elementwise = float(self.radian) if χ.dtype == float else self.radian
        return q * radian, p / radian

    def _inner_place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return the place and the momentum that belong to the radicand."""
        count(places=χ.size)
        arithmetic = arithmetic_of(χ)
        anomaly = arithmetic.choose(lambda _: self.anomaly.in_doubles(), lambda _: self.anomaly)
        turn = (
            np.rint(χ / (2 * np.pi))
            if χ.dtype == float
            else elementwise(lambda x: x.context.nint(x / (2 * x.context.pi)), χ, 1)
        )
        pi: Elementwise = arithmetic.pi()
        # the map is asked within one turn, where elliptic functions have all their digits
        rest: Numbers = χ - 2 * pi * turn

        def at(x: Elementwise) -> tuple[Elementwise, Elementwise]:
            place = anomaly.place(x, arithmetic)
            return place.q, place.speed

        q, speed = elementwise(at, rest, 2)
        p = self.ratio(rest) * speed
        return (q, p) if self.anomaly.even else (q + self.anomaly.direction * 2 * pi * turn, p)
