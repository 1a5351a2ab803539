"""The curve y² = P(x) of a separated coordinate: P²(q) and φ′² in a variable x, squares taken out.

∫ N dq/√P² = ε ∫ N dx/(S √P), with P² G = S² P, P without multiple factors, and ε the sign of S φ′ on the piece of the
x-axis the motion is on. The genus decides: deg P ≤ 2 elementary, 3 or 4 elliptic, more hyperelliptic.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import sympy as sp

from hjsolve.closed_form.change_of_variable import Substitution, extended_domain_ends
from hjsolve.closed_form.substitutions import known_substitutions
from hjsolve.display.shown import Shown
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

W = sp.Symbol("W")
"""The key of ∫ p dq among the integrals of a coordinate; the others are ∫ ∂p/∂c dq by their constant c."""


@dataclass(frozen=True, repr=False)
class MomentumCurve(Shown):
    """One coordinate's curve y² = P(x).

    Attributes:
        coordinate: q.
        substitution: x = φ(q), and P²(q) as a function of x.
        polynomial: P(x), squarefree.
        square: S(x), rational, with P² φ′² = S² P.
        momentum_squared: P²(q).
        generic: P²(q) as a function of x for general constants.
        special_case: constant → what it is, where the constants are special.
    """

    coordinate: Coordinate
    substitution: Substitution
    polynomial: sp.Poly
    square: sp.Expr
    momentum_squared: sp.Expr
    generic: sp.Expr
    special_case: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)

    @property
    def degree(self) -> int:
        """The degree of P."""
        return int(self.polynomial.degree())

    @property
    def ends(self) -> tuple[sp.Expr, sp.Expr]:
        """The ends of the domain of q."""
        return extended_domain_ends(self.coordinate)

    def numerator(self, key: sp.Symbol) -> sp.Expr:
        """N as a function of x, of ∫ N dq/√P²: P² itself for W, ½ ∂P²/∂c for a constant c.

        Args:
            key: ``W``, or a constant of the motion.
        """
        if key == W:
            return self.substitution.function
        return (sp.diff(self.generic, key) / 2).subs(self.special_case)

    def at(self, special_case: Mapping[sp.Symbol, sp.Expr]) -> MomentumCurve | None:
        """Return the curve of motions whose constants obey equations, such as E = 0.

        Args:
            special_case: constant → what it is.
        """
        # with E = 0 the leading coefficient drops out, or two roots meet: another P, and another S
        special = replace(self.substitution, function=self.substitution.function.subs(dict(special_case)))
        found = momentum_curve(special, self.coordinate, self.momentum_squared)
        return None if found is None else replace(found, generic=self.generic, special_case=dict(special_case))

    @property
    def substitution_square(self) -> sp.Expr:
        """P²(q) through the variable: the square of the coordinate's momentum in the special case."""
        return self.momentum_squared.subs(dict(self.special_case))

    @property
    def x(self) -> sp.Symbol:
        """The variable."""
        return self.substitution.x


def momentum_curves(square: sp.Expr, coordinate: Coordinate, x: sp.Symbol) -> list[MomentumCurve]:
    """Return the curves of a squared momentum in every variable that makes it algebraic, the simplest first.

    Args:
        square: P²(q; constants).
        coordinate: q.
        x: the symbol of the variable.
    """
    found = [
        curve
        for s in known_substitutions(square, coordinate, x)
        if (curve := momentum_curve(s, coordinate, square)) is not None
    ]
    return sorted(found, key=_plainness)


def _plainness(curve: MomentumCurve) -> tuple[int, ...]:
    """Genus, whether a root of P has no radicals, degree, whether P has odd powers, length of the variable.

    Of 1/q the degree is at least 2: a fall along a line is a cycloid in q itself. Of genus 1 an exponential, whose ends
    of the line are branch points or no less, comes after functions that are even or odd, as the potential is.
    """
    P, x = curve.polynomial, curve.x
    plain = curve.degree <= 2
    if 2 < curve.degree <= 4:
        bare, _ = named_constants(P.as_expr(), x)
        factors = [sp.Poly(f, x) for f, _ in sp.factor_list(sp.numer(sp.together(bare)), x)[1]]
        # factors to second degree, or even ones, have roots in radicals: their forms hold no numbered roots
        plain = all(f.degree() <= 2 or not any(n % 2 for (n,) in f.monoms()) for f in factors)
    place, q = curve.substitution.place, curve.coordinate.symbol
    degree = max(curve.degree, 2) if place == 1 / q else curve.degree
    elliptic, exponential = genus(degree) == 1, isinstance(place, sp.exp)
    ranked = 4 if elliptic and exponential else degree
    odd = degree > 2 and any(n % 2 for (n,) in P.monoms())
    return (
        genus(degree), int(not plain), ranked, int(odd), int(elliptic and exponential), degree,
        int(sp.count_ops(place.as_coeff_Mul()[1])),  # -sin((d - q)/2) is no longer than sin(q/2)
    )  # fmt: skip


def genus(degree: int) -> int:
    """Return the genus of y² = P(x).

    Args:
        degree: of P, squarefree.
    """
    # the number of independent integrals of the first kind: 0 elementary, 1 elliptic (Legendre), 2 and more neither
    return max(0, (degree - 1) // 2)


def momentum_curve(substitution: Substitution, coordinate: Coordinate, square: sp.Expr) -> MomentumCurve | None:
    """Return the curve in a given variable; None where P² is not rational in it.

    Args:
        substitution: the variable.
        coordinate: q.
        square: P²(q).
    """
    x = substitution.x
    # letters in place of √2 or sin α: sympy's polynomials over algebraic numbers are much slower
    bare, back = named_constants(substitution.function * substitution.slope_squared, x)
    top, bottom = sp.fraction(sp.cancel(sp.together(bare)))
    if not (top.is_polynomial(x) and bottom.is_polynomial(x)) or top == 0:
        return None
    # R = N/D in lowest terms; √R = √(odd part) × (the rest), so that P has no square factor
    below = sp.factor_list(bottom, x)
    monic = sp.Mul(*(factor**power for factor, power in below[1]))
    above = sp.factor_list(top, x)
    root, odd, powers = sp.S.One, sp.S.One, dict[sp.Expr, int]()
    for factor, power in (*above[1], *below[1]):
        powers[factor] = powers.get(factor, 0) + power
    for factor, power in powers.items():
        root *= factor ** (power // 2)
        odd *= factor ** (power % 2)
    # squares of positive constants go before the root: the signs that regimes ask for stay short
    outside, inside = _squares(sp.factor(above[0] / below[0]))
    P = sp.Poly((inside * odd).expand().xreplace(back), x)
    return MomentumCurve(
        coordinate, substitution, P, sp.factor(outside * root / monic).xreplace(back), square, substitution.function
    )


def _squares(content: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Squares of positive numbers and symbols taken out of a factor: c = a² b."""
    outside, inside = sp.S.One, sp.S.One
    for factor in sp.Mul.make_args(content):
        if factor.is_Rational:
            for part, exponent in ((abs(int(factor.p)), 1), (int(factor.q), -1)):
                for prime, power in sp.factorint(part).items():
                    outside *= sp.Integer(prime) ** (exponent * (power // 2))
                    inside *= sp.Integer(prime) ** (exponent * (power % 2))
            # the sign stays within: P > 0 where the motion is
            inside *= sp.sign(factor)
            continue
        base, power = factor.as_base_exp()
        if power.is_Integer and base.is_positive:
            # only of what is positive for all letters: of others the sign would be lost
            whole, half = divmod(abs(int(power)), 2)
            outside *= base ** (whole * sp.sign(power))
            inside *= base ** (half * sp.sign(power))
        else:
            inside *= factor
    return outside, inside


def named_constants(expression: sp.Expr, x: sp.Symbol) -> tuple[sp.Expr, dict[sp.Symbol, sp.Expr]]:
    """Constants that are no rational functions of symbols, √2 or sin α, by names of their own.

    Args:
        expression: rational in x.
        x: the variable.

    Returns:
        The expression in names, and name → constant.
    """
    names = dict[sp.Expr, sp.Symbol]()
    for atom in sorted(expression.atoms(sp.Function, sp.Pow, sp.NumberSymbol), key=sp.default_sort_key):
        if atom.has(x) or (isinstance(atom, sp.Pow) and atom.exp.is_Integer):
            continue
        names[atom] = sp.Dummy(f"k{len(names)}", positive=atom.is_positive, real=True)
    return expression.xreplace(names), {name: atom for atom, name in names.items()}
