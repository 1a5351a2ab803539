"""Values of the elliptic functions to any number of digits, by mpmath, and what mpmath has no function for.

Real formulas for real arguments; a value is worked out at two precisions and given where they agree.

Of the functions of Jacobi u is the argument and m the parameter, the square of the modulus.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import TypeVar

import mpmath
import sympy as sp

from hjsolve.precision import for_any_context, mp

R = TypeVar("R")
"""What a function has as its values."""

_GUARD = 24
_DOUBLINGS = 6
_REMEMBERED = 512
"""How many values are kept: sympy asks for those of one sum over and over while it looks for cancellation."""


def remembered(function: Callable[..., R]) -> Callable[..., R]:
    """Return a function of mpmath's numbers that keeps its last values, each with the precision it was worked out at.

    Args:
        function: of numbers and of mpmath's present precision, and of nothing else.
    """

    @lru_cache(_REMEMBERED, typed=True)
    def at(_bits: int, *numbers: mpmath.mpf) -> R:
        return function(*numbers)

    @wraps(function)
    def now(*numbers: mpmath.mpf) -> R:
        return at(mp.prec, *numbers)

    return now


@lru_cache(_REMEMBERED)
def evaluated(value: Callable[..., mpmath.mpf], arguments: tuple[sp.Expr, ...], bits: int) -> sp.Expr | None:
    """Return the value of a function at numbers, right to a number of bits.

    The working precision is doubled until two values agree: an argument of 10⁹ periods costs digits, and so does a
    place near a zero. Floats among the arguments are taken as the exact binary numbers they are.

    Args:
        value: the function, of mpmath's numbers at mpmath's present precision; ``ValueError`` outside its domain.
        arguments: sympy numbers.
        bits: of the value.

    Returns:
        A Float (or a complex sum of two), or None where an argument is not a number, lies outside the domain of the
        function, or no digits could be computed (a zero that is not exact).
    """
    working, former = bits + _GUARD, None
    for _ in range(_DOUBLINGS):
        numbers = [_number(argument, working) for argument in arguments]
        if any(number is None for number in numbers):
            return None
        with mp.workprec(working):
            try:
                present = mp.convert(value(*numbers))
            except (ValueError, ZeroDivisionError):
                return None
            if not mp.isfinite(present):
                return None
            if former is not None and abs(present - former) <= abs(present) * mp.mpf(2) ** (-bits - 4):
                return _float(present, bits)
        former, working = present, 2 * working
    return None


@lru_cache(_REMEMBERED)
def _number(argument: sp.Expr, bits: int) -> mpmath.mpf | mpmath.mpc | None:
    """Return a sympy number as one of mpmath's, with so many bits."""
    if not argument.is_number:
        return None
    real, imaginary = argument.evalf(int(bits / 3.32) + 2).as_real_imag()
    if not (real.is_Rational or real.is_Float) or not (imaginary.is_Rational or imaginary.is_Float):
        return None
    with mp.workprec(bits):
        parts = [mp.mpf(int(p.p)) / int(p.q) if p.is_Rational else mp.make_mpf(p._mpf_) for p in (real, imaginary)]
        return mp.mpc(*parts) if parts[1] else parts[0]


def _float(value: mpmath.mpf | mpmath.mpc, bits: int) -> sp.Expr:
    parts = [sp.Float._new(part._mpf_, bits) for part in (mp.re(value), mp.im(value))]
    return parts[0] + sp.I * parts[1] if isinstance(value, mp.mpc) and parts[1] != 0 else parts[0]


# ------------------------------------------------------------------------------------------------ Carlson's integrals
@for_any_context
def carlson_rf(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf) -> mpmath.mpf:
    """R_F(x, y, z), DLMF 19.16.1.

    Args:
        x, y, z: none of them negative, at most one of them zero.

    Raises:
        ValueError: an argument is on the negative axis.
    """
    _refuse_negative(x, y, z)
    return mp.elliprf(x, y, z)


@for_any_context
def carlson_rc(x: mpmath.mpf, y: mpmath.mpf) -> mpmath.mpf:
    """R_C(x, y), DLMF 19.16.6; Cauchy's principal value where y < 0, 19.6.15.

    Args:
        x: not negative.
        y: not zero.

    Raises:
        ValueError: x is on the negative axis.
    """
    _refuse_negative(x)
    return mp.elliprc(x, y)


@for_any_context
def carlson_rd(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf) -> mpmath.mpf:
    """R_D(x, y, z) = R_J(x, y, z, z), DLMF 19.16.5.

    Args:
        x, y: not negative, at most one of them zero.
        z: positive.

    Raises:
        ValueError: an argument is on the negative axis.
    """
    _refuse_negative(x, y, z)
    return mp.elliprd(x, y, z)


@for_any_context
def carlson_rj(x: mpmath.mpf, y: mpmath.mpf, z: mpmath.mpf, p: mpmath.mpf) -> mpmath.mpf:
    """R_J(x, y, z, p), DLMF 19.16.2; Cauchy's principal value where p < 0, 19.20.14 with the middle one for z.

    Args:
        x, y, z: none of them negative, at most one of them zero.
        p: not zero.

    Raises:
        ValueError: x, y or z is on the negative axis, or p is and they are not all real.
    """
    _refuse_negative(x, y, z)
    if mp.im(p) != 0 or mp.re(p) >= 0:
        return mp.elliprj(x, y, z, p)
    if any(mp.im(argument) != 0 for argument in (x, y, z)):
        raise ValueError("a principal value of complex arguments")
    x, y, z = sorted((x, y, z))
    q = -p
    p = (y * (x + z + q) - x * z) / (y + q)
    first = (p - y) * mp.elliprj(x, y, z, p) - 3 * mp.elliprf(x, y, z)
    return (first + 3 * mp.sqrt(x * y * z / (x * z + p * q)) * mp.elliprc(x * z + p * q, p * q)) / (y + q)


@for_any_context
def legendre_e(*arguments: mpmath.mpf) -> mpmath.mpf:
    """E(m), or E(φ, m), of the parameter m = k², DLMF 19.2.5.

    mpmath's complete integral loses as many digits as 1 − m has zeros: next to a separatrix it is wrong by 10⁻⁴⁴ at 60
    digits. This one adds positive terms, E = k′²(R_D(0, k′², 1) + R_D(0, 1, k′²))/3, DLMF 19.25.1.
    """
    *φ, m = arguments
    complement = 1 - m
    if mp.im(m) != 0 or mp.re(complement) <= 0 or any(mp.im(angle) != 0 for angle in φ):
        return mp.ellipe(*arguments)
    # a complex number may be real: that of a product of two conjugate ones has no order
    complement, φ = mp.re(complement), [mp.re(angle) for angle in φ]
    if not φ:
        return complement * (mp.elliprd(0, complement, 1) + mp.elliprd(0, 1, complement)) / 3
    turns = mp.nint(φ[0] / mp.pi)
    rest = mp.ellipe(φ[0] - turns * mp.pi, m) if turns else mp.ellipe(φ[0], m)
    return 2 * turns * legendre_e(m) + rest if turns else rest


@for_any_context
def legendre_pi(*arguments: mpmath.mpf) -> mpmath.mpf:
    """Π(n; φ|m) or Π(n|m); nan beyond the pole and of complex arguments, where mpmath integrates numerically.

    In hundreds of digits that takes minutes, and a case of a form that is not taken may have such arguments.
    """
    n, *rest = (mp.re(x) if mp.im(x) == 0 else mp.nan for x in arguments)
    if any(mp.isnan(x) for x in (n, *rest)):
        return mp.nan
    # beyond the pole, 1 − n sin² φ ≤ 0, it is a principal value (DLMF 19.2.7), which mpmath does not have
    sine = mp.sin(rest[0]) if len(rest) == 2 else mp.mpf(1)
    return mp.ellippi(n, *rest) if n * sine**2 < 1 else mp.nan


def _refuse_negative(*arguments: mpmath.mpf) -> None:
    if any(mp.im(argument) == 0 and mp.re(argument) < 0 for argument in arguments):
        raise ValueError("an argument on the negative axis")


# ------------------------------------------------------------------------------------------------ Jacobi's functions
@for_any_context
def jacobi_am(u: mpmath.mpf, m: mpmath.mpf) -> mpmath.mpf:
    """Jacobi's amplitude for real u and m: odd and continuous in u, with derivative dn(u|m).

    For m > 1 it swings between ± arcsin(1/√m); for m < 1 it grows by π with every 2K(m).

    Raises:
        ValueError: u or m is not real.
    """
    return _jacobi(u, m)[0]


@for_any_context
def jacobi_sn(u: mpmath.mpf, m: mpmath.mpf) -> mpmath.mpf:
    """Give Jacobi's sn(u|m), by real formulas where u and m are real."""
    return _jacobi(u, m)[1] if _real(u, m) else mp.ellipfun("sn", u, m=m)


@for_any_context
def jacobi_cn(u: mpmath.mpf, m: mpmath.mpf) -> mpmath.mpf:
    """Give Jacobi's cn(u|m), by real formulas where u and m are real."""
    return _jacobi(u, m)[2] if _real(u, m) else mp.ellipfun("cn", u, m=m)


@for_any_context
def jacobi_dn(u: mpmath.mpf, m: mpmath.mpf) -> mpmath.mpf:
    """Give Jacobi's dn(u|m), by real formulas where u and m are real."""
    return _jacobi(u, m)[3] if _real(u, m) else mp.ellipfun("dn", u, m=m)


@for_any_context
def jacobi_epsilon(u: mpmath.mpf, m: mpmath.mpf) -> mpmath.mpf:
    """Jacobi's ℰ(u|m) = ∫₀ᵘ dn²(v|m) dv for real u and m, DLMF 22.16.14.

    Raises:
        ValueError: u or m is not real.
    """
    return _jacobi(u, m)[4]


def _real(u: mpmath.mpf, m: mpmath.mpf) -> bool:
    return mp.im(u) == 0 and mp.im(m) == 0


@remembered
def _jacobi(u: mpmath.mpf, m: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
    """am, sn, cn, dn, ℰ; parameters beyond 0 … 1 by DLMF 22.17.2–22.17.8."""
    if not _real(u, m):
        raise ValueError("the amplitude of complex arguments")
    u, m = mp.mpf(mp.re(u)), mp.mpf(mp.re(m))
    if m > 1:
        k = mp.sqrt(m)
        _, s, c, d, ε = _between(k * u, 1 / m)
        return mp.asin(s / k), s / k, d, c, k * ε - (m - 1) * u
    if m < 0:
        k = mp.sqrt(1 - m)
        ψ, s, c, d, ε = _between(k * u, m / (m - 1))
        φ = ψ + mp.atan(s * c * (1 / k - 1) / (s * s / k + c * c))
        return φ, s / (k * d), c / d, 1 / d, k * (ε + m / (1 - m) * s * c / d)
    return _between(u, m)


def _between(u: mpmath.mpf, m: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
    """am, sn, cn, dn, ℰ for 0 ≤ m ≤ 1: descending means, DLMF 22.20(ii), 19.8(i), Abramowitz & Stegun 17.6.10."""
    if m == 1:
        return 2 * mp.atan(mp.tanh(u / 2)), mp.tanh(u), mp.sech(u), mp.sech(u), mp.tanh(u)
    a, b, steps, squares = mp.one, mp.sqrt(1 - m), [], m / 2
    while abs(a - b) > a * mp.eps:
        a, b, c = (a + b) / 2, mp.sqrt(a * b), (a - b) / 2
        steps.append((c, c / a))
        squares += 2 ** (len(steps) - 1) * c * c
    φ, ε = a * u * 2 ** len(steps), (1 - squares) * u
    for c, quotient in reversed(steps):
        ε += c * mp.sin(φ)
        φ = (φ + mp.asin(quotient * mp.sin(φ))) / 2
    s, c = mp.sin(φ), mp.cos(φ)
    return φ, s, c, mp.sqrt(1 - m + m * c * c), ε
