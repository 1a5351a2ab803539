"""∫ R(x) dx/√P(x) for deg P ≤ 2, in the functions that are real where the motion is.

With u = 1/(x − r) a pole at r becomes a power: ∫ dx/((x − r)ᵏ √P) = −σ ∫ uᵏ⁻¹ du/√Q(u), Q = P(r) u² + P′(r) u + ½P″,
σ the sign of x − r. Powers are reduced by d(uⁿ √Q), so that what is left are ∫ du/√Q: arc sine, area functions,
a root or a logarithm, according to the signs of the leading coefficient and of the discriminant.

Gradshteyn and Ryzhik (2007), 2.26; the discriminant of Q is that of P.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.signs import Signs
from hjsolve.functions.elliptic import PartialFractions


@dataclass(frozen=True)
class BasicIntegral:
    """∫ dx/√P, or ∫ dx/((x − r) √P) with u = 1/(x − r).

    Attributes:
        kind: arcsine, area sine, area cosine right, area cosine left, root, line, logarithm.
        quadratic: A, B, C of Q = A u² + B u + C.
        place: r; None where u = x.
        side: σ, the sign of x − r; −1 where u = x, so that the integral is −σ ∫ du/√Q always.
    """

    kind: str
    quadratic: tuple[sp.Expr, sp.Expr, sp.Expr]
    place: sp.Expr | None
    side: int

    def variable(self, x: sp.Expr) -> sp.Expr:
        """u(x).

        Args:
            x: the variable of the curve, or what stands for it.
        """
        return x if self.place is None else 1 / (x - self.place)

    def written(self, x: sp.Expr) -> sp.Expr:
        """The integral as a function of x.

        Args:
            x: the variable of the curve, or what stands for it.
        """
        A, B, C = self.quadratic
        u = self.variable(x)
        slope, D = _halved(A, B, C, sp.Dummy("u"), u)
        match self.kind:
            case "arcsine":
                value = sp.asin(-slope / positive_root(D)) / positive_root(-A)
            case "area sine":
                value = sp.asinh(slope / positive_root(-D)) / positive_root(A)
            case "area cosine right":
                value = sp.acosh(slope / positive_root(D)) / positive_root(A)
            case "area cosine left":
                value = -sp.acosh(-slope / positive_root(D)) / positive_root(A)
            case "root":
                value = 2 * positive_root(B * u + C) / B
            case "line":
                value = u / positive_root(C)
            case _:
                value = self.sign_of_u * sp.log(self.sign_of_u * u) / positive_root(A)
        return -self.side * value

    @property
    def sign_of_u(self) -> int:
        """The sign of u on the piece; of a logarithm only."""
        return self.side

    def complete(self) -> sp.Expr | None:
        """The integral from root to root; None where P does not have two roots with P > 0 between."""
        A = self.quadratic[0]
        if self.kind != "arcsine":
            return None
        return (1 if self.place is None else self.side) * sp.pi / positive_root(-A)


@dataclass(frozen=True)
class Antiderivative:
    """∫ R dx/√P = a(x) √P + Σ c_k I_k(x).

    Attributes:
        x: the variable.
        polynomial: P.
        algebraic: a(x), rational.
        terms: the coefficients and the integrals.
    """

    x: sp.Symbol
    polynomial: sp.Expr
    algebraic: sp.Expr
    terms: tuple[tuple[sp.Expr, BasicIntegral], ...]

    def written(self, x: sp.Expr | None = None) -> sp.Expr:
        """The function.

        Args:
            x: what is put for the variable; the variable itself by default.
        """
        place = self.x if x is None else x
        algebraic = sp.factor(self.algebraic) * positive_root(self.polynomial) if self.algebraic != 0 else sp.S.Zero
        return algebraic.subs(self.x, place) + sp.Add(*(c * term.written(place) for c, term in self.terms))

    def complete(self) -> sp.Expr | None:
        """From root to root of P, where P > 0 between two of them; None elsewhere."""
        values = [(c, term.complete()) for c, term in self.terms]
        if any(value is None for _, value in values):
            return None
        return sp.Add(*(c * value for c, value in values))

    def residual(self, integrand: sp.Expr) -> sp.Expr:
        """√P d/dx of the function less R: zero, exactly, where the function is right.

        Args:
            integrand: R(x).
        """
        P, a = self.polynomial, self.algebraic
        slope = sp.diff(a, self.x) * P + a * sp.diff(P, self.x) / 2
        rest = sp.Add(*(c if t.place is None else c / (self.x - t.place) for c, t in self.terms))
        return sp.cancel(sp.together(slope + rest - integrand))


def _halved(
    A: sp.Expr, B: sp.Expr, C: sp.Expr, name: sp.Symbol, u: sp.Expr
) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
    """Au + B/2 and B²/4 − AC, both without the positive factor of the first."""
    slope, D = A * name + B / 2, sp.expand(B**2 / 4 - A * C)
    number, rest = sp.factor_terms(slope).as_coeff_Mul()
    common = abs(number) * sp.Mul(*(f for f in sp.Mul.make_args(rest) if f.is_positive))
    slope = sp.expand(sp.cancel(slope / common)).subs(name, u)
    if u.is_Pow or not u.is_Symbol:
        slope = sp.factor(sp.together(slope))
    return slope, sp.factor_terms(sp.expand(sp.cancel(D / common**2)))


def positive_root(radicand: sp.Expr) -> sp.Expr:
    """√ of what is positive, with squares and common factors taken out.

    Args:
        radicand: positive where the form holds.
    """
    return sp.sqrt(sp.factor_terms(radicand))


def elementary_antiderivative(
    R: PartialFractions, P: sp.Poly, signs: Signs, side_of: Callable[[sp.Expr], int]
) -> Antiderivative:
    """Integrate R/√P, deg P ≤ 2, real on the piece of the x-axis that a motion is on.

    Args:
        R: in partial fractions, all poles real.
        P: of degree 0, 1 or 2, squarefree.
        signs: decides between the real forms, and keeps what it decided.
        side_of: r ↦ the sign of x − r on the piece.
    """
    if R.complex_poles:
        raise NoFormError("the integrand has poles at complex places: no real form of it is known here")
    (x,) = P.gens
    C, B, A = (P.coeff_monomial(x**k) for k in range(3))
    algebraic, terms = sp.S.Zero, dict[sp.Expr | None, list[sp.Expr]]()
    a, c = _powers(list(R.powers), (A, B, C), x, signs)
    algebraic += a
    terms.setdefault(None, []).append(c)
    for place, weights in _by_place(R).items():
        Q = (sp.factor(P.as_expr().subs(x, place)), sp.factor(sp.diff(P.as_expr(), x).subs(x, place)), A)
        Q = (_short(Q[0]), _short(Q[1]), A)
        side, u = side_of(place), sp.Dummy("u")
        a, c = _powers([(power - 1, weight) for power, weight in weights], Q, u, signs)
        # √Q(u) = σ √P/(x − r), and the integral is −σ times that over u
        algebraic += -a.subs(u, 1 / (x - place)) / (x - place)
        terms.setdefault(place, []).append(c)
    kept = []
    for place, found in terms.items():
        if (weight := _short(sp.Add(*found))) == 0:
            continue
        quadratic = (A, B, C) if place is None else (
            _short(P.as_expr().subs(x, place)), _short(sp.diff(P.as_expr(), x).subs(x, place)), A
        )  # fmt: skip
        side = -1 if place is None else side_of(place)
        kind = _kind(quadratic, signs, place)
        if kind == "root" and place is None:  # c ∫dx/√(Bx + C) is a multiple of √P as well
            algebraic += 2 * weight / B
            continue
        kept.append((weight, BasicIntegral(kind, quadratic, place, side)))
    return Antiderivative(x, P.as_expr(), algebraic, tuple(kept))


def _by_place(R: PartialFractions) -> dict[sp.Expr, list[tuple[int, sp.Expr]]]:
    """Place → (power, weight) of the poles there."""
    found = dict[sp.Expr, list[tuple[int, sp.Expr]]]()
    for place, power, weight in R.poles:
        found.setdefault(place, []).append((power, weight))
    return found


def _short(expression: sp.Expr) -> sp.Expr:
    return sp.factor(sp.cancel(sp.together(sp.expand(expression))))


def _powers(
    weights: list[tuple[int, sp.Expr]], quadratic: tuple[sp.Expr, sp.Expr, sp.Expr], u: sp.Symbol, signs: Signs
) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
    """Σ w_n ∫ uⁿ du/√Q = a(u) √Q + c ∫ du/√Q: a and c."""
    A, B, C = quadratic
    a, left = sp.S.Zero, dict[int, sp.Expr]()
    for n, weight in weights:
        left[n] = left.get(n, sp.S.Zero) + weight
    while left and (n := max(left)) > 0:
        weight = left.pop(n)
        if signs.sign(A) != 0:
            a += weight * u ** (n - 1) / (n * A)
            lower = {n - 1: -weight * (n - sp.Rational(1, 2)) * B / (n * A), n - 2: -weight * (n - 1) * C / (n * A)}
        elif signs.sign(B) != 0:
            a += weight * u**n / ((n + sp.Rational(1, 2)) * B)
            lower = {n - 1: -weight * n * C / ((n + sp.Rational(1, 2)) * B)}
        else:  # ∫ uⁿ du/√C = uⁿ⁺¹ √C/((n + 1) C)
            a += weight * u ** (n + 1) / ((n + 1) * C)
            lower = {}
        for m, more in lower.items():
            if m >= 0 and more != 0:
                left[m] = left.get(m, sp.S.Zero) + more
    return a, left.get(0, sp.S.Zero)


def _kind(
    quadratic: tuple[sp.Expr, sp.Expr, sp.Expr], signs: Signs, place: sp.Expr | None
) -> str:  # fmt: skip
    A, B, C = quadratic
    leading = signs.sign(A)
    if leading < 0:
        return "arcsine"
    if leading == 0:
        return "line" if signs.sign(B) == 0 else "root"
    discriminant = sp.expand(B**2 - 4 * A * C)
    if signs.sign(discriminant) == 0:
        return "logarithm"
    if signs.sign(discriminant) < 0:
        return "area sine"
    # 2Au + B is positive right of the greater root of Q and negative left of the smaller
    return "area cosine right" if signs.slope_sign(A, B, place) > 0 else "area cosine left"
