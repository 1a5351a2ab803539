"""Parameters at which a pole of an integrand meets a root of P, or goes to infinity: R = r of a torus."""

from __future__ import annotations

import math

import pytest
import sympy as sp

from hjsolve.precision import mp
from tests.support.entries import forms


@pytest.mark.nightly
def test_a_torus_without_a_hole_is_of_a_regime_of_its_own() -> None:
    """Its forms divided by R − r before; the period of u is ∮ r² du/p_u, with 2E r² = p_u² + (p_v r/(R + r cos u))²."""
    given = {"R": 2.0, "r": 2.0, "E": 4.14025568137, "p_v": -6.0}
    exact = {name: sp.Rational(*value.as_integer_ratio()) for name, value in given.items()}
    holding = [f for f in forms("torus-geodesics") if f.regime.holds({s: exact[s.name] for s in f.regime.example})]
    with mp.workdps(30):
        radius, energy, momentum = mp.mpf(2), mp.mpf(given["E"]), mp.mpf(6)
        turn, count = mp.acos((momentum / mp.sqrt(2 * energy) - radius) / radius), 400
        total = mp.mpf(0)
        for k in range(count):
            u = turn * mp.cos((k + mp.mpf(1) / 2) * mp.pi / count)
            p = mp.sqrt(2 * energy * radius**2 - (momentum / (1 + mp.cos(u))) ** 2)
            total += radius**2 / p * turn * mp.sin((k + mp.mpf(1) / 2) * mp.pi / count)
        period = float(2 * total * mp.pi / count)
    assert holding
    for form in holding:
        function = form.lambdify("numpy")["periods.u"]
        assert math.isclose(float(function(**{n: given[n] for n in function.names})), period, rel_tol=1e-13)
        for name, value in form.lambdify("numpy").items():
            if name.startswith(("periods.", "frequencies.", "actions.")):
                assert math.isfinite(float(value(**{n: given[n] for n in value.names}))), name
