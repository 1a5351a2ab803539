"""Surfaces of section against closed forms, against an integrator of another kind, and by what they conserve."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve
from hjsolve.motion.initial_data import read_phase_point
from hjsolve.scenes.extrapolated_flow import ORDER, extrapolated
from hjsolve.scenes.surface_of_section import PlaneMotion, plane_motion, returns, surface_of_section


def plane(system: hjsolve.System, **initial: dict[str, str]) -> PlaneMotion:
    values = read_phase_point(system, initial["q"], initial.get("velocity"), initial.get("p"), None)
    found = plane_motion(system, values)
    assert found is not None
    return found


def line(potential: str) -> hjsolve.System:
    return hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="(dot(x)**2 + dot(y)**2)/2", potential=potential
    )


HENON_HEILES = line("(x**2 + y**2)/2 + x**2*y - y**3/3")


def test_the_order_of_a_step_is_the_one_it_claims() -> None:
    def turning(state: np.ndarray) -> np.ndarray:
        return np.array([state[1], -state[0]])

    errors = []
    for step in (1.6, 0.8):
        after, claimed = extrapolated(turning, np.array([[1.0], [0.0]]), np.array([step]))
        true = np.abs(after[:, 0] - [np.cos(step), -np.sin(step)]).max()
        assert true <= claimed.max()
        errors.append(true)
    assert np.log2(errors[0] / errors[1]) > ORDER - 1


def test_returns_of_two_oscillators_are_those_of_the_cosine() -> None:
    motion = plane(line("(x**2 + 2*y**2)/2"), q={"x": "0", "y": "1"}, velocity={"x": "1", "y": "0"})
    found = returns(motion, motion.start[:, None], 0, 0.0, 40, np.full(1, 1e-13))[:, 0]
    phase = np.sqrt(2) * 2 * np.pi * np.arange(1, 41)  # x = sin t passes 0 upwards once in 2π
    np.testing.assert_allclose(found[0], 0, rtol=0, atol=2e-11)
    np.testing.assert_allclose(found[1], np.cos(phase), rtol=0, atol=2e-10)
    np.testing.assert_allclose(found[3], -np.sqrt(2) * np.sin(phase), rtol=0, atol=2e-10)


def test_a_crossing_between_two_steps_below_the_section_is_not_lost() -> None:
    level = 0.9999  # which x = sin t is above for a hundredth of its period only
    motion = plane(line("(x**2 + 2*y**2)/2"), q={"x": "0", "y": "1"}, velocity={"x": "1", "y": "0"})
    found = returns(motion, motion.start[:, None], 0, level, 10, np.full(1, 1e-13))[:, 0]
    times = np.arcsin(level) + 2 * np.pi * np.arange(10)
    np.testing.assert_allclose(found[1], np.cos(np.sqrt(2) * times), rtol=0, atol=2e-9)


def test_returns_are_those_of_another_integrator() -> None:
    integrate = pytest.importorskip("scipy.integrate")
    motion = plane(HENON_HEILES, q={"x": "0.1", "y": "0.2"}, velocity={"x": "0.3", "y": "0"})

    def upwards(_: float, state: np.ndarray) -> float:
        return float(state[0])

    upwards.direction = 1  # type: ignore[attr-defined]
    run = integrate.solve_ivp(
        lambda _, s: [s[2], s[3], -s[0] - 2 * s[0] * s[1], -s[1] - s[0] ** 2 + s[1] ** 2],
        (0, 80), motion.start, method="DOP853", rtol=1e-13, atol=1e-15, events=upwards,
    )  # fmt: skip
    twin = run.y_events[0].T
    found = returns(motion, motion.start[:, None], 0, 0.0, twin.shape[1], np.full(1, 1e-13))[:, 0]
    assert twin.shape[1] >= 10
    np.testing.assert_allclose(found, twin, rtol=0, atol=1e-9)


@pytest.mark.nightly
def test_a_section_keeps_its_energy_and_says_how_far_its_points_can_be_trusted() -> None:
    regular = plane(HENON_HEILES, q={"x": "0.1", "y": "0.2"}, velocity={"x": "0.3", "y": "0"})
    chaotic = plane(HENON_HEILES, q={"x": "0", "y": "-0.15"}, velocity={"x": "0.54", "y": "0"})  # E = 0.158, near 1/6
    sections = [surface_of_section(p) for p in (regular, chaotic)]
    fractions = []
    for one in sections:
        assert one is not None
        seen = np.isfinite(one.points[0])
        y, p = one.points[:, seen]
        assert one.drift < 1e-11
        assert seen.sum() > 500
        assert (p**2 / 2 + y**2 / 2 - y**3 / 3 <= one.energy + 1e-10).all()  # x = 0: what is left is ẋ²/2
        fractions.append(np.minimum(one.settled, seen.sum(axis=1)).sum() / seen.sum())
    assert fractions[0] == 1
    assert fractions[1] < 1


def test_where_more_than_two_coordinates_are_left_there_is_no_plane() -> None:
    system = hjsolve.System(
        coordinates={"x": "line", "y": "line", "z": "line"}, kinetic="(dot(x)**2 + dot(y)**2 + dot(z)**2)/2",
        potential="x*y*z",
    )  # fmt: skip
    at = {"x": "1", "y": "1", "z": "1"}
    assert plane_motion(system, read_phase_point(system, at, at, None, None)) is None
