"""Systems of several coordinates as a teacher types them: forms against quadratures, and how they are written."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms

pytestmark = pytest.mark.rotating_file(3)

PLANE = {"r": "0 < r", "phi": "angle"}
FLAT = "m*(dot(r)**2 + r**2*dot(phi)**2)/2"
TURNING = "m*(dot(r)**2 + r**2*(dot(phi) + Om)**2)/2"
VALUES = {"m": "3/2", "k": 2, "b": "1/7", "c": "1/3", "Om": "1/3", "R": "4/3", "g": 1, "l": "2/3", "A": 1}


def _motion(
    kinetic: str, potential: str, q: Mapping[str, str], velocity: Mapping[str, str], domains: Mapping[str, str] = PLANE
) -> hjsolve.Motion:
    held = {s.name for text in (kinetic, potential) for s in sp.sympify(text, {"S": sp.Symbol("S")}).free_symbols}
    system = hjsolve.System(domains, kinetic, potential, {n: v for n, v in VALUES.items() if n in held})
    return hjsolve.solve(system).motion(q=q, velocity=velocity)


def _form(motion: hjsolve.Motion) -> RegimeForms:
    form = own_form(motion)
    assert form is not None
    return form


def _constants(motion: hjsolve.Motion) -> dict[str, object]:
    parameters = {p.name: p.value for p in motion.solution.system.parameters}
    return parameters | dict(motion.initial.constants)


def _at(form: RegimeForms, name: str, given: Mapping[str, object]) -> mpmath.mpf:
    """A form at numbers, of which some may be those of other forms."""
    held = {s.name for s in form.written_out(name).free_symbols} | {s.name for s in form.regime.example}
    return form.evaluate(name, {n: v for n, v in given.items() if n in held}, 30).value


def _numbers_agree(form: RegimeForms, motion: hjsolve.Motion, *groups: str) -> None:
    given = _constants(motion)
    for group in groups:
        for name, expected in getattr(motion, group).items():
            value = form.evaluate(f"{group}.{name}", given, 30).value
            assert abs(value - expected.value) <= 1e-14 * abs(expected.value)


KEPLER = {"q": {"r": "1", "phi": "0"}, "velocity": {"r": "1/5", "phi": "4/5"}}


@pytest.mark.parametrize(
    ("kinetic", "potential", "expected"),
    [
        (FLAT, "-k/r + c", "c - k**2*m/(2*(J_r + Abs(J_phi))**2)"),
        (TURNING, "-k/r", "-J_phi*Om - k**2*m/(2*(J_r + Abs(J_phi))**2)"),
    ],
)
def test_energies_are_those_of_kepler_with_a_term_more(kinetic: str, potential: str, expected: str):
    motion = _motion(kinetic, potential, **KEPLER)
    form = _form(motion)
    assert str(form.energy) == expected
    _numbers_agree(form, motion, "actions", "periods", "frequencies")
    assert not any(form.periods[name].has(sp.Abs, sp.sign) for name in (("r", "phi") if "c" in expected else ("r",)))


def test_eccentricities_are_one_and_a_product():
    form = _form(_motion(FLAT, "-k/r + c", q={"r": "1", "phi": "0"}, velocity={"r": "1/5", "phi": "12/5"}))
    where = {symbol.name: str(meaning) for symbol, meaning in form.where.items()}
    assert where["a"] == "k/(2*(E - c))"
    assert where["e"] == "sqrt(1 + 2*p_phi**2*(E - c)/(k**2*m))"
    # tan ½ν = √((e + 1)/(e − 1)) tanh ½ξ
    assert str(form.anomaly["phi"]) == "phi_p + 2*atan(sqrt(e + 1)*tanh(xi/2)/sqrt(e - 1))*sign(p_phi)"
    e, ξ = 1.7, 0.8
    ν = 2 * math.atan(math.sqrt((e + 1) / (e - 1)) * math.tanh(ξ / 2))
    assert e * math.cosh(ξ) - 1 == pytest.approx((e * e - 1) / (1 + e * math.cos(ν)), rel=1e-14)


@pytest.mark.parametrize(
    ("potential", "place"),
    [("k*r**2/2 + b*cos(phi)/r**2", "1"), pytest.param("-k/r + b*cos(phi)**2/r**2", "5/2", marks=pytest.mark.nightly)],
)
def test_an_angle_that_goes_round_is_not_an_arc_that_turns_back(potential: str, place: str):
    """φ(t) and φ(ξ) at places half a turn and a turn later: asin(cn u) would be that of a libration."""
    motion = _motion(FLAT, potential, q={"r": "1", "phi": place}, velocity={"r": "1/5", "phi": "6/5"})
    form = _form(motion)
    assert motion.kinds["phi"] == "rotation"
    given: dict[str, object] = _constants(motion) | {"r_0": 1, "phi_0": sp.sympify(place), "t_0": 0}
    given |= {"beta_2": -_at(form, "orbit_equations.alpha_2", given | {"r": 1, "phi": sp.sympify(place)})}
    period = motion.periods["phi"].value
    if "phi" in form.inverse:
        for part in (0.3, 0.55, 0.8, 1.2):
            state = motion.at(part * period)
            expected = state.q["phi"] + 2 * math.pi * state.turns["phi"]
            got = _at(form, "inverse.phi", given | {"t": sp.Rational(repr(part * period))})
            assert abs(got - expected) <= 1e-12 * abs(expected)
        return
    places = []
    for ξ in np.linspace(0.5, 20, 14):
        here = given | {"xi": sp.Rational(repr(float(ξ)))}
        t = float(_at(form, "anomaly.t", here))
        state = motion.at(t)
        places.append(state.q["phi"] + 2 * math.pi * state.turns["phi"])
        got = float(_at(form, "anomaly.phi", here))
        assert abs(got - places[-1]) <= 1e-12 * abs(places[-1])
    assert max(places) > 2 * math.pi


def test_letters_without_signs_have_the_root_of_a_quotient():
    motion = _motion(
        "A*dot(x)**2/2 + m*l**2*dot(theta)**2/2", "-m*g*l*cos(theta)", {"x": "0", "theta": "1/3"},
        {"x": "1/5", "theta": "1/3"}, {"x": "line", "theta": "angle"},
    )  # fmt: skip
    form = _form(motion)
    assert str(form.periods["theta"]) == "4*sqrt(l/g)*elliptic_k(k**2)"
    assert {str(r) for r in form.regime.relations} >= {"g*l > 0"}
    _numbers_agree(form, motion, "actions", "periods", "frequencies")


HYPERBOLIC = "m*R**2*(dot(chi)**2 + sinh(chi)**2*dot(phi)**2)/2"


def test_functions_of_twice_the_argument_have_elementary_forms():
    """The oscillator of the hyperbolic plane: y² is a quartic in cosh χ, a quadratic in cosh 2χ."""
    motion = _motion(
        HYPERBOLIC, "k*R**2*tanh(chi)**2/2", {"chi": "1/2", "phi": "1/2"}, {"chi": "1/5", "phi": "4/5"},
        {"chi": "0 < chi", "phi": "angle"},
    )  # fmt: skip
    form = _form(motion)
    assert {"chi", "phi"} <= set(form.inverse)
    assert not any(value.has(sp.elliptic_k, sp.elliptic_pi) for value in form.named().values())
    _numbers_agree(form, motion, "actions", "periods", "frequencies")
    # Higgs, J. Phys. A 12 (1979) 309, with R² → −R²
    J, L, m, k, R = sp.symbols("J_chi J_phi m k R", real=True)
    N = 2 * J + sp.Abs(L)
    expected = {J: 0.3, L: 0.2, m: 1.5, k: 2, R: sp.Rational(4, 3)}
    made = form.energy
    assert made is not None
    written = made.xreplace({s: expected[t] for s in made.free_symbols for t in expected if s.name == t.name})
    Higgs = N * sp.sqrt(k / m) - N**2 / (2 * m * R**2)
    assert float(written) == pytest.approx(float(Higgs.subs(expected)), rel=1e-14)


def test_kepler_in_the_hyperbolic_plane_has_the_energy_of_a_book():
    motion = _motion(
        HYPERBOLIC, "-k*cosh(chi)/(R*sinh(chi))", {"chi": "1/2", "phi": "1/2"}, {"chi": "1/5", "phi": "4/5"},
        {"chi": "0 < chi", "phi": "angle"},
    )  # fmt: skip
    form = _form(motion)
    assert str(form.energy) == "-k**2*m/(2*(J_chi + Abs(J_phi))**2) - (J_chi + Abs(J_phi))**2/(2*R**2*m)"
    _numbers_agree(form, motion, "actions", "periods", "frequencies")


@pytest.mark.parametrize(("place", "speed"), [("7/2", "1/5"), ("-19/3", "1/5"), ("7/2", "3")])
def test_along_a_line_every_cell_of_a_lattice_has_the_form_of_the_first(place: str, speed: str):
    motion = _motion("m*dot(x)**2/2", "-A*cos(x/b)", {"x": place}, {"x": speed}, {"x": "line"})
    form = _form(motion)
    if motion.kinds["x"] == "libration":
        assert str(form.regime).endswith("; x about 0, or whole periods 2*pi*b from there")
    given = _constants(motion) | {"x_0": sp.Rational(place), "t_0": 0}
    for t in ("1/50", "1/3", "5/2"):
        expected = motion.at(t).q["x"]
        assert abs(form.evaluate("inverse.x", given | {"t": t}, 30).value - expected) <= 1e-14 * abs(expected)
        numbers = {n: float(sp.sympify(v)) for n, v in given.items()}
        np.testing.assert_allclose(
            form.lambdify()["inverse.x"](**numbers, t=np.array([float(sp.Rational(t))])), [expected], rtol=4e-14
        )
    near = sp.Rational(repr(float(motion.at("1/50").q["x"])))
    assert float(_at(form, "time_law", given | {"x": near})) == pytest.approx(0.02, rel=1e-12)


@pytest.mark.parametrize("place", ["1/5", "5/2"])
def test_a_rotation_over_equal_barriers_begins_at_any_place(place: str):
    """−A cos 2x repeats itself twice along the angle: the form about either well holds for both."""
    form = _form(_motion("m*dot(x)**2/2", "-A*cos(2*x)", {"x": "5/2"}, {"x": "3"}, {"x": "angle"}))
    motion = _motion("m*dot(x)**2/2", "-A*cos(2*x)", {"x": place}, {"x": "3"}, {"x": "angle"})
    given = _constants(motion) | {"x_0": sp.Rational(place), "t_0": 0}
    for t in ("1/3", "5/2"):
        state = motion.at(t)
        expected = state.q["x"] + 2 * math.pi * state.turns["x"]
        assert abs(form.evaluate("inverse.x", given | {"t": t}, 30).value - expected) <= 1e-14 * abs(expected)


def test_energies_hold_whole_squares_and_momenta_along_lines():
    """Hartmann's ring, and Landau's levels across an electric field: E = J|ω| − E₀ p/B − m E₀²/2B²."""
    hartmann = _motion(
        "m*(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)/2", "-k/r + b/(r**2*sin(theta)**2)",
        {"r": "1", "theta": "1", "phi": "0"}, {"r": "1/5", "theta": "1/4", "phi": "2/3"},
        {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"},
    )  # fmt: skip
    energy = _form(hartmann).energy
    assert str(energy) == "-k**2*m/(2*(J_r + J_theta + sqrt(J_phi**2 + 2*b*m))**2)"
    crossed = _motion(
        "m*(dot(x)**2 + dot(y)**2)/2 + c*x*dot(y)", "-k*x", {"x": "1/2", "y": "1/3"}, {"x": "1/5", "y": "1/3"},
        {"x": "line", "y": "line"},
    )  # fmt: skip
    energy, constants = _form(crossed).energy, crossed.initial.constants
    assert energy is not None
    J, p, c, k, m = crossed.actions["x"].value, float(constants["p_y"]), 1 / 3, 2, 1.5
    given = {"J_x": J, "p_y": p, "c": c, "k": k, "m": m}
    landau = J * c / m - k * p / c - m * k**2 / (2 * c**2)
    assert float(energy.xreplace({s: sp.Float(given[s.name]) for s in energy.free_symbols})) == pytest.approx(landau)
    assert landau == pytest.approx(float(constants["E"]), rel=1e-13)
