"""Numbers of forms: with an error, and only for constants of the form's regime."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import mpmath
import sympy as sp
from mpmath import libmp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.named_forms import NamedForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.regions import DIGITS, Where, holds_place, middle_of, with_named
from hjsolve.closed_form.turns_of_angles import (
    DIGITS_AT_ENDS,
    CountedAngle,
    counted_angles,
    curves_held,
    gained_in_a_turn,
    passing_angles,
)
from hjsolve.errors import InvalidInputError, MissingValueError
from hjsolve.formulas.read import number as read_number
from hjsolve.precision import mp, multiprecision

_GUARD, _FLOAT_DIGITS = 20, 15
"""Digits beyond those asked, which a form may lose; digits up to which a result is a double."""
_TIMES_THE_DIGITS = 1, 4, 16
"""Of a number that is infinite with fewer digits: those of roots that are 1e90 apart, where E is nearly 0."""
_TIMES_THE_DIGITS_OF_ROOTS = 2, 4, 8, 16
"""Of roots written in radicals, until half of the digits that are asked stay the same: E of 1e-300 is of doubles."""
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
    exact, gained = _in_one_turn(form, name, exact)
    places = _with_turns_passed(form, name, exact, digits + _GUARD)
    for _, there in places:
        refuse_places(form, there)
    for times in _TIMES_THE_DIGITS:
        # roots and constants to twice the digits: what differs between both evaluations is lost by the form alone
        working, near, far = 2 * times * (digits + _GUARD), mp.zero, mp.zero
        working *= DIGITS_AT_ENDS if len(places) > 1 else 1
        for count, there in places:
            table = many_digits(there, working) | root_values(form, there, working, expression.free_symbols)
            with mp.workdps(working // 2):
                near += count * number_of(expression, table)
            with mp.workdps(working):
                far += count * number_of(expression, table)
        with mp.workdps(working):
            more = number_of(gained, many_digits(exact, working))
            near, far = near + more, far + more
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


def _in_one_turn(
    form: NamedForms, name: str, exact: Mapping[sp.Symbol, sp.Expr]
) -> tuple[dict[sp.Symbol, sp.Expr], sp.Expr]:  # fmt: skip
    """Return places with the whole turns taken off that are counted, and what the form gained in these."""
    moved, gained, gains = dict(exact), sp.S.Zero, gained_in_a_turn(form, name)
    for own in counted_angles(form, exact):
        count = _turns(own, exact[own.begin], exact)
        moved[own.symbol] = exact[own.symbol] - count * own.turn.xreplace(dict(exact))
        gained += count * gains.get(own.symbol, sp.S.Zero) if count else 0
    return moved, gained


def _with_turns_passed(
    form: NamedForms, name: str, exact: Mapping[sp.Symbol, sp.Expr], digits: int
) -> list[tuple[int, dict[sp.Symbol, sp.Expr]]]:  # fmt: skip
    """Return places within one turn, and next to its ends as often as it was passed: a form is the sum over these."""
    inside, passed = dict(exact), list[tuple[int, CountedAngle]]()
    for own in passing_angles(form, name, exact):
        count = _turns(own, exact[own.symbol], exact)
        inside[own.symbol] = exact[own.symbol] - count * own.turn.xreplace(dict(exact))
        passed += [(count, own)] if count else []
    places = [(1, inside)]
    for count, own in passed:
        # at the end itself tan(q/2) is infinite: next to it, and from both sides
        half = own.turn * (sp.S.Half - sp.Integer(10) ** -digits)
        middle, half = (e.xreplace(dict(exact)) for e in (own.middle, half))
        places += [(side * count, inside | {own.symbol: middle + side * half}) for side in (1, -1)]
    return places


def _turns(own: CountedAngle, place: sp.Expr, exact: Mapping[sp.Symbol, sp.Expr]) -> int:
    """Return how many turns a place is from that of the form."""
    numbers = many_digits(dict(exact), DIGITS)
    with mp.workdps(DIGITS):
        away = number_of(place, numbers) - number_of(own.middle, numbers)
        return int(mp.nint(away / number_of(own.turn, numbers)))


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


def _root_values(where: Where, exact: Mapping[sp.Symbol, sp.Expr], digits: int) -> dict[sp.Symbol, mpmath.mpf]:
    with mp.workdps(digits):
        known = with_named(where, many_digits(exact, digits), digits)
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
