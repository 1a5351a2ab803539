"""The mass matrix read off T, and the sizes that formulas may have."""

import pytest
import sympy as sp

from hjsolve.errors import ExpressionError
from hjsolve.formulas.read import parse
from hjsolve.mechanics.kinetic_energy import mass_as_written, mass_entries, velocity_coefficients

x, y, m = sp.symbols("x y m", real=True)
u, v = sp.symbols("u v", real=True)
FORMS = [
    m / 2 * (u**2 + x**2 * v**2),
    (u + v * sp.cos(x)) ** 2 / (1 + x**2) + (u - y) * v * m,
    (m * u + (x + y) * v) * (u - x * v) / sp.exp(x) + 3 * u + x,
    2 * u * v - (u + v) ** 2 + 5 * u**2 * sp.sin(y) ** 2 + sp.cos(y) ** 2 * 5 * u**2,
]


@pytest.mark.parametrize("kinetic", FORMS, ids=str)
def test_the_parts_of_the_kinetic_energy_are_its_derivatives(kinetic):
    found = velocity_coefficients(kinetic, [u, v])
    rest = {u: 0, v: 0}
    assert sp.simplify(found.get((), 0) - kinetic.subs(rest)) == 0
    for i, p in enumerate((u, v)):
        assert sp.simplify(found.get((i,), 0) - kinetic.diff(p).subs(rest)) == 0
    for matrix in (mass_as_written(kinetic, [u, v]), mass_entries(kinetic, [u, v])):
        assert (matrix - sp.hessian(kinetic, (u, v))).applyfunc(sp.simplify) == sp.zeros(2, 2)


def test_entries_are_tidied_where_sine_and_cosine_squared_add_up():
    kinetic = m / 2 * ((u * sp.cos(x) + v * sp.sin(x)) ** 2 + (u * sp.sin(x) - v * sp.cos(x)) ** 2)
    assert mass_entries(kinetic, [u, v]) == sp.ImmutableMatrix([[m, 0], [0, m]])


NAMES = {name: sp.Symbol(name, real=True) for name in "abcdefgxyz"}


def factors(count):
    return "*".join(f"(x - {name})*(x + {name})" for name in "abcdefg"[:count])


def test_numerators_and_denominators_are_counted_by_themselves():
    parsed = parse(f"({factors(5).replace('x', 'y')})/({factors(6)})", NAMES, source="V")
    assert sp.degree(sp.fraction(parsed)[1], NAMES["x"]) == 12


@pytest.mark.parametrize("text", [factors(7), f"1/({factors(7)})", f"1/(1/({factors(7)}))", f"({factors(7)})**(-1)"])
def test_too_many_terms_are_refused_above_and_below_the_line(text):
    with pytest.raises(ExpressionError, match="more than 5000 terms"):
        parse(text, NAMES, source="V")


@pytest.mark.parametrize(
    "text", ["(x + y + z + a + b)**-30", "1/(x + y + z + a + b)**30", "1/(1/(x + y + z + a + b)**30)"]
)
def test_large_powers_of_sums_are_refused_above_and_below_the_line(text):
    with pytest.raises(ExpressionError, match="terms"):
        parse(text, NAMES, source="V")
