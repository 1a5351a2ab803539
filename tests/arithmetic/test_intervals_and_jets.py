"""Interval arithmetic encloses and jets differentiate: random expressions against mpmath."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from mpmath import mp

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.interval import Interval, Intervals
from hjsolve.arithmetic.jet import Jets
from hjsolve.lowering import lower

x = sp.Symbol("x", real=True)
UNARY = (sp.sin, sp.cos, sp.tan, sp.exp, sp.log, sp.sqrt, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh,
         sp.asinh, sp.acosh, sp.atanh)  # fmt: skip
leaves = st.one_of(st.just(x), st.just(x), st.integers(-9, 9).map(lambda n: sp.Rational(n, 4)))
trees = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda p: p[0] + p[1]),
        st.tuples(inner, inner).map(lambda p: p[0] * p[1]),
        st.tuples(inner, st.integers(-3, 4).filter(bool)).map(lambda p: p[0] ** p[1]),
        st.tuples(st.sampled_from(UNARY), inner).map(lambda p: p[0](p[1])),
    ),
    max_leaves=6,
)
places = st.integers(-300, 300).map(lambda n: n / 128)


def lowered(tree):
    """A tape of a real expression that holds x; other draws are passed over."""
    assume(tree.has(x) and not tree.has(sp.zoo, sp.nan, sp.oo, -sp.oo, sp.I, sp.Abs, sp.sign))
    return lower([tree], [x])


def truth(tree, place):
    """The value to forty digits; other than finite and real is passed over."""
    with mp.workdps(60):
        value = sp.lambdify(x, tree, "mpmath")(mp.mpf(place))
        assume(mpmath.isfinite(value) and not isinstance(value, mpmath.mpc) and abs(value) < 1e100)
        return mp.mpf(value)


@pytest.mark.parametrize("bits", [53, 90])
@given(tree=trees, left=places, width=st.integers(0, 256), fraction=st.floats(0, 1))
@example(tree=x ** sp.Rational(1, 4), left=0.0, width=0, fraction=0.0)
@settings(max_examples=150)
def test_an_enclosure_holds_the_value_at_every_place_inside(bits, tree, left, width, fraction):
    tape, right = lowered(tree), left + width / 128
    place = left + fraction * (right - left)
    assume(left <= place <= right)
    try:
        value = truth(tree, place)
    except (ZeroDivisionError, ValueError, OverflowError):
        assume(False)
    field = Intervals(Float64()) if bits == 53 else Intervals(Multi(bits))
    ends = [np.array([v]) if bits == 53 else np.array([Multi(bits).convert(v)], dtype=object) for v in (left, right)]
    with np.errstate(all="ignore"):
        found = tape.run(field, [Interval(*ends)])[0]
    low, high = (np.broadcast_to(end, (1,))[0] for end in (found.low, found.high))
    with mp.workdps(60):
        assert mp.mpf(low) <= value <= mp.mpf(high)


@pytest.mark.nightly
@given(tree=trees, place=places)
@settings(max_examples=150)
def test_a_jet_holds_the_first_two_derivatives(tree, place):
    tape, jets = lowered(tree), Jets(Multi(200))
    try:
        truth(tree, place)
        ours = tape.run(jets, [jets.variable(Multi(200).convert(place))])[0]
        with mp.workdps(60):
            theirs = [truth(sp.diff(tree, x, k), place) for k in range(3)]
    except (ZeroDivisionError, ValueError, OverflowError):
        assume(False)
    for mine, exact in zip(ours, theirs, strict=True):
        with mp.workdps(50):
            assert abs(mp.mpf(mine or 0) - exact) <= mp.mpf("1e-30") * (1 + max(abs(v) for v in theirs))
