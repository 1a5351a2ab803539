"""φ(t) of an ignorable coordinate: its equation along q(t), where t is an elliptic integral of the first kind.

With t = ∫ N dq/P a multiple of u = ∫ dφ/Δ, every other integral of the coordinate is a function of u as well, of
u, E(am u) and Π(ν, am u), smooth for all times: the spherical pendulum, Lagrange's top (Whittaker, Analytical dynamics,
§ 55, 72).
"""

from __future__ import annotations

import sympy as sp

from hjsolve.closed_form.elementary_motion import OTHER
from hjsolve.closed_form.elliptic_inverses import in_moduli, modulus
from hjsolve.closed_form.even_curves import EvenMap, even_integral
from hjsolve.closed_form.fractions import partial_fractions
from hjsolve.closed_form.named_quantities import NamedQuantities, Phase
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral, monotone_inverse
from hjsolve.closed_form.real_branch_points import LegendreIntegrals, LegendreMap, elliptic_integral
from hjsolve.closed_form.signs import Signs
from hjsolve.closed_form.verification import sample_numbers, value_along


def integral_in_time(
    own: CoordinateIntegrals, time: PieceIntegral, other: PieceIntegral, elapsed: sp.Expr, start: sp.Symbol,
    names: NamedQuantities,
) -> sp.Expr:  # fmt: skip
    """∫ N dq/P along a motion, as a function of the time, from t₀ on.

    Args:
        own: the coordinate.
        time: its integral in the time law.
        other: the integral that is wanted.
        elapsed: t − t₀.
        start: the lower limit.
        names: of the quantities of the forms.

    Raises:
        NoFormError: the time is no integral of the first kind, or the other has no form of this kind.
    """
    way = time.way
    if time.first is None or not isinstance(way, (LegendreMap, EvenMap)) or other.curve is not time.curve:
        raise NoFormError(OTHER)
    s, q = time.curve.substitution, time.curve.coordinate.symbol
    k = modulus(names, way.m)
    begin = s.place.subs(q, start)
    if isinstance(way, EvenMap):
        φ_0, Ω = way.amplitude(begin)[0], way.Ω
    else:
        φ_0 = sp.asin(sp.sqrt(names.oriented(sp.factor(way.s(begin)))))
        Ω = sp.sqrt(names.oriented(sp.factor(way.Ω**2)))
    F_0 = sp.elliptic_f(monotone_inverse(φ_0), k**2)
    u = Phase(names, elapsed / time.first, way.direction * Ω, F_0, even=False).argument
    t = next(term for term in elapsed.args if term.is_Symbol)
    u_0 = u.subs(t, t - elapsed)
    value = in_moduli(_up_to(own, other, way, u) - _up_to(own, other, way, u_0), names)
    value_along(own, (time, other), names.written_out(value), (t, start))
    return value


def _up_to(own: CoordinateIntegrals, other: PieceIntegral, way: LegendreMap | EvenMap, u: sp.Expr) -> sp.Expr:
    """The integral up to am u."""
    region = next(r for c, r in own.regions if c is other.curve)
    signs, x = Signs(own.sample.values, region.place), other.curve.x
    signs.name({s: sp.Float(v, 50) for s, v in sample_numbers(own).items() if s in own.where})
    integrals = LegendreIntegrals.along(u, way.m)
    if isinstance(way, EvenMap):
        return even_integral(other.rational, way, x, signs, complete=False, own=integrals)
    return elliptic_integral(partial_fractions(other.rational, x, signs), way, x, integrals)
