"""The closed forms of the catalog are right, for every motion of every entry that has one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hjsolve.costs.closed_forms import closed_form
from hjsolve.costs.own_methods import own
from hjsolve.costs.side_by_side import _places
from hjsolve.costs.subject import scene_of
from hjsolve.costs.trial import Task
from tests.support.entries import with_closed_form

pytestmark = pytest.mark.rotating_file(6)

ENTRIES, MOTIONS = with_closed_form()


def test_there_are_some() -> None:
    assert len(ENTRIES) >= 9
    assert len(MOTIONS) >= 14


@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_closed_forms_agree_with_the_quadratures(name: str, motion: str) -> None:
    scene, solution = scene_of(name, motion)
    assert scene.times is not None
    scene = replace(scene, times=replace(scene.times, count=3))
    task = Task(scene, solution, _places(scene))
    form = closed_form(task)
    assert form is not None
    trial = own(task, "mpmath", 40)
    known = trial.read(trial.compute(None, 0.0), range(3)).numbers
    values = dict(zip(form.names, form.values(200, task.every), strict=True))
    assert len(values) >= 3
    for key, found in values.items():
        assert key in known, key
        for value, (truth, _) in zip(found, known[key], strict=True):
            assert abs(value - truth) <= 1e-38 * max(abs(truth), 1), key


def test_another_kind_of_motion_has_none() -> None:
    scene, solution = scene_of("kepler-planar", "hyperbolic")
    assert closed_form(Task(scene, solution, ())) is None
