"""Carlson's symmetric elliptic integrals R_F, R_C, R_D, R_J as functions of sympy (DLMF 19.16)."""

from __future__ import annotations

import sympy as sp
from sympy.core.function import ArgumentIndexError
from sympy.core.sorting import ordered

from hjsolve.functions import many_digits
from hjsolve.functions.printing import Printable


class CarlsonRF(Printable):
    """R_F(x, y, z) = ½ ∫₀^∞ dt / √((t+x)(t+y)(t+z)): the first kind, symmetric in all arguments (DLMF 19.16.1).

    The arguments are put in sympy's order; R_F(x, y, y) is R_C(x, y).
    """

    nargs = 3
    letter, scipy_name, value = "R_F", "elliprf", staticmethod(many_digits.carlson_rf)

    @classmethod
    def eval(cls, x: sp.Expr, y: sp.Expr, z: sp.Expr) -> sp.Expr | None:
        """Order the arguments; give the values of DLMF 19.20(i)."""
        arranged = tuple(ordered((x, y, z)))
        if [x, y, z].count(sp.S.Zero) > 1:
            return sp.oo
        for twice in (y, z):
            if (x, y, z).count(twice) > 1:
                other = next((a for a in arranged if a != twice), twice)
                return CarlsonRC(other, twice) if not _on_cut(twice) else None
        return cls(*arranged) if arranged != (x, y, z) else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_F/∂z = −R_D(x, y, z)/6, DLMF 19.18.1."""
        z, others = _picked(self, argindex)
        return -CarlsonRD(*others, z) / 6

    def _eval_is_positive(self) -> bool | None:
        return _positive(self.args)


class CarlsonRC(Printable):
    """R_C(x, y) = ½ ∫₀^∞ dt / (√(t+x) (t+y)): arcs and logarithms in one (DLMF 19.16.6).

    Where y < 0 it is Cauchy's principal value. ``expand_func`` writes it as an arc or a logarithm where the order of
    x and y is known.
    """

    nargs = 2
    letter, scipy_name, value = "R_C", "elliprc", staticmethod(many_digits.carlson_rc)

    @classmethod
    def eval(cls, x: sp.Expr, y: sp.Expr) -> sp.Expr | None:
        """Return the values R_C(x, x), R_C(0, y) (DLMF 19.6.15)."""
        if y.is_zero:
            return sp.oo
        if x == y and not _on_cut(x):
            return 1 / sp.sqrt(x)
        if x.is_zero and y.is_positive:
            return sp.pi / (2 * sp.sqrt(y))
        if x.is_zero and y.is_negative:
            return sp.S.Zero
        return None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_C/∂x = (R_C − 1/√x)/(2(y − x)), ∂R_C/∂y = (√x/y − R_C)/(2(y − x)).

        Both follow from 2x ∂ₓ + 2y ∂ᵧ = −1 (homogeneity) and from R_C's integral; right for y < 0 as well.
        """
        x, y = self.args
        if argindex not in {1, 2}:
            raise ArgumentIndexError(self, argindex)
        return (self - 1 / sp.sqrt(x) if argindex == 1 else sp.sqrt(x) / y - self) / (2 * (y - x))

    def _eval_expand_func(self, **_: object) -> sp.Expr:
        x, y = self.args
        if not (x.is_nonnegative and y.is_positive):
            return self
        if (y - x).is_positive:
            return sp.acos(sp.sqrt(x / y)) / sp.sqrt(y - x)
        if (x - y).is_positive:
            return sp.atanh(sp.sqrt((x - y) / x)) / sp.sqrt(x - y)
        return self

    def _eval_is_positive(self) -> bool | None:
        return _positive(self.args)


class CarlsonRD(Printable):
    """R_D(x, y, z) = (3/2) ∫₀^∞ dt / (√((t+x)(t+y)) (t+z)^(3/2)): the second kind (DLMF 19.16.5).

    Symmetric in x and y, which are put in sympy's order.
    """

    nargs = 3
    letter, scipy_name, value = "R_D", "elliprd", staticmethod(many_digits.carlson_rd)

    @classmethod
    def eval(cls, x: sp.Expr, y: sp.Expr, z: sp.Expr) -> sp.Expr | None:
        """Order x and y; give the values of DLMF 19.20(iv)."""
        if z.is_zero or (x.is_zero and y.is_zero):
            return sp.oo
        if x == y == z and not _on_cut(x):
            return x ** sp.Rational(-3, 2)
        if x.is_zero and y == z and not _on_cut(y):
            return 3 * sp.pi / (4 * y ** sp.Rational(3, 2))
        arranged = tuple(ordered((x, y)))
        return cls(*arranged, z) if arranged != (x, y) else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_D/∂x = (R_D(x, y, z) − R_D(y, z, x))/(2(z − x)), partial fractions; ∂/∂z by homogeneity, DLMF 19.18.11.

        Where x and z are the same expression the integral is elementary: −¾ ∂²R_C(y, x)/∂x².
        """
        x, y, z = self.args
        if argindex == 3:
            slopes = sp.Add(*(self.args[i] * self.fdiff(i + 1) for i in (0, 1)))
            return -(sp.Rational(3, 2) * self + slopes) / z
        if argindex not in {1, 2}:
            raise ArgumentIndexError(self, argindex)
        mine, other = (x, y) if argindex == 1 else (y, x)
        if mine != z:
            return (self - CarlsonRD(other, z, mine)) / (2 * (z - mine))
        return -sp.Rational(3, 4) * _second_slope(other, z)

    def _eval_is_positive(self) -> bool | None:
        return _positive(self.args)


class CarlsonRJ(Printable):
    """R_J(x, y, z, p) = (3/2) ∫₀^∞ dt / (√((t+x)(t+y)(t+z)) (t+p)): the third kind (DLMF 19.16.2).

    Symmetric in x, y, z, which are put in sympy's order; R_J(x, y, z, z) is R_D(x, y, z). Where p < 0 it is Cauchy's
    principal value.
    """

    nargs = 4
    letter, scipy_name, value = "R_J", "elliprj", staticmethod(many_digits.carlson_rj)

    @classmethod
    def eval(cls, x: sp.Expr, y: sp.Expr, z: sp.Expr, p: sp.Expr) -> sp.Expr | None:
        """Order x, y, z; R_D where p is one of them."""
        if p.is_zero or [x, y, z].count(sp.S.Zero) > 1:
            return sp.oo
        arranged = list(ordered((x, y, z)))
        if p in arranged:
            arranged.remove(p)
            return CarlsonRD(*arranged, p)
        return cls(*arranged, p) if tuple(arranged) != (x, y, z) else None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂R_J/∂x = (R_J − R_D(y, z, x))/(2(p − x)), from partial fractions; ∂/∂p by homogeneity, DLMF 19.18.11."""
        p = self.args[3]
        if argindex == 4:
            slopes = sp.Add(*(self.args[i] * self.fdiff(i + 1) for i in range(3)))
            return -(sp.Rational(3, 2) * self + slopes) / p
        mine, others = _picked(self, argindex, symmetric=3)
        return (self - CarlsonRD(*others, mine)) / (2 * (p - mine))

    def _eval_is_positive(self) -> bool | None:
        return _positive(self.args)


def _picked(function: sp.Function, argindex: int, symmetric: int = 3) -> tuple[sp.Expr, tuple[sp.Expr, ...]]:
    """One of the symmetric arguments and the others."""
    if not 1 <= argindex <= symmetric:
        raise ArgumentIndexError(function, argindex)
    arguments = function.args[:symmetric]
    return arguments[argindex - 1], arguments[: argindex - 1] + arguments[argindex:]


def _second_slope(x: sp.Expr, y: sp.Expr) -> sp.Expr:
    """∂²R_C(x, y)/∂y²."""
    variable = sp.Dummy()
    return CarlsonRC(x, variable).diff(variable, 2).subs(variable, y)


def _on_cut(argument: sp.Expr) -> bool:
    """Return whether the argument is known to be negative, where the integral does not exist."""
    return bool(argument.is_extended_negative)


def _positive(arguments: tuple[sp.Expr, ...]) -> bool | None:
    """Positive integrands have positive integrals; nothing is said of others."""
    return True if all(argument.is_positive for argument in arguments) else None
