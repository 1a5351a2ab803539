"""Four coordinates stayed undecided: what nobody needs was multiplied out.

Near misses: the mixed derivative of V, six million products of terms, although the value of the condition at a point
costs no more than a few evaluations of V. Separable systems: a base point where √(x² + 5) and log(y² + 2) are irrational,
which made every constant of Φ a polynomial in √5 and log 2, and Φ⁻¹ by elimination, with pivots that cancel in the end.
"""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

from hjsolve.separation import Obstruction, Separation, separate
from tests.support.random_staeckel import SMALL, case


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [400003, 400004])
def test_a_disturbance_of_a_billionth_is_found_among_a_thousand_terms(seed):
    """V is a separable potential plus one known term: S_ij(V) is S_ij of that term, by numerical slopes of g."""
    near, exact = case(seed, 4, separable=False).system, case(seed, 4, separable=True).system
    verdict = separate(near)
    assert isinstance(verdict, Obstruction)
    assert verdict.part == "potential"
    term = near.potential - exact.potential
    assert (term / SMALL).as_coeff_Mul()[0] == 1
    i, j = (near.symbols[name] for name in verdict.pair)
    gi, gj = (verdict.shell.inverse_metric[[c.name for c in near.coordinates].index(name)] for name in verdict.pair)
    point = {near.symbols[name]: value for name, value in verdict.witness.point.items()}

    def slope(f: sp.Expr, q: sp.Symbol) -> mpmath.mpf:
        """∂ ln f/∂q at the witness."""
        of_q = sp.lambdify(q, f.xreplace({s: v for s, v in point.items() if s != q}), "mpmath")
        here = mpmath.mpf(point[q].p) / point[q].q
        return mpmath.diff(of_q, here) / of_q(here)

    with mpmath.workdps(60):
        mixed, along_i, along_j = (mpmath.mpf(term.diff(*q).subs(point).evalf(60)) for q in ((i, j), (i,), (j,)))
        expected = mixed - slope(gj, i) * along_j - slope(gi, j) * along_i
        assert verdict.witness.lower <= expected <= verdict.witness.upper
        assert verdict.witness.excludes_zero


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [400002, 400003])
def test_separable_systems_of_a_thousand_terms_separate(seed):
    """cᵀΦ = (1, 0, …, 0) and cᵀψ = V at a point of our own, to 40 digits."""
    system = case(seed, 4, separable=True).system
    verdict = separate(system)
    assert isinstance(verdict, Separation)
    form, point = verdict.stackel, {c.symbol: sp.Rational(2 * k + 3, 5) for k, c in enumerate(system.coordinates)}
    metric = sp.Matrix([g.subs(point).evalf(60) for g in form.inverse_metric]).T
    error = metric * form.matrix.subs(point).evalf(60) - sp.Matrix([[1, 0, 0, 0]])
    assert max(abs(x) for x in error) < 1e-40
    V = system.potential.subs(point).evalf(60)
    assert abs((metric * sp.Matrix(form.column).subs(point).evalf(60))[0] - V) < 1e-40 * abs(V)
    for i, q in enumerate(system.coordinates):
        assert sp.Tuple(*form.matrix.row(i), form.column[i]).free_symbols <= {q.symbol}


def test_the_few_rational_points_of_a_root_are_not_the_only_base_points():
    """√(x² + 5) is rational at few simple places; where Φ is singular at all of them, others are tried."""
    assert isinstance(separate(case(300013, 3, separable=True).system), Separation)
