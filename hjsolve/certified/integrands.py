"""One cycle of a coordinate in balls: a periodic map χ ↦ q and the regular integrands over it.

Every map is q − a = W s²/(s² + c²), b − q = W c²/(s² + c²) between turning points, with

    |dq/dχ|/√((q − a)(b − q)) = 2 (s′c − sc′)/(s² + c²),

and q = q₀ + 2 arg(c + is) − π for a rotation, with the same right side for dq/dχ. Any analytic s and c serve that gain
a sign in a turn of χ, s odd, c even, and s′c − sc′ > 0: the means of the integrands over a turn do not depend on them.

They are s = S(λ; sin χ/2), c = S(μ; cos χ/2) with S(κ; x) = sinh κx / sinh κ, and S(0; x) = x, the plain anomaly.
Where another zero of p² is near, at a − (b − a)/ρ, sinh² λ = ρ moves it to where κx = iπ/2, a critical point of S, so
that √p² has no branch point there. So nodes grow like log ρ, as with the elliptic anomaly of ``anomaly``; its s and c,
theta functions, cost three times as much, and wide balls are enclosed less sharply. λ and μ are doubles that are taken
as exact, so the map is the same at every precision.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

from hjsolve.arithmetic.ball import Ball, Balls, flint, working
from hjsolve.arithmetic.tape import BoundTape, Tape
from hjsolve.certified.ball_radicand import BallMomentumSquared
from hjsolve.errors import required

_ENTIRE = {"add", "sub", "mul", "neg", "rational", "pi", "sin", "cos", "exp", "sinh", "cosh"}

TERMS = 8
"""Terms of Taylor's formula at a turning point, without the remainder; Arb's series are cut off at ten."""


class Fractions(NamedTuple):
    """s²/(s² + c²), c²/(s² + c²), 2 (s′c − sc′)/(s² + c²), s² + c², s and c."""

    low: Ball
    high: Ball
    stretch: Ball
    denominator: Ball
    s: Ball
    c: Ball


@dataclass(frozen=True)
class AnomalyMap:
    """s = S(λ; sin χ/2), c = S(μ; cos χ/2).

    Attributes:
        lower, upper: λ and μ, how slow the map is at χ = 0 and at χ = π.
    """

    lower: float = 0.0
    upper: float = 0.0

    @property
    def plain(self) -> bool:
        """True for s = sin χ/2, c = cos χ/2."""
        return not (self.lower or self.upper)

    def fractions(self, χ: Ball) -> Fractions:
        """Return the map at a real or complex ball.

        Args:
            χ: phase, a ball.
        """
        sine, cosine = (χ / 2).sin_cos()
        if self.plain:
            return Fractions(sine * sine, cosine * cosine, flint.arb(1), flint.arb(1), sine, cosine)
        s, ds = _slowed(self.lower, sine)
        c, dc = _slowed(self.upper, cosine)
        denominator = s * s + c * c
        stretch = (cosine * ds * c + sine * dc * s) / denominator
        return Fractions(*_shared(s, c), stretch, denominator, s, c)


def _shared(s: Ball, c: Ball) -> tuple[Ball, Ball]:
    """s²/(s² + c²) and c²/(s² + c²); a complex ball is wide, and what varies stands in each of them once."""
    # the smaller over the larger: the square is at most about 1, and neither overflows nor divides by a ball with 0
    swapped = bool(abs(s).mid() > abs(c).mid())
    ratio = c / s if swapped else s / c
    square = ratio * ratio
    large = 1 / (1 + square)
    # over a real ball square·large keeps the relative digits of a small distance; over a wide complex one it would use
    # the ball twice
    small = 1 - large if isinstance(s, flint.acb) else square * large
    return (large, small) if swapped else (small, large)


def _slowed(κ: float, x: Ball) -> tuple[Ball, Ball | int]:
    """S(κ; x) and dS/dx."""
    if not κ:
        return x, 1
    slow, unit, rate = _constants(κ, flint.ctx.prec)
    sinh, cosh = (slow * x).sinh_cosh()
    return sinh * unit, cosh * rate


@lru_cache(maxsize=16)
def _constants(κ: float, bits: int) -> tuple[flint.arb, flint.arb, flint.arb]:
    """κ, 1/sinh κ and κ/sinh κ at a precision."""
    with working(bits):
        slow = flint.arb(κ)
        unit = 1 / slow.sinh()
        return slow, unit, slow * unit


def between_turns(near_lower: float, near_upper: float) -> AnomalyMap:
    """Make the map of a libration with zeros of p² near.

    Args:
        near_lower, near_upper: (b − a) over the distance of the next zero from a and from b; 0 where it is far.
    """
    # sinh²λ = ρ; up to ρ = 1 the next zero is as far away as the motion is wide, and the plain map does
    return AnomalyMap(*(math.asinh(math.sqrt(ρ)) if ρ > 1 else 0.0 for ρ in (near_lower, near_upper)))


def all_round(gap: float) -> AnomalyMap:
    """Make the map of a rotation; ``gap`` is the distance of the complex zero of p² near χ = π from the real axis."""
    # at the critical point c = i/sinh μ = i·gap/2, and q − q₀ is about ±2c: the zero of p² lies where the map is
    # stationary
    return AnomalyMap(0.0, math.asinh(2 / gap))


class CycleNode(NamedTuple):
    """A place of the cycle: q, q − a, b − q (None for a rotation), |dq/dχ|/√((q − a)(b − q)), s² + c²; is a nearer?"""

    q: Ball
    from_lower: Ball | None
    to_upper: Ball | None
    stretch: Ball
    denominator: Ball
    near_lower: bool = False

    @property
    def nearest(self) -> Ball:
        """The distance from the nearer turning point of a libration."""
        return required(self.from_lower if self.near_lower else self.to_upper)


@dataclass(frozen=True, eq=False)
class CycleIntegrand:
    """The integrands of one coordinate at one precision: of the current context when it is made.

    Attributes:
        line: p² and kernels.
        lower, upper: turning points; None for a rotation.
        slow: q₀ for a rotation, χ = π.
        wanted: kernels, −1 for p dq.
        map: χ ↦ q.
        spread: a map for where another zero of p² is near; None where there is none.
        near: the largest W|R′/R| at a turning point, W = b − a and R = p²/((q − a)(b − q)): W over the distance of the
            next zero of p² outside.
        symmetry: into how many equal parts the integrands divide a turn: 2 where they are even in χ, as over a
            libration, 4 where χ ↦ π − χ leaves them what they are as well; 1 where nothing is known.
    """

    line: BallMomentumSquared
    lower: flint.arb | None
    upper: flint.arb | None
    slow: flint.arb
    wanted: tuple[int, ...]
    map: AnomalyMap = AnomalyMap()
    spread: AnomalyMap | None = None
    near: float = 0.0
    symmetry: int = 1

    @property
    def librates(self) -> bool:
        """True between two turning points."""
        return self.lower is not None

    @property
    def ends(self) -> tuple[flint.arb, flint.arb]:
        """The turning points of a libration."""
        return required(self.lower), required(self.upper)

    def over(self, map_: AnomalyMap) -> CycleIntegrand:
        """Return the same cycle with another map."""
        symmetry = self.symmetry if map_.lower == map_.upper else min(self.symmetry, 2)  # χ ↦ π − χ exchanges s and c
        return self if map_ == self.map else replace(self, map=map_, symmetry=symmetry)

    def rounded(self, bits: int) -> CycleIntegrand:
        """Return the same cycle for a low precision."""
        line = self.line.rounded(bits)
        if line is self.line:
            return self
        with working(bits):
            # x + 0 rounds the ball to the working precision, outward
            lower, upper = (None if x is None else x + 0 for x in (self.lower, self.upper))
            return replace(self, line=line, lower=lower, upper=upper, slow=self.slow + 0)

    @cached_property
    def width(self) -> flint.arb:
        with working(self.line.bits):  # whoever asks first, at whatever precision
            lower, upper = self.ends
            return upper - lower

    @cached_property
    def lower_series(self) -> list[Ball]:
        """``TERMS`` Taylor coefficients of F at the lower turning point."""
        return self.line.taylor(flint.acb(self.ends[0]), TERMS)

    @cached_property
    def upper_series(self) -> list[Ball]:
        """The same at the upper one."""
        return self.line.taylor(flint.acb(self.ends[1]), TERMS)

    @cached_property
    def weights(self) -> BoundTape[Ball]:
        return self.line.weights(*(j for j in self.wanted if j >= 0))

    @cached_property
    def entire(self) -> bool:
        """True where p² and the kernels are entire functions of q by their form."""
        return _entire(self.line.radicand.squared) and _entire(self.line.radicand.kernels)

    def sample(self, χ: Ball) -> CycleNode:
        """Return where χ is.

        Args:
            χ: phase, a ball.
        """
        fraction = self.map.fractions(χ)
        if self.lower is None:
            return CycleNode(self._turned(χ, fraction), None, None, fraction.stretch, fraction.denominator)
        from_lower, to_upper = self.width * fraction.low, self.width * fraction.high
        near_lower = bool(fraction.low.real < 0.5)  # the shares add up to 1
        # counted from the nearer end: q − a there has no cancellation
        q = self.lower + from_lower if near_lower else self.upper - to_upper
        return CycleNode(q, from_lower, to_upper, fraction.stretch, fraction.denominator, near_lower)

    def _turned(self, χ: Ball, fraction: Fractions) -> Ball:
        """Return the q of a rotation; on a complex ball up to whole turns, which p² does not see."""
        # with λ = μ = 0 it is 2 arg(c + is) = χ, without an arctangent that has cuts
        if self.map.plain:
            return self.slow + χ - flint.arb.pi()
        s, c = fraction.s, fraction.c
        if isinstance(s, flint.arb) and isinstance(c, flint.arb):
            return self.slow + 2 * flint.arb.atan2(s, c) - flint.arb.pi()
        # |s| < |c|: atan(s/c) is used where its argument is small and away from the cuts at ±i
        if fraction.high.real > 0.5:
            return self.slow + 2 * Balls().unary("atan", s / c) - flint.arb.pi()
        side = 1 if χ.real.mid() > 0 else -1  # c/s is small near χ = ±π and keeps its relative width there
        return self.slow - 2 * Balls().unary("atan", c / s) + (side - 1) * flint.arb.pi()

    def values(self, χ: Ball) -> list[Ball]:
        """Return the wanted integrands at a real ball, a node: kⱼ (dq/dχ)/p, or p dq/dχ.

        Args:
            χ: phase, a real ball.
        """
        sample = self.sample(χ)
        square = self.line.value(sample.q)
        if sample.from_lower is None:
            product: Ball = flint.arb(1)
            root = square.sqrt()
        else:
            product = sample.from_lower * sample.to_upper
            # √R at a node: a node is never a turning point, so product is not 0
            root = (square / product).sqrt()
        return self.integrands(sample, product, root)

    def integrands(self, sample: CycleNode, product: Ball, root: Ball) -> list[Ball]:
        """Return the wanted integrands from √(p²/((q − a)(b − q))).

        Args:
            product: (q − a)(b − q), 1 for a rotation.
            root: √(p²/product).
        """
        weights = iter(self.weights.run(sample.q) if self.weights.outputs else ())
        # (dq/dχ)/p = stretch/√R, since dq/dχ = stretch √((q − a)(b − q)) and p = √((q − a)(b − q)) √R
        scale = sample.stretch / root
        return [product * root * sample.stretch if j < 0 else next(weights) * scale for j in self.wanted]


def _entire(tape: Tape) -> bool:
    """Return True where no operation has a singularity, whatever the free input."""
    varying = {0}
    for place, operation in enumerate(tape.operations, len(tape.inputs)):
        if varying.isdisjoint(operation.operands):
            continue
        varying.add(place)
        constant_divisor = operation.code == "div" and operation.operands[1] not in varying
        # quotients by constants and whole powers are polynomials of what they are made of; all else may have a pole or
        # a cut
        positive_power = operation.code == "power" and operation.payload[0] > 0
        if not (operation.code in _ENTIRE or constant_divisor or positive_power):
            return False
    return True
