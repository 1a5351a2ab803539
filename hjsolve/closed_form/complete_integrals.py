"""Sums of complete elliptic integrals for doubles: over integrals of one sign, the half turns of near poles taken out.

With c = 1 − m

    B = ⅓ c R_D(0, 1, c),  D = ⅓ R_D(0, c, 1),  J(n) = ⅓ R_J(0, c, 1, 1 − n),
    K = B + D,  E = B + c D,  Π(n) = K + n J(n),

so that a K + b E + A Π(n) = (a + b + A) B + (a + b c + A) D + A n J(n): the coefficients are those of what is left of a
small oscillation (E − c K is of the order of m), and nothing cancels where they are in factors.

Of a pole r beyond the turning points, P(r) < 0 and n < 0 or n > m, Π grows as the pole comes near; what grows is a half
turn and nothing else:

    A Π(n) = ½π A √(n/((1 − n)(n − m))) − A (m/n) J(m/n)

which is taken where n² > m, the former elsewhere. The factor of ½π is a residue, ± a constant: the half turns of the
poles at cos θ = 1 and −1 cancel in whole numbers. The product of c − x over all roots x of P is P(c) by its leading
coefficient.

Fukushima, J. Comput. Appl. Math. 236 (2012) 1961 (B, D, J); DLMF 19.7.8 and 19.7.9 (n to m/n), 19.25.1, 19.25.2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.closed_form.coefficients_by_roots import far_points, in_roots
from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.named_quantities import written_out
from hjsolve.closed_form.regions import Where
from hjsolve.closed_form.tidy import linear_in, longer_than
from hjsolve.functions import CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.precision import mp

COMPLETE = (sp.elliptic_k, sp.elliptic_e, sp.elliptic_pi)
_LONGEST = 250
"""Operations of a coefficient that is factored: longer ones may take sympy seconds."""
_NEAR = 2**-20
"""Part of its distance from a pole at which a root is put to see what a coefficient loses there."""


@dataclass(frozen=True)
class _Pole:
    """A Π(n) of a pole between roots where P < 0.

    Attributes:
        A: its coefficient.
        n: its characteristic.
        far: the condition under which it is K + n J(n).
        size: the factor of the half turn, without its sign.
        sign: of the half turn.
    """

    A: sp.Expr
    n: sp.Expr
    far: sp.Expr
    size: sp.Expr
    sign: sp.Expr


class CompleteIntegrals:
    """The complete integrals of forms of one regime.

    Args:
        where: symbol → its definition.
        example: symbol → its value at a motion of the regime: signs and order are its.
    """

    def __init__(self, where: Where, example: Mapping[sp.Symbol, mpmath.mpf]):
        self.example = example
        self.plain = {s: e for s, e in where.items() if isinstance(e, sp.Expr) and not _rooted(e)}
        self.radicals = {s: e for s, e in where.items() if isinstance(e, sp.Expr) and _rooted(e)}
        self.roots = roots_by_polynomial(where)
        self.far = far_points(where, example)
        self._known = dict[sp.Expr, sp.Expr]()

    def arranged(self, expression: sp.Expr) -> sp.Expr:
        """Return an equal expression, every sum of complete integrals in it over B, D and J.

        Args:
            expression: of a form.
        """
        if not expression.has(*COMPLETE):
            return expression
        if expression not in self._known:
            total = linear_in(expression, _complete)
            self._known[expression] = (
                expression.func(*map(self.arranged, expression.args)) if total is None else self._written(total)
            )
        return self._known[expression]

    def _written(self, total: dict[sp.Expr, sp.Expr]) -> sp.Expr:
        value = total.pop(sp.S.One, sp.S.Zero)
        for m in sorted({i.args[-1] for i in total}, key=sp.default_sort_key):
            value += self._of_parameter(m, {i: w for i, w in total.items() if i.args[-1] == m})
        return value

    def _of_parameter(self, m: sp.Expr, weights: dict[sp.Expr, sp.Expr]) -> sp.Expr:
        c = self.complement(m)
        # K alone loses nothing: it is R_F(0, 1 − m, 1) as it stands
        if c is None and all(isinstance(i, sp.elliptic_k) for i in weights):
            return sp.Add(*(w * i for i, w in weights.items()))
        c = self.tidy(1 - m) if c is None else c
        # Π = K + n J: the K of all poles are counted into one coefficient, where they cancel in exact arithmetic
        a, b = weights.pop(sp.elliptic_k(m), sp.S.Zero), weights.pop(sp.elliptic_e(m), sp.S.Zero)
        poles, value = list[_Pole](), sp.S.Zero
        for integral, A in weights.items():
            n = integral.args[0]
            pole = self._pole(A, n, m)
            if pole is None:
                a += A
                # n J(n) = ⅓ n R_J(0, 1 − m, 1, 1 − n), DLMF 19.25.2
                value += A * n * CarlsonRJ(0, c, 1, self._one_minus(n)) / 3
                continue
            poles.append(pole)
            # n → m/n, DLMF 19.7.8 and 19.7.9: with n² > m it is |m/n| < √m, and what is left of Π does not grow
            ratio = self.tidy(m / n)
            weight = _either(A * n, pole.far, -self.tidy(A * m / n))
            value += weight * CarlsonRJ(0, c, 1, _either(self._one_minus(n), pole.far, self._one_minus(ratio))) / 3
        # half turns of one size first: ½π (1 − 1) is 0, the difference of two large products is not
        for size in dict.fromkeys(p.size for p in poles):
            turns = sp.Add(*(_either(sp.S.Zero, p.far, p.sign) for p in poles if p.size == size))
            value += sp.pi / 2 * size * turns
        if b == 0:
            return value + self._coefficient(a, poles) * CarlsonRF(0, c, 1)
        # K = B + D, E = B + c D
        first, second = self._coefficient(a + b, poles), self._coefficient(a + b * c, poles)
        return value + (first * c * CarlsonRD(0, 1, c) + second * CarlsonRD(0, c, 1)) / 3

    def _coefficient(self, own: sp.Expr, poles: list[_Pole]) -> sp.Expr:
        """Return what K is multiplied by: its own coefficient, and those of the poles that are far.

        The coefficient of a pole and what the own one has next to it nearly cancel where a root is there too; that of
        a pole of another kind, at infinity, and the rest of the own one do where a root is far away.
        """
        parts, value = self._parts(own) if poles else [own], sp.S.Zero
        # near poles first: they take the parts that cancel with them, the far ones what is left
        for pole in sorted(poles, key=lambda pole: not self._near(pole.A)):
            near = self._near(pole.A)
            # what grows next to the same pole is put together before anything is rounded
            held = [part for part in parts if not near or self._near(part) & near]
            parts = [part for part in parts if part not in held]
            value += _either(self.tidy(sp.Add(*held, pole.A)), pole.far, self.tidy(sp.Add(*held)))
        return value + self.tidy(sp.Add(*parts))

    def _parts(self, coefficient: sp.Expr) -> list[sp.Expr]:
        """Partial fractions by a root that is next to numbers in the denominator."""
        explicit = self.written_out(coefficient)
        if longer_than(explicit, _LONGEST):
            return [coefficient]
        near = sorted({x for x, _ in self._near(coefficient)}, key=str)
        if not near:
            return [coefficient]
        factors = sp.Mul.make_args(sp.factor(sp.together(explicit)))
        whole = [f for f in factors if f.as_base_exp()[1].is_Integer]
        rest = sp.Mul(*(f for f in factors if f not in whole))
        # of 1/((1 − x)(1 + x)) only the term with 1 − x grows with the pole at 1
        return [rest * sp.factor(part) for part in sp.Add.make_args(sp.apart(sp.Mul(*whole), near[0]))]

    def _near(self, coefficient: sp.Expr) -> set[tuple[sp.Symbol, sp.Expr]]:
        """Return the roots that a denominator has next to a number, and the number."""
        explicit, found = self.written_out(coefficient), set[tuple[sp.Symbol, sp.Expr]]()
        for power in explicit.atoms(sp.Pow):
            if power.exp.is_Integer and power.exp < 0 and self._gap(power.base) and len(power.free_symbols) == 1:
                (x,) = power.free_symbols
                found.add((x, sp.expand(x - power.base / power.base.coeff(x))))
        return found

    def _pole(self, A: sp.Expr, n: sp.Expr, m: sp.Expr) -> _Pole | None:
        """Return the half turn of a pole; None where P > 0 there, or where that is not known."""
        if not (A.free_symbols | n.free_symbols | m.free_symbols) <= self.example.keys():
            return None
        at_n, at_m = number_of(n, self.example), number_of(m, self.example)
        # A² n/((1 − n)(n − m)) ≤ 0: the residue is not real, and there is no half turn
        if 0 <= at_n <= at_m or at_n >= 1:
            return None
        # its root is the half turn by ½π: rational in the roots, and free of them where the residue is a constant
        square = A**2 * n / ((1 - n) * (n - m))
        explicit = self.written_out(self.written_out(square).xreplace(self.radicals))
        size = sp.sqrt(_without_root(explicit) or self.tidy(square))
        return _Pole(A, n, sp.Le(n**2, m), size, self._sign(A))

    def _sign(self, A: sp.Expr) -> sp.Expr:
        """Return the sign of a coefficient: that of its constants, where they may change it, and of the example."""
        value = sp.S(int(mp.sign(number_of(A, self.example))))
        for factor in sp.Mul.make_args(A):
            base, power = factor.as_base_exp()
            if base.free_symbols and power.is_odd and not base.is_positive and not self._gap(base):
                value *= sp.sign(base) * int(mp.sign(number_of(base, self.example)))
        return value

    def _gap(self, base: sp.Expr) -> bool:
        """Whether an expression is c − x, of numbers c and roots x, which keep their order in a regime."""
        named = {s for symbols in self.roots.values() for s in symbols} | self.radicals.keys()
        return bool(base.is_Add and len(base.args) == 2 and base.free_symbols <= named)

    def complement(self, m: sp.Expr) -> sp.Expr | None:
        """1 − m as a quotient without the 1; None where it does not cancel.

        Args:
            m: the parameter.
        """
        m = self.written_out(m)
        # 1 − (a − b)/(c − b) is (c − a)/(c − b): a difference of roots, known to its last place where they are
        above, below = sp.fraction(sp.together(m))
        if below == 1:
            return None
        left = sp.expand(below - above)
        if len(sp.Add.make_args(left)) > len(sp.Add.make_args(sp.expand(below))):
            return None
        return self._by_products(sp.factor(left) if not longer_than(left, _LONGEST) else sp.factor_terms(left)) / below

    def _one_minus(self, n: sp.Expr) -> sp.Expr:
        quotient = self.complement(n)
        return self.tidy(1 - n) if quotient is None else quotient

    def written_out(self, expression: sp.Expr) -> sp.Expr:
        """Return an expression without the names, but of roots and of what has roots of sums in sums.

        Args:
            expression: of a form.
        """
        return written_out(expression, self.plain)

    def tidy(self, coefficient: sp.Expr) -> sp.Expr:
        """Return a coefficient in factors, where that is not longer.

        Args:
            coefficient: of an integral.
        """
        explicit = self.written_out(coefficient)
        if not explicit.has(sp.Add) or longer_than(explicit, _LONGEST):
            return coefficient
        made = self._by_products(sp.factor(sp.together(explicit)))
        if made.is_number:
            return made
        points, candidates = self._points(explicit), [coefficient, made]
        by_roots = in_roots(explicit, self.roots) if self.far else explicit
        if by_roots != explicit and not longer_than(by_roots, _LONGEST):
            candidates.append(sp.factor(sp.together(by_roots)))
        # digits before length: the shorter form may be the one that cancels
        return min(candidates, key=lambda e: (self._loss(e, points), sp.count_ops(e)))

    def _points(self, explicit: sp.Expr) -> list[Mapping[sp.Symbol, mpmath.mpf]]:
        """Return the example, motions with a root far away, and places where a root is next to a pole.

        An identity in the roots holds there, too.
        """
        points: list[Mapping[sp.Symbol, mpmath.mpf]] = [self.example, *self.far]
        for x, pole in self._near(explicit):
            at = number_of(pole, self.example)
            # x is moved towards the pole and nothing else: coefficients are identities in the roots, not in the
            # constants
            points.append({**self.example, x: at + (self.example[x] - at) * _NEAR})
        return points

    def _loss(self, e: sp.Expr, points: list[Mapping[sp.Symbol, mpmath.mpf]]) -> int:
        """Return how many digits are lost at the worst of some places."""
        worst = 1.0
        explicit = self.written_out(e)
        for point in points:
            if not explicit.free_symbols <= point.keys():
                return 0
            value, error = _with_error(explicit, point)
            worst = max(worst, float(error / abs(value)) if value else 1e300)
        return int(mp.log10(worst))

    def _by_products(self, expression: sp.Expr) -> sp.Expr:
        """Write the product of c − x over all roots x, where it is a factor, as P(c) by its leading coefficient."""
        factors = dict[sp.Expr, sp.Expr]()
        for factor in sp.Mul.make_args(expression):
            base, power = factor.as_base_exp()
            factors[base] = factors.get(base, sp.S.Zero) + power
        for P, symbols in self.roots.items():
            if len(set(symbols.values())) == P.degree():
                _with_all_roots(factors, P, symbols)
        self._with_radicals(factors)
        return sp.Mul(*(base**power for base, power in factors.items()))

    def _with_radicals(self, factors: dict[sp.Expr, sp.Expr]) -> None:
        """Write a product of factors with roots in radicals without them, where they leave it: Vieta's formulas."""
        for power in {p for base, p in factors.items() if base.free_symbols & self.radicals.keys()}:
            held = [b for b, p in factors.items() if p == power and b.is_Add and b.free_symbols & self.radicals.keys()]
            total = sp.Mul(*held)
            if len(held) < 2 or longer_than(total, _LONGEST):
                continue
            # (c − x₁)(c − x₂) is P(c)/a where both roots are radicals: without one, and nothing cancels next to c
            made = sp.factor(sp.expand(total.xreplace(self.radicals)))
            if _rooted(made) or sp.count_ops(made) > 2 * sp.count_ops(total):
                continue
            for base in held:
                del factors[base]
            for factor in sp.Mul.make_args(made):
                base, own = factor.as_base_exp()
                factors[base] = factors.get(base, sp.S.Zero) + own * power


def roots_by_polynomial(where: Where) -> dict[sp.Poly, dict[sp.Symbol, int]]:
    """Return polynomial → root → its number; two coordinates may have the same P, and its roots two names.

    Args:
        where: symbol → its definition.
    """
    found = dict[sp.Poly, dict[sp.Symbol, int]]()
    for symbol, meaning in where.items():
        if isinstance(meaning, tuple):
            found.setdefault(meaning[0], {})[symbol] = meaning[1]
    return found


def _with_all_roots(factors: dict[sp.Expr, sp.Expr], P: sp.Poly, numbers: Mapping[sp.Symbol, int]) -> None:
    places = dict[sp.Expr, dict[int, tuple[sp.Expr, sp.Expr]]]()
    for base in factors:
        held = base.free_symbols & numbers.keys()
        if len(held) == 1 and base.is_Add:
            (x,) = held
            slope = base.coeff(x)
            # s (x − c): the same c must occur with every root of P
            if slope.is_number and slope != 0 and (c := sp.expand(x - base / slope)) not in numbers and not c.has(x):
                places.setdefault(c, {})[numbers[x]] = (base, slope)
    for c, found in places.items():
        powers = {factors[base] for base, _ in found.values()}
        if len(found) < P.degree() or len(powers) > 1:
            continue
        (power,) = powers
        value = sp.factor(P.as_expr().subs(P.gen, c) / P.LC())
        if value == 0:
            continue
        for base, slope in found.values():
            del factors[base]
            # Π s (xⱼ − c) = (−1)ⁿ sⁿ P(c)/a, one factor −s for each root
            value *= -slope
        for factor in sp.Mul.make_args(value):
            base, own = factor.as_base_exp()
            factors[base] = factors.get(base, sp.S.Zero) + own * power


def _with_error(e: sp.Expr, point: Mapping[sp.Symbol, mpmath.mpf]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Return a value, and a bound of its error in units of the last place of 1, each number known to its last place."""
    # running errors to first order: enough to compare two forms, no bound is claimed
    if e.is_Add:
        values, errors = zip(*(_with_error(a, point) for a in e.args), strict=True)
        return sum(values), sum(errors) + abs(sum(values))
    if e.is_Mul:
        values, errors = zip(*(_with_error(a, point) for a in e.args), strict=True)
        value = mp.fprod(values)
        return value, abs(value) * sum(error / abs(v) if v else 1 for v, error in zip(values, errors, strict=True))
    if e.is_Pow and e.exp.is_Rational:
        base, error = _with_error(e.base, point)
        value = number_of(e, point)
        return value, abs(value * float(e.exp)) * (error / abs(base) if base else 1)
    value = number_of(e, point)
    return value, abs(value)


def _rooted(expression: sp.Expr) -> bool:
    """Whether roots of sums are parts of sums: what a square does not free of roots."""
    return any(
        part.is_Add and any(p.base.is_Add and not p.exp.is_Integer for p in part.atoms(sp.Pow))
        for part in sp.preorder_traversal(expression)
    )


def _without_root(e: sp.Expr) -> sp.Expr | None:
    """Return an expression that is rational in one √D without it, where its value does not depend on its sign."""
    powers = {p for p in e.atoms(sp.Pow) if p.base.is_Add and not p.exp.is_Integer}
    if len({p.base for p in powers}) != 1 or longer_than(e, _LONGEST) or any((2 * p.exp).q != 1 for p in powers):
        return None
    (D,), s = {p.base for p in powers}, sp.Dummy("s")
    # e = (a₀ + a₁ s)/(b₀ + b₁ s), s² = D, does not depend on the sign of s where a₁ b₀ = a₀ b₁
    above, below = sp.fraction(sp.together(e.xreplace({p: s ** (2 * p.exp) for p in powers})))
    if above.is_polynomial(s) and below.is_polynomial(s):
        a, b = (sp.rem(sp.expand(part), s**2 - D, s) for part in (above, below))
        if sp.expand(a.coeff(s, 1) * b.coeff(s, 0) - a.coeff(s, 0) * b.coeff(s, 1)) == 0:
            k = 0 if b.coeff(s, 0) != 0 else 1
            return sp.factor(a.coeff(s, k) / b.coeff(s, k))
    return None


def _complete(integral: sp.Expr) -> bool:
    return isinstance(integral, COMPLETE) and len(integral.args) == (2 if isinstance(integral, sp.elliptic_pi) else 1)


def _either(first: sp.Expr, condition: sp.Expr, second: sp.Expr) -> sp.Expr:
    return sp.Piecewise((first, condition), (second, True))
