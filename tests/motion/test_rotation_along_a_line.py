"""A periodic V on a line: over its barriers a motion is a rotation, and x runs on."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from hjsolve import System, solve
from hjsolve.errors import OutsideMotionError
from hjsolve.motion.motion import Motion


def moving(potential: str, x: str, velocity: str, digits: int = 15, **parameters: object) -> Motion:
    system = System({"x": "line"}, "dot(x)**2/2", potential, parameters=parameters)
    return solve(system).motion(q={"x": x}, velocity={"x": velocity}, digits=digits)


def pendulum(x: mpf, velocity: mpf, t: mpf) -> mpf:
    """x(t) of V = −cos x over the barrier: x/2 = am((t + t₁)/k, k²), k² = 4/(v² + 4 sin²(x/2))."""
    m = 4 / (velocity**2 + 4 * mp.sin(x / 2) ** 2)
    k, sign = mp.sqrt(m), 1 if velocity > 0 else -1
    u = mp.ellipf(sign * x / 2, m) + t / k
    period = 2 * mp.ellipk(m)
    turns = mp.nint(u / period)
    rest = u - turns * period
    angle = mp.atan2(mp.ellipfun("sn", rest, m=m), mp.ellipfun("cn", rest, m=m))
    return sign * 2 * (angle + mp.pi * turns)


@pytest.mark.parametrize(("x", "velocity"), [("3.1416", "1.5"), ("-9.4247", "-0.01"), ("100.5309", "-2.5"), ("1", "9")])
def test_the_state_is_that_of_the_pendulum_wherever_the_motion_starts(x: str, velocity: str) -> None:
    motion = moving("-cos(x)", x, velocity)
    assert motion.kinds["x"] == "rotation"
    with mp.workdps(50):
        start, v = mpf(x), mpf(velocity)
        m = 4 / (v**2 + 4 * mp.sin(start / 2) ** 2)
        period = motion.periods["x"]
        assert abs(period.value - 2 * mp.sqrt(m) * mp.ellipk(m)) <= period.error
        times = np.array([-7.0, 0.0, 0.5, 20.0])
        together = motion.at(times)
        for k, t in enumerate(times):
            state, truth = motion.at(float(t)), pendulum(start, v, mpf(t))
            assert abs(state.q["x"] - truth) <= state.error.q["x"] <= 1e-11
            assert abs(together.q["x"][k] - truth) <= together.error.q["x"][k] <= 1e-11


def test_thirty_digits_run_on_as_well() -> None:
    state = moving("-cos(x)", "22", "2.25", digits=30).at("1000")
    with mp.workdps(50):
        assert abs(state.q["x"] - pendulum(mpf(22), mpf("2.25"), mpf(1000))) <= state.error.q["x"] <= mpf(10) ** -24


def test_a_place_on_the_line_is_passed_once() -> None:
    motion = moving("-cos(x)", "3.1416", "-1.5")
    assert abs(motion.time_at("x", motion.at(12.0).q["x"]).value - 12) < 1e-13
    assert abs(motion.time_at("x", motion.at(-12.0).q["x"], -1).value + 12) < 1e-13
    with pytest.raises(OutsideMotionError):
        motion.time_at("x", 20)
    with pytest.raises(OutsideMotionError):
        motion.time_at("x", -20, 1)


def test_any_period_given_by_letters_is_seen() -> None:
    """In u = 2x and τ = 2t the lattice cos(2 a x/3), a = 3, is the pendulum: d²u/dτ² = −sin u, du/dτ = dx/dt."""
    motion = moving("-k*cos(2*a*x/3)", "100.1", "-2.5", k=1, a=3)
    assert motion.kinds["x"] == "rotation"
    with mp.workdps(50):
        truth = pendulum(mpf("200.2"), mpf("-2.5"), mpf(100)) / 2
        state = motion.at(50.0)
        assert abs(state.q["x"] - truth) <= state.error.q["x"] <= 1e-12


def test_sines_that_are_not_commensurate_or_a_slope_are_no_rotation() -> None:
    for potential in ("cos(x)/9 + cos(sqrt(2)*x)/9", "cos(x)/9 - x"):
        assert moving(potential, "1", "2", digits=15).kinds["x"] == "escape"


def test_two_lattices_keep_their_own_time() -> None:
    system = System({"x": "line", "y": "line"}, "(dot(x)**2+dot(y)**2)/2", "-cos(x) - cos(3*y)")
    motion = solve(system).motion(q={"x": "3.1416", "y": "0"}, velocity={"x": "1.5", "y": "2.1"})
    assert set(motion.kinds.values()) == {"rotation"}
    state = motion.at(5.0)
    with mp.workdps(50):
        for name, truth in (
            ("x", pendulum(mpf("3.1416"), mpf("1.5"), mpf(5))),
            ("y", pendulum(mpf(0), mpf("2.1"), mpf(15)) / 3),
        ):
            assert abs(state.q[name] - truth) <= state.error.q[name] <= 1e-12
