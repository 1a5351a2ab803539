"""Across every border of regimes (a degree that falls, two roots that meet, E through 0) the right form or none.

Borders are those that the curves have: leading coefficient, discriminant, values at the ends of the domain. From a
motion on a border one constant is moved off it, by a tenth down to 10⁻¹², to both sides. W between two places by
every form whose regime holds there, on the piece of the axis the motion is on, is compared with ∫ p dq.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.evaluation import many_digits, number_of
from hjsolve.closed_form.form_context import FormContext, context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.regions import root_interval_of
from hjsolve.closed_form.sampling import Sample, samples
from hjsolve.closed_form.special_cases import special_cases_of
from hjsolve.precision import mp
from tests.support.entries import forms
from tests.support.turns import in_the_turn

STEPS = [sp.Rational(sign, 10**k) for k in (1, 5, 12) for sign in (-1, 1)] + [sp.S.Zero]


@pytest.mark.nightly_cases("double-well-10", "pendulum-10")
@pytest.mark.parametrize(("name", "fewest"), [
    ("kepler-planar", 20), ("pendulum", 10), ("double-well", 10), ("morse", 6),
    pytest.param("isochrone", 20, marks=pytest.mark.nightly),
    pytest.param("bead-on-turning-wire", 10, marks=pytest.mark.nightly),
    pytest.param("spherical-pendulum", 10, marks=pytest.mark.nightly),
    pytest.param("schwarzschild", 10, marks=pytest.mark.nightly),
])  # fmt: skip
def test_the_right_form_or_none_on_both_sides_of_every_border(name: str, fewest: int) -> None:
    solution = hjsolve.solve(name)
    found, context, compared = forms(name), context_of(solution), 0
    for sample in _across_borders(context):
        holding = [form for form in found if form.regime.holds(sample.values) and _on_its_piece(form, sample)]
        kinds = {tuple(form.regime.kinds.items()) for form in holding}
        assert len(kinds) <= 1, (sample, kinds)
        for form in holding:
            compared += _compared(form, sample)
        for form in found:
            if form not in holding and form.periods and not form.regime.holds(sample.values):
                with pytest.raises(hjsolve.InvalidInputError, match="regime"):
                    _evaluated(form, sample.values)
    assert compared >= fewest


def _across_borders(context: FormContext) -> Iterator[Sample]:
    system = context.solution.system
    for special in special_cases_of(context.curves, context.constants):
        (constant,) = special
        for sample in list(samples(context.solution, 12, 5, special))[:3]:
            for step in STEPS:
                moved = dict(sample.values) | {constant: sample.values[constant] + step}
                numbers = many_digits(moved, 60)
                squares = [
                    number_of(square, {**numbers, system.coordinate(n).symbol: mp.mpf(int(q.p)) / int(q.q)})
                    for (n, square), q in zip(
                        context.solution.momentum_squared.items(), sample.places.values(), strict=True
                    )
                ]  # fmt: skip
                if all(not isinstance(p2, mp.mpc) and p2 > mp.mpf("1e-8") for p2 in squares):
                    yield Sample(moved, sample.places)


def _on_its_piece(form: RegimeForms, sample: Sample) -> bool:
    found = [(root_interval_of(curve, sample), region) for curve, region in form.regime.regions]
    return all(there is not None and there.key == region.key for there, region in found)


def _compared(form: RegimeForms, sample: Sample) -> int:
    """W from the place of the sample a little on, by the form and by quadrature; 1 where both were had."""
    if form.characteristic_function is None:
        return 0
    solution = form.solution
    values, expected = dict(sample.values), mp.mpf(0)
    for c in solution.system.coordinates:
        if c.name not in solution.coordinates:
            values |= {c.symbol: sp.S.Zero}
            continue
        begin = in_the_turn(form, c.name, sample)
        end = begin + sp.Rational(1, 10**4)
        values |= {c.symbol: end, solution.lower_limits[c.name]: begin}
        numbers = many_digits(sample.values, 60)
        with mp.workdps(50):
            square = solution.momentum_squared[c.name]
            ends = [mp.mpf(int(e.p)) / int(e.q) for e in (begin, end)]
            path = mp.quad(
                lambda q, s=square, n=numbers, c=c: mp.sqrt(number_of(s, {**n, c.symbol: q})), ends, maxdegree=4
            )
            expected += path
    beside = solution.characteristic_function.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)
    with mp.workdps(50):
        expected += mp.mpmathify(sp.N(beside.xreplace(values), 50))  # the potential of the shift p = P − A
    got = form.evaluate("characteristic_function", {s.name: v for s, v in _held(form, values).items()}, 30)
    assert abs(got.value - expected) <= 1e-25 * abs(expected) + abs(got.error), (form.regime.words, got, expected)
    return 1


def _held(form: RegimeForms, values: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    assert form.characteristic_function is not None
    known = set(form.regime.example) | form.written_out("characteristic_function").free_symbols
    return {s: v for s, v in values.items() if s in known}


def _evaluated(form: RegimeForms, values: Mapping[sp.Symbol, sp.Expr]) -> None:
    name = next(iter(form.periods))
    known = {s.name for s in (*form.regime.example, *form.periods[name].free_symbols)}
    form.evaluate(f"periods.{name}", {s.name: v for s, v in values.items() if s.name in known})


def test_an_angle_beyond_a_pole_is_outside() -> None:
    form = next(f for f in hjsolve.closed_forms("free-particle-spherical") if not f.regime.special)
    function = form.lambdify("numpy")["orbit_equations.alpha_2"]
    given = {s.name: float(v) for s, v in form.regime.example.items()} | {"theta_0": 1.5, "r": 6.0, "r_0": 5.0}

    def at(theta: float) -> dict[str, float]:
        return {n: {**given, "theta": theta}[n] for n in function.names}

    assert math.isfinite(function(**at(1.6)))
    assert math.isnan(function(**at(2 * math.pi - 1.6)))
    form.evaluate("orbit_equations.alpha_2", at(1.6))
    with pytest.raises(hjsolve.InvalidInputError, match="outside"):  # where cos θ is the same
        form.evaluate("orbit_equations.alpha_2", at(2 * math.pi - 1.6))
