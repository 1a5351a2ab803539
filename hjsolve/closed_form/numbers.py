"""Numbers of forms: with an error, and only for constants of the form's regime."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import (
    DIGITS,
    RootInterval,
    holds_place,
    middle_of,
    ordered_real_roots,
)  # fmt: skip
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number as read_number
from hjsolve.precision import mp, multiprecision

_GUARD, _FLOAT_DIGITS = 20, 15
"""Digits beyond those asked, which a form may lose; digits up to which a result is a double."""
_TIMES_THE_DIGITS = 1, 4, 16
"""Of a number that is infinite with fewer digits: those of roots that are 1e90 apart, where E is nearly 0."""
_TIMES_THE_DIGITS_OF_ROOTS = 2, 4, 8, 16
"""Of roots written in radicals, until half of the digits that are asked stay the same: E of 1e-300 is of doubles."""
_GIVE_A_PLACE = ("inverse", "orbit", "parametric", "anomaly")
"""Groups of forms that give a coordinate."""
_DIGITS_OF_EXAMPLE = 30
"""Of what is only put in order."""


def form_at_numbers(form: NamedForms, name: str, values: Mapping[str, object], digits: int) -> Estimate:
    """One form at numbers; see ``RegimeForms.evaluate``.

    Args:
        form: of a regime.
        name: of the quantity.
        values: symbol's name → number.
        digits: of the result.

    Raises:
        InvalidInputError: an unknown name, or constants that are not of this regime.
        MissingValueError: a value that is missing.
    """
    expression = wanted_form(form, name)
    exact = _exact(form, expression, values)
    refuse_outside(form, exact)
    turns = whole_turns(form, exact)
    lengths = {symbol: turn for _, symbol, _, turn in places_of_turns(form, turns)}
    exact |= {symbol: exact[symbol] - count * lengths[symbol].xreplace(exact) for symbol, count in turns.items()}
    refuse_places(form, exact)
    for symbol, more in gained_in_a_turn(form, name).items() if any(turns.values()) else ():
        expression = expression + turns.get(symbol, 0) * more
    for times in _TIMES_THE_DIGITS:
        # roots and constants to twice the digits: what differs between both evaluations is lost by the form alone
        working = 2 * times * (digits + _GUARD)
        table = many_digits(exact, working) | root_values(form, exact, working, expression.free_symbols)
        with mp.workdps(working // 2):
            near = number_of(expression, table)
        with mp.workdps(working):
            far = number_of(expression, table)
            if mp.isfinite(far) and mp.isfinite(near):
                break
    else:
        raise InvalidInputError(f"{name} is infinite there")
    with mp.workdps(working):
        # √P² of a place that is never reached is imaginary; its rounding is not
        if abs(mp.im(far)) > abs(far) * mp.mpf(10) ** -digits:
            raise InvalidInputError(f"{name} has no real value there: the place is not one the motion reaches")
        again = mp.re(far)
        # the finer value has all the digits of the coarser one, so that their difference is the coarser one's error
        lost = 2 * abs(mp.re(near) - again)
    if digits <= _FLOAT_DIGITS:
        return Estimate(float(again), float(lost) + abs(float(again)) * EPS)
    context = multiprecision(libmp.dps_to_prec(digits + 2))
    return Estimate(context.mpf(again), context.mpf(lost) + abs(context.mpf(again)) * context.mpf(10) ** -digits)


def refuse_outside(form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr]) -> None:
    """Refuse constants that are not of a form's regime.

    Args:
        form: of a regime.
        exact: symbol → exact value, of every parameter and constant.

    Raises:
        InvalidInputError: they are of another one.
    """
    if not form.regime.holds(exact):
        raise InvalidInputError(
            f"these constants are not of the form's regime ({form.regime.words}); "
            "take the form of closed_forms(solution) whose regime holds, or closed_forms(motion)"
        )


def refuse_places(form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr]) -> None:
    """Refuse a coordinate, or a lower limit, at which the motion of the regime never is.

    Args:
        form: of a regime.
        exact: symbol → exact value, of constants, coordinates and lower limits.

    Raises:
        InvalidInputError: it is such a place.
    """
    for curve, region, symbol in curves_held(form, exact):
        numbers = many_digits(exact, DIGITS)
        if holds_place(curve, region, numbers[symbol], numbers):
            continue
        turn = ""
        if curve.substitution.closed:
            middle, half = float(middle_of(curve, numbers)), float(number_of(curve.substitution.turn, numbers)) / 2
            turn = f"; the form is that of one turn, {symbol} from {middle - half:.3g} to {middle + half:.3g}"
        raise InvalidInputError(f"{symbol} = {float(numbers[symbol]):.6g} is outside this regime's motion{turn}")


def whole_turns(form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, int]:
    """Return how many whole turns coordinates, and lower limits, lie from the turn of their curve.

    Args:
        form: of a regime.
        exact: symbol → exact value, of constants, coordinates and lower limits.
    """
    found = dict[sp.Symbol, int]()
    for curve, symbol, begin, turn in places_of_turns(form, exact):
        numbers = many_digits(exact, DIGITS)
        with mp.workdps(DIGITS):
            found[symbol] = int(mp.nint((numbers[begin] - middle_of(curve, numbers)) / number_of(turn, numbers)))
    return found


def places_of_turns(
    form: NamedForms, held: Iterable[sp.Symbol]
) -> list[tuple[MomentumCurve, sp.Symbol, sp.Symbol, sp.Expr]]:  # fmt: skip
    """Return the curves of coordinates and lower limits among symbols, what says in which turn each is, and the turn.

    A libration of an angle is in one well, whatever turns are counted, one along a line in any cell of the lattice; a
    rotation is counted from its lower limit.

    Args:
        form: of a regime.
        held: the symbols.
    """
    known, found = set(held), list[tuple[MomentumCurve, sp.Symbol, sp.Symbol, sp.Expr]]()
    for curve, region, symbol in curves_held(form, known):
        if (turn := _turn(form, curve, region)) is not None:
            begin = form.solution.lower_limits.get(curve.coordinate.name, symbol)
            found.append((curve, symbol, begin if region.kind == "rotation" and begin in known else symbol, turn))
    return found


def _turn(form: NamedForms, curve: MomentumCurve, region: RootInterval) -> sp.Expr | None:
    """Return by what a coordinate may be moved without a change of the forms; None where by nothing."""
    s, angle = curve.substitution, curve.coordinate.domain.kind == "angle"
    if not s.closed:
        return None
    # of a shift A of the momenta nothing is known but that it repeats itself along a whole angle
    if form.solution.shift[curve.coordinate.name] != 0 or (angle and region.kind == "libration"):
        return 2 * sp.pi if angle else None
    return s.turn


def gained_in_a_turn(form: NamedForms, name: str) -> dict[sp.Symbol, sp.Expr]:
    """Return what a form gains where a coordinate moves on by a whole turn, by the symbol of the coordinate.

    q(t) is counted from q(t₀), and W holds −∫ A dq of a shift A of the momenta, p = P − A. Other forms gain nothing.

    Args:
        form: of a regime.
        name: of the quantity.
    """
    solution, (group, _, coordinate) = form.solution, name.partition(".")
    if group in _GIVE_A_PLACE and coordinate in solution.lower_limits:
        places = places_of_turns(form, [solution.lower_limits[coordinate]])
        return {symbol: turn for _, symbol, _, turn in places}
    if name != "characteristic_function":
        return {}
    shifts = ((solution.system.coordinate(q).symbol, A) for q, A in solution.shift.items() if A != 0)
    return {q: -sp.integrate(A, (q, -sp.pi, sp.pi)) for q, A in shifts}


def curves_held(form: NamedForms, held: Iterable[sp.Symbol]) -> list[tuple[MomentumCurve, RootInterval, sp.Symbol]]:
    """Return the curves of coordinates and lower limits that are among symbols.

    Args:
        form: of a regime.
        held: the symbols.
    """
    known = set(held)
    return [
        (curve, region, symbol)
        for curve, region in form.regime.regions
        for symbol in (curve.coordinate.symbol, form.solution.lower_limits.get(curve.coordinate.name))
        if symbol in known
    ]


def wanted_form(form: NamedForms, name: str) -> sp.Expr:
    """Return a form by its name.

    Args:
        form: of a regime.
        name: of the quantity.

    Raises:
        InvalidInputError: an unknown name, or one of which there is no form.
    """
    named = form.named()
    if name not in named:
        reason = form.why_not.get(name)
        more = f"there is no form of it: {reason}" if reason else f"known are {', '.join(named)}"
        raise InvalidInputError(f"{name!r}: {more}")
    return named[name]


def _exact(form: NamedForms, expression: sp.Expr, values: Mapping[str, object]) -> dict[sp.Symbol, sp.Expr]:
    """Return the symbol → exact value, of everything the regime and the expression need."""
    exact = {p.symbol: p.value for p in form.solution.system.parameters if p.value is not None}
    needed = {s.name: s for s in (*form.regime.example, *needed_names(expression.free_symbols, form.where)[1])}
    for name, value in values.items():
        if name not in needed:
            raise InvalidInputError(
                f"{name!r} occurs neither in the form nor in its regime; they contain {', '.join(needed)}"
            )
        exact[needed[name]] = read_number(value, source=name)
    for constant, meaning in form.regime.special.items():
        # of E = 0 nobody should have to say that E is 0
        if constant not in exact:
            exact[constant] = meaning.xreplace(exact)
    missing = [name for name, symbol in needed.items() if symbol not in exact]
    if missing:
        raise MissingValueError(f"a value is missing for {', '.join(missing)}")
    return exact


def root_values(
    form: NamedForms, exact: Mapping[sp.Symbol, sp.Expr], digits: int, wanted: Iterable[sp.Symbol] | None = None
) -> dict[sp.Symbol, mpmath.mpf]:  # fmt: skip
    """Return the values of the symbols that ``where`` defines, as far as what they rest on is known.

    Args:
        form: of a regime.
        exact: symbol → exact value.
        digits: to which roots are found.
        wanted: symbols whose values, and those of what they rest on, are enough; None for all.
    """
    where = needed_names(form.where if wanted is None else wanted, form.where)[0]
    found = _root_values(where, exact, digits)
    written = [s for s in found if not isinstance(where[s], tuple)]
    for times in _TIMES_THE_DIGITS_OF_ROOTS:
        if not written:
            break
        # −b + √(b² + 4Ea) loses as many digits as E has zeros, and what is left of it looks like a number
        coarse, found = found, _root_values(where, exact, times * digits)
        with mp.workdps(digits):
            off = mp.mpf(10) ** (-digits // 2)
            if all(found[s] != 0 and abs(found[s] - coarse[s]) <= off * abs(found[s]) for s in written):
                break
    return found


def _root_values(
    where: Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]], exact: Mapping[sp.Symbol, sp.Expr], digits: int
) -> dict[sp.Symbol, mpmath.mpf]:  # fmt: skip
    known = many_digits(exact, digits)
    with mp.workdps(digits):
        for symbol, meaning in where.items():
            rests_on = sp.Tuple(*meaning[0].all_coeffs()) if isinstance(meaning, tuple) else meaning
            if not rests_on.free_symbols <= known.keys():
                continue
            if isinstance(meaning, tuple):
                polynomial, index = meaning
                known[symbol] = ordered_real_roots(polynomial, known, digits)[index]
            else:
                # names of pairs of conjugate roots are real; the rounding of a square root of a negative number is not
                known[symbol] = mp.re(number_of(meaning, known))
    return {symbol: known[symbol] for symbol in where if symbol in known}


def at_example(form: NamedForms, wanted: Iterable[sp.Symbol]) -> dict[sp.Symbol, Mpf]:
    """Return the constants, the named roots and some named quantities at the motion that a regime was found with.

    Args:
        form: of a regime.
        wanted: symbols of what is to be arranged.
    """
    exact = dict(form.regime.example)
    roots = (s for s, meaning in form.where.items() if isinstance(meaning, tuple))
    return many_digits(exact, _DIGITS_OF_EXAMPLE) | root_values(form, exact, _DIGITS_OF_EXAMPLE, (*roots, *wanted))
