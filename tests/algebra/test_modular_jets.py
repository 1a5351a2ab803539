"""Derivatives modulo primes: against the exact derivatives of the field at the same points."""

from __future__ import annotations

from itertools import combinations

import pytest
import sympy as sp

from hjsolve.algebra.modular import Filter, ModularPoint, NoRootError
from hjsolve.algebra.modular_jets import ModularJets, at_random_points
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.energy_shell import Shell, reduce
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.obstruction import obstruction
from hjsolve.separation.obstruction.blocks import components
from tests.support.separation_cases import REFUSED, SEPARABLE

x, y, z = sp.symbols("x y z", real=True)
f = sp.Function("f")
FUNCTIONS = (
    x**2 * y**3 + x * z - 7,
    sp.sin(x) * sp.cos(y) ** 2 / (1 + x**2 * z**2),
    sp.sqrt(x**2 + y**2 + 1) * sp.exp(x - 2 * z),
    sp.cosh(x * y) / (z + sp.sinh(x * y)),
    (x + y) ** 3 / (x * y + z) ** 2 + sp.log(1 + x**2 * y**2),
    f(x * y) * f(z) + f(x * y).diff(x),
    sp.Rational(2, 3) * z**4,
    sp.S.Zero,
)


@pytest.mark.parametrize("function", FUNCTIONS, ids=str)
def test_slopes_and_mixed_derivatives_are_those_of_the_field(function):
    q = (x, y, z)
    reader = Reader([function])
    element = reader.element(function)
    points = 0
    for seed in range(20):
        point = ModularPoint(reader.field, seed)
        try:
            jet = ModularJets(reader, q, point).element(element)
        except NoRootError:
            continue
        points += 1
        assert jet.value == point.element(element)
        for i in range(3):
            slope = reader.diff(element, q[i])
            assert jet.slopes[i] == point.element(slope)
            for j in range(i + 1, 3):
                assert jet.mixed[i, j] == point.element(reader.diff(slope, q[j]))
    assert points > 4


def test_the_logarithm_of_a_jet_is_the_jet_of_the_logarithm():
    function = (x + y) ** 3 / (x * y + z) ** 2
    reader = Reader([function])
    element = reader.element(function)
    ((prime, (jet,)),) = at_random_points(reader, (x, y, z), [element], points=1)
    logarithm = jet.logarithm(prime)
    point = ModularPoint(reader.field, 0)
    assert prime == point.prime
    for i, q in enumerate((x, y, z)):
        slope = reader.log_diff(element, q)
        assert logarithm.slopes[i] == point.element(slope)
        for j in range(i + 1, 3):
            assert logarithm.mixed[i, j] == point.element(reader.diff(slope, (x, y, z)[j]))


def test_a_point_where_a_function_vanishes_or_has_no_root_is_passed_over():
    function = sp.sqrt(x**2 + y + 3)
    reader = Reader([function])
    found = at_random_points(reader, (x, y), [reader.element(function)], points=5)
    assert len({prime for prime, _ in found}) == 5
    reader = Reader([x])
    jets = ModularJets(reader, (x,), ModularPoint(reader.field, 0))
    with pytest.raises(ZeroDivisionError, match="vanishes"):
        jets.element(reader.field.zero).logarithm(jets.point.prime)


ORTHOGONAL = {
    name: shell
    for name, system in [*SEPARABLE.items(), *((name, system) for name, (system, _, _) in REFUSED.items())]
    if isinstance(shell := reduce(system), Shell) and len(shell.coordinates) > 1
}


@pytest.mark.parametrize("name", ORTHOGONAL)
def test_a_condition_passes_the_filter_exactly_where_its_written_terms_do(name):
    setting = obstruction.of_shell(ORTHOGONAL[name], Reader().field.budget)
    reader, q = setting.reader, setting.symbols
    conditions = levi_civita.LeviCivitaConditions(reader, q, setting.metric, setting.potential)
    sieve = Filter(reader.field)
    failing = set()
    for c in conditions:
        passes = c.passes_filter
        assert passes is sieve.vanishes(c.products)
        assert conditions.holds(c, sieve) is passes
        if not passes:
            failing.add((c.i, c.j))
    assert bool(failing) == (name in REFUSED)
    if name in REFUSED:
        a, b = sorted([c.name for c in ORTHOGONAL[name].coordinates].index(s) for s in REFUSED[name][1])
        assert any({a, b} <= set(block) for block in components(len(q), failing))


@pytest.mark.parametrize("name", ORTHOGONAL)
def test_one_factor_for_all_metric_coefficients(name):
    """S_ij(gʰʰ)/gʰʰ alike for every h: against the differences written out."""
    setting = obstruction.of_shell(ORTHOGONAL[name], Reader().field.budget)
    reader, n = setting.reader, len(setting.symbols)
    conditions = levi_civita.LeviCivitaConditions(reader, setting.symbols, setting.metric, setting.potential)
    sieve, minus = Filter(reader.field), [reader.field.coerce(-1)]
    for i, j in combinations(range(n), 2):
        first = conditions.of_metric(i, j, i)
        written = (
            sieve.vanishes([*conditions.of_metric(i, j, h), *([minus, *factors] for factors in first)])
            for h in range(n)
        )
        assert conditions.one_factor(i, j) is all(written)


@pytest.mark.parametrize("answer", [True, None])
def test_a_filter_that_lets_everything_pass_is_no_proof(answer, monkeypatch):
    setting = obstruction.of_shell(ORTHOGONAL[sorted(REFUSED.keys() & ORTHOGONAL)[0]], Reader().field.budget)
    conditions = levi_civita.LeviCivitaConditions(setting.reader, setting.symbols, setting.metric, setting.potential)
    sieve = Filter(setting.reader.field)
    written = [sieve.vanishes(c.products) for c in conditions]
    assert not all(written)
    monkeypatch.setattr(levi_civita.LeviCivitaConditions, "passes_filter", lambda *_: answer)
    assert [conditions.holds(c, sieve) for c in conditions] == written
