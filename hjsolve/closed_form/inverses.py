"""q(t) and r(θ): Jacobi's equations solved for the coordinates, where each holds a single transcendental function."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.carlson import CarlsonMap, carlson_inverse
from hjsolve.closed_form.elementary import Antiderivative
from hjsolve.closed_form.even_curves import EvenMap, even_inverse
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral, monotone_inverse
from hjsolve.closed_form.real_branch_points import elliptic_inverse
from hjsolve.closed_form.tidy import multiplied_out, shortened_powers
from hjsolve.closed_form.time_limit import check_time
from hjsolve.closed_form.verification import monotone_span, sample_numbers, value_at
from hjsolve.closed_form.workshop import Stratum, Workshop
from hjsolve.functions import JacobiAM, JacobiCN, JacobiSN
from hjsolve.precision import mp

_DIGITS = 40


def inverse_forms(
    shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], special: Stratum, why_not: dict[str, str]
) -> dict[str, sp.Expr]:  # fmt: skip
    """q(t) of every coordinate that can be had.

    Each coordinate must have one independent integral τ, its others being multiples of it by constants: then Jacobi's
    equations are linear in the τ, and each τ(q) is inverted by itself.

    Args:
        shop: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        why_not: gets a reason for every coordinate without one.
    """
    solution, found = shop.solution, dict[str, sp.Expr]()
    try:
        values = _phases(shop, pieces, special)
    except NoFormError as error:
        return _refused(shop, why_not, str(error))
    for name, (integral, τ) in values.items():
        try:
            found[name] = inverted(pieces[name], integral, τ, solution.lower_limits[name])
        except NoFormError as error:
            why_not[f"inverse.{name}"] = str(error)
    for c in solution.separation.shell.ignorable:
        equation = solution.orbit_equations[c.momentum.name]
        if not solution.coordinates:
            found[c.name] = sp.expand(equation.lhs - (equation.rhs - c.symbol))
            continue
        try:
            moved = sp.Add(*(_multiple(pieces[n], c.momentum, i) * τ for n, (i, τ) in values.items()))
        except NoFormError:
            why_not[f"inverse.{c.name}"] = "its equation contains another integral than the time law"
            continue
        constant = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero) - c.symbol
        along = {solution.system.coordinate(n).symbol: found.get(n) for n in solution.coordinates}
        if any(constant.has(q) and place is None for q, place in along.items()):
            why_not[f"inverse.{c.name}"] = "the shift of the momenta enters its equation, and with it q(t) of another"
            continue
        constant = constant.xreplace({q: place for q, place in along.items() if place is not None})
        found[c.name] = shortened_powers(sp.expand(equation.lhs - constant.subs(dict(special)) - moved))
    return found


def _refused(shop: Workshop, why_not: dict[str, str], reason: str) -> dict[str, sp.Expr]:
    for c in shop.solution.system.coordinates:
        why_not[f"inverse.{c.name}"] = reason
    return {}


def _phases(
    shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], special: Stratum
) -> dict[str, tuple[PieceIntegral, sp.Expr]]:  # fmt: skip
    """Coordinate → its one integral, and what that is as a function of t and the β."""
    solution, names = shop.solution, list(shop.solution.coordinates)
    if not names:
        return {}
    ignorable = {c.momentum for c in solution.separation.shell.ignorable}
    inner = [c for c in solution.constants.values() if c.symbol not in ignorable]
    for name in names:
        if name not in pieces:
            raise NoFormError(f"{name} has no integral in closed form")
    references = {name: _reference(pieces[name], [c.symbol for c in inner]) for name in names}
    M = sp.Matrix([[_multiple(pieces[n], c.symbol, references[n]) for n in names] for c in inner])
    right = []
    for c in inner:
        equation = solution.time_law if c.symbol == shop.constants[0] else solution.orbit_equations[c.name]
        assert equation is not None
        rest = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
        right.append(equation.lhs - rest.subs(dict(special)))
    if any(r.free_symbols & {solution.system.coordinate(n).symbol for n in names} for r in right):
        raise NoFormError("the shift of the momenta enters the time law")
    solved = M.LUsolve(sp.Matrix(right)) if len(names) > 1 else sp.Matrix([right[0] / M[0, 0]])
    return {n: (references[n], sp.expand(sp.cancel(τ))) for n, τ in zip(names, solved, strict=True)}


def _reference(own: CoordinateIntegrals, inner: list[sp.Symbol]) -> PieceIntegral:
    """The integral of which all others of a coordinate are multiples: the first that there is."""
    for key in inner:
        if key in own.integrals:
            return own.integrals[key]
        if key in own.why_not:
            raise NoFormError(f"{own.name}: {own.why_not[key]}")
    raise NoFormError(f"{own.name} has no integral")


def _multiple(own: CoordinateIntegrals, key: sp.Symbol, reference: PieceIntegral) -> sp.Expr:
    """N/N_reference, a constant."""
    numerator = own.numerators.get(key, sp.S.Zero)
    ratio = sp.cancel(sp.together(numerator / reference.numerator))
    if ratio.has(reference.curve.coordinate.symbol):
        raise NoFormError(
            f"the time law and the orbit equations contain different integrals over {own.name}: "
            "they must be solved together"
        )
    return ratio


Numbers = Mapping[sp.Symbol, mpmath.mpf]


def inverted(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, others: Numbers | None = None
) -> sp.Expr:  # fmt: skip
    """The q at which an integral from a lower limit has a value.

    Args:
        own: the coordinate.
        integral: ∫ N dq/P.
        value: what it is to be.
        start: the lower limit, a symbol.
        others: numbers for other symbols of the value, to try the inverse with.

    Raises:
        NoFormError: it contains more than one function of q.
    """
    if integral.law is None:
        return _elliptic(own, integral, value, start, others)
    law, q = integral.law, integral.curve.coordinate.symbol
    s = integral.curve.substitution
    if not law.terms and law.algebraic != 0:
        return _algebraic(own, integral, value, start, others)
    if law.algebraic != 0 or len(law.terms) != 1:
        raise NoFormError(_why_not_inverted(own, law))
    weight, basic = law.terms[0]
    begin = basic.written(s.place.subs(q, start))
    x = basic.solved(sp.expand(value / weight) + begin)
    return verified_inverse(own, integral, shortened_powers(s.inverse.subs(s.x, x)), value, start, others)


def _elliptic(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, others: Numbers | None
) -> sp.Expr:  # fmt: skip
    """sn² of an integral of the first kind."""
    s, q = integral.curve.substitution, integral.curve.coordinate.symbol
    if integral.curve.degree > 4:
        raise NoFormError(f"t({own.name}) is an integral on a curve of genus 2: its inverse is not given")
    if integral.first is None or integral.way is None:
        raise NoFormError(f"t({own.name}) contains integrals of the second or third kind: they have no inverse")
    amount, begin = multiplied_out(value / integral.first), s.place.subs(q, start)
    way = integral.way
    match way:
        case EvenMap():
            x = even_inverse(way, amount, begin)
        case CarlsonMap():
            x = carlson_inverse(way, amount, begin)
        case _:
            x = elliptic_inverse(way, amount, begin)
    place = shortened_powers(s.inverse.subs(s.x, x))
    if own.kind == "rotation":  # asin(sn u) turns back after a quarter of a turn, am u goes on
        place = place.replace(
            lambda e: isinstance(e, sp.asin) and isinstance(e.args[0], JacobiSN), lambda e: JacobiAM(*e.args[0].args)
        ).replace(
            lambda e: isinstance(e, sp.asin) and isinstance(e.args[0], JacobiCN),
            lambda e: sp.pi / 2 - JacobiAM(*e.args[0].args),
        )
    return verified_inverse(own, integral, monotone_inverse(place), value, start, others)


def _algebraic(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, others: Numbers | None
) -> sp.Expr:  # fmt: skip
    """C √(Bx + C) = w: the uniformly accelerated motion."""
    law, s, q = integral.law, integral.curve.substitution, integral.curve.coordinate.symbol
    assert law is not None
    P = sp.Poly(law.polynomial, law.x)
    if P.degree() != 1 or law.algebraic.has(law.x):
        raise NoFormError(_why_not_inverted(own, law))
    B, C = P.all_coeffs()
    w = value / law.algebraic + sp.sqrt(law.polynomial).subs(law.x, s.place.subs(q, start))
    x = sp.expand((w**2 - C) / B)
    return verified_inverse(own, integral, shortened_powers(s.inverse.subs(s.x, x)), value, start, others)


def _why_not_inverted(own: CoordinateIntegrals, law: Antiderivative) -> str:
    kinds = [term.kind for _, term in law.terms]
    if law.algebraic != 0 and len(kinds) == 1 and own.kind in ("libration", "escape", "boundary"):
        what = {"arcsine": "Kepler's equation", "area cosine right": "Kepler's equation of the hyperbola"}.get(kinds[0])
        if what is not None:
            return f"t({own.name}) is {what}: {own.name}(t) has no closed form"
    if not kinds:
        return f"t({own.name}) is algebraic, of higher degree in the root"
    return f"t({own.name}) contains more than one transcendental function of {own.name}"


def verified_inverse(
    own: CoordinateIntegrals, integral: PieceIntegral, place: sp.Expr, value: sp.Expr, start: sp.Symbol,
    others: Numbers | None,
) -> sp.Expr:  # fmt: skip
    """An inverse, once it gives back a place from the integral there, to 40 digits.

    Args:
        own: the coordinate, with its sample.
        integral: ∫ N dq/P, verified.
        place: the inverse, q as a function of the value.
        value: what the integral from the lower limit is to be, an expression of t and β.
        start: the lower limit.
        others: numbers for other symbols of the value.

    Raises:
        NoFormError: it does not.
    """
    check_time()
    q = integral.curve.coordinate.symbol
    begin, stop = own.sample.places[own.name], _nearby(own, integral)
    with mp.workdps(_DIGITS + 20):
        numbers = {**sample_numbers(own), **(others or {})}
        free = sorted(value.free_symbols - set(numbers), key=str)
        numbers |= {s: mp.mpf(k + 2) / 7 for k, s in enumerate(free)}
        numbers[start], target = _fraction(begin), _fraction(stop)
        difference = value_at(integral.value, numbers | {q: target}) - value_at(
            integral.value, numbers | {q: numbers[start]}
        )
        unknown, offset = free[0], value_at(value, numbers)
        numbers[unknown] += (difference - offset) / value_at(sp.diff(value, unknown), numbers)
        got = value_at(place, numbers)
        if not abs(got - target) <= (abs(target) + mp.mpf(10) ** -5) * mp.mpf(10) ** -_DIGITS:
            raise NoFormError(f"not verified: the inverse gives {mp.nstr(got, 15)} for {mp.nstr(target, 15)}")
        if own.kind == "rotation" and integral.cycle is not None:
            numbers[unknown] += value_at(integral.cycle, numbers) / value_at(sp.diff(value, unknown), numbers)
            turned = mp.sin((value_at(place, numbers) - target) / 2)
            if not abs(turned) <= mp.mpf(10) ** -_DIGITS:
                raise NoFormError("the inverse that was found is right on one turn only")
    return place


def _nearby(own: CoordinateIntegrals, integral: PieceIntegral) -> sp.Expr:
    """Another place of the same region, on the same side of the turning points."""
    low, high = monotone_span(own, integral)
    return sp.Rational(str(mp.nstr(low + (high - low) * mp.mpf("0.64"), 15)))


def orbit_formulas(shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], special: Stratum) -> dict[str, sp.Expr]:
    """A coordinate as a function of another one, from an orbit equation −β = ….

    That of an ignorable momentum, θ + ∫ ∂p/∂c dq, gives q(θ); that of a separation constant over two coordinates,
    ∫ ∂p₁/∂α dq₁ + ∫ ∂p₂/∂α dq₂, gives q₁(q₂), as for two centres.

    Args:
        shop: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
    """
    solution, found = shop.solution, dict[str, sp.Expr]()
    ignorable = {c.momentum for c in solution.separation.shell.ignorable}
    keys = [(name, solution.constants[name].symbol) for name in solution.orbit_equations]
    for name, key in sorted(keys, key=lambda pair: pair[1] not in ignorable):
        held = [n for n in solution.coordinates if n in pieces and key in pieces[n].numerators]
        wanted = 1 if key in ignorable else 2
        if key in special or len(held) != wanted or any(key not in pieces[n].integrals for n in held):
            continue
        for target in held:
            try:
                check_time()
                found.setdefault(target, _along(shop, pieces, name, key, target, held))
            except NoFormError:
                continue
    return found


def _along(
    shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], name: str, key: sp.Symbol, target: str, held: list[str]
) -> sp.Expr:  # fmt: skip
    """One coordinate from an orbit equation."""
    solution, own = shop.solution, pieces[target]
    equation = solution.orbit_equations[name]
    rest = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
    if rest.has(own.integrals[key].curve.coordinate.symbol):
        raise NoFormError("the shift of the momenta enters the orbit equation")
    value, numbers = multiplied_out(equation.lhs - rest), dict[sp.Symbol, mpmath.mpf]()
    for other in held:
        if other != target:
            more, along = pieces[other], pieces[other].integrals[key]
            q, start = along.curve.coordinate.symbol, solution.lower_limits[other]
            value -= along.value - along.value.xreplace({q: start})
            with mp.workdps(_DIGITS + 20):
                numbers |= sample_numbers(more)
                numbers |= {q: _fraction(_nearby(more, along)), start: _fraction(more.sample.places[other])}
    return inverted(own, own.integrals[key], value, solution.lower_limits[target], numbers)


def parametric_formulas(
    shop: Workshop, pieces: Mapping[str, CoordinateIntegrals], special: Stratum
) -> dict[str, sp.Expr]:  # fmt: skip
    """q₁(τ) and q₂(τ) from ∫ ∂p₁/∂α dq₁ + ∫ ∂p₂/∂α dq₂ = −β: dτ = ±∂p₁/∂α dq₁ = ∓∂p₂/∂α dq₂, growing with both.

    So the times of two centres and of Kerr's geodesics decouple (Greenwood (5-137); Mino, Phys. Rev. D 67, 084027).

    Args:
        shop: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
    """
    solution, names = shop.solution, list(shop.solution.coordinates)
    ignorable = {c.momentum for c in solution.separation.shell.ignorable}
    taken = {s.name for s in solution.characteristic_function.free_symbols}
    τ = sp.Symbol("tau" if "tau" not in taken else "tau_1", real=True)
    if len(names) != 2 or any(name not in pieces for name in names):
        return {}
    for constant in solution.orbit_equations:
        key, found = solution.constants[constant].symbol, dict[str, sp.Expr]()
        if key in ignorable or key in special or any(key not in pieces[n].integrals for n in names):
            continue
        for name in names:
            try:
                found[name] = _on_branch(pieces[name], key, τ, solution.lower_limits[name])
            except NoFormError:
                continue
        if found:
            return found
    return {}


def _on_branch(own: CoordinateIntegrals, key: sp.Symbol, τ: sp.Symbol, start: sp.Symbol) -> sp.Expr:
    """Q(τ) of a coordinate that grows with τ."""
    integral, numbers = own.integrals[key], sample_numbers(own)
    numerator = value_at(
        integral.numerator, numbers | {integral.curve.coordinate.symbol: _fraction(own.sample.places[own.name])}
    )
    return inverted(own, integral, τ if numerator > 0 else -τ, start)


def _fraction(value: sp.Expr) -> mpmath.mpf:
    return mp.mpf(int(value.p)) / int(value.q)
