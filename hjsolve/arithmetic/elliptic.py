"""Jacobi's elliptic functions in terms of the complementary parameter, for any plain arithmetic.

Bulirsch's descending Landen transformation (Numer. Math. 7 (1965) 78): the complementary parameter
k′² is carried, so nothing is lost when k → 1. The quarter period is π/(2·AGM(1, k′)).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import cast, overload

import numpy as np

from hjsolve.arithmetic.floats import ComplexPoints, Float64, Multi
from hjsolve.arithmetic.number_types import Complexes, Elementwise, Mpf, N, Numeric, Reals
from hjsolve.arithmetic.tape import Arithmetic
from hjsolve.errors import InternalError

_MOST_MEANS = 4096
"""Of two positive numbers: they are halved towards each other in powers of two, then squared."""


@overload
def quarter_period(complement: float, arithmetic: Float64) -> float: ...
@overload
def quarter_period(complement: Mpf, arithmetic: Multi) -> Mpf: ...
def quarter_period(complement: float | Mpf, arithmetic: Float64 | Multi) -> Numeric:
    """Return K for the complementary parameter k′², 0 < k′² ≤ 1.

    Args:
        complement: k′² = 1 − k².
        arithmetic: in which K is worked out.
    """
    return arithmetic.pi() / (2 * _means(complement, arithmetic)[-1][0])


@lru_cache(maxsize=64)
def _means(complement: float | Mpf, arithmetic: Float64 | Multi) -> list[tuple[Numeric, Numeric]]:
    """Return the means from (1, k′), kept from one argument to the next."""
    one, bits = arithmetic.rational(1, 1), arithmetic.bits

    def equal(a: Numeric, b: Numeric) -> bool:
        if bits < 900:
            return bool(abs(a - b) <= a * 2.0 ** (-(bits // 2) - 2))
        # no double is as small as 2^−bits/2 here, so the squares are compared
        return bool(abs(a - b) ** 2 <= a * a * arithmetic.power(arithmetic.rational(1, 2), bits + 4))

    return means((one, arithmetic.unary("sqrt", complement)), equal, arithmetic)


def means(start: tuple[N, N], equal: Callable[[N, N], bool], arithmetic: Arithmetic[N]) -> list[tuple[N, N]]:
    """Return arithmetic and geometric means in turn, to twice the digits to which the last but one are equal.

    Args:
        start: two positive numbers.
        equal: whether two means agree to half of the digits.

    Raises:
        InternalError: they do not meet; they are not positive.
    """
    half, pairs = arithmetic.rational(1, 2), [start]
    while not equal(*pairs[-1]):
        a, b = pairs[-1]
        if len(pairs) > _MOST_MEANS:
            raise InternalError(f"the arithmetic-geometric mean of {start[0]} and {start[1]} does not converge")
        pairs.append((arithmetic.mul(half, arithmetic.add(a, b)), arithmetic.unary("sqrt", arithmetic.mul(a, b))))
    return [*pairs, (arithmetic.mul(half, arithmetic.add(*pairs[-1])), pairs[-1][1])]


def descended(u: N, pairs: list[tuple[N, N]], arithmetic: Arithmetic[N]) -> tuple[N, N, N]:
    """Return sn, cn, dn for 0 < u ≤ K/2, where cn/sn is carried: it loses nothing for small u.

    Args:
        u: argument.
        pairs: means from (1, k′), see ``means``.
    """
    mul, div, add, one = arithmetic.mul, arithmetic.div, arithmetic.add, arithmetic.rational(1, 1)
    dn, angle = one, mul(pairs[-1][0], u)
    a = div(arithmetic.unary("cos", angle), arithmetic.unary("sin", angle))
    c = mul(pairs[-1][0], a)
    for high, low in reversed(pairs[:-1]):
        a, c = mul(c, a), mul(c, dn)
        dn = div(add(low, a), add(high, a))
        a = div(c, high)
    sn = div(one, arithmetic.unary("sqrt", add(mul(c, c), one)))
    return sn, mul(c, sn), dn


@overload
def jacobi(u: Reals, complement: float, quarter: float, arithmetic: Float64) -> tuple[Reals, Reals, Reals]: ...
@overload
def jacobi(
    u: Numeric, complement: float | Mpf, quarter: float | Mpf, arithmetic: Float64 | Multi
) -> tuple[Numeric, Numeric, Numeric]: ...
def jacobi(
    u: Elementwise, complement: Elementwise, quarter: Elementwise, arithmetic: Float64 | Multi
) -> tuple[Numeric, Numeric, Numeric]:
    """Return sn u, cn u, dn u for −2K ≤ u ≤ 2K (or just beyond), cn with full relative accuracy near its zeros ±K.

    Args:
        u: argument; scalar, or array for ``Float64``, of complex numbers for ``ComplexPoints``.
        complement: k′² = 1 − k².
        quarter: K, see ``quarter_period``.
    """
    if isinstance(arithmetic, ComplexPoints):
        return cast("tuple[Numeric, Numeric, Numeric]", jacobi_complex(u, complement, quarter))
    size = abs(u)
    reduced = size > quarter
    v = arithmetic.where(reduced, 2 * quarter - size, size)
    beyond, v = v < 0, abs(v)  # 2K rounded up
    far = v > quarter / 2
    v = arithmetic.where(far, quarter - v, v)
    unit = arithmetic.rational(1, 1)
    if complement == 1:
        sn, cn, dn = arithmetic.unary("sin", v), arithmetic.unary("cos", v), unit
    else:
        small = v <= 2.0 ** (-9 * arithmetic.bits)  # 1/v² may have no double; sn = v, cn = dn = 1 to the last digit
        found = descended(arithmetic.where(small, quarter / 2, v), _means(complement, arithmetic), arithmetic)
        sn, cn, dn = (arithmetic.where(small, *x) for x in zip((v, unit, unit), found, strict=True))
    k = arithmetic.unary("sqrt", complement)
    sn, cn, dn = (arithmetic.where(far, *x) for x in ((cn / dn, sn), (k * sn / dn, cn), (k / dn, dn)))
    sn = arithmetic.copysign(sn, u)
    return arithmetic.where(beyond, -sn, sn), arithmetic.where(reduced, -cn, cn), dn


def jacobi_complex(u: Complexes, complement: float, quarter: float) -> tuple[Complexes, Complexes, Complexes]:
    """Return sn, cn, dn of complex arguments, |Re u| ≤ 2K, by the addition theorem (DLMF 22.8.19-21).

    Args:
        u: complex array.
        complement: k′² = 1 − k².
        quarter: K, the quarter period.
    """
    if complement == 1.0:
        return np.sin(u), np.cos(u), np.ones_like(u)
    s, c, d = jacobi(np.real(u), complement, quarter, Float64())
    parameter = 1.0 - complement
    other = quarter_period(parameter, Float64())
    # 2iK′ is a period of sn²: no strip goes that far, and the clip keeps the arithmetic finite
    y = np.clip(np.imag(u), -1.999 * other, 1.999 * other)
    s1, c1, d1 = jacobi(y, parameter, other, Float64())
    # a sum of squares: it vanishes at the poles alone
    below = c1 * c1 + parameter * (s * s1) ** 2
    sn = (s * d1 + 1j * c * d * s1 * c1) / below
    cn = (c * c1 - 1j * s * d * s1 * d1) / below
    dn = (d * c1 * d1 - 1j * parameter * s * c * s1) / below
    return cast("Complexes", sn), cast("Complexes", cn), cast("Complexes", dn)
