"""Forms that are derived stand next to the other methods, and their claims hold."""

from __future__ import annotations

import pytest

import hjsolve
from hjsolve.costs.closed_forms import closed_trials
from hjsolve.costs.derived_forms import derived_form
from hjsolve.costs.side_by_side import _places
from hjsolve.costs.subject import scene_of
from hjsolve.costs.trial import Task


@pytest.mark.nightly_cases("double-well-all")
@pytest.mark.parametrize(("name", "covers"), [
    ("double-well", "all"), pytest.param("spherical-pendulum", "all", marks=pytest.mark.nightly),
    pytest.param("schwarzschild", "numbers", marks=pytest.mark.nightly),
])  # fmt: skip
def test_a_system_without_typed_forms_gets_derived_ones(name: str, covers: str) -> None:
    table = hjsolve.cost(name, digits=(30,), seconds=600, repeats=1, rivals=False)
    rows = [row for row in table.rows if row.method == "closed form"]
    assert [row.digits for row in rows] == [15, 30]
    for row in rows:
        assert row.held
        assert row.covers == covers
        assert row.error is not None
        assert row.error <= 10.0**-row.digits


def test_typed_forms_are_preferred_and_derived_ones_say_what_they_lack() -> None:
    scene, solution = scene_of("kepler-planar", "default")
    task = Task(scene, solution, _places(scene))
    assert closed_trials(task, ())
    derived = derived_form(task, 10)
    assert derived is not None
    assert "the states" in derived.missing
    assert {name.partition(".")[0] for name in derived.fixed} >= {"actions", "frequencies", "periods"}


@pytest.mark.nightly
def test_what_has_no_form_is_no_rival() -> None:
    scene, solution = scene_of("triaxial-geodesics", "default")
    assert derived_form(Task(scene, solution, ()), 5) is None
