"""Two places of coupled coordinates: close encounters are found, and the flow of the search is that of the motion."""

from functools import cache

import numpy as np
import pytest

import hjsolve
from hjsolve.two_point.asked.question import read_question
from hjsolve.two_point.search.flow import RegularFlow

PLANE = {"x": "line", "y": "line"}
POTENTIALS = {
    "Stark": "-1/sqrt(x**2 + y**2) - x/20",
    "two centres": "-1/sqrt((x - 1)**2 + y**2) - 1/(2*sqrt((x + 1)**2 + y**2))",
}


@cache
def solved(name):
    return hjsolve.solve(hjsolve.System(PLANE, "(dot(x)**2 + dot(y)**2)/2", POTENTIALS[name]), coordinates="find")


def joined(name, q0, velocity, time):
    """Motions to where a known one leads, and that one."""
    known = solved(name).motion(q=q0, velocity=velocity)
    q1 = {c: float(x) for c, x in known.at(time).q.items()}
    return known, solved(name).two_point(q0=q0, q1=q1, time=time, turns=range(4))


def has(found, known):
    p0 = known.at(0).p
    return any(all(abs(c.p0[n].value - float(p0[n])) < 1e-8 for n in p0) for c in found)


def test_a_fall_past_the_centre_at_a_distance_of_a_ten_thousandth_is_found():
    q0, velocity = {"x": 1.033223, "y": 1.03968}, {"x": -0.125979, "y": -0.072499}
    known, found = joined("Stark", q0, velocity, 2.907465)
    distance = np.hypot(*(known.at(np.linspace(1.5, 2.9, 20001)).q[c] for c in "xy"))
    assert 5e-5 < distance.min() < 1.5e-4
    assert has(found, known)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "q0", "velocity", "time", "least"),
    [
        ("Stark", {"x": -0.315245, "y": 0.658882}, {"x": -0.138655, "y": 0.033}, 4.62647, 14),
        ("Stark", {"x": -0.97253, "y": 0.609785}, {"x": 0.144257, "y": -0.191411}, 4.489468, 8),
        ("two centres", {"x": 0.064274, "y": 0.673798}, {"x": -1.112021, "y": -0.377605}, 4.065017, 7),
    ],
)
def test_motions_with_several_close_encounters_are_found_and_each_ends_at_q1(name, q0, velocity, time, least):
    known, found = joined(name, q0, velocity, time)
    assert has(found, known)
    assert len(found) >= least
    for c in found:
        end = c.motion.at(time)
        for n, x in known.at(time).q.items():
            assert abs(float(end.q[n]) - float(x)) < 1e-12
            assert abs(float(end.p[n]) - c.p1[n].value) <= c.p1[n].error + float(end.error.p[n])
        assert abs(c.motion.principal_function(time).value - c.principal_function.value) < 1e-10


@pytest.mark.parametrize("name", sorted(POTENTIALS))
def test_the_flow_of_the_search_has_the_end_and_the_derivatives_of_the_motion(name):
    solution, velocity = solved(name), {"x": -0.125979, "y": 0.272499}
    asked = {"q0": {"x": 0.3, "y": 0.4}, "q1": {"x": 1, "y": 1}, "time": 2.5, "turns": 0}
    question, values = read_question(solution, parameters=None, digits=15, **asked)
    p0 = np.array([[velocity["x"]], [velocity["y"]]])
    flow = RegularFlow(question, values).run(p0, tolerance=1e-13, parts=(2, 4, 6, 8, 10, 12))
    motion = solution.motion(q=asked["q0"], velocity=velocity)
    assert flow.reached[0]
    np.testing.assert_allclose(flow.q[:, 0], [float(motion.at(2.5).q[c]) for c in "xy"], rtol=1e-10, atol=0)
    matrix = np.array(motion.transition_matrix(2.5).value, dtype=float)
    np.testing.assert_allclose(flow.position_by_momentum[0], matrix[:2, 2:], rtol=1e-7, atol=0)
