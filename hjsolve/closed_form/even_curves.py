"""∫ R(x²) dx/√P for P = A (x² − X₁)(x² − X₂): the forms of the pendulum and of Duffing's oscillator.

With X = x² linear in s = sin² φ, ∫ dx/√P = ± (1/Ω) F(φ|m). By where x is:

    X₁ > X₂ > 0, |x| < √X₂:  x = √X₂ sn,  Ω² = A X₁,          m = X₂/X₁
    X₁ > X₂ > 0, √X₂ < x < √X₁:  x = √X₁ dn,  Ω² = −A X₁,     m = 1 − X₂/X₁
    X₁ > 0 > X₂, |x| < √X₁:  x = √X₁ cn,  Ω² = −A (X₁ − X₂),  m = X₁/(X₁ − X₂)

Byrd and Friedman, Handbook of elliptic integrals (1971), 219, 218, 213.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots
from hjsolve.closed_form.fractions import partial_fractions
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.real_branch_points import FAR, LegendreIntegrals, LegendreMap, over_s
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import in_factors


@dataclass(frozen=True)
class EvenMap:
    """The map of a piece of the x-axis, P even.

    Attributes:
        kind: sn, dn or cn.
        side: the sign of x on the piece, dn; else 1.
        scale: |x| is this times sn, dn or |cn|; positive.
        line: X = x² as a linear function of s: its value at s = 0 and at s = 1.
        m: the parameter.
        Ω: the factor of the argument.
        k: the modulus in forms, by a name.
        rate: Ω in forms, by a name.
    """

    kind: str
    side: int
    scale: sp.Expr
    line: tuple[sp.Expr, sp.Expr]
    m: sp.Expr
    Ω: sp.Expr
    k: sp.Expr = field(default_factory=partial(sp.Dummy, "k", positive=True))
    rate: sp.Expr = field(default_factory=partial(sp.Dummy, "rate", positive=True))

    @property
    def direction(self) -> int:
        """1 where φ grows with x, else −1."""
        return 1 if self.kind == "sn" or self.side < 0 else -1

    @property
    def quarters(self) -> int:
        """How many K the argument grows by from the lower end to the upper."""
        return 1 if self.kind == "dn" else 2

    def amplitude(self, x: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """φ, sin φ and cos φ at x.

        Args:
            x: the variable.
        """
        y = x / self.scale
        if self.kind == "sn":
            return sp.asin(y), y, sp.sqrt(1 - y**2)
        if self.kind == "cn":
            return sp.acos(y), sp.sqrt(1 - y**2), y
        X0, X1 = self.line
        # dn² = 1 − m sn² falls from X₁ at the outer turning point to X₂ at the inner one
        s = (X0 - x**2) / (X0 - X1)
        return sp.asin(sp.sqrt(s)), sp.sqrt(s), sp.sqrt(1 - s)


def even_map(roots: NamedRoots) -> EvenMap | None:
    """Return the map of an even P; None where there is none of these."""
    A = roots.leading
    squares = [sp.factor(sp.expand(r**2)) for r in roots.real]
    # P > 0 between the inner roots ± √X₂: A > 0, a pendulum or a soft spring
    if len(squares) == 4 and roots.interval == (1, 2):
        X1, X2 = squares[3], squares[2]
        return EvenMap("sn", 1, sp.sqrt(X2), (sp.S.Zero, X2), in_factors(X2 / X1), sp.sqrt(in_factors(A * X1)))
    # A < 0 between an inner and an outer root: one well of two
    if len(squares) == 4 and roots.interval in ((0, 1), (2, 3)):
        X1, X2 = squares[3], squares[2]
        side = 1 if roots.interval == (2, 3) else -1
        return EvenMap("dn", side, sp.sqrt(X1), (X1, X2), in_factors(1 - X2 / X1), sp.sqrt(in_factors(-A * X1)))
    # X₂ < 0, a pair on the imaginary axis: a hard spring, or a double well above its barrier
    if len(squares) == 2 and roots.interval == (0, 1) and roots.pairs[0][0] == 0:
        X1, X2 = squares[1], -sp.factor(sp.expand(roots.pairs[0][1] ** 2))
        gap = in_factors(X1 - X2)
        return EvenMap("cn", 1, sp.sqrt(X1), (X1, sp.S.Zero), in_factors(X1 / gap), sp.sqrt(in_factors(-A * gap)))
    return None


def in_square(R: sp.Expr, x: sp.Symbol, X: sp.Symbol) -> sp.Expr:
    """Return an even rational function of x in X = x².

    Args:
        R: the function.
        x: its variable.
        X: the symbol of x², positive.

    Raises:
        NoFormError: R is not even.
    """
    if sp.cancel(sp.together(R - R.subs(x, -x))) != 0:
        raise NoFormError("the integrand is not even in x")
    return sp.cancel(sp.powdenest(R.subs(x, sp.sqrt(X)), force=True))


def even_integral(
    R: sp.Expr, change: EvenMap, x: sp.Symbol, signs: Signs, *, complete: bool, own: LegendreIntegrals | None = None
) -> sp.Expr:  # fmt: skip
    """∫ R dx/√P: up to x, from x = 0 (sn) or from the upper end (dn, cn); or over the whole piece.

    Args:
        R: rational in x.
        change: the map.
        x: the variable.
        signs: of the sample.
        complete: whether over the whole piece.
        own: the integrals of dφ/Δ, up to another amplitude than that of x.

    Raises:
        NoFormError: R is not even, or has a pole that these integrals do not reach.
    """
    X = sp.Symbol(x.name, positive=True)
    parts = partial_fractions(in_square(R, x, X), X, signs)
    own = own or LegendreIntegrals(change.k, change.m, None if complete else change.amplitude(x))
    # X is linear in sn², as x is on a cubic: the same reductions with d = ∞
    linear = LegendreMap(*change.line, FAR, FAR, 1, sp.S.One)
    total = over_s(parts, linear, own) / change.rate
    return change.quarters * total if complete else change.direction * total
