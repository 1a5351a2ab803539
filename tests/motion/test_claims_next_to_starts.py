"""W, t(q) and actions that start next to a turning point or a separatrix, in doubles: their claims against 50 digits."""

from __future__ import annotations

import mpmath
import pytest

import hjsolve
from hjsolve.motion.motion import Motion

exact = mpmath.MPContext()
exact.dps = 60


def both(system: hjsolve.System | str, **start: object) -> tuple[Motion, Motion]:
    solution = hjsolve.solve(system)
    return solution.motion(**start), solution.motion(**start, digits=50)


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


def test_the_action_of_a_rotation_next_to_the_separatrix_is_resolved() -> None:
    pendulum = hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    found, truth = both(pendulum, q={"x": 3.141592653589387}, velocity={"x": -4.284176617371155e-13})
    assert found.kinds == {"x": "rotation"}
    energy = exact.mpf(-4.284176617371155e-13) ** 2 / 2 - exact.cos(exact.mpf(3.141592653589387))
    action = 4 * exact.sqrt((1 + energy) / 2) * exact.ellipe(2 / (1 + energy)) / exact.pi
    assert abs(abs(exact.mpf(found.actions["x"].value)) - action) <= found.actions["x"].error < 1e-15  # 1.269… came
    for t in (1e-3, 0.94, 5.0):
        assert holds(found.characteristic_function(t), truth.characteristic_function(t))
