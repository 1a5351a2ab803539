"""Formulas that overflow far out, and exact numbers with many terms: what took minutes, or for ever."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.interval import Interval, Intervals
from hjsolve.motion.initial_data import expanded, number_is_zero
from hjsolve.one_coordinate.ray import Ray


def test_what_overflows_is_large_not_unknown():
    field = Intervals(Float64())
    square = field.power(field.unary("cosh", Interval(np.array([400.0]), np.array([800.0]))), 2)
    assert square.low[0] > 1e307
    assert square.high[0] == np.inf
    inverse = field.div(field.rational(1, 1), square)
    assert -1e-299 < inverse.low[0] <= 0 <= inverse.high[0] < 1e-299


@pytest.fixture
def enclosures(monkeypatch):
    """Counts the calls in many digits."""
    calls = []
    enclose = Ray.enclose

    def counted(self, x0, x1, bits):
        if bits > 53:
            calls.append(np.size(x0))
        return enclose(self, x0, x1, bits)

    monkeypatch.setattr(Ray, "enclose", counted)
    return calls


@pytest.mark.parametrize("potential", ["-1/cosh(x)**2", "-cosh(x)", "-exp(-x**2)", "1 - sinh(x)**2"])
def test_the_way_to_infinity_is_decided_without_dividing_it(potential, enclosures):
    system = hjsolve.System(coordinates={"x": "line"}, kinetic="dot(x)**2/2", potential=potential)
    assert hjsolve.solve(system).motion(q={"x": 2}, velocity={"x": 5}, want=["kinds"]).kinds == {"x": "escape"}
    assert sum(enclosures) < 300


def test_over_a_well_of_poeschl_and_teller_the_motion_is_the_closed_one():
    system = hjsolve.System(coordinates={"x": "line"}, kinetic="dot(x)**2/2", potential="-1/cosh(x)**2")
    motion = hjsolve.solve(system).motion(q={"x": 0}, velocity={"x": 2})
    with mp.workdps(40):
        energy = mp.mpf(1)
        for t in (-3.0, 0.4, 2.5):
            state = motion.at(t)
            truth = mp.asinh(mp.sqrt((energy + 1) / energy) * mp.sinh(mp.sqrt(2 * energy) * mp.mpf(t)))
            assert abs(mp.mpf(state.q["x"]) - truth) <= state.error.q["x"] <= 1e-13 * (1 + abs(truth))


def long_number(terms, factors):
    """A product of sums of sines that no rule shortens."""
    return sp.Mul(*(sp.Add(*(sp.sin(sp.Rational(7 * k + 3, j + 2)) for k in range(terms))) for j in range(factors)))


def test_a_long_number_is_not_multiplied_out_and_its_sign_is_found():
    number = long_number(9, 6)
    assert expanded(number) is number
    assert not number_is_zero(number + 1)
    assert number_is_zero(number * (sp.sin(1) ** 2 + sp.cos(1) ** 2 - 1))
    zero = (sp.sin(1) ** 2 + sp.cos(1) ** 2 - 1) * long_number(4, 5) + (
        sp.sqrt(2) * sp.sin(2) - sp.sqrt(8) * sp.sin(1) * sp.cos(1)
    ) ** 2
    assert number_is_zero(zero)
