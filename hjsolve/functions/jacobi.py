"""Jacobi's sn, cn, dn, am and ℰ = ∫ dn² as functions of sympy, of argument u and parameter m = k² (DLMF 22)."""

from __future__ import annotations

import sympy as sp
from sympy.core.function import ArgumentIndexError

from hjsolve.functions import many_digits
from hjsolve.functions.printing import Printable


class _Jacobi(Printable):
    """What they have in common: parity, quarter periods, the inverse, realness."""

    nargs = 2
    odd = True
    """Whether the function is odd in u; else it is even."""

    @classmethod
    def eval(cls, u: sp.Expr, m: sp.Expr) -> sp.Expr | None:
        """Values at whole multiples of K(m), m = 0 and 1; a sign of u comes out; F(φ|m) gives φ back where it is real.

        Args:
            u: the argument.
            m: the parameter.
        """
        if u.is_zero:
            return cls._at_quarter(0, m)
        if m.is_zero:
            return cls._circular(u)
        if (m - 1).is_zero:
            return cls._hyperbolic(u)
        quarters = u / sp.elliptic_k(m)
        if quarters.is_Integer and quarters != 0:
            return cls._at_quarter(int(quarters), m)
        if u.could_extract_minus_sign():
            return -cls(-u, m) if cls.odd else cls(-u, m)
        if isinstance(u, sp.elliptic_f) and u.args[1] == m and u.args[0].is_real and (1 - m).is_positive:
            return cls._of_amplitude(u.args[0], m)
        return None

    @classmethod
    def _at_quarter(cls, n: int, m: sp.Expr) -> sp.Expr:
        """Return the value at n K(m), DLMF 22.5(i)."""
        return cls._of_amplitude(n * sp.pi / 2, m)

    @classmethod
    def _circular(cls, u: sp.Expr) -> sp.Expr:
        """Return the value at m = 0, DLMF 22.5(ii)."""
        return cls._of_amplitude(u, sp.S.Zero)

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        """Return the value at m = 1, DLMF 22.5(ii)."""
        raise NotImplementedError

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, m: sp.Expr) -> sp.Expr:
        """Return the value where the amplitude is φ, DLMF 22.20.1."""
        raise NotImplementedError

    def _slope(self, by_amplitude: sp.Expr, argindex: int) -> sp.Expr:
        """∂/∂u or ∂/∂m of what depends on them through the amplitude alone."""
        u, m = self.args
        if argindex == 1:
            return by_amplitude * JacobiDN(u, m)
        if argindex == 2:
            return by_amplitude * _amplitude_by_parameter(u, m)
        raise ArgumentIndexError(self, argindex)

    def _eval_is_real(self) -> bool | None:
        return True if all(argument.is_real for argument in self.args) else None


class JacobiAM(_Jacobi):
    """am(u|m): the amplitude φ with u = F(φ|m) = ∫₀^φ dθ/√(1 − m sin²θ); for real u and m (DLMF 22.16.1).

    Continuous in u: it grows by π with every 2K(m) where m < 1, and swings between ± arcsin(1/√m) where m > 1.
    """

    letter, scipy_name, value = "am", "ellipj", staticmethod(many_digits.jacobi_am)

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        return 2 * sp.atan(sp.tanh(u / 2))

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, _m: sp.Expr) -> sp.Expr:
        return φ

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂/∂u = dn (DLMF 22.16.3); ∂/∂m from u = F(am|m), DLMF 19.4."""
        return self._slope(sp.S.One, argindex)


class JacobiSN(_Jacobi):
    """sn(u|m) = sin am(u|m), DLMF 22.2.4."""

    letter, scipy_name, value = "sn", "ellipj", staticmethod(many_digits.jacobi_sn)

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        return sp.tanh(u)

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, _m: sp.Expr) -> sp.Expr:
        return sp.sin(φ)

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂/∂u = cn dn, DLMF 22.13.1; ∂/∂m through the amplitude."""
        return self._slope(JacobiCN(*self.args), argindex)


class JacobiCN(_Jacobi):
    """cn(u|m) = cos am(u|m), DLMF 22.2.5."""

    letter, scipy_name, value, odd = "cn", "ellipj", staticmethod(many_digits.jacobi_cn), False

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        return sp.sech(u)

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, _m: sp.Expr) -> sp.Expr:
        return sp.cos(φ)

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂/∂u = −sn dn, DLMF 22.13.2; ∂/∂m through the amplitude."""
        return self._slope(-JacobiSN(*self.args), argindex)


class JacobiDN(_Jacobi):
    """dn(u|m) = ∂am/∂u, the root √(1 − m sn²) that is 1 at u = 0, DLMF 22.2.6."""

    letter, scipy_name, value, odd = "dn", "ellipj", staticmethod(many_digits.jacobi_dn), False

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        return sp.sech(u)

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, m: sp.Expr) -> sp.Expr:
        return sp.sqrt(1 - m * sp.sin(φ) ** 2)

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂/∂u = −m sn cn, DLMF 22.13.3; ∂/∂m from dn² = 1 − m sn²."""
        u, m = self.args
        s, c = JacobiSN(u, m), JacobiCN(u, m)
        if argindex == 1:
            return -m * s * c
        if argindex == 2:
            return -s * (s / self + 2 * m * c * _scaled_slope(u, m)) / 2
        raise ArgumentIndexError(self, argindex)


class JacobiEpsilon(_Jacobi):
    """ℰ(u|m) = ∫₀ᵘ dn²(v|m) dv, which is E(am(u|m)|m) for m < 1; for real u and m (DLMF 22.16.14, 22.16.31)."""

    letter, value = "epsilon", staticmethod(many_digits.jacobi_epsilon)

    @classmethod
    def _hyperbolic(cls, u: sp.Expr) -> sp.Expr:
        return sp.tanh(u)

    @classmethod
    def _of_amplitude(cls, φ: sp.Expr, m: sp.Expr) -> sp.Expr:
        return sp.elliptic_e(φ, m)

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """∂/∂u = dn², DLMF 22.16.15; ∂/∂m from ℰ = E(am|m), DLMF 19.4.6."""
        u, m = self.args
        if argindex == 1:
            return JacobiDN(u, m) ** 2
        if argindex == 2:
            return (self - u) / (2 * m) + JacobiDN(u, m) ** 2 * _scaled_slope(u, m)
        raise ArgumentIndexError(self, argindex)


def _amplitude_by_parameter(u: sp.Expr, m: sp.Expr) -> sp.Expr:
    """∂am/∂m = −dn · ∂F(φ|m)/∂m at φ = am, DLMF 19.4.5 and 22.16."""
    return JacobiDN(u, m) * _scaled_slope(u, m)


def _scaled_slope(u: sp.Expr, m: sp.Expr) -> sp.Expr:
    """−∂F(φ|m)/∂m at φ = am(u|m): [u − (ℰ(u|m) − m sn cn/dn)/(1 − m)]/(2m), for m > 1 on every swing."""
    second = JacobiEpsilon(u, m) - m * JacobiSN(u, m) * JacobiCN(u, m) / JacobiDN(u, m)
    return (u - second / (1 - m)) / (2 * m)
