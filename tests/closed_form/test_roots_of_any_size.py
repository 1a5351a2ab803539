"""Roots of polynomials whose sizes are far apart: those that the coefficients were made of, in 800 digits."""

from __future__ import annotations

import random

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.evaluation import many_digits
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.regions import complex_roots, region_exists, root_interval_of
from hjsolve.closed_form.sampling import Sample
from hjsolve.precision import mp


def _product(roots: list[mpmath.mpc]) -> tuple[mpmath.mpf, ...]:
    """The coefficients of ∏ (x − r)."""
    with mp.workdps(800):
        found = [mp.mpf(1)]
        for r in roots:
            found = [a - b * r for a, b in zip([*found, 0], [0, *found], strict=True)]
        return tuple(mp.re(c) for c in found)


@pytest.mark.parametrize("decades", [3, 20, 100, 300])
def test_every_root_is_found_whatever_its_size(decades: int) -> None:
    draw = random.Random(decades)
    for _ in range(12):
        with mp.workdps(60):
            roots = list[mpmath.mpc]()
            while len(roots) < 4:
                size = mp.mpf(10) ** draw.uniform(-decades, decades)
                if len(roots) < 3 and draw.random() < 0.3:
                    roots += [size * mp.expj(1 + draw.random()), 0]
                    roots[-1] = mp.conj(roots[-2])
                else:
                    roots.append(draw.choice((-1, 1)) * size)
            found = complex_roots(_product(roots), 50)
            assert len(found) == len(roots)
            for r in roots:  # next to a root of 1e300 all others were one, or none was found
                assert min(abs(z - r) for z in found) <= abs(r) * mp.mpf(10) ** -20


@pytest.mark.parametrize("energy", ["1e-20", "1e-60", "1e-300"])
def test_a_region_of_small_negative_energies_is_that_of_all(energy: str) -> None:
    # the turning point far away is at 3/(2·1e-300), the others are about 1: 300 steps for all roots at once failed
    context = context_of(hjsolve.solve("two-centres-plane"))
    numbers = {"m": 1, "k1": 1, "k2": "1/2", "a": 1, "E": "-1/1000", "alpha_2": "-1/3"}
    exact = {p.symbol: sp.Rational(numbers[p.name]) for p in context.solution.system.parameters}
    exact |= {c.symbol: sp.Rational(numbers[n]) for n, c in context.solution.constants.items()}
    curve = context.curves["xi"][0]
    like = root_interval_of(curve, Sample(exact, {"xi": sp.Integer(3), "eta": sp.Rational(1, 3)}))
    assert like is not None
    E = context.constants[0]
    assert region_exists(curve, like, many_digits(exact | {E: -sp.Rational(energy)}, 50))
    assert not region_exists(curve, like, many_digits(exact | {E: sp.Rational(energy)}, 50))
