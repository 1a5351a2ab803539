"""From X, Y, Z in the frame of a web to its coordinates: the inverse of each chart, in doubles or in many digits.

Coordinates of one point are not unique in charts without ends; here the ones that are ≥ 0, or whose cosine is, are
taken as far as they are free. The confocal roots come from their symmetric functions with their order known
(Byrd, Friedman, Handbook of Elliptic Integrals, for the kinds; the cubic by its trigonometric solution). What cancels
is paid for in digits where there are many: the input is exact, and callers take enough of them. In doubles it is made
good by Newton's method (``ensembles.charted``), so no digit has to be right there but the first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Elementwise
from hjsolve.errors import InternalError

Lengths = Mapping[str, Elementwise]
"""Named constants of a chart."""
Point = Sequence[Elementwise]
"""X, Y, Z: numbers, or arrays of one shape."""
_NOISE = 3
"""What is below 2^(−precision/3) of its surroundings is zero in many digits: a place on a coordinate plane."""


def inverse_chart(
    kind: str, X: Point, aside: Point, lengths: Lengths, arithmetic: Float64 | Multi
) -> list[Elementwise]:
    """Return the coordinates of a point, or of many.

    Args:
        kind: of the chart, as in ``Chart.kind``.
        X: the point in the frame of the web.
        aside: the velocity there; on an axis of rotation the azimuth is its direction.
        lengths: named constants of the chart.
        arithmetic: what is computed in.

    Raises:
        InternalError: a kind without an inverse.
    """
    if kind in ("cartesian", "normal modes"):
        return list(X)
    with np.errstate(all="ignore"):
        return _inverse(kind, X, aside, lengths, _Formulas(arithmetic))


def _inverse(kind: str, X: Point, aside: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    ρ = c.hypot(X[0], X[1])
    # on the axis the azimuth is that in which the motion leaves it
    azimuth = c.atan2(c.where(ρ != 0, X[1], aside[1]), c.where(ρ != 0, X[0], aside[0]))
    if kind in ("polar", "circular cylinder"):
        return [ρ, azimuth, *X[2:]]
    if kind.endswith("cylinder"):
        flat = _FLAT_OR_OCTANT[kind.split(maxsplit=1)[0]]
        return [*flat(X[:2], lengths, c), X[2]]
    if kind == "spherical":
        r = c.hypot(ρ, X[2])
        across, along = c.where(r != 0, ρ, c.hypot(aside[0], aside[1])), c.where(r != 0, X[2], aside[2])
        return [r, c.atan2(across, along), azimuth]
    if kind in _MERIDIAN:
        return [*_MERIDIAN[kind]((ρ, X[2]), lengths, c), azimuth]
    if kind not in _FLAT_OR_OCTANT:
        raise InternalError(f"no inverse of the chart {kind}")
    return _FLAT_OR_OCTANT[kind](X, lengths, c)


def _hypot_of_doubles(_: Float64) -> Callable[[Elementwise, Elementwise], Elementwise]:
    return np.hypot


def _no_spacing(_: Float64) -> Elementwise:
    return 0.0


class _Formulas:
    """What the formulas need of an arithmetic."""

    def __init__(self, arithmetic: Float64 | Multi):
        self.arithmetic, self.where, self.atan2 = arithmetic, arithmetic.where, arithmetic.atan2
        self.hypot = arithmetic.choose(_hypot_of_doubles, lambda many: many.context.hypot)
        self.spacing = arithmetic.choose(_no_spacing, lambda many: many.context.mpf(2) ** (-many.bits // _NOISE))

    def of(self, name: str, x: Elementwise) -> Elementwise:
        """Apply a function of one variable."""
        return self.arithmetic.unary(name, x)

    def sqrt(self, x: Elementwise) -> Elementwise:
        return self.of("sqrt", x)

    def root(self, x: Elementwise, size: Elementwise = 1) -> Elementwise:
        """√x of what is no smaller than 0 but for its rounding; 0 where it is rounding."""
        return self.sqrt(self.where(x <= size * self.spacing, 0, x))

    def over(self, above: Elementwise, below: Elementwise, otherwise: Elementwise) -> Elementwise:
        """Return the quotient, or something else where the divisor is 0."""
        return self.where(below != 0, above / self.where(below != 0, below, 1), otherwise)

    def at_least(self, least: Elementwise, x: Elementwise) -> Elementwise:
        return self.where(x < least, least, x)

    def two_roots(self, total: Elementwise, product: Elementwise) -> tuple[Elementwise, Elementwise]:
        """(s, k) ≥ 0 with s − k = total, s·k = product ≥ 0; neither cancels."""
        # the root without cancellation, and the other one as the product over it
        larger = (abs(total) + self.sqrt(total**2 + 4 * product)) / 2
        smaller = self.over(product, larger, 0)
        return self.where(total >= 0, larger, smaller), self.where(total >= 0, smaller, larger)

    def three_roots(self, total: Elementwise, pairs: Elementwise, product: Elementwise) -> list[Elementwise]:
        """Return the real roots of s³ − total·s² + pairs·s − product, rising, by the cosine of a third."""
        middle, width = total / 3, self.sqrt(self.at_least(0, total**2 - 3 * pairs))
        # Viète: all three roots are real, as they are squares of coordinates up to a shift
        cosine = self.over(2 * total**3 - 9 * total * pairs + 27 * product, 2 * width**3, 1)
        # rounding may carry the cosine beyond ±1 where two roots are the same
        angle, turn = self.of("acos", -self.at_least(-1, -self.at_least(-1, cosine))), 2 * self.arithmetic.pi()
        return [middle + 2 * width / 3 * self.of("cos", (angle + shift * turn) / 3) for shift in (1, 2, 0)]


def _parabolic(X: Point, _: Lengths, c: _Formulas) -> list[Elementwise]:
    """X = (u² − v²)/2, Y = uv, so that u² − v² = 2X, u²v² = Y²."""
    u2, v2 = c.two_roots(2 * X[0], X[1] ** 2)
    u = c.sqrt(u2)
    return [u, c.over(X[1], u, c.sqrt(v2))]


def _elliptic(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """sinh²μ − sin²ν = (X² + Y²)/a² − 1, sinh²μ sin²ν = Y²/a²."""
    x, y = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = c.two_roots(x**2 + y**2 - 1, y**2)
    s = c.sqrt(s2)
    return [c.of("asinh", s), c.atan2(c.over(y, s, c.sqrt(k2)), x / c.sqrt(1 + s2))]


def _rotational_parabolic(X: Point, _: Lengths, c: _Formulas) -> list[Elementwise]:
    """ρ = uv, z = (u² − v²)/2."""
    return [c.sqrt(s) for s in c.two_roots(2 * X[1], X[0] ** 2)]


def _prolate(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """ρ = a sinh μ sin ν, z = a cosh μ cos ν."""
    return _elliptic((X[1], X[0]), lengths, c)


def _oblate(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """ρ = a cosh μ sin ν, z = a sinh μ cos ν; sinh²μ − cos²ν = (ρ² + z²)/a² − 1."""
    ρ, z = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = c.two_roots(ρ**2 + z**2 - 1, z**2)
    s = c.sqrt(s2)
    return [c.of("asinh", s), c.atan2(ρ / c.sqrt(1 + s2), c.over(z, s, c.sqrt(k2)))]


def _conical(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """With n = X/r: high − low = (e₃ − e₁)n₁² − (e₂ − e₁) + (e₃ − e₂)n₂², high·low = (e₂ − e₁)(e₃ − e₂)n₂²."""
    e1, e2, e3 = (lengths[f"e{i}"] for i in (1, 2, 3))
    r = c.sqrt(X[0] ** 2 + X[1] ** 2 + X[2] ** 2)
    n = [c.over(x, r, x) for x in X]
    first, second, scale = e2 - e1, e3 - e2, c.sqrt(e3 - e1)
    high, low = c.two_roots((e3 - e1) * n[0] ** 2 - first + second * n[1] ** 2, first * second * n[1] ** 2)
    cosine = c.root(low / first)
    sine = c.over(n[1], cosine, c.root(high / second))
    # by tangents: an arcsine next to ±1 would have half of the digits
    χ = c.atan2(n[0] * scale / c.sqrt(first + high), cosine)
    return [r, χ, c.atan2(sine, n[2] * scale / c.sqrt(second + low))]


def _ellipsoidal(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """Return the roots u < v < w of Π(s − aᵢ) − Σ xᵢ² Π_{j≠i}(s − aⱼ), x = X/a."""
    a, b = lengths["a"], [lengths[f"a{i}"] for i in (1, 2, 3)]
    x = [value / a for value in X]
    squares = [value**2 for value in x]
    pairs = [b[1] + b[2], b[0] + b[2], b[0] + b[1]]
    products = [b[1] * b[2], b[0] * b[2], b[0] * b[1]]
    u, v, w = c.three_roots(
        sum(b) + sum(squares),
        b[0] * b[1] + b[0] * b[2] + b[1] * b[2] + sum(s * p for s, p in zip(squares, pairs, strict=True)),
        b[0] * b[1] * b[2] + sum(s * p for s, p in zip(squares, products, strict=True)),
    )
    first, second, whole = b[1] - b[0], b[2] - b[1], b[2] - b[0]
    size = whole + sum(squares)
    cosine, other = c.root((b[1] - u) / first, size / first), c.root((b[2] - v) / second, size / second)
    high = c.at_least(0, w - b[2]) / second
    # bounds of the intervals u < a₂ < v < a₃ < w, which rounding may leave
    above, below = c.at_least(first, v - b[0]), c.at_least(second, b[2] - u)
    χ = c.atan2(x[0] / c.sqrt(above * (w - b[0]) / whole), cosine)
    sine = c.over(x[1], cosine * c.sqrt((1 + high) * second), c.root((v - b[1]) / second, size / second))
    rest = c.sqrt(second * below / whole)
    return [χ, c.atan2(sine, other), c.of("asinh", c.over(x[2], other * rest, c.sqrt(high)))]


def _paraboloidal(X: Point, lengths: Lengths, c: _Formulas) -> list[Elementwise]:
    """Return the roots u < v < w of (s − 2x)(s − b)(s − c) − y²(s − c) − z²(s − b), (x, y, z) = X/a."""
    a, b, e = (lengths[name] for name in ("a", "b", "c"))
    x, y, z = (value / a for value in X)
    u, v, w = c.three_roots(2 * x + b + e, 2 * x * (b + e) + b * e - y**2 - z**2, 2 * x * b * e - y**2 * e - z**2 * b)
    d = e - b
    size = d + abs(x) + abs(y) + abs(z)
    low, other = c.root((b - u) / d, size / d), c.root((e - v) / d, size / d)
    high = c.at_least(0, w - e) / d
    sine = c.over(y, d * low * c.sqrt(1 + high), c.root((v - b) / d, size / d))
    last = c.over(z, d * c.sqrt(1 + low**2) * other, c.sqrt(high))
    return [c.of("asinh", low), c.atan2(sine, other), c.of("asinh", last)]


_Inverse = Callable[[Point, Lengths, _Formulas], list[Elementwise]]
_FLAT_OR_OCTANT: Mapping[str, _Inverse] = {
    "parabolic": _parabolic, "elliptic": _elliptic, "conical": _conical, "ellipsoidal": _ellipsoidal,
    "paraboloidal": _paraboloidal,
}  # fmt: skip
_MERIDIAN: Mapping[str, _Inverse] = {
    "rotational parabolic": _rotational_parabolic,
    "prolate spheroidal": _prolate,
    "oblate spheroidal": _oblate,
}
