"""Elliptic forms: against the engine, in the shapes that books print, and across separatrices."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.inverses import _value
from hjsolve.closed_form.named_quantities import NamedQuantities
from hjsolve.functions import JacobiSN
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(5)

t, t_0 = sp.symbols("t t_0", real=True)

MOTIONS = [
    ("double-well", {"x": "1.1"}, {"x": "0.1"}, {}), ("double-well", {"x": "0.1"}, {"x": 2}, {}),
    ("pendulum", {"theta": "0.4"}, {"theta": "1.5"}, {}), ("pendulum", {"theta": "0.4"}, {"theta": 9}, {}),
    ("spherical-pendulum", {"theta": "0.7", "phi": 0}, {"theta": "0.2", "phi": "1.3"}, {}),
    ("rod-spherical-pendulum", {"theta": "2", "phi": 0}, {"theta": "0.2", "phi": "1.3"}, {}),
    ("bead-on-turning-wire", {"theta": "2.9"}, {"theta": "0.2"}, {}),
    ("bead-on-turning-wire", {"theta": "0.4"}, {"theta": "5.3"}, {}),
    ("rod-against-moving-wall", {"theta": "0.4"}, {"theta": "7.3"}, {}),
    ("oblate-geodesics", {"beta": "0.3", "lambda_": 0}, {"beta": "0.5", "lambda_": "0.7"}, {}),
]  # fmt: skip


@pytest.mark.rotating(3)
@pytest.mark.nightly_cases("rod-against-moving-wall-q8-velocity8-parameters8")
@pytest.mark.parametrize(("name", "q", "velocity", "parameters"), MOTIONS)
def test_numbers_agree_with_the_engine_to_36_digits(name: str, q: dict, velocity: dict, parameters: dict) -> None:
    motion = hjsolve.solve(name).motion(q=q, velocity=velocity, parameters=parameters, digits=40)
    form = own_form(motion)
    assert form is not None
    exact = {p.name: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}
    exact |= dict(motion.initial.constants)
    compared = 0
    for group in ("actions", "frequencies", "periods"):
        known, derived = getattr(motion, group), getattr(form, group)
        assert set(known) == set(derived), (group, form.why_not)
        for key in known:
            held = {s.name for s in (*form.regime.example, *derived[key].free_symbols)}
            value = form.evaluate(f"{group}.{key}", {n: v for n, v in exact.items() if n in held}, 40)
            assert abs(value.value - known[key].value) <= 1e-36 * abs(known[key].value), (group, key)
            compared += 1
    assert compared >= 3


@pytest.mark.nightly_cases(
    "lagrange-top-turning-frame-libration", "rod-against-moving-wall-asymptotic",
    "rod-against-moving-wall-libration",
)  # fmt: skip
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("turntable-slot", "asymptotic"), ("rod-against-moving-wall", "asymptotic"),
        ("rod-against-moving-wall", "libration"), ("lagrange-top-turning-frame", "libration"),
        pytest.param("torus-geodesics", "asymptotic", marks=pytest.mark.nightly),
    ],
)  # fmt: skip
def test_every_integral_of_these_regimes_has_a_form(name: str, kind: str) -> None:
    """Places of rest inside the domain or at the cut of an angle, and two curves of a coordinate with named roots."""
    own = [f for f in forms(name) if kind in f.regime.kinds.values()]
    assert own
    for form in own:
        assert [k for k in form.why_not if not k.startswith(("inverse", "energy"))] == []
        assert form.time_law is not None


@pytest.mark.nightly
def test_pendulum_is_the_printed_one() -> None:
    """θ(t) = 2 asin(k sn(√(g/l) (t − t₀), k)), period 4K(k)√(l/g), k² = (E + mgl)/(2mgl) (Whittaker § 44)."""
    form = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "libration")
    known = {s.name: s for s in form.written_out("inverse.theta").free_symbols | form.periods["theta"].free_symbols}
    E, m, g, l_, θ_0 = (known[n] for n in ("E", "m", "g", "l", "theta_0"))
    k2 = (E + m * g * l_) / (2 * m * g * l_)
    printed = 2 * sp.asin(sp.sqrt(k2) * JacobiSN(sp.sqrt(g / l_) * (t - t_0), k2))
    at = {E: sp.Rational(1, 3), m: sp.Rational(11, 10), g: 9, l_: sp.Rational(3, 2), t_0: sp.Rational(1, 5)}
    for time in (sp.Rational(1, 4), sp.Rational(7, 3), sp.S(50)):
        one = sp.N(form.written_out("inverse.theta").subs(θ_0, 0).xreplace(at | {t: time}), 50)
        assert abs(one - sp.N(printed.xreplace(at | {t: time}), 50)) < sp.Float(10) ** -40
    period = sp.N((form.periods["theta"] - 4 * sp.sqrt(l_ / g) * sp.elliptic_k(k2)).xreplace(at), 50)
    assert abs(period) < sp.Float(10) ** -40


def test_three_regimes_of_the_pendulum() -> None:
    kinds = {f.regime.kinds["theta"]: f for f in forms("pendulum")}
    assert set(kinds) == {"libration", "rotation", "asymptotic"}
    assert not kinds["asymptotic"].periods
    assert not kinds["asymptotic"].actions
    assert kinds["asymptotic"].time_law is not None


@pytest.mark.parametrize("distance", ["-1/10", "-1/10**12", "0", "1/10**12", "1/10"])
def test_no_pendulum_form_crosses_the_separatrix(distance: str) -> None:
    solution = hjsolve.solve("pendulum")
    exact = {p.symbol: p.value for p in solution.system.parameters}
    height = math.prod(p.value for p in solution.system.parameters if p.name in "mgl")
    (E,) = (c.symbol for c in solution.constants.values())
    off = sp.sympify(distance)
    holding = [f.regime.kinds["theta"] for f in forms("pendulum") if f.regime.holds(exact | {E: height + off})]
    assert holding == (["asymptotic"] if off == 0 else ["libration"] if off < 0 else ["rotation"])


def test_wells_of_duffing() -> None:
    """Over the barrier one form, below it one for each well; the left one mirrors the right one."""
    bounded = [f for f in forms("double-well") if not f.regime.special]
    ends = {tuple(sp.N(e.xreplace(dict(f.regime.example))) > 0 for e in f.turning_points["x"]) for f in bounded}
    assert ends == {(False, True), (True, True), (False, False)}


def test_functions_of_numpy() -> None:
    form = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "libration")
    period = form.lambdify("numpy")["periods.theta"]
    energies = np.array([-9.0, -1.0, 5.0, 20.0])
    values = period(E=energies)
    assert np.isnan(values[-1])
    assert not np.any(np.isnan(values[:3]))
    for energy, value in zip(energies[:3], values[:3], strict=True):
        far = form.evaluate("periods.theta", {"E": sp.Rational(str(energy))}, 30).value
        assert abs(value - float(far)) <= 4e-15 * float(far)


@pytest.mark.nightly_cases("two-centres-plane")
@pytest.mark.parametrize("name", ["two-centres-plane", "double-pendulum-small"])
def test_motions_of_the_catalog(name: str) -> None:
    """A rotation over a cosine squared, on a curve of genus 2 that X = sin² makes elliptic; radicals within radicals."""
    data = hjsolve.catalog.describe(name).motions["default"].arguments
    test_numbers_agree_with_the_engine_to_36_digits(name, data["q"], data["velocity"], {})


@pytest.mark.nightly_cases("2", "1", "3")
@pytest.mark.parametrize("seed", [1, 2, 3, pytest.param(4, marks=pytest.mark.nightly)])
def test_angles_with_a_squared_cosine(seed: int) -> None:
    """Rotations and librations about either place of rest, in potentials nobody chose."""
    draw = random.Random(seed)
    a, b = (sp.Rational(draw.randint(-30, 30), 10) for _ in range(2))
    system = hjsolve.System(
        coordinates={"theta": "angle"}, kinetic="dot(theta)**2/2", potential="a*cos(theta) + b*cos(theta)**2",
        parameters={"a": a, "b": b},
    )  # fmt: skip
    for place, speed in ((draw.randint(-31, 31), draw.randint(1, 9)), (draw.randint(-31, 31), draw.randint(40, 60))):
        q, v = {"theta": sp.Rational(place, 10)}, {"theta": sp.Rational(speed, 10)}
        motion = hjsolve.solve(system).motion(q=q, velocity=v, digits=40)
        form = own_form(motion)
        assert form is not None
        exact = {"a": a, "b": b, "E": motion.initial.constants["E"]}
        for group in ("actions", "frequencies", "periods"):
            derived, known = getattr(form, group), getattr(motion, group)
            assert set(derived) == set(known), form.why_not
            for key, expression in derived.items():
                held = {s.name for s in (*form.regime.example, *expression.free_symbols)}
                value = form.evaluate(f"{group}.{key}", {n: w for n, w in exact.items() if n in held}, 40)
                assert abs(value.value - known[key].value) <= 1e-36 * abs(known[key].value)


@pytest.mark.parametrize(("name", "q", "velocity"), [
    ("dumbbell-in-bowl", {"theta": "0.9"}, {"theta": "0.2"}),
    ("cone", {"r": "1.1", "phi": 0}, {"r": "0.3", "phi": "1.2"}),
])  # fmt: skip
def test_forms_with_complex_roots_and_double_poles(name: str, q: dict, velocity: dict) -> None:
    """Carlson's integrals: a complex pair next to two real roots, and a double pole at infinity."""
    test_numbers_agree_with_the_engine_to_36_digits(name, q, velocity, {})


def test_a_name_that_rests_on_what_drops_out_of_a_form_is_left_to_the_form_written_out() -> None:
    """Geodesics of an oblate spheroid ended in a KeyError: a name held a symbol that has no number, and cancels."""
    x, unknown, c, d = sp.symbols("x unknown c d", real=True)
    names = NamedQuantities((), (), (), {c: x + unknown, d: x**2}, {x: mpmath.mpf(3)})
    assert names.at(c - unknown + d, names.numbers) == {x: 3, d: 9}
    assert _value(c - unknown + d, names, {x: mpmath.mpf(3), unknown: mpmath.mpf(7)}) == 12
    assert _value(sp.Add(c, -unknown, d), names, {x: mpmath.mpf(3), unknown: mpmath.mpf(-1)}) == 12


@pytest.mark.nightly
def test_geodesics_of_an_oblate_spheroid_have_forms_along_the_motion() -> None:
    for form in forms("oblate-geodesics"):
        assert {"anomaly.beta", "anomaly.t"} <= set(form.named()), form.regime.words
