"""One coordinate's integrals in one regime: antiderivatives, values over a cycle, and the conditions they rest on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.elementary import Antiderivative, antiderivative, root
from hjsolve.closed_form.fractions import NoFormError, fractions
from hjsolve.closed_form.regions import RootInterval, region_of
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.signs import Signs


@dataclass(frozen=True)
class PieceIntegral:
    """∫ N dq/√P², one of the integrals of a coordinate.

    Attributes:
        numerator: N(q).
        value: the antiderivative as a function of q.
        cycle: over a full cycle; None where the motion has none, or where there is no form of it.
        rational: R(x) of ∫ R dx/√P.
        law: the elementary antiderivative in x; None of an elliptic one.
        curve: the curve it was found on.
    """

    numerator: sp.Expr
    value: sp.Expr
    cycle: sp.Expr | None
    rational: sp.Expr
    law: Antiderivative | None
    curve: MomentumCurve


@dataclass(frozen=True)
class CoordinateIntegrals:
    """A coordinate in a regime.

    Attributes:
        name: of the coordinate.
        sample: the motion it was found with.
        region: where the motion is on the x-axis of the first curve.
        regions: all curves used, with the region on each.
        numerators: W or a constant → N(q), none zero.
        conditions: expression in the constants → its sign.
        integrals: W or a constant → its integral; no key where the coordinate does not contribute.
        roots: the real roots of P of the first curve, ascending; None where they have no names.
        why_not: W or a constant → why there is no form.
        where: named symbol → what it is.
    """

    name: str
    sample: Sample
    region: RootInterval
    regions: tuple[tuple[MomentumCurve, RootInterval], ...]
    numerators: Mapping[sp.Symbol, sp.Expr]
    conditions: Mapping[sp.Expr, int]
    integrals: Mapping[sp.Symbol, PieceIntegral]
    roots: tuple[sp.Expr, ...] | None
    why_not: Mapping[sp.Symbol, str]
    where: Mapping[sp.Symbol, object] = field(default_factory=dict)


def piece(
    name: str, numerators: Mapping[sp.Symbol, sp.Expr], found: list[MomentumCurve], sample: Sample
) -> CoordinateIntegrals | None:  # fmt: skip
    """Integrate a coordinate in the regime of a sample.

    Args:
        name: of the coordinate.
        numerators: W or a constant → N(q), none that is zero.
        found: its curves, the simplest first, in the stratum of the sample.
        sample: a motion.

    Returns:
        The piece; None where the motion is at rest or asymptotic in this coordinate.
    """
    integrals, why_not, regions = dict[sp.Symbol, PieceIntegral](), dict[sp.Symbol, str](), []
    conditions, first = dict[sp.Expr, int](), None
    for curve in found:
        missing = [key for key in numerators if key not in integrals]
        if not missing:
            break
        region = region_of(curve, sample)
        if region is None or not region.whole:
            continue
        first = first or region
        signs = Signs(sample.values, region.place)
        used = False
        for key in missing:
            try:
                integrals[key] = _integral(curve, region, key, numerators[key], signs)
                used = True
            except NoFormError as error:
                why_not.setdefault(key, str(error))
        if used:
            regions.append((curve, region))
            conditions |= signs.decided | region.conditions(signs)
    if first is None:
        return None
    return CoordinateIntegrals(
        name, sample, first, tuple(regions), numerators, conditions, integrals,
        _roots(regions[0][0], Signs(sample.values, first.place)) if regions else None,
        {key: reason for key, reason in why_not.items() if key not in integrals},
    )  # fmt: skip


def _integral(
    curve: MomentumCurve, region: RootInterval, key: sp.Symbol, numerator: sp.Expr, signs: Signs
) -> PieceIntegral:
    """∫ N dq/√P² = ε ∫ N dx/(S √P)."""
    if curve.degree > 2:
        raise NoFormError(
            f"y² = P({curve.substitution.place}) has degree {curve.degree}: no closed form in elementary functions"
        )
    s, x = curve.substitution, curve.x
    R = region.orientation(signs) * curve.numerator(key) / curve.square
    law = antiderivative(
        fractions(R, x), curve.polynomial, signs, lambda r: 1 if region.place > signs.number(r) else -1
    )
    cycle = None
    if region.kind == "libration":
        whole = law.complete()
        cycle = None if whole is None else 2 * whole
        if cycle is not None and not s.increasing:
            cycle = -cycle
    return PieceIntegral(numerator, law.written(s.place), cycle, R, law, curve)


def _roots(curve: MomentumCurve, signs: Signs) -> tuple[sp.Expr, ...] | None:
    """The real roots of P, deg P ≤ 2, ascending."""
    if curve.degree > 2:
        return None
    C, B, A = (curve.polynomial.coeff_monomial(curve.x**k) for k in range(3))
    if A == 0:
        return (sp.factor(sp.cancel(-C / B)),) if B != 0 else ()
    D = sp.factor_terms(sp.expand(B**2 / 4 - A * C))
    if signs.sign(D) < 0:
        return ()
    order = (-1, 1) if signs.sign(A) > 0 else (1, -1)
    return tuple((-B / 2 + side * root(D)) / A for side in order)
