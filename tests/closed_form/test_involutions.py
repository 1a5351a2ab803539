"""Genus that is left after involutions: curves made to have one, and curves made at random to have none."""

from __future__ import annotations

import random

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.form_context import context_of
from hjsolve.closed_form.involutions import _in_involution, why_no_form

pytestmark = pytest.mark.rotating_file(4)

X = sp.Symbol("x", real=True)


def moved(P: sp.Expr, rng: random.Random) -> sp.Poly:
    """P of six branch points under a Möbius map of the line."""
    a, b, c, d = rng.choice([(2, 1, 3, 5), (1, -4, 2, 3), (7, 2, 1, 1)])
    return sp.Poly(sp.cancel((c * X + d) ** 6 * P.subs(X, (a * X + b) / (c * X + d))), X, domain="QQ")


@pytest.mark.parametrize("seed", range(5))
def test_even_sextics_in_any_variable_are_in_involution(seed: int) -> None:
    rng = random.Random(seed)
    squares = [sp.Rational(rng.randint(-40, 40), 7) + sp.Rational(k, 97) for k in range(3)]
    assert _in_involution(moved(sp.Mul(*(X**2 - r for r in squares)), rng))
    assert _in_involution(sp.Poly(X * sp.Mul(*(X**2 - r for r in squares[:2])), X, domain="QQ"))


@pytest.mark.parametrize("unit", [1, 10**5, 10**20, sp.Rational(1, 10**10), sp.Rational(1, 10**20)])
@pytest.mark.parametrize(("roots", "found"), [
    ((1, 2, 5, 11, 30), False), ((1, 2, 5, 11, -7, 23), False), ((1, -1, 2, -2, 5, -5), True), ((0, 1, -1, 3, -3), True),
])  # fmt: skip
def test_an_involution_is_found_or_not_in_any_unit(roots: tuple[int, ...], found: bool, unit: sp.Rational) -> None:
    P = sp.Poly(sp.expand(sp.Mul(*(X - unit * r for r in roots))), X, domain="QQ")
    assert _in_involution(P) == found


@pytest.mark.parametrize("seed", range(5))
def test_sextics_at_random_are_not(seed: int) -> None:
    rng = random.Random(seed)
    P = sp.Add(*(sp.Rational(rng.randint(1, 90), 7) * (-1) ** rng.randint(0, 1) * X**k for k in range(7)))
    assert not _in_involution(moved(P, rng))


@pytest.mark.nightly_cases("garnier-eta-2", "neumann-beta-2", "triaxial-geodesics-alpha-2")
@pytest.mark.parametrize(
    ("name", "coordinate", "left"),
    [("triaxial-geodesics", "alpha", 2), ("neumann", "beta", 2), ("garnier", "eta", 2), ("tube-turning-freely", "theta", 3),
     ("elliptic-trammel", "theta", 2)],
)  # fmt: skip
def test_the_genus_of_known_systems(name: str, coordinate: str, left: int) -> None:
    """Jacobi's geodesics, Neumann's and Garnier's systems live on curves of genus 2."""
    proof = why_no_form(context_of(hjsolve.solve(name)).curves[coordinate])
    assert proof.proved
    assert proof.holds()
    found = str(proof)
    assert f"by its reflections {left}" in found
    assert ("no Möbius involution reduces it" in found) == (left == 2)
