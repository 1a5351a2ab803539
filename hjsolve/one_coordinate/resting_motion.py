"""The motion of one coordinate that stays where it is.

At a double zero of F = p² with F″ < 0 it is the limit of a vanishing libration, F ≈ ½F″ (q − q₀)² + δ: J = 0 and ∂J/∂κⱼ
= kⱼ/√(−½F″).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, cast

from hjsolve.arithmetic.error_free import Pair, split
from hjsolve.arithmetic.number_types import Elementwise, Mpf, Numbers, Reals
from hjsolve.arithmetic.work_counter import count
from hjsolve.one_coordinate.fourier_series import FourierSeries, zero
from hjsolve.one_coordinate.kind_of_motion import Kind, KindOfMotion, Weights, phase_times


@dataclass(frozen=True)
class AtRest(KindOfMotion):
    """A coordinate that rests: the phase only counts, as the limit of a vanishing libration.

    Attributes:
        rest: the place.
        rates: kⱼ/√(−F″/2) there (kⱼ alone where the rest is unstable).
        sizes: |rates| and what they change by over the distance |q|: as large as the terms that may cancel in them.
        stable: True where F″ < 0: small motions about the place have a frequency.
        settled: True where F < 0 on both sides, also where F″ = 0 or there is a kink.
    """

    rest: Mpf
    rates: list[Mpf]
    sizes: list[Mpf]
    stable: bool

    settled: bool = False
    kind: Kind = "equilibrium"
    start: Mpf | int = 0
    action: Mpf | int | None = 0
    rests = True
    cycle: ClassVar[None] = None

    @property
    def bounded(self) -> AtRest:
        """This motion."""
        return self

    @property
    def signed_action(self) -> int | None:
        """0, the limit of a vanishing libration; None on top of a barrier."""
        # on top of a barrier nothing librates about the place
        return 0 if self.stable else None

    @property
    def kernels(self) -> list[FourierSeries]:
        """Series of what is left of the kernels next to their means: nothing."""
        return [zero() for _ in self.rates]

    def libration(self, j: int) -> Mpf:
        """Return the size of the terms that the growth of Gⱼ is the sum of."""
        return self.sizes[j]

    def momentum_integral(self, χ: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return zeros: nothing is moved through."""
        return 0 * χ, 0 * χ, 0 * χ

    def rounding_size(self, weights: Weights, χ: Reals) -> Reals:
        return cast("Reals", sum(abs(w) * phase_times(self.growth(j), χ) for j, w in enumerate(weights) if w))

    def place_in_two_doubles(self, χ: Reals, approximate: Reals) -> Pair:  # noqa: ARG002
        """Return the place in two doubles."""
        rest = split(self.rest)
        return Pair(rest.high + 0 * χ, rest.low + 0 * χ)

    def place_spacing(self, χ: Reals) -> Reals:
        """Return 0: the place is known to any precision."""
        return 0.0 * χ

    def growth(self, j: int) -> float | Mpf:
        """Return the growth of Gⱼ per unit phase."""
        return self.rates[j]

    def integral(self, j: int, χ: Numbers) -> Numbers:
        return self.rate(j, χ) * χ

    def rate(self, j: int, χ: Numbers) -> Numbers:
        rate: Elementwise = float(self.rates[j]) if χ.dtype == float else self.rates[j]
        # constant, as an array like χ
        return rate + 0 * χ

    def place(self, χ: Numbers) -> tuple[Numbers, Numbers]:
        """Return the place, and the momentum 0."""
        count(places=χ.size)
        rest: Elementwise = float(self.rest) if χ.dtype == float else self.rest
        return rest + 0 * χ, 0 * χ
