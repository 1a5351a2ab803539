"""Moving constraints, Lagrange brackets, involution, Jacobi's metric: C16, C40, C72 by the machine, Ex 4-7, P4-14."""

from __future__ import annotations

import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.mechanics.system import parameter

SPACE = {"x": "line", "y": "line", "z": "line"}
T3 = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"


@pytest.mark.nightly
def test_c40_a_plane_that_moves_by_a_velocity_constraint() -> None:
    """P2-10: the plane has the velocity (−10, −15, −20)/29; in it the motion is an isotropic oscillator."""
    system = hjsolve.System(SPACE, T3, "k/2*(x**2 + y**2 + z**2)", {"m": 1, "k": 4},
                            constraints=["2*dot(x) + 3*dot(y) + 4*dot(z) + 5 = 0"])  # fmt: skip
    assert system.time is not None
    solution = hjsolve.solve(system, coordinates="find")
    assert (solution.kind, solution.solution.chart.kind) == ("frame", "normal modes")
    t = system.time
    velocity = {name: sp.diff(f, t) for name, f in solution.frame.place.items()}
    gone = dict(system.eliminated)["z"]
    velocity["z"] = sp.diff(gone, t) + sum(sp.diff(gone, c.symbol) * velocity[c.name] for c in system.coordinates)
    assert velocity == {"x": sp.Rational(-10, 29), "y": sp.Rational(-15, 29), "z": sp.Rational(-20, 29)}
    motion = solution.motion(q={"x": "0.3", "y": "0.1"}, velocity={"x": "0.2", "y": "-0.5"}, parameters={"c_1": 0})
    state = motion.at(2)
    with mp.workdps(30):  # x − d is an oscillator of frequency 2 about the moving centre d = −10 t/29
        expected = mpf("0.3") * mp.cos(4) + (mpf("0.2") + mpf(10) / 29) / 2 * mp.sin(4) - mpf(20) / 29
        assert abs(mpf(state.q["x"]) - expected) <= mpf(state.error.q["x"]) <= 1e-12


def test_c16_and_c72_by_the_machine() -> None:
    """P1-7: T = (11/12) m l² θ̇² + … and p_θ; P4-8: the accelerations (g/3, −g/3, −2g/3)."""
    disk = hjsolve.System(
        {"theta": "angle", "phi": "angle", "psi": "angle"},
        "2*m*l**2/3*dot(theta)**2 + m*r**2/4*dot(phi)**2 + I0/2*dot(psi)**2", 0,
        {n: parameter(n, v, assume="positive") for n, v in (("m", 1), ("l", 2), ("r", 1), ("I0", 1))}, constraints=["r*dot(phi) = l*dot(theta) + (l + r)*dot(psi)"],
    )  # fmt: skip
    ((name, _),) = disk.eliminated
    s, c = disk.symbols, {q.name: q.velocity for q in disk.coordinates}
    if name == "phi":
        m, l, r, I0 = (s[n] for n in ("m", "l", "r", "I0"))
        book = 11 * m * l**2 / 12 * c["theta"] ** 2 + m * l * (l + r) / 2 * c["theta"] * c["psi"]
        book += (I0 + m * (l + r) ** 2 / 2) / 2 * c["psi"] ** 2
        assert sp.expand(disk.kinetic - book) == 0
    assert {q.name for q in hjsolve.separate(disk).shell.ignorable} == {q.name for q in disk.coordinates}
    plane = hjsolve.System(SPACE, T3, "m*g*z", {"m": 1, "g": 3}, constraints=["dot(x) - dot(y) + dot(z) = 0"])
    motion = hjsolve.solve(plane, coordinates="find").motion(
        q={"x": 0, "y": 0}, velocity={"x": 0, "y": 0}, parameters={"c_1": 0}
    )
    state = motion.at(2)
    assert abs(state.q["x"] - 2) <= state.error.q["x"] + 1e-15  # g/3 = 1
    assert abs(state.q["y"] + 2) <= state.error.q["y"] + 1e-15


def test_a_moving_holonomic_constraint_gives_t1_and_t0() -> None:
    """A bead on a rod that turns as y = x t: T = ½ (1 + t²) ẋ² + t x ẋ + ½ x²."""
    bead = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", 0, constraints=["y = x*t"])
    x, t = bead.coordinates[0], bead.time
    expected = (1 + t**2) * x.velocity**2 / 2 + t * x.symbol * x.velocity + x.symbol**2 / 2
    assert sp.expand(bead.kinetic - expected) == 0
    motion = hjsolve.solve(bead).motion(q={"x": 1}, velocity={"x": 1})
    state = motion.at([0, "1.5"])
    y, v = state.q["x"][1], state.velocity["x"][1]
    assert abs(state.p["x"][1] - ((1 + 2.25) * v + 1.5 * y)) < 1e-14  # p = (1 + t²) ẋ + t x
    with mp.workdps(30):  # (1 + t²) ẍ + 2 t ẋ = 0: x = 1 + atan t
        assert abs(mpf(y) - 1 - mp.atan(mpf("1.5"))) <= mpf(state.error.q["x"][1]) <= 1e-14
    with pytest.raises(hjsolve.NonholonomicError, match="not integrable"):
        hjsolve.System(SPACE, T3, 0, {"m": 1}, constraints=["sin(t**2)*dot(x) - cos(t**2)*dot(y) = 0"])


@pytest.mark.nightly
def test_lagrange_brackets_of_a_map() -> None:
    found = hjsolve.canonical(
        {"Q": "sqrt(q)*cos(p)", "P": "sqrt(q)*sin(p)"}, domains={"q": "0 < q", "p": "0 < p < pi/2"}
    )
    half = sp.Rational(1, 2)
    assert [found.lagrange_bracket(*pair) for pair in (("q", "p"), ("p", "q"), ("q", "q"))] == [half, -half, 0]
    with pytest.raises(hjsolve.InvalidInputError, match="not one of q, p"):
        found.lagrange_bracket("q", "Q")


def test_involution_of_a_set() -> None:
    """The separation constants of the spherical pendulum are in involution; two components of L are not."""
    assert hjsolve.involution(["H", "p_phi"], "spherical-pendulum")
    space = hjsolve.System(SPACE, T3, "-k/sqrt(x**2 + y**2 + z**2)", {"m": 1, "k": 1})
    L = ["y*p_z - z*p_y", "z*p_x - x*p_z", "x*p_y - y*p_x"]
    square = " + ".join(f"({c})**2" for c in L)
    assert hjsolve.involution(["H", L[2], square], space)
    wrong = hjsolve.involution(["H", *L], space)
    assert not wrong
    assert "functions 2 and 3" in wrong.statement
    with pytest.raises(hjsolve.InvalidInputError, match="two functions"):
        hjsolve.involution(["H"], space)


@pytest.mark.parametrize(("entry", "constant"), [("projectile", "p_x"), ("kepler-planar", "p_theta"),
                                                 ("whirling-tube", None)])  # fmt: skip
def test_the_orbits_of_one_energy_are_geodesics(entry: str, constant: str | None) -> None:
    """P4-14 and Ex 4-7: p² of the geodesics at the energy ½ is that of the system at E = h; so is the orbit equation."""
    system = hjsolve.catalog.load(entry)
    own, geodesic = hjsolve.solve(system), hjsolve.solve(hjsolve.jacobi_metric(system, energy="h"))
    h, E = geodesic.system.symbols["h"], own.separation.shell.energy
    for name, square in own.momentum_squared.items():
        half = geodesic.momentum_squared[name].subs(geodesic.separation.shell.energy, sp.Rational(1, 2))
        assert sp.simplify(half - square.subs(E, h)) == 0
    if constant is not None:
        left = geodesic.orbit_equations[constant].rhs.subs(geodesic.separation.shell.energy, sp.Rational(1, 2))
        right = own.orbit_equations[constant].rhs.subs(E, h)
        kernels = [next(iter(x.atoms(sp.Integral))).function for x in (left, right)]
        assert sp.simplify(kernels[0] ** 2 - kernels[1] ** 2) == 0
    with pytest.raises(hjsolve.InvalidInputError, match="linear in the velocities"):
        hjsolve.jacobi_metric("crossed-fields")
