"""Closed forms that ``hjsolve.closed_forms`` derives, as a method next to the others, for systems with none typed in.

Only what the scene asks is evaluated: numbers of the motion, and states where the inverse is known and every separated
momentum is positive at the start (the branch that the forms are of). The error claimed is the difference of two
evaluations, the second with twice the digits.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import mpmath
import sympy as sp

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.evaluation import Evaluator, many_digits
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.named_quantities import needed_names
from hjsolve.closed_form.numbers import refuse_places, root_values
from hjsolve.costs.answers import Answer
from hjsolve.costs.trial import Task, Trial
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.motion.motion import Motion
from hjsolve.precision import mp
from hjsolve.scenes.question import Times
from hjsolve.scenes.run import first_arguments

Claimed: TypeAlias = float | Mpf
_GUARD, _FRACTION, _MOST_SECONDS = 20, 0.25, 5.0
_NUMBERS = ("turning_points", "actions", "frequencies", "periods")


@dataclass(frozen=True, eq=False)
class DerivedForm:
    """The forms of a scene's motion, made ready.

    Attributes:
        fixed: name → formula, of the results of the motion.
        states: name → formula, of functions of the time.
        form: they are of.
        exact: symbol → exact value, of all symbols but the time and the named roots.
        start: the initial time.
        missing: what is wanted and has no form.
    """

    fixed: Mapping[str, sp.Expr]
    states: Mapping[str, sp.Expr]
    form: RegimeForms
    exact: Mapping[sp.Symbol, sp.Expr]
    start: sp.Expr
    missing: tuple[str, ...]

    def values(self, digits: int, moments: Sequence[sp.Expr]) -> dict[str, list[mpmath.mpf]]:
        """Evaluate.

        Args:
            digits: of the working precision.
            moments: times, exact.
        """
        numbers = many_digits(self.exact, digits) | root_values(self.form, self.exact, digits)
        with mp.workdps(digits):
            found = {n: [v] for n, v in zip(self.fixed, Evaluator([*self.fixed.values()]).at(numbers), strict=True)}
            if self.states:
                at = Evaluator([*self.states.values()]).along(numbers, _T)
                rows = [at(mp.mpf(int(t.p)) / int(t.q)) for t in map(_rational, moments)]
                found |= {name: [row[k] for row in rows] for k, name in enumerate(self.states)}
        if any(isinstance(v, mp.mpc) or not mp.isfinite(v) for values in found.values() for v in values):
            raise NotConvergedError("the closed form has no real value here")
        return found


_T, _T0 = sp.Symbol("t", real=True), sp.Symbol("t_0", real=True)


def derived_trials(task: Task, levels: Sequence[int], seconds: float) -> list[Trial]:
    """Return the derived forms at several accuracies.

    Args:
        levels: digits beyond double precision.
        seconds: of the whole comparison; a quarter of it, and 5 at most, may go into the derivation.

    Returns:
        One trial a level and one at 15 digits; none where nothing that is asked has a form, an effect is switched on,
        or something happens on the way.
    """
    scene = task.scene
    if task.solution is None or scene.effects or scene.events:
        return []
    begin = time.process_time()
    form = derived_form(task, min(_FRACTION * seconds, _MOST_SECONDS))
    spent = time.process_time() - begin
    return [] if form is None else [_trial(task, form, digits, spent) for digits in (15, *levels)]


def derived_form(task: Task, seconds: float) -> DerivedForm | None:
    """Derive what a scene asks; None where nothing of it has a form.

    Args:
        task: with the scene.
        seconds: of processor time for the derivation.
    """
    motion = required(task.solution).motion(**first_arguments(task.scene))
    form = own_form(motion, seconds=seconds)
    if form is None:
        return None
    named, fixed = form.named(), dict[str, sp.Expr]()
    for name, expression in named.items():
        head, _, rest = name.partition(".")
        if head in _NUMBERS and head in task.scene.want:
            fixed[f"{head}.{rest.replace('.lower', '.0').replace('.upper', '.1')}"] = expression
    exact = _exact(motion)
    states, missing = dict[str, sp.Expr](), list[str]()
    if task.states:
        known = set(exact) | {_T}
        found = {
            f"q.{n}": e
            for n, e in form.inverse.items()
            if _positive(motion) and _in_place(form, exact) and needed_names(e.free_symbols, form.where)[1] <= known
        }
        states, missing = found, [] if len(found) == len(motion.solution.system.coordinates) else ["the states"]
    missing += [w.replace("_", " ") for w in _NUMBERS if w in task.scene.want and _lacks(motion, w, fixed)]
    return DerivedForm(fixed, states, form, exact, motion.t0, tuple(missing)) if fixed or states else None


def _lacks(motion: Motion, word: str, fixed: Mapping[str, sp.Expr]) -> bool:
    return any(not any(name.startswith(f"{word}.{key}") for name in fixed) for key in getattr(motion, word))


def _positive(motion: Motion) -> bool:
    at, system = motion.initial.values, motion.solution.system
    return all(at[system.coordinate(name).momentum].is_positive for name in motion.solution.coordinates)


def _in_place(form: RegimeForms, exact: Mapping[sp.Symbol, sp.Expr]) -> bool:
    """Return whether the motion starts on the piece, or in the turn, that the form is of."""
    try:
        refuse_places(form, exact)
    except InvalidInputError:
        return False
    return True


def _exact(motion: Motion) -> dict[sp.Symbol, sp.Expr]:
    """Return symbol → exact value: parameters, constants, lower limits at the start, and the β that go with them."""
    solution, at = motion.solution, motion.initial.values
    exact = {p.symbol: at[p.symbol] for p in solution.system.parameters}
    exact |= {c.symbol: motion.initial.constants[name] for name, c in solution.constants.items()}
    exact |= {limit: at[solution.system.coordinate(n).symbol] for n, limit in solution.lower_limits.items()}
    exact[_T0] = motion.t0
    for equation in solution.orbit_equations.values():
        betas = [s for s in equation.lhs.free_symbols if s not in exact and s != _T]
        start = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
        value = -start.xreplace(dict(at)).xreplace({_T: motion.t0})
        if len(betas) == 1 and not value.free_symbols:
            exact[betas[0]] = value
    return exact


def _rational(moment: sp.Expr) -> sp.Rational:
    return moment if moment.is_Rational else sp.Rational(str(sp.N(moment, 60)))


def _trial(task: Task, form: DerivedForm, digits: int, spent: float) -> Trial:
    angles = {f"q.{c.name}" for c in task.scene.system.coordinates if c.domain.kind == "angle"}

    def compute(times: Times | None, _: float) -> dict[str, list[tuple[Claimed, Claimed]]]:
        moments = task.every if times is None else times.listed
        near, far = form.values(digits + _GUARD, moments), form.values(2 * (digits + _GUARD), moments)
        return {n: [_rounded(x, y, digits) for x, y in zip(near[n], far[n], strict=True)] for n in far}

    def read(result: dict[str, list[tuple[Claimed, Claimed]]], places: Sequence[int]) -> Answer:
        numbers = {n: tuple(v[k] for k in places) if n in form.states else tuple(v) for n, v in result.items()}
        sizes = {n: max(abs(float(v)) for v, _ in result[n]) for n in form.states}
        count = 2 * sum(len(values) for values in result.values())
        return Answer(numbers, count, {n: size for n, size in sizes.items() if n not in angles})

    covers = "all" if not form.missing else "numbers" if form.missing == ("the states",) else "part"
    without = f"without {' and '.join(form.missing)}; " if form.missing else ""
    note = f"{without}derived in {spent:.1f} s"
    return Trial("closed form", digits, compute, read, "formulas", own=True, covers=covers, note=note)


def _rounded(value: mpmath.mpf, again: mpmath.mpf, digits: int) -> tuple[Claimed, Claimed]:
    """Return the value to the digits asked, and what it claims."""
    with mp.workdps(2 * (digits + _GUARD)):
        difference = 2 * abs(again - value)
        if digits <= 15:
            return float(again), float(difference) + abs(float(again)) * EPS
        return again, difference + abs(again) * mp.mpf(10) ** -digits
