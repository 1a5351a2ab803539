"""The anomaly: one change of variable that makes every integral of the motion regular.

A bounded coordinate moves between a and b like q = m − h cos χ; over the anomaly χ the integrands
p dq and dq/p are analytic and periodic, so that equally spaced nodes converge geometrically. Where
another zero of p² (d < a or c > b) or a pole comes near, the plain anomaly needs many nodes; the
elliptic one sends a, b, c, d to 0, 1, 1/k², ∞ by w = sn²(u | k²), which spreads them evenly:

    q − a = W sn²/D,   b − q = W (1 + ρ_d) cn²/D,   D = 1 + ρ_d cn²,   W = b − a,
    ρ_d = W/(a − d),   ρ_c = W/(c − b),   k′² = 1/((1 + ρ_c)(1 + ρ_d)),   χ = π u/K,
    dq/√((q−a)(b−q)) = (2K/π) √((1 + ρ_c (b−q)/W)(1 + ρ_d (q−a)/W)) k′ dχ      (Byrd & Friedman 254-256)

With ρ_c = ρ_d = 0 this is q = m − h cos χ. A rotating angle uses q = q₀ ± (2 am u − π) in the same
way, the slow place q₀ where p² is least at χ = π. Differences q − a and b − q never cancel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hjsolve.numeric.arithmetic import Float64, Multi
from hjsolve.numeric.elliptic import jacobi, quarter_period


class Place(NamedTuple):
    """Where the anomaly χ puts the coordinate.

    Attributes:
        q: position.
        speed: dq/dχ, with the sign of the motion.
        product: (q − a)(b − q), or 1 for a rotation.
        stretch: |dq/dχ| / √product.
    """

    q: Any
    speed: Any
    product: Any
    stretch: Any


@dataclass(frozen=True)
class Libration:
    """To and fro between two turning points; χ = 0 at the lower one, π at the upper one.

    Attributes:
        lower: a.
        width: b − a, known to full relative precision.
        upper: b.
        near_lower: ρ_d; 0 where nothing is near.
        near_upper: ρ_c.
        complement, quarter: k′² and K.
    """

    lower: Any
    width: Any
    upper: Any
    near_lower: Any
    near_upper: Any
    complement: Any
    quarter: Any

    even = True
    direction = 1

    def place(self, χ: Any, arithmetic: Float64 | Multi) -> Place:
        """Return the place at χ, |χ| ≤ 2π."""
        sn, cn, _ = jacobi(χ * self.quarter / arithmetic.pi(), self.complement, self.quarter, arithmetic)
        denominator = 1 + self.near_lower * cn * cn
        from_lower = self.width * (sn * sn / denominator)
        to_upper = self.width * ((1 + self.near_lower) * cn * cn / denominator)
        root = self.width * (arithmetic.unary("sqrt", 1 + self.near_lower) * sn * cn / denominator)
        ends = (1 + self.near_upper * (to_upper / self.width)) * (1 + self.near_lower * (from_lower / self.width))
        stretch = 2 * self.quarter / arithmetic.pi() * arithmetic.unary("sqrt", ends * self.complement)
        q = _nearer(from_lower, to_upper, self.lower, self.upper)
        return Place(q, root * stretch, from_lower * to_upper, stretch)

    def phase(self, q: Any, forward: int, arithmetic: Multi) -> Any:
        """Return χ in (−π, π] of a position; ``forward`` is the sign of p, 0 at a turning point."""
        x = (q - self.lower) / self.width
        y = (self.upper - q) / self.width
        if forward == 0:
            return arithmetic.pi() if x > y else 0 * x
        context = arithmetic.context
        sine = context.sqrt(abs(x) * (1 + self.near_lower))
        amplitude = context.atan2(sine, context.sqrt(abs(y)))
        return forward * arithmetic.pi() * context.ellipf(amplitude, 1 - self.complement) / self.quarter


@dataclass(frozen=True)
class Rotation:
    """An angle that goes round; χ grows by 2π a turn, whichever way the motion goes.

    Attributes:
        slow: q₀, where p² is least (χ = π).
        direction: +1 or −1, the sign of p.
        complement, quarter: k′² and K.
    """

    slow: Any
    direction: int
    complement: Any
    quarter: Any

    even = False

    def place(self, χ: Any, arithmetic: Float64 | Multi) -> Place:
        """Return the place at χ, |χ| ≤ 2π; q is not reduced to one turn."""
        sn, cn, dn = jacobi(χ * self.quarter / arithmetic.pi(), self.complement, self.quarter, arithmetic)
        amplitude = np.arctan2(sn, cn) if isinstance(arithmetic, Float64) else arithmetic.context.atan2(sn, cn)
        stretch = 2 * self.quarter / arithmetic.pi() * dn
        q = self.slow + self.direction * (2 * amplitude - arithmetic.pi())
        return Place(q, self.direction * stretch, 0 * q + 1, stretch)

    def phase(self, q: Any, forward: int, arithmetic: Multi) -> Any:  # noqa: ARG002  (asked like a libration's)
        """Return χ in (−π, π] of a position."""
        context = arithmetic.context
        angle = self.direction * (q - self.slow) + arithmetic.pi()
        angle -= 2 * arithmetic.pi() * context.nint(angle / (2 * arithmetic.pi()))
        return arithmetic.pi() * context.ellipf(angle / 2, 1 - self.complement) / self.quarter


Anomaly = Libration | Rotation


def libration(lower: Any, upper: Any, below: Any | None, above: Any | None, arithmetic: Multi) -> Libration:
    """Make the anomaly between two turning points.

    Args:
        lower, upper: a < b.
        below, above: the nearest zero or pole of p² outside, None where there is none.
        arithmetic: precision of all of them.
    """
    width = upper - lower
    near_lower = width / (lower - below) if below is not None else 0 * width
    near_upper = width / (above - upper) if above is not None else 0 * width
    complement = 1 / ((1 + near_lower) * (1 + near_upper))
    return Libration(lower, width, upper, near_lower, near_upper, complement, quarter_period(complement, arithmetic))


def rotation(slow: Any, direction: int, gap: Any, arithmetic: Multi) -> Rotation:
    """Make the anomaly of a rotating angle.

    Args:
        slow: place of least p².
        direction: sign of p.
        gap: distance of the complex zero of p² next to ``slow`` from the real axis; None where it is far.
        arithmetic: precision of all of them.
    """
    one = arithmetic.rational(1, 1)
    complement = one if gap is None else (gap / 2) ** 2 / (1 + (gap / 2) ** 2)
    return Rotation(slow, direction, complement, quarter_period(complement, arithmetic))


def as_float(anomaly: Anomaly) -> Anomaly:
    """Round the constants of an anomaly to doubles, for vectorised use."""
    values = {name: getattr(anomaly, name) for name in anomaly.__dataclass_fields__}
    rounded: dict[str, Any] = {name: v if isinstance(v, int) else float(v) for name, v in values.items()}
    return type(anomaly)(**rounded)


def _nearer(from_lower: Any, to_upper: Any, lower: Any, upper: Any) -> Any:
    """Q from the end that keeps its relative accuracy."""
    if isinstance(from_lower, np.ndarray):
        return np.where(from_lower < to_upper, lower + from_lower, upper - to_upper)
    return lower + from_lower if from_lower < to_upper else upper - to_upper
