"""Energy–momentum maps of steep potentials: P² and its slope share a root of high multiplicity at the origin."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.energy_momentum.multiple_roots import real_roots

T = "(dot(r)**2 + r**2*dot(theta)**2)/2"


def kinds(potential, p: float, E: float) -> str:
    """Of the motions at E, from the signs of E − V_eff on a dense grid: a libration for each allowed stretch inside."""
    r = np.geomspace(0.2, 2000, 400_000)
    allowed = E - potential(r) - p**2 / (2 * r**2) > 0
    begins, ends = allowed & ~np.roll(allowed, 1), allowed & ~np.roll(allowed, -1)
    assert not allowed[0]
    found = int(begins[1:].sum()), int(ends[:-1].sum()), bool(allowed[-1])
    return ("libration",) * found[1] + ("escape",) * found[2]


@pytest.mark.parametrize(
    ("n", "m", "strength"),
    [(12, 6, 4), *(pytest.param(*x, marks=pytest.mark.nightly) for x in ((9, 6, 1), (10, 5, 1), (14, 7, 2)))],
)
def test_maps_of_lennard_jones_have_the_kinds_that_the_effective_potential_shows(n: int, m: int, strength: int) -> None:
    solution = hjsolve.solve(hjsolve.System({"r": "0 < r", "theta": "angle"}, T, f"{strength}*(1/r**{n} - 1/r**{m})"))
    window = {"p_theta": (0.005, 3), "E": (-2, 2)}
    found = hjsolve.energy_momentum_map(solution, x="p_theta", y="E", window=window)
    met = set()
    for p in (0.1, 0.5, 1.1, 1.9):
        for E in (-1.7, -0.31, -0.013, 0.011, 0.07, 0.9):
            expected = kinds(lambda r: strength * (r**-n - r**-m), p, E)
            assert found.kinds_at(p, E) == ({"r": expected} if expected else {"r": ()}), (p, E)
            met.add(expected)
    assert {(), ("libration",), ("escape",)} <= met


def test_roots_of_any_multiplicity_are_found_once_to_30_digits() -> None:
    x = sp.Symbol("x", real=True)
    cases = {
        x**11 * (x**6 - 2): [-(2 ** sp.Rational(1, 6)), 0, 2 ** sp.Rational(1, 6)],
        (3 * x - 1) ** 3 * (x + 5) ** 2 * (x**2 + 1) ** 4: [-5, sp.Rational(1, 3)],
        x**4 - 2 * sp.pi * x**2 + sp.pi**2: [-sp.sqrt(sp.pi), sp.sqrt(sp.pi)],
        x**5 * (x**2 - sp.sqrt(2)) ** 2: [-(2 ** sp.Rational(1, 4)), 0, 2 ** sp.Rational(1, 4)],
        x**3 - sp.Rational(2, 10**60): [2 ** sp.Rational(1, 3) / sp.Integer(10) ** 20],
        (x - 1) ** 2 * (x - 1 - sp.Rational(1, 10**12)): [1, 1 + sp.Rational(1, 10**12)],
    }
    for expression, truth in cases.items():
        found = real_roots(sp.Poly(sp.expand(expression), x))
        assert len(found) == len(truth)
        for root, exact in zip(found, truth):
            assert abs(sp.N(root - exact, 60)) <= abs(sp.N(exact, 40)) * sp.Rational(1, 10**28)
