"""Pendulums about any place, and with several equal wells along an angle: the same forms however V is typed."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form

LETTERS = {"m": "3/2", "A": 1, "B": "1/3", "d": "2/5"}
SLOW, FAST = "1/5", 3


def _motion(potential: str, place: object, speed: object) -> hjsolve.Motion:
    names = {s.name for s in sp.sympify(potential, {"B": sp.Symbol("B")}).free_symbols} & set(LETTERS) | {"m"}
    system = hjsolve.System({"x": "angle"}, "m*dot(x)**2/2", potential, {n: LETTERS[n] for n in LETTERS if n in names})
    return hjsolve.solve(system).motion(q={"x": place}, velocity={"x": speed})


@pytest.mark.parametrize("speed", [SLOW, FAST], ids=["libration", "rotation"])
@pytest.mark.parametrize(
    ("potential", "place"),
    [
        ("-A*cos(2*x)", "1/3"),
        pytest.param("-A*cos(2*x)", 3, marks=pytest.mark.nightly),
        ("A*sin(x)**2 - A/2", -3),
        ("-A*cos(3*x)", -2),
        pytest.param("-A*cos(5*x)", "6/5", marks=pytest.mark.nightly),
        ("-A*cos(2*x) - B*sin(2*x)", "-31/10"),
        ("-A*cos(x - d)", "1/2"),
        pytest.param("-A*cos(x) + B*sin(x)", "1/2", marks=pytest.mark.nightly),
        ("A*cos(3*(x - d))", "3/2"),
    ],
)
def test_forms_are_those_of_a_pendulum_and_agree_with_the_quadratures(potential: str, place: object, speed: object):
    motion = _motion(potential, place, speed)
    form = own_form(motion)
    assert form is not None
    given = {p.name: p.value for p in motion.solution.system.parameters} | {"E": motion.initial.constants["E"]}
    for name in ("actions.x", "periods.x", "frequencies.x"):
        group, value = name.split(".")[0], form.evaluate(name, given, 40).value
        expected = getattr(motion, group)["x"].value
        assert abs(value - expected) <= 4e-15 * abs(expected)
    start = {"x_0": motion.initial.values[motion.solution.system.coordinates[0].symbol], "t_0": 0}
    place_now = form.evaluate("inverse.x", given | start | {"t": "3/10"}, 40).value
    turns = (place_now - motion.at("3/10").q["x"]) / (2 * mpmath.pi)
    assert abs(turns - mpmath.nint(turns)) < 1e-15
    assert abs(form.evaluate("inverse.x", given | start | {"t": 0}, 40).value - start["x_0"]) < 1e-30
    arrays = {name: np.array([float(v)] * 2) for name, v in (given | start).items()} | {"t": np.array([0.3, 0.0])}
    np.testing.assert_allclose(
        form.lambdify()["inverse.x"](**arrays), [float(place_now), float(start["x_0"])], rtol=4e-15
    )
    assert sp.count_ops(form.inverse["x"]) <= 16
    assert not any("Carlson" in type(f).__name__ for f in form.named()["time_law"].atoms(sp.Function))


@pytest.mark.parametrize(
    ("potential", "place", "speed"),
    [
        ("-A*cos(2*x) - B*cos(4*x)", 3, SLOW),
        pytest.param("-A*cos(2*x) - B*cos(4*x)", 3, FAST, marks=pytest.mark.nightly),
        pytest.param("-A*cos(3*x) + B*sin(6*x)", -2, SLOW, marks=pytest.mark.nightly),
        ("A/(2 + cos(2*x))", 3, SLOW),
    ],
)
def test_functions_of_multiples_alone_have_forms_too(potential: str, place: object, speed: object):
    motion = _motion(potential, place, speed)
    form = own_form(motion)
    assert form is not None
    given = {p.name: p.value for p in motion.solution.system.parameters} | {"E": motion.initial.constants["E"]}
    for name in ("actions.x", "periods.x"):
        value, expected = form.evaluate(name, given, 40).value, getattr(motion, name.split(".")[0])["x"].value
        assert abs(value - expected) <= 4e-15 * abs(expected)
    start, later = (motion.initial.values[motion.solution.system.coordinates[0].symbol], motion.at("1/10").q["x"])
    later += 2 * mpmath.pi * mpmath.nint((float(start) - later) / (2 * mpmath.pi))  # a rotation counts its turns
    law = form.evaluate("time_law", given | {"x_0": start, "x": later}, 30)
    assert abs(abs(float(law.value)) - 0.1) < 1e-13


def test_a_libration_is_in_its_well_whatever_turns_are_counted():
    form = own_form(_motion("A*cos(x)", 3, SLOW))
    assert form is not None
    given = {"m": "3/2", "A": 1, "E": "-9/10", "x_0": 3}
    here, there = (
        form.evaluate("time_law", given | {"x": x}, 20).value
        for x in (sp.Rational(13, 4), sp.Rational(13, 4) - 2 * sp.pi)
    )
    assert here == there


def test_a_turn_later_w_has_gained_the_integral_of_the_shift():
    """On the turning wire p = P − A with A = m r² w (cos θ − 1): W(θ) − W(θ − 2π) = −∮ A dθ = 2π m r² w."""
    arguments = hjsolve.catalog.describe("bead-on-turning-wire").motions["default"].arguments
    form = own_form(hjsolve.solve("bead-on-turning-wire").motion(**arguments))
    assert form is not None
    given = {"m": 2, "r": "1/2", "w": 3, "E": "-1/5", "theta_0": 3}
    places = sp.Rational(31, 10), sp.Rational(31, 10) - 2 * sp.pi
    here, before = (form.evaluate("characteristic_function", given | {"theta": θ}, 30).value for θ in places)
    assert abs(here - before - 3 * mpmath.pi) < 1e-14
    arrays = {name: float(sp.sympify(v)) for name, v in given.items()} | {"theta": np.array([float(θ) for θ in places])}
    np.testing.assert_allclose(
        form.lambdify()["characteristic_function"](**arrays), [float(here), float(before)], rtol=4e-15
    )


def test_every_well_has_a_regime_of_its_own_that_says_where_it_is():
    forms = hjsolve.closed_forms(_motion("-A*cos(2*x)", "1/3", SLOW).solution)
    wells = [form for form in forms if form.regime.kinds["x"] == "libration"]
    assert len(wells) == 2
    assert {str(form.regime).rsplit(";", 1)[1].strip() for form in wells} == {"x about 0", "x about pi"}
    assert sum(form.regime.kinds["x"] == "rotation" for form in forms) == 1


def test_a_shift_typed_as_two_terms_is_named():
    """E of the bottom of the well is −√(A² + B²), where sn has k = 0."""
    motion = _motion("-A*cos(x) - B*sin(x)", "1/2", SLOW)
    form = own_form(motion)
    assert form is not None
    assert form.inverse["x"].has(sp.atan2)
    A, B = (motion.solution.system.symbols[name] for name in "AB")
    period = form.periods["x"].subs(form.where).subs(form.where)
    at_rest = period.subs({A: 1, B: sp.Rational(1, 3), "m": 1})
    (E,) = (s for s in at_rest.free_symbols if s.name == "E")
    (m,) = (s for s in at_rest.free_symbols if s.name == "m")
    small = at_rest.subs(m, 1).limit(E, -sp.sqrt(10) / 3)
    assert float(small) == pytest.approx(2 * math.pi / (10 / 9) ** 0.25, rel=1e-14)


@pytest.mark.parametrize(
    ("domain", "potential", "place"),
    [
        ("angle", "-A*cos(x)", 2),
        ("angle", "-A*cos(2*x)", -20),
        ("angle", "-A*cos(x) - B*sin(x)", 20),
        ("line", "-A*cos(x/B)", 3),
        pytest.param("angle", "-A*cos(3*x) - B*cos(6*x)", 2, marks=pytest.mark.nightly),
        pytest.param("angle", "A/(2 + cos(x))", 2, marks=pytest.mark.nightly),
    ],
)
def test_time_and_action_of_a_rotation_go_on_through_every_turn(domain: str, potential: str, place: int):
    """Against the quadrature of m/p and p by mpmath, which sees no turns."""
    names = [name for name in ("A", "B", "m") if name in potential or name == "m"]
    values = {name: sp.Rational(LETTERS[name]) for name in names}
    system = hjsolve.System({"x": domain}, "m*dot(x)**2/2", potential, values)
    motion = hjsolve.solve(system).motion(q={"x": place}, velocity={"x": FAST})
    form, ends = own_form(motion), (sp.Rational(7, 2), sp.Integer(9), sp.Integer(-7))
    assert form is not None
    given = values | {"E": motion.initial.constants["E"], "x_0": place}
    V = sp.lambdify("x", sp.sympify(potential).subs({sp.Symbol(n): v for n, v in values.items()}), "mpmath")
    with mpmath.workdps(30):
        numbers = {n: mpmath.mpf(str(sp.N(v, 40))) for n, v in given.items()}

    def slowness(q: mpmath.mpf) -> mpmath.mpf:
        return numbers["m"] / momentum(q)

    def momentum(q: mpmath.mpf) -> mpmath.mpf:
        return mpmath.sqrt(2 * numbers["m"] * (numbers["E"] - V(q)))

    for name, integrand in (("time_law", slowness), ("characteristic_function", momentum)):
        found = []
        for end in ends:
            with mpmath.workdps(30):
                stop = mpmath.mpf(str(end.evalf(40)))
                path = mpmath.linspace(numbers["x_0"], stop, 2 + 2 * int(abs(stop - place)))
                expected = mpmath.quad(integrand, path, method="gauss-legendre")
                value = form.evaluate(name, given | {"x": end}, 25).value
                assert abs(value - expected) <= mpmath.mpf(10) ** -24 * abs(expected)
                assert abs(form.lambdify("mpmath")[name](**numbers, x=stop) / expected - 1) < mpmath.mpf(10) ** -14
                found.append(float(value))
        arrays = {n: np.full(len(ends), float(v)) for n, v in numbers.items()}
        doubles = form.lambdify()[name](**arrays, x=np.array([float(end) for end in ends]))
        np.testing.assert_allclose(doubles, found, rtol=4e-15)
