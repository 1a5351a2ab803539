"""The relativistic rows of Greenwood's table, and collisions, where only the four-momentum is kept."""

from typing import Any

import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog
from hjsolve.mechanics.system import System, parameter
from hjsolve.separation import Obstruction, Separation, separate
from tests.support.book import RESULTS, H_of, Mechanics, Result, exact, formula, motion, off, result, start

S = sp.Symbol
DIGITS_PRINTED = 2e-3
"""The book prints three digits of these numbers."""


# ------------------------------------------------------------------------------------------------ relativity
PARTICLE = {"m0": parameter("m0", value=1, assume="positive"), "c": parameter("c", value=1, assume="positive")}
PLANE, POLAR = {"x": "line", "y": "line"}, {"r": "0 < r", "theta": "angle"}
T_PLANE, T_POLAR = "m0/2*(dot(x)**2 + dot(y)**2)", "m0/2*(dot(r)**2 + r**2*dot(theta)**2)"


def relativistic(coordinates: dict[str, str], kinetic: str, potential: str) -> Any:
    return separate(System(coordinates, kinetic, potential, PARTICLE, relativity={"mass": "m0", "light": "c"}))


@result("C91", "(7-165)")
def relativistic_hamiltonian():
    """H = c*sqrt(m0^2*c^2 + p^2) + V; p^2 = ((E - V)/c)^2 - m0^2*c^2 on H = E."""
    E, square, V = S("E"), formula("p_r**2 + p_theta**2/r**2"), formula("-k/r")
    book = S("c") * sp.sqrt(formula("m0**2*c**2") + square) + V
    shell = ((E - V) / S("c")) ** 2 - formula("m0**2*c**2") - square
    return exact(H_of("relativistic-kepler") - book, shell.subs(E, book))


@result("C91", "(7-159)-(7-165), separability")
def relativistic_separability():
    """V of one Cartesian coordinate and central V separate; V1(x) + V2(y) and v2(theta)/r^2 do not."""
    for given in ((PLANE, T_PLANE, "x**4"), (POLAR, T_POLAR, "r**2/2"), (POLAR, T_POLAR, "-1/r")):
        assert isinstance(relativistic(*given), Separation), given
    for given in ((PLANE, T_PLANE, "x**2/2 + y**2/2"), (POLAR, T_POLAR, "sin(theta)/r**2")):
        assert isinstance(relativistic(*given), Obstruction), given
    return 0


@result("C91", "(7-159)-(7-165), Sommerfeld")
def sommerfeld():
    """E = m0*c^2/sqrt(1 + k^2/(J_r + sqrt(L^2 - k^2))^2) and the turn 2*pi/sqrt(1 - k^2/L^2) from pericentre to pericentre."""
    run = motion("relativistic-kepler")
    L, E, J = (mp.mpf(float(x.value)) for x in (run.constants["p_theta"], run.constants["E"], run.actions["r"]))
    root, k = mp.sqrt(L**2 - mp.mpf("0.01")), mp.mpf("0.1")
    turn = mp.mpf(float(run.frequencies["theta"].value)) / mp.mpf(float(run.frequencies["r"].value))
    return max(off(E, 1 / mp.sqrt(1 + (k / (J + root)) ** 2)), off(turn, L / root))


@result("C92", "(7-170)")
def relativistic_charge():
    """H = c*sqrt(m0^2*c^2 + (p - eA)^2) + e*phi; Landau's gauge separates, the symmetric gauge does not."""
    H = H_of("relativistic-crossed-fields")
    book = formula("c*sqrt(m0**2*c**2 + p_x**2 + (p_y - eB*x)**2)")
    symmetric = relativistic(PLANE, f"{T_PLANE} + x*dot(y)/2 - y*dot(x)/2", "-3*x/10")
    assert isinstance(symmetric, Obstruction)
    assert symmetric.part == "gyroscopic"
    assert isinstance(separate(catalog.load("relativistic-crossed-fields")), Separation)
    return exact((H + formula("eF*x")) ** 2 - book**2)


@result("C92", "(7-166)-(7-170), drift")
def relativistic_drift():
    """The mean velocity across both fields is -E/B, and p = m0*gamma*v + eA."""
    run = motion("relativistic-crossed-fields", "thrown")
    period = mp.mpf(float(run.periods["x"].value))
    first, last = run.at(0), run.at(float(10 * period))
    drift = (mp.mpf(float(last.q["y"])) - mp.mpf(float(first.q["y"]))) / mp.mpf(float(10 * period))
    v = (mp.mpf("0.5"), mp.mpf("0.1"))
    γ = 1 / mp.sqrt(1 - v[0] ** 2 - v[1] ** 2)
    return max(off(drift, "-0.3"), off(first.p["x"], γ * v[0]), off(first.p["y"], γ * v[1] + mp.mpf("0.1")))


@result("C93", "P7-15, period")
def relativistic_spring_period():
    """t = sqrt(m0/k)*integral of (1 + 2n^2*cos^2)/sqrt(1 + n^2*cos^2), n^2 = k*a^2/(4*m0*c^2), sin = x/a."""
    run, n2 = motion("relativistic-oscillator"), mp.mpf(9) / 16
    quarter = time_integral(n2, mp.pi / 2)
    eighth = float(mp.mpf("1.5") * mp.sin(mp.mpf("0.7")))
    there = float(run.time_at("x", eighth, 1).value) - float(run.time_at("x", 0, 0).value)
    way = time_integral(n2, mp.asin(mp.mpf(eighth) / mp.mpf("1.5")))
    # from 3/2 inward: x = 0 is passed at a quarter, the far side turned at a half; the second passage of 1.5*sin(0.7) is later
    return max(off(run.periods["x"].value, 4 * quarter), off(there, 2 * quarter + way))


def time_integral(n2: Any, end: Any) -> Any:
    return mp.quad(lambda f: (1 + 2 * n2 * mp.cos(f) ** 2) / mp.sqrt(1 + n2 * mp.cos(f) ** 2), mp.linspace(0, end, 5))


@result("C93", "P7-15, equation and energy")
def relativistic_spring_equation():
    """m0*(1 - x'^2/c^2)^(-3/2)*x'' + k*x = 0 from L = -m0*c^2*sqrt(1 - x'^2/c^2) - V, and E = m*c^2 + k*x^2/2."""
    spring = Mechanics("-m0*c**2*sqrt(1 - x_d**2/c**2)", "k*x**2/2", ["x"])
    book = spring.of("m0*(1 - x_d**2/c**2)**(-3/2)*x_dd + k*x")
    energy = spring.of("m0*c**2/sqrt(1 - x_d**2/c**2) + k*x**2/2")
    H = H_of("relativistic-oscillator").subs(S("p_x"), spring.momentum("x"))
    point = {S("m0"): 2, S("c"): 3, S("k"): 5, S("x"): sp.Rational(1, 7), S("x_d"): sp.Rational(9, 5)}
    return exact(spring.equation("x") - book, spring.jacobi - energy, (H - energy).subs(point))


@result("C94", "(7-178)-(7-187)")
def hyperbolic_motion():
    """x = (c^2/g)*(sqrt(1 + g^2*t^2/c^2) - 1), v = c*tanh(g*tau/c) at t = (c/g)*sinh(g*tau/c)."""
    run = start("constant-proper-acceleration", {"x": 0}, {"x": 0}, g="1.5", c=2)
    worst = mp.zero
    for τ in (mp.mpf("0.4"), mp.mpf(1), mp.mpf(5)):
        time = mp.mpf(float(4 / mp.mpf(3) * mp.sinh(τ * mp.mpf("0.75"))))
        state = run.at(float(time))
        root = mp.sqrt(1 + (mp.mpf("0.75") * time) ** 2)
        speed = 2 * mp.tanh(mp.asinh(mp.mpf("0.75") * time))
        worst = max(worst, off(state.q["x"], mp.mpf(8) / 3 * (root - 1)), off(state.velocity["x"], speed))
    return worst


@result("C94", "(7-187), tau = 1", DIGITS_PRINTED)
def hyperbolic_motion_at_one():
    """In units of c and g: at tau = 1 x = 0.543, v = 0.762, t = 1.175."""
    run = motion("constant-proper-acceleration")
    time = run.time_at("x", float(mp.cosh(1) - 1)).value
    state = run.at(float(mp.sinh(1)))
    return max(off(state.q["x"], "0.543"), off(state.velocity["x"], "0.762"), off(time, "1.175"))


@result("C94", "Ex 7-7", 5e-3)
def journey():
    """A leg of proper time 1.76 takes the time 2.83: 7.04 and 11.32 years for four legs (the book rounds g/c)."""
    run = motion("constant-proper-acceleration")
    distance = mp.cosh(mp.mpf("1.76")) - 1
    time = mp.mpf(float(run.time_at("x", float(distance)).value))
    return max(off(time, "2.83"), off(4 * time, "11.32"), off(4 * mp.asinh(time), "7.04"))


# ------------------------------------------------------------------------------------------------ no H at all
def together(*particles: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    """Speed, angle in degrees and rest mass of what sticks together; particles as (rest mass, v_x, v_y), c = 1."""
    E, px, py = mp.zero, mp.zero, mp.zero
    for m, vx, vy in particles:
        energy = m / mp.sqrt(1 - vx**2 - vy**2)
        E, px, py = E + energy, px + energy * vx, py + energy * vy
    return mp.hypot(px, py) / E, mp.degrees(mp.atan2(py, px)), mp.sqrt(E**2 - px**2 - py**2)


@result("C96", "Ex 7-6", 1e-3)
def head_on():
    """m0 at 0.9c overtakes m0 at 0.3c (data reconstructed) and sticks: V = 0.712c, M0 = 2.348*m0."""
    V, _, M = together((mp.one, mp.mpf("0.9"), mp.zero), (mp.one, mp.mpf("0.3"), mp.zero))
    return max(off(V, "0.712"), off(M, "2.348"))


@result("C96", "P7-13", 1e-3)
def at_an_angle():
    """m0 at c/4 and m0/2 at c/2, 60 degrees apart (data reconstructed): v = 0.2943c, 31.84 degrees, 1.539*m0."""
    half, root = mp.mpf("0.25"), mp.sqrt(3) / 4
    return off(together((mp.one, half, mp.zero), (mp.mpf("0.5"), half, root)), ["0.2943", "31.84", "1.539"])


@result("C54", "(3-190)")
def forces_off_the_line():
    """Forces f12 = -f21 not along the line of centres keep the linear momentum, not the angular momentum."""
    r1, r2, f = (sp.Matrix(sp.symbols(f"{n}_x {n}_y {n}_z")) for n in ("r1", "r2", "f"))
    torque = r1.cross(f) + r2.cross(-f)
    along = torque.subs(dict(zip(f, S("s") * (r1 - r2), strict=True)))
    assert any(x != 0 for x in torque)
    return exact(torque - (r1 - r2).cross(f), along.applyfunc(sp.expand), f + -f)


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
