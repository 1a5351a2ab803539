"""√P over the named roots in doubles: the same value everywhere, and W next to a turning point keeps its digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.derive import form_of_sample
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.radicands_by_roots import RadicandsByRoots
from hjsolve.closed_form.sampling import Sample
from tests.support.entries import forms, solution

ULP = 2.0**-52
X = sp.Symbol("x", real=True)


def _action(c: float, E: float, low: float, high: float) -> mpmath.mpf:
    """∫ √(2E − q² − (2√2/3) c q³) dq between two places, by quadrature."""
    with mpmath.workdps(40):
        E, c = mpmath.mpf(E), mpmath.mpf(c)
        root = mpmath.sqrt

        def momentum(q: mpmath.mpf) -> mpmath.mpf:
            return root(2 * E - q**2 - 2 * root(2) / 3 * c * q**3)

        return mpmath.quad(momentum, [mpmath.mpf(low), mpmath.mpf(high)])


# c, u_0, u, v_0, v, E, alpha_2: u is within 1e-5 of its turning point, and form and quadrature were 1e5 units apart
ESCAPES = [
    (1.0, 1.1576651866380547, 1.1576655706239936, -0.8559023323461653, -0.855814745905533, 1.4722047580577924,
     0.07072978440605351),
    (0.9082643483691231, 4.506369645959288, 4.506372231777451, -1.0896713935888218, -1.0889175646815044,
     49.37701768885026, 0.04125252332402256),
]  # fmt: skip


@pytest.mark.nightly
@pytest.mark.parametrize("motion", ESCAPES, ids=["small", "large"])
def test_the_characteristic_function_next_to_a_turning_point(motion: tuple[float, ...]) -> None:
    given = dict(zip(("c", "u_0", "u", "v_0", "v", "E", "alpha_2"), motion, strict=True))
    context = context_of(solution("henon-heiles-separable"))
    system = context.solution.system
    symbols = [*(p.symbol for p in system.parameters), *(c.symbol for c in context.solution.constants.values())]
    sample = Sample({s: sp.Rational(given[s.name]) for s in symbols}, {n: sp.Rational(given[n]) for n in ("u", "v")})
    form = form_of_sample(context, context.curves, {}, sample)
    assert form is not None
    function = form.lambdify("numpy")["characteristic_function"]
    got = function(**{n: np.array([given[n]]) for n in function.names})[0]
    c, u_0, u, v_0, v, E, a = motion
    with mpmath.workdps(40):
        parts = _action(c, mpmath.mpf(E) - mpmath.mpf(a), u_0, u), _action(c, a, v_0, v)
        # what the roundings of the places do, |q ∂W/∂q|
        slopes = sum(abs(q) * part / (high - low) for q, part, high, low in ((u, parts[0], u, u_0), (v, parts[1], v, v_0)))
        assert abs(got - sum(parts)) <= 16 * ULP * slopes


def test_radicands_are_written_by_roots_and_others_are_left() -> None:
    a, b, c, q, q_0 = sp.symbols("a b c q q_0", real=True)
    P = sp.Poly(a * X**3 + b * X + c, X)
    roots = sp.symbols("x_1:4", real=True)
    by_roots = RadicandsByRoots({r: (P, k) for k, r in enumerate(roots)}, {q: sp.cos(q), q_0: sp.cos(q_0)})
    other = sp.sqrt(a * sp.cos(q) ** 3 + b * sp.cos(q) + 2 * c)
    made = by_roots(sp.sqrt(-3 * P.as_expr().subs(X, sp.cos(q_0))) + other)
    product = -3 * a * sp.Mul(*(sp.cos(q_0) - r for r in roots))
    assert made == sp.sqrt(product) + other


def test_a_pair_without_names_leaves_the_radicand() -> None:
    a, q = sp.symbols("a q", real=True)
    P, root = sp.Poly(X**3 + X - a, X), sp.Symbol("x_1", real=True)
    plain = sp.sqrt(P.as_expr().subs(X, q))
    assert RadicandsByRoots({root: (P, 0)}, {q: q})(plain) == plain
    along, across = sp.symbols("x_re x_im", real=True)
    pair = {along: -root / 2, across: sp.sqrt(1 + root**2 - root**2 / 4)}
    made = RadicandsByRoots({root: (P, 0), **pair}, {q: q})(plain)
    assert made == sp.sqrt((q - root) * ((q - along) ** 2 + across**2))


def test_arcs_of_what_overflowed_are_no_numbers_to_be_believed() -> None:
    # beyond x = 355 cosh² is above all doubles, and V = 0 to 300 digits: W = √(2mE) (x − x₀); it was −0.640 for 0.460
    form = next(f for f in forms("poeschl-teller") if f.regime.words == "x: escape; E > 0")
    given = {"m": 1.0, "V0": 0.98, "a": 1.0, "x": 458.5, "E": 2.85e-6, "x_0": 267.0}
    function = form.lambdify("numpy")["characteristic_function"]
    got = function(**{n: np.array([given[n]]) for n in function.names})[0]
    right = np.sqrt(2 * given["m"] * given["E"]) * (given["x"] - given["x_0"])
    assert abs(got - right) <= 16 * ULP * given["x"] * np.sqrt(2 * given["E"])
