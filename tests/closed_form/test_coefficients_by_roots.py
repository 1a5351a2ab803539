"""Letters of P by its roots: the same value, and its digits where a root is far away."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

from hjsolve.closed_form.coefficients_by_roots import far_points, in_roots
from hjsolve.closed_form.complete_integrals import roots_by_polynomial
from hjsolve.closed_form.evaluation import evaluator
from hjsolve.closed_form.regions import ordered_real_roots
from hjsolve.precision import mp
from tests.support.entries import forms

X = sp.Symbol("x", real=True)
E, K, A = sp.symbols("E k alpha", real=True)
P = sp.Poly(2 * E * X**4 + 2 * K * X**3 - (4 * E + 2 * A) * X**2 - 2 * K * X + 2 * E + 2 * A - sp.Rational(1, 3), X)
ROOTS = sp.symbols("x_1:5", real=True)
WHERE = {x: (P, k) for k, x in enumerate(ROOTS)}


def _values(energy: float) -> dict[sp.Symbol, mpmath.mpf]:
    known = {E: mp.mpf(energy), K: mp.mpf("1.25"), A: mp.mpf("-0.375")}
    return known | dict(zip(ROOTS, ordered_real_roots(P, known, 50), strict=True))


@pytest.mark.parametrize("energy", [0.25, 2**-12, -(2**-12)])
def test_a_coefficient_has_the_same_value_and_all_digits(energy: float) -> None:
    with mp.workdps(50):
        known = _values(energy)
        far = max(ROOTS, key=lambda x: abs(known[x]))
        own = E * (far**2 + ROOTS[1] * far) + K * far - A
        written = in_roots(own, roots_by_polynomial(WHERE))
        assert not written.free_symbols & {K, A}
        made = sp.factor(written)
        true, same = (evaluator(e).at(known)[0] for e in (own, made))
        assert abs(true - same) <= abs(true) * mp.mpf(10) ** -40
    values = {s: float(v) for s, v in known.items()}
    off = {e: abs(float(e.subs(values)) - float(true)) / abs(float(true)) / 2**-53 for e in (own, made)}
    assert off[made] < 40
    if abs(energy) < 1e-3:
        assert off[own] > 200  # else the arrangement is of no use


@pytest.mark.nightly
@pytest.mark.parametrize(("constants", "units"), [
    ({"m": 0.5, "a": 1.9, "k": 0.7, "E": 2.99026381309e-4, "alpha_2": -0.446062788498, "p_phi": -0.05}, 12),
    ({"m": 0.35, "a": 1.45, "k": 1.3, "E": -9.45216315436e-4, "alpha_2": -0.0260685570501, "p_phi": -0.65}, 150),
], ids=["hyperbolic", "elliptic, condition 47"])  # fmt: skip
def test_the_action_of_eta_of_a_weakly_bound_motion(constants: dict[str, float], units: float) -> None:
    """J_η of Kepler's problem in prolate coordinates, ∮ p dη/2π: 7 500 and 71 000 units off before."""
    exact = {name: sp.Rational(*value.as_integer_ratio()) for name, value in constants.items()}
    form = next(
        f for f in forms("kepler-prolate")
        if not f.regime.special and f.regime.holds({s: exact[s.name] for s in f.regime.example})
    )  # fmt: skip
    got = float(form.lambdify("numpy")["actions.eta"](**constants))
    η = form.solution.system.coordinate("eta").symbol
    square = form.solution.momentum_squared["eta"].xreplace({s: exact[s.name] for s in form.regime.example})
    with mp.workdps(40):
        low, high = (
            mp.mpf(form.evaluate(f"turning_points.eta.{side}", constants, 40).value) for side in ("lower", "upper")
        )
        p2 = evaluator(square).along({}, η)
        middle, half, count = (low + high) / 2, (high - low) / 2, 600
        angles = [(k + mp.mpf(1) / 2) * mp.pi / count for k in range(count)]
        terms = [mp.sqrt(abs(p2(middle - half * mp.cos(t))[0])) * half * mp.sin(t) for t in angles]
        true = float(mp.fsum(terms) / count)
    assert abs(got - true) <= units * abs(true) * 2**-52


def test_motions_with_a_root_far_away_have_all_roots() -> None:
    with mp.workdps(50):
        (point,) = far_points(WHERE, _values(0.25))
        true = _values(0.25 / 2**10)
    assert all(abs(point[x] - true[x]) <= abs(true[x]) * mp.mpf(10) ** -25 for x in ROOTS)
    assert max(abs(point[x]) for x in ROOTS) > 1000
