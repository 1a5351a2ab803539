"""Whatever made a motion, it answers the same questions."""

import pytest

import hjsolve

MOTIONS = {
    "T + V": lambda: hjsolve.solve("pendulum").motion(q={"theta": "0.1"}, p={"theta": "0.2"}),
    "moving frame": lambda: hjsolve.frames.load("spring-moving-anchor").motion(q={"q": "0.3"}, velocity={"q": "0.4"}),
    "linear modes": lambda: hjsolve.gyroscopic_modes("gyroscopic-three").motion(
        q={"q1": 1, "q2": 0, "q3": 0}, velocity={"q1": 0, "q2": 0, "q3": 0}
    ),
    "p⁴ + q²": lambda: hjsolve.from_hamiltonian("p**4 + q**2", {"q": "line"}).motion(q={"q": 1}, p={"q": 0}),
    "q p": lambda: hjsolve.from_hamiltonian("q*p", {"q": "line"}).motion(q={"q": 1}, p={"q": 1}),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_every_kind_of_motion_answers_at_kinds_and_constants(name):
    motion = MOTIONS[name]()
    assert isinstance(motion, hjsolve.AnyMotion)
    state = motion.at([0.0, 0.5])
    assert isinstance(state, hjsolve.State)
    assert list(state.status) == ["ok", "ok"]
    assert state.q.keys() == state.p.keys() == state.velocity.keys() == state.error.q.keys()
    assert all(isinstance(constant, hjsolve.Estimate) for constant in motion.constants.values())
    assert set(motion.kinds.values()) <= {
        "libration",
        "rotation",
        "escape",
        "equilibrium",
        "ignorable",
        "boundary",
        "asymptotic",
    }
