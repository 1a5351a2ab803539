"""p²(q) of one separated coordinate, at any precision and over intervals.

F(q; κ) = p², and the kernels kⱼ = ½ ∂F/∂κⱼ of Jacobi's equations Σᵢ ∫ kᵢⱼ dqᵢ/pᵢ = βⱼ (Greenwood (5-70), (5-71)).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hjsolve.arithmetic.asymptotic_expansion import BITS
from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.interval import Interval, Intervals, meet, over_shape
from hjsolve.arithmetic.jet import Derivatives, Jet, Jets
from hjsolve.arithmetic.number_types import Mpf, Numbers, Numeric
from hjsolve.arithmetic.sign_at_infinity import sign_before, sign_beyond, sign_in_the_end
from hjsolve.arithmetic.tape import BoundTape, Tape
from hjsolve.arithmetic.work_counter import count

_TRIED = (128, 256, 512, 1024, 2048, 4096, 8192)
_KEPT = 64
"""Precisions tried at the start, and bits of p² there that must be left of the first."""

Number = Callable[[int], Mpf]
"""A real number as a rule: binary digits asked ↦ ``mpf`` with (about) that many right."""


@dataclass(frozen=True)
class MomentumSquared:
    """F(q) = p²(q; κ) and its kernels ½ ∂F/∂κⱼ, with the constants κ known exactly.

    In its methods q is the position, ``bits`` the working precision.

    Attributes:
        squared: tape of F; inputs q, then constants and parameters.
        kernels: tape of ½ ∂F/∂κⱼ, one output a constant; same inputs.
        inputs: constants and parameters at any precision.
        guard: bits by which its terms cancel at the start; every evaluation has so many more than are asked for.
    """

    squared: Tape
    kernels: Tape
    inputs: Callable[[int], list[Mpf]]
    guard: int = 0

    def value(self, q: Numeric, bits: int) -> Mpf:
        """Return F(q) at the working precision ``bits``."""
        count(squares=1)
        return self._bound("value", bits).run(q)[0]

    def jet(self, q: Numeric, bits: int) -> Derivatives[Mpf]:
        """Return F, F′ and F″ at q; zeros where the formula does not contain q."""
        count(squares=1)
        bound = self._bound("jet", bits)
        jet = bound.run(Jet(q, Multi(bits).rational(1, 1)))[0]
        zero = Multi(bits).rational(0, 1)
        return Derivatives(*(zero if part is None else part for part in jet))

    def weights(self, q: Numeric, bits: int) -> list[Mpf]:
        """Return ½ ∂F/∂κⱼ at q."""
        count(kernels=1)
        return self._bound("weights", bits).run(q)

    def sign_beyond(self, side: int, start: float) -> int:
        """Return the sign of F for all side·q ≥ start; 0 where that is not known.

        Args:
            side: +1 towards +∞, −1 towards −∞.
            start: distance from zero.
        """
        bits = BITS + 2 * self.guard
        return sign_beyond(self.squared, self.inputs(bits), side, start, bits)

    def sign_in_the_end(self, side: int, end: Mpf | None) -> int:
        """Return the sign that F has from some place on, however close to an end; 0 where that is not known.

        Args:
            end: where q ends; None for ±∞.
            side: +1 upwards, −1 downwards.
        """
        bits = BITS + 2 * self.guard
        return sign_in_the_end(self.squared, self.inputs(bits), side, end, bits)

    def sign_before(self, end: Mpf, side: int, distance: Mpf) -> int:
        """Return the sign of F wherever 0 < side·(end − q) ≤ distance; 0 where that is not known.

        Args:
            end: where q ends.
            side: +1 from below, −1 from above.
            distance: from the end.
        """
        bits = BITS + 2 * self.guard
        return sign_before(self.squared, self.inputs(bits), end, side, distance, bits)

    def guarded(self, place: Number, squared: Number) -> MomentumSquared:
        """Return the same with as many bits more as its terms lose at a place where it is known.

        A velocity 1e-50 of the others leaves p² = 1e-100 of terms that cancel.

        Args:
            place: q.
            squared: p² > 0 there, by other means.
        """
        for bits in _TRIED:
            # p² by the velocity, which does not cancel, against the difference E − V at the same place
            known = squared(bits)
            if abs(self.value(place(bits), bits) - known) <= known * known.context.ldexp(1, -_KEPT):
                return replace(self, guard=bits - _TRIED[0])
        return self

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in self.__dict__.items() if name != "_tapes"}

    @cached_property
    def _tapes(self) -> dict[tuple[str, int], BoundTape]:
        return {}

    def _bound(self, what: str, bits: int) -> BoundTape:
        """Return the tapes with all but q known, kept for every precision that was asked for."""
        key = what, bits
        if key not in self._tapes:
            # all callers say how many bits they want; what cancels at the start is added here
            work = bits + self.guard
            arithmetic = Multi(work)
            field = Intervals(Float64()) if bits == 53 else Intervals(arithmetic)
            tape = self.kernels if what == "weights" else self.squared
            match what:
                case "value" | "weights":
                    bound = tape.bind(arithmetic, self.inputs(work))
                case "jet":
                    bound = tape.bind(Jets(arithmetic), [Jet(x) for x in self.inputs(work)])
                case _:
                    points = [field.point(x) for x in self.inputs(128 if bits == 53 else work)]
                    jets = [Jet(x) for x in points]
                    bound = tape.bind(field, points) if what == "centre" else tape.bind(Jets(field), jets)
            self._tapes[key] = bound
        return self._tapes[key]

    def enclose(self, low: Numbers, high: Numbers, bits: int = 53) -> Derivatives[Interval]:
        """Enclose F, F′, F″ over cells [low, high]: arrays of floats, or of ``mpf`` above 53 bits.

        The value is sharpened by the mean value form, F(m) + F′(cell)·(cell − m).

        Args:
            low, high: ends of the cells, shape (m,).
        """
        cells = self._bound("cells", bits)
        centres = self._bound("centre", bits)
        field, cell, middle = centres.arithmetic, Interval(low, high), (low + high) / 2
        value, first, second = cells.run(Jet(cell, field.rational(1, 1)))[0]
        zero = Interval(0 * low, 0 * low)
        first, second = (zero if part is None else part for part in (first, second))
        centre = centres.run(Interval(middle, middle))[0]
        with np.errstate(all="ignore"):
            # over a narrow cell the mean value form is off by (width)², the formula as it stands by its width
            sharp = field.add(centre, field.mul(first, field.sub(cell, Interval(middle, middle))))
            value = meet(value, sharp)
        return Derivatives(*(over_shape(part, np.shape(low)) for part in (value, first, second)))


def has_period(radicand: MomentumSquared, place: Number) -> bool:
    """Return True when p² has period 2π (a wheel on a slope has not, though its coordinate is an angle).

    Args:
        radicand: p².
        place: rule that gives a position in any number of binary digits.
    """
    bits = 160
    turn = 2 * multiprecision(bits).pi
    places = [place(bits) + k for k in range(3)]
    pairs = [(radicand.value(q, bits), radicand.value(q + turn, bits)) for q in places]
    size = max(abs(value) for pair in pairs for value in pair)
    # three places that no symmetry relates, to 120 bits
    return all(abs(here - there) <= multiprecision(bits).mpf(2) ** -120 * size for here, there in pairs)
