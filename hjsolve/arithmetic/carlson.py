"""Carlson's and Jacobi's elliptic functions for arrays of doubles, in numpy alone.

Duplication (Carlson, Numer. Algorithms 10 (1995) 13, arXiv math/9409227; DLMF 19.36(i)); descending means (DLMF
22.20(ii)).
What is outside the domain of a function is nan. An element does not depend on its neighbours.

Arguments are numbers or arrays that broadcast; of the functions of Jacobi u is the argument and m the parameter k².
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Elementwise

Doubles = NDArray[np.float64]
Numbers = float | Doubles

_MOST_DUPLICATIONS = 60
"""Each divides the spread of the arguments by four: 4⁻⁶⁰ is below the spacing of doubles, whatever they were."""


def broadcast(*arguments: Numbers) -> list[Doubles]:
    """Return copies of one shape."""
    return [np.array(a) for a in np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in arguments))]


def _inside(value: Doubles, *conditions: Elementwise) -> Doubles:
    return np.where(np.logical_and.reduce(conditions), value, np.nan)


Term = Callable[[Sequence[Elementwise], Sequence[Elementwise], Elementwise, Doubles], Elementwise]
"""(arguments, their roots, λ, 4⁻ⁿ) ↦ what the n-th duplication adds to the sum."""


def duplicated(
    A: Elementwise, arguments: Sequence[Elementwise], tolerance: float, term: Term | None = None
) -> Elementwise:
    """Replace each x by (x + λ)/4, λ = √x√y + √x√z + √y√z, until all are near their mean (Carlson 1995, (2.18)–(2.26)).

    Args:
        A: weighted mean of the arguments, shape (n,).
        arguments: x, y, z and p where there is one; only p may be complex.
        tolerance: largest ((A − x)/A)⁶ at the end, where the series in (A − x)/A begins to suffice.
        term: what a duplication adds; None for nothing.

    Returns:
        The arguments, A, 4⁻ⁿ and the sum of the terms, each element at its own end.
    """
    bound = np.max([abs(A - x) for x in arguments], axis=0) / tolerance ** (1 / 6)
    weight, total = np.ones_like(bound), np.zeros_like(A)
    for _ in range(_MOST_DUPLICATIONS):
        open_ = bound > abs(A)
        if not open_.any():
            break
        roots = [np.sqrt(x) for x in arguments]
        sx, sy, sz = roots[:3]
        λ = np.where(open_, sx * sy + sx * sz + sy * sz, 0.0)
        if term is not None:
            total += np.where(open_, term(arguments, roots, λ, weight), 0.0)
        quarter = np.where(open_, 0.25, 1.0)
        arguments = [(x + λ) * quarter for x in arguments]
        A, bound, weight = (A + λ) * quarter, bound * quarter, weight * quarter
    return arguments, A, weight, total


def carlson_rf(x: Numbers, y: Numbers, z: Numbers) -> Doubles:
    """R_F(x, y, z) of non-negative arguments, at most one of them zero (Carlson 1995, (2.2)–(2.6))."""
    x, y, z = broadcast(x, y, z)
    with np.errstate(all="ignore"):
        (x, y, z), A, _, _ = duplicated((x + y + z) / 3, (x, y, z), 3 * EPS)
        X, Y = (A - x) / A, (A - y) / A
        Z = -X - Y
        second, third = X * Y - Z * Z, X * Y * Z
        series = 1 + second * (second / 24 - 0.1 - 3 * third / 44) + third / 14
        return _inside(series / np.sqrt(A), x >= 0, y >= 0, z >= 0)


def carlson_rc(x: Numbers, y: Numbers) -> Doubles:
    """R_C(x, y), x ≥ 0; the principal value where y < 0 (DLMF 19.2.17–19.2.20)."""
    x, y = broadcast(x, y)
    with np.errstate(all="ignore"):
        factor = np.where(y < 0, np.sqrt(x / (x - y)), 1.0)
        x, y = np.where(y < 0, x - y, x), abs(y)
        root = np.sqrt(abs(x - y))
        arcs = np.where(x < y, np.arctan(root / np.sqrt(x)), np.arcsinh(root / np.sqrt(y)))
        return _inside(factor * np.where(x == y, 1 / np.sqrt(x), arcs / root), x >= 0)


def carlson_rd(x: Numbers, y: Numbers, z: Numbers) -> Doubles:
    """R_D(x, y, z), x, y ≥ 0 and not both zero, z > 0 (Carlson 1995, (2.29)–(2.35))."""
    x, y, z = broadcast(x, y, z)
    with np.errstate(all="ignore"):
        (x, y, z), A, weight, total = duplicated(
            (x + y + 3 * z) / 5, (x, y, z), EPS / 4, lambda xs, roots, λ, w: w / (roots[2] * (xs[2] + λ))
        )
        X, Y = (A - x) / A, (A - y) / A
        Z = -(X + Y) / 3
        return _inside(weight * series(X, Y, Z, Z) / (A * np.sqrt(A)) + 3 * total, x >= 0, y >= 0, z >= 0)


def carlson_rj(x: Numbers, y: Numbers, z: Numbers, p: Numbers) -> Doubles:
    """R_J(x, y, z, p), x, y, z ≥ 0 and at most one zero (Carlson 1995, (2.17)–(2.26)); p < 0 by DLMF 19.20.14."""
    x, y, z, p = broadcast(x, y, z, p)
    if not (p < 0).any():
        return _rj(x, y, z, p)
    least, middle, most = np.sort(np.array([x, y, z]), axis=0)
    return _principal(least, middle, most, p)


def _principal(x: Doubles, y: Doubles, z: Doubles, p: Doubles) -> Doubles:
    """For x ≤ y ≤ z and any p."""
    with np.errstate(all="ignore"):
        q = np.where(p < 0, -p, np.nan)
        r = (y * (x + z + q) - x * z) / (y + q)
        inner = (r - y) * _rj(x, y, z, r) - 3 * carlson_rf(x, y, z)
        s = x * z + r * q
        other = np.sqrt(x * y * z / s) * carlson_rc(s, r * q)
        return np.where(p < 0, (inner + 3 * other) / (y + q), _rj(x, y, z, abs(p)))


def _rj(x: Doubles, y: Doubles, z: Doubles, p: Doubles) -> Doubles:
    """For p > 0, by the terms of DLMF 19.26.18, of positive numbers; Carlson's R_C(1, 1 + e) loses digits at e → −1."""

    def term(xs: Sequence[Doubles], roots: Sequence[Doubles], λ: Doubles, weight: Doubles) -> Doubles:
        p, (sx, sy, sz, sp) = xs[3], roots
        α, β = p * (sx + sy + sz) + sx * sy * sz, sp * (p + λ)
        return weight * carlson_rc(α * α, β * β)

    with np.errstate(all="ignore"):
        (x, y, z, p), A, weight, total = duplicated((x + y + z + 2 * p) / 5, (x, y, z, p), EPS / 4, term)
        X, Y, Z = (A - x) / A, (A - y) / A, (A - z) / A
        value = weight * series(X, Y, Z, -(X + Y + Z) / 2) / (A * np.sqrt(A)) + 3 * total
        return _inside(value, x >= 0, y >= 0, z >= 0, p > 0)


def series(X: Elementwise, Y: Elementwise, Z: Elementwise, P: Elementwise) -> Elementwise:
    """Carlson's series of R_J about equal arguments (1995, (2.26)), with Z three times for R_D.

    Args:
        X, Y, Z, P: (A − x)/A … (A − p)/A, their weighted sum X + Y + Z + 2P = 0.
    """
    return 1 + series_beyond_one(X, Y, Z, P)


def series_beyond_one(X: Elementwise, Y: Elementwise, Z: Elementwise, P: Elementwise) -> Elementwise:
    """Return the series without its first term, 1, as two doubles need it.

    Args:
        X, Y, Z, P: as of ``series``.
    """
    E2 = X * Y + X * Z + Y * Z - 3 * P * P
    E3 = X * Y * Z + 2 * E2 * P + 4 * P**3
    E4 = (2 * X * Y * Z + E2 * P + 3 * P**3) * P
    E5 = X * Y * Z * P * P
    return E3 / 6 - 3 * E2 / 14 + 9 * E2 * E2 / 88 - 3 * E4 / 22 - 9 * E2 * E3 / 52 + 3 * E5 / 26


# ------------------------------------------------------------------------------------------------ Jacobi's functions
def jacobi_functions(u: Numbers, m: Numbers) -> tuple[Doubles, ...]:
    """am, sn, cn, dn, ℰ of real arguments and any real parameter (DLMF 22.20(ii), 22.17).

    Args:
        u: argument; number or array.
        m: parameter k²; number or array.
    """
    u, m = broadcast(u, m)
    with np.errstate(all="ignore"):
        above, below = m > 1, m < 0
        scale = np.where(above, np.sqrt(abs(m)), np.where(below, np.sqrt(1 - m), 1.0))
        φ, s, c, d, ε = _between(u * scale, np.where(above, 1 / m, np.where(below, m / (m - 1), m)))
        beyond = np.arctan(s * c * (1 / scale - 1) / (s * s / scale + c * c))
        return (
            np.where(above, np.arcsin(s / scale), np.where(below, φ + beyond, φ)),
            np.where(above, s / scale, np.where(below, s / (scale * d), s)),
            np.where(above, d, np.where(below, c / d, c)),
            np.where(above, c, np.where(below, 1 / d, d)),
            np.where(above, scale * ε - (m - 1) * u, np.where(below, scale * (ε + m / (1 - m) * s * c / d), ε)),
        )


def _between(u: Doubles, m: Doubles) -> tuple[Doubles, ...]:
    """For 0 ≤ m ≤ 1; ℰ by Abramowitz & Stegun 17.6.10."""
    a, b, steps, doublings, squares = np.ones_like(m), np.sqrt(1 - m), [], np.ones_like(m), m / 2
    for _ in range(12):
        open_ = (abs(a - b) > a * 1e-16) & (m < 1)
        if not open_.any():
            break
        c = np.where(open_, (a - b) / 2, 0.0)
        a, b = np.where(open_, (a + b) / 2, a), np.where(open_, np.sqrt(a * b), b)
        steps.append((c, c / a))
        squares += doublings * c * c
        doublings = np.where(open_, 2 * doublings, doublings)
    φ, ε = doublings * a * u, (1 - squares) * u
    for c, quotient in reversed(steps):
        sine = np.sin(φ)
        ε += c * sine
        φ = np.where(c == 0, φ, (φ + np.arcsin(quotient * sine)) / 2)
    one = m == 1
    φ, ε = np.where(one, 2 * np.arctan(np.tanh(u / 2)), φ), np.where(one, np.tanh(u), ε)
    s, c = np.where(one, np.tanh(u), np.sin(φ)), np.where(one, 1 / np.cosh(u), np.cos(φ))
    return φ, s, c, np.where(one, c, np.sqrt(1 - m + m * c * c)), ε


def jacobi_am(u: Numbers, m: Numbers) -> Doubles:
    """Jacobi's amplitude, continuous in u."""
    return jacobi_functions(u, m)[0]


def jacobi_sn(u: Numbers, m: Numbers) -> Doubles:
    """Jacobi's sn."""
    return jacobi_functions(u, m)[1]


def jacobi_cn(u: Numbers, m: Numbers) -> Doubles:
    """Jacobi's cn."""
    return jacobi_functions(u, m)[2]


def jacobi_dn(u: Numbers, m: Numbers) -> Doubles:
    """Jacobi's dn."""
    return jacobi_functions(u, m)[3]


def jacobi_epsilon(u: Numbers, m: Numbers) -> Doubles:
    """Jacobi's ℰ = ∫₀ᵘ dn²."""
    return jacobi_functions(u, m)[4]


# ------------------------------------------------------------------------------------------------ Legendre's integrals
def _reduced(φ: Numbers, m: Numbers) -> tuple[Doubles, Doubles, Doubles, Doubles, Doubles]:
    """Return half turns, sin φ, cos² φ and 1 − m sin² φ of φ brought to −π/2 … π/2; and m."""
    φ, m = broadcast(φ, m)
    turns = np.round(φ / np.pi)
    s = np.sin(φ) * np.where(turns % 2 == 0, 1.0, -1.0)
    square = np.cos(φ) ** 2
    return turns, s, square, 1 - m + m * square, m


def legendre_f(φ: Numbers, m: Numbers) -> Doubles:
    """Legendre's F(φ|m) for any real φ, DLMF 19.25.5.

    Args:
        φ, m: amplitude and parameter k².
    """
    turns, s, square, Δ, m = _reduced(φ, m)
    return s * carlson_rf(square, Δ, 1) + np.where(turns == 0, 0.0, 2 * turns * carlson_rf(0, 1 - m, 1))


def legendre_k(m: Numbers) -> Doubles:
    """Return the complete integral K(m), DLMF 19.25.1.

    Args:
        m: parameter k².
    """
    return carlson_rf(0, 1 - np.asarray(m, dtype=float), 1)


def legendre_e(*arguments: Numbers) -> Doubles:
    """Legendre's E(m) or E(φ|m), DLMF 19.25.1 and 19.25.9.

    Args:
        arguments: m, or φ and m, as sympy's ``elliptic_e`` takes them.
    """
    *φ, m = arguments
    complement = 1 - np.asarray(m, dtype=float)
    whole = carlson_rf(0, complement, 1) - m * carlson_rd(0, complement, 1) / 3
    if not φ:
        return whole
    turns, s, square, Δ, m = _reduced(φ[0], m)
    return (
        s * carlson_rf(square, Δ, 1)
        - m * s**3 * carlson_rd(square, Δ, 1) / 3
        + np.where(turns == 0, 0.0, 2 * turns * whole)
    )


def legendre_pi(n: Numbers, *arguments: Numbers) -> Doubles:
    """Legendre's Π(n|m) or Π(n; φ|m), DLMF 19.25.2 and 19.25.14.

    Args:
        n: characteristic; the integrand is 1/((1 − n sin²θ)√(1 − m sin²θ)).
        arguments: m, or φ and m, as sympy's ``elliptic_pi`` takes them.
    """
    *φ, m = arguments
    n, m = broadcast(n, m)
    if not φ:
        return _third_kind(n, m, np.ones_like(m), np.zeros_like(m), 1 - m)
    turns, s, square, Δ, m = _reduced(φ[0], m)
    turning = turns != 0
    whole = np.zeros(np.broadcast(turns, n, m).shape)
    if np.any(turning):
        whole = np.where(turning, 2 * turns * _third_kind(n, m, np.ones_like(m), np.zeros_like(m), 1 - m), 0.0)
    return _third_kind(n, m, s, square, Δ) + whole


def _third_kind(n: Doubles, m: Doubles, s: Doubles, square: Doubles, Δ: Doubles) -> Doubles:
    """Π by sin φ, cos² φ and 1 − m sin² φ, −π/2 ≤ φ ≤ π/2.

    F + n s³ R_J/3 cancels where n → −∞: Π is √|n| times less than F there. With N = (m − n)/(1 − n) between m and 1

        Π(n) = ((1 − m)(−n) Π(N)/(1 − n) + m F)/(m − n) + √(−n/((1 − n)(m − n))) arctan(√(−n (m − n)/(1 − n)) s c/√Δ)

    has positive terms (Abramowitz and Stegun 17.7.15 to 17.7.17); 1 − N s² = c² + s² (1 − m)/(1 − n).
    """
    first = s * carlson_rf(square, Δ, 1)
    with np.errstate(all="ignore"):
        far = (n < -1) & (m >= 0)
        N = np.where(far, (m - n) / (1 - n), n)
        pole = np.where(far, square + s * s * (1 - m) / (1 - n), 1 - n * s * s)
        third = first + N * s**3 * carlson_rj(square, Δ, 1, pole) / 3
        arc = np.sqrt(-n / ((1 - n) * (m - n))) * np.arctan(np.sqrt(-n * (m - n) / (1 - n)) * s * np.sqrt(square / Δ))
        return np.where(far, ((1 - m) * (-n) / (1 - n) * third + m * first) / (m - n) + arc, third)
