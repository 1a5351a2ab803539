"""Forms at arrays of doubles: the regime and the named roots are those that 50 digits find, element by element."""

from __future__ import annotations

import random
from dataclasses import replace

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.derive import form_of_sample
from hjsolve.closed_form.doubles import CurveForArrays
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.sampling import Sample
from tests.support.entries import forms, solution

ENTRIES = ["pendulum", "double-well", "spherical-pendulum", "bead-on-turning-wire", "cone", "ladder"]


def _spread(value: sp.Expr, draw: random.Random) -> float:
    """A number about another one: near it, of the other sign, ten times as large, nothing."""
    size = abs(float(value)) or 1.0
    return draw.choice(
        [float(value) * draw.uniform(0.9, 1.1), draw.uniform(-3, 3) * size, draw.uniform(-30, 30) * size]
    )


@pytest.mark.nightly
@pytest.mark.nightly_cases("bead-on-turning-wire", "cone", "double-well", "ladder", "spherical-pendulum")
@pytest.mark.parametrize("name", ENTRIES)
def test_arrays_of_constants_are_sorted_as_by_fifty_digits(name: str) -> None:
    draw, inside, outside = random.Random(name), 0, 0
    for form in forms(name):
        key = next(iter({**form.periods, **form.turning_points}), None)
        key = (
            f"periods.{key}"
            if key in form.periods
            else next((n for n in form.named() if n.startswith("turning")), None)
        )
        if key is None:
            continue
        doubles, exact = form.lambdify("numpy")[key], form.lambdify("mpmath")[key]
        constants = {s.name for s in form.solution.constants.values() for s in [s.symbol]}
        example = {s.name: v for s, v in form.regime.example.items() if s.name in doubles.names}
        fixed = {s.name for s in form.regime.special}
        places = []
        for _ in range(60):
            at = {n: _spread(v, draw) if n in constants else float(v) for n, v in example.items()}
            if fixed:
                meant = {s: sp.Float(at[s.name]) if s.name in at else v for s, v in form.regime.example.items()}
                at |= {s.name: float(e.xreplace(meant)) for s, e in form.regime.special.items() if s.name in at}
            places.append(at)
        got = doubles(**{n: np.array([at[n] for at in places]) for n in example})
        for value, at in zip(got, places, strict=True):
            with mpmath.workdps(40):
                truth = exact(**{n: mpmath.mpf(v) for n, v in at.items()})
            if fixed:
                continue  # doubles are seldom exactly on a border
            assert bool(np.isnan(value)) == bool(mpmath.isnan(truth)), (form.regime.words, at, value, truth)
            if not np.isnan(value):
                inside += 1
                assert abs(value - float(truth)) <= 1e-9 * abs(float(truth)), (key, at)
            else:
                outside += 1
    assert inside >= 20
    assert outside >= 20


def test_a_polynomial_without_doubt_is_decided_in_doubles() -> None:
    """The test of a region settles nearly all of a spread of energies; the separatrix itself is not certain."""
    form = next(f for f in forms("pendulum") if f.regime.kinds["theta"] == "libration")
    ((curve, region),) = form.regime.regions
    (top,) = (float(r.lhs.subs(form.regime.example)) for r in form.regime.relations[1:])
    energies = np.array([-0.9, -0.1, 0.4, 0.999, 1 - 1e-13, 1.0, 1 + 1e-13, 1.001, 2.0]) * top
    table = {s: energies if s.name == "E" else np.full(9, float(v)) for s, v in form.regime.example.items()}
    found = CurveForArrays(curve).at(table, (9,), {})
    assert found is not None
    exists, unsure = found.has(region)
    assert unsure.tolist() == [False] * 5 + [True] + [False] * 3
    assert (exists & ~unsure).tolist() == [True] * 5 + [False] * 4


@pytest.mark.parametrize(("name", "inside", "outside"), [
    ("double-well", "1.1", "-1.1"), ("bead-on-turning-wire", "3.4", "-1.1831853071795865"), ("pendulum", "0.3", "9.2"),
    ("kepler-planar", "0.9", "40"),
])  # fmt: skip
def test_a_place_of_another_well_or_turn_is_refused(name: str, inside: str, outside: str) -> None:
    """There the formula may be real, and of the wrong sign."""
    started = {
        "double-well": ({"x": "1.1"}, {"x": "0.1"}),
        "bead-on-turning-wire": ({"theta": "2.5"}, {"theta": "0.1"}),
        "pendulum": ({"theta": "0.2"}, {"theta": 1}),
        "kepler-planar": ({"r": 1, "theta": 0}, {"theta": "0.9"}),
    }
    q, velocity = started[name]
    velocity = {c: velocity.get(c, 0) for c in q}
    motion = hjsolve.solve(name).motion(q=q, velocity=velocity)
    form = own_form(motion)
    assert form is not None
    (coordinate,) = form.solution.coordinates
    first = {"pendulum": "0.1", "bead-on-turning-wire": "3"}.get(name, "1")
    values = {s.name: v for s, v in motion.initial.values.items() if s in form.regime.example}
    values |= dict(motion.initial.constants) | {f"{coordinate}_0": first}
    rest = {s.name for s in form.characteristic_function.free_symbols} - {*values, coordinate}
    values |= dict.fromkeys(rest, sp.S.Zero)
    W = form.lambdify("numpy")["characteristic_function"]
    values = {n: v for n, v in values.items() if n in W.names}
    assert not np.isnan(float(form.evaluate("characteristic_function", values | {coordinate: inside}).value))
    with pytest.raises(hjsolve.InvalidInputError, match="outside this regime's motion"):
        form.evaluate("characteristic_function", values | {coordinate: outside})
    got = W(**{n: float(v) for n, v in values.items()}, **{coordinate: np.array([float(inside), float(outside)])})
    assert np.isnan(got).tolist() == [False, True]


CONE = {"m": 1.25, "g": 0.95, "alpha": 0.968657734857, "E": 263.262840241, "p_phi": 4.166666666666667}
"""Turning points 0.197 and 391: the parameter of the complete integrals is 1 − 1/990."""


@pytest.mark.parametrize("name", ["periods.phi", "frequencies.phi", "periods.r", "actions.r"])
def test_complete_integrals_keep_their_digits_next_to_the_parameter_one(name: str) -> None:
    form = forms("cone")[0]
    got = float(form.lambdify("numpy")[name](**CONE))
    exact = form.evaluate(name, {n: repr(v) for n, v in CONE.items()}, 40).value
    assert abs(got - exact) <= 20 * np.spacing(float(abs(exact)))


def test_source_code_has_the_complements_too() -> None:
    text = forms("cone")[0].code("python")
    assert "elliptic_pi(nu, k**2)" not in text
    assert "carlson_rj(0, 1, part" in text


@pytest.mark.nightly_cases("spherical-pendulum-1e-06", "rod-spherical-pendulum-1e-06")
@pytest.mark.parametrize("p_phi", [1e-6, *(pytest.param(p, marks=pytest.mark.nightly) for p in (1.0, 1e-3))])
@pytest.mark.parametrize("entry", ["spherical-pendulum", "rod-spherical-pendulum"])
def test_numbers_keep_their_digits_where_a_root_is_next_to_a_pole(entry: str, p_phi: float) -> None:
    """The pendulum passes the vertical at 1 − x₃ ~ p_φ²: a difference of doubles that had none left at p_φ = 1e-6."""
    form = forms(entry)[0]
    given = {"E": 3.0, "p_phi": p_phi, "m": 1.25, "l": 0.95, "g": 9.81}
    for name in ("periods.phi", "frequencies.phi", "actions.theta", "periods.theta"):
        function = form.lambdify("numpy")[name]
        values = {n: given[n] for n in function.names}
        exact = form.evaluate(name, {n: repr(v) for n, v in values.items()}, 40).value
        assert abs(float(function(**values)) - exact) <= 20 * np.spacing(float(abs(exact)))


TOPS = {
    "both ends of the axis nearly passed": {"E": 161.877607511, "p_psi": 0.3, "p_phi": -0.26666666666666666},
    "half turns that cancel": {"E": 185.711890441, "p_psi": 0.36666666666666664, "p_phi": 0.8333333333333334},
    "slow": {"E": 1.0146821614, "p_psi": -1.1666666666666667, "p_phi": -0.5166666666666667},
    "nearly upright": {"E": 3.3, "p_psi": 1.0, "p_phi": 1.0 + 2**-20},
}


@pytest.mark.nightly
@pytest.mark.parametrize("motion", TOPS)
def test_half_turns_about_the_ends_of_the_axis_cancel_exactly(motion: str) -> None:
    """Ω_ψ of a fast top is what is left of two half turns: 1e4 to 7e6 units of the last place were lost in doubles."""
    form = next(f for f in forms("lagrange-top") if not f.regime.special)
    given = {"I_a": 0.5, "I_t": 1.0, "m": 1.0, "g": 1.0, "l": 1.0, **TOPS[motion]}
    for name in ("periods.phi", "periods.psi", "frequencies.phi", "frequencies.psi"):
        function = form.lambdify("numpy")[name]
        values = {n: given[n] for n in function.names}
        exact = form.evaluate(name, {n: repr(v) for n, v in values.items()}, 40).value
        assert abs(float(function(**values)) - exact) <= 50 * np.spacing(float(abs(exact)))


CENTRES = {"m": 1.0, "a": 1.0, "k1": 1.0, "k2": 0.5, "E": -0.0113347923862, "alpha_2": 21.0558223115}


@pytest.mark.nightly
@pytest.mark.parametrize("p_phi", [8 / 15, 1e-3])
def test_the_half_turn_of_a_pole_beside_a_root_is_apart_where_others_are_complex(p_phi: float) -> None:
    """cos η nearly reaches both ends of the axis, P has a complex pair: 977 units of the last place were lost."""
    given = {**CENTRES, "p_phi": p_phi}
    solution = hjsolve.solve("two-centres-space")
    motion = {s: sp.Rational(given[s.name]) for s in (p.symbol for p in solution.system.parameters)}
    motion |= {c.symbol: sp.Rational(given[c.name]) for c in solution.constants.values()}
    form = next(f for f in forms("two-centres-space") if not f.regime.special and f.regime.holds(motion))
    for name in ("periods.phi", "frequencies.phi", "periods.xi", "periods.eta", "actions.eta"):
        function = form.lambdify("numpy")[name]
        values = {n: given[n] for n in function.names}
        exact = form.evaluate(name, {n: repr(v) for n, v in values.items()}, 40).value
        assert abs(float(function(**values)) - exact) <= 20 * np.spacing(float(abs(exact))), name


@pytest.mark.parametrize(("name", "at"), [
    ("morse", {"m": 0.0208852685945782, "D": 14.53523211418916, "a": 82.657106134117, "E": 14.536077387323346, "t_0": 0,
               "x_0": 2.2823271477440934, "t": 148.7491876399679}),
    ("poeschl-teller", {"m": 1.0, "V0": 2.0, "a": 3.0, "E": 0.5, "t_0": 0, "x_0": 1.0, "t": 400.0}),
])  # fmt: skip
def test_a_form_whose_parts_overflow_is_worked_out_in_many_digits(name: str, at: dict[str, float]) -> None:
    """The logarithm of cosh 3500 is a double, and cosh 3500 is not."""
    form = next(f for f in forms(name) if f.regime.kinds["x"] == "escape" and not f.regime.special)
    inverse = form.lambdify("numpy")["inverse.x"]
    near = dict(at) | {"t": at["t"] / 1000}
    arrays = {n: np.array([near[n], v]) for n, v in at.items() if n in inverse.names}
    for value, own in zip(inverse(**arrays), (near, at), strict=True):
        right = form.evaluate("inverse.x", {n: sp.Rational(own[n]) for n in arrays}).value
        assert abs(value - right) <= 1e-13 * abs(right)


@pytest.mark.parametrize("name", ["torus-geodesics", "vinti"])
def test_zeros_of_the_slope_that_no_motion_meets_leave_arrays_to_doubles(name: str) -> None:
    """1 + tan²(u/2) has no real zero, 1/ρ is zero at the end of the domain; a zero within it is left to 50 digits."""
    for curves in context_of(solution(name)).curves.values():
        for curve in curves:
            assert CurveForArrays(curve).roots is not None
            x = curve.x
            within = x - curve.substitution.place.subs(curve.coordinate.symbol, sp.Rational(1, 3))
            assert CurveForArrays(replace(curve, square=curve.square * within)).roots is None


def test_a_pole_of_a_form_is_infinite_and_the_other_elements_have_their_numbers() -> None:
    form = forms("harmonic-oscillator")[0]
    (E,) = (c.symbol for c in form.solution.constants.values())
    period = replace(form, periods={"x": 1 / (E - 1)}).lambdify("numpy")["periods.x"]
    at = dict.fromkeys(period.names, 1.0) | {"E": np.array([1.0, 2.0, -1.0])}
    assert np.array_equal(period(**at), [np.inf, 1.0, np.nan], equal_nan=True)


@pytest.mark.nightly
def test_forms_have_their_numbers_where_roots_are_far_apart() -> None:
    # E = −1e-76: the outer root is 1e76 times the others, and a difference of roots had no digit of 45
    at = {
        "m": 0.998847229075701, "a": 1.0023676567679296, "k1": 0.9858151087387964, "k2": 0.5068028713317848,
        "xi": 139.00477261855147, "eta": 1.7295537715702511, "E": -1.0431181369752019e-76, "t_0": 0.0,
        "alpha_2": 2.5478107639621284, "p_phi": -0.8793525826417335, "xi_0": 49.426129895204795,
        "eta_0": 0.6199732568668536,
    }  # fmt: skip
    exact = {n: sp.Rational(v) for n, v in at.items()}
    (form,) = (f for f in forms("two-centres-space") if not f.regime.special and f.regime.holds(
        {s: exact[s.name] for s in f.regime.example}))  # fmt: skip
    law = form.lambdify("numpy")["time_law"]
    truth = 4.894102680653528e89  # the quadrature between both places, by Gauss's rule
    assert law(**{n: at[n] for n in law.names}) == pytest.approx(truth, rel=1e-12)
    found = form.evaluate("time_law", {n: str(exact[n]) for n in law.names}, 25)
    assert float(found.value) == pytest.approx(truth, rel=1e-12)


@pytest.mark.parametrize("E", [-1e-5, -2.4986926028820027e-91, -3.768477636333927e-119])
def test_roots_in_radicals_keep_their_digits_next_to_a_parabola(E: float) -> None:
    # (−b + √(b² + 4Ec))/2E: of 119 zeros of E, 90 digits left a number that was wrong, and of a narrow claim
    at = {"m": 0.9589998696588825, "a": 1.0805018538174, "k1": 1.1684544880057572, "k2": 0.5278665060064195,
          "alpha_2": 377.4024453818466}  # fmt: skip
    own = hjsolve.solve("two-centres-plane")
    context = context_of(own)
    symbols = {s.name: s for s in (*(p.symbol for p in own.system.parameters),
                                   *(c.symbol for c in own.constants.values()))}  # fmt: skip
    values = {symbols[n]: sp.Rational(v) for n, v in {**at, "E": -1e-5}.items()}
    form = form_of_sample(context, context.curves, {}, Sample(values, {"xi": sp.Integer(8), "eta": sp.S.Half}))
    assert form is not None
    name = "turning_points.xi.lower"
    with mpmath.workdps(500):
        m, a, k1, k2, α = (mpmath.mpf(v) for v in at.values())
        b, c = m * a * (k1 + k2), -(m * a**2 * mpmath.mpf(E) + α)  # E m a² x² + b x + c = 0, x = cosh ξ
        truth = mpmath.acosh(2 * c / (-b - mpmath.sqrt(b**2 - 4 * m * a**2 * mpmath.mpf(E) * c)))
    given = {**at, "E": E}
    function = form.lambdify("numpy")[name]
    assert function(**{n: given[n] for n in function.names}) == pytest.approx(float(truth), rel=1e-15, abs=0)
    for digits in (15, 25, 40):
        found = form.evaluate(name, {n: str(sp.Rational(v)) for n, v in given.items()}, digits)
        with mpmath.workdps(60):
            assert abs(mpmath.mpf(str(found.value)) - truth) <= found.error + mpmath.mpf(10) ** (1 - digits)
