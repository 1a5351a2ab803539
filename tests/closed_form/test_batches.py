"""Forms in doubles at random motions, against ensembles and quadratures; and that a form that is broken is caught."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import hjsolve
from benchmarks.closed_form_batches import campaign, forms_of
from benchmarks.closed_form_comparisons import Met, condition
from benchmarks.closed_form_draws import Draws, Seeds
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


def _met(solution: Solution, form: RegimeForms) -> Met:
    """What is found of one form at fifty motions of its regime."""
    return next(own for own in campaign(solution, [form], 50, seed=5, seconds=0) if own.form is form)


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
    sound = _met(solution, form)
    assert {"time_law", "characteristic_function", "periods.theta", "actions.theta"} <= set(sound.rows)
    for name in sound.rows:
        found = _met(solution, _broken(form, name, factor))
        assert any(name.split(".")[0] in fault for row in found.rows.values() for fault in row.faults), name


def test_the_time_of_an_anomaly_is_judged_at_the_place_it_has_in_doubles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Q(ξ) off by 1e-11 of itself is no fault of t(ξ): the quadrature ends at another ξ, where the rate is the local one."""
    plain = Met.at

    def off(own: Met, name: str, given: Any) -> Any:
        return plain(own, name, given) * (1 + 1e-11 if name == "anomaly.r" else 1)

    monkeypatch.setattr(Met, "at", off)
    found = campaign(*_known("kepler-planar"), 40, seed=5, seconds=60)
    rows = [own.rows["anomaly.t"] for own in found if "anomaly.t" in own.rows]
    assert sum(row.beyond for row in rows) > 10
    assert [fault for row in rows for fault in row.faults] == []


def test_a_regime_that_is_seldom_met_is_drawn_about_its_motions() -> None:
    solution, forms = _known("kepler-planar")
    draws, dice = Draws(solution), np.random.default_rng(3)
    values = draws.parameters(dice, 0, None)
    table, momenta = draws.motions(dice, values, 4096, None)
    # one in a thousand: motions next to circular ones, e < 0.05
    E, L = table["E"], table["p_theta"]
    e = np.sqrt(1 + 2 * E * L**2)
    kept = np.flatnonzero((E < 0) & (e < 0.05))
    assert 0 < len(kept) < 40
    columns = {f"{k}.{n}": (table if k == "q" else momenta)[n][kept] for k in "qp" for n in ("r", "theta")}
    seeds = Seeds.of(solution, columns, {n: v[kept] for n, v in table.items()}, frozenset()).joined(None, dice)
    for _ in range(3):
        moved = draws.parameters(dice, 1, seeds)
        near, p = draws.motions(dice, moved, 4096, seeds)
        ratio = 2 * near["E"] * near["p_theta"] ** 2 / (near["m"] * near["k"] ** 2)
        found = np.flatnonzero((ratio < 0) & (ratio > -1) & (1 + ratio < 0.05**2))
        assert len(found) > 2 * len(kept)
        columns = {f"{k}.{n}": (near if k == "q" else p)[n][found] for k in "qp" for n in ("r", "theta")}
        seeds = Seeds.of(solution, columns, {n: v[found] for n, v in near.items()}, frozenset()).joined(seeds, dice)
    assert len(seeds.parameters) == 4


@pytest.mark.parametrize("name", ["turning_points.r.lower", "turning_points.r.upper", "actions.r"])
def test_what_the_engine_hands_back_is_compared_all_the_same(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Turning points and J of a coordinate, where the engine has none: by P² alone, to 1e-9 of themselves."""
    plain = Draws.followed

    def without(self: Draws, *arguments: Any) -> Any:
        table, columns = plain(self, *arguments) or pytest.fail("parameters are refused")
        hidden = (n for n in columns if n.startswith(("actions.r", "turning_points.r")))
        return table, {**columns, **{n: np.full_like(columns[n], np.nan) for n in hidden}}

    monkeypatch.setattr(Draws, "followed", without)
    solution, (form, *_) = _known("kepler-planar")
    sound = _met(solution, form)
    assert sound.rows[name].count > 5  # ellipses with 1 − e of 1e-9 do not settle
    assert [fault for row in sound.rows.values() for fault in row.faults] == []
    broken = _met(solution, _broken(form, name, 1 + sp.Rational(1, 10**9)))
    assert broken.rows[name].faults


def test_the_condition_where_the_regime_is_narrower_than_a_step() -> None:
    # turning points at E = α₂ (1 + 4e-10) were called 4e8 units off: both sides of a step were of other regimes
    def at(name: str, given: dict[str, Any]) -> Any:
        x = given["x"]
        return np.where(abs(x - 1) < 1e-7, np.sin(1e3 * (x - 1)), np.nan)

    own: Any = SimpleNamespace(functions={"f": SimpleNamespace(names=("x",))}, angles=set(), at=at)
    x = np.array([1.0, 1 + 9e-8, 1.0])
    size, moved = condition(own, "f", {"x": x}, {"x": np.array([0.0, 1e-9, 2e-9])})
    assert np.allclose(size, 1e3, rtol=1e-3, atol=0)
    assert np.allclose(moved, [0.0, 1e-6, 2e-6], rtol=1e-3, atol=0)
