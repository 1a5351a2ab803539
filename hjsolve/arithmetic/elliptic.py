"""Jacobi's elliptic functions in terms of the complementary parameter, for any plain arithmetic.

Bulirsch's descending Landen transformation (Numer. Math. 7 (1965) 78): the complementary parameter
k′² is carried, so nothing is lost when k → 1. The quarter period is π/(2·AGM(1, k′)).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, overload

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Mpf, Numeric, Reals


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
    means = _means(complement, arithmetic)
    return arithmetic.pi() / (2 * means[-1][0])


@lru_cache(maxsize=64)
def _means(complement: float | Mpf, arithmetic: Float64 | Multi) -> list[tuple[Numeric, Numeric]]:
    """Return the sequence of arithmetic and geometric means from (1, k′), kept from one argument to the next."""
    a: Numeric = arithmetic.rational(1, 1)
    b: Numeric = arithmetic.unary("sqrt", complement)
    pairs = [(a, b)]
    while (
        abs(a - b) > a * 2.0 ** (-(arithmetic.bits // 2) - 2)
        if arithmetic.bits < 900
        else abs(a - b) ** 2 > a * a * arithmetic.power(arithmetic.rational(1, 2), arithmetic.bits + 4)
    ):
        a, b = (a + b) / 2, arithmetic.unary("sqrt", a * b)
        pairs.append((a, b))
    pairs.append(((a + b) / 2, b))
    return pairs


@overload
def jacobi(u: Reals, complement: float, quarter: float, arithmetic: Float64) -> tuple[Reals, Reals, Reals]: ...
@overload
def jacobi(
    u: Numeric, complement: float | Mpf, quarter: float | Mpf, arithmetic: Float64 | Multi
) -> tuple[Numeric, Numeric, Numeric]: ...
def jacobi(
    u: Numeric, complement: float | Mpf, quarter: float | Mpf, arithmetic: Float64 | Multi
) -> tuple[Numeric, Numeric, Numeric]:
    """Return sn u, cn u, dn u for −2K ≤ u ≤ 2K (or just beyond), cn with full relative accuracy near its zeros ±K.

    Args:
        u: argument; scalar, or array for ``Float64``.
        complement: k′² = 1 − k².
        quarter: K, see ``quarter_period``.
        arithmetic: where to compute.
    """
    return arithmetic.choose(
        lambda doubles: _jacobi_array(np.asarray(u, dtype=float), float(complement), float(quarter), doubles),
        lambda many: _jacobi_number(u, complement, quarter, many),
    )


def _jacobi_number(
    u: Numeric, complement: float | Mpf, quarter: float | Mpf, arithmetic: Multi
) -> tuple[Numeric, Numeric, Numeric]:
    size = abs(u)
    folded = size > quarter
    v = 2 * quarter - size if folded else size
    beyond, v = v < 0, abs(v)  # 2K rounded up
    far = v > quarter / 2
    sn, cn, dn = _bulirsch(quarter - v if far else v, complement, arithmetic)
    if far:
        k = arithmetic.unary("sqrt", complement)
        sn, cn, dn = cn / dn, k * sn / dn, k / dn
    return (-sn if (u < 0) != beyond else sn), (-cn if folded else cn), dn


def _jacobi_array(u: Reals, complement: float, quarter: float, arithmetic: Float64) -> tuple[Reals, Reals, Reals]:
    size = np.abs(u)
    folded = size > quarter
    v = np.where(folded, 2 * quarter - size, size)
    beyond, v = v < 0, np.abs(v)
    far = v > quarter / 2
    sn, cn, dn = _bulirsch(np.where(far, quarter - v, v), complement, arithmetic)
    k = complement**0.5
    sn, cn, dn = np.where(far, cn / dn, sn), np.where(far, k * sn / dn, cn), np.where(far, k / dn, dn)
    return np.where(beyond, -1, 1) * np.copysign(sn, u), np.where(folded, -cn, cn), dn


def _bulirsch(u: Any, complement: float | Mpf, arithmetic: Float64 | Multi) -> tuple[Any, Any, Any]:
    """sn, cn, dn for 0 ≤ u ≤ K/2."""
    dn = 0 * u + 1
    if complement == 1:
        return arithmetic.unary("sin", u), arithmetic.unary("cos", u), dn
    pairs = _means(complement, arithmetic)
    c: Any = pairs[-1][0] * u
    sine: Any = arithmetic.unary("sin", c)
    cosine: Any = arithmetic.unary("cos", c)
    none, unit = sine == 0, dn
    with np.errstate(all="ignore"):
        a = cosine / arithmetic.where(none, unit, sine)
        c = pairs[-1][0] * a
        for high, low in reversed(pairs[:-1]):
            a = c * a
            c = c * dn
            dn = (low + a) / (high + a)
            a = c / high
        root: Any = arithmetic.unary("sqrt", c * c + 1)
        sn = 1 / root
        cn = c * sn
    return arithmetic.where(none, sine, sn), arithmetic.where(none, cosine, cn), arithmetic.where(none, unit, dn)
