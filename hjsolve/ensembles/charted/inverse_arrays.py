"""From X, Y, Z in the frame of a web to its coordinates, for arrays of doubles.

The formulas and the choice among the coordinates of one point are those of ``motion.charted.inverse_charts``. What
cancels here is made good by Newton's method (``charted_starts``), so no digit of this has to be right but the first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from hjsolve.arithmetic.number_types import Elementwise, Reals
from hjsolve.errors import InternalError

Lengths = Mapping[str, float]


def inverse_arrays(kind: str, X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    """Return the coordinates of many points.

    Args:
        kind: of the chart, as in ``Chart.kind``.
        X: the points in the frame of the web, arrays of one shape.
        lengths: named constants of the chart.

    Raises:
        InternalError: a kind without an inverse.
    """
    if kind in ("cartesian", "normal modes"):
        return list(X)
    with np.errstate(all="ignore"):
        ρ, azimuth = np.hypot(X[0], X[1]), np.arctan2(X[1], X[0])
        if kind in ("polar", "circular cylinder"):
            return [ρ, azimuth, *X[2:]]
        if kind.endswith("cylinder"):
            flat = _FLAT_OR_OCTANT[kind.split(maxsplit=1)[0]]
            return [*flat(X[:2], lengths), X[2]]
        if kind in _MERIDIAN:
            return [*_MERIDIAN[kind]((ρ, X[2]), lengths), azimuth]
        if kind not in _FLAT_OR_OCTANT:
            raise InternalError(f"no inverse of the chart {kind}")
        return _FLAT_OR_OCTANT[kind](X, lengths)


def _root(x: Reals) -> Reals:
    return np.sqrt(np.maximum(x, 0.0))


def _over(above: Reals, below: Reals, otherwise: Reals | float) -> Reals:
    return np.where(below != 0, above / np.where(below != 0, below, 1.0), otherwise)


def _two_roots(total: Reals, product: Reals) -> tuple[Reals, Reals]:
    """Return (s, k) ≥ 0 with s − k = total, s·k = product ≥ 0; neither cancels."""
    larger = (np.abs(total) + np.sqrt(total**2 + 4 * product)) / 2
    smaller = _over(product, larger, 0.0)
    return np.where(total >= 0, larger, smaller), np.where(total >= 0, smaller, larger)


def _parabolic(X: Sequence[Reals], _: Lengths) -> list[Reals]:
    u2, v2 = _two_roots(2 * X[0], X[1] ** 2)
    u = np.sqrt(u2)
    return [u, _over(X[1], u, np.sqrt(v2))]


def _elliptic(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    x, y = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = _two_roots(x**2 + y**2 - 1, y**2)
    s = np.sqrt(s2)
    return [np.arcsinh(s), np.arctan2(_over(y, s, np.sqrt(k2)), x / np.sqrt(1 + s2))]


def _spherical(X: Sequence[Reals], _: Lengths) -> list[Reals]:
    return [np.hypot(X[0], X[1]), np.arctan2(X[0], X[1])]


def _rotational_parabolic(X: Sequence[Reals], _: Lengths) -> list[Reals]:
    return [np.sqrt(s) for s in _two_roots(2 * X[1], X[0] ** 2)]


def _prolate(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    return _elliptic((X[1], X[0]), lengths)


def _oblate(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    ρ, z = X[0] / lengths["a"], X[1] / lengths["a"]
    s2, k2 = _two_roots(ρ**2 + z**2 - 1, z**2)
    s = np.sqrt(s2)
    return [np.arcsinh(s), np.arctan2(ρ / np.sqrt(1 + s2), _over(z, s, np.sqrt(k2)))]


def _conical(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    e1, e2, e3 = (lengths[f"e{i}"] for i in (1, 2, 3))
    r = np.sqrt(X[0] ** 2 + X[1] ** 2 + X[2] ** 2)
    n = [x / r for x in X]
    first, second, scale = e2 - e1, e3 - e2, np.sqrt(e3 - e1)
    high, low = _two_roots((e3 - e1) * n[0] ** 2 - first + second * n[1] ** 2, first * second * n[1] ** 2)
    cosine = _root(low / first)
    sine = _over(n[1], cosine, _root(high / second))
    χ = np.arctan2(n[0] * scale / np.sqrt(first + high), cosine)
    return [r, χ, np.arctan2(sine, n[2] * scale / np.sqrt(second + low))]


def _ellipsoidal(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    a, b = lengths["a"], [lengths[f"a{i}"] for i in (1, 2, 3)]
    x = [value / a for value in X]
    squares = [value**2 for value in x]
    pairs = (b[1] + b[2], b[0] + b[2], b[0] + b[1])
    products = (b[1] * b[2], b[0] * b[2], b[0] * b[1])
    u, v, w = _three_roots(
        sum(b) + sum(squares),
        b[0] * b[1] + b[0] * b[2] + b[1] * b[2] + sum(s * p for s, p in zip(squares, pairs, strict=True)),
        b[0] * b[1] * b[2] + sum(s * p for s, p in zip(squares, products, strict=True)),
    )
    first, second, whole = b[1] - b[0], b[2] - b[1], b[2] - b[0]
    cosine, other = _root((b[1] - u) / first), _root((b[2] - v) / second)
    high = np.maximum(w - b[2], 0.0) / second
    above, below = np.maximum(v - b[0], first), np.maximum(b[2] - u, second)
    χ = np.arctan2(x[0] / np.sqrt(above * (w - b[0]) / whole), cosine)
    sine = _over(x[1], cosine * np.sqrt((1 + high) * second), _root((v - b[1]) / second))
    return [χ, np.arctan2(sine, other), np.arcsinh(_over(x[2], other * np.sqrt(second * below / whole), _root(high)))]


def _paraboloidal(X: Sequence[Reals], lengths: Lengths) -> list[Reals]:
    a, b, e = (lengths[name] for name in ("a", "b", "c"))
    x, y, z = (value / a for value in X)
    u, v, w = _three_roots(2 * x + b + e, 2 * x * (b + e) + b * e - y**2 - z**2, 2 * x * b * e - y**2 * e - z**2 * b)
    d = e - b
    low, other = _root((b - u) / d), _root((e - v) / d)
    high = np.maximum(w - e, 0.0) / d
    sine = _over(y, d * low * np.sqrt(1 + high), _root((v - b) / d))
    return [
        np.arcsinh(low), np.arctan2(sine, other),
        np.arcsinh(_over(z, d * np.sqrt(1 + low**2) * other, _root(high))),
    ]  # fmt: skip


def _three_roots(total: Elementwise, pairs: Elementwise, product: Elementwise) -> list[Reals]:
    """Return real roots of s³ − total·s² + pairs·s − product in rising order, by the cosine of a third of an angle."""
    middle, width = total / 3, _root(total**2 - 3 * pairs)
    cosine = _over(2 * total**3 - 9 * total * pairs + 27 * product, 2 * width**3, 1.0)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    return [middle + 2 * width / 3 * np.cos((angle + shift * 2 * np.pi) / 3) for shift in (1, 2, 0)]


_Inverse = Callable[[Sequence[Reals], Lengths], list[Reals]]
_FLAT_OR_OCTANT: Mapping[str, _Inverse] = {
    "parabolic": _parabolic, "elliptic": _elliptic, "conical": _conical, "ellipsoidal": _ellipsoidal,
    "paraboloidal": _paraboloidal,
}  # fmt: skip
_MERIDIAN: Mapping[str, _Inverse] = {
    "spherical": _spherical, "rotational parabolic": _rotational_parabolic, "prolate spheroidal": _prolate,
    "oblate spheroidal": _oblate,
}  # fmt: skip
