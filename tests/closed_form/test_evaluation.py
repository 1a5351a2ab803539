"""Values and slopes of formulas by lists of lines are those of sympy, digit by digit."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from hjsolve.closed_form.evaluation import Evaluator, many_digits, number_of
from hjsolve.functions import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ, JacobiAM, JacobiCN, JacobiSN
from hjsolve.precision import mp

x, m, a = sp.symbols("x m a", real=True)
FORMULAS = [
    sp.elliptic_f(sp.asin(sp.sqrt(x)), m), sp.elliptic_e(sp.asin(sp.sqrt(x)), m),
    sp.elliptic_pi(m / 3, sp.asin(sp.sqrt(x)), m) * sp.sqrt(x + a) - sp.elliptic_k(m) / x**3,
    CarlsonRF(x, x + 1, a) + CarlsonRC(x + 1, a * x), CarlsonRD(x, a, x + 2) * sp.exp(-a * x),
    CarlsonRJ(x, x + 1, a, m + 2 * x), JacobiSN(x * a, m) ** 2 + JacobiCN(x, m) + JacobiAM(a * x, m),
    x**m + sp.pi * sp.log(a * x) / (1 + x) ** sp.Rational(3, 2) + sp.Abs(x - 2) + sp.atan2(x, a) * sp.acosh(2 + x**2),
]  # fmt: skip


@pytest.mark.parametrize("formula", FORMULAS)
def test_values_and_slopes_are_those_of_sympy(formula: sp.Expr) -> None:
    draw = random.Random(str(formula))
    at = {x: sp.Rational(draw.randint(10, 90), 100), m: sp.Rational(draw.randint(10, 90), 100), a: sp.Rational(7, 5)}
    with mp.workdps(50):
        along = Evaluator([formula], x).along(many_digits({m: at[m], a: at[a]}, 60), x)
        value, slope = along(mp.mpf(int(at[x].p)) / int(at[x].q))
    for got, exact in ((value, formula), (slope, sp.diff(formula, x))):
        truth = mp.mpmathify(sp.N(exact.xreplace(at), 50))
        assert abs(got - truth) <= abs(truth) * mp.mpf(10) ** -44


def test_what_is_no_number_is_nan_or_complex() -> None:
    with mp.workdps(30):
        assert mp.isnan(number_of(1 / (x - 1), {x: mp.mpf(1)}))
        assert isinstance(number_of(sp.sqrt(x), {x: mp.mpf(-1)}), mp.mpc)
        for arc in (sp.acos, sp.asin):
            assert mp.isnan(number_of(arc(x), {x: mp.mpc(mp.nan, 1)}))
    assert Evaluator([sp.S(3)], x).at({})[1] == 0
