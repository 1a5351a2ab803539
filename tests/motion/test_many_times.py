"""Many times at once are read from a table in blocks: the same bits as a few at a time, whatever has ended meanwhile."""

import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError
from tests.support import entries

FEW, MANY = 5_000, 70_001
"""Both are read from the table; only the second takes more than one block."""


def len_of(times):
    return str(np.size(times))


def ellipse():
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    return kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": 1.2}, t0="1/3"), 300.0


def rotating_pendulum():
    pendulum = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    return pendulum.motion(q={"theta": 0}, velocity={"theta": 5}), 300.0


def thrown_out_of_its_domain():
    return hjsolve.solve(hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "x")).motion(q={"x": 1}, velocity={"x": 1}), 5.0


@pytest.mark.parametrize("make", [ellipse, rotating_pendulum, thrown_out_of_its_domain])
def test_blocks_change_no_bit(make):
    motion, reach = make()
    times = np.random.default_rng(7).uniform(-reach, reach, MANY)
    whole = motion.at(times)
    parts = [motion.at(times[begin : begin + FEW]) for begin in range(0, MANY, FEW)]
    parts[-1] = motion.at(times[-FEW:])
    for group in ("q", "p", "velocity", "turns"):
        for name, values in getattr(whole, group).items():
            first = np.concatenate([getattr(part, group)[name] for part in parts[:-1]])
            assert np.array_equal(values[: len(first)], first, equal_nan=True), (group, name)
            assert np.array_equal(values[-FEW:], getattr(parts[-1], group)[name], equal_nan=True), (group, name)
    assert list(whole.status[-FEW:]) == list(parts[-1].status)


def test_what_has_ended_is_told_among_many():
    motion, _ = thrown_out_of_its_domain()
    times = np.linspace(-4, 4, MANY)
    state = motion.at(times)
    end, begin = 1 + np.sqrt(3), 1 - np.sqrt(3)
    inside = (times > begin) & (times < end)
    assert np.array_equal(state.status == "ok", inside)
    assert set(state.status[~inside]) == {"reaches_boundary"}
    assert np.array_equal(np.isnan(state.q["x"]), ~inside)
    exact = 1 + times - times**2 / 2
    assert np.all(np.abs(state.q["x"] - exact)[inside] <= state.error.q["x"][inside])


def test_one_time_too_long_among_many_is_refused():
    motion, _ = ellipse()
    for far in (1e291, 1e20):
        times = np.linspace(0, 1, MANY)
        times[MANY // 2] = far
        with pytest.raises(InvalidInputError, match="t: "):
            motion.at(times)


@pytest.mark.rotating(3)
@pytest.mark.parametrize("name", entries.separable())
def test_states_at_many_times_are_those_at_one_over_the_catalog(name):
    # ten systems with a moving support did not end: a place waited for an angle that asked for all places
    motion = entries.motion(name)
    times = np.linspace(0, 7, 3000)
    many = motion.at(times)
    for k in (5, 1234, 2900):
        one = motion.at(float(times[k]))
        for group in ("q", "p"):
            for key in one.q:
                here, there = (np.ravel(getattr(many, group)[key])[k], float(getattr(one, group)[key]))
                if np.isnan(here) and np.isnan(there):
                    continue
                claim = np.ravel(getattr(many.error, group)[key])[k] + float(getattr(one.error, group)[key])
                off = abs(here - there)
                turn = (
                    2 * np.pi if group == "q" and motion.solution.system.coordinate(key).domain.kind == "angle" else 0
                )
                assert min(off, abs(off - turn)) <= claim + 1e-15 * turn, (group, key)


@pytest.mark.parametrize("digits", [15, 30])
@pytest.mark.parametrize("times", [100, [1, 100], [100, 200], np.linspace(90, 200, 3000)], ids=len_of)
def test_after_the_end_of_a_motion_all_is_nan_with_its_error(digits, times):
    # with 30 digits the errors of a velocity ended in an AttributeError of a float
    if digits > 15 and np.size(times) > 2:
        times = times[::300]
    solution = hjsolve.solve(hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "x"))
    state = solution.motion(q={"x": 1}, velocity={"x": 1}, digits=digits).at(times)
    for group in ("q", "p", "velocity"):
        for numbers in (getattr(state, group), getattr(state.error, group)):
            assert np.isnan(float(np.ravel(numbers["x"])[-1])), group
    assert np.ravel(state.status)[-1] == "reaches_boundary"
