"""H(q, p) of one degree of freedom that is not quadratic in p, against closed forms, quadratures and differential equations."""

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import hjsolve

pytestmark = pytest.mark.rotating_file(8)


def moving(H, q, p, domain="line", **more):
    return hjsolve.from_hamiltonian(H, {"q": domain}, more.pop("parameters", None)).motion(
        q={"q": q}, p={"q": p}, **more
    )


def within(estimate, true, digits):
    assert abs(mpf(estimate.value) - true) <= estimate.error <= mpf(10) ** -digits * abs(true)


@pytest.mark.parametrize("digits", [15, 30])
@pytest.mark.parametrize("n", [4, 6])
def test_a_power_of_p_with_a_spring_has_the_period_and_action_of_beta_functions(n, digits):
    """p = (E − q²)^(1/n): T = ½·4/n ∫ … = (2/n) B(1/2, 1/n), J = (1/π) B(1/2, 1 + 1/n) at E = 1."""
    motion = moving(f"p**{n} + q**2", 1, 0, digits=digits)
    with mp.workdps(60):
        within(motion.periods["q"], mpf(2) / n * mpmath.beta(mpf(1) / 2, mpf(1) / n), digits - 1)
        within(motion.actions["q"], mpmath.beta(mpf(1) / 2, 1 + mpf(1) / n) / mp.pi, digits - 1)
        for end, true in zip(motion.turning_points["q"], (-1, 1), strict=True):
            within(end, mpf(true), digits - 1)
    assert motion.kinds["q"] == "libration"


def test_the_oscillator_written_as_a_square_root_has_the_period_of_its_quadratic_form():
    """H = f(K) with K = (p² + q²)/2 has the frequency f′(K): here 1/√(1 + 2K)."""
    motion = moving("sqrt(1 + p**2 + q**2)", "0.6", "0.8")
    within(motion.periods["q"], 2 * mp.pi * mp.sqrt(2), 15)
    within(motion.actions["q"], mpf(1) / 2, 15)
    state = motion.at([0.5, 100, -3.25])
    for t, q, error in zip((0.5, 100, -3.25), state.q["q"], state.error.q["q"], strict=True):
        with mp.workdps(40):
            true = mp.cos(t / mp.sqrt(2) - mp.atan2(mpf(8), mpf(6)))
            assert abs(mpf(float(q)) - true) <= error < 1e-14


def test_a_relativistic_spring_has_the_period_of_its_quadrature():
    motion = moving("sqrt(1 + p**2) + k*q**2", 0, 1, parameters={"k": "1/2"})
    with mp.workdps(40):
        E = mp.sqrt(2)
        top = mp.sqrt(2 * (E - 1))

        def rest(s):
            q = top * mp.sin(s)
            w = E - q * q / 2
            return w / mp.sqrt(w + 1) * mp.sqrt(2)  # dq/q̇ with w² − 1 = (w + 1)(top² − q²)/2

        within(motion.periods["q"], 4 * mp.quad(rest, [0, mp.pi / 4, mp.pi / 2]), 14)


CASES = [
    ("sqrt(1+p**2)-cos(q)", "0", "3", "angle"), ("sqrt(1+p**2)-cos(q)", "0", "-3", "angle"),
    ("p**4/4-p**2/2+q**2/2", "0", "1/2", "line"), ("p**4/4-p**2/2+q**2/2", "0", "3/2", "line"),
    ("p**3/3-p+q**2", "0", "0.9", "line"), ("cos(p)+cos(q)/2", "1", "1", "angle"),
    ("exp(p)+exp(q)-p-q", "1", "1", "line"), ("p**4+(q**2-1)**2", "0", "1.1", "line"),
    ("p**4+q**2+p*q/3", "1", "0", "line"), ("cosh(p)*(1+q**2)", "1", "1/2", "line"),
    ("p**4+q**2-exp(-400*(q-1/2)**2)/5", "1", "0", "line"),
]  # fmt: skip


@pytest.mark.rotating(4)
@pytest.mark.nightly_cases("p**4+q**2-exp(-400*(q-1/2)**2)/5-1-0-line")
@pytest.mark.parametrize(("H", "q", "p", "domain"), CASES)
def test_states_are_those_of_hamilton_s_equations_and_come_back(H, q, p, domain):
    motion = moving(H, q, p, domain)
    rates = [*map(_function, (motion.problem.velocity, motion.problem.force))]
    times = np.linspace(0, 2.5, 6)
    start = [float(mp.mpf(eval(x))) for x in (q, p)]
    exact = solve_ivp(
        lambda _, y: [f(*y) for f in rates], (0, 2.5), start, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-12
    )
    state, later = motion.at(times), motion.at(times + float(motion.periods["q"].value))
    assert np.allclose(state.unwrapped("q"), exact.y[0], rtol=0, atol=2e-9)
    assert np.allclose(state.p["q"], exact.y[1], rtol=0, atol=2e-9)
    assert np.allclose(state.velocity["q"], [rates[0](*y) for y in exact.y.T], rtol=0, atol=2e-8)
    assert np.allclose(later.p["q"], state.p["q"], rtol=0, atol=1e-13)


def _function(formula):
    import sympy as sp

    symbols = sorted(formula.free_symbols, key=str, reverse=True)
    names = {s.name: s for s in symbols}
    q, p = names.get("q", sp.Symbol("q")), next((s for s in symbols if s.name != "q"), sp.Symbol("p"))
    return sp.lambdify([q, p], formula)


@pytest.mark.nightly_cases(
    "cos(p)+cos(q)/2-1-1-angle", "p**4+(q**2-1)**2-0-1.1-line", "p**4/4-p**2/2+q**2/2-0-3/2-line",
    "sqrt(1+p**2)-cos(q)-0--3-angle",
)  # fmt: skip
@pytest.mark.parametrize(("H", "q", "p", "domain"), CASES[:8])
def test_the_claims_of_fifteen_digits_hold_against_thirty(H, q, p, domain):
    few, many = moving(H, q, p, domain), moving(H, q, p, domain, digits=30)
    for name in ("periods", "actions", "frequencies"):
        value, true = getattr(few, name)["q"], getattr(many, name)["q"].value
        assert abs(mpf(value.value) - true) <= value.error <= 1e-15 * abs(true) + value.error / 4
    state, exact = few.at([0.7, 321.0]), many.at([0.7, 321.0])
    for group in ("q", "p", "velocity"):
        for k in range(2):
            off = abs(mpf(float(getattr(state, group)["q"][k])) - getattr(exact, group)["q"][k])
            assert off <= getattr(state.error, group)["q"][k] < 1e-12


def test_a_place_of_rest_rests():
    motion = moving("p**4 + q**2", 0, 0)
    assert motion.kinds == {"q": "equilibrium"}
    assert motion.at([0, 5]).q["q"].tolist() == [0, 0]


@pytest.mark.nightly_cases("p**4-p**2+q**2-0-1-line-NotConvergedError")
@pytest.mark.parametrize(
    ("H", "q", "p", "domain", "error"),
    [
        ("p**4", 0, 1, "line", hjsolve.NotConvergedError),
        ("p**4-p**2+q**2", 0, 1, "line", hjsolve.NotConvergedError),
        ("p**4 + q**2", 1, 0, "-1/2 < q < 2", hjsolve.NotConvergedError),
        ("p**4 + q**2", 3, 0, "-1 < q < 2", hjsolve.InvalidInputError),
        ("sqrt(p) + q**2", 0, -1, "line", hjsolve.InvalidInputError),
    ],
)
def test_what_does_not_come_back_or_is_not_real_is_refused(H, q, p, domain, error):
    with pytest.raises(error):
        moving(H, q, p, domain)


@pytest.mark.nightly_cases("1e30")
@pytest.mark.parametrize("size", ["1e-100", "1e-6", "1e30"])
def test_any_size_of_motion_is_followed(size):
    """T goes like E^(−1/4) for p⁴ + q²."""
    motion = moving("p**4 + q**2", size, 0)
    with mp.workdps(40):
        within(motion.periods["q"], mpmath.beta(mpf(1) / 2, mpf(1) / 4) / 2 / mp.sqrt(mpf(size)), 14)
