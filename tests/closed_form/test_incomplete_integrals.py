"""F and Π of a pole next to a root, put together for doubles: against quadrature, and the same value elsewhere."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.derive import form_of_sample
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.incomplete_integrals import IncompleteIntegrals
from hjsolve.closed_form.sampling import Sample
from hjsolve.functions import modules
from tests.support.entries import solution

ULP = 2.0**-52
a, b, d, r, k, χ = sp.symbols("a b d r k chi", positive=True)
N = (d - r) * (b - a) / ((a - r) * (b - d))
PLAIN = (sp.elliptic_f(χ, k**2) / (d - r) + (d - a) / ((a - r) * (d - r)) * sp.elliptic_pi(N, χ, k**2)) / 3
"""⅓ ∫ dφ/((x − r) Δ)."""


def test_a_pole_next_to_the_root_at_infinity_of_s() -> None:
    x = sp.Symbol("x", positive=True)
    made = IncompleteIntegrals({χ: sp.asin(x)}).arranged(PLAIN)
    assert not made.has(sp.elliptic_pi)
    names = [a, b, d, r, k, χ]
    plain, better = (sp.lambdify(names, e, modules=modules("numpy")) for e in (PLAIN, made))
    for gap in (0.5, 1e-3, 1e-6, 1e-9):
        at = (3.0, 0.25, 1.0 + gap, 1.0, 0.5, 0.75)
        with mpmath.workdps(40):
            A, B, D, R, m, top = (mpmath.mpf(v) for v in at)

            def integrand(φ: mpmath.mpf, A=A, B=B, D=D, R=R, m=m) -> mpmath.mpf:  # type: ignore[no-untyped-def]
                s = mpmath.sin(φ) ** 2
                ν = (B - A) / (B - D)  # x = (a − νds)/(1 − νs)
                place = (A - ν * D * s) / (1 - ν * s)
                return 1 / (place - R) / mpmath.sqrt(1 - m**2 * s) / 3

            truth = mpmath.quad(integrand, [0, top])
        assert abs(float(better(*at)) - truth) <= 16 * ULP * abs(truth), gap
        if gap == 1e-9:
            assert abs(float(plain(*at)) - truth) > 1e-8 * abs(truth)


def test_what_may_be_beyond_a_quarter_turn_is_left() -> None:
    for where in ({}, {χ: sp.acos(r)}):
        assert IncompleteIntegrals(where).arranged(PLAIN) == PLAIN


@pytest.mark.nightly
def test_coordinate_time_about_a_black_hole_for_a_small_p_t() -> None:
    # a root of the radicand is 1e-9 from the horizon: 4e8 and 1e7 units of the last place were lost
    given = {
        "M": 1.2609793091398416, "r": 3.1847381038478084, "theta": 1.5593738404996502, "E": 397.5645259280987,
        "alpha_2": 3827.0612041672284, "p_t": 0.0011303084875980507, "p_phi": -71.80855570528763,
        "r_0": 3.1112797840617232, "theta_0": 1.203542129440045,
    }  # fmt: skip
    context = context_of(solution("schwarzschild"))
    system = context.solution.system
    symbols = [*(p.symbol for p in system.parameters), *(c.symbol for c in context.solution.constants.values())]
    exact = {s: sp.Rational(given[s.name]) for s in symbols}
    form = form_of_sample(context, context.curves, {}, Sample(exact, {n: sp.Rational(given[n]) for n in ("r", "theta")}))
    assert form is not None
    function = form.lambdify("numpy")["orbit_equations.p_t"]
    got = function(**{n: np.array([given.get(n, 0.0)]) for n in function.names})[0]
    with mpmath.workdps(40):
        M, E, α, p_t = (mpmath.mpf(given[n]) for n in ("M", "E", "alpha_2", "p_t"))

        def integrand(x: mpmath.mpf) -> mpmath.mpf:
            # P_r² = (p_t² + 2Ef − 2αf/r²)/f² with f = 1 − 2M/r, and its half derivative by p_t over its root
            f = 1 - 2 * M / x
            return p_t / f / mpmath.sqrt(p_t**2 + 2 * E * f - 2 * α * f / x**2)

        truth = mpmath.quad(integrand, [mpmath.mpf(given["r_0"]), mpmath.mpf(given["r"])])
    assert abs(abs(got) - truth) <= 64 * ULP * truth
