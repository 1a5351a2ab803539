"""A form is the same whatever the units: mass, length and time of 1e-30 to 1e20, and roots that are 1e30 apart.

Scales are powers of ten, exact in the constants; what a form gives must grow by the power that its dimension says.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.derive import form_of_sample
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.regions import _roots_of, holds_place
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.signs import Signs
from hjsolve.precision import mp
from tests.support.entries import forms

pytestmark = pytest.mark.rotating_file(5)

# name → powers of mass, length and time; √length for u and v of parabolic coordinates
ENERGY, TURN = (1, 2, -2), (1, 2, -1)
DIMENSIONS: Mapping[str, Mapping[str, tuple[float, float, float]]] = {
    "kepler-planar": {"m": (1, 0, 0), "k": (1, 3, -2), "r": (0, 1, 0), "E": ENERGY, "p_theta": TURN},
    "double-well": {"m": (1, 0, 0), "a": (1, 0, -2), "b": (1, -2, -2), "x": (0, 1, 0), "E": ENERGY},
    "cone": {
        "m": (1, 0, 0), "g": (0, 1, -2), "alpha": (0, 0, 0), "r": (0, 1, 0), "E": ENERGY, "p_phi": TURN,
    },
    "spherical-pendulum": {
        "m": (1, 0, 0), "l": (0, 1, 0), "g": (0, 1, -2), "theta": (0, 0, 0), "E": ENERGY, "p_phi": TURN,
    },
    "stark": {
        "m": (1, 0, 0), "k": (1, 3, -2), "F": (1, 1, -2), "u": (0, 0.5, 0), "v": (0, 0.5, 0), "E": ENERGY,
        "alpha_2": (2, 3, -2), "p_phi": TURN,
    },
}  # fmt: skip
UNITS = {"electron": (-30, -10, -16), "galaxy": (20, 20, 16), "heavy": (20, -20, 0), "slow": (0, 0, 20)}
"""Decimal logarithms of the units of mass, length and time."""
CYCLES = {"periods": (0, 0, 1), "frequencies": (0, 0, -1), "actions": TURN}


def _factor(powers: tuple[float, float, float], unit: tuple[int, int, int]) -> sp.Rational:
    decades = sum(p * u for p, u in zip(powers, unit, strict=True))
    assert decades == int(decades)
    return sp.Rational(10) ** int(decades)


def _scaled(entry: str, values: Mapping[sp.Symbol, sp.Expr], unit: tuple[int, int, int]) -> dict[sp.Symbol, sp.Expr]:
    return {s: v * _factor(DIMENSIONS[entry][s.name], unit) for s, v in values.items()}


@lru_cache(maxsize=8)
def _derived(entry: str, unit: tuple[int, int, int]) -> tuple[RegimeForms, ...]:
    """The forms of the regimes of an entry, each derived at its example in other units."""
    context, found = context_of(hjsolve.solve(entry)), list[RegimeForms]()
    for form in forms(entry):
        if form.regime.special:
            continue
        places = {curve.coordinate.name: _place(form, curve.coordinate.name) for curve, _ in form.regime.regions}
        there = {n: q * _factor(DIMENSIONS[entry][n], unit) for n, q in places.items()}
        made = form_of_sample(context, context.curves, {}, Sample(_scaled(entry, form.regime.example, unit), there))
        assert made is not None
        found.append(made)
    return tuple(found)


def _place(form: RegimeForms, name: str) -> sp.Rational:
    """A rational place of a coordinate in the regime's motion."""
    curve, region = next((c, r) for c, r in form.regime.regions if c.coordinate.name == name)
    values = Signs(form.regime.example, region.place).numbers | {curve.x: region.place}
    return sp.Rational(
        str(sp.N(curve.substitution.inverse.subs({s: sp.Float(str(v), 40) for s, v in values.items()}), 30))
    )


@pytest.mark.nightly_cases(*(f"{entry}-{unit}" for entry in ("stark", "spherical-pendulum", "cone") for unit in UNITS))
@pytest.mark.parametrize("unit", UNITS.values(), ids=UNITS)
@pytest.mark.parametrize("entry", DIMENSIONS)
def test_a_form_is_derived_in_any_unit(entry: str, unit: tuple[int, int, int]) -> None:
    known = [form for form in forms(entry) if not form.regime.special]
    for one, other in zip(known, _derived(entry, unit), strict=True):
        assert other.regime.words == one.regime.words
        assert other.named() == one.named()
        assert other.why_not == one.why_not


@pytest.mark.nightly_cases(*(f"{entry}-{unit}" for entry in ("stark", "spherical-pendulum", "cone") for unit in UNITS))
@pytest.mark.parametrize("unit", UNITS.values(), ids=UNITS)
@pytest.mark.parametrize("entry", DIMENSIONS)
def test_a_form_has_its_numbers_in_any_unit(entry: str, unit: tuple[int, int, int]) -> None:
    for form in forms(entry):
        values = _scaled(entry, form.regime.example, unit)
        assert form.regime.holds(values)
        others = [o for o in forms(entry) if o is not form and o.regime.special and not form.regime.special]
        assert not any(o.regime.holds(values) for o in others)  # E of 1e-60 is not 0
        own = {s.name: str(v) for s, v in values.items()}
        first = {s.name: str(v) for s, v in form.regime.example.items()}
        functions = form.lambdify("numpy")
        for name in form.named():
            powers = CYCLES.get(name.split(".")[0])
            if powers is None:
                continue
            factor = _factor(powers, unit)
            there, here = form.evaluate(name, own, 30).value, form.evaluate(name, first, 30).value
            with mp.workdps(40):
                expected = mp.mpmathify(here) * mp.mpf(factor.p) / factor.q
                assert abs(mp.mpmathify(there) - expected) <= abs(expected) * mp.mpf(10) ** -28, name
            function = functions[name]
            doubles = {n: np.array([float(sp.Rational(own[n]))] * 2) for n in function.names}
            assert np.allclose(function(**doubles), float(there), rtol=1e-9, atol=0), name


SCALES = [f"1e{k}" for k in (-20, -7, 0, 20)]


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(("roots", "double"), [
    (("1", "2", "3", "-5"), False), (("1", "1", "3"), True), (("1", "2", "1e30"), False), (("1e-30", "1", "2"), False),
    (("1", "1", "1e30"), True), (("0", "1", "2"), False), (("0", "0", "2"), True), (("0", "1e-30", "1", "7"), False),
    (("1", "1.00000000000001", "4"), False), (("-1e25", "1e-25", "1", "3", "1e12"), False),
])  # fmt: skip
def test_roots_are_told_apart_in_any_unit(roots: tuple[str, ...], double: bool, scale: str) -> None:
    with mp.workdps(80):
        unit = mp.mpf(scale)
        expected = sorted(mp.mpf(r) * unit for r in roots)
        coefficients = [unit**3]
        for root in expected:
            longer = [*coefficients, mp.mpf(0)]
            coefficients = [c - root * d for c, d in zip(longer, [mp.mpf(0), *coefficients], strict=True)]
    found, alike = _roots_of(tuple(coefficients), 50)
    assert alike == double
    assert len(found) == len(roots)
    if not double:
        for got, root in zip(found, expected, strict=True):
            assert abs(got - root) <= abs(root) * mp.mpf(10) ** -30


def test_roots_of_a_pair_are_not_real_next_to_a_root_far_away() -> None:
    # (x − 1e30)(x² − 2x + 1 + 1e-30): the pair is 1 ± 1e-15 i, and was called a double root by the scale of 1e30
    with mp.workdps(80):
        c = 1 + mp.mpf("1e-30")
        far = mp.mpf("1e30")
        found, alike = _roots_of((mp.mpf(1), -2 - far, c + 2 * far, -c * far), 50)
    assert not alike
    assert len(found) == 1


def test_a_place_is_refused_in_small_units() -> None:
    # r from 1e-20 to 3e-20: a place a tenth beyond was accepted with a tolerance of 1e-12
    (form,) = [f for f in forms("kepler-planar") if f.regime.kinds["r"] == "libration"]
    curve, region = form.regime.regions[0]
    unit = (0, -20, 0)
    numbers = Signs(_scaled("kepler-planar", form.regime.example, unit), region.place).numbers
    ends = sorted(mp.mpf(r) * mp.mpf(10) ** -20 for r in region.roots)
    for part, inside in ((mp.mpf("0.9"), False), (mp.mpf("1.01"), True)):
        assert holds_place(curve, region, ends[0] * part, numbers) == inside


@pytest.mark.parametrize("decades", [-20, 0, 20])
def test_a_motion_has_its_own_form_in_any_unit(decades: int) -> None:
    solution = hjsolve.solve("double-well")
    unit = sp.Rational(10) ** decades  # of length, with m = 1, and a = 1/s²
    motion = solution.motion(
        q={"x": sp.Rational(4, 5) * unit}, velocity={"x": sp.Rational(3, 10) * unit},
        parameters={"m": 1, "a": 1, "b": 1 / unit**2},
    )  # fmt: skip
    form = own_form(motion)
    assert form is not None
    assert "inverse.x" in form.named()


@pytest.mark.parametrize("radius", ["1", "1/10", "1/1000", "1e-20", "1e20"])
def test_a_fall_from_rest_has_its_own_form_from_any_radius(radius: str) -> None:
    # it was looked for at r = 1/10 − (1 + 1/10)/8, beyond the centre, and there was none
    motion = hjsolve.solve("kepler-planar").motion(q={"r": radius, "theta": 0}, velocity={"r": 0, "theta": 0})
    form = own_form(motion)
    assert form is not None
    assert form.regime.words == "r: boundary; p_theta = 0, E < 0"
