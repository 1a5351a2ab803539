"""The course of one separated coordinate: what kind of motion it makes, and its regular integrals.

Every course answers the same questions for a phase χ that grows with time: where the coordinate is,
and what the integrals Gⱼ(χ) = ∫ kⱼ dq/p are, one for each constant of the motion. Greenwood (5-70),
(5-71): the motion is the set of phases for which Σᵢ Gᵢⱼ(χᵢ) keeps its value, and grows like t for the energy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.number_types import Elementwise, Mask, Mpf, Numbers, Reals
from hjsolve.arithmetic.work_counter import count
from hjsolve.one_coordinate.anomaly import BarrierAnomaly, Libration, Rotation, TwoBarrierAnomaly
from hjsolve.one_coordinate.chebyshev_panels import EndMap, Panels
from hjsolve.one_coordinate.fourier_series import FourierSeries, zero
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.open_branch import Branch
from hjsolve.one_coordinate.stretched_anomaly import Stretched

Anomaly = Libration | BarrierAnomaly | Rotation | TwoBarrierAnomaly | Stretched

Kind = Literal["libration", "rotation", "escape", "equilibrium", "asymptotic", "boundary"]
PARTS = frozenset({"time", "action", "place"})
"""What is integrated over a cycle: Jacobi's integrals (periods, times), the action, what places and momenta need."""


def arithmetic_of(array: Numbers) -> Float64 | Multi:
    """Return the arithmetic in which an array of phases is held.

    Args:
        array: of doubles, or of ``mpf``.
    """
    if array.dtype != object:
        return Float64()
    return Multi(cast("Mpf", array.flat[0]).context.prec) if array.size else Float64()


def elementwise(function: Callable[..., Any], χ: Numbers, outputs: int) -> Any:
    """Apply a function of a float array, or of one ``mpf`` to an object array.

    Args:
        function: gives a tuple of ``outputs`` values, or one value where that is 1.
        χ: doubles or ``mpf``, shape (m,).
        outputs: how many values the function gives.
    """
    if χ.dtype != object:
        return function(χ)
    return np.frompyfunc(function, 1, outputs)(χ)


@dataclass(frozen=True)
class Periodic:
    """Libration or rotation: phases with period 2π.

    Attributes:
        kind: libration or rotation.
        anomaly: the map χ ↦ q in many digits.
        kernels: series of kⱼ (dq/dχ)/p.
        momentum: series of ln(p/(dq/dχ)), which may vary by many orders of magnitude.
        density: series of p dq/dχ; its mean is the action.
        start: χ of the initial place.
        radicand: p² and its kernels.
    """

    kind: Kind
    anomaly: Anomaly
    kernels: list[FourierSeries]
    momentum: FourierSeries
    density: FourierSeries | None
    start: Mpf
    radicand: MomentumSquared

    periodic = True

    @property
    def action(self) -> Mpf | float | None:
        """(1/2π) ∮ p dq, positive; None where it was not integrated."""
        return None if self.density is None else self.density.mean

    @property
    def tail(self) -> float:
        """The largest of the last coefficients, relative to the size of its function."""
        return max(float(s.tail) for s in (*self.kernels, self.momentum))

    def limits(self) -> tuple[float, float]:
        """Return the least and greatest phase there is: it goes on for ever."""
        return -np.inf, np.inf

    def integral(self, j: int, χ: Numbers) -> Numbers:
        """Return Gⱼ from 0 to χ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        mean = self.kernels[j].mean
        return (float(mean) if χ.dtype == float else mean) * χ + elementwise(self.kernels[j].ripple, χ, 1)

    def rate(self, j: int, χ: Numbers) -> Numbers:
        """Return dGⱼ/dχ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        return elementwise(self.kernels[j].value, χ, 1)

    def growth(self, j: int) -> float | Mpf:
        """Return the growth of Gⱼ per unit phase, in the mean.

        Args:
            j: position of the constant.
        """
        return self.kernels[j].mean

    def blur(self, χ: Reals) -> Reals:
        """Return the rounding of the anomaly itself as an uncertainty of χ in doubles; 0 where it has none.

        Args:
            χ: phases, shape (m,).
        """
        return self.anomaly.rounding(χ)

    def pace(self, weights: tuple[float, ...], χ: Reals) -> Reals:
        """Return Σ wⱼ dGⱼ/dχ for a float array |χ| ≤ π by the formula, not the series: small values keep digits.

        Args:
            weights: wⱼ, one a constant.
            χ: phases in doubles, shape (m,).
        """
        q, _ = self.place(χ)
        count(kernels=q.size)
        numbers = [float(x) for x in self.radicand.inputs(64)]
        kernels = self.radicand.kernels.run(Float64(), [q, *numbers])
        total: Elementwise = sum(w * k for w, k in zip(weights, kernels, strict=False) if w)
        return total / self.ratio(χ) * self.anomaly.slope_at(χ)

    def ratio(self, χ: Elementwise) -> Elementwise:
        """Return p/(dq/dχ) to full relative accuracy; χ a float array or one ``mpf``.

        Args:
            χ: phase.
        """
        if not isinstance(χ, np.ndarray):
            return χ.context.exp(self.momentum.value(χ))
        rest = replace(self.momentum, mean=0.0)
        return float(multiprecision(96).exp(self.momentum.mean)) * np.exp(rest.value(χ))

    def crowding(self, χ: Reals) -> Reals:
        """Return |χ d ln(p/(dq/dχ))/dχ| for a float array: how the rounding of χ comes out in p, relative to p.

        p is a product of two factors; next to a pole both change fast with χ, and p may not.

        Args:
            χ: phases in doubles, shape (m,).
        """
        h, series = 1e-5, replace(self.momentum, mean=0.0)
        return np.abs(χ * (series.value(χ + h) - series.value(χ - h)) / (2 * h))

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return q (not reduced to one turn) and the shell momentum at χ.

        Args:
            χ: phases, shape (m,).
        """
        count(places=χ.size)
        arithmetic = arithmetic_of(χ)
        anomaly = self.anomaly.in_doubles() if isinstance(arithmetic, Float64) else self.anomaly
        turn = (
            np.rint(χ / (2 * np.pi))
            if χ.dtype == float
            else elementwise(lambda x: x.context.nint(x / (2 * x.context.pi)), χ, 1)
        )
        pi: Elementwise = arithmetic.pi()
        rest: Numbers = χ - 2 * pi * turn

        def at(x: Elementwise) -> tuple[Elementwise, Elementwise]:
            place = anomaly.place(x, arithmetic)
            return place.q, self.ratio(x) * place.speed

        q, p = elementwise(at, rest, 2)
        return (q, p) if self.anomaly.even else (q + self.anomaly.direction * 2 * pi * turn, p)


@dataclass(frozen=True)
class AtRest:
    """A coordinate that rests: the phase only counts, as the limit of a vanishing libration.

    Attributes:
        rest: the place.
        rates: kⱼ/√(−F″/2) there (kⱼ alone where the rest is unstable).
        sizes: |rates| and what they change by over the distance |q|: as large as the terms that may cancel in them.
        stable: True where F″ < 0.
    """

    rest: Mpf
    rates: list[Mpf]
    sizes: list[Mpf]
    stable: bool

    kind: Kind = "equilibrium"
    start: Mpf | int = 0
    action: Mpf | int | None = 0
    periodic = True

    @property
    def kernels(self) -> list[FourierSeries]:
        """Series of what is left of the kernels beside their means: nothing."""
        return [zero() for _ in self.rates]

    def limits(self) -> tuple[float, float]:
        """Return the least and greatest phase there is: the phase only counts."""
        return -np.inf, np.inf

    def growth(self, j: int) -> float | Mpf:
        """Return the growth of Gⱼ per unit phase.

        Args:
            j: position of the constant.
        """
        return self.rates[j]

    def integral(self, j: int, χ: Numbers) -> Numbers:
        """Return Gⱼ from 0 to χ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        return self.rate(j, χ) * χ

    def rate(self, j: int, χ: Numbers) -> Numbers:
        """Return dGⱼ/dχ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        rate: Elementwise = float(self.rates[j]) if χ.dtype == float else self.rates[j]
        return rate + 0 * χ

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return the place, and the momentum 0.

        Args:
            χ: phases, shape (m,).
        """
        count(places=χ.size)
        rest: Elementwise = float(self.rest) if χ.dtype == float else self.rest
        return rest + 0 * χ, 0 * χ


@dataclass(frozen=True, eq=False)
class Unbounded:
    """Escape, asymptotic motion, or motion to an end of the domain.

    Attributes:
        kind: escape, asymptotic or boundary.
        ahead: branch of the motion for χ ≥ 0.
        behind: branch for χ ≤ 0, run backwards; the same branch where the motion turns at χ = 0.
        start: χ of the initial place.
        reach: how far the panels go: (weights, amount of the weighted sum of integrals), or (None, greatest phase).
        back: the amount for the branch behind, where it is another; None for the same.
    """

    kind: Kind
    ahead: Branch
    behind: Branch
    start: Mpf
    reach: tuple[tuple[float, ...] | None, float] = (None, 1.0)
    back: float | None = None

    periodic = False
    action = None

    def _sides(self, χ: Numbers) -> tuple[Mask, Panels, Panels]:
        weights, amount = self.reach
        ahead = self.ahead.panels(weights, amount)
        if self.behind is self.ahead:
            return χ >= 0, ahead, ahead
        return χ >= 0, ahead, self.behind.panels(weights, amount if self.back is None else self.back)

    def integral(self, j: int, χ: Numbers) -> Numbers:
        """Return Gⱼ from 0 to χ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.integral(j, np.abs(χ)), -behind.integral(j, np.abs(χ)))

    def grain(self, j: int, χ: Numbers) -> Reals:
        """Return the size that the rounding of an integral in doubles refers to.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.grain(j, np.abs(χ)), behind.grain(j, np.abs(χ)))

    def rate(self, j: int, χ: Numbers) -> Numbers:
        """Return dGⱼ/dχ.

        Args:
            j: position of the constant.
            χ: phases, shape (m,).
        """
        forward, ahead, behind = self._sides(χ)
        return np.where(forward, ahead.value(j, np.abs(χ)), behind.value(j, np.abs(χ)))

    def edges(self) -> Reals:
        """Return the phases at all panel ends, increasing."""
        _, ahead, behind = self._sides(np.zeros(1))
        return np.concatenate([-behind.edges[:0:-1], ahead.edges]).astype(float)

    def rate_sum(self, weights: tuple[float, ...], χ: Reals) -> Reals:
        """Return Σ wⱼ dGⱼ/dχ.

        Args:
            weights: wⱼ, one a constant.
            χ: phases, shape (m,).
        """
        return cast("Reals", sum(w * self.rate(j, χ) for j, w in enumerate(weights) if w))

    def limits(self) -> tuple[float, float]:
        """Return the least and greatest phase the panels hold; infinite along an asymptote, whose tail is known.

        Not where it is reached in a finite time all the same, at a place where the kinetic energy vanishes.
        """
        _, ahead, behind = self._sides(np.zeros(1))
        ends = [
            np.inf if b.way.end == "asymptote" and not self._settled(p) else float(p.edges[-1])
            for b, p in ((self.behind, behind), (self.ahead, ahead))
        ]
        return -ends[0], ends[1]

    def _settled(self, panels: Panels) -> bool:
        """True where the time that the panels were made for no longer grows with the phase."""
        weights, _ = self.reach
        if weights is None or not any(weights):
            return False
        last = np.array([float(panels.edges[-1])])
        rate, total = (
            abs(sum(w * float(part(j, last)[0]) for j, w in enumerate(weights) if w))
            for part in (panels.value, panels.integral)
        )
        return bool(last[0] * rate <= 10.0**-self.ahead.digits * total)

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return q and the shell momentum at χ.

        Args:
            χ: phases, shape (m,).
        """
        count(places=χ.size)
        forward, ahead, behind = self._sides(χ)
        (q1, p1), (q2, p2) = self._on(self.ahead, ahead, χ, 1), self._on(self.behind, behind, χ, -1)
        return np.where(forward, q1, q2), np.where(forward, p1, p2)

    def _on(self, branch: Branch, panels: Panels, χ: Numbers, sign: int) -> tuple[Numbers, Numbers]:
        y, arithmetic = np.abs(χ), arithmetic_of(χ)
        way = branch.way if χ.dtype == object else float_way(branch.way)
        q, slope = elementwise(lambda v: way.position(v, arithmetic), y, 2)
        return q, sign * slope * panels.value(-1, y) / elementwise(lambda v: way.rest(v, arithmetic), y, 1)


def float_way(way: EndMap) -> EndMap:
    """Round the constants of a map to doubles.

    Args:
        way: with constants of many digits.
    """
    return replace(way, start=float(way.start), length=float(way.length))  # type: ignore[arg-type]  # as many digits


CoordinateMotion = Periodic | AtRest | Unbounded
