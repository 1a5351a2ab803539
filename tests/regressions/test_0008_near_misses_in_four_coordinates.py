"""Near misses with four coordinates stayed undecided: the mixed derivative of V was multiplied out before it was asked.

Six million products of terms were more than one product may cost, although the value of the condition at a point costs
no more than a few evaluations of V.
"""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

from hjsolve.separation import Obstruction, separate
from tests.random_staeckel import SMALL, case


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
