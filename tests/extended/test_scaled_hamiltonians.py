"""K(q, p, t) of any degree that does not hold the time in a scaled frame: P6-4, P6-5, and own ones against scipy."""

from __future__ import annotations

import pickle

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mp
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.motion.state import AnyMotion

FRAMES = {
    "scaled, degree 4": ("-q*p + (q**2*exp(2*t) + p**2*exp(-2*t))**2/8", "line", 1, 0, ("1", "1/2")),
    "moving": ("p**4 + (q + 3*t)**2 - 3*p", "line", 0, 3, ("1/2", "1/3")),
    "scaled and moving": ("p**4*exp(-4*c*t) + (q + t)**2*exp(2*c*t) - c*(q + t)*p - p", "line", "c", 1, ("1", "1/4")),
    "a root": ("sqrt(1 + p**2*exp(-t)) + q**2*exp(t) - q*p/2", "line", "1/2", 0, ("1", "0")),
}


@pytest.mark.parametrize("name", FRAMES)
def test_the_motion_of_k_is_that_of_hamiltons_equations(name: str) -> None:
    text, domain, a, v, (q0, p0) = FRAMES[name]
    problem = hjsolve.from_hamiltonian(text, {"q": domain}, {"c": "1/3"} if "c" in text else {})
    letters = {s.name: s for s in problem.hamiltonian.free_symbols}
    assert problem.frame.rate == sp.sympify(a, locals=letters)
    assert problem.frame.drift == v
    assert not problem.frame.hamiltonian.has(sp.Symbol("t", real=True))
    motion = problem.motion(q={"q": q0}, p={"q": p0}, t0="1/4")
    assert isinstance(motion, AnyMotion)
    q, p = problem.coordinate.symbol, problem.coordinate.momentum
    t = next(s for s in problem.hamiltonian.free_symbols if s.name == "t")
    K = problem.hamiltonian.subs({x.symbol: x.value for x in problem.parameters})
    rates = sp.lambdify((t, q, p), [sp.diff(K, p), -sp.diff(K, q)])
    start = [float(sp.Rational(x)) for x in (q0, p0)]
    twin = solve_ivp(lambda s, y: rates(s, *y), (0.25, 2.0), start, "DOP853", rtol=1e-12, atol=1e-13, t_eval=[1.0, 2.0])
    state = motion.at(np.array([1.0, 2.0]))
    assert np.allclose([state.q["q"], state.p["q"]], twin.y, rtol=1e-9, atol=1e-10)
    speeds = [rates(s, *y)[0] for s, y in zip((1.0, 2.0), twin.y.T, strict=True)]
    assert np.allclose(state.velocity["q"], speeds, rtol=1e-8, atol=1e-9)
    assert np.all(state.error.q["q"] < 1e-13)
    assert np.allclose([motion.at("1/4").q["q"], motion.at("1/4").p["q"]], start, rtol=1e-14, atol=1e-15)
    assert pickle.loads(pickle.dumps(problem)).frame.rate == problem.frame.rate


def test_problem_6_4_is_a_sum_of_two_moving_parts() -> None:
    """C85: F₂ = (P₁ + v₀)(q₁ − v₀ t) + ½ P₂² e^{−2t} tan q₂ of ½ (p₁² + p₂² + q₁²); K by the book, motion by the map."""
    K = "p_Q1**2/2 - v0**2/2 - Q2*p_Q2 + (Q2**2*exp(2*t) + p_Q2**2*exp(-2*t))**2/8 + (Q1 + v0*t)**2/2"
    problem = hjsolve.from_hamiltonian(K, {"Q1": "line", "Q2": "line"}, {"v0": 2})
    assert [[c.name for c in part.coordinates] for part in problem.parts] == [["Q1"], ["Q2"]]
    with mp.workdps(40):
        v0, q1, p1, q2, p2 = 2, mp.mpf("0.3"), mp.mpf("0.7"), mp.mpf("0.2"), mp.mpf("0.4")

        def image(t: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
            """The motion of the old variables, mapped."""
            x, y, turned = q1 * mp.cos(t) + p1 * mp.sin(t), p1 * mp.cos(t) - q1 * mp.sin(t), q2 + p2 * t
            P2 = mp.sqrt(2 * p2) * mp.exp(t) * mp.cos(turned)
            return x - v0 * t, P2 * mp.exp(-2 * t) * mp.tan(turned), y - v0, P2

        begin = image(mp.mpf(0))
        motion = problem.motion(q={"Q1": begin[0], "Q2": begin[1]}, p={"Q1": begin[2], "Q2": begin[3]}, digits=25)
        for t in ("0.5", "1.7"):
            state, expected = motion.at(t), image(mp.mpf(t))
            found = (state.q["Q1"], state.q["Q2"], state.p["Q1"], state.p["Q2"])
            assert all(abs(x - y) < mp.mpf(10) ** -22 * (1 + abs(y)) for x, y in zip(found, expected, strict=True))
        assert abs(motion.constants["E_Q2"].value - p2**2 / 2) < mp.mpf(10) ** -22
    assert "E" not in motion.constants


def test_problem_6_5_has_a_frame() -> None:
    """C86: K = ⅛ (Q² e^{−2t} + P² e^{2t})² + ½ atan² (P e^{2t}/Q) + Q P becomes ½ (q² + p²) in X, Y."""
    K = "(q**2*exp(-2*t) + p**2*exp(2*t))**2/8 + atan(p*exp(2*t)/q)**2/2 + q*p"
    problem = hjsolve.from_hamiltonian(K, {"q": "0 < q"})
    q, p = problem.coordinate.symbol, problem.coordinate.momentum
    assert (problem.frame.rate, problem.frame.drift) == (-1, 0)
    assert sp.expand(problem.frame.hamiltonian - (q**2 + p**2) ** 2 / 8 - sp.atan(p / q) ** 2 / 2) == 0
    t = next(s for s in problem.hamiltonian.free_symbols if s.name == "t")
    assert not hjsolve.is_integral("q*p_q", problem)
    assert hjsolve.poisson_bracket("q*exp(-t)", "p_q*exp(t)", problem) == 1
    assert t.is_real


@pytest.mark.parametrize(("K", "domain"), [
    ("p**4 + q*t", "line"), ("p**3*exp(t) + sin(t)*q", "line"), ("p**4 + cos(q - t)", "angle"),
    ("p**4 + (q + t)**2", "0 < q"),
])  # fmt: skip
def test_what_has_no_such_frame_is_refused(K: str, domain: str) -> None:
    with pytest.raises(hjsolve.InvalidSystemError, match="no such frame was found"):
        hjsolve.from_hamiltonian(K, {"q": domain})


def test_a_motion_needs_momenta() -> None:
    problem = hjsolve.from_hamiltonian(FRAMES["moving"][0], {"q": "line"})
    with pytest.raises(hjsolve.InvalidInputError, match="give p="):
        problem.motion(q={"q": 1}, velocity={"q": 0})
