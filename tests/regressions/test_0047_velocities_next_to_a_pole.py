"""Next to a pole of the coordinates: velocities from distances and differences that do not cancel."""

import random

import mpmath
import numpy as np
import pytest

from tests.support import entries

TOP = entries.solution("lagrange-top")


def sleeping(tilt, seed):
    """A top that stands nearly upright (the pole is at π/2), its tilt given exactly."""
    draw = random.Random(f"{tilt} {seed}")
    tilt, spin = mpmath.mpf(tilt), mpmath.mpf(draw.uniform(2.2, 4))
    with mpmath.workdps(60):
        place = {"psi": "0.1", "theta": mpmath.pi / 2 - tilt, "phi": "0.2"}
        return {
            "q": place,
            "p": {"phi": spin, "theta": tilt * draw.uniform(-1, 1), "psi": -spin * (1 + tilt**2 * draw.uniform(-1, 1))},
        }


def compared(start, times, digits=40):
    """Relative errors of the velocities, and the errors claimed over the true ones."""
    motion, exact = TOP.motion(**start), TOP.motion(**start, digits=digits)
    some = times if len(times) < 10 else times[:: len(times) // 4]
    states, truth = motion.at(times), exact.at(some)
    step = max(1, len(times) // len(some)) if len(times) >= 10 else 1
    worst = 0.0
    for name in ("psi", "phi"):
        values, claims = states.velocity[name][::step], states.error.velocity[name][::step]
        for value, claim, true in zip(values, claims, truth.velocity[name], strict=True):
            off = abs(mpmath.mpf(float(value)) - true)
            assert off <= claim
            assert claim <= 1e-12 * abs(true)
            worst = max(worst, float(off / abs(true)))
    return worst


@pytest.mark.nightly_cases("1e-7")
@pytest.mark.parametrize("tilt", ["1e-2", "1e-4", "1e-6", "1e-7"])
def test_the_precession_of_a_sleeping_top_has_all_digits(tilt):
    """It had ten of them at 1e-6."""
    assert compared(sleeping(tilt, 1), [0.1, 0.5, 3.0, 17.0]) < 1e-13


@pytest.mark.nightly_cases("1e-7")
@pytest.mark.parametrize("tilt", ["1e-7", pytest.param("1e-9", marks=pytest.mark.nightly)])
def test_what_doubles_cannot_tell_is_not_divided_into_ever_smaller_cells_of_doubles(tilt, monkeypatch):
    """All enclosures of p² in doubles were rounding: 2000 divisions, 40 s, and then it was refused."""
    monkeypatch.setattr("hjsolve.one_coordinate.turning_points._MOST_WORK", 400)
    motion = TOP.motion(**sleeping(tilt, 1))
    exact = TOP.motion(**sleeping(tilt, 1), digits=40)
    for one, other in zip(motion.turning_points["theta"], exact.turning_points["theta"], strict=True):
        assert abs(mpmath.mpf(one.value) - other.value) <= one.error + other.error


@pytest.mark.parametrize("tilt", ["1e-3", "1e-6"])
def test_so_it_has_at_many_times(tilt):
    assert compared(sleeping(tilt, 2), list(np.linspace(0, 20, 4 * 600))) < 1e-13


def test_a_velocity_that_does_not_cancel_is_left_as_it_was():
    from hjsolve.motion.near_poles import badly_rounded

    motion = entries.motion("kepler-planar")
    state = motion.at([0.1, 2.0, 5.0])
    assert not badly_rounded(motion.separated, state.q, state.p).any()


def test_two_doubles_give_the_same_velocities_as_one_where_nothing_cancels():
    """At every phase of an ordinary top, by the rule for poles and without it."""
    from hjsolve.motion.near_poles import sharpened_velocities
    from hjsolve.motion.phases import coordinate_motions_of, phases_at

    start = {"q": {"psi": 0, "theta": "0.3", "phi": 0}, "p": {"psi": "0.4", "theta": "0.2", "phi": 2}}
    motion, times = TOP.motion(**start), np.linspace(0, 9, 40)
    state, phases = motion.at(times), phases_at(motion.separated, times, [])
    everywhere = np.ones(len(times), dtype=bool)
    sharp = sharpened_velocities(
        motion.separated, coordinate_motions_of(motion.separated, phases), phases.χ, state.q, state.velocity, everywhere
    )
    for name, values in sharp.items():
        assert np.all(np.abs(values - state.velocity[name]) <= 2 * state.error.velocity[name])
