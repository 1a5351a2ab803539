"""Errors pass between processes, and ``==`` of values that hold arrays has one answer."""

from __future__ import annotations

import copy
import inspect
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import hjsolve
from hjsolve.display.by_value import same
from hjsolve.display.shown import WIDEST, brief
from tests.support import entries

ERRORS = [c for name in hjsolve.__all__ if inspect.isclass(c := getattr(hjsolve, name)) and issubclass(c, Exception)]
DETAILS = {
    hjsolve.ExpressionError: {"source": "potential", "text": "x + ", "position": 4},
    hjsolve.ForbiddenMotionError: {"name": "r", "regions": ((0.5, None),)},
    hjsolve.NotConvergedError: {"estimate": hjsolve.Estimate(1.5, 0.25)},
    hjsolve.NotSeparableError: {"verdict": "refused"},
}


@pytest.mark.parametrize("kind", ERRORS)
def test_an_error_survives_pickle_and_deepcopy(kind):
    error = kind("what is wrong", **DETAILS.get(kind, {}))
    error.add_note("where")
    for again in (pickle.loads(pickle.dumps(error)), copy.deepcopy(error), copy.copy(error)):
        assert type(again) is kind
        assert str(again) == "what is wrong"
        assert vars(again) == vars(error)


def refusal(name):
    return str(hjsolve.solve(name))


@pytest.mark.nightly
def test_a_process_pool_hands_a_refusal_on_with_its_verdict():
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(hjsolve.NotSeparableError) as caught:
            pool.submit(refusal, "henon-heiles").result(timeout=100)
        assert caught.value.verdict == hjsolve.separate("henon-heiles")


def states():
    return entries.motion("kepler-planar").at(np.linspace(0, 9, 40))


def critical_map():
    return hjsolve.energy_momentum_map(entries.solution("spherical-pendulum"))


def scene():
    return hjsolve.Scene.load({"system": "pendulum", "want": ["periods"]})


def fronts():
    return hjsolve.wavefronts(entries.motion("kepler-planar"), fronts=4, orbits=3)


@pytest.mark.parametrize("make", [states, critical_map, scene, fronts])
def test_a_copy_with_arrays_equals_its_original_and_another_value_does_not(make):
    value = make()
    assert (pickle.loads(pickle.dumps(value)) == value) is True
    assert (copy.deepcopy(value) == value) is True
    assert (value != value) is False
    assert (value == 1) is False


def test_scenes_and_wavefronts_of_equal_questions_are_equal():
    assert scene() == scene()
    assert scene() != hjsolve.Scene.load({"system": "pendulum", "want": ["actions"]})
    assert fronts() == fronts()
    assert fronts() != hjsolve.wavefronts(entries.motion("kepler-planar"), fronts=5, orbits=3)


def test_states_at_other_times_are_not_equal():
    motion = entries.motion("kepler-planar")
    assert (motion.at([1.0, 2.0]) == motion.at([1.0, 2.5])) is False
    assert (motion.at([1.0, 2.0]) == motion.at([1.0, 2.0, 3.0])) is False
    assert motion.at(np.array([1.0, 2.0])) == motion.at(np.array([1.0, 2.0]))


@pytest.mark.parametrize(("one", "other", "answer"), [
    (np.array([1.0, np.nan]), np.array([1.0, np.nan]), True), (np.array([1.0, 2.0]), np.array([1.0, 3.0]), False),
    (np.zeros(2), np.zeros(3), False), (float("nan"), float("nan"), True), (float("nan"), 1.0, False),
    ({"r": np.zeros(2)}, {"r": np.zeros(2)}, True), ({"r": np.zeros(2)}, {"s": np.zeros(2)}, False),
    ((1, [np.ones(2)]), (1, [np.ones(2)]), True), ((1,), (1, 2), False), (np.zeros(1), 0.0, False),
])  # fmt: skip
def test_two_values_are_the_same_or_not(one, other, answer):
    assert same(one, other) is answer


def test_a_motion_in_units_of_pint_can_be_pickled_and_copied():
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    motion = entries.motion("kepler-planar").to_units(registry)
    again = pickle.loads(pickle.dumps(motion))
    assert again.periods["r"].value.magnitude == motion.periods["r"].value.magnitude
    assert str(again.periods["r"].value.units) == str(motion.periods["r"].value.units)
    assert copy.deepcopy(motion).measures.library.registry is registry


def test_motions_and_batches_are_equal_by_their_values():
    import numpy as np

    import hjsolve

    start = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}
    solution = hjsolve.solve("kepler-planar")
    one, other = solution.motion(**start), solution.motion(**start)
    assert one == other
    assert hash(one) == hash(other)
    assert one != solution.motion(**start, digits=20)
    assert one != solution.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.1"})
    batch, same, another = (
        hjsolve.ensemble(
            "kepler-planar", q={"r": np.ones(2), "theta": 0}, velocity={"r": 0, "theta": v}, want="actions"
        )
        for v in (1.2, 1.2, 1.1)
    )
    assert batch == same
    assert batch != another


def test_positions_of_a_table_print_as_their_values():
    """``print(state.q)`` showed ``OnDemand(r, theta)``."""
    import numpy as np

    import hjsolve

    state = (
        hjsolve.solve("kepler-planar")
        .motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
        .at(np.linspace(0, 1, 3000))
    )
    assert repr(state.q) == brief({name: state.q[name] for name in state.q}, WIDEST)
