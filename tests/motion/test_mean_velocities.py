"""Mean velocities of ignorable coordinates: drifts, and dt/dτ of geodesics, against closed forms and long flights."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from tests.reference.kerr import by_quadrature, from_turning_points
from tests.support import entries

MOVING = (
    "calogero-moser", "charge-in-uniform-field", "crossed-fields", "free-times-oscillator", "kerr", "pendulum-on-block",
    "rod-with-sliding-end", "schwarzschild", "relativistic-crossed-fields",
)  # fmt: skip


@pytest.mark.parametrize("digits", [15, 40])
def test_a_charge_drifts_by_the_ratio_of_the_fields(digits: int) -> None:
    solution = entries.solution("crossed-fields")
    given = {"q": {"x": 0, "y": 0, "z": 0}, "velocity": {"x": 0, "y": "0.3", "z": "0.4"}}
    motion = solution.motion(**given, parameters={"F": "1/7", "B": "3"}, digits=digits)
    found = motion.mean_velocities
    assert set(found) == {"x", "z"}
    with mp.workdps(60):
        for name, truth in (("x", mpf(1) / 21), ("z", mpf(2) / 5)):
            assert abs(mpf(found[name].value) - truth) <= mpf(found[name].error) <= truth * mpf(10) ** (1 - digits)


@pytest.mark.parametrize(("a", "p", "e", "x"), [("0.9", "6", "0.3", "0.7"), ("0.9", "12", "0.6", "-0.8")])
def test_what_a_far_observer_sees_of_a_black_hole(a: str, p: str, e: str, x: str) -> None:
    """dt/dτ, and frequencies divided by it, against quadratures at 32 digits (Fujita and Hikida 2009, section 3)."""
    with mp.workdps(32):
        orbit = from_turning_points(mpf(a), mpf(p), mpf(e), mpf(x))
        truth = by_quadrature(orbit)
        r = mpf(p)
        momenta = {"t": -orbit.E, "r": orbit.momentum(r), "theta": -mp.sqrt(orbit.Q), "phi": orbit.L}
        motion = entries.solution("kerr").motion(
            q={"t": "0", "r": p, "theta": "pi/2", "phi": "0"}, parameters={"a": a},
            p={name: mp.nstr(value, mp.dps) for name, value in momenta.items()}, want=["frequencies", "mean_velocities"],
        )  # fmt: skip
        rate = motion.mean_velocities["t"]
        assert abs(mpf(rate.value) - truth["t"] / truth["tau"]) <= rate.error <= 4e-16 * rate.value
        for name in ("r", "theta", "phi"):
            seen = mpf(motion.frequencies[name].value) / mpf(rate.value)
            assert abs(seen * truth["t"] / truth[name] - 1) <= 1e-15


@pytest.mark.parametrize("name", MOVING)
def test_it_is_where_the_coordinate_goes_in_the_long_run(name: str) -> None:
    """q(t) − q(t₀) − v (t − t₀) swings about for ever, and does not grow."""
    motion = entries.motion(name)
    periods = [e.value for e in motion.periods.values()] or [1.0]
    near = np.linspace(0.0, 60 * max(periods), 2001)
    far = near[1:] + 1e6 * max(periods)
    for coordinate, mean in motion.mean_velocities.items():
        assert abs(mean.value) > 0.01
        start = motion.at(0.0).q[coordinate]
        libration = np.ptp(motion.at(near).q[coordinate] - mean.value * near)
        later = motion.at(far).q[coordinate] - start - mean.value * far
        rounding = 4 * mean.error * far[-1] + 2.0**-51 * abs(mean.value) * far[-1]
        assert np.max(np.abs(later)) <= 1.05 * libration + rounding


def test_only_where_the_rest_is_bounded_and_time_was_asked() -> None:
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    assert kepler.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": 1}).mean_velocities == {}
    motion = entries.solution("kerr").motion(**entries.described("kerr").motions["default"].arguments, want="actions")
    with pytest.raises(hjsolve.InvalidInputError, match='add "mean_velocities" to want'):
        _ = motion.mean_velocities
