"""Derivatives at points: modulo primes against the exact ones of the field, in intervals against those of sympy."""

from __future__ import annotations

from itertools import combinations

import mpmath
import pytest
import sympy as sp

from hjsolve.algebra.element_jets import ElementJets, at_random_points
from hjsolve.algebra.intervals import NoEnclosureError
from hjsolve.algebra.modular import Filter, ModularPoint, NoRootError
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.energy_shell import Shell, reduce
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.obstruction import obstruction
from hjsolve.separation.obstruction.blocks import components
from hjsolve.separation.zero_test.interval_elements import IntervalPoint
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
            jet = ElementJets(reader, q, point).element(element)
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


@pytest.mark.parametrize("function", [g for g in FUNCTIONS if not g.has(f)], ids=str)
@pytest.mark.parametrize("precision", [64, 160])
def test_jets_in_intervals_hold_the_slopes_and_mixed_derivatives_and_are_narrow(function, precision):
    q, place = (x, y, z), {x: sp.Rational(3, 7), y: sp.Rational(-5, 4), z: sp.Rational(8, 3)}
    reader = Reader([function])
    jets = ElementJets(reader, q, IntervalPoint(reader.field, place, precision))
    jet = jets.element(reader.element(function))
    found = [(jet.value, function), *((jet.slopes[i], function.diff(q[i])) for i in range(3))]
    found += [(jet.mixed[i, j], function.diff(q[i], q[j])) for i, j in combinations(range(3), 2)]
    with mpmath.workprec(2 * precision):
        for enclosure, exact in found:
            value = mpmath.mpf(exact.xreplace(place).evalf(2 * precision))
            low, high = (mpmath.mpf(end) for end in jets.point.numbers.mpf(enclosure)._mpi_)
            assert low <= value <= high
            assert high - low <= mpmath.ldexp(1 + abs(value), 20 - precision)


def test_what_may_vanish_has_no_logarithm_in_intervals():
    reader = Reader([x, y])
    jets = ElementJets(reader, (x, y), IntervalPoint(reader.field, {x: sp.Rational(1, 3), y: sp.Rational(1, 3)}, 64))
    with pytest.raises(NoEnclosureError, match="contains zero"):
        jets.logarithm(jets.element(reader.element(x - y)))


def test_the_logarithm_of_a_jet_is_the_jet_of_the_logarithm():
    function = (x + y) ** 3 / (x * y + z) ** 2
    reader = Reader([function])
    element = reader.element(function)
    ((jets, (jet,)),) = at_random_points(reader, (x, y, z), [element], points=1)
    logarithm = jets.logarithm(jet)
    point = jets.point
    for i, q in enumerate((x, y, z)):
        slope = reader.log_diff(element, q)
        assert logarithm.slopes[i] == point.element(slope)
        for j in range(i + 1, 3):
            assert logarithm.mixed[i, j] == point.element(reader.diff(slope, (x, y, z)[j]))


def test_a_point_where_a_function_vanishes_or_has_no_root_is_passed_over():
    function = sp.sqrt(x**2 + y + 3)
    reader = Reader([function])
    found = at_random_points(reader, (x, y), [reader.element(function)], points=5)
    assert len({jets.point.prime for jets, _ in found}) == 5
    reader = Reader([x])
    jets = ElementJets(reader, (x,), ModularPoint(reader.field, 0))
    with pytest.raises(ZeroDivisionError, match="vanishes"):
        jets.logarithm(jets.element(reader.field.zero))


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
