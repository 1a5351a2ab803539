"""Forms on curves without any real branch point, and of integrands with complex poles, in the catalog's systems."""

from __future__ import annotations

from functools import cache

import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.motion.motion import Motion

pytestmark = pytest.mark.rotating_file(1)

SYSTEMS = {
    "slider-on-pivoted-bar": ("slider-on-pivoted-bar", {"r": "0.5", "theta": 0}, {"r": 2, "theta": "0.3"}),
    "over a quartic": (
        hjsolve.System(
            coordinates={"x": "line"}, kinetic="m*dot(x)**2/2", potential="-(x**4 + a*x**3 + b*x**2 + c*x)/2",
            parameters={"m": "3/2", "a": "7/10", "b": "11/5", "c": "-13/10"},
        ),
        {"x": "-1.3"}, {"x": "2.9"},
    ),
}  # fmt: skip


@cache
def started(name: str) -> tuple[Motion, RegimeForms]:
    system, q, velocity = SYSTEMS[name]
    motion = hjsolve.solve(system).motion(q=q, velocity=velocity, digits=40)
    form = own_form(motion)
    assert form is not None
    return motion, form


def given(motion: Motion, t: sp.Expr) -> dict[str, object]:
    """Names of parameters, constants, coordinates and lower limits, the latter where the motion was at t₀."""
    names = [c.name for c in motion.solution.system.coordinates]
    begin, here = motion.at(motion.t0), motion.at(t)
    values = {p.name: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}
    values |= {**motion.initial.constants, "t_0": motion.t0, "t": t}
    return values | {f"{n}_0": begin.unwrapped(n) for n in names} | {n: here.unwrapped(n) for n in names}


def evaluated(form: RegimeForms, name: str, values: dict[str, object]) -> object:
    held = {s.name for s in (*form.regime.example, *form.written_out(name).free_symbols)}
    texts = {n: v if isinstance(v, sp.Expr) else str(v) for n, v in values.items() if n in held}
    return form.evaluate(name, texts, 32).value


@pytest.mark.nightly_cases("1/3-over a quartic", "1/3-slider-on-pivoted-bar", "1/50-slider-on-pivoted-bar")
@pytest.mark.parametrize("name", list(SYSTEMS))
@pytest.mark.parametrize("t", ["1/50", "1/7", "1/3"])
def test_time_law_inverse_and_w_along_the_motion(name: str, t: str) -> None:
    """The forms on a curve without a real branch point, against the engine's states and W with 40 digits."""
    motion, form = started(name)
    assert [k for k in form.why_not if not k.startswith(("inverse", "energy"))] == []
    assert any(len(region.roots) == 0 and curve.degree == 4 for curve, region in form.regime.regions)
    time = sp.Rational(t)
    values = given(motion, time)
    with mp.workdps(40):
        assert abs(evaluated(form, "time_law", values) - mpf(time.p) / time.q) < 1e-28
    along, begin = (
        motion.characteristic_function(time).value,
        evaluated(form, "characteristic_function", given(motion, motion.t0)),
    )
    assert abs(evaluated(form, "characteristic_function", values) - begin - along) <= 1e-28 * (1 + abs(along))
    for coordinate in form.inverse:
        if "x" in coordinate:
            assert abs(evaluated(form, f"inverse.{coordinate}", values) - values[coordinate]) < 1e-28


@pytest.mark.nightly
def test_numpy_and_c_text_of_such_a_form() -> None:
    motion, form = started("over a quartic")
    law = form.lambdify("numpy")["time_law"]
    state = motion.at([0.0, 0.1, 0.3])
    places = [float(x) for x in state.q["x"]]
    constants = {"E": float(sp.N(motion.initial.constants["E"]))}
    assert law(x=places, x_0=places[0], **constants) == pytest.approx([0.0, 0.1, 0.3], abs=1e-12)
    assert "carlson_rf" in form.code("c")


@pytest.mark.nightly
def test_complex_poles_of_vintis_problem() -> None:
    """∂W/∂p_φ has poles at ρ = ±ic: periods of φ and actions against the engine."""
    data = hjsolve.catalog.describe("vinti").motions["default"].arguments
    motion = hjsolve.solve("vinti").motion(**{**data, "digits": 40})
    form = own_form(motion)
    assert form is not None
    assert [k for k in form.why_not if not k.startswith(("inverse", "energy"))] == []
    values = {p.name: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}
    values |= dict(motion.initial.constants)
    for group in ("actions", "frequencies"):
        known = getattr(motion, group)
        assert set(known) == set(getattr(form, group))
        for key, estimate in known.items():
            assert abs(evaluated(form, f"{group}.{key}", values) - estimate.value) <= 1e-30 * abs(estimate.value)
