"""Every closed form that the catalog has typed in is found again, from T and V alone."""

from __future__ import annotations

from functools import lru_cache

import pytest
import sympy as sp

import hjsolve
from hjsolve import catalog
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.costs.closed_forms import closed_form
from hjsolve.costs.side_by_side import _places
from hjsolve.costs.subject import scene_of
from hjsolve.costs.trial import Task
from tests.support.entries import with_closed_form

ENTRIES, MOTIONS = with_closed_form()


def test_all_entries_are_here() -> None:
    assert len(ENTRIES) == 11
    assert len(MOTIONS) >= 14


@lru_cache(maxsize=4)
def _started(name: str, motion: str) -> tuple[hjsolve.Motion, RegimeForms]:
    data = catalog.describe(name).motions[motion]
    started = hjsolve.solve(name).motion(**data.arguments)
    form = own_form(started)
    assert form is not None
    return started, form


@pytest.mark.rotating(3)
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_typed_forms_are_derived(name: str, motion: str) -> None:
    """Each typed formula, evaluated with 60 digits at the motion, is the derived form at the motion's constants."""
    scene, solution = scene_of(name, motion)
    task = Task(scene, solution, _places(scene))
    typed = closed_form(task)
    assert typed is not None
    started, form = _started(name, motion)
    signs = {c.name: started.initial.values[c.momentum] for c in solution.system.coordinates}
    constants = {str(s): started.initial.values[s] for s in (p.symbol for p in solution.system.parameters)}
    constants |= dict(started.initial.constants)
    moments = task.every[:3]
    values = dict(zip(typed.names, typed.values(260, moments), strict=True))
    named, compared = form.named(), 0
    for key, found in values.items():
        group, _, rest = key.partition(".")
        if group == "p":
            continue
        if group == "q":
            for value, t in zip(found, moments, strict=True):
                compared += _state(started, form, rest, t, value)
            continue
        if group == "turning_points":
            rest = rest.replace(".0", ".lower").replace(".1", ".upper")
        derived = form.evaluate(f"{group}.{rest}", _needed(form, named[f"{group}.{rest}"], constants), 40)
        truth, name_of = found[0], rest.partition(".")[0]
        rotates = started.kinds[name_of] == "rotation" and signs[name_of] < 0
        sign = -1 if rotates and group in ("actions", "frequencies") else 1
        assert abs(sign * derived.value - truth) <= 1e-38 * max(abs(truth), 1), key
        compared += 1
    assert compared >= 3


def _needed(form: RegimeForms, expression: sp.Expr, constants: dict[str, object]) -> dict[str, object]:
    names = {s.name for s in (*form.regime.example, *expression.free_symbols)}
    return {name: value for name, value in constants.items() if name in names}


def _state(started: hjsolve.Motion, form: RegimeForms, name: str, t: sp.Expr, typed: object) -> int:
    """q(t) from the derived inverse, with the constants β of the motion, on the branch it starts on."""
    solution = started.solution
    at = dict(started.initial.values)
    if any(at[solution.system.coordinate(n).momentum] < 0 for n in solution.coordinates):
        return 0  # the forms are those of the branch p > 0
    table = dict(at.items())
    table |= {c.symbol: started.initial.constants[n] for n, c in solution.constants.items()}
    table |= {limit: at[solution.system.coordinate(n).symbol] for n, limit in solution.lower_limits.items()}
    betas = {}
    for equation in solution.orbit_equations.values():
        (beta,) = (s for s in equation.lhs.free_symbols)
        start = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
        betas[beta] = -start.xreplace(at).xreplace({sp.Symbol("t", real=True): started.t0})
    expression = form.written_out(f"inverse.{name}")
    value = expression.xreplace(
        betas | {s: v for s, v in table.items() if s != solution.system.coordinate(name).symbol}
    )
    value = value.xreplace({sp.Symbol("t", real=True): t, sp.Symbol("t_0", real=True): started.t0})
    assert not value.free_symbols, value.free_symbols
    assert abs(sp.N(value, 60) - sp.Float(typed, 60)) <= 1e-38 * max(abs(sp.Float(typed, 60)), 1)
    return 1
