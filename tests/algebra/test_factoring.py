"""Factors of polynomials: the product is the polynomial, factors agree with sympy's, and nothing takes minutes."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from hjsolve.algebra.factoring import MAX_DEGREES, MAX_DEGREES_OF_MANY, factored, irreducible
from hjsolve.mechanics.system import System
from hjsolve.separation import Separation, separate

x, y, z, a, b, c, m = sp.symbols("x y z a b c m")
s = sp.sin(x)


def random_product(seed: int) -> sp.Expr:
    generator = random.Random(seed)
    gens = generator.sample([y, z, a, b, s], generator.randint(1, 3))

    def part() -> sp.Expr:
        terms = range(generator.randint(1, 3))
        return sp.Add(
            *(generator.randint(-3, 3) * sp.Mul(*(g ** generator.randint(0, 2) for g in gens)) for _ in terms)
        )

    unit = generator.choice([1, 2, sp.Rational(3, 4), -1])
    return sp.expand(unit * sp.Mul(*(part() for _ in range(generator.randint(1, 3)))))


@pytest.mark.parametrize("seed", range(40))
def test_factors_of_random_products_are_those_of_sympy(seed: int) -> None:
    f = random_product(seed)
    ours = factored(f)
    assert sp.expand(ours - f) == 0
    assert ours == sp.factor(f)


@pytest.mark.parametrize(
    "product",
    [
        (x - a) * (x - b) * (x - c) * (y - a),
        m * (x**2 + y**2) ** 2 * (a * x + b),
        (m * x + y) ** 2 * (a**2 - b**2),
        (x**2 + y**2 + z**2) * (x * y * z * a + b**2 * c**2),
    ],
)
def test_products_of_mechanics_come_apart(product: sp.Expr) -> None:
    assert factored(sp.expand(product)) == sp.factor(sp.expand(product))


def test_what_is_no_polynomial_over_the_rationals_comes_back_as_given() -> None:
    for f in (sp.sqrt(2) * x + sp.sqrt(2) * y, sp.pi * x + sp.pi, 1 / x + 1 / y, sp.S.Zero, sp.Integer(3)):
        assert sp.simplify(factored(f) - f) == 0


def test_the_general_algorithm_is_asked_about_small_polynomials_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wang's algorithm took between 0.01 s and minutes for the 11 terms of one entry of this metric, by chance."""
    asked: list[tuple[int, int]] = []
    element = sp.polys.rings.PolyElement
    original = element.factor_list

    def recorded(self: sp.polys.rings.PolyElement) -> object:
        degrees = [d for d in self.degrees() if d > 0]
        asked.append((len(degrees), sum(degrees)))
        return original(self)

    monkeypatch.setattr(element, "factor_list", recorded)
    S, D = "(r**2 + a**2*cos(theta)**2)", "((r**2 + a**2)*(1 - l*r**2/3) - 2*M*r)"
    G = "(1 + l*a**2*cos(theta)**2/3)"
    kinetic = (
        f"-{D}/(2*{S})*(dot(t) - a*sin(theta)**2*dot(phi))**2 + {S}/(2*{D})*dot(r)**2 + {S}/(2*{G})*dot(theta)**2"
        f"+ {G}*sin(theta)**2/(2*{S})*((r**2 + a**2)*dot(phi) - a*dot(t))**2"
    )
    coordinates = {"t": "line", "r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}
    system = System(coordinates, kinetic, "0", {"M": "1", "a": "1/2", "l": "1/10"}, signature="indefinite")
    assert isinstance(separate(system), Separation)
    assert asked
    assert all(degrees <= MAX_DEGREES.get(count, MAX_DEGREES_OF_MANY) for count, degrees in asked)


def test_a_polynomial_of_high_degree_is_not_its_own_factor():
    ring = sp.polys.rings.ring("x, y, z", sp.ZZ)[0]
    x, y, _ = ring.gens
    f = (x**40 + y**2 + 1) * (y**40 + 3 * y**2 + 2)  # without z; too high for the general algorithm
    assert sp.prod([factor**e for factor, e in irreducible(f)]) == f
