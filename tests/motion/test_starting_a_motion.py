"""What makes starting a motion fast must not change what it finds: bound tapes, jets, enclosures, cells divided together."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.interval import Interval, Intervals
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.lowering import lower
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.ray import Ray
from hjsolve.one_coordinate.turning_points import first_end

q, E, k = sp.symbols("q E k")
FORMULAS = (
    2 * E - k * sp.cos(q) ** 2,
    E**3 * k / (q**2 + k) - sp.sqrt(1 + E * k),
    (q**2 - 2 * k * q + E) ** -2 + k / q**3,
    sp.exp(-k * q) / (E + sp.sin(k) ** 2) + 1 / (q**2 + E) ** 4,
)


def radicand(formula: sp.Expr, *values: str) -> MomentumSquared:
    arguments = [q, E, k]
    kernels = [sp.diff(formula, c) / 2 for c in (E, k)]
    return MomentumSquared(
        lower([formula], arguments), lower(kernels, arguments), lambda bits: [Multi(bits).convert(v) for v in values]
    )


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_bound_tape_gives_what_the_whole_tape_gives(formula: sp.Expr) -> None:
    tape = lower([formula, E * k, q + 1], [q, E, k])
    whole = tape.run(Float64(), [np.array([0.3, 1.7]), 1.25, 0.75])
    bound = tape.bind(Float64(), [1.25, 0.75]).run(np.array([0.3, 1.7]))
    for ours, theirs in zip(bound, whole, strict=True):
        assert np.array_equal(ours, theirs)
    assert len(tape.bind(Float64(), [1.25, 0.75]).rest) < len(tape.operations)


@pytest.mark.parametrize("formula", FORMULAS)
def test_jets_are_the_derivatives_of_the_formula(formula: sp.Expr) -> None:
    with mpmath.workdps(40):
        x = mpmath.mpf("1.7")
        found = radicand(formula, "1.25", "0.75").jet(x, 160)
        at = {E: sp.Rational(5, 4), k: sp.Rational(3, 4), q: sp.Rational(17, 10)}
        for order, value in enumerate(found):
            truth = mpmath.mpf(sp.N(sp.diff(formula, q, order).subs(at), 45))
            assert abs(value - truth) <= abs(truth) * mpmath.mpf(10) ** -38


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(FORMULAS), st.floats(0.05, 3), st.floats(0, 1), st.floats(0, 1))
def test_enclosures_hold_the_function_and_its_derivatives(
    formula: sp.Expr, low: float, width: float, fraction: float
) -> None:
    high = low + width
    x = min(max(low + fraction * width, low), high)
    cell = radicand(formula, "1.25", "0.75").enclose(np.array([low]), np.array([high]))
    with mpmath.workdps(40):
        inside = radicand(formula, "1.25", "0.75").jet(mpmath.mpf(x), 160)
    for part, value in zip(cell, inside, strict=True):
        assert part.low[0] <= value <= part.high[0]


@settings(max_examples=200, deadline=None)
@given(*[st.sampled_from([-np.inf, -3.0, -1.0, 0.0, 0.5, 2.0, np.inf])] * 4)
def test_products_of_intervals_with_unbounded_ends(a: float, b: float, c: float, d: float) -> None:
    x, y = Interval(*(np.array([v]) for v in sorted((a, b)))), Interval(*(np.array([v]) for v in sorted((c, d))))
    product = Intervals(Float64()).mul(x, y)
    for u in (a, b):
        for v in (c, d):
            exact = 0.0 if u == 0 or v == 0 else u * v
            assert product.low[0] <= exact <= product.high[0]


def test_a_constant_has_no_derivative() -> None:
    jets = Jets(Float64())
    assert jets.power(Jet(2.0), -2) == Jet(0.25)


def test_cells_that_wait_for_the_same_are_divided_together(monkeypatch) -> None:
    """The end does not change, and fewer enclosures are asked for than one undecided cell at a time needs."""
    horizon = q**2 - 2 * q + k**2
    field = radicand(
        sp.expand(((E * (q**2 + k**2) - 2 * k) ** 2 - horizon * (q**2 + 8)).expand()) / horizon**2, "0.95", "0.9"
    )
    enclose, calls = MomentumSquared.enclose, []
    monkeypatch.setattr(MomentumSquared, "enclose", lambda *a: calls.append(1) or enclose(*a))

    def end(together: int) -> tuple[int, mpmath.mpf]:
        monkeypatch.setattr("hjsolve.one_coordinate.turning_points._TOGETHER", together)
        calls.clear()
        found = first_end(Ray(field, lambda bits: Multi(bits).convert(6), 1, None), digits=15)
        assert found.kind == "turning"
        return len(calls), found.place(100)

    (many, one_by_one), (few, at_once) = end(1), end(48)
    assert at_once == one_by_one
    assert 3 * few <= many
