"""q(t) and orbits of systems that books name, against the motion that the engine computes, far beyond the turning points.

Kepler + b/r³ and Schwarzschild's orbit: Whittaker, Analytical dynamics § 48, Chandrasekhar, Black holes § 19; Duffing,
the bead on a turning wire, the spherical pendulum and Lagrange's top: Whittaker §§ 34, 55, 71.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(3)

t, t_0 = sp.symbols("t t_0", real=True)
TIMES = ("0.3", "2.5", "17")


def _constants(motion: hjsolve.Motion, form: RegimeForms) -> dict[str, sp.Expr]:
    """Name → exact value, of every symbol of a form but t and the coordinates, on the branch it starts on."""
    solution, at = motion.solution, motion.initial.values
    values = {p.name: at[p.symbol] for p in solution.system.parameters} | dict(motion.initial.constants)
    values |= {limit.name: at[solution.system.coordinate(n).symbol] for n, limit in solution.lower_limits.items()}
    for equation in solution.orbit_equations.values():
        (beta,) = (s for s in equation.lhs.free_symbols)
        start = equation.rhs.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
        values[beta.name] = -start.xreplace(dict(at)).xreplace({t: motion.t0})
    return values | {"t_0": motion.t0}


def _value(form: RegimeForms, name: str, values: Mapping[str, sp.Expr]) -> float:
    held = {s.name for s in (*form.regime.example, *form.written_out(name).free_symbols)}
    return float(form.evaluate(name, {n: v for n, v in values.items() if n in held}).value)


@pytest.mark.rotating(3)
@pytest.mark.nightly_cases(
    "lagrange-top-theta-q6-velocity6", "spherical-pendulum-theta-q5-velocity5", "bead-on-turning-wire-theta-q2-velocity2"
)
@pytest.mark.parametrize(("name", "coordinate", "q", "velocity"), [
    ("double-well", "x", {"x": "1.1"}, {"x": "0.1"}), ("double-well", "x", {"x": "0.1"}, {"x": 2}),
    ("bead-on-turning-wire", "theta", {"theta": "0.3"}, {"theta": "0.2"}),
    ("bead-on-turning-wire", "theta", {"theta": "0.3"}, {"theta": 3}), ("pendulum", "theta", {"theta": "0.3"}, {"theta": 9}),
    ("spherical-pendulum", "theta", {"theta": "0.7", "phi": 0}, {"theta": "0.2", "phi": "1.3"}),
    ("lagrange-top", "theta", {"theta": "0.7", "phi": 0, "psi": 0}, {"theta": "0.2", "phi": "0.4", "psi": "5"}),
])  # fmt: skip
def test_in_time(name: str, coordinate: str, q: dict, velocity: dict) -> None:
    motion = hjsolve.solve(name).motion(q=q, velocity=velocity)
    form = own_form(motion)
    assert form is not None
    values = _constants(motion, form)
    for moment in TIMES:
        expected = motion.at(moment).q[coordinate]
        got = _value(form, f"inverse.{coordinate}", values | {"t": sp.Rational(moment)})
        turned = (
            math.remainder(got - expected, 2 * math.pi) if motion.kinds[coordinate] == "rotation" else got - expected
        )
        assert abs(turned) <= 2e-12 * max(abs(expected), abs(got), 0.1), (moment, got, expected)


@pytest.mark.nightly_cases("stark-q2-velocity2", "two-centres-plane-q0-velocity0")
@pytest.mark.parametrize(("name", "q", "velocity"), [
    ("two-centres-plane", {"xi": "0.9", "eta": "0.4"}, {"xi": "0.1", "eta": "0.1"}),
    ("liouville-p5-6", {"q1": "0.3", "q2": "3"}, {"q1": "0.5", "q2": "0.4"}),
    ("stark", {"u": "1.1", "v": "0.9", "phi": 0}, {"u": "0.1", "v": "0.1", "phi": "0.5"}),
])  # fmt: skip
def test_in_the_time_that_decouples(name: str, q: dict, velocity: dict) -> None:
    """At one τ both coordinates are where a motion is at one time; of two centres ξ(τ) by the slope dξ/dτ = p/|∂p²/2∂α|."""
    motion = hjsolve.solve(name).motion(q=q, velocity=velocity)
    form = own_form(motion)
    assert form is not None
    values, solution = _constants(motion, form), motion.solution
    key = next(c.symbol for n, c in solution.constants.items() if n.startswith("alpha"))
    assert form.parametric
    for moment in ("0.2", "0.35", "0.6"):
        for coordinate in form.regime.kinds:
            there, step = sp.Rational(moment), sp.Rational(1, 1000)
            a, b, c, d = (
                sp.Float(_value(form, f"parametric.{coordinate}", values | {"tau": there + k * step}), 20)
                for k in (-2, -1, 1, 2)
            )
            slope = float((a - 8 * b + 8 * c - d) / (12 * step))
            place = _value(form, f"parametric.{coordinate}", values | {"tau": there})
            square = solution.momentum_squared[coordinate]
            at = {s: values[s.name] for s in square.free_symbols | {key} if s.name in values}
            at[solution.system.coordinate(coordinate).symbol] = sp.Float(place, 25)
            p2, N = (float(sp.N(e.xreplace(at), 20)) for e in (square, sp.diff(square, key) / 2))
            assert abs(slope**2 - p2 / N**2) <= 1e-8 * (slope**2 + abs(p2 / N**2)), (coordinate, moment)
    if set(form.regime.kinds) <= set(form.parametric):
        one, two = form.regime.kinds
        first, second = (_value(form, f"parametric.{n}", values | {"tau": sp.Rational("0.1")}) for n in (one, two))
        passed = motion.orbit(two, along=one, values=[first])
        assert abs(float(passed[0]) - second) <= 1e-10 * abs(second)


@pytest.mark.parametrize("potential", ["-k/r + b/r**2", "-k/r - b/r**3", "-k/r + b/r**3"])
def test_orbits_of_perturbed_kepler_problems(potential: str) -> None:
    """r(θ): a conic that turns; sn² of θ where u = 1/r obeys a cubic."""
    system = hjsolve.System(
        coordinates={"r": "0 < r", "theta": "angle"}, kinetic="(dot(r)**2 + r**2*dot(theta)**2)/2", potential=potential,
        parameters={"k": 1, "b": "0.03"},
    )  # fmt: skip
    motion = hjsolve.solve(system).motion(q={"r": 1, "theta": "0.2"}, velocity={"r": "0.3", "theta": "1.1"})
    form = own_form(motion)
    assert form is not None
    assert motion.kinds["r"] == "libration"
    values = _constants(motion, form)
    for moment in TIMES:
        state = motion.at(moment)
        got = _value(form, "orbit.r", values | {"theta": sp.Rational(float(state.unwrapped("theta")))})
        assert abs(got - state.q["r"]) <= 1e-11 * state.q["r"], (moment, got, state.q["r"])


@pytest.mark.nightly
def test_schwarzschilds_orbit() -> None:
    """r along the orbit by sn², bound; in the equation of the separation constant θ is the other coordinate."""
    entry = hjsolve.catalog.describe("schwarzschild")
    motion = hjsolve.solve("schwarzschild").motion(**entry.motions["default"].arguments)
    form = own_form(motion)
    assert form is not None
    assert {s.name for s in form.written_out("orbit.r").free_symbols} >= {"theta", "theta_0", "r_0"}
    assert {"r", "theta", "phi"} <= set(form.actions)
    assert {"r", "theta", "phi"} <= set(form.frequencies)


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "count"), [("kepler-parabolic", 6), ("liouville-p5-6", 8)])
def test_every_general_regime_has_its_orbit(name: str, count: int) -> None:
    """The pieces of a regime are tried at one motion, whichever motions they were found with."""
    found = [form for form in forms(name) if not form.regime.special]
    assert len(found) >= count
    assert all(set(form.orbit) == set(form.solution.coordinates) for form in found)
