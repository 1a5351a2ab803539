"""Formulas in fractions give what sympy's substitution gives, or decline."""

from __future__ import annotations

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from hjsolve import catalog
from hjsolve.motion import initial_data
from hjsolve.motion.rational_values import rational_value
from tests.support import entries

x, y = sp.symbols("x y", real=True)
numbers = st.fractions(min_value=-5, max_value=5, max_denominator=50)
FORMULAS = [
    x**2 / 2 - 3 * x * y + sp.Rational(7, 3),
    (x - y) / (x + y) - x**-3,
    x * y**2 * (1 + x) ** 4 / (2 + y**2) ** 2,
    x * (1 - y) ** 5 - y / (7 + x**2),
    -x / (3 * y) + sp.Rational(1, 10**30),
]


@settings(max_examples=60)
@given(st.sampled_from(FORMULAS), numbers, numbers)
def test_fractions_give_what_substitution_gives(formula: sp.Expr, a, b) -> None:
    place = {x: sp.Rational(a.numerator, a.denominator), y: sp.Rational(b.numerator, b.denominator)}
    found, theirs = rational_value(formula, place), sp.simplify(formula.xreplace(place))
    if found is None:  # a division by zero
        assert not theirs.is_Rational
    else:
        assert found == theirs


@pytest.mark.parametrize(("formula", "value"), [
    (sp.cos(x) + sp.sin(x) + sp.exp(x) * y, sp.Rational(5, 2)), (sp.sqrt(y - sp.Rational(5, 4)), sp.Rational(1, 2)),
    (x / (y + 1), 0), (abs(x - y), sp.Rational(3, 2)),
])  # fmt: skip
def test_what_is_rational_at_special_places_is_seen(formula: sp.Expr, value: object) -> None:
    assert rational_value(formula, {x: sp.Integer(0), y: sp.Rational(3, 2)}) == value


@pytest.mark.parametrize(
    "formula", [sp.sin(y), sp.pi * y, y / x, x**-2, sp.sqrt(y), sp.sqrt(-y), sp.log(y), y ** sp.Rational(1, 3)]
)
def test_what_is_not_a_fraction_is_left_to_sympy(formula: sp.Expr) -> None:
    assert rational_value(formula, {x: sp.Integer(0), y: sp.Rational(3, 2)}) is None
    assert rational_value(x + 1, {x: sp.sqrt(2)}) is None
    assert rational_value(x + y, {x: sp.Integer(1)}) is None


def test_constants_of_the_catalog_are_the_same_either_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every entry's own initial data, in fractions where they suffice, and by sympy alone."""
    ways = []
    for declined in (False, True):
        if declined:
            monkeypatch.setattr(initial_data, "rational_value", lambda *_: None)
        found = {}
        for name in catalog.ids("separable")[::4]:
            described = entries.described(name)
            if described.initial is not None:
                given = described.initial.arguments
                found[name] = initial_data.read_initial_data(entries.solution(name), **{"parameters": None, **given})
        ways.append(found)
    assert len(ways[0]) > 12
    assert sum(c.is_Rational for i in ways[0].values() for c in i.constants.values()) > 10
    for name, ours in ways[0].items():
        for key, value in ours.constants.items():
            other = ways[1][name].constants[key]
            assert value == other or sp.simplify(value - other) == 0, (name, key)
