"""Relativistic particles (Greenwood (7-159)–(7-187), P7-15, Ex 7-7) against closed forms and Taylor series."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve import catalog
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import System, hamiltonian, momenta, parameter, velocities
from hjsolve.separation import Obstruction, Separation, separate
from hjsolve.solution.quadratures import solve
from tests.reference.taylor import Flow
from tests.support import entries

IDS = [
    "relativistic-oscillator", "constant-proper-acceleration", "relativistic-kepler",
    "relativistic-isotropic-oscillator", "relativistic-crossed-fields",
]  # fmt: skip
MOTIONS = [(name, motion) for name in IDS for motion in entries.described(name).motions]
PARTICLE = {"m0": parameter("m0", value=1, assume="positive"), "c": parameter("c", value=1, assume="positive")}
LIGHT = {"mass": "m0", "light": "c"}


@pytest.mark.parametrize(("name", "motion"), MOTIONS, ids=[f"{n}-{m}" for n, m in MOTIONS])
def test_positions_and_momenta_are_those_of_a_taylor_integration(name: str, motion: str) -> None:
    entry = entries.described(name)
    solved = solve(entry.system).motion(**entry.motions[motion].arguments, digits=25)
    assert dict(solved.kinds) == dict(entry.motions[motion].kinds)
    system = entry.system
    with mp.workdps(50):
        values = {s: mpf(sp.N(solved.initial.values[s], 50)) for s in (p.symbol for p in system.parameters)}
        begin = [
            mpf(sp.N(solved.initial.values[s], 50))
            for s in (*(c.symbol for c in system.coordinates), *(c.momentum for c in system.coordinates))
        ]
        q, p = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
        m, c = (values[sp.Symbol(n, positive=True)] for n in ("m0", "c"))
        flow = Flow(_plain_hamiltonian(name, q, p), q, p, values, begin, digits=30)
        assert m > 0
        assert c > 0
        for t in ("0.7", "2", "5"):
            expected, state = flow.at(mpf(t)), solved.at(t)
            for k, coordinate in enumerate(system.coordinates):
                assert abs(mp.mpf(state.q[coordinate.name]) - _principal(coordinate, expected[k])) < mpf(10) ** -22
                assert abs(mp.mpf(state.p[coordinate.name]) - expected[len(q) + k]) < mpf(10) ** -22


def _principal(coordinate: object, value: mpf) -> mpf:
    if coordinate.domain.kind != "angle":
        return value
    return value - 2 * mp.pi * mp.ceil((value - mp.pi) / (2 * mp.pi))


def _plain_hamiltonian(name: str, q: list[sp.Symbol], p: list[sp.Symbol]) -> sp.Expr:
    """H written down by hand, (7-165) and (7-170)."""
    m, c, k, g = (sp.Symbol(n, positive=True) for n in ("m0", "c", "k", "g"))
    B, F = sp.Symbol("eB", real=True, nonzero=True), sp.Symbol("eF", real=True)
    square, V = {
        "relativistic-oscillator": lambda: (p[0] ** 2, k * q[0] ** 2 / 2),
        "constant-proper-acceleration": lambda: (p[0] ** 2, -m * g * q[0]),
        "relativistic-kepler": lambda: (p[0] ** 2 + p[1] ** 2 / q[0] ** 2, -k / q[0]),
        "relativistic-isotropic-oscillator": lambda: (p[0] ** 2 + p[1] ** 2 / q[0] ** 2, k * q[0] ** 2 / 2),
        "relativistic-crossed-fields": lambda: (p[0] ** 2 + (p[1] - B * q[0]) ** 2, -F * q[0]),
    }[name]()
    return c * sp.sqrt(m**2 * c**2 + square) + V


@pytest.mark.parametrize("amplitude", ["0.01", "1.5", "20"])
def test_the_period_of_the_spring_is_the_books_integral(amplitude: str) -> None:
    """P7-15: t = √(m0/k) ∫ (1 + 2η² cos²φ)/√(1 + η² cos²φ) dφ, sin φ = x/a, η² = k a²/(4 m0 c²)."""
    motion = solve(catalog.load("relativistic-oscillator")).motion(
        q={"x": amplitude}, velocity={"x": 0}, parameters={"m0": 2, "k": 3, "c": "0.7"}, digits=30)  # fmt: skip
    with mp.workdps(45):
        η2 = 3 * mpf(amplitude) ** 2 / (4 * 2 * mpf("0.7") ** 2)
        quarter = mp.quad(lambda f: (1 + 2 * η2 * mp.cos(f) ** 2) / mp.sqrt(1 + η2 * mp.cos(f) ** 2),
                          mp.linspace(0, mp.pi / 2, 9))  # fmt: skip
        expected = 4 * mp.sqrt(mpf(2) / 3) * quarter
        assert abs(motion.periods["x"].value - expected) < expected * mpf(10) ** -28
        E = 2 * mpf("0.7") ** 2 + 3 * mpf(amplitude) ** 2 / 2
        assert abs(motion.constants["E"].value - E) < E * mpf(10) ** -28


def test_the_time_law_of_the_spring_between_the_turns() -> None:
    motion = solve(catalog.load("relativistic-oscillator")).motion(q={"x": 0}, velocity={"x": "0.8"}, digits=25)
    a = motion.turning_points["x"][1].value
    with mp.workdps(40):
        η2 = mp.mpf(a) ** 2 / 4
        for fraction in ("0.3", "0.9"):
            φ = mp.asin(mpf(fraction))
            expected = mp.quad(lambda f: (1 + 2 * η2 * mp.cos(f) ** 2) / mp.sqrt(1 + η2 * mp.cos(f) ** 2), [0, φ])
            found = motion.time_at("x", mp.mpf(a) * mpf(fraction)).value
            assert abs(found - expected) < mpf(10) ** -22


def test_constant_force_gives_the_hyperbola_of_the_book() -> None:
    """(7-178)–(7-187): x, v and, at τ = 1, x = 0.543, v = 0.762, t = 1.175 in units of c and g."""
    motion = solve(catalog.load("constant-proper-acceleration")).motion(q={"x": 0}, velocity={"x": 0}, digits=25)
    with mp.workdps(35):
        for t in ("0.01", "1", "1000"):
            state = motion.at(t)
            root = mp.sqrt(1 + mpf(t) ** 2)
            assert abs(state.q["x"] - mpf(t) ** 2 / (root + 1)) < mpf(10) ** -24 * abs(state.q["x"])
            assert abs(state.velocity["x"] - mpf(t) / root) < mpf(10) ** -24
        state = motion.at(mp.sinh(1))
        assert abs(state.q["x"] - (mp.cosh(1) - 1)) < mpf(10) ** -23
        assert abs(state.velocity["x"] - mp.tanh(1)) < mpf(10) ** -23
    assert round(float(state.q["x"]), 3) == 0.543
    assert round(float(state.velocity["x"]), 3) == 0.762
    assert round(float(state.t), 3) == 1.175


def test_a_journey_there_and_back_takes_the_books_times() -> None:
    """Ex 7-7: half of 4·x₁ = distance; four legs of proper time 1.76 and time 2.83 (g = 1.03 ly/yr²)."""
    τ = 1.76 * 1.0
    t = mpmath.sinh(τ)
    motion = solve(catalog.load("constant-proper-acceleration")).motion(q={"x": 0}, velocity={"x": 0})
    assert abs(motion.time_at("x", mpmath.cosh(τ) - 1).value - t) < 1e-13
    assert round(float(t), 2) == 2.82
    assert round(4 * 1.76, 2) == 7.04


def test_the_ellipse_precesses_as_sommerfeld_says() -> None:
    entry = entries.described("relativistic-kepler")
    motion = solve(entry.system).motion(**entry.initial.arguments, digits=30)
    L, E = motion.constants["p_theta"].value, motion.constants["E"].value
    with mp.workdps(40):
        k, s = mpf("0.1"), mp.sqrt(1 - (mpf("0.1") / L) ** 2)
        turn = 2 * mp.pi * motion.periods["r"].value / motion.periods["theta"].value
        assert abs(turn - 2 * mp.pi / s) < mpf(10) ** -27
        # E = m c²/√(1 + (k/c)²/(J_r + √(L² − k²/c²))²): Sommerfeld's fine-structure formula
        J = motion.actions["r"].value
        assert abs(E - 1 / mp.sqrt(1 + k**2 / (J + L * s) ** 2)) < mpf(10) ** -28


def test_the_charge_drifts_across_the_fields() -> None:
    """Mean velocity E/B across both fields, whatever the start; |E| < cB."""
    for motion in ("default", "thrown"):
        entry = entries.described("relativistic-crossed-fields")
        solved = solve(entry.system).motion(**entry.motions[motion].arguments)
        period = solved.periods["x"].value
        first, later = solved.at(0.0), solved.at(100 * period)
        assert abs(first.q["x"] - later.q["x"]) < 1e-12
        assert abs((later.q["y"] - first.q["y"]) / (100 * period) - -0.3) < 1e-13


def test_crossed_fields_do_not_separate_in_the_symmetric_gauge() -> None:
    """C92: A = B(−y, x)/2 is not closed: gyroscopic."""
    system = System(
        {"x": "line", "y": "line"}, "m0/2*(dot(x)**2 + dot(y)**2) + b/2*(x*dot(y) - y*dot(x))", "-f*x",
        {**PARTICLE, "b": 1, "f": "0.3"}, relativity=LIGHT)  # fmt: skip
    verdict = separate(system)
    assert isinstance(verdict, Obstruction)
    assert verdict.part == "gyroscopic"
    assert verdict.system == system


@pytest.mark.parametrize(("coordinates", "kinetic", "potential", "separates"), [
    ({"x": "line", "y": "line"}, "m0/2*(dot(x)**2 + dot(y)**2)", "x**2/2 + y**2/2", False),
    ({"x": "line", "y": "line"}, "m0/2*(dot(x)**2 + dot(y)**2)", "x**4", True),
    ({"r": "0 < r", "a": "angle"}, "m0/2*(dot(r)**2 + r**2*dot(a)**2)", "r**2/2", True),
    ({"r": "0 < r", "a": "angle"}, "m0/2*(dot(r)**2 + r**2*dot(a)**2)", "sin(a)/r**2", False),
    ({"r": "0 < r", "a": "0 < a < pi", "b": "angle"},
     "m0/2*(dot(r)**2 + r**2*dot(a)**2 + r**2*sin(a)**2*dot(b)**2)", "-1/r", True),
])  # fmt: skip
def test_v_and_its_square_must_both_be_of_staeckels_form(
    coordinates: dict[str, str], kinetic: str, potential: str, separates: bool
) -> None:
    """C91: one Cartesian coordinate or a central V; sums V1(x) + V2(y) and v(θ)/r² are lost."""
    verdict = separate(System(coordinates, kinetic, potential, PARTICLE, relativity=LIGHT))
    assert isinstance(verdict, Separation) == separates
    if not separates:
        assert verdict.part == "potential"
        assert separate(System(coordinates, kinetic, potential, PARTICLE)).__class__ is Separation


def test_slow_motion_is_the_classical_one() -> None:
    """c → ∞: E − m0 c² → T + V, to first order in 1/c²."""
    system = catalog.load("relativistic-oscillator")
    x, p = system.coordinate("x").symbol, system.coordinate("x").momentum
    m, c, k = (system.symbols[n] for n in ("m0", "c", "k"))
    s = sp.Symbol("s", positive=True)
    expansion = sp.series(hamiltonian(system).subs(c, 1 / s), s, 0, 2).removeO().subs(s, 1 / c)
    assert sp.expand(expansion - (m * c**2 + p**2 / (2 * m) + k * x**2 / 2)) == 0
    motion = solve(system).motion(q={"x": 1}, velocity={"x": 0}, parameters={"c": 1000}, digits=20)
    # T = 2π√(m/k) (1 + 3 k a²/(16 m c²) + …)
    assert abs(motion.periods["x"].value / (2 * mpmath.pi) - 1 - mpf(3) / 16 / 10**6) < 1e-12


def test_velocity_and_momentum_are_inverse_to_each_other() -> None:
    for name in IDS:
        system = catalog.load(name)
        there, back = momenta(system), velocities(system)
        point = {s: sp.Rational(7 + i, 20 + 3 * i) for i, s in enumerate(system.symbols.values())}
        speeds = {c.velocity: sp.Rational(1, 9 + k) for k, c in enumerate(system.coordinates)}
        p = {c.momentum: there[c.name].subs({**point, **speeds}) for c in system.coordinates}
        for c in system.coordinates:
            assert abs(sp.N(back[c.name].subs({**point, **p}) - speeds[c.velocity], 30)) < 1e-28


def test_wrong_declarations_are_refused_in_one_line() -> None:
    cases = [
        ({"mass": "m0"}, "relativity: give the parameters"), ({"mass": "m0", "light": "w"}, '"w" is not a parameter'),
        ({"mass": "m0", "light": "k"}, "declare k with assume"),
    ]  # fmt: skip
    for given, text in cases:
        with pytest.raises(InvalidSystemError, match=text):
            System({"x": "line"}, "m0/2*dot(x)**2", "k*x", {**PARTICLE, "k": 1}, relativity=given)
    with pytest.raises(InvalidSystemError, match="no part without velocities"):
        System({"x": "line"}, "m0/2*dot(x)**2 + x", 0, PARTICLE, relativity=LIGHT)
