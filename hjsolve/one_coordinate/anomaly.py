"""The anomaly: one change of variable that makes every integral of the motion regular.

A bounded coordinate moves between a and b like q = m − h cos χ; over the anomaly χ the integrands
p dq and dq/p are analytic and periodic, so that equally spaced nodes converge geometrically. Where
another zero of p² (d < a or c > b) or a pole comes near, the plain anomaly needs many nodes; the
elliptic one sends a, b, c, d to 0, 1, 1/k², ∞ by w = sn²(u | k²), which spreads them evenly:

    q − a = W sn²/D,   b − q = W (1 + ρ_d) cn²/D,   D = 1 + ρ_d cn²,   W = b − a,
    ρ_d = W/(a − d),   ρ_c = W/(c − b),   k′² = 1/((1 + ρ_c)(1 + ρ_d)),   χ = π u/K,
    dq/√((q−a)(b−q)) = (2K/π) √((1 + ρ_c (b−q)/W)(1 + ρ_d (q−a)/W)) k′ dχ      (Byrd & Friedman 254-256)

With ρ_c = ρ_d = 0 this is q = m − h cos χ. Where it is a complex pair c ± iδ that comes near the inside of the
motion (a barrier that is just overcome), the four are a, b, c ± iδ, and the map is (Byrd & Friedman 259)

    (q − a)/(b − q) = (A/B) tan²(φ/2),   φ = am(2Kχ/π),   A² = (c − a)² + δ²,   B² = (b − c)² + δ²,
    k′² = ((A + B)² − W²)/(4AB),         dq/√((q−a)(b−q)) = (2K/π) dn √(AB)/(A sin²(φ/2) + B cos²(φ/2)) dχ.

A rotating angle uses q = q₀ ± (2 am u − π) in the same
way, the slow place q₀ where p² is least at χ = π. Differences q − a and b − q never cancel.
"""

from __future__ import annotations

from dataclasses import dataclass

from hjsolve.arithmetic.elliptic import jacobi, quarter_period
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Mpf, Numeric, Truth
from hjsolve.one_coordinate.phase_map import Place, Unstretched


@dataclass(frozen=True)
class Libration(Unstretched):
    """To and fro between two turning points; χ = 0 at the lower one, π at the upper one.

    Attributes:
        lower: a.
        width: b − a, known to full relative precision.
        upper: b.
        near_lower: ρ_d; 0 where nothing is near.
        near_upper: ρ_c.
        complement, quarter: k′² and K.
    """

    lower: Mpf
    width: Mpf
    upper: Mpf
    near_lower: Mpf
    near_upper: Mpf
    complement: Mpf
    quarter: Mpf

    even = True
    direction = 1

    def place(self, χ: Numeric, arithmetic: Float64 | Multi) -> Place:
        # u = Kχ/π: χ = 0, π, 2π are u = 0, K, 2K, at which sn² is 0, 1, 0
        sn, cn, _ = jacobi(χ * self.quarter / arithmetic.pi(), self.complement, self.quarter, arithmetic)
        # D of Byrd & Friedman 254-256; it is positive for ρ_d > −1
        denominator = 1 + self.near_lower * cn * cn
        from_lower = self.width * (sn * sn / denominator)
        # b − q from cn², not as W less q − a: next to b it has all its digits
        to_upper = self.width * ((1 + self.near_lower) * cn * cn / denominator)
        # √((q − a)(b − q)) with the sign of sn cn: dq/dχ changes its sign at the turning points
        root = self.width * (arithmetic.unary("sqrt", 1 + self.near_lower) * sn * cn / denominator)
        ends = (1 + self.near_upper * (to_upper / self.width)) * (1 + self.near_lower * (from_lower / self.width))
        stretch = 2 * self.quarter / arithmetic.pi() * arithmetic.unary("sqrt", ends * self.complement)
        q = _nearer(from_lower, to_upper, self, arithmetic)
        return Place(q, root * stretch, from_lower * to_upper, stretch, 1, from_lower, to_upper)

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:
        """Return χ in (−π, π] of a position; ``forward`` is the sign of p, 0 at a turning point.

        Args:
            q: position between the turning points.
            forward: sign of p, 0 at a turning point.
            arithmetic: in which χ is worked out.
        """
        x = (q - self.lower) / self.width
        y = (self.upper - q) / self.width
        # p = 0 is a turning point: χ is 0 or π exactly, whatever the rounding of x and y says
        if forward == 0:
            return arithmetic.pi() if x > y else 0 * x
        context = arithmetic.context
        sine = context.sqrt(abs(x) * (1 + self.near_lower))
        # tan²am = (1 + ρ_d) x/y: the arctangent of both roots keeps its digits next to either end
        amplitude = context.atan2(sine, context.sqrt(abs(y)))
        return forward * arithmetic.pi() * context.ellipf(amplitude, 1 - self.complement) / self.quarter


@dataclass(frozen=True)
class BarrierAnomaly(Unstretched):
    """A libration that passes over a low barrier; χ as in ``Libration``, slow at the maximum.

    Attributes:
        lower: a.
        width: b − a, known to full relative precision.
        upper: b.
        from_lower, from_upper: A/W and B/W, distances of the complex pair from the turning points.
        complement, quarter: k′² and K.
    """

    lower: Mpf
    width: Mpf
    upper: Mpf
    from_lower: Mpf
    from_upper: Mpf
    complement: Mpf
    quarter: Mpf

    even = True
    direction = 1

    def place(self, χ: Numeric, arithmetic: Float64 | Multi) -> Place:
        # a turn of χ is one period 4K of cn: χ is reduced to it before it is multiplied
        reduced = χ - 2 * arithmetic.pi() * arithmetic.rint(χ / (2 * arithmetic.pi()))
        sn, cn, dn = jacobi(2 * reduced * self.quarter / arithmetic.pi(), self.complement, self.quarter, arithmetic)
        # sin²(φ/2) = (1 − cos φ)/2 cancels where cos φ is near 1: sin²φ/(2(1 + |cos φ|)) does not
        size = arithmetic.unary("abs", cn)
        small, large = sn * sn / (1 + size) / 2, (1 + size) / 2
        low, high = _ordered(small, large, cn > 0, arithmetic)  # sin²(φ/2), cos²(φ/2)
        denominator = self.from_lower * low + self.from_upper * high
        mean = arithmetic.unary("sqrt", self.from_lower * self.from_upper)
        from_lower = self.width * (self.from_lower * low / denominator)
        to_upper = self.width * (self.from_upper * high / denominator)
        stretch = 2 * self.quarter / arithmetic.pi() * dn * mean / denominator
        q = _nearer(from_lower, to_upper, self, arithmetic)
        speed = self.width * mean * sn / 2 / denominator * stretch
        return Place(q, speed, from_lower * to_upper, stretch, 1, from_lower, to_upper)

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:
        """Return χ in (−π, π] of a position; ``forward`` is the sign of p, 0 at a turning point."""
        x = (q - self.lower) / self.width
        y = (self.upper - q) / self.width
        if forward == 0:
            return arithmetic.pi() if x > y else 0 * x
        context = arithmetic.context
        # tan²(φ/2) = (B/A) (q − a)/(b − q), the map solved for φ
        amplitude = 2 * context.atan2(context.sqrt(abs(x) * self.from_upper), context.sqrt(abs(y) * self.from_lower))
        return forward * arithmetic.pi() * context.ellipf(amplitude, 1 - self.complement) / (2 * self.quarter)


@dataclass(frozen=True)
class Rotation(Unstretched):
    """An angle that goes round; χ grows by 2π a turn, whichever way the motion goes.

    Attributes:
        slow: q₀, where p² is least (χ = π).
        direction: +1 or −1, the sign of p.
        complement, quarter: k′² and K.
    """

    slow: Mpf
    direction: int
    complement: Mpf
    quarter: Mpf

    even = False

    def place(self, χ: Numeric, arithmetic: Float64 | Multi) -> Place:
        """Return the place at χ, |χ| ≤ 2π; q is not reduced to one turn."""
        sn, cn, dn = jacobi(χ * self.quarter / arithmetic.pi(), self.complement, self.quarter, arithmetic)
        # am from its sine and cosine: an arctangent of sn/cn would lose the half turn
        amplitude = arithmetic.atan2(sn, cn)
        stretch = 2 * self.quarter / arithmetic.pi() * dn
        q = self.slow + self.direction * (2 * amplitude - arithmetic.pi())
        return Place(q, self.direction * stretch, 0 * q + 1, stretch)

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:  # noqa: ARG002  (asked like a libration's)
        """Return χ in (−π, π] of a position."""
        context = arithmetic.context
        angle = self.direction * (q - self.slow) + arithmetic.pi()
        # one turn of the angle is one of χ: what is left lies in (−π, π]
        angle -= 2 * arithmetic.pi() * context.nint(angle / (2 * arithmetic.pi()))
        return arithmetic.pi() * context.ellipf(angle / 2, 1 - self.complement) / self.quarter


@dataclass(frozen=True)
class TwoBarrierAnomaly(Unstretched):
    """An angle that goes round over two barriers; χ as in ``Rotation``, slow at both.

    A Möbius map of the circle carries the two barriers, as complex pairs, to w = 0 and w = π with equal gaps; there
    w = am(v + K) − π/2, v = 2K(χ − π)/π, is slow at both: cos w = cd v, sin w = k′ sd v.

    Attributes:
        slow: the place of w = 0, at the highest maximum (χ = π).
        direction: +1 or −1, the sign of p.
        scale, tilt: the map tan((q − slow)/2) = Y/(scale + tilt Y), Y = tan(w/2), for motion upward.
        complement, quarter: k′² and K.
    """

    slow: Mpf
    direction: int
    scale: Mpf
    tilt: Mpf
    complement: Mpf
    quarter: Mpf

    even = False

    def place(self, χ: Numeric, arithmetic: Float64 | Multi) -> Place:
        """Return the place at χ, |χ| ≤ 2π; q is not reduced to one turn."""
        pi, root = arithmetic.pi(), arithmetic.unary("sqrt", self.complement)
        turn = arithmetic.rint((χ - pi) / (2 * pi))
        sn, cn, dn = jacobi(2 * self.quarter * ((χ - pi) / pi - 2 * turn), self.complement, self.quarter, arithmetic)
        cosine, sine = cn / dn, root * sn / dn
        # half angles by the root that does not cancel; the other one from sin w = 2 sin(w/2) cos(w/2)
        large = arithmetic.unary("sqrt", (1 + arithmetic.unary("abs", cosine)) / 2)
        size = arithmetic.unary("abs", sine)
        s, c = _ordered(size / (2 * large), large, cosine > 0, arithmetic)  # |sin w/2|, cos w/2
        s = arithmetic.copysign(s, sine)
        beside = self.scale * c + self.direction * self.tilt * s
        angle = arithmetic.atan2(s, beside)
        stretch = self.scale / (s * s + beside * beside) * root / dn * 2 * self.quarter / pi
        q = self.slow + self.direction * (2 * angle + 2 * pi * turn)
        return Place(q, self.direction * stretch, 0 * q + 1, stretch)

    def phase(self, q: Mpf, forward: int, arithmetic: Multi) -> Mpf:  # noqa: ARG002  (asked like a libration's)
        """Return χ in (−π, π] of a position."""
        context, pi = arithmetic.context, arithmetic.pi()
        half = self.direction * (q - self.slow) / 2
        half -= pi * context.nint(half / pi)
        sine, cosine = context.sin(half), context.cos(half)
        # the Möbius map of tan((q − slow)/2), solved for Y = tan(w/2)
        w = 2 * context.atan2(self.scale * sine, cosine - self.direction * self.tilt * sine)
        # w = am(v + K) − π/2, so that w = 0 is v = 0
        v = context.ellipf(w + pi / 2, 1 - self.complement) - self.quarter
        χ = pi + pi * v / (2 * self.quarter)
        return χ - 2 * pi * context.ceil((χ - pi) / (2 * pi))


Anomaly = Libration | BarrierAnomaly | Rotation | TwoBarrierAnomaly


def libration_anomaly(lower: Mpf, upper: Mpf, below: Mpf | None, above: Mpf | None, arithmetic: Multi) -> Libration:
    """Make the anomaly between two turning points.

    Args:
        lower, upper: a < b.
        below, above: the nearest zero or pole of p² outside, None where there is none.
        arithmetic: precision of all of them.
    """
    width = upper - lower
    # no zero near: ρ = 0, for which the elliptic map is the plain one
    near_lower = width / (lower - below) if below is not None else 0 * width
    near_upper = width / (above - upper) if above is not None else 0 * width
    # k′² must not exceed 1: c and d change their places in the cross ratio
    if (1 + near_lower) * (1 + near_upper) < 1:  # on one side of the motion, c between it and d
        near_lower, near_upper = -near_upper / (1 + near_upper), -near_lower / (1 + near_lower)
    complement = 1 / ((1 + near_lower) * (1 + near_upper))
    return Libration(lower, width, upper, near_lower, near_upper, complement, quarter_period(complement, arithmetic))


def barrier_anomaly(lower: Mpf, upper: Mpf, barrier_top: Mpf, gap: Mpf, arithmetic: Multi) -> BarrierAnomaly:
    """Make the anomaly between two turning points with a barrier just overcome between them.

    Args:
        lower, upper: a < b.
        barrier_top, gap: the complex pair crest ± i·gap next to the motion, a < crest < b.
        arithmetic: precision of all of them.
    """
    width = upper - lower
    left, right, δ = ((x / width) for x in (barrier_top - lower, upper - barrier_top, gap))
    A, B = (arithmetic.unary("sqrt", x * x + δ * δ) for x in (left, right))
    # A − left = δ²/(A + left): the difference of two nearly equal lengths is written without one
    excess = δ * δ / (A + left) + δ * δ / (B + right)  # (A + B) − W, which may be tiny
    # k′² = ((A + B)² − W²)/(4AB) with W = 1, as a product of sum and difference
    complement = excess * (A + B + 1) / (4 * A * B)
    return BarrierAnomaly(lower, width, upper, A, B, complement, quarter_period(complement, arithmetic))


def rotation_anomaly(slow: Mpf, direction: int, gap: Mpf | None, arithmetic: Multi) -> Rotation:
    """Make the anomaly of a rotating angle.

    Args:
        slow: place of least p².
        direction: sign of p.
        gap: distance of the complex zero of p² next to ``slow`` from the real axis; None where it is far.
        arithmetic: precision of all of them.
    """
    one = arithmetic.rational(1, 1)
    # dn vanishes at χ = π + iK′π/K; k′ = tanh(gap/2), of which this is the second order, puts the zero of p² there
    complement = one if gap is None else (gap / 2) ** 2 / (1 + (gap / 2) ** 2)
    return Rotation(slow, direction, complement, quarter_period(complement, arithmetic))


def two_barrier_anomaly(
    barrier_top: Mpf, gap: Mpf, other: Mpf, other_gap: Mpf, direction: int, arithmetic: Multi
) -> TwoBarrierAnomaly:
    """Make the anomaly of an angle that goes round over two barriers.

    In the upper half plane of tan((q − crest)/2) the pairs are z₁ = i tanh(gap/2) and z₂; the real Möbius map that
    takes iε to z₁ and i/ε to z₂ exists when both pairs have the same hyperbolic distance, 2 ln(1/ε).

    Args:
        barrier_top, gap: the highest maximum of V, a complex pair crest ± i·gap.
        other, other_gap: the second one.
        direction: sign of p.
        arithmetic: precision of all of them.
    """
    context = arithmetic.context
    # the circle as a line by Y = tan(q/2): crest ± i·gap becomes ± i tanh(gap/2)
    e1 = context.tanh(gap / 2)
    z2 = context.tan(context.mpc(other - barrier_top, other_gap) / 2)
    x2, e2 = z2.real, z2.imag
    # cosh of the hyperbolic distance of z₁ and z₂, less 1: next to 0 it keeps its digits
    ρ = (x2 * x2 + (e2 - e1) ** 2) / (2 * e1 * e2)
    # ε² = e^(−distance): the pairs iε and i/ε lie as far apart as z₁ and z₂
    ε = context.sqrt(1 / (1 + ρ + context.sqrt(ρ * (ρ + 2))))
    # (A Y + B)/(C Y + D) with determinant 1 takes iε to z₁: Im z₁ = ε/|C iε + D|² gives C and D
    C = context.sqrt(max(0 * ε, (1 / (ε * e2) - ε / e1) / (1 / ε**2 - ε**2))) * (1 if x2 > 0 else -1)
    D = context.sqrt(ε / e1 - (C * ε) ** 2)
    A, B = D * e1 / ε, -C * ε * e1
    complement = (2 * ε / (1 + ε * ε)) ** 2
    return TwoBarrierAnomaly(
        barrier_top + 2 * context.atan2(B, D), direction, B * B + D * D, A * B + C * D, complement,
        quarter_period(complement, arithmetic),
    )  # fmt: skip


def _ordered(small: Numeric, large: Numeric, order: Truth, arithmetic: Float64 | Multi) -> tuple[Numeric, Numeric]:
    """(small, large) where ``order`` holds, (large, small) elsewhere."""
    return arithmetic.where(order, small, large), arithmetic.where(order, large, small)


def _nearer(
    from_lower: Numeric, to_upper: Numeric, ends: Libration | BarrierAnomaly, arithmetic: Float64 | Multi
) -> Numeric:
    """Return q, counted from the end that keeps its relative accuracy."""
    return arithmetic.where(abs(from_lower) < abs(to_upper), ends.lower + from_lower, ends.upper - to_upper)
