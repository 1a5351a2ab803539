"""q(t) and r(θ): Jacobi's equations solved for the coordinates, where each holds a single transcendental function."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.complex_poles import PairOfComplexPoles
from hjsolve.closed_form.elementary import Antiderivative, positive_root
from hjsolve.closed_form.elementary_inverses import (
    accelerated,
    cubic_inverse,
    elementary_inverse,
    power_inverse,
    separatrix_inverse,
    square_root_inverse,
)
from hjsolve.closed_form.elliptic_inverses import elliptic_inverse, going_round, root_of_square
from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.even_curves import in_square
from hjsolve.closed_form.form_context import FormContext, SpecialCase
from hjsolve.closed_form.jacobi_equations import common_parameter, integrated_over, time_of, without_integrals
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities, Phase
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral, monotone_inverse
from hjsolve.closed_form.square_curves import SquareCurve
from hjsolve.closed_form.tidy import elliptic, multiplied_out, shortened_powers
from hjsolve.closed_form.time_limit import check_time
from hjsolve.closed_form.verification import DIGITS, nearby, sample_numbers, sample_place, value_at
from hjsolve.closed_form.why_not import (
    Contains,
    IndependentIntegrals,
    NotFound,
    NotOfTheFirstKind,
    OfCoordinate,
    TranscendentalEquation,
    WhyNot,
)
from hjsolve.errors import required
from hjsolve.functions import JacobiCN
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.precision import mp


def inverse_forms(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], special: SpecialCase, why_not: dict[str, WhyNot],
    names: NamedQuantities,
) -> dict[str, sp.Expr]:  # fmt: skip
    """q(t) of every coordinate that can be computed.

    Each coordinate must have one independent integral τ, its others being multiples of it by constants: then Jacobi's
    equations are linear in the τ, and each τ(q) is inverted by itself.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        why_not: gets a reason for every coordinate without one.
        names: of the quantities of the forms.
    """
    solution, found = context.solution, dict[str, sp.Expr]()
    # Jacobi: ∂W/∂E = t − t₀, ∂W/∂α = −β: linear in the τ_j where each coordinate has one independent integral
    values = _values(context, pieces, special, why_not)
    for name, (integral, τ) in values.items():
        try:
            found[name] = inverted(pieces[name], integral, τ, solution.lower_limits[name], names)
        except NoFormError as error:
            why_not[f"inverse.{name}"] = error.why
    for c in solution.separation.shell.ignorable:
        equation = solution.orbit_equations[c.momentum.name]
        if not solution.coordinates:
            found[c.name] = _straight(sp.expand(equation.lhs - (equation.rhs - c.symbol)), context)
            continue
        without = [
            n
            for n in solution.coordinates
            if n not in values and (n not in pieces or c.momentum in pieces[n].numerators)
        ]
        if without:
            why_not.setdefault(
                f"inverse.{c.name}",
                Contains(f"{c.name}(t)", f"{without[0]}(t)", why_not.get(f"inverse.{without[0]}")),
            )
            continue
        try:
            moved = sp.Add(*(_multiple(pieces[n], c.momentum, i) * τ for n, (i, τ) in values.items()))
        except NoFormError as error:
            why_not[f"inverse.{c.name}"] = error.why
            continue
        constant = without_integrals(equation.rhs) - c.symbol
        along = {solution.system.coordinate(n).symbol: found.get(n) for n in solution.coordinates}
        if any(constant.has(q) and place is None for q, place in along.items()):
            why_not[f"inverse.{c.name}"] = NotFound("the shift of the momenta enters its equation")
            continue
        constant = constant.xreplace({q: place for q, place in along.items() if place is not None})
        place = equation.lhs - constant.subs(dict(special)) - moved
        found[c.name] = _in_time(place, c, context, names)
    for name in found:  # an angle that stays needs none of the integrals that could not be inverted
        why_not.pop(f"inverse.{name}", None)
    return found


def _in_time(place: sp.Expr, c: Coordinate, context: FormContext, names: NamedQuantities) -> sp.Expr:
    """Return a polynomial of the time; else φ_p + what has been added since t_p."""
    if not elliptic(place):
        straight = _straight(shortened_powers(sp.expand(place)), context)
        if all(straight.is_polynomial(t) for t in time_of(context.solution)):
            return straight
    terms = sp.Add(*(sp.expand_mul(term, deep=False) for term in sp.Add.make_args(place)))
    # φ_p is φ at the turning point: it collects what the lower limit and β have added
    constant, running = terms.as_independent(*time_of(context.solution), as_Add=True)
    return names.named(f"{c.name}_p", constant, short=3 * SHORT) + running


def _straight(place: sp.Expr, context: FormContext) -> sp.Expr:
    """Return a polynomial of the time in powers of t − t₀."""
    law = context.solution.time_law
    if law is None:
        return place
    (t,), s = time_of(context.solution), sp.Dummy("s")
    # s = t − t₀, so that x₀ + v₀ (t − t₀) + … is expanded about the start and not about t = 0
    moved = sp.expand(place.subs(t, s + t - law.lhs))
    if not moved.is_polynomial(s) or not moved.has(s):
        return place
    terms = sp.Poly(moved, s).terms()
    return sp.Add(*(sp.factor(sp.cancel(c)) * law.lhs**n if n else sp.expand(c) for (n,), c in terms))


def _values(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], special: SpecialCase, why_not: dict[str, WhyNot]
) -> dict[str, tuple[PieceIntegral, sp.Expr]]:  # fmt: skip
    """As ``_phases``; where the equations must be solved together, of the coordinate that is alone in the time law."""
    solution, key = context.solution, context.constants[0]
    try:
        return _phases(context, pieces, special)
    except NoFormError as error:
        reason = error.why
    for c in solution.system.coordinates:
        why_not[f"inverse.{c.name}"] = reason
    # of Kepler in space E stands over r alone: r(t) does not wait for the angles
    held = integrated_over(solution, pieces, key)
    if solution.time_law is None or len(held) != 1 or held[0] not in pieces or key not in pieces[held[0]].integrals:
        return {}
    rest = without_integrals(solution.time_law.rhs)
    if rest != 0:
        return {}
    (name,) = held
    for c in solution.system.coordinates:
        why_not[f"inverse.{c.name}"] = Contains(f"{c.name}(t)", f"{name}(t)", None)
    why_not.pop(f"inverse.{name}")
    return {name: (pieces[name].integrals[key], solution.time_law.lhs)}


def _phases(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], special: SpecialCase
) -> dict[str, tuple[PieceIntegral, sp.Expr]]:  # fmt: skip
    """Coordinate → its one integral, and what that is as a function of t and the β."""
    solution, names = context.solution, list(context.solution.coordinates)
    if not names:
        return {}
    ignorable = {c.momentum for c in solution.separation.shell.ignorable}
    inner = [c for c in solution.constants.values() if c.symbol not in ignorable]
    for name in names:
        if name not in pieces:
            raise NoFormError(OfCoordinate(name, context.why_no_integral(name)))
    references = {name: _reference(pieces[name], [c.symbol for c in inner]) for name in names}
    # Σ_j M_cj τ_j = right side of c; M is the Stäckel matrix where every column is a constant
    M = sp.Matrix([[_multiple(pieces[n], c.symbol, references[n]) for n in names] for c in inner])
    right = []
    for c in inner:
        equation = required(solution.time_law if c.symbol == context.constants[0] else solution.orbit_equations[c.name])
        rest = without_integrals(equation.rhs)
        right.append(equation.lhs - rest.subs(dict(special)))
    if any(r.free_symbols & {solution.system.coordinate(n).symbol for n in names} for r in right):
        raise NoFormError("the shift of the momenta enters the time law")
    solved = M.LUsolve(sp.Matrix(right)) if len(names) > 1 else sp.Matrix([right[0] / M[0, 0]])
    return {n: (references[n], sp.expand(sp.cancel(τ))) for n, τ in zip(names, solved, strict=True)}


def _reference(own: CoordinateIntegrals, inner: list[sp.Symbol]) -> PieceIntegral:
    """Return the integral of which all others of a coordinate are multiples: the first that there is."""
    for key in inner:
        if key in own.integrals:
            return own.integrals[key]
        if key in own.why_not:
            raise NoFormError(OfCoordinate(own.name, own.why_not[key]))
    raise NoFormError(f"{own.name} has no integral")


def _multiple(own: CoordinateIntegrals, key: sp.Symbol, reference: PieceIntegral) -> sp.Expr:
    """N/N_reference, a constant."""
    numerator = own.numerators.get(key, sp.S.Zero)
    # r² and 1 of Kepler's ∫ r dr/√P and ∫ dr/(r √P) are no multiples: t(r) and θ(r) are two functions
    ratio = sp.cancel(sp.together(numerator / reference.numerator))
    if ratio.has(reference.curve.coordinate.symbol):
        raise NoFormError(IndependentIntegrals(own.name, reference.curve.coordinate.symbol, ratio))
    return ratio


Numbers = Mapping[sp.Symbol, mpmath.mpf]


def inverted(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, names: NamedQuantities,
    others: Numbers | None = None,
) -> sp.Expr:  # fmt: skip
    """Return the q at which an integral from a lower limit has a value.

    Args:
        own: the coordinate.
        integral: ∫ N dq/P.
        value: what it is to be.
        start: the lower limit, a symbol.
        names: of the quantities of the forms.
        others: numbers for other symbols of the value, to try the inverse with.

    Raises:
        NoFormError: it contains more than one function of q.
    """
    if integral.law is None:
        return _elliptic(own, integral, value, start, names, others)
    law, q = integral.law, integral.curve.coordinate.symbol
    s = integral.curve.substitution
    if not law.terms and law.algebraic != 0:
        return _algebraic(own, integral, value, start, names, others)
    # of a separatrix tanh and sech, before the general logarithm
    x = separatrix_inverse(law, value, s.place.subs(q, start), names)
    if x is None and (law.algebraic != 0 or len(law.terms) != 1):
        raise NoFormError(_why_not_inverted(own, law))
    if x is None:
        weight, basic = law.terms[0]
        if isinstance(basic, PairOfComplexPoles):
            raise NoFormError(_why_not_inverted(own, law))
        x = elementary_inverse(basic, multiplied_out(value / weight, math.inf), s.place.subs(q, start), names)
    return verified_inverse(own, integral, s.q(x), value, start, names, others)


def _elliptic(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, names: NamedQuantities,
    others: Numbers | None,
) -> sp.Expr:  # fmt: skip
    """sn² of an integral of the first kind."""
    s, q = integral.curve.substitution, integral.curve.coordinate.symbol
    # R = 1: ∫ dx/√P(x²) = ½ ∫ dX/√(X P(X)) is of the first kind in X
    if integral.squared is not None and not integral.rational.has(integral.curve.x):
        x = _through_square(integral, integral.squared, value, start, names)
        return verified_inverse(own, integral, s.q(x), value, start, names, others)
    if integral.squared is not None:  # were x(t) elliptic, X(t) = x² would be
        X = integral.squared.X
        raise NoFormError(NotOfTheFirstKind(own.name, X, in_square(integral.rational, integral.curve.x, X)))
    if integral.curve.degree > 4:
        raise NoFormError(f"t({own.name}) is an integral on a curve of genus 2: its inverse is not given")
    # of second and third kind the inverse is not single-valued in the complex plane (Jacobi, Abel)
    if integral.first is None or integral.change is None:
        raise NoFormError(NotOfTheFirstKind(own.name, integral.curve.x, integral.rational))
    amount, begin = multiplied_out(value / integral.first), s.place.subs(q, start)
    x = elliptic_inverse(integral.change, amount, begin, names, lambda e: s.unwound(e, q, start))
    place = s.q(x)
    found, reason = [place], NoFormError("")
    if (
        own.kind == "rotation"
    ):  # asin(sn u) turns back after a quarter of a turn, am u goes on; cn u is even, am u is not
        found = [going_round(place, side) for side in ((1, -1) if place.has(JacobiCN) else (1,))]
    for one in found:
        try:
            return verified_inverse(own, integral, monotone_inverse(one), value, start, names, others)
        except NoFormError as error:
            reason = error
    raise reason


def _through_square(
    integral: PieceIntegral, squared: SquareCurve, value: sp.Expr, start: sp.Symbol, names: NamedQuantities
) -> sp.Expr:  # fmt: skip
    """Return x of ∫ R dx/√P(x²) = ± ½ R ∫ dX/√(X P(X)), R constant, by X = x²."""
    s, change = integral.curve.substitution, integral.change
    if change is None:
        raise NoFormError("the curve in the square is not elliptic")
    twice = 2 * squared.side / integral.rational
    amount, begin = multiplied_out(twice * value), s.place.subs(integral.curve.coordinate.symbol, start)
    if not squared.passes:
        return squared.side * sp.sqrt(elliptic_inverse(change, amount, begin**2, names))
    # √X goes on with the other sign at X = 0: the phase begins there, where x = ± √X is odd in it
    passed = twice * integral.value.subs(integral.curve.coordinate.symbol, start)
    return root_of_square(change, squared.roots, amount, passed, names)


def _algebraic(
    own: CoordinateIntegrals, integral: PieceIntegral, value: sp.Expr, start: sp.Symbol, names: NamedQuantities,
    others: Numbers | None,
) -> sp.Expr:  # fmt: skip
    """Return the place where an algebraic function of x, C √(Bx + C) as in uniform acceleration, has a value."""
    law, s, q = required(integral.law), integral.curve.substitution, integral.curve.coordinate.symbol
    P, begin, plain = sp.Poly(law.polynomial, law.x), s.place.subs(q, start), not law.algebraic.has(law.x)
    x = None
    # √(x² + bx + c) = value: as of a free particle in r, one square root
    if P.degree() == 2 and plain:
        x = square_root_inverse(law, own_side(own, integral), value, begin, names)
    # √(Bx + C) = value: uniform acceleration
    elif P.degree() == 1 and plain:
        x = _accelerated(law, P, value, begin, names)
    # (x + c) √(Bx + C) = value: a cubic in the root (Barker), or a pure power of it
    elif P.degree() == 1:
        x = power_inverse(law, value, begin, names) or cubic_inverse(law, value, begin, names)
    if x is None:
        raise NoFormError(_why_not_inverted(own, law))
    return verified_inverse(own, integral, s.q(x), value, start, names, others)


def _accelerated(
    law: Antiderivative, P: sp.Poly, value: sp.Expr, begin: sp.Expr, names: NamedQuantities
) -> sp.Expr:  # fmt: skip
    B, C = P.all_coeffs()
    running = sp.expand(2 * value / (law.algebraic * B))
    moving, root = [v for v in names.variables if running.has(v)], positive_root(B * begin + C)
    if len(moving) == 1 and not running.has(*names.places):
        return accelerated(names, begin, running, moving[0], root, B)
    return sp.cancel(-C / B) + B / 4 * Phase(names, running, sp.S.One, 2 * root / B, even=True).argument ** 2


def own_side(own: CoordinateIntegrals, integral: PieceIntegral) -> int:
    """On which side of the middle of the roots of P, deg P = 2, a motion is.

    Args:
        own: the coordinate.
        integral: on the curve of P.
    """
    region = next(r for c, r in own.regions if c is integral.curve)
    _, B, A = (integral.curve.polynomial.coeff_monomial(integral.curve.x**k) for k in range(3))
    middle = value_at(-B / (2 * A), sample_numbers(own))
    return 1 if region.place > middle else -1


def _why_not_inverted(own: CoordinateIntegrals, law: Antiderivative) -> WhyNot:
    """Return a proof where there is one: two independent functions of q in the time law."""
    if not law.terms:
        return NotFound(f"t({own.name}) is algebraic, of higher degree in the root")
    proof = TranscendentalEquation(own.name, law)
    return proof if proof.holds() else NotFound(f"t({own.name}) holds several logarithms, and was not solved")


def _value(place: sp.Expr, names: NamedQuantities, numbers: dict[sp.Symbol, mpmath.mpf]) -> mpmath.mpf:
    """Return a place from the values of its names; written out where a name holds what drops out of the whole."""
    known = names.at(place, numbers)
    return value_at(place, known) if place.free_symbols <= known.keys() else value_at(names.written_out(place), numbers)


def verified_inverse(
    own: CoordinateIntegrals, integral: PieceIntegral, place: sp.Expr, value: sp.Expr, start: sp.Symbol,
    names: NamedQuantities, others: Numbers | None,
) -> sp.Expr:  # fmt: skip
    """Return an inverse, once it gives back a place from the integral there, to 40 digits.

    Args:
        own: the coordinate, with its sample.
        integral: ∫ N dq/P, verified.
        place: the inverse, q as a function of the value.
        value: what the integral from the lower limit is to be, an expression of t and β.
        start: the lower limit.
        names: of the quantities that the inverse holds.
        others: numbers for other symbols of the value.

    Raises:
        NoFormError: it does not.
    """
    check_time()
    q = integral.curve.coordinate.symbol
    stop = nearby(own, integral)
    with mp.workdps(DIGITS + 20):
        numbers = {**sample_numbers(own), **(others or {})}
        free = sorted(value.free_symbols - set(numbers), key=str)
        numbers |= {s: mp.mpf(k + 2) / 7 for k, s in enumerate(free)}
        numbers[start], target = sample_place(own), number_of(stop, {})
        # the time at which the motion is at ``target`` by the verified integral; β and t₀ have numbers of their own
        difference = value_at(integral.value, numbers | {q: target}) - value_at(
            integral.value, numbers | {q: numbers[start]}
        )
        # as large as the integral in any unit: next to a β of 1 an integral of 1e-36 would have no digits
        numbers |= {s: numbers[s] * difference / value_at(sp.diff(value, s), numbers) for s in free}
        unknown, offset = free[0], value_at(value, numbers)
        # the value is linear in each of t and the β, so one step of Newton's rule is exact
        numbers[unknown] += (difference - offset) / value_at(sp.diff(value, unknown), numbers)
        got = _value(place, names, numbers)
        # by both places, one of which may be at 0: in no unit
        if not abs(got - target) <= (abs(target) + abs(numbers[start])) * mp.mpf(10) ** -DIGITS:
            raise NoFormError(f"not verified: the inverse gives {mp.nstr(got, 15)} for {mp.nstr(target, 15)}")
        # a turn later an arc function would be back at its first value, am u goes on
        if own.kind == "rotation" and integral.cycle is not None:
            numbers[unknown] += value_at(integral.cycle, numbers) / value_at(sp.diff(value, unknown), numbers)
            turn = value_at(integral.curve.substitution.turn, numbers)
            # the angle itself, or the angle and a whole turn
            turned = mp.sin((_value(place, names, numbers) - target) * mp.pi / turn)
            if not abs(turned) <= mp.mpf(10) ** -DIGITS:
                raise NoFormError("the inverse that was found is right on one turn only")
    return place


def orbit_formulas(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], special: SpecialCase, names: NamedQuantities
) -> dict[str, sp.Expr]:  # fmt: skip
    """Return a coordinate as a function of another one, from an orbit equation −β = ….

    That of an ignorable momentum, θ + ∫ ∂p/∂c dq, gives q(θ); that of a separation constant over two coordinates,
    ∫ ∂p₁/∂α dq₁ + ∫ ∂p₂/∂α dq₂, gives q₁(q₂), as for two centres.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        names: of the quantities of the forms.
    """
    solution, found = context.solution, dict[str, sp.Expr]()
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
                found.setdefault(target, _along(context, pieces, (name, key), target, held, names))
            except NoFormError:
                continue
    return found


def _along(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], equation_of: tuple[str, sp.Symbol], target: str,
    held: list[str], names: NamedQuantities,
) -> sp.Expr:  # fmt: skip
    """One coordinate from an orbit equation."""
    name, key = equation_of
    solution, own = context.solution, pieces[target]
    equation = solution.orbit_equations[name]
    rest = without_integrals(equation.rhs)
    if rest.has(own.integrals[key].curve.coordinate.symbol):
        raise NoFormError("the shift of the momenta enters the orbit equation")
    value, numbers = multiplied_out(equation.lhs - rest), dict[sp.Symbol, mpmath.mpf]()
    for other in held:
        if other != target:
            more, along = pieces[other], pieces[other].integrals[key]
            q, start = along.curve.coordinate.symbol, solution.lower_limits[other]
            value -= along.value - along.value.xreplace({q: start})
            with mp.workdps(DIGITS + 20):
                numbers |= sample_numbers(more)
                numbers |= {q: number_of(nearby(more, along), {}), start: sample_place(more)}
    return inverted(own, own.integrals[key], value, solution.lower_limits[target], names, numbers)


def parametric_formulas(
    context: FormContext, pieces: Mapping[str, CoordinateIntegrals], special: SpecialCase, names: NamedQuantities
) -> dict[str, sp.Expr]:  # fmt: skip
    """q₁(τ) and q₂(τ) from ∫ ∂p₁/∂α dq₁ + ∫ ∂p₂/∂α dq₂ = −β: dτ = ±∂p₁/∂α dq₁ = ∓∂p₂/∂α dq₂, growing with both.

    So the times of two centres and of Kerr's geodesics decouple (Greenwood (5-137); Mino, Phys. Rev. D 67, 084027).

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        names: of the quantities of the forms.
    """
    solution, two = context.solution, list(context.solution.coordinates)
    ignorable = {c.momentum for c in solution.separation.shell.ignorable}
    τ = common_parameter(solution)
    if len(two) != 2 or any(name not in pieces for name in two):
        return {}
    for constant in solution.orbit_equations:
        key, found = solution.constants[constant].symbol, dict[str, sp.Expr]()
        if key in ignorable or key in special or any(key not in pieces[n].integrals for n in two):
            continue
        for name in two:
            try:
                found[name] = _on_branch(pieces[name], key, τ, solution.lower_limits[name], names)
            except NoFormError:
                continue
        if found:
            return found
    return {}


def _on_branch(
    own: CoordinateIntegrals, key: sp.Symbol, τ: sp.Symbol, start: sp.Symbol, names: NamedQuantities
) -> sp.Expr:  # fmt: skip
    """Q(τ) of a coordinate that grows with τ."""
    integral, numbers = own.integrals[key], sample_numbers(own)
    # ∂p/∂α is positive for one of the coordinates and negative for the other
    numerator = value_at(integral.numerator, numbers | {integral.curve.coordinate.symbol: sample_place(own)})
    return inverted(own, integral, τ if numerator > 0 else -τ, start, names)
