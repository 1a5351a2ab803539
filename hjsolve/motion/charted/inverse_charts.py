"""From X, Y, Z in the frame of a web to its coordinates: the inverse of each chart, in any number of digits.

Coordinates of one point are not unique in charts without ends; here the ones that are ≥ 0, or whose cosine is, are
taken as far as they are free. The confocal roots come from their symmetric functions with their order known
(Byrd, Friedman, Handbook of Elliptic Integrals, for the kinds; the cubic by its trigonometric solution). What cancels
is paid for in digits: the input is exact, and callers take enough of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.errors import InternalError

Lengths = Mapping[str, Mpf]
"""Named constants of a chart."""
_NOISE = 3
"""What is below 2^(−precision/3) of its surroundings is zero: a place on a coordinate plane."""


def inverse_chart(kind: str, X: Sequence[Mpf], aside: Sequence[Mpf], lengths: Lengths, context: Context) -> list[Mpf]:
    """Return the coordinates of a point.

    Args:
        kind: of the chart, as in ``Chart.kind``.
        X: the point in the frame of the web.
        aside: the velocity there; on an axis of rotation the azimuth is its direction.
        lengths: named constants of the chart.
        context: of mpmath, to the precision of which is computed.

    Raises:
        InternalError: a kind without an inverse.
    """
    if kind in ("cartesian", "normal modes"):
        return list(X)
    ρ = context.hypot(X[0], X[1])
    direction = X if ρ else aside
    azimuth = context.atan2(direction[1], direction[0]) if any(direction[:2]) else context.zero
    if kind in ("polar", "circular cylinder"):
        return [ρ, azimuth, *X[2:]]
    if kind.endswith("cylinder"):
        flat = _FLAT_OR_OCTANT[kind.split(maxsplit=1)[0]]
        return [*flat(X[:2], lengths, context), X[2]]
    if kind == "spherical" and not ρ and not X[2]:
        return [ρ, context.atan2(context.hypot(aside[0], aside[1]), aside[2]), azimuth]
    if kind in _MERIDIAN:
        return [*_MERIDIAN[kind]((ρ, X[2]), lengths, context), azimuth]
    if kind not in _FLAT_OR_OCTANT:
        raise InternalError(f"no inverse of the chart {kind}")
    return _FLAT_OR_OCTANT[kind](X, lengths, context)


def _root(x: Mpf, size: Mpf, c: Context) -> Mpf:
    """√x of what is no smaller than 0 but for its rounding; 0 where it is rounding."""
    return c.zero if x <= size * c.mpf(2) ** (-c.prec // _NOISE) else c.sqrt(x)


def _two_roots(total: Mpf, product: Mpf, c: Context) -> tuple[Mpf, Mpf]:
    """Return (s, k) ≥ 0 with s − k = total, s·k = product ≥ 0; neither cancels."""
    width = c.sqrt(total**2 + 4 * product)
    larger = (abs(total) + width) / 2
    smaller = product / larger if larger else c.zero
    return (larger, smaller) if total >= 0 else (smaller, larger)


def _parabolic(X: Sequence[Mpf], _: Lengths, c: Context) -> list[Mpf]:
    """X = (u² − v²)/2, Y = uv, so that u² − v² = 2X, u²v² = Y²."""
    u2, v2 = _two_roots(2 * X[0], X[1] ** 2, c)
    u = c.sqrt(u2)
    return [u, X[1] / u if u else c.sqrt(v2)]


def _elliptic(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """sinh²μ − sin²ν = (X² + Y²)/a² − 1, sinh²μ sin²ν = Y²/a²."""
    x, y = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = _two_roots(x**2 + y**2 - 1, y**2, c)
    s = c.sqrt(s2)
    sine = y / s if s else c.sqrt(k2)
    return [c.asinh(s), c.atan2(sine, x / c.sqrt(1 + s2))]


def _spherical(X: Sequence[Mpf], _: Lengths, c: Context) -> list[Mpf]:
    return [c.hypot(X[0], X[1]), c.atan2(X[0], X[1])]


def _rotational_parabolic(X: Sequence[Mpf], _: Lengths, c: Context) -> list[Mpf]:
    """ρ = uv, z = (u² − v²)/2."""
    return [c.sqrt(s) for s in _two_roots(2 * X[1], X[0] ** 2, c)]


def _prolate(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """ρ = a sinh μ sin ν, z = a cosh μ cos ν."""
    return _elliptic((X[1], X[0]), lengths, c)


def _oblate(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """ρ = a cosh μ sin ν, z = a sinh μ cos ν; sinh²μ − cos²ν = (ρ² + z²)/a² − 1."""
    ρ, z = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = _two_roots(ρ**2 + z**2 - 1, z**2, c)
    s = c.sqrt(s2)
    return [c.asinh(s), c.atan2(ρ / c.sqrt(1 + s2), z / s if s else c.sqrt(k2))]


def _conical(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """With n = X/r: high − low = (e₃ − e₁)n₁² − (e₂ − e₁) + (e₃ − e₂)n₂², high·low = (e₂ − e₁)(e₃ − e₂)n₂²."""
    e1, e2, e3 = (lengths[f"e{i}"] for i in (1, 2, 3))
    r = c.sqrt(sum(x**2 for x in X))
    if not r:
        return [c.zero, c.zero, c.zero]
    n = [x / r for x in X]
    first, second = e2 - e1, e3 - e2
    high, low = _two_roots((e3 - e1) * n[0] ** 2 - first + second * n[1] ** 2, first * second * n[1] ** 2, c)
    cosine = _root(low / first, c.one, c)
    sine = n[1] / cosine if cosine else _root(high / second, c.one, c)
    scale = c.sqrt(e3 - e1)
    χ = c.atan2(n[0] * scale / c.sqrt(first + high), cosine)
    return [r, χ, c.atan2(sine, n[2] * scale / c.sqrt(second + low))]


def _ellipsoidal(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """Return the roots u < v < w of Π(s − aᵢ) − Σ xᵢ² Π_{j≠i}(s − aⱼ), x = X/a."""
    a, b = lengths["a"], [lengths[f"a{i}"] for i in (1, 2, 3)]
    x = [value / a for value in X]
    squares = [value**2 for value in x]
    pairs = [b[1] + b[2], b[0] + b[2], b[0] + b[1]]
    products = [b[1] * b[2], b[0] * b[2], b[0] * b[1]]
    u, v, w = _three_roots(
        sum(b, c.zero) + sum(squares, c.zero),
        b[0] * b[1] + b[0] * b[2] + b[1] * b[2] + sum(s * p for s, p in zip(squares, pairs, strict=True)),
        b[0] * b[1] * b[2] + sum(s * p for s, p in zip(squares, products, strict=True)),
        c,
    )
    first, second, whole = b[1] - b[0], b[2] - b[1], b[2] - b[0]
    size = whole + sum(squares)
    cosine = _root((b[1] - u) / first, size / first, c)
    other = _root((b[2] - v) / second, size / second, c)
    high = max(w - b[2], c.zero) / second
    above, below = max(v - b[0], first), max(b[2] - u, second)
    χ = c.atan2(x[0] / c.sqrt(above * (w - b[0]) / whole), cosine)
    sine = x[1] / (cosine * c.sqrt((1 + high) * second)) if cosine else _root((v - b[1]) / second, size / second, c)
    rest = c.sqrt(second * below / whole)
    return [χ, c.atan2(sine, other), c.asinh(x[2] / (other * rest) if other else c.sqrt(high))]


def _paraboloidal(X: Sequence[Mpf], lengths: Lengths, c: Context) -> list[Mpf]:
    """Return the roots u < v < w of (s − 2x)(s − b)(s − c) − y²(s − c) − z²(s − b), (x, y, z) = X/a."""
    a, b, e = (lengths[name] for name in ("a", "b", "c"))
    x, y, z = (value / a for value in X)
    u, v, w = _three_roots(2 * x + b + e, 2 * x * (b + e) + b * e - y**2 - z**2, 2 * x * b * e - y**2 * e - z**2 * b, c)
    d = e - b
    size = d + abs(x) + abs(y) + abs(z)
    low = _root((b - u) / d, size / d, c)
    other = _root((e - v) / d, size / d, c)
    high = max(w - e, c.zero) / d
    sine = y / (d * low * c.sqrt(1 + high)) if low else _root((v - b) / d, size / d, c)
    return [
        c.asinh(low), c.atan2(sine, other),
        c.asinh(z / (d * c.sqrt(1 + low**2) * other) if other else c.sqrt(high)),
    ]  # fmt: skip


def _three_roots(total: Mpf, pairs: Mpf, product: Mpf, c: Context) -> list[Mpf]:
    """Return real roots of s³ − total·s² + pairs·s − product in rising order, by the cosine of a third of an angle."""
    middle = total / 3
    width2 = max(total**2 - 3 * pairs, c.zero)
    if not width2:
        return [middle] * 3
    width = c.sqrt(width2)
    cosine = (2 * total**3 - 9 * total * pairs + 27 * product) / (2 * width**3)
    angle = c.acos(max(-c.one, min(c.one, cosine)))
    return [middle + 2 * width / 3 * c.cos((angle + shift * 2 * c.pi) / 3) for shift in (1, 2, 0)]


_Inverse = Callable[[Sequence[Mpf], Lengths, Context], list[Mpf]]
_FLAT_OR_OCTANT: Mapping[str, _Inverse] = {
    "parabolic": _parabolic, "elliptic": _elliptic, "conical": _conical, "ellipsoidal": _ellipsoidal,
    "paraboloidal": _paraboloidal,
}  # fmt: skip
_MERIDIAN: Mapping[str, _Inverse] = {
    "spherical": _spherical, "rotational parabolic": _rotational_parabolic, "prolate spheroidal": _prolate,
    "oblate spheroidal": _oblate,
}  # fmt: skip
