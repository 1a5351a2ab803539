"""States in 30 digits at many times: all of them refined at once, with errors that hold against 50 digits."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.time_law import refine
from tests.support import entries

PICKED = [0, 1, 250, 617, 999]


def held(name: str, many: int = 1000, widest: float = 1e-27) -> None:
    """Claims hold against 50 digits, and are no wider than ``widest`` of 1 or the largest value there is."""
    given = {k: v for k, v in entries.given(name).items() if k != "digits"}
    solution = entries.solved(name)
    motion = solution.motion(**given, digits=30)
    if motion.separated.torus is None:
        return
    times = np.linspace(0, max(float(period.value) for period in motion.periods.values()), many)
    picked = [k for k in PICKED if k < many]
    states, truth = motion.at(times), solution.motion(**given, digits=50).at(times[picked])
    with mp.workdps(70):
        for group in ("q", "p", "velocity"):
            for coordinate, values in getattr(states, group).items():
                errors = getattr(states.error, group)[coordinate]
                largest = max(map(abs, values))
                for true, k in zip(getattr(truth, group)[coordinate], picked, strict=True):
                    assert abs(mp.mpf(true) - mp.mpf(values[k])) <= errors[k], (name, group, coordinate, k)
                    assert errors[k] <= widest * max(1, largest)


@pytest.mark.parametrize("name", [pytest.param("kepler-planar", marks=pytest.mark.nightly), "pendulum"])
def test_errors_of_a_thousand_states_hold(name: str) -> None:
    held(name)


@pytest.mark.nightly
@pytest.mark.parametrize("name", entries.separable_with_effects())
def test_errors_of_many_states_hold_over_the_catalog(name: str) -> None:
    held(name, 300)


@pytest.mark.nightly
def test_steps_at_all_times_at_once_leave_few_to_newtons_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 000 states of Kepler took 15 s: every one had four steps with slopes in many digits, a series at a time."""
    singly = []
    alone = refine._alone
    monkeypatch.setattr(refine, "_alone", lambda *given: singly.append(1) or alone(*given))
    held("kepler-planar")
    assert not singly


def test_next_to_a_separatrix_newtons_method_takes_over() -> None:
    solution = entries.solved("pendulum")
    near = solution.motion(q={"theta": 0}, velocity={"theta": "1.9999999999999999999"}, digits=30)
    times = np.linspace(0, float(near.periods["theta"].value), 20)
    better = solution.motion(q={"theta": 0}, velocity={"theta": "1.9999999999999999999"}, digits=50).at(times)
    states = near.at(times)
    with mp.workdps(70):
        for value, true, error in zip(states.q["theta"], better.q["theta"], states.error.q["theta"], strict=True):
            assert abs(mp.mpf(value) - mp.mpf(true)) <= error


def test_series_in_fixed_point_are_the_series() -> None:
    context = multiprecision(200)
    cosines = np.array([context.mpf(3) / 7**k for k in range(1, 40)], dtype=object)
    sines = np.array([context.mpf(-2) / 5**k for k in range(1, 40)], dtype=object)
    series = FourierSeries(context.mpf(1) / 3, cosines, sines, 80, 0)
    places = np.array([context.mpf(x) for x in ("0", "1e-30", "0.7", "-3.1", "200.25")], dtype=object)
    for together, one in ((series.value(places), series.value), (series.oscillation(places), series.oscillation)):
        for x, found in zip(places, together, strict=True):
            assert abs(found - one(x)) <= context.mpf(2) ** -194
