"""Sums of complete integrals over B, D and J: the value as before, and in doubles to its last places."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.complete_integrals import COMPLETE
from hjsolve.closed_form.evaluation import number_of
from hjsolve.functions import modules
from hjsolve.precision import mp

E, p, q, x = sp.symbols("E p q x", real=True)
X = sp.symbols("x_1:4", real=True)
P = sp.Poly((1 - x**2) * (E - x) - (p - q * x) ** 2 / 2, x)
"""Of a top: P(1) and P(−1) are −(p ∓ q)²/2, negative of squares."""
K2, NU, NU_1 = sp.symbols("k2 nu nu_1", real=True)
WHERE = {
    **{name: (P, k) for k, name in enumerate(X)},
    K2: (X[1] - X[0]) / (X[2] - X[0]),
    NU: (X[1] - X[0]) / (1 - X[0]),
    NU_1: -(X[1] - X[0]) / (1 + X[0]),
}
PARTS = (
    (p - q) * sp.elliptic_pi(NU, K2) / (1 - X[0]),
    (p + q) * sp.elliptic_pi(NU_1, K2) / (1 + X[0]),
)


def numbers(**constants):
    """Constants and what is defined by them, to 60 digits."""
    with mp.workdps(60):
        at = {s: mp.mpf(float(constants[s.name])) for s in (E, p, q)}  # doubles, so that nothing is rounded
        roots = mp.polyroots([number_of(c, at) for c in P.all_coeffs()], maxsteps=500, extraprec=400)
        at |= dict(zip(X, sorted(mp.re(r) for r in roots), strict=True))
        return at | {s: number_of(e, at) for s, e in WHERE.items() if not isinstance(e, tuple)}


@pytest.fixture(scope="module")
def arrange():
    return ForDoubles(WHERE, numbers(E=3, p="0.7", q="0.4"))


def units(expression, arrange, at):
    """The distance of a form in doubles from 50 digits, in units of its last place; roots are rounded once."""
    made = arrange.form(expression)
    found = arrange.definitions(made.free_symbols)
    known = {s: float(at[s]) for s in (E, p, q, *X)}
    for name in (s for s in (K2, NU, NU_1) if s in found):
        known[name] = sp.lambdify(list(known), found[name], modules("numpy"))(*map(np.float64, known.values()))
    with np.errstate(all="ignore"):
        got = sp.lambdify(list(known), made, modules("numpy"), cse=True)(*map(np.float64, known.values()))
    with mp.workdps(50):
        exact = number_of(expression, at)
    return float(abs(mp.mpf(float(got)) - exact)) / float(np.spacing(abs(float(exact))))


@pytest.mark.parametrize("sign", [1, pytest.param(-1, marks=pytest.mark.nightly)])
def test_half_turns_of_two_poles_cancel_in_whole_numbers(arrange, sign):
    """Of a fast top each Π is a half turn and little more: their difference had up to 1e6 units of the last place."""
    total, draw = PARTS[0] + sign * PARTS[1], random.Random(sign)
    for _ in range(60):
        size = 10 ** draw.uniform(0.5, 3.5)
        at = numbers(E=size, p=draw.uniform(-1, 1), q=draw.uniform(-1, 1))
        assert units(total, arrange, at) <= 100, at


def test_a_pole_that_is_far_keeps_its_integral(arrange):
    at = numbers(E=1.49, p=-1.96, q=-1.58)
    assert at[NU_1] ** 2 < at[K2]
    assert units(PARTS[1], arrange, at) <= 20
    at = numbers(E=0.5, p=0.3 + 2**-30, q=0.3)  # x₃ is at the pole, and the motion far from it
    assert at[NU] ** 2 < at[K2]
    assert at[NU] - at[K2] < 1e-15
    assert units(PARTS[0], arrange, at) <= 20


@pytest.mark.parametrize("m", ["1e-12", "0.3", "0.999999999"])
def test_what_is_of_the_order_of_m_has_all_digits(arrange, m):
    """E − (1 − m) K of a small oscillation, with m a quotient of constants."""
    ratio = p / E
    value = 2 * E * sp.elliptic_e(ratio) - 2 * (E - p) * sp.elliptic_k(ratio)
    made = arrange.form(value)
    assert not made.has(*COMPLETE)
    given = float(m)
    with mp.workdps(50):
        exact = number_of(value, {E: mp.mpf(1), p: mp.mpf(given)})
    got = sp.lambdify([E, p], made, modules("numpy"))(np.float64(1), np.float64(given))
    assert abs(mp.mpf(float(got)) - exact) <= 10 * np.spacing(float(exact))


@pytest.mark.parametrize(("c", "size"), [(1, "1e-7"), (-1, "1e-6")])
def test_a_root_next_to_a_pole_is_a_quotient_on_either_side(arrange, c, size):
    at = numbers(E=40, p=float(size) + c * 0.3, q="0.3")  # p − c q is tiny: so is P(c)
    for gap in (c - X[0], c - X[1]):
        assert units(gap, arrange, at) <= 20 or abs(number_of(gap, at)) > 0.1


def test_a_root_minus_nearly_itself_is_by_the_conjugate(arrange):
    total = sp.sqrt(q**2 + 2 * E) - q
    made = arrange.form(total)
    at = {E: mp.mpf("1e-9"), q: mp.mpf(1), p: mp.mpf(0)}
    given = [np.float64(1e-9), np.float64(1), np.float64(0)]
    with mp.workdps(50):
        exact = number_of(total, at | {E: mp.mpf(1e-9)})
    got = float(sp.lambdify([E, q, p], made, modules("numpy"))(*given))
    assert abs(got - exact) <= 4 * np.spacing(float(exact))
    assert sp.lambdify([E, q, p], made, "math")(1e-9, -1.0, 0) == 2 + 1e-9
