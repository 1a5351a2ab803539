"""The algebra of a point: radicals kept formal, numbers that a parameter has not met, and those that it has."""

from __future__ import annotations

from random import Random

import pytest
import sympy as sp
from sympy.polys.rings import PolyElement

from hjsolve.coordinates.killing.radical_algebra import PointAlgebra, collected_generators, prepared

x, y = sp.symbols("x y", real=True)
k, c = sp.symbols("k c", real=True)
r1, r2 = sp.sqrt((x + 1) ** 2 + y**2), sp.sqrt((x - 1) ** 2 + y**2)
ξ, η = (r1 + r2) / 2, (r1 - r2) / 2
POTENTIALS = {
    "lens": (ξ * sp.sqrt(ξ**2 - 1) * sp.acosh(ξ) + η * sp.sqrt(1 - η**2) * (sp.acos(η) - c)) / (ξ**2 - η**2),
    "two centres": -k / r1 - c / r2,
}


@pytest.mark.parametrize("name", list(POTENTIALS))
def test_an_element_with_a_parameter_times_its_inverse_is_one(name):
    V = prepared([POTENTIALS[name]], (x, y))
    algebra = PointAlgebra(collected_generators(V, (x, y)), Random(1))
    value = algebra.evaluate(V[0])
    field = algebra.field
    assert any(isinstance(number, PolyElement) for number in value.values())
    one = algebra.multiply(value, algebra.inverse(value))
    assert {key: field.convert(number) for key, number in one.items()} == {(): field.one}


def test_the_value_at_a_point_is_that_of_the_expression_there():
    V = k * (x + sp.sqrt(x**2 + y**2)) ** 2 / (c + y * sp.sqrt(x**2 + y**2)) + x / 3
    algebra = PointAlgebra(collected_generators([V], (x, y)), Random(2))
    r = sp.sqrt(x**2 + y**2)
    ((key, _),) = algebra.evaluate(r).items()
    numbers = {name: algebra.field.to_sympy(algebra.field.convert(a)) for name, a in algebra.evaluate(V).items()}
    assert numbers.keys() == {(), key}
    there = V.xreplace(algebra.plain)
    assert sp.simplify(numbers[()] + numbers[key] * r.xreplace(algebra.plain) - there) == 0
