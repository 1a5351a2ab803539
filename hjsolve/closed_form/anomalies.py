"""q(ξ) and t(ξ), where t(q) cannot be solved for q: ξ makes the root of the quadrature rational, as Kepler's anomaly.

With the centre c and half distance h of the roots of P = Ax² + Bx + C, on the branch on which q grows,

    A < 0:         x = c ∓ h cos ξ    ∫dx/√P = ± ξ/√−A     (eccentric anomaly)
    A > 0, D > 0:  x = c ± h cosh ξ   ∫dx/√P = ± ξ/√A      (its hyperbolic twin)
    A > 0, D < 0:  x = c + h sinh ξ   ∫dx/√P = ± ξ/√A
    A = 0:         x = x₀ (1 + ξ²)    √P = ± √−C ξ         (Barker; ξ = tan ν/2)

Battin, An introduction to the mathematics and methods of astrodynamics (1999), chapter 4.
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.elementary import positive_root
from hjsolve.closed_form.elementary_motion import one_root
from hjsolve.closed_form.inverses import verified_inverse
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral
from hjsolve.closed_form.regime import plain_relation
from hjsolve.closed_form.signs import Signs, sign_of_many_digits
from hjsolve.closed_form.tidy import shortened_powers, square_root
from hjsolve.closed_form.verification import monotone_span, sample_numbers, value_at
from hjsolve.closed_form.workshop import Workshop
from hjsolve.solution.quadratures import Solution

_DIGITS = 40
TIME = "t"
"""The key of t(ξ)."""


def anomaly_of(solution: Solution) -> sp.Symbol:
    """ξ, by a name that the solution does not use.

    Args:
        solution: of which they are forms.
    """
    taken = {s.name for s in solution.characteristic_function.free_symbols}
    return sp.Symbol(next(n for n in ("xi", "chi", "xi_1") if n not in taken), real=True)


def anomaly_forms(
    shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], names: NamedQuantities, inverse: dict[str, sp.Expr],
    why_not: dict[str, str],
) -> dict[str, sp.Expr]:  # fmt: skip
    """q(ξ) and t(ξ) of the coordinate over which alone the time law integrates; empty where there is no such anomaly.

    Args:
        shop: of the solution.
        pieces: separated coordinate → its integrals.
        names: of the quantities of the forms.
        inverse: gets q(t) where t(ξ) is solved for ξ.
        why_not: loses its reason.
    """
    solution, key = shop.solution, shop.constants[0]
    held = [n for n in solution.coordinates if n not in pieces or key in pieces[n].numerators]
    if any(name in inverse for name in solution.coordinates):
        return {}
    if solution.time_law is None or len(held) != 1 or held[0] not in pieces or key not in pieces[held[0]].integrals:
        return {}
    (name,) = held
    own, integral, law = pieces[name], pieces[name].integrals[key], solution.time_law
    rest = law.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
    if integral.law is None or rest != 0 or not one_root(integral.law):
        return {}
    made = _Anomaly(own, integral, anomaly_of(solution), names)
    try:
        found = made.forms(law.lhs, solution.lower_limits[name])
    except NoFormError:
        return {}
    place = made.solved_cubic(found)
    if place is None:
        return found
    inverse[name] = verified_inverse(own, integral, place, law.lhs, solution.lower_limits[name], names, None)
    del why_not[f"inverse.{name}"]
    return found


def _bounds(relation: sp.Basic, base: sp.Expr) -> bool:
    """Whether a relation of the regime gives the sign of a factor."""
    if not isinstance(relation, (sp.StrictGreaterThan, sp.StrictLessThan)):
        return bool(isinstance(relation, sp.Ne) and base == relation.lhs and relation.rhs == 0)
    return bool(sp.cancel(base / (relation.lhs - relation.rhs)).is_number)


class _Anomaly:
    """The parameter of one coordinate."""

    def __init__(self, own: CoordinateIntegrals, integral: PieceIntegral, ξ: sp.Symbol, names: NamedQuantities):
        assert integral.law is not None
        self.own, self.integral, self.law, self.ξ, self.names = own, integral, integral.law, ξ, names
        P = sp.Poly(integral.law.polynomial, integral.law.x)
        self.A, self.B, self.C = (P.coeff_monomial(integral.law.x**k) for k in (2, 1, 0))
        self.e: sp.Expr = sp.S.Zero
        self.direction = 1 if integral.curve.substitution.increasing else -1
        self.at = Signs(own.sample.values, mpmath.mpf(0))

    def _sign(self, expression: sp.Expr) -> int:
        """The sign, where every factor has the same in the whole regime; else 0."""
        relations = [r for e, sign in self.own.conditions.items() if (r := plain_relation(e, sign)) is not None]
        for factor in sp.Mul.make_args(sp.factor(expression)):
            base, power = factor.as_base_exp()
            fixed = base.is_positive or base.is_negative or any(_bounds(r, base) for r in relations)
            if not fixed and not (power.is_integer and power.is_even):
                return 0
        return sign_of_many_digits(self.at.number(expression))

    def forms(self, elapsed: sp.Expr, start: sp.Symbol) -> dict[str, sp.Expr]:
        """q(ξ) and t(ξ).

        Args:
            elapsed: t − t₀.
            start: the lower limit.
        """
        s, q = self.integral.curve.substitution, self.integral.curve.coordinate.symbol
        x, root, amount, ξ_0 = self._parametrised(s.place.subs(q, start))
        weight = sp.Add(*(c for c, _ in self.law.terms))
        running = weight * amount + self.law.algebraic.subs(self.law.x, x) * root
        function = self._scaled(sp.expand(sp.expand(running)))
        t = self.time = next(term for term in elapsed.args if term.is_Symbol)
        passed = self.names.named(f"{t.name}_p", (t - elapsed) - function.subs(self.ξ, ξ_0))
        found = {self.own.name: shortened_powers(s.inverse.subs(s.x, x)), TIME: passed + function}
        self._verify(found)
        return found

    def solved_cubic(self, found: Mapping[str, sp.Expr]) -> sp.Expr | None:
        """q(t) by t − t_p = (s ξ + ξ³/3)/n', a cubic with one real root: Barker's equation; None of any other.

        Args:
            found: q(ξ) and t(ξ).
        """
        passed, running = found[TIME].as_independent(self.ξ, as_Add=True)
        if not running.is_polynomial(self.ξ) or sp.degree(running, self.ξ) != 3:
            return None
        third, second, first, _ = sp.Poly(running, self.ξ).all_coeffs()
        ratio = sp.cancel(first / (3 * third))
        if second != 0 or not ratio.is_positive:
            return None
        s = sp.sqrt(ratio)
        elapsed = sp.factor(3 / (2 * s * first)) * (self.time - passed)
        return found[self.own.name].subs(self.ξ, 2 * s * sp.sinh(sp.asinh(elapsed) / 3))

    def _scaled(self, running: sp.Expr) -> sp.Expr:
        """(1/n)(ξ − e sin ξ): written in the eccentricity, the factor of ξ taken out and named."""
        ξ, table = self.ξ, {s: m for s, m in self.names.where.items() if not isinstance(m, tuple) and s != self.e}
        while held := running.free_symbols & set(table):
            running = running.xreplace({s: table[s] for s in held})
        running = sp.expand(running)
        α = sp.factor(sp.cancel(sp.together(running.coeff(ξ))))
        if α == 0 or α.has(ξ):
            return running
        α = shortened_powers(-α if self._sign(α) < 0 else α)
        n = self.names.named("n", shortened_powers(1 / α), short=SHORT)
        terms = dict[sp.Expr, sp.Expr]()
        for term in sp.Add.make_args(running):
            constant, wave = term.as_independent(ξ)
            terms[wave] = terms.get(wave, sp.S.Zero) + constant
        rest = (shortened_powers(sp.factor(sp.cancel(sp.together(c / α)))) * wave for wave, c in terms.items())
        return sp.Add(*rest) / n

    def _parametrised(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        """x(ξ), √P, ∫ dx/√P, and the ξ of a place, on the branch on which q grows."""
        A, B, C, ξ, δ = self.A, self.B, self.C, self.ξ, self.direction
        if A == 0:
            return self._barker(x_0)
        kind = self._sign(A)
        if kind == 0:
            raise NoFormError("the sign of the leading coefficient is open")
        centre = sp.cancel(-B / (2 * A))
        square = sp.expand(sp.cancel(B**2 / (4 * A**2) - C / A))
        D = self.at.number(square)
        size = positive_root(A if kind > 0 else -A)
        if kind > 0 and D < 0:
            h = self.names.named("a", square_root(-square), positive=True)
            middle = self.names.named("c", centre, short=3 * SHORT)
            ψ_0 = δ * sp.asinh((x_0 - middle) / h)
            return middle + δ * h * sp.sinh(ξ), size * h * sp.cosh(ξ), δ * ξ / size, ψ_0
        side = 1 if kind > 0 and self.at.number(centre) < self._place() else -1
        wave, slope = (sp.cosh(ξ), sp.sinh(ξ)) if kind > 0 else (sp.cos(ξ), sp.sin(ξ))
        if kind < 0:
            side = -δ
        x, level, h = self._about(centre, square, side, wave, x_0)
        if kind < 0:
            return x, size * h * slope, δ * ξ / size, sp.acos(level)
        turn = side * δ
        return x, turn * size * h * slope, δ * ξ / size, turn * sp.acosh(level)

    def _about(
        self, centre: sp.Expr, square: sp.Expr, side: int, wave: sp.Expr, x_0: sp.Expr
    ) -> tuple[sp.Expr, sp.Expr, sp.Expr]:  # fmt: skip
        """X = c + side h wave; the wave at a place; h. With an eccentricity h/|c| where the sign of c is known."""
        sign = self._sign(centre)
        if sign == 0:
            h = self.names.named("a", square_root(square), positive=True)
            middle = self.names.named("c", centre, short=3 * SHORT)
            return middle + side * h * wave, side * (x_0 - middle) / h, h
        e = self.names.named("e", sp.sqrt(sp.expand(sp.cancel(square / centre**2))), positive=True)
        a = self.names.named("a", sign * centre, positive=True)
        self.e = e
        return a * (sign + side * e * wave), side * (x_0 / a - sign) / e, a * e

    def _place(self) -> mpmath.mpf:
        """The x of the sample."""
        return next(r for c, r in self.own.regions if c is self.integral.curve).place

    def _barker(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        """P = Bx + C."""
        B, C, ξ, δ = self.B, self.C, self.ξ, self.direction
        first = sp.cancel(-C / B)
        grows = self._sign(B)
        if grows == 0 or self.law.terms:
            raise NoFormError("the sign of the slope of P is open")
        turn = δ * grows
        if self._sign(C) < 0:
            vertex = self.names.named("x_v", sp.factor(first), short=SHORT)
            return vertex * (1 + ξ**2), turn * positive_root(-C) * ξ, sp.S.Zero, turn * sp.sqrt(x_0 / vertex - 1)
        return first + ξ**2 / B, turn * ξ, sp.S.Zero, turn * positive_root(B * x_0 + C)

    def _verify(self, found: Mapping[str, sp.Expr]) -> None:
        """Compare t(ξ) with the integral between two places, to 40 digits."""
        q = self.integral.curve.coordinate.symbol
        explicit = {n: self.names.written_out(e) for n, e in found.items()}
        with mpmath.workdps(_DIGITS + 20):
            numbers = sample_numbers(self.own)
            low, high = monotone_span(self.own, self.integral)
            values = list[tuple[mpmath.mpf, mpmath.mpf]]()
            held = set().union(*(e.free_symbols for e in explicit.values())) - set(numbers) - {self.ξ}
            numbers |= dict.fromkeys(held, (low + high) / 2)  # t₀ and the lower limit shift both alike
            for part in ("0.3", "0.6"):
                ξ = self._solved(explicit[self.own.name], numbers, low + (high - low) * mpmath.mpf(part))
                place, t = (value_at(explicit[n], numbers | {self.ξ: ξ}) for n in (self.own.name, TIME))
                values.append((t, value_at(self.integral.value, numbers | {q: place})))
            (t_1, v_1), (t_2, v_2) = values
            if not abs((t_2 - t_1) - (v_2 - v_1)) <= abs(v_2 - v_1) * mpmath.mpf(10) ** -_DIGITS:
                raise NoFormError("not verified: the parametric form of the time law differs from the integral")

    def _solved(self, place: sp.Expr, numbers: dict[sp.Symbol, mpmath.mpf], target: mpmath.mpf) -> mpmath.mpf:
        """A ξ on the branch at which q is near a place, by bisection in few steps: any such ξ will do."""
        low, high = (mpmath.mpf(0), mpmath.pi) if self._sign(self.A) < 0 else (mpmath.mpf(-40), mpmath.mpf(40))
        grows = self._branch(numbers, place)
        low, high = (low, high) if grows is None else grows
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if value_at(place, numbers | {self.ξ: middle}) < target else (low, middle)
        return (low + high) / 2

    def _branch(
        self, numbers: dict[sp.Symbol, mpmath.mpf], place: sp.Expr
    ) -> tuple[mpmath.mpf, mpmath.mpf] | None:  # fmt: skip
        """Where q grows with ξ: 0 … π of a cosine; else the half line on which it does."""
        if self._sign(self.A) < 0:
            return None
        near, far = (value_at(place, numbers | {self.ξ: mpmath.mpf(k)}) for k in (0, 1))
        below = value_at(place, numbers | {self.ξ: mpmath.mpf(-1)})
        if near > below:
            return None
        return (mpmath.mpf(0), mpmath.mpf(40)) if far > near else (mpmath.mpf(-40), mpmath.mpf(0))
