"""Forms in doubles at random motions, against ensembles and quadratures; and that a form that is broken is caught."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import pytest
import sympy as sp

import hjsolve
from benchmarks.closed_form_batches import campaign, forms_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.solution.quadratures import Solution

pytestmark = pytest.mark.rotating_file(1)
MOTIONS = 200


@lru_cache(maxsize=4)
def _known(entry: str) -> tuple[Solution, tuple[RegimeForms, ...]]:
    solution = hjsolve.solve(entry)
    return solution, tuple(forms_of(solution))


def _broken(form: RegimeForms, name: str, factor: sp.Rational) -> RegimeForms:
    """A form with one of its expressions multiplied."""
    group, _, rest = name.partition(".")
    own: Any = getattr(form, group)
    if isinstance(own, sp.Eq):
        return replace(form, **{group: sp.Eq(own.lhs, factor * own.rhs, evaluate=False)})
    if isinstance(own, sp.Expr):
        return replace(form, **{group: factor * own})
    key, _, side = rest.partition(".")
    value = own[key]
    if isinstance(value, sp.Eq):
        value = sp.Eq(value.lhs, factor * value.rhs, evaluate=False)
    elif side:
        value = tuple(factor * end if s == side else end for s, end in zip(("lower", "upper"), value, strict=True))
    else:
        value = factor * value
    return replace(form, **{group: {**own, key: value}})


@pytest.mark.parametrize(("entry", "motions"), [
    ("pendulum", MOTIONS), ("kepler-planar", MOTIONS),
    *(pytest.param(name, 2000, marks=pytest.mark.nightly) for name in ("kepler-planar", "double-well", "morse")),
])  # fmt: skip
def test_forms_in_doubles(entry: str, motions: int) -> None:
    for own in campaign(*_known(entry), motions, seed=5, seconds=60):
        found = own.rows.values()
        assert [fault for row in found for fault in row.faults] == []
        assert sum(row.nan for row in found) == 0
        if own.motions == motions:
            # of a fall into the centre, p_θ = 0, the engine has neither actions nor turning points
            none = ("actions.", "turning_points.") if own.form.regime.special else ()
            asked = [row for row in found if not row.name.startswith(none)]
            assert sum(row.count for row in asked) > motions * len(asked) / 2


@pytest.mark.parametrize("entry", ["pendulum", "kepler-planar"])
@pytest.mark.parametrize("factor", [sp.Rational(-1), 1 + sp.Rational(1, 10**9)])
def test_a_form_that_is_broken_is_caught(entry: str, factor: sp.Rational) -> None:
    solution, (form, *_) = _known(entry)
    sound = campaign(solution, [form], 50, seed=5, seconds=0)[0]
    assert {"time_law", "characteristic_function", "periods.theta", "actions.theta"} <= set(sound.rows)
    for name in sound.rows:
        found = campaign(solution, [_broken(form, name, factor)], 50, seed=5, seconds=0)[0]
        assert any(name.split(".")[0] in fault for row in found.rows.values() for fault in row.faults), name
