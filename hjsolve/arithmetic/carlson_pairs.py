"""Carlson's, Legendre's and Jacobi's elliptic functions in two doubles, elementwise over arrays.

The formulas of ``carlson``, for what doubles lose: about 25 digits are right. What is outside the domain is nan.
A function takes and returns ``Pair``; of the functions of Jacobi u is the argument and m the parameter k².
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.carlson import series_beyond_one
from hjsolve.arithmetic.double_double import pair_abs, pair_add, pair_atan, pair_div, pair_mul, pair_sincos, pair_sqrt
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Elementwise, Mask, Reals

MOST_DUPLICATIONS = 80
"""Each divides the spread of the arguments by four."""
LAST_SPREAD = 1e-5
"""Of the arguments by their mean, at which Carlson's series takes over: its sixth power is what is left out."""
LAST_SPREAD_OF_RC = 3e-5
"""Likewise of R_C, whose series goes to the seventh power."""
_EQUAL_MEANS = 2.0**-100
"""Of themselves, how far the two means are apart at the end."""
_MOST_MEANS = 16
"""Steps of the means, each of which doubles the digits."""
OF_RC = 0.3, 1 / 7, 0.375, 9 / 22, 159 / 208, 9 / 8
"""Coefficients of s² … s⁷ (Carlson 1995, (2.16))."""


@dataclass(frozen=True, eq=False)
class TwoDoubles:
    """A number in two doubles, with operators.

    Attributes:
        high, low: its parts.
    """

    high: Elementwise
    low: Elementwise = 0.0

    def __add__(self, other: TwoDoubles | float) -> TwoDoubles:
        o = as_two_doubles(other)
        return TwoDoubles(*pair_add(self.high, self.low, o.high, o.low))

    def __mul__(self, other: TwoDoubles | float) -> TwoDoubles:
        o = as_two_doubles(other)
        return TwoDoubles(*pair_mul(self.high, self.low, o.high, o.low))

    def __truediv__(self, other: TwoDoubles | float) -> TwoDoubles:
        o = as_two_doubles(other)
        return TwoDoubles(*pair_div(self.high, self.low, o.high, o.low))

    def __neg__(self) -> TwoDoubles:
        return TwoDoubles(-self.high, -self.low)

    def __sub__(self, other: TwoDoubles | float) -> TwoDoubles:
        return self + (-as_two_doubles(other))

    def __rsub__(self, other: float) -> TwoDoubles:
        return as_two_doubles(other) + (-self)

    __radd__, __rmul__ = __add__, __mul__

    def __rtruediv__(self, other: float) -> TwoDoubles:
        return as_two_doubles(other) / self

    def scaled(self, power: Elementwise) -> TwoDoubles:
        """Return it times a power of two, or a mask of 0 and 1, which rounds nothing."""
        return TwoDoubles(self.high * power, self.low * power)

    def size(self) -> TwoDoubles:
        """Return |x|."""
        return TwoDoubles(*pair_abs(self.high, self.low))

    def root(self) -> TwoDoubles:
        """Return √x."""
        return TwoDoubles(*pair_sqrt(self.high, self.low))


def as_two_doubles(x: TwoDoubles | Elementwise) -> TwoDoubles:
    """Return a number of either kind as two doubles."""
    return x if isinstance(x, TwoDoubles) else TwoDoubles(x)


def either(condition: Mask, x: TwoDoubles, y: TwoDoubles) -> TwoDoubles:
    """Return x where a condition holds, else y."""
    return TwoDoubles(np.where(condition, x.high, y.high), np.where(condition, x.low, y.low))


PI = TwoDoubles(np.pi, 1.2246467991473532e-16)


def arctan(x: TwoDoubles) -> TwoDoubles:
    """Return arctan x."""
    return TwoDoubles(*pair_atan(x.high, x.low))


def arcsin(x: TwoDoubles) -> TwoDoubles:
    """Return arcsin x; next to ±1 by the product (1 − x)(1 + x)."""
    return 2.0 * arctan(x / (1.0 + ((1.0 - x) * (1.0 + x)).root()))


def sine_and_cosine(x: TwoDoubles) -> tuple[TwoDoubles, TwoDoubles]:
    """Return sin x and cos x."""
    s, s_low, c, c_low = pair_sincos(x.high, x.low)
    return TwoDoubles(s, s_low), TwoDoubles(c, c_low)


Term = Callable[[Sequence[TwoDoubles], Sequence[TwoDoubles], TwoDoubles, Reals], TwoDoubles]
"""(arguments, their roots, λ, 4⁻ⁿ) ↦ what the n-th duplication adds."""


def _broadcast(*arguments: TwoDoubles) -> list[TwoDoubles]:
    shape = np.broadcast_shapes(*(np.shape(a.high) for a in arguments))
    return [TwoDoubles(a.high + np.zeros(shape), a.low + np.zeros(shape)) for a in arguments]


def _duplicated(
    A: TwoDoubles, arguments: Sequence[TwoDoubles], term: Term | None = None
) -> tuple[Sequence[TwoDoubles], TwoDoubles, Reals, TwoDoubles]:
    """Replace each x by (x + λ)/4 until all are near their mean, as ``carlson.duplicated`` does in doubles."""
    bound = np.max([abs((A - x).high) for x in arguments], axis=0) / LAST_SPREAD
    weight, total = np.ones_like(bound), TwoDoubles(np.zeros_like(bound), np.zeros_like(bound))
    for _ in range(MOST_DUPLICATIONS):
        open_ = bound > abs(A.high)
        if not open_.any():
            break
        roots = [x.root() for x in arguments]
        sx, sy, sz = roots[:3]
        λ = either(open_, sx * (sy + sz) + sy * sz, TwoDoubles(0.0, 0.0))
        if term is not None:
            total = total + either(open_, term(arguments, roots, λ, weight), TwoDoubles(0.0, 0.0))
        quarter = np.where(open_, 0.25, 1.0)
        arguments = [(x + λ).scaled(quarter) for x in arguments]
        A, bound, weight = (A + λ).scaled(quarter), bound * quarter, weight * quarter
    return arguments, A, weight, total


def _inside(value: TwoDoubles, *arguments: TwoDoubles) -> TwoDoubles:
    good = np.logical_and.reduce([np.asarray(a.high) >= 0 for a in arguments])
    return either(good, value, TwoDoubles(np.nan, np.nan))


def rf(x: TwoDoubles, y: TwoDoubles, z: TwoDoubles) -> TwoDoubles:
    """R_F(x, y, z)."""
    x, y, z = given = _broadcast(x, y, z)
    (x, y, z), A, _, _ = _duplicated((x + y + z) / 3.0, given)
    X, Y = ((A - x) / A).high, ((A - y) / A).high
    second, third = X * Y - (X + Y) ** 2, -X * Y * (X + Y)
    return _inside(
        (1.0 + as_two_doubles(second * (second / 24 - 0.1 - 3 * third / 44) + third / 14)) / A.root(), *given
    )


def rc(x: TwoDoubles, y: TwoDoubles) -> TwoDoubles:
    """R_C(x, y), x ≥ 0; the principal value where y < 0."""
    x, y = _broadcast(x, y)
    below, given = np.asarray(y.high) < 0, x
    factor = either(below, (x / (x - y)).root(), TwoDoubles(1.0, 0.0))
    x, y = either(below, x - y, x), y.size()
    A = (x + y + y) / 3.0
    bound = abs((y - A).high) / LAST_SPREAD_OF_RC
    for _ in range(MOST_DUPLICATIONS):
        open_ = bound > abs(A.high)
        if not open_.any():
            break
        λ = either(open_, 2.0 * (x.root() * y.root()) + y, TwoDoubles(0.0, 0.0))
        quarter = np.where(open_, 0.25, 1.0)
        x, y, A, bound = (
            (x + λ).scaled(quarter), (y + λ).scaled(quarter), (A + λ).scaled(quarter), bound * quarter
        )  # fmt: skip
    s, rest = ((y - A) / A).high, 0.0
    for c in reversed(OF_RC):
        rest = rest * s + c
    return _inside(factor * (1.0 + as_two_doubles(rest * s * s)) / A.root(), given)


def rd(x: TwoDoubles, y: TwoDoubles, z: TwoDoubles) -> TwoDoubles:
    """R_D(x, y, z)."""
    given = _broadcast(x, y, z)

    def term(xs: Sequence[TwoDoubles], roots: Sequence[TwoDoubles], λ: TwoDoubles, weight: Reals) -> TwoDoubles:
        return (1.0 / (roots[2] * (xs[2] + λ))).scaled(weight)

    x, y, z = given
    (x, y, z), A, weight, total = _duplicated((x + y + 3.0 * z) / 5.0, given, term)
    X, Y = ((A - x) / A).high, ((A - y) / A).high
    Z = -(X + Y) / 3
    return _inside(_last(X, Y, Z, Z, A, weight) + 3.0 * total, *given)


def _last(X: Reals, Y: Reals, Z: Reals, P: Reals, A: TwoDoubles, weight: Reals) -> TwoDoubles:
    """4⁻ⁿ times Carlson's series, which begins with 1, by A^(3/2)."""
    return ((1.0 + as_two_doubles(series_beyond_one(X, Y, Z, P))) / (A * A.root())).scaled(weight)


def rj(x: TwoDoubles, y: TwoDoubles, z: TwoDoubles, p: TwoDoubles) -> TwoDoubles:
    """R_J(x, y, z, p); Cauchy's principal value where p < 0 (DLMF 19.20.14)."""
    x, y, z, p = _broadcast(x, y, z, p)
    if not (np.asarray(p.high) < 0).any():
        return _rj(x, y, z, p)
    least, most = (either(np.asarray((y - x).high) * side >= 0, x, y) for side in (1, -1))
    middle = either(np.asarray((z - least).high) < 0, least, either(np.asarray((z - most).high) > 0, most, z))
    least = either(np.asarray((z - least).high) < 0, z, least)
    most = either(np.asarray((z - most).high) > 0, z, most)
    below = np.asarray(p.high) < 0
    q = either(below, -p, TwoDoubles(np.nan, np.nan))
    r = (middle * (least + most + q) - least * most) / (middle + q)
    s = least * most + r * q
    inner = (r - middle) * _rj(least, middle, most, r) - 3.0 * rf(least, middle, most)
    other = 3.0 * ((least * middle * most / s).root() * rc(s, r * q))
    return either(below, (inner + other) / (middle + q), _rj(x, y, z, p.size()))


def _rj(x: TwoDoubles, y: TwoDoubles, z: TwoDoubles, p: TwoDoubles) -> TwoDoubles:
    def term(xs: Sequence[TwoDoubles], roots: Sequence[TwoDoubles], λ: TwoDoubles, weight: Reals) -> TwoDoubles:
        p, (sx, sy, sz, sp) = xs[3], roots
        α, β = p * (sx + sy + sz) + sx * sy * sz, sp * (p + λ)
        return rc(α * α, β * β).scaled(weight)

    given = [x, y, z, p]
    (x, y, z, p), A, weight, total = _duplicated((x + y + z + 2.0 * p) / 5.0, given, term)
    X, Y, Z = (((A - v) / A).high for v in (x, y, z))
    return _inside(_last(X, Y, Z, -(X + Y + Z) / 2, A, weight) + 3.0 * total, *given)


# ------------------------------------------------------------------------------------------------ Legendre's integrals
def _reduced(φ: TwoDoubles, m: TwoDoubles) -> tuple[Reals, TwoDoubles, TwoDoubles, TwoDoubles, TwoDoubles]:
    φ, m = _broadcast(φ, m)
    turns = np.round(φ.high / np.pi)
    s, c = sine_and_cosine(φ)
    square = c * c
    return turns, s.scaled(np.where(turns % 2 == 0, 1.0, -1.0)), square, 1.0 - m + m * square, m


def _with_turns(part: TwoDoubles, turns: Reals, whole: Callable[[], TwoDoubles]) -> TwoDoubles:
    if not np.any(turns):
        return part
    return part + either(turns != 0, TwoDoubles(2.0 * turns, 0.0 * turns) * whole(), TwoDoubles(0.0, 0.0))


_ZERO, _ONE = TwoDoubles(0.0, 0.0), TwoDoubles(1.0, 0.0)


def legendre_f(φ: TwoDoubles, m: TwoDoubles) -> TwoDoubles:
    """F(φ|m)."""
    turns, s, square, Δ, m = _reduced(φ, m)
    return _with_turns(s * rf(square, Δ, _ONE), turns, lambda: legendre_k(m))


def legendre_k(m: TwoDoubles) -> TwoDoubles:
    """K(m)."""
    return rf(_ZERO, 1.0 - m, _ONE)


def legendre_e(*arguments: TwoDoubles) -> TwoDoubles:
    """E(m), or E(φ|m)."""
    *φ, m = arguments

    def whole() -> TwoDoubles:  # of positive terms, as ``many_digits.legendre_e``
        c = 1.0 - m
        return c * (rd(_ZERO, c, _ONE) + rd(_ZERO, _ONE, c)) / 3.0

    if not φ:
        return whole()
    turns, s, square, Δ, m = _reduced(φ[0], m)
    return _with_turns(s * rf(square, Δ, _ONE) - m * s * s * s * rd(square, Δ, _ONE) / 3.0, turns, whole)


def legendre_pi(n: TwoDoubles, *arguments: TwoDoubles) -> TwoDoubles:
    """Π(n|m), or Π(n; φ|m)."""
    *φ, m = arguments
    n, m = _broadcast(n, m)

    def whole() -> TwoDoubles:
        return _third_kind(n, m, _ONE, _ZERO, 1.0 - m)

    if not φ:
        return whole()
    turns, s, square, Δ, m = _reduced(φ[0], m)
    return _with_turns(_third_kind(n, m, s, square, Δ), turns, whole)


def _third_kind(n: TwoDoubles, m: TwoDoubles, s: TwoDoubles, square: TwoDoubles, Δ: TwoDoubles) -> TwoDoubles:
    """Π by sin φ, cos² φ and 1 − m sin² φ; far poles as in ``carlson._third_kind``."""
    first, far = s * rf(square, Δ, _ONE), (np.asarray(n.high) < -1) & (np.asarray(m.high) >= 0)
    N = either(far, (m - n) / (1.0 - n), n)
    pole = either(far, square + s * s * (1.0 - m) / (1.0 - n), 1.0 - n * s * s)
    third = first + N * s * s * s * rj(square, Δ, _ONE, pole) / 3.0
    if not far.any():
        return third
    out = either(far, n, TwoDoubles(-2.0, 0.0))
    arc = (-out / ((1.0 - out) * (m - out))).root()
    arc = arc * arctan((-out * (m - out) / (1.0 - out)).root() * s * (square / Δ).root())
    return either(far, ((1.0 - m) * -out / (1.0 - out) * third + m * first) / (m - out) + arc, third)


# ------------------------------------------------------------------------------------------------ Jacobi's functions
def jacobi_functions(u: TwoDoubles, m: TwoDoubles) -> tuple[TwoDoubles, ...]:
    """am, sn, cn, dn, ℰ of real arguments and any real parameter, as ``carlson.jacobi_functions``."""
    u, m = _broadcast(u, m)
    above, below = np.asarray((m - 1.0).high) > 0, np.asarray(m.high) < 0
    scale = either(above, m.size().root(), either(below, (1.0 - m).root(), _ONE))
    inner = either(above, 1.0 / m, either(below, m / (m - 1.0), m))
    φ, s, c, d, ε = _between(u * scale, inner)
    beyond = arctan(s * c * (1.0 / scale - 1.0) / (s * s / scale + c * c))
    return (
        either(above, arcsin(s / scale), either(below, φ + beyond, φ)),
        either(above, s / scale, either(below, s / (scale * d), s)),
        either(above, d, either(below, c / d, c)),
        either(above, c, either(below, 1.0 / d, d)),
        either(above, scale * ε - (m - 1.0) * u, either(below, scale * (ε + m / (1.0 - m) * s * c / d), ε)),
    )


def _between(u: TwoDoubles, m: TwoDoubles) -> tuple[TwoDoubles, ...]:
    """For 0 ≤ m < 1; nan for m = 1, which doubles know."""
    m = either(np.asarray((1.0 - m).high) > 0, m, TwoDoubles(np.nan, np.nan))
    a, b, steps = either(np.ones(np.shape(m.high), dtype=bool), _ONE, m), (1.0 - m).root(), []
    doublings, squares = np.ones_like(m.high), m.scaled(0.5)
    for _ in range(_MOST_MEANS):
        open_ = abs((a - b).high) > a.high * _EQUAL_MEANS
        if not open_.any():
            break
        c = either(open_, (a - b).scaled(0.5), _ZERO)
        a, b = either(open_, (a + b).scaled(0.5), a), either(open_, (a * b).root(), b)
        steps.append((c, c / a))
        squares = squares + (c * c).scaled(doublings)
        doublings = np.where(open_, 2 * doublings, doublings)
    φ, ε = (a * u).scaled(doublings), (1.0 - squares) * u
    for c, quotient in reversed(steps):
        sine, _ = sine_and_cosine(φ)
        ε = ε + c * sine
        φ = either(np.asarray(c.high) == 0, φ, (φ + arcsin(quotient * sine)).scaled(0.5))
    s, c = sine_and_cosine(φ)
    return φ, s, c, (1.0 - m + m * c * c).root(), ε


JACOBI = {name: k for k, name in enumerate(("JacobiAM", "JacobiSN", "JacobiCN", "JacobiDN", "JacobiEpsilon"))}
FUNCTIONS: dict[str, Callable[..., TwoDoubles]] = {
    "CarlsonRF": rf, "CarlsonRC": rc, "CarlsonRD": rd, "CarlsonRJ": rj,
    "elliptic_k": legendre_k, "elliptic_f": legendre_f, "elliptic_e": legendre_e, "elliptic_pi": legendre_pi,
}  # fmt: skip
"""Name of sympy's function → it in two doubles."""


def elliptic_function(name: str, *arguments: Pair) -> Pair:
    """Return an elliptic function in two doubles.

    Args:
        name: as sympy's class has it.
        arguments: of the function.
    """
    given = [TwoDoubles(*a) for a in arguments]
    value = jacobi_functions(*given)[JACOBI[name]] if name in JACOBI else FUNCTIONS[name](*given)
    return Pair(value.high, value.low)
