"""Proofs by Liouville's theorem that integrals of a coordinate are not elementary, where no variable makes p² rational.

If ∫ N dq/p is elementary, N/p = v₀′ + Σ cᵢ vᵢ′/vᵢ with constants cᵢ and v of the field that q, the functions in p², and
p generate (Liouville; Rosenlicht, Amer. Math. Monthly 79 (1972) 963; Bronstein, Symbolic integration I (2005), 5.5).

1. p² = A(w) (ℓ + R(w)), w = q, e^{cq} or e^{icq}, where ℓ′ is rational in w and ℓ is not: log r, or F q beside cos q.
   The field is that of rational functions of w and p; with g = (ℓ + R)′/2, p p′ = A′p²/(2A) + A g. A polynomial in p
   that divides p times its own derivative would make ℓ an algebraic function of w, which it is not; so v₀ is a
   polynomial Σ bⱼ pʲ, bⱼ and vᵢ rational in w. Its powers give bⱼ = c A^{−j/2} for the highest j, c = 0 beyond j = 2 as
   g is not a derivative, and for odd j where A is not a square; last b₁ A g = N, which cannot be. Of a square A = s²
   it can, where N/s is a multiple of g. With N = p², of W, the powers of p give b₁ ≠ 0 and b₁ A g = 0.
2. p² = θʲ (R₀ + R₁ θⁿ + …), θ = e^G, with R and G rational in q. In powers of θ, which v₀ and log vᵢ have too, with
   coefficients algebraic over the rational functions, that of each power that is not 0 is a derivative by itself:
   a′ + s G′ a = c with the coefficient c of θˢ in N/p. By the conjugates of √R₀, a = α/√R₀ with a rational α, and
   Risch's algorithm decides whether there is one: for −U e^{−x²} it is α′ − 2xα = a number, and there is none.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import sympy as sp
from sympy.integrals.rde import rischDE
from sympy.integrals.risch import DifferentialExtension
from sympy.integrals.risch import NonElementaryIntegralException as NotElementaryError

from hjsolve.closed_form.why_not import WhyNot


@dataclass(frozen=True, repr=False)
class NotElementary(WhyNot):
    """The integrals of a coordinate are not elementary.

    Attributes:
        q: the coordinate.
        square: p².
        numerators: N of its integrals, but that of W.
    """

    q: sp.Symbol
    square: sp.Expr
    numerators: tuple[sp.Expr, ...]

    @property
    def proved(self) -> bool:  # type: ignore[override]
        """Whether it is so."""
        return self.holds()

    @property
    def at_random(self) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
        """Return p² and the N at rational constants that nobody chose."""
        held = set().union(*(e.free_symbols for e in (self.square, *self.numerators))) - {self.q}
        # constants that somebody chose may satisfy by chance what others do not
        values = {s: sp.Rational(17 + 12 * k + k * k, 10 + 7 * k) for k, s in enumerate(sorted(held, key=str))}
        square, *numerators = (_with_plain_constants(e, self.q, values) for e in (self.square, *self.numerators))
        return square, tuple(numerators)


def _with_plain_constants(e: sp.Expr, q: sp.Symbol, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return an expression at rational constants; of an angle among them the tangent of its half is rational."""
    e = sp.expand_trig(sp.sympify(e))
    table = dict[sp.Expr, sp.Expr]()
    for f in e.atoms(sp.sin, sp.cos):
        if not f.has(q):
            t = f.args[0].xreplace(values)
            table[f] = (2 * t if isinstance(f, sp.sin) else 1 - t**2) / (1 + t**2)
    return e.xreplace(table).xreplace(values)


class LinearBesideRational(NotElementary):
    """p² is A(w) (ℓ + R(w)), ℓ not rational in w, but its derivative: case 1 above."""

    def holds(self) -> bool:
        """Return whether ℓ′ is rational in w, and no derivative of such a function, and no N/√A is a multiple of g."""
        square, numerators = self.at_random
        w, variable, parts = sp.Dummy("w"), _variable(square, self.q), _factor_and_slope(square, self.q)
        if variable is None or parts is None:
            return False
        slope, rate, factor, *given = (
            _rational(e, variable, self.q, w) for e in (parts[1], sp.diff(variable, self.q), parts[0], *numerators)
        )
        if slope is None or rate is None or factor is None or None in given or 0 in (slope, *given):
            return False
        # without a residue ℓ would be rational in w itself, and p² with it
        if not _has_residue(sp.cancel(slope / rate), w):
            return False
        # A is not a square: no odd power of p is left of v₀
        root = _root_of_square(factor, w)
        return root is None or all(sp.cancel(sp.diff(sp.cancel(N / (root * slope)), w)) != 0 for N in given)

    def __str__(self) -> str:
        kinds = {f: _transcendental(f) for f in self.square.atoms(sp.Function) if f.has(self.q)}
        linear, others = (", ".join(sorted(str(f) for f in kinds if kinds[f] is kind)) for kind in (True, False))
        return (
            f"p² is linear in {linear or self.q} and else rational in {others or self.q}: "
            "by Liouville's theorem its integrals are not elementary"
        )


class NoRationalSolution(NotElementary):
    """p² is a sum of powers of θ = e^G with rational coefficients and G: case 2 above."""

    def holds(self) -> bool:
        """Return whether a coefficient of every integral is not a derivative."""
        square, numerators = self.at_random
        if not all(N.is_rational_function(self.q) for N in numerators):
            return False
        for G in _exponents(square, self.q):
            terms = _powers(square, G, self.q)
            if terms is not None and len(terms) > 1:
                return all(self._of(N, terms, sp.diff(G, self.q)) for N in (*numerators, None))
        return False

    def _of(self, N: sp.Expr | None, terms: dict[int, sp.Expr], slope: sp.Expr) -> bool:
        """Whether ∫ N dq/p, or ∫ p dq, is not elementary: by the lowest power, by the next, or by the highest two."""
        powers = sorted(terms)
        # expansions at θ = 0 and at θ = ∞: one obstruction is enough, and two terms of √ are rational in R₀ and R₁
        for first, second in ((powers[0], powers[1]), (powers[-1], powers[-2])):
            R, ratio = terms[first], terms[second] / terms[first]
            leading, half = (R, sp.Rational(1, 2)) if N is None else (N, -sp.Rational(1, 2))
            for s, c in ((half * first, leading), (half * first + second - first, half * leading * ratio)):
                # of θ⁰ a logarithm may come in (Σ cᵢ log vᵢ): it proves nothing
                if s != 0 and not self._solvable(s * slope, c, R):
                    return True
        return False

    def _solvable(self, slope: sp.Expr, c: sp.Expr, R: sp.Expr) -> bool:
        """Whether a′ + s G′ a = c/√R has a solution α/√R with a rational α."""
        x, of_a = sp.Dummy("x"), slope - sp.diff(R, self.q) / (2 * R)
        field = DifferentialExtension(extension={"D": [sp.Poly(1, x)]})
        parts = [sp.Poly(e, x) for f in (of_a, c) for e in sp.fraction(sp.cancel(sp.together(f.subs(self.q, x))))]
        try:
            rischDE(*parts, field)
        except NotElementaryError:
            return False
        return True

    def __str__(self) -> str:
        held = ", ".join(sorted({str(f) for f in self.square.atoms(sp.Function) if f.has(self.q)}))
        return (
            f"p² is a polynomial in {held} with coefficients rational in {self.q}: "
            "by Liouville's theorem its integrals are not elementary"
        )


def not_elementary(square: sp.Expr, numerators: Iterable[sp.Expr], q: sp.Symbol) -> WhyNot | None:
    """Return the proof for a coordinate; None where neither kind reaches it.

    Args:
        square: p².
        numerators: N of its integrals, but that of W.
        q: the coordinate.
    """
    given = tuple(numerators)
    kinds = (LinearBesideRational(q, square, given), NoRationalSolution(q, square, given))
    return next((proof for proof in kinds if proof.holds()), None)


def _transcendental(f: sp.Expr) -> bool:
    """Whether a function has an algebraic derivative: a logarithm, or an arc function, which is one."""
    return isinstance(f, (sp.log, sp.atan, sp.acot, sp.asinh, sp.acosh, sp.atanh, sp.acoth))


def _factor_and_slope(square: sp.Expr, q: sp.Symbol) -> tuple[sp.Expr, sp.Expr] | None:
    """Return A and (ℓ + R)′ of p² = A (ℓ + R), ℓ of logarithms, or else q beside waves; None where it is not linear."""
    logarithms = [f for f in square.atoms(sp.Function) if f.has(q) and _transcendental(f)]
    waves = [] if logarithms else [f for f in square.atoms(sp.Function) if f.has(q)]
    letters = {f: sp.Dummy() for f in sorted(logarithms, key=sp.default_sort_key)} or {q: sp.Dummy()}
    hidden = {f: sp.Dummy() for f in waves}
    plain = sp.expand(square.xreplace(hidden)).xreplace(letters)
    if not plain.is_polynomial(*letters.values()):
        return None
    linear = sp.Poly(plain, *letters.values())
    if linear.total_degree() != 1:
        return None
    back = {name: f for f, name in hidden.items()}
    A, *others = (sp.factor(linear.coeff_monomial(name).xreplace(back)) for name in letters.values())
    ratios = [sp.S.One, *(sp.cancel(c / A) for c in others)]
    if any(r.has(q) for r in ratios):
        return None
    rest = linear.coeff_monomial(1).xreplace(back) / A
    return A, sp.Add(*(r * sp.diff(f, q) for r, f in zip(ratios, letters, strict=True)), sp.diff(rest, q))


def _root_of_square(f: sp.Expr, w: sp.Symbol) -> sp.Expr | None:
    """Return the root of a rational function, up to a number; None where it is not a square."""
    root = sp.S.One
    for part, sign in zip(sp.fraction(f), (1, -1), strict=True):
        for factor, power in sp.factor_list(part, w)[1]:
            if power % 2:
                return None
            root *= factor ** (sign * power // 2)
    return root


def _variable(square: sp.Expr, q: sp.Symbol) -> sp.Expr | None:
    """Return what p² may be rational in, but for one term: q, or the exponential of its waves."""
    waves = square.atoms(sp.cos, sp.sin, sp.tan, sp.cot)
    growing = square.atoms(sp.cosh, sp.sinh, sp.tanh, sp.coth, sp.exp)
    rates = {sp.diff(f.args[0], q) for f in waves | growing if f.has(q)}
    if not rates:
        return q
    # incommensurable rates need two exponentials, of which no case above speaks
    if any(not r.is_Rational or r == 0 for r in rates):
        return None
    return sp.exp((sp.I if waves else 1) * sp.gcd_list([abs(r) for r in rates]) * q)


def _exponents(square: sp.Expr, q: sp.Symbol) -> list[sp.Expr]:
    """Return the G of which p² may hold powers of e^G."""
    found = [f.args[0] for f in square.atoms(sp.exp) if f.has(q) and f.args[0].is_rational_function(q)]
    return sorted(found, key=sp.default_sort_key)[:2]


def _rational(e: sp.Expr, variable: sp.Expr, q: sp.Symbol, w: sp.Symbol) -> sp.Expr | None:
    """Return an expression as a rational function of w; None where it is none."""
    if variable == q:
        e = sp.together(e).xreplace({q: w})
    else:
        rate = sp.diff(variable, q) / variable
        e = sp.expand(e.rewrite(sp.exp)).subs(q, sp.log(w) / rate)
        e = sp.powsimp(sp.expand(e))
    return sp.cancel(sp.together(e)) if e.is_rational_function(w) and not e.has(q) else None


def _powers(square: sp.Expr, exponent: sp.Expr, q: sp.Symbol) -> dict[int, sp.Expr] | None:
    """Return power of e^G → coefficient, rational in q; None where p² is not such a sum."""
    found = dict[int, sp.Expr]()
    for term in sp.Add.make_args(sp.expand(square.rewrite(sp.exp))):
        waves = [f for f in sp.Mul.make_args(term) if isinstance(f, sp.exp) and f.has(q)]
        ratio = sp.cancel(sp.Add(*(f.args[0] for f in waves)) / exponent)
        rest = term / sp.Mul(*waves)
        if not ratio.is_Integer or not rest.is_rational_function(q):
            return None
        found[int(ratio)] = found.get(int(ratio), sp.S.Zero) + rest
    return {n: e for n, c in found.items() if (e := sp.cancel(sp.together(c))) != 0}


def _has_residue(f: sp.Expr, w: sp.Symbol) -> bool:
    """Return whether a rational function is not the derivative of one: Hermite's reduction leaves simple poles."""
    from sympy.integrals.rationaltools import ratint_ratpart

    # the polynomial part is a derivative anyway
    top, bottom = (sp.Poly(part, w) for part in sp.fraction(f))
    _, rest = sp.div(top, bottom)
    return not rest.is_zero and sp.cancel(ratint_ratpart(rest, bottom, w)[1]) != 0
