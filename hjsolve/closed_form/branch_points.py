"""The roots of P, deg P = 3 or 4, by name: rational or in radicals where they are, else as ordered real roots of P."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve, named_constants
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pairs_by_division import remaining_pair
from hjsolve.closed_form.regions import RootInterval, ordered_real_roots
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.tidy import shortened_powers
from hjsolve.precision import mp

LONGEST_ROOT = 24
"""Operations above which a root in radicals gets a name."""


@dataclass(frozen=True)
class NamedRoots:
    """The roots of P as expressions, in order at the sample.

    Attributes:
        leading: the leading coefficient of P.
        real: ascending.
        pairs: real and imaginary part of each complex pair, the latter positive.
        where: symbol → (P, index of the real root), of those without radicals.
        interval: indices of the real roots around the motion; None where there is none on that side.
        polynomial: P.
    """

    leading: sp.Expr
    real: tuple[sp.Expr, ...]
    pairs: tuple[tuple[sp.Expr, sp.Expr], ...]
    where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
    interval: tuple[int | None, int | None]
    polynomial: sp.Poly


def named_roots(curve: MomentumCurve, region: RootInterval, signs: Signs, prefix: str) -> NamedRoots:
    """Name the roots of P.

    Args:
        curve: of degree 3 or 4.
        region: where the motion is.
        signs: of the sample.
        prefix: of new names.

    Raises:
        NoFormError: the roots in radicals could not be separated.
    """
    P, x = curve.polynomial, curve.x
    found, pairs, left = _radicals(curve, signs)
    where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]] = {}
    # an irreducible cubic or quartic has no radicals that anybody reads (Cardano): its roots are named by their order
    if left is not None:
        symbols = _by_numbers(left, found, signs, prefix)
        where |= {symbol: (left, k) for k, symbol in enumerate(symbols)}
        found = [*found, *symbols]
        pairs += remaining_pair(left, symbols) if symbols else _two_pairs(left, signs, prefix, where)
    # in order at the sample: within a regime roots neither meet nor change places
    real = tuple(sorted(found, key=lambda e: mp.mpf(signs.number(e))))
    # x₁ for √(a + √(a² + 4Eb))/√b of the double well: moduli and periods hold each root many times
    if left is None and any(sp.count_ops(r) > LONGEST_ROOT or _nested(r) for r in real):
        real, where = _by_names(real, signs, prefix)
        pairs = tuple((re, _part_by_name(im, signs, prefix, where) if re == 0 else im) for re, im in pairs)
    # a wrong sign of a discriminant would show here: numbers of the roots were found without radicals
    if len(real) != len(region.roots) or len(real) + 2 * len(pairs) != P.degree():
        raise NoFormError(f"the roots of {P.as_expr()} in {x} could not be separated")
    with mp.workdps(30):
        below = [k for k, r in enumerate(region.roots) if r < region.place]
        above = [k for k, r in enumerate(region.roots) if r > region.place]
    ends = (below[-1] if below else None, above[0] if above else None)
    return NamedRoots(P.LC(), real, pairs, where, ends, P)


def _by_numbers(left: sp.Poly, found: list[sp.Expr], signs: Signs, prefix: str) -> list[sp.Symbol]:
    """Names for the real roots of a factor without radicals, numbered among all real roots of P.

    Args:
        left: the factor.
        found: the other real roots of P.
        signs: of the sample.
        prefix: of the names.
    """
    values = ordered_real_roots(left, signs.numbers, 50)
    places = sorted([*values, *(mp.mpf(signs.number(r)) for r in found)])
    symbols = [sp.Symbol(f"{prefix}_{places.index(value) + 1}", real=True) for value in values]
    signs.name({symbol: sp.Float(value, 50) for symbol, value in zip(symbols, values, strict=True)})
    return symbols


def _nested(root: sp.Expr) -> bool:
    """Return whether a root is a root of a sum with another root in it."""
    radicals = [p for p in root.atoms(sp.Pow) if p.exp.is_Rational and not p.exp.is_Integer]
    return any(inner.has(*radicals) for p in radicals for inner in (p.base,) if inner.is_Add)


def _by_names(
    real: tuple[sp.Expr, ...], signs: Signs, prefix: str
) -> tuple[tuple[sp.Expr, ...], dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]]:  # fmt: skip
    """Names for the roots with radicals, whose differences and ratios are not multiplied out; −x₁ has no new name."""
    where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]] = {}
    named = dict[sp.Expr, sp.Expr]()
    # of an even P the roots are ± x₁, ± x₂: half of the names are enough, and x₁² cancels between them
    opposite = {r for r in real if -r in real and signs.number(r) < 0}
    for root in real:
        if root in opposite:
            continue
        symbol = root if root.is_Rational else sp.Symbol(f"{prefix}_{len(where) + 1}", real=True)
        if symbol != root:
            if -root in opposite:
                symbol = sp.Symbol(symbol.name, positive=True)
            where[symbol] = root
            signs.name({symbol: sp.Float(signs.number(root), 50)})
        named[root] = symbol
    return tuple(-named[-r] if r in opposite else named[r] for r in real), where


def _part_by_name(
    im: sp.Expr, signs: Signs, prefix: str, where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
) -> sp.Expr:  # fmt: skip
    """Return a name for an imaginary part of a pair with real part zero."""
    if im.is_Symbol or im.is_number:
        return im
    symbol = sp.Symbol(f"{prefix}_im", positive=True)
    where[symbol] = im
    signs.name({symbol: sp.Float(signs.number(im), 50)})
    return symbol


def _two_pairs(
    P: sp.Poly, signs: Signs, prefix: str, where: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
) -> tuple[tuple[sp.Expr, sp.Expr], ...]:  # fmt: skip
    """Both complex pairs of a quartic, by Ferrari: y = x + b/4a, y⁴ + py² + qy + r = (y² + sy + t)(y² − sy + u).

    z = s² is a root of z³ + 2pz² + (p² − 4r)z − q², which for two complex pairs has three real roots, of which the
    greatest is the positive one: ± √z/2 are the real parts.
    """
    a, b, c, d, e = P.all_coeffs()
    b, c, d, e = (sp.cancel(k / a) for k in (b, c, d, e))
    # the depressed quartic y⁴ + p y² + q y + r, by Tschirnhaus's shift
    p, q = sp.factor(c - 3 * b**2 / 8), sp.factor(d - b * c / 2 + b**3 / 8)
    r = sp.factor(e - b * d / 4 + b**2 * c / 16 - 3 * b**4 / 256)
    # then z = 0 is a root of the resolvent, and q/s is 0/0
    if q == 0:
        raise NoFormError("P is even about the middle of its roots, and they have no names")
    symbol = sp.Symbol(f"{prefix}_z", positive=True)
    z = sp.Symbol(f"{prefix}_y", real=True)
    resolvent = sp.Poly(z**3 + 2 * p * z**2 + (p**2 - 4 * r) * z - q**2, z)
    where[symbol] = (resolvent, 2)
    values = ordered_real_roots(resolvent, signs.numbers, 50)
    if len(values) != 3 or not values[2] > 0:
        raise NoFormError("the complex roots of P could not be separated")
    signs.name({symbol: sp.Float(values[2], 50)})
    # y² ± s y + (z + p ∓ q/s)/2: real part ∓ s/2, imaginary part √(z/4 + p/2 ∓ q/(2s))
    s, found = sp.sqrt(symbol), list[tuple[sp.Expr, sp.Expr]]()
    for side in (-1, 1):
        found.append((side * s / 2 - b / 4, sp.sqrt(symbol / 4 + p / 2 + side * q / (2 * s))))
    return tuple(found)


def _radicals(
    curve: MomentumCurve, signs: Signs
) -> tuple[list[sp.Expr], tuple[tuple[sp.Expr, sp.Expr], ...], sp.Poly | None]:
    """Roots of factors of degree 1 and 2, x⁴ + p x² + q and x³ + p, real and in pairs; the factor of another kind."""
    x = curve.x
    bare, back = named_constants(curve.polynomial.as_expr(), x)
    real, pairs = list[sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
    left: sp.Poly | None = None
    for factor, _ in sp.factor_list(sp.numer(sp.together(bare)), x)[1]:
        coefficients = [c.xreplace(back) for c in sp.Poly(factor, x).all_coeffs()]
        match len(coefficients):
            case 2:
                real.append(sp.cancel(-coefficients[1] / coefficients[0]))
            case 3:
                _quadratic(coefficients, signs, real, pairs)
            # x³ = ratio: the real cube root, and its turns by ± 120°
            case 4 if coefficients[1] == 0 and coefficients[2] == 0:
                ratio = sp.factor(sp.cancel(-coefficients[3] / coefficients[0]))
                side = signs.sign(ratio)
                size = sp.cbrt(side * ratio)
                real.append(side * size)
                pairs.append((-side * size / 2, sp.sqrt(3) * size / 2))
            # biquadratic: roots of a quadratic in x², each positive one gives ± √, each negative one a pair on the axis
            case 5 if coefficients[1] == 0 and coefficients[3] == 0:
                squares, complex_squares = list[sp.Expr](), list[tuple[sp.Expr, sp.Expr]]()
                _quadratic(coefficients[::2], signs, squares, complex_squares)
                for square in squares:
                    if signs.sign(square) > 0:
                        real += [-sp.sqrt(square), sp.sqrt(square)]
                    else:
                        pairs.append((sp.S.Zero, sp.sqrt(-square)))
                for re, im in complex_squares:
                    # √(re + i im) = √((|z| + re)/2) + i √((|z| − re)/2)
                    size = sp.sqrt(re**2 + im**2)
                    part = (sp.sqrt((size + re) / 2), sp.sqrt((size - re) / 2))
                    pairs += [part, (-part[0], part[1])]
            case _:
                left = sp.Poly(factor.xreplace(back), x)
    return [shortened_powers(r) for r in real], tuple(pairs), left


def _quadratic(
    coefficients: list[sp.Expr], signs: Signs, real: list[sp.Expr], pairs: list[tuple[sp.Expr, sp.Expr]]
) -> None:  # fmt: skip
    a, b, c = coefficients
    D = sp.factor(b**2 / 4 - a * c)
    if signs.sign(D) > 0:
        ratio = sp.factor(sp.cancel(-c / a))
        sides = (-1, 1)
        # without b the root of c/a is shorter, and has no a to cancel
        real += [s * sp.sqrt(ratio) for s in sides] if b == 0 else [(-b / 2 + s * sp.sqrt(D)) / a for s in sides]
    else:
        size = a if signs.sign(a) > 0 else -a
        pairs.append((sp.cancel(-b / (2 * a)), sp.sqrt(-D) / size))
