"""Closed forms against the certified engine, at the borders of regimes, and as code."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.curves import W
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.pieces import piece
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.closed_form.verification import flaws
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(4)

NUMBERS = [
    "kepler-planar", "kepler-spherical", "kepler-parabolic", "isochrone", "isotropic-oscillator-polar", "morse",
    "poeschl-teller", "smorodinsky-winternitz", "anisotropic-oscillator", "charge-in-uniform-field", "calogero-moser",
    "oscillator-on-moving-plane", "spring-in-moving-frame", "sphere-geodesics",
]  # fmt: skip


def _of_the_catalog(name: str) -> list[Sample]:
    found = []
    for data in hjsolve.catalog.describe(name).motions.values():
        motion = hjsolve.solve(name).motion(**data.arguments)
        values = {p.symbol: motion.initial.values[p.symbol] for p in motion.solution.system.parameters}
        values |= {c.symbol: motion.initial.constants[n] for n, c in motion.solution.constants.items()}
        places = {
            n: motion.initial.values[motion.solution.system.coordinate(n).symbol] for n in motion.solution.coordinates
        }
        if all(value.is_Rational for value in (*values.values(), *places.values())):
            found.append(Sample(values, places))
    return found


@pytest.mark.rotating(2)
@pytest.mark.nightly_cases(
    "calogero-moser", "charge-in-uniform-field", "isochrone", "kepler-spherical", "morse", "poeschl-teller",
    "smorodinsky-winternitz", "sphere-geodesics",
)  # fmt: skip
@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_agree_with_the_engine_to_38_digits(name: str) -> None:
    """A motion drawn at random, not the one the form was verified at."""
    solution, compared = hjsolve.solve(name), 0
    for sample in (*_of_the_catalog(name), *samples(solution, 40, seed=77)):
        signs = dict.fromkeys(solution.coordinates, 1)
        q = {c.name: sample.places.get(c.name, 0) for c in solution.system.coordinates}
        constants = {n: sample.values[c.symbol] for n, c in solution.constants.items()}
        parameters = {p.name: sample.values[p.symbol] for p in solution.system.parameters}
        try:
            motion = solution.motion(q=q, constants=constants, signs=signs, parameters=parameters, digits=40)
        except hjsolve.NotConvergedError:
            continue
        if not set(motion.kinds.values()) <= {"libration", "rotation", "ignorable"} or not motion.frequencies:
            continue
        form = own_form(motion)
        assert form is not None
        at = {s.name: v for s, v in sample.values.items()}
        for group in ("actions", "frequencies", "periods", "mean_velocities"):
            known, derived = getattr(motion, group), getattr(form, group)
            assert set(derived) >= set(known), (group, known, form.why_not)
            for key, expression in derived.items():
                needed = {s.name for s in (*form.regime.example, *expression.free_symbols)}
                if key not in known or expression.xreplace(dict(sample.values)).has(sp.zoo):
                    continue
                value = form.evaluate(f"{group}.{key}", {n: v for n, v in at.items() if n in needed}, 40)
                scale = max(abs(known[key].value), 1e-3)
                assert abs(value.value - known[key].value) <= 1e-38 * scale, (group, key)
                compared += 1
        if compared > 8:
            return
    assert compared > 0


@pytest.mark.nightly_cases("isochrone-E-0")
@pytest.mark.parametrize(("name", "constant", "border"), [
    ("kepler-planar", "E", 0), ("isochrone", "E", 0), ("morse", "E", 1), ("poeschl-teller", "E", 0),
    ("kepler-planar", "p_theta", 0),
])  # fmt: skip
def test_no_form_holds_on_the_wrong_side(name: str, constant: str, border: float) -> None:
    """Across every border: the forms whose regime holds have right values, those that do not refuse or give nan."""
    solution = hjsolve.solve(name)
    base = {c: sp.Rational(7, 10) for c in solution.constants} | {constant: sp.S.Zero}
    for distance in (sp.Rational(-1, 10), sp.Rational(-1, 10**9), 0, sp.Rational(1, 10**9), sp.Rational(1, 10)):
        at = base | {constant: border + distance}
        if constant != "E":
            at["E"] = sp.Rational(-3, 10)
        exact = {p.symbol: p.value for p in solution.system.parameters}
        exact |= {c.symbol: sp.sympify(at[n]) for n, c in solution.constants.items()}
        holding = [f for f in forms(name) if f.regime.holds(exact)]
        assert len({tuple(f.regime.kinds.items()) for f in holding}) <= 1, at
        for form in forms(name):
            if form in holding or not form.periods:
                continue
            group = next(iter(form.periods))
            with pytest.raises(hjsolve.InvalidInputError, match="regime"):
                form.evaluate(f"periods.{group}", at)
            function = form.lambdify("numpy")[f"periods.{group}"]
            given = {n: float(v) for n, v in at.items() if n in function.names}
            assert math.isnan(function(**given))
        if distance == 0:
            assert all(f.regime.special for f in holding)


def test_a_wrong_integral_is_not_shown() -> None:
    """The check itself: an antiderivative, and a cycle, off by one part in 1e20 are caught."""
    from dataclasses import replace

    solution = hjsolve.solve("kepler-planar")
    context = context_of(solution)
    sample = next(s for s in samples(solution, 20, seed=3) if s.values[context.constants[0]] < 0)
    found = piece("r", context.numerators["r"], context.curves["r"], sample)
    assert found is not None
    assert W not in flaws(found, [W])
    right, off = found.integrals[W], 1 + sp.Rational(1, 10**20)
    assert right.cycle is not None
    for wrong in (replace(right, value=right.value * off), replace(right, cycle=right.cycle * off)):
        broken = replace(found, integrals={W: wrong})
        assert "not verified" in flaws(broken, [W])[W]
    flipped = replace(found, integrals={W: replace(right, numerator=-right.numerator)})
    assert W in flaws(flipped, [W])


def test_the_quadrature_of_a_cycle_reaches_turning_points_far_apart() -> None:
    """Of a bead on a cone from 0.013 to 37 000, 83 000 equally spaced nodes would be needed."""
    from dataclasses import replace

    context = context_of(hjsolve.solve("cone"))
    values = {
        "m": "1", "g": "1", "alpha": "261799387799/500000000000", "E": "177779111031/5000000", "p_phi": "-10/3",
    }  # fmt: skip
    symbols = {s.name: s for s in (*context.constants, *(p.symbol for p in context.solution.system.parameters))}
    sample = Sample({symbols[n]: sp.Rational(v) for n, v in values.items()}, {"r": sp.S.One})
    found = piece("r", context.numerators["r"], context.curves["r"], sample)
    assert found is not None
    keys = list(found.integrals)
    assert len(keys) == 3
    assert flaws(found, keys) == {}
    off = {key: replace(own, cycle=own.cycle * (1 + sp.Rational(1, 10**36))) for key, own in found.integrals.items()}
    assert set(flaws(replace(found, integrals=off), keys)) == set(keys)


def test_functions_and_code() -> None:
    form = forms("kepler-planar")[0]
    period = form.lambdify("numpy")["periods.r"]
    energies = np.linspace(-0.7, -0.1, 7)
    expected = math.pi / np.sqrt(2) / (-energies) ** 1.5
    assert np.all(np.abs(period(E=energies, p_theta=0.4) - expected) <= 4e-16 * expected)
    assert np.all(np.isnan(period(E=-energies, p_theta=0.4)))
    with mpmath.workdps(50):
        value = form.lambdify("mpmath")["periods.r"](E="-1/2", p_theta="0.4", m=1, k=1)
        assert abs(value - 2 * mpmath.pi) < mpmath.mpf(10) ** -48
    space: dict[str, object] = {}
    exec(form.code("python"), space)
    assert abs(space["periods_r"](-0.5, 1, 1) - 2 * math.pi) < 1e-14  # type: ignore[operator]
    assert "double periods_r(double E, double k, double m)" in form.code("c")
    with pytest.raises(hjsolve.InvalidInputError, match="python"):
        form.code("fortran")
    with pytest.raises(hjsolve.InvalidInputError, match="numpy"):
        form.lambdify("torch")


def test_questions_that_have_no_answer() -> None:
    form = forms("kepler-planar")[0]
    with pytest.raises(hjsolve.InvalidInputError, match="Kepler's equation"):
        form.evaluate("inverse.r", {"E": -1, "p_theta": "0.1"})
    with pytest.raises(hjsolve.MissingValueError, match="p_theta"):
        form.evaluate("periods.r", {"E": -1})
    with pytest.raises(hjsolve.InvalidInputError, match="neither"):
        form.evaluate("periods.r", {"E": -1, "p_theta": "0.1", "speed": 3})
    with pytest.raises(hjsolve.InvalidInputError, match="closed_forms"):
        hjsolve.closed_forms(3)  # type: ignore[arg-type]


@pytest.mark.nightly
def test_errors_cover_the_truth() -> None:
    form, draw = forms("isochrone")[0], random.Random(11)
    for _ in range(20):
        at = {"E": sp.Rational(-draw.randint(1, 30), 100), "p_theta": sp.Rational(draw.randint(5, 60), 100)}
        try:
            near = form.evaluate("actions.r", at)
        except hjsolve.InvalidInputError:
            continue
        far = form.evaluate("actions.r", at, 50)
        assert abs(near.value - far.value) <= near.error


def test_own_regime_comes_first() -> None:
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.5"})
    found = hjsolve.closed_forms(motion)
    assert found[0].regime.kinds["r"] == motion.kinds["r"] == "escape"
    parabola = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "sqrt(2)"})
    own = own_form(parabola)
    assert own is not None
    assert [str(c) for c in own.regime.special] == ["E"]
