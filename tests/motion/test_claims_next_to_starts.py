"""W, t(q) and actions that start next to a turning point or a separatrix, in doubles: their claims against 50 digits."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve
from hjsolve.motion.motion import Motion

exact = mpmath.MPContext()
exact.dps = 60


NEXT_TO_THE_SEPARATRIX = {"q": {"x": 3.141592653589387}, "velocity": {"x": -4.284176617371155e-13}}


def both(system: hjsolve.System | str, **start: object) -> tuple[Motion, Motion]:
    solution = hjsolve.solve(system)
    return solution.motion(**start), solution.motion(**start, digits=50)


def rotation_action(energy: object) -> object:
    """J of a pendulum above the separatrix; E(m) by DLMF 19.25.1, mpmath's own is wrong by 1e-44 at 60 digits here."""
    less = (energy - 1) / (energy + 1)
    e = less * (exact.elliprd(0, less, 1) + exact.elliprd(0, 1, less)) / 3
    return 4 * exact.sqrt((1 + energy) / 2) * e / exact.pi


def holds(found: object, truth: object) -> bool:
    return bool(abs(exact.mpf(found.value) - exact.mpf(truth.value)) <= exact.mpf(found.error))


@pytest.mark.parametrize(
    ("r", "rate", "place"),
    [
        (1.309426172674668, 2.0609005237790997e-05, 1.3094263487706155),
        (1.7563669634938592, -2.45766465998154e-11, 1.757048721878829),
    ],
)
def test_t_of_q_of_an_escape_holds_the_rounding_of_its_panel(r: float, rate: float, place: float) -> None:
    start = {"q": {"r": r, "theta": 0}, "velocity": {"r": rate, "theta": 1.5}}
    found, truth = both("kepler-planar", **start)
    assert found.kinds["r"] == "escape"
    assert holds(found.time_at("r", place), truth.time_at("r", place))


@pytest.mark.nightly
def test_the_action_of_a_rotation_next_to_the_separatrix_is_resolved() -> None:
    pendulum = hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    found = hjsolve.solve(pendulum).motion(**NEXT_TO_THE_SEPARATRIX)
    assert found.kinds == {"x": "rotation"}
    energy = exact.mpf(-4.284176617371155e-13) ** 2 / 2 - exact.cos(exact.mpf(3.141592653589387))
    action = rotation_action(energy)
    assert abs(abs(exact.mpf(found.actions["x"].value)) - action) <= found.actions["x"].error < 1e-15  # 1.269… came


@pytest.mark.nightly
def test_w_of_a_rotation_next_to_the_separatrix_is_resolved() -> None:
    found, truth = both(hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)"), **NEXT_TO_THE_SEPARATRIX)
    many = truth.actions["x"]
    energy = exact.mpf(-4.284176617371155e-13) ** 2 / 2 - exact.cos(exact.mpf(3.141592653589387))
    assert abs(abs(exact.mpf(many.value)) - rotation_action(energy)) <= exact.mpf(many.error) < 1e-49
    for t in (1e-3, 0.94, 5.0):
        assert holds(found.characteristic_function(t), truth.characteristic_function(t))


@pytest.mark.nightly
@pytest.mark.parametrize("digits", [30, 50])
@pytest.mark.parametrize("distance", [3, 7, 12, 19, 26, 33, 40])
def test_rotations_at_any_distance_from_the_separatrix(distance: int, digits: int) -> None:
    with exact.workdps(120):
        energy = 1 + exact.mpf(10) ** -distance
        rate = exact.nstr(exact.sqrt(2 * (energy + 1)), 110)
        energy = exact.mpf(rate) ** 2 / 2 - 1
        action, less = rotation_action(energy), (energy - 1) / (energy + 1)
        frequency = exact.pi / (exact.sqrt(2 / (energy + 1)) * exact.ellipk(1 - less))
        pendulum = hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
        motion = hjsolve.solve(pendulum).motion(q={"x": 0}, velocity={"x": rate}, digits=digits)
        for found, truth in ((motion.actions["x"], action), (motion.frequencies["x"], frequency)):
            assert abs(exact.mpf(found.value) - truth) <= exact.mpf(found.error) < 10 * exact.mpf(10) ** -digits
