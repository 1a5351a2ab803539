"""H(q, p) of one degree of freedom: P5-1, H = q + p, and its neighbours."""

from __future__ import annotations

import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve.errors import InvalidInputError, InvalidSystemError, OutsideMotionError
from hjsolve.extended.linear_hamiltonian import LinearHamiltonian, from_hamiltonian
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.solution.quadratures import solve


def test_the_books_problem_5_1() -> None:
    """C74: S = −αt + αq − q²/2, q = t − β, p = α − q."""
    problem = from_hamiltonian("q + p", {"q": "line"})
    assert isinstance(problem, LinearHamiltonian)
    α, q, t = sp.Symbol("E", real=True), problem.coordinate.symbol, sp.Symbol("t", real=True)
    assert sp.expand(problem.principal_function - (-α * t + α * q - q**2 / 2)) == 0
    assert problem.time_law == q
    assert problem.momentum == α - q
    place, momentum = problem.at("2.5", q="0.5", p="1", digits=30)
    assert abs(place - 3) < mpf(10) ** -30
    assert abs(momentum + mpf(3) / 2) < mpf(10) ** -30


def test_s_solves_the_hamilton_jacobi_equation() -> None:
    problem = from_hamiltonian("(1 + q**2)*p + w*q", {"q": "line"}, {"w": "1/3"})
    S, q, t = problem.principal_function, problem.coordinate.symbol, sp.Symbol("t", real=True)
    residual = sp.diff(S, t) + problem.hamiltonian.subs(problem.coordinate.momentum, sp.diff(S, q))
    assert sp.simplify(residual) == 0


@pytest.mark.nightly
def test_a_rate_that_depends_on_q_is_integrated_and_inverted() -> None:
    """q̇ = 1 + q²: q = tan t, and infinity is reached at π/2."""
    problem = from_hamiltonian("(1 + q**2)*p", {"q": "line"})
    with mp.workdps(40):
        place, momentum = problem.at("1.2", q=0, p=1, digits=30)
        assert abs(place - mp.tan(mpf("1.2"))) < mpf(10) ** -28
        assert abs(momentum - mp.cos(mpf("1.2")) ** 2) < mpf(10) ** -28
        back, _ = problem.at("-1.2", q=0, p=1, digits=30)
        assert abs(back + mp.tan(mpf("1.2"))) < mpf(10) ** -28
    with pytest.raises(OutsideMotionError, match="infinity"):
        problem.at(2, q=0, p=1)


def test_where_the_rate_vanishes_q_rests_and_p_does_not() -> None:
    """H = a(q) p + b(q) with a(q0) = 0: dp/dt = -a'(q0) p - b'(q0)."""
    with mp.workdps(40):
        for text, expected in (
            ("q*p", mp.exp(-1)), ("q*p + 3*q", 4 * mp.exp(-1) - 3), ("q**2*p + q", mpf(0)), ("-q*p", mp.e),
        ):  # fmt: skip
            problem = from_hamiltonian(text, {"q": "line"})
            assert isinstance(problem, LinearHamiltonian)
            motion = problem.motion(q={"q": 0}, p={"q": 1}, digits=30)
            state = motion.at(1)
            assert motion.kinds == {"q": "equilibrium"}
            assert (state.q["q"], state.velocity["q"], state.status) == (0, 0, "ok")
            assert abs(state.p["q"] - expected) < mpf(10) ** -30


def test_states_carry_errors_and_the_motion_ends_at_its_domain() -> None:
    """H = p*sqrt(1 + q): q = (t + 2)^2/4 - 1 from q = 0; p = E/sqrt(1 + q)."""
    problem = from_hamiltonian("w*p*sqrt(1 + q)", {"q": "-1 < q < 3"}, {"w": None})
    assert isinstance(problem, LinearHamiltonian)
    motion = problem.motion(q={"q": 0}, p={"q": "0.3"}, parameters={"w": 1}, t0="0.5")
    sharp = problem.motion(q={"q": 0}, p={"q": "0.3"}, parameters={"w": 1}, t0="0.5", digits=30)
    state = motion.at([0.5, 1.0, 2.0, 3.0])
    with mp.workdps(40):
        for k, t in enumerate((0.5, 1.0, 2.0)):
            q = (mpf(t) + mpf("1.5")) ** 2 / 4 - 1
            p = mpf("0.3") / mp.sqrt(1 + q)
            assert abs(mpf(float(state.q["q"][k])) - q) <= state.error.q["q"][k] < 1e-14
            assert abs(mpf(float(state.p["q"][k])) - p) <= state.error.p["q"][k] < 1e-14
            assert abs(mpf(float(state.velocity["q"][k])) - mp.sqrt(1 + q)) <= state.error.velocity["q"][k] < 1e-14
            assert abs(sharp.at(t).q["q"] - q) <= sharp.at(t).error.q["q"] < 1e-29
    assert list(state.status) == ["ok", "ok", "ok", "reaches_boundary"]
    assert state.q["q"][3] != state.q["q"][3]
    assert abs(motion.constants["E"].value - 0.3) <= motion.constants["E"].error
    for given, error in (
        ({"q": {"q": 5}, "p": {"q": 1}, "parameters": {"w": 1}}, "not inside the domain"),
        ({"q": {"q": 1}, "velocity": {"q": 1}, "parameters": {"w": 1}}, "says nothing about p"),
        ({"q": {"x": 1}, "p": {"q": 1}, "parameters": {"w": 1}}, "'x' is not a coordinate of this system; it has q"),
        ({"q": {"q": 1}, "p": {"q": 1}}, "no value for w"),
    ):
        with pytest.raises(InvalidInputError, match=error):
            problem.motion(**given)  # type: ignore[arg-type]


def test_a_quadratic_hamiltonian_is_a_natural_system() -> None:
    system = from_hamiltonian("p**2/(2*m) + w*q*p + k*q**2/2", {"q": "line"}, {"m": 1, "w": "0.1", "k": 1})
    assert isinstance(system, System)
    q = system.coordinate("q")
    m, w, k = (system.symbols[n] for n in "mwk")
    given = q.momentum**2 / (2 * m) + w * q.symbol * q.momentum + k * q.symbol**2 / 2
    assert sp.simplify(hamiltonian(system) - given) == 0
    period = solve(system).motion(q={"q": 1}, p={"q": 0}).periods["q"].value
    assert abs(period - 2 * float(mp.pi) / (1 - 0.01) ** 0.5) < 1e-14


@pytest.mark.parametrize(("text", "coordinates", "why"), [
    ("q", {"q": "line"}, "does not contain p"), ("p**4 + q**2", {"q": "angle"}, "period"),
    ("p", {"q": "line", "r": "line"}, "the momenta are p_q, p_r, not p"), ("p", {"p": "line"}, "rename"),
])  # fmt: skip
def test_other_hamiltonians_are_refused(text: str, coordinates: dict[str, str], why: str) -> None:
    with pytest.raises(InvalidSystemError, match=why):
        from_hamiltonian(text, coordinates)
