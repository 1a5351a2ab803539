"""W and S along motions: against ∫ p·dq by quadrature of states, Hamilton's equations by Taylor series, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.mechanics.system import hamiltonian
from tests.reference.taylor import Flow
from tests.support import entries
from tests.support.gauss import gauss

pytestmark = pytest.mark.rotating_file(10)

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def swept(motion, t):
    """∫ p·q̇ dt by Gauss and Legendre's rule on more and more pieces, from the states alone; and ∫ |p·q̇| dt."""
    former, pieces = None, 8
    while True:
        ends = np.linspace(0.0, t, pieces + 1)
        half = np.diff(ends)[:, None] / 2
        state = motion.at((ends[1:] + ends[:-1])[:, None] / 2 + half * NODES)
        power = sum(state.p[name] * state.velocity[name] for name in state.p)
        total, size = float(np.sum(power * WEIGHTS * half)), float(np.sum(np.abs(power) * WEIGHTS * np.abs(half)))
        if former is not None and abs(total - former) <= 3e-15 * size:
            return total, size
        assert pieces < 1000
        former, pieces = total, 2 * pieces


def span(motion):
    periods = [period.value for period in motion.periods.values()]
    return min(1.3 * max(periods), 20 * min(periods)) if periods else 2.0


@pytest.mark.entries
@pytest.mark.nightly_cases("liouville-p5-6")
@pytest.mark.parametrize("name", entries.separable_with_effects())
def test_it_is_the_integral_of_twice_the_kinetic_energy(name):
    """Over the whole catalog, forwards and backwards, to 1e-13 of ∫ |p·q̇| dt, and to its claim."""
    motion = entries.solved(name).motion(**entries.given(name))
    for direction in (1, -0.37):
        t = direction * span(motion)
        if ends := [e.value for e in motion.boundary_times.values() if e.value * direction > 0]:
            t = min(t, 0.8 * min(ends, key=abs), key=abs)
        found, (total, size) = motion.characteristic_function(t), swept(motion, t)
        assert abs(found.value - total) <= min(found.error + 4e-15 * size, 1e-13 * size)
        assert found.error <= 2e-13 * size


@pytest.mark.entries
@pytest.mark.nightly_cases(
    "garnier", "henon-heiles-separable", "kepler-prolate", "kuzmin-kutuzov", "neumann", "perfect-oblate-spheroid",
    "triaxial-geodesics", "two-centres-space", "vinti",
)  # fmt: skip
@pytest.mark.parametrize("name", entries.separable_with_effects())
def test_betas_are_what_the_printed_equations_say(name):
    """∂W/∂α along the branch at t₀, from the printed integrands by 30-digit quadrature over the anomaly of the interval."""
    solution, given = entries.solved(name), entries.given(name)
    motion, fine = solution.motion(**given), solution.motion(**{**given, "digits": 40}, want=["constants", "betas"])
    energy, values = solution.separation.shell.energy.name, dict(motion.initial.values)
    values |= {solution.constants[k].symbol: v for k, v in motion.initial.constants.items()}
    values |= {sp.Symbol(t, real=True): motion.t0 for t in ("t", "tau")}
    equations = {k: equation.rhs for k, equation in solution.orbit_equations.items()}
    if solution.time_law is not None:
        equations[energy] = solution.time_law.rhs
    assert set(motion.betas) == set(equations)
    with mp.workdps(30):
        for constant, right in equations.items():
            terms = [along_branch(solution, fine, term, values) for term in sp.Add.make_args(right)]
            total, size = mp.fsum(terms), mp.fsum(terms, absolute=True)
            sought = mpf(str(motion.t0)) - total if constant == energy else -total
            found = motion.betas[constant]
            assert abs(found.value - sought) <= found.error + mpf(10) ** -20 * size
            assert found.error <= 4e-14 * (size + 1)


def along_branch(solution, fine, term, values):
    """A term of ∂W/∂α at the initial place: an integral from its lower limit, with the sign of the root at t₀."""
    integrals = term.atoms(sp.Integral)
    if not integrals:
        return mpf(str(sp.N(term.subs(values), 40)))
    (integral,) = integrals
    symbol = integral.variables[0]
    coordinate = next(c for c in solution.system.coordinates if c.symbol == symbol)
    low, high = fine.lower_limits[coordinate.name].value, mpf(str(sp.N(values[symbol], 45)))
    if fine.kinds[coordinate.name] == "equilibrium" or abs(high - low) < mpf(10) ** -25 * (1 + abs(high)):
        return mpf(0)
    integrand = sp.lambdify(symbol, integral.function.subs({s: v for s, v in values.items() if s != symbol}), "mpmath")

    def over_anomaly(s):
        with mp.workdps(45):
            return mp.re(integrand(low + (high - low) * mp.sin(s / 2) ** 2)) * mp.sin(s) / 2 * (high - low)

    root = sp.N((values[coordinate.momentum] + solution.shift[coordinate.name]).subs(values), 20)
    factor = mpf(str(sp.N((term / integral).subs(values), 40)))
    total = mp.quad(over_anomaly, [0, mp.pi / 2, mp.pi], method=gauss)
    return factor * total * (-1 if root < 0 else 1)


@pytest.mark.nightly_cases("liouville-p5-6", "stark")
@pytest.mark.parametrize(
    "name", ["pendulum", "kepler-spherical", "lagrange-top", "two-centres-plane", "stark", "liouville-p5-6"]
)
def test_it_is_the_action_of_hamiltons_equations_by_taylor_series(name):
    """W and S as further unknowns of a 30-digit integrator: dS/dt = L, with the state."""
    solution = entries.solution(name)
    given = entries.described(name).motions["default"].arguments
    motion = solution.motion(**given, digits=25)
    system = solution.system
    H = hamiltonian(system)
    q, p = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    area, dummy = sp.Symbol("area"), sp.Symbol("p_area")
    # H + p_area·(p·∂H/∂p): with p_area = 0 the motion is the same, and d(area)/dt = p·q̇
    more = H + dummy * sp.Add(*(momentum * sp.diff(H, momentum) for momentum in p))
    with mp.workdps(45):
        start = [mpf(str(sp.N(motion.initial.values[s], 45))) for s in (*q, *p)]
        values = {c.symbol: mpf(str(sp.N(motion.initial.values[c.symbol], 45))) for c in system.parameters}
        flow = Flow(
            more, [*q, area], [*p, dummy], values, [*start[: len(q)], mpf(0), *start[len(q) :], mpf(0)], digits=30
        )
        E = mpf(str(sp.N(H.subs(motion.initial.values), 45)))
        for t in ("0.7", "2.3"):
            area_there = flow.at(mpf(t))[len(q)]
            W, S = motion.characteristic_function(t), motion.principal_function(t)
            assert abs(W.value - area_there) <= W.error <= mpf(10) ** -22 * (1 + abs(area_there))
            assert abs(S.value - (area_there - E * mpf(t))) <= S.error <= mpf(10) ** -22 * (1 + abs(area_there))


def kepler_action(t, e, a):
    """W = √a (E + e sin E) from the pericentre, with Kepler's equation n t = E − e sin E; m = k = 1."""
    M = mpf(t) * a ** mpf("-1.5")
    E = mp.findroot(lambda x: x - e * mp.sin(x) - M, M)
    return mp.sqrt(a) * (E + e * mp.sin(E))


@pytest.mark.parametrize("digits", [15, 40])
@pytest.mark.parametrize("t", ["1/3", "-7", "20", "1e10", "2e10"])
def test_kepler_after_a_thousand_million_orbits(t, digits):
    motion = entries.solution("kepler-planar").motion(
        q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}, digits=digits
    )
    with mp.workdps(70):
        e = mpf("0.44")
        truth = kepler_action(mp.mpf(sp.Rational(t).p) / sp.Rational(t).q, e, 1 / (1 - e))
        found = motion.characteristic_function(t)
        assert abs(mpf(found.value) - truth) <= found.error <= abs(truth) * (3e-14 if digits == 15 else mpf(10) ** -37)
        if abs(truth) > 1e9:
            assert abs(mpf(found.value) / truth - 1) <= 5e-16
            assert found.error <= 2e-15 * abs(truth)


@pytest.mark.parametrize("t", ["0.25", "3", "6283185307.25", "-1e12"])
def test_the_oscillator_after_many_swings(t):
    """x = 2 cos t: W = ∫ 4 sin² t dt = 2t − sin 2t, S = −sin 2t, right to the size of W."""
    line = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2"))
    motion = line.motion(q={"x": 2}, velocity={"x": 0})
    with mp.workdps(50):
        W, S = 2 * mpf(t) - mp.sin(2 * mpf(t)), -mp.sin(2 * mpf(t))
        found, principal = motion.characteristic_function(t), motion.principal_function(t)
        assert abs(found.value - W) <= found.error <= 2e-15 * abs(W) + 4e-14
        assert abs(principal.value - S) <= principal.error <= 6e-15 * abs(W) + 4e-14
    with mp.workdps(60):
        fine = line.motion(q={"x": 2}, velocity={"x": 0}, digits=45)
        exact = -mp.sin(2 * mpf(t))
        assert (
            abs(fine.principal_function(t).value - exact)
            <= fine.principal_function(t).error
            <= (2 + abs(mpf(t))) * mpf(10) ** -42
        )


@pytest.mark.nightly
def test_falling_thrown_and_escaping():
    """Closed forms: x = t²/2 + …, a repelled particle, and a motion to the end of a domain."""
    fall = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "-x")).motion(q={"x": 0}, velocity={"x": "-3"})
    times = np.array([[0.5, 3.0, 6.0], [100.0, -2.0, 1e5]])
    found = fall.characteristic_function(times)
    truth = ((times - 3) ** 3 + 27) / 3  # ∫ (t − 3)² dt
    assert found.value.shape == found.error.shape == times.shape
    assert np.all(np.abs(found.value - truth) <= found.error)
    assert np.all(found.error <= 2e-14 * (np.abs(times - 3) ** 3 + 27))
    cliff = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "-x**2/2"))
    over = cliff.motion(q={"x": 0}, velocity={"x": 1})  # x = sinh t: W = t/2 + sinh(2t)/4
    found = over.characteristic_function([0.5, -3.0, 12.0])
    truth = np.array([t / 2 + np.sinh(2 * t) / 4 for t in (0.5, -3.0, 12.0)])
    assert np.all(np.abs(found.value - truth) <= found.error + 4e-16 * np.abs(truth))
    creep = cliff.motion(q={"x": 1}, velocity={"x": -1})  # x = e^{−t}: W = (1 − e^{−2t})/2
    found = creep.characteristic_function([0.5, 5.0, 40.0])
    truth = [(1 - np.exp(-2 * t)) / 2 for t in (0.5, 5.0, 40.0)]
    assert np.all(np.abs(found.value - truth) <= found.error + 1e-16)
    assert np.all(found.error <= 1e-14)
    gone = hjsolve.solve(hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "0*x")).motion(q={"x": 1}, velocity={"x": -2})
    found = gone.characteristic_function([0.25, 0.75])
    assert found.value[0] == pytest.approx(1.0, rel=1e-15)
    assert np.isnan(found.value[1])
    assert np.isnan(found.error[1])


def test_infall_to_a_centre_reaches_its_finite_action():
    """r from 1 at rest to r under −1/r without angular momentum: W = √2 (asin-form), from r = (1 − cos η)/2."""
    kepler = hjsolve.solve(hjsolve.System({"r": "0 < r"}, "dot(r)**2/2", "-1/r"))
    motion = kepler.motion(q={"r": 1}, velocity={"r": 0})
    with mp.workdps(40):
        for η in ("0.5", "2", "3"):  # from rest: r = (1 + cos η)/2, t = (η + sin η)/√8
            η = mpf(η)
            t, W = (η + mp.sin(η)) / mp.sqrt(8), (η - mp.sin(η)) / mp.sqrt(2)
            found = motion.characteristic_function(mp.nstr(t, 35))
            assert abs(found.value - W) <= found.error <= 2e-12


def test_rests_and_free_coordinates():
    pendulum = entries.solution("pendulum")
    rest = pendulum.motion(q={"theta": 0}, velocity={"theta": 0})
    assert rest.characteristic_function("5").value == 0
    energy = float(rest.constants["E"].value)
    assert rest.principal_function("5").value == pytest.approx(-5 * energy, rel=1e-15)
    free = hjsolve.solve(hjsolve.System({"x": "line", "y": "line"}, "dot(x)**2/2 + 3*dot(y)**2/2", "0"))
    motion = free.motion(q={"x": 1, "y": 2}, velocity={"x": 2, "y": "0.5"}, t0=10)
    found, principal = motion.characteristic_function("1e9"), motion.principal_function("1e9")
    truth = 4.75 * (1e9 - 10)
    assert abs(found.value - truth) <= found.error <= 3e-15 * truth
    assert abs(principal.value - truth / 2) <= principal.error <= 6e-15 * truth
    assert {name: beta.value for name, beta in motion.betas.items()} == {"p_x": 19.0, "p_y": 3.0}
    assert motion.lower_limits == {}


def test_the_beta_of_the_energy_is_the_passage_of_the_lower_turning_point():
    motion = entries.solution("kepler-planar").motion(
        q={"r": "1.3", "theta": "0.4"}, velocity={"r": "-0.1", "theta": "0.6"}, t0=3
    )
    passage = motion.time_at("r", motion.lower_limits["r"].value)
    assert motion.kinds["r"] == "libration"
    assert abs(motion.betas["E"].value - passage.value) <= 1e-7  # a turning point of 16 digits is passed within 1e-8
    assert motion.at(motion.betas["E"].value).q["r"] == pytest.approx(motion.lower_limits["r"].value, rel=1e-15)


@pytest.mark.nightly
def test_s_generates_the_motion():
    """∂S/∂q = p where q is reached: S at neighbouring ends of one family W(q; α) at the same α, so p = ΔW/Δq."""
    motion = entries.solution("liouville-p5-6").motion(
        **entries.described("liouville-p5-6").motions["default"].arguments, digits=40
    )
    t, h = mpf("0.8"), mpf(10) ** -12
    states = [motion.at(mp.nstr(t + k * h, 45)) for k in (-1, 0, 1)]
    W = [motion.characteristic_function(mp.nstr(t + k * h, 45)).value for k in (-1, 0, 1)]
    swept_between = sum(states[1].p[n] * (states[2].q[n] - states[0].q[n]) for n in states[1].q)
    assert abs((W[2] - W[0]) / swept_between - 1) < mpf(10) ** -20


def test_the_symbolic_principal_function_solves_the_time_dependent_equation():
    solution = entries.solution("kepler-planar")
    t, E = sp.Symbol("t", real=True), solution.separation.shell.energy
    assert sp.diff(solution.principal_function, t) == -E
    assert solution.principal_function + E * t == solution.characteristic_function
    free = hjsolve.solve(hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "0", {"m": 1}))
    (p,) = [c.momentum for c in free.system.coordinates]
    m = free.system.parameters[0].symbol
    assert sp.simplify(sp.diff(free.principal_function, t) + p**2 / (2 * m)) == 0


def test_what_was_not_integrated_is_refused():
    motion = entries.solution("kepler-planar").motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": 1}, want=["periods"])
    with pytest.raises(hjsolve.InvalidInputError, match="characteristic_function"):
        motion.characteristic_function(1)
    whole = entries.motion("kepler-planar")
    with pytest.raises(hjsolve.InvalidInputError):
        whole.principal_function("soon")
