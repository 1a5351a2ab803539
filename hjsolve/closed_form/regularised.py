"""A coordinate, and every integral over it, as a function of a parameter ξ that passes its turning points smoothly.

With the centre c and half distance h of the roots of P = Ax² + Bx + C, q growing with ξ where ξ is small and positive,

    A < 0:         x = c ∓ h cos ξ    ∫dx/√P = ± ξ/√−A     (eccentric anomaly)
    A > 0, D > 0:  x = c ± h cosh ξ   ∫dx/√P = ± ξ/√A      (its hyperbolic twin)
    A > 0, D < 0:  x = c + h sinh ξ   ∫dx/√P = ± ξ/√A
    A = 0:         x = x₀ (1 + ξ²)    √P = ± √−C ξ         (Barker; ξ = tan ν/2)

and of a pole at r, with a = c − r and b the amplitude, w = √|a² − b²|,

    ∫ dξ/(a + b cos ξ)  = ± (ξ − 2 arctan(b sin ξ/(a ± w + b cos ξ)))/w        (smooth for all ξ)
    ∫ dξ/(a + b cosh ξ) = ± (2/w) arctan(((|b| ∓ a)/w) tanh ½ξ), or artanh
    ∫ dξ/(a + b ξ²)     = arctan(√(b/a) ξ)/√(ab)

Where deg P is 3 or 4, ξ is the argument u of sn u, and the integrals are those of u, E(am u) and Π(ν, am u).

Battin, An introduction to the mathematics and methods of astrodynamics (1999), chapter 4; Whittaker, Analytical
dynamics, § 55, 72.
"""

from __future__ import annotations

import mpmath
import sympy as sp

from hjsolve.closed_form.complex_poles import PairOfComplexPoles
from hjsolve.closed_form.elementary import (
    Antiderivative,
    BasicIntegral,
    elementary_antiderivative,
    positive_root,
)
from hjsolve.closed_form.elliptic_inverses import going_round, in_moduli, place_of_argument, slope_of_argument
from hjsolve.closed_form.even_curves import EvenMap, even_integral
from hjsolve.closed_form.fractions import partial_fractions
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral, monotone_inverse, rational_factor
from hjsolve.closed_form.real_branch_points import LegendreIntegrals, LegendreMap, elliptic_integral, without_square
from hjsolve.closed_form.reduction import reduced
from hjsolve.closed_form.regime import plain_relation, sign_is_fixed
from hjsolve.closed_form.regions import RootInterval
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import one_and_product, square_root
from hjsolve.closed_form.verification import sample_numbers, value_at
from hjsolve.precision import mp


class Regularised:
    """A coordinate on one curve, by its parameter.

    Args:
        own: the coordinate.
        integral: the integral whose curve is used.
        ξ: the parameter.
        start: the lower limit of the coordinate.
        names: of the quantities of the forms.

    Raises:
        NoFormError: no such parameter is known.
    """

    def __init__(
        self, own: CoordinateIntegrals, integral: PieceIntegral, ξ: sp.Symbol, start: sp.Symbol, names: NamedQuantities
    ):  # fmt: skip
        self.own, self.time, self.curve, self.ξ, self.names = own, integral, integral.curve, ξ, names
        s, q = self.curve.substitution, self.curve.coordinate.symbol
        self.region: RootInterval = next(r for c, r in own.regions if c is self.curve)
        self.direction = 1 if s.increasing else -1
        self.signs = Signs(own.sample.values, self.region.place)
        self.signs.name({s: sp.Float(v, 50) for s, v in sample_numbers(own).items() if s not in own.sample.values})
        self.x, self.root, self.amount, self.begin = self._parametrised(s.place.subs(q, start))
        self.place: sp.Expr = self._place()

    def _place(self) -> sp.Expr:
        """q(ξ)."""
        return self.curve.substitution.q(self.x)

    def _parametrised(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        """x(ξ), √P, ∫ dx/√P, and the ξ of a place, on the branch on which q grows."""
        raise NotImplementedError

    def _rational(self, key: sp.Symbol) -> sp.Expr:
        return rational_factor(self.curve, self.region, self.signs, key)

    def integral(self, key: sp.Symbol) -> sp.Expr:
        """∫ ∂p/∂c dq as a function of ξ.

        Args:
            key: the constant c.

        Raises:
            NoFormError: an integral that is not smooth in ξ.
        """
        raise NotImplementedError

    def span(self) -> tuple[sp.Expr, sp.Expr]:
        """Two values of ξ on the branch on which q grows."""
        raise NotImplementedError


class EllipticArgument(Regularised):
    """The argument u of sn u."""

    def _parametrised(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        change = self.time.change
        if not isinstance(change, (LegendreMap, EvenMap)) or self.curve.degree > 4:
            raise NoFormError("no argument of sn u is known here")
        if isinstance(change, EvenMap):
            φ_0 = change.amplitude(x_0)[0]
        else:
            φ_0 = sp.asin(sp.sqrt(self.names.oriented(sp.factor(change.s(x_0)))))
        self.change, self.direction = change, change.direction * self.direction
        if isinstance(change, EvenMap) and self.own.kind == "rotation":
            φ_0 = φ_0.replace(  # of a place more than a quarter of a turn from the top too
                lambda e: isinstance(e, sp.acos) and isinstance(e.args[0], sp.sin),
                lambda e: sp.pi / 2 - e.args[0].args[0],
            )
        # u = F(φ) at the lower limit, x(u) and dx/du from sn, cn and dn
        u_0, x = sp.elliptic_f(monotone_inverse(φ_0), change.k**2), place_of_argument(change, self.ξ, self.names)
        slope = slope_of_argument(change, self.ξ, self.names)
        return x, change.direction * change.rate * slope, change.direction * self.ξ / change.rate, u_0

    def _place(self) -> sp.Expr:
        place = super()._place()
        if self.own.kind != "rotation":
            return place
        place = going_round(place)
        slope, m = sp.diff(place, self.ξ), self.change.k**2
        with mp.workdps(30):
            K = mp.ellipk(value_at(self.names.written_out(m), self.names.numbers))
            at = [self.names.numbers | {self.ξ: (n + mp.mpf("0.5")) * K} for n in range(-4, 4)]
            slopes = [value_at(self.names.written_out(slope), numbers) for numbers in at]
        if len({mp.sign(one) for one in slopes}) > 1:
            raise NoFormError("the angle by sn u turns back after a part of a turn")
        return place

    def integral(self, key: sp.Symbol) -> sp.Expr:
        """∫ ∂p/∂c dq as a function of the parameter."""
        R, change, x = self._rational(key), self.change, self.curve.x
        a, rest = reduced(R, self.curve.polynomial)
        integrals = LegendreIntegrals.along(self.ξ, change.k, change.m)
        if isinstance(change, EvenMap):
            value = even_integral(rest, change, x, self.signs, complete=False, own=integrals)
        else:
            # the poles of second order of x² dx/√P at d, where sn² = 1/ν, would give Π twice
            parts, more = without_square(partial_fractions(rest, x, self.signs), change, self.curve.polynomial)
            value, a = elliptic_integral(parts, change, x, integrals), a + more
        return in_moduli(value + a.subs(x, self.x) * self.root, self.names)

    def span(self) -> tuple[sp.Expr, sp.Expr]:
        """Return two values of the parameter on the branch on which q grows."""
        low, high = sp.Rational(2, 10), sp.Rational(7, 10)
        return (low, high) if self.direction > 0 else (high, low)


class Anomaly(Regularised):
    """The parameter of ∫ R dx/√P, deg P ≤ 2.

    Args:
        conic: whether lengths are a and e, as of Kepler's ellipse, where the signs allow it.
    """

    def __init__(
        self, own: CoordinateIntegrals, integral: PieceIntegral, ξ: sp.Symbol, start: sp.Symbol, names: NamedQuantities
    ):  # fmt: skip
        law = integral.law
        if law is None:
            raise NoFormError("no anomaly is known here")
        # one arc alone is q(t) itself, c − h cos ωt; Kepler's two need a and e
        self.law, self.conic = law, not (law.algebraic == 0 and len(law.terms) == 1)
        P = sp.Poly(law.polynomial, law.x)
        self.A, self.B, self.C = (P.coeff_monomial(law.x**k) for k in (2, 1, 0))
        self.e: sp.Expr = sp.S.Zero
        super().__init__(own, integral, ξ, start, names)

    def sign_of(self, expression: sp.Expr) -> int:
        """Return the sign, where it is the same in the whole regime; else 0.

        Args:
            expression: of parameters and constants.
        """
        relations = [r for e, sign in self.own.conditions.items() if (r := plain_relation(e, sign)) is not None]
        if not sign_is_fixed(relations, expression):
            return 0
        return self.signs.there(expression)

    def _parametrised(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        A, B, C, ξ, δ = self.A, self.B, self.C, self.ξ, self.direction
        if A == 0:
            return self._barker(x_0)
        kind = self.sign_of(A)
        if kind == 0:
            raise NoFormError("the sign of the leading coefficient is open")
        # x = c ± h wave ξ, with h² = D/A²: the middle and half distance of the roots
        centre = sp.cancel(-B / (2 * A))
        square = sp.expand(sp.cancel(B**2 / (4 * A**2) - C / A))
        D = self.signs.number(square)
        size = positive_root(A if kind > 0 else -A)
        # no real root: sinh takes every x once
        if kind > 0 and D < 0:
            h = self.names.named("a", square_root(-square), positive=True)
            middle = self.names.named("c", centre, short=3 * SHORT)
            self.wave = (sp.sinh, middle, δ * h)
            return middle + δ * h * sp.sinh(ξ), size * h * sp.cosh(ξ), δ * ξ / size, δ * sp.asinh((x_0 - middle) / h)
        if kind < 0:
            # of a conic ξ = 0 is the pericentre, else the upper turning point
            x, level, h = self._about(centre, square, -δ if self.conic else 1, sp.cos, x_0)
            turn = 1 if self.conic else -δ
            ξ_0 = sp.acos(level) if self.conic else -δ * sp.acos(level)
            return x, turn * size * h * sp.sin(ξ), δ * ξ / size, ξ_0
        # on the branch of the hyperbola that the motion is on: r = a (e cosh ξ − 1), attracted
        side = 1 if self.signs.number(centre) < self.region.place else -1
        x, level, h = self._about(centre, square, side, sp.cosh, x_0)
        turn = side * δ
        return x, turn * size * h * sp.sinh(ξ), δ * ξ / size, turn * sp.acosh(level)

    def _about(
        self, centre: sp.Expr, square: sp.Expr, side: int, wave: type[sp.Function], x_0: sp.Expr
    ) -> tuple[sp.Expr, sp.Expr, sp.Expr]:  # fmt: skip
        """X = c + side h wave; the wave at a place; h. With an eccentricity h/|c| where the sign of c is known."""
        sign = self.sign_of(centre) if self.conic else 0
        if sign == 0:
            h = self.names.named("a", square_root(square), positive=True)
            middle = self.names.named("c", centre, short=3 * SHORT)
            self.wave = (wave, middle, side * h)
            return middle + side * h * wave(self.ξ), side * (x_0 - middle) / h, h
        # e = h/|c|, so that of Kepler e² = 1 + 2EL²/mk²
        e = self.names.named("e", sp.sqrt(one_and_product(square / centre**2)), positive=True)
        a = self.names.named("a", sign * centre, positive=True)
        self.e, self.wave = e, (wave, sign * a, side * a * e)
        return a * (sign + side * e * wave(self.ξ)), side * (x_0 / a - sign) / e, a * e

    def _barker(self, x_0: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        """P = Bx + C."""
        B, C, ξ, δ = self.B, self.C, self.ξ, self.direction
        first = sp.cancel(-C / B)
        grows = self.sign_of(B)
        if grows == 0:
            raise NoFormError("the sign of the slope of P is open")
        # q grows with ξ where it grows with x (δ) and x with ξ² (the sign of B)
        turn = δ * grows
        if self.sign_of(C) < 0:
            positive = True if self.sign_of(first) > 0 else None
            vertex = self.names.named("x_v", sp.factor(first), short=SHORT, positive=positive)
            root = positive_root(-C)
            self.wave = (sp.Pow, vertex, vertex)
            return vertex * (1 + ξ**2), turn * root * ξ, 2 * turn * root * ξ / B, turn * sp.sqrt(x_0 / vertex - 1)
        self.wave = (sp.Pow, first, 1 / B)
        # without a sign of C: ξ = √P itself
        return first + ξ**2 / B, turn * ξ, 2 * turn * ξ / B, turn * positive_root(B * x_0 + C)

    def integral(self, key: sp.Symbol) -> sp.Expr:
        """∫ ∂p/∂c dq as a function of the parameter."""
        law = elementary_antiderivative(self._rational(key), self.curve.polynomial, self.signs, self._side)
        return self._along(law)

    def _side(self, r: sp.Expr) -> int:
        return 1 if self.region.place > self.signs.number(r) else -1

    def _along(self, law: Antiderivative) -> sp.Expr:
        algebraic = law.algebraic.subs(law.x, self.x) * self.root
        return sp.expand(algebraic) + sp.Add(*(c * self._term(term) for c, term in law.terms))

    def _term(self, term: BasicIntegral | PairOfComplexPoles) -> sp.Expr:
        if isinstance(term, PairOfComplexPoles):
            raise NoFormError("an integral past complex poles is not written in the anomaly")
        return self.amount if term.place is None else self._pole(term)

    def _pole(self, term: BasicIntegral) -> sp.Expr:
        """∫ dx/((x − r) √P), or ∫ dx/((r² − x²) √P)."""
        (function, middle, b), ξ, r = self.wave, self.ξ, term.place
        if term.kind == "pair":
            return self._pair(r)
        # ∫ dx/((x − r) √P) = ∫ (dx/√P)/(a + b wave ξ), dx/√P = rate dξ
        a, rate = sp.factor(middle - r), sp.diff(self.amount, ξ)
        a_n, b_n = (self._number(e) for e in (a, b))
        if function is sp.sinh or (function is sp.Pow and not a_n * b_n > 0):
            raise NoFormError("the integral is not smooth in the anomaly")
        if function is sp.Pow:
            sign = 1 if a_n > 0 else -1
            return sign * rate * sp.atan(sp.sqrt(sp.factor(b / a)) * ξ) / sp.sqrt(sp.factor(a * b))
        # w = √|a² − b²| = √|P(r)/A|
        P, sign = sp.Poly(self.law.polynomial, self.law.x), 1 if (a_n if abs(a_n) > abs(b_n) else b_n) > 0 else -1
        square = sp.factor(P.as_expr().subs(self.law.x, r) / self.A)
        w = square_root(square if self._number(square) > 0 else -square)
        if function is sp.cos:
            # 2 arctan(√((a−b)/(a+b)) tan ½ξ) would jump at ξ = π; less ξ it is the arctan of a periodic function
            above = b * sp.sin(ξ) / (a + sign * w + b * sp.cos(ξ))
            if self.e != 0 and r == 0:
                # r = 0: a = c, w = |c| √(1 − e²), the true anomaly ν = ξ + 2 arctan(e sin ξ/(1 + √(1 − e²) − e cos ξ))
                e = b / middle  # ± e
                above = e * sp.sin(ξ) / (1 + sp.sqrt(1 - self.e**2) + e * sp.cos(ξ))
            return sign * rate * (ξ - 2 * sp.atan(above)) / w
        # |b| > |a|: of a pole between the roots of P, tanh; else artanh
        if abs(b_n) > abs(a_n):
            slope = (sign * b - sign * a) / w
            if self.e != 0 and r == 0:
                # (|b| ∓ a)/√(b² − a²) of r = a (e cosh ξ ∓ 1): tan ½ν = √((e ± 1)/(e ∓ 1)) tanh ½ξ
                slope = (sp.sqrt(self.e + 1) / sp.sqrt(self.e - 1)) ** (-1 if a_n * b_n > 0 else 1)
            return sign * rate * 2 * sp.atan(slope * sp.tanh(ξ / 2)) / w
        if not a_n * b_n > 0:
            raise NoFormError("the integral is not smooth in the anomaly")
        return sign * rate * 2 * sp.atanh((sign * a - sign * b) / w * sp.tanh(ξ / 2)) / w

    def _pair(self, r: sp.Expr) -> sp.Expr:
        """∫ dx/((r² − x²) √P), P even: arctan(k tan ξ) is ξ + arctan((k − 1) sin 2ξ/(k + 1 − (k − 1) cos 2ξ))."""
        function, middle, b = self.wave
        if function is not sp.cos or middle != 0:
            raise NoFormError("the integral is not smooth in the anomaly")
        # x = b cos ξ, so that r² − x² = w² + b² sin² ξ, w² = r² − b²: an arctan of (r/w) tan ξ, made smooth
        w, ξ = sp.sqrt(sp.factor(sp.cancel(r**2 - self.names.written_out(b) ** 2))), self.ξ
        above = (r - w) * sp.sin(2 * ξ) / (r + w - (r - w) * sp.cos(2 * ξ))
        return sp.diff(self.amount, ξ) * (ξ + sp.atan(above)) / (r * w)

    def _number(self, e: sp.Expr) -> mpmath.mpf:
        with mp.workdps(50):
            return value_at(self.names.written_out(e), self.names.numbers)

    def span(self) -> tuple[sp.Expr, sp.Expr]:
        """Return two values of the parameter on the branch on which q grows."""
        low, high = sp.Rational(3, 10), sp.Rational(8, 10)
        if self.wave[0] is sp.cos and not self.conic and self.direction > 0:
            return -high, -low
        if self.wave[0] is sp.sinh:
            return low, high
        rising = self._number(sp.diff(self.place, self.ξ).subs(self.ξ, low))
        return (low, high) if rising > 0 else (-high, -low)


def by_parameter(
    own: CoordinateIntegrals, integral: PieceIntegral, ξ: sp.Symbol, start: sp.Symbol, names: NamedQuantities
) -> Regularised:  # fmt: skip
    """Return a coordinate by the parameter of an integral.

    Args:
        own: the coordinate.
        integral: the integral.
        ξ: the parameter.
        start: the lower limit.
        names: of the quantities of the forms.

    Raises:
        NoFormError: no such parameter is known.
    """
    kind: type[Regularised] = EllipticArgument if integral.law is None else Anomaly
    return kind(own, integral, ξ, start, names)
