"""Means of integrands by Arb's own rigorous quadrature, which finds its way around singularities close to the path.

It asks for the integrand over complex balls (Johansson, arXiv:1802.07942) and wants it bounded. It is: on a ball that
touches a turning point p²/((q−a)(b−q)) is enclosed by slopes, F[a, q] lying in the hull of F′ over the segment from a
to q, so nothing is divided by zero. A ball that meets a branch cut gives "not finite".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from hjsolve.arithmetic.ball import Ball, Balls, flint, hull
from hjsolve.arithmetic.work_counter import count
from hjsolve.certified.integrands import CycleIntegrand


def mean(cycle: CycleIntegrand, j: int, bits: int, size: flint.arb) -> flint.arb:
    """Enclose (1/π) ∫₀^π of an integrand over the plain anomaly (over a full turn and divided by 2π for a rotation).

    Args:
        j: which kernel; −1 for p dq/dχ.
        bits: relative precision wanted.
        size: of the integrand, roughly.

    Returns:
        A real ball at the current precision; wide where the quadrature did not converge.
    """
    f = _Plain(cycle)
    length = flint.arb.pi() * (1 if cycle.librates else 2)
    # Petras's algorithm: subdivision with Gauss and Legendre's rule where the integrand is bounded on an ellipse
    total = flint.acb.integral(
        lambda χ, _: f.value(j, χ),
        0,
        length,
        rel_tol=flint.arb(2) ** -bits,
        abs_tol=size * flint.arb(2) ** -(bits + 4),
        eval_limit=400 * bits + 20000,
        depth_limit=8 * bits,
    )
    return (total / length).real


@dataclass(frozen=True)
class _Plain:
    """The integrands over the plain anomaly, q = a + (b − a) sin²(χ/2), on any ball; q = χ for a rotation."""

    cycle: CycleIntegrand

    def value(self, j: int, χ: Ball) -> Ball:
        """Return kⱼ (dq/dχ)/p, or p dq/dχ for j = −1."""
        count(squares=1, kernels=int(j >= 0))
        if self.cycle.lower is None:
            root = Balls().unary("sqrt", self._squared(χ))
            return root if j < 0 else self._weight(j, χ) / root
        # q − a = W sin²(χ/2), b − q = W cos²(χ/2): dχ = dq/√((q − a)(b − q)) takes the two inverse roots away
        s, c = (χ / 2).sin_cos()
        from_lower, to_upper = self.cycle.width * s * s, self.cycle.width * c * c
        q = self.cycle.lower + from_lower
        root = Balls().unary("sqrt", self._regular(q, from_lower, to_upper))
        return from_lower * to_upper * root if j < 0 else self._weight(j, q) / root

    def _weight(self, j: int, q: Ball) -> Ball:
        return self.cycle.weights.run(q)[[k for k in self.cycle.wanted if k >= 0].index(j)]

    def _regular(self, q: Ball, from_lower: Ball, to_upper: Ball) -> Ball:
        """R = p²/((q−a)(b−q)): the quotient on a small ball, a slope on one that is wide or touches an end.

        F[a, q] = F′(a) + ½F″(hull)(q − a) stays sharp where F′(a) is small (near a separatrix).
        """
        # where q − a may vanish only the slope F[a, q] from that end is of use; a wide ball takes the nearer end
        at_lower, at_upper = _touches_zero(from_lower), _touches_zero(to_upper)
        # a ball that holds both ends says nothing: Arb divides it
        if at_lower and at_upper:
            return q * flint.arb("nan")
        if at_lower or (not at_upper and _wide(q) and abs(from_lower) < abs(to_upper)):
            found = self._sloped(q, 0, from_lower, to_upper)
        elif at_upper or _wide(q):
            found = self._sloped(q, 1, -to_upper, -from_lower)
        else:
            return self._squared(q) / (from_lower * to_upper)
        # a slope that may be 0 tells less than the quotient, where there is one
        if at_lower or at_upper or found.real > 0:
            return found
        return self._squared(q) / (from_lower * to_upper)

    def _sloped(self, q: Ball, end: int, offset: Ball, distance: Ball) -> Ball:
        place = self.cycle.ends[end]
        # the remainder ½F″ over the hull of the ball and the end: Taylor's formula needs a convex set
        bend = self.cycle.line.taylor(hull(q, place), 3)[2]
        return (self._end_slopes[end] + bend * offset) / distance

    @cached_property
    def _end_slopes(self) -> tuple[Ball, Ball]:
        """F′ at both turning points."""
        line, (lower, upper) = self.cycle.line, self.cycle.ends
        return line.taylor(lower, 2)[1], line.taylor(upper, 2)[1]

    def _squared(self, q: Ball) -> Ball:
        """F on a ball: directly at a point, by a Taylor polynomial about the middle where the ball is wide."""
        middle = q.mid()
        offset = q - middle
        # on a ball this small the dependency of the formula on q costs nothing
        if abs(offset).upper() < flint.arb(2) ** -40 * abs(middle).upper():
            return self.cycle.line.value(q)
        value, slope = self.cycle.line.taylor(middle, 2)
        return value + (slope + self.cycle.line.taylor(q, 3)[2] * offset) * offset


def _wide(q: Ball) -> bool:
    """Return True for a ball so wide that the quotient of F and its factors says little."""
    return isinstance(q, flint.acb) and bool(q.rad() > 2.0**-6 * (1 + abs(q).upper()))


def _touches_zero(x: Ball) -> bool:
    return bool(x.contains(0))
