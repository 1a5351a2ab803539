"""Is a constant zero? Proved by a separation bound for algebraic numbers, and by Baker's theorem read backwards.

**Algebraic numbers.** Every expression in rational numbers, + − · /, roots, and sines and cosines of rational multiples
of π is a quotient A/B of algebraic integers. With |A| ≤ u and |B| ≤ l for all conjugates, and D the degree of the field
that the expression lives in, A ≠ 0 has |norm A| ≥ 1, hence

    |A/B| ≥ 1/(u^(D−1) l)        unless it is zero

(Burnikel, Funke, Mehlhorn, Schirra, Schmitt, Algorithmica 55 (2009) 14, with u and l by the rules of ``_Bound``). An
enclosure below that bound proves zero; one that excludes zero proves the opposite.

**Logarithms and angles.** Σ rₖ log αₖ with rational rₖ is zero if Π αₖ^(m rₖ) = 1 for a whole m, which is an algebraic
question. Σ rₖ arg zₖ with zₖ = 1 + i aₖ for atan aₖ and z = −1 for π is a whole multiple of π/m if Π zₖ^(m rₖ) is
real; an enclosure tells which one. (By Baker's theorem there is no other way for such a sum to vanish.)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

import sympy as sp

from hjsolve.algebra.intervals import NoEnclosureError, enclose
from hjsolve.algebra.tree_walk import TreeWalk
from hjsolve.precision import mp

MAX_DEGREE, MAX_BITS = 4096, 40_000
MAX_MULTIPLE = 240
_TOLERANCE = 1e-6
Pair = tuple[sp.Expr, sp.Expr]


class NotAlgebraicError(ArithmeticError):
    """The constant is none that these rules know."""


@dataclass(frozen=True)
class _Bound:
    """log₂ of bounds of all conjugates of A and B in A/B."""

    up: float
    down: float

    @staticmethod
    def of_rational(x: sp.Rational) -> _Bound:
        return _Bound(_log2(abs(int(x.p))), _log2(int(x.q)))

    def plus(self, other: _Bound) -> _Bound:
        a, b = self.up + other.down, other.up + self.down
        return _Bound(max(a, b) + math.log2(1 + 2.0 ** -min(abs(a - b), 60)) + _TOLERANCE, self.down + other.down)

    def times(self, other: _Bound) -> _Bound:
        return _Bound(self.up + other.up, self.down + other.down)

    def inverse(self) -> _Bound:
        return _Bound(self.down, self.up)

    def root(self, k: int) -> _Bound:
        if self.up >= self.down:
            return _Bound((self.up + (k - 1) * self.down) / k + _TOLERANCE, self.down)
        return _Bound(self.up, (self.down + (k - 1) * self.up) / k + _TOLERANCE)


def _log2(n: int) -> float:
    """Return an upper bound of log₂ n, at least 0."""
    return 0.0 if n <= 1 else math.log2(n) + _TOLERANCE if n < 2**900 else float(n.bit_length())


class _Measure(TreeWalk[_Bound]):
    """The walk in bounds, and the degree of the field of what was met."""

    def __init__(self) -> None:
        super().__init__()
        self.roots: dict[sp.Expr, int] = {}
        self.turn = 1

    @property
    def degree(self) -> int:
        cyclotomic = 1 if self.turn <= 2 else int(sp.totient(math.lcm(4, self.turn))) // 2
        return math.prod(self.roots.values()) * cyclotomic

    def leaf(self, x: sp.Expr) -> _Bound | None:
        return _Bound.of_rational(x) if x.is_Rational else None

    def total(self, parts: Iterable[_Bound]) -> _Bound:
        return reduce(_Bound.plus, parts)

    def product(self, parts: Iterable[_Bound]) -> _Bound:
        return reduce(_Bound.times, parts)

    def function(self, x: sp.Expr) -> _Bound:
        if isinstance(x, (sp.sin, sp.cos)):
            turn = x.args[0] / sp.pi
            if turn.is_Rational:
                self.turn = math.lcm(self.turn, 2 * int(turn.q))
                return _Bound(1.0, 1.0)
        raise NotAlgebraicError(f"{sp.sstr(x)[:60]} is not known to be algebraic")

    def power(self, x: sp.Expr) -> _Bound:
        base, exponent = x.args
        if not exponent.is_Rational:
            return self.function(x)
        bound, q = self(base), int(exponent.q)
        if q > 1:
            self.roots[base] = math.lcm(self.roots.get(base, 1), q)
            bound = bound.root(q)
        result = _Bound(0.0, 0.0)
        for _ in range(min(abs(int(exponent.p)), 64)):
            result = result.times(bound)
        if abs(int(exponent.p)) > 64:
            raise NotAlgebraicError("a high power")
        return result.inverse() if exponent < 0 else result


def algebraic_is_zero(x: sp.Expr) -> bool:
    """Return whether an algebraic constant is zero.

    Args:
        x: without symbols.

    Raises:
        NotAlgebraicError: it is none, or its degree is too large.
        NoEnclosureError: it divides by zero, or is not real.
    """
    x = _without_tangents(x)
    if x.is_Rational:
        return x == 0
    measure = _Measure()
    bound = measure(x)
    if measure.degree > MAX_DEGREE:
        raise NotAlgebraicError(f"an algebraic number of degree {measure.degree}")
    needed = int((measure.degree - 1) * bound.up + bound.down) + 2
    if needed > MAX_BITS:
        raise NotAlgebraicError(f"{needed} bits would be needed")
    precision = 64
    while True:
        lower, upper = enclose(x, {}, precision)
        if lower > 0 or upper < 0:
            return False
        if max(-lower, upper) < mp.ldexp(1, -needed):
            return True
        precision *= 2
        if precision > 8 * needed + 4096:
            raise NotAlgebraicError("the enclosure does not shrink")


def _without_tangents(x: sp.Expr) -> sp.Expr:
    """tan, cot, sec and csc as quotients."""
    x = x.replace(sp.tan, lambda a: sp.sin(a) / sp.cos(a)).replace(sp.cot, lambda a: sp.cos(a) / sp.sin(a))
    return x.replace(sp.sec, lambda a: 1 / sp.cos(a)).replace(sp.csc, lambda a: 1 / sp.sin(a))


# -------------------------------------------------------------------------------- linear forms


@dataclass(frozen=True)
class _Form:
    """Rational coefficients: of logarithms by argument, of arc tangents by argument, and of π."""

    logarithms: Mapping[sp.Expr, Fraction]
    angles: Mapping[sp.Expr, Fraction]
    turns: Fraction


def constant_is_zero(x: sp.Expr) -> bool | None:
    """Return whether a constant is zero; None where these rules do not tell.

    Args:
        x: with logarithms and inverse functions of algebraic numbers only as ``log`` and ``atan``, see ``elementary``.
    """
    try:
        return _decided(x)
    except (NotAlgebraicError, NoEnclosureError):
        return None


def _decided(x: sp.Expr) -> bool | None:
    if x.is_Rational:
        return x == 0
    if not x.has(sp.log, sp.atan, sp.pi) or not _transcendental(x):
        return algebraic_is_zero(x)
    lower, upper = enclose(x, {}, 128)
    if lower > 0 or upper < 0:
        return False
    groups: dict[sp.Expr, list[sp.Expr]] = {}
    rest = []
    for term in sp.Add.make_args(sp.expand_mul(x)):
        found = [f for f in sp.Mul.make_args(term) if _is_primitive(f)]
        if len(found) > 1 or (not found and _transcendental(term)):
            return None
        if not found:
            rest.append(term)
            continue
        factor, scale = (term / found[0]).as_coeff_Mul()
        groups.setdefault(scale, []).append(factor * found[0])
    parts = [_form(terms) for terms in groups.values()]
    if algebraic_is_zero(sp.Add(*rest)) and all(_vanishes(form) for form in parts):
        return True
    return None


def _is_primitive(x: sp.Expr) -> bool:
    return isinstance(x, (sp.log, sp.atan)) or x is sp.pi


def _transcendental(x: sp.Expr) -> bool:
    """Return whether π, a logarithm or an arc tangent stands outside of a sine or cosine of an angle."""
    if isinstance(x, (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc)):
        return not (x.args[0] / sp.pi).is_Rational
    return _is_primitive(x) or any(map(_transcendental, x.args))


def _form(terms: list[sp.Expr]) -> _Form:
    logarithms, angles, turns = dict[sp.Expr, Fraction](), dict[sp.Expr, Fraction](), Fraction(0)
    for term in terms:
        c, f = term.as_coeff_Mul()
        r = Fraction(int(c.p), int(c.q))
        if f is sp.pi:
            turns += r
        else:
            kind = logarithms if isinstance(f, sp.log) else angles
            kind[f.args[0]] = kind.get(f.args[0], Fraction(0)) + r
    return _Form(logarithms, angles, turns)


def _vanishes(form: _Form) -> bool:
    """Return a proof that both the sum of logarithms and the sum of angles are zero."""
    logarithms = {a: r for a, r in form.logarithms.items() if r}
    angles = {a: r for a, r in form.angles.items() if r}
    if logarithms:
        m = math.lcm(*(r.denominator for r in logarithms.values()))
        product = sp.Mul(*(a ** int(m * r) for a, r in logarithms.items()))
        if not algebraic_is_zero(product - 1):
            return False
    if not angles:
        return form.turns == 0
    m = math.lcm(form.turns.denominator, *(r.denominator for r in angles.values()))
    if m > MAX_MULTIPLE or sum(abs(r) for r in angles.values()) * m > MAX_MULTIPLE:
        raise NotAlgebraicError("a high multiple of an angle")
    real, imaginary = sp.S.One, sp.S.Zero
    for a, r in angles.items():
        for _ in range(abs(int(m * r))):
            a_ = a if r > 0 else -a
            real, imaginary = _product((real, imaginary), (sp.S.One, a_))
    if not algebraic_is_zero(imaginary):
        return False
    total = sp.Add(*(sp.Rational(r.numerator, r.denominator) * sp.atan(a) for a, r in angles.items()))
    turns = sp.Rational(form.turns.numerator, form.turns.denominator) * sp.pi
    lower, upper = enclose(m * (total + turns) / sp.pi, {}, 128)
    return bool(lower > -1 and upper < 1)


def _product(a: Pair, b: Pair) -> Pair:
    """Return the product of two complex numbers.

    What is irrational is left as it is, what is rational multiplied out.
    """
    real, imaginary = a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]
    return sp.expand_mul(real), sp.expand_mul(imaginary)
