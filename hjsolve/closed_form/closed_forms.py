"""The public verb: closed forms of a solution, or of a motion."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.closed_form.derive import form_of_sample, forms_of_solution, special_of
from hjsolve.closed_form.form_context import FormContext, context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.time_limit import within_seconds
from hjsolve.closed_form.verification import DIGITS
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.precision import one_at_a_time
from hjsolve.separation import Separation
from hjsolve.solution.quadratures import Solution, solve

SECONDS = 20.0
"""Of the processor for all regimes of a solution: what is not derived by then says so, and is on request."""
_FEWEST, _MOST_DIGITS = 15, 200
"""Digits of a comparison: what doubles show, and what a form is still compared to within seconds."""


@arguments.with_known_names('closed_forms("kepler-planar", seconds=20)')
@one_at_a_time
def closed_forms(
    subject: Solution | Motion | System | Separation | str | Path, *, digits: int = DIGITS, seconds: float = SECONDS
) -> tuple[RegimeForms, ...]:  # fmt: skip
    """Derive closed forms of the quadratures, regime by regime; each is verified before it is given.

    A form is differentiated back to its integrand, and compared with the quadrature to so many digits at a motion of
    its regime; what fails, or has no form in elementary and elliptic functions, is missing, and ``why_not`` says why.

    Args:
        subject: a solution, or what ``solve`` takes; or a motion.
        digits: to which the forms are compared with the quadratures, 15 to 200.
        seconds: of processor time that may be spent. What is not done by then is missing: integrals that were begun
            say so in ``why_not``, regimes that were not are not listed.

    Returns:
        The forms of a solution: one for each regime that a search among random motions meets, those of general
        constants before those of special ones (E = 0, a separatrix), bounded ones first. Of a motion: its own regime
        first; then the others of its solution. Empty where every motion found is at rest.

    Raises:
        InvalidInputError: something else; digits out of range, seconds that are not positive.
        NotSeparableError: a system that does not separate.

    Example:
        >>> import hjsolve
        >>> form = hjsolve.closed_forms("harmonic-oscillator")[0]
        >>> form.regime.words, form.periods["x"]
        ('x: libration; E > 0', 2*pi*sqrt(m)/sqrt(k))
    """
    if type(digits) is not int or not _FEWEST <= digits <= _MOST_DIGITS:
        raise InvalidInputError(
            f"closed_forms: digits must be a whole number from {_FEWEST} to {_MOST_DIGITS}, not {digits!r}"
        )
    if not seconds > 0:
        raise InvalidInputError(f"closed_forms: seconds must be positive, not {seconds!r}")
    if not isinstance(subject, (Motion, Solution, System, Separation, str, Path)):
        raise InvalidInputError(
            f"closed_forms: expected a solution, a motion, a system or a catalog id, got {type(subject).__name__}"
        )
    if isinstance(subject, Motion):
        refuse_kinks(subject.solution.system.kinks, "closed_forms")
        with within_seconds(seconds):
            context = context_of(subject.solution, digits)
            own = [form for form in (_own_form(context, subject),) if form is not None]
            return (*own, *forms_of_solution(context, own))
    solution = subject if isinstance(subject, Solution) else solve(subject)
    refuse_kinks(solution.system.kinks, "closed_forms")
    with within_seconds(seconds):
        return forms_of_solution(context_of(solution, digits))


def own_form(motion: Motion, *, seconds: float | None = SECONDS) -> RegimeForms | None:
    """Return the closed forms of a motion's own regime; None of one at rest.

    Args:
        motion: started, in any digits.
        seconds: of processor time that may be spent; None for no limit.
    """
    with within_seconds(seconds):
        return _own_form(context_of(motion.solution, DIGITS), motion)


def _own_form(context: FormContext, motion: Motion) -> RegimeForms | None:
    solution = motion.solution
    exact = {p.symbol: motion.initial.values[p.symbol] for p in solution.system.parameters}
    exact |= {c.symbol: motion.initial.constants[name] for name, c in solution.constants.items()}
    special = dict(special_of(context, exact))
    values = {symbol: _rational(value) for symbol, value in exact.items() if symbol not in special}
    for symbol, meaning in special.items():
        values[symbol] = _rational(meaning.xreplace(values))
    places = {
        name: _rational(motion.initial.values[solution.system.coordinate(name).symbol]) for name in solution.coordinates
    }
    inside = {name: _moved_inside(motion, name, place) for name, place in places.items()}
    return form_of_sample(context, context.at(special), special, Sample(values, inside))


def _rational(value: sp.Expr) -> sp.Expr:
    """Return a number by one with 260 digits; a rational number by itself."""
    return value if value.is_Rational else sp.Rational(str(sp.N(value, _MOST_DIGITS + 60)))


def _moved_inside(motion: Motion, name: str, place: sp.Expr) -> sp.Expr:
    """Return a place a little inside the region, where the motion starts at a turning point."""
    lower, upper = motion.turning_points.get(name, (None, None))
    low, high = (None if end is None else _rational(sp.sympify(end.value)) for end in (lower, upper))
    if low is not None and high is not None and high > low:
        return low + (high - low) * sp.Rational(37, 100)
    if low is None and high is None:
        return place
    edge, sign = (low, 1) if low is not None else (sp.sympify(high), -1)
    domain = motion.solution.system.coordinate(name).domain
    end = domain.upper if sign > 0 else domain.lower
    end = None if end is None else _rational(end.xreplace(dict(motion.initial.values)))
    # an eighth of the way to the end of the domain, or of its own size: a fall from r = 1/10, or in units of 1e-20
    size = (abs(edge) if end is None else abs(end - edge)) / 8 or sp.Rational(1, 8)
    return place if abs(place - edge) > size else edge + sign * size
