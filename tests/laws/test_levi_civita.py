"""Levi-Civita's conditions: verdicts on known systems, and every term against the formula written out by sympy."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

from hjsolve.algebra.element_jets import ElementJets
from hjsolve.algebra.intervals import enclose
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.system import System
from hjsolve.separation import Obstruction, Separation, region_of, separate
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.obstruction import obstruction
from hjsolve.separation.zero_test.interval_elements import IntervalPoint
from tests.support.random_staeckel import case
from tests.support.separation_cases import REFUSED, SEPARABLE, decided

pytestmark = pytest.mark.rotating_file(15)

x, y, z = sp.symbols("x y z", positive=True)
px, py, pz = sp.symbols("p_x p_y p_z", real=True)
POINT = {x: sp.Rational(3, 7), y: sp.Rational(5, 4), z: sp.Rational(2, 3)}
MOMENTA = {px: sp.Rational(7, 5), py: sp.Rational(-3, 8), pz: sp.Rational(11, 6)}


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_a_separable_system_is_recognised(name):
    assert isinstance(decided(name), Separation)


@pytest.mark.parametrize("name", list(REFUSED))
def test_a_system_that_does_not_separate_is_refused_with_the_right_pair_and_part(name):
    system, pair, part = REFUSED[name]
    verdict = decided(name)
    assert isinstance(verdict, Obstruction)
    assert (verdict.pair, verdict.part) == (pair, part)


@pytest.mark.parametrize("name", list(REFUSED))
def test_the_witness_lies_in_the_domain_and_excludes_zero(name):
    system, _, _ = REFUSED[name]
    verdict = decided(name)
    witness, names = verdict.witness, {sp.sstr(s): s for s in verdict.residual.free_symbols}
    assert witness.lower > 0 or witness.upper < 0
    point = {names[n]: v for n, v in witness.point.items() if n in names}
    value = verdict.residual.subs(point).evalf(40)
    assert witness.lower - abs(value) / 10**12 <= value <= witness.upper + abs(value) / 10**12
    values = {q.symbol: witness.point[q.name] for q in system.parameters if q.name in witness.point}
    assert all(value > 0 for value in values.values())
    for symbol, (lower, upper) in region_of(system).bounds.items():
        if symbol.name in witness.point:
            here = witness.point[symbol.name]
            assert lower is None or lower.subs(values) < here
            assert upper is None or here < upper.subs(values)


@pytest.mark.parametrize("name", list(REFUSED))
def test_a_refusal_advises_and_never_says_not_integrable(name):
    advice = decided(name).advice
    assert "integrable without separating" in advice.replace("\n", " ")
    assert "not integrable" not in advice
    assert "nonintegrable" not in advice


def test_small_oscillations_are_sent_to_normal_modes():
    for name in ("coupled small oscillations, C23b", "three particles on an elastic rod, C45"):
        assert "normal modes" in decided(name).advice


def eisenhart(metric, f, i, j, q):
    """S_ij(f) of Benenti and Eisenhart, written out by sympy."""
    return (
        f.diff(q[i], q[j]) - sp.log(metric[j]).diff(q[i]) * f.diff(q[j]) - sp.log(metric[i]).diff(q[j]) * f.diff(q[i])
    )


METRICS = [
    (x * y + z, x**2 + y * z, 1 / (x + y + z)),
    (sp.exp(x * z) / y, sp.sin(x) + y**2 * z, z * x**2 * y**3 + x + y),
    (sp.sqrt(x**2 + y**2 + z), 1 / (x * y * z + 1), sp.cosh(x * z) - sp.cos(y + z)),
]


@pytest.mark.parametrize("metric", METRICS)
def test_every_condition_is_the_formula_of_eisenhart_on_metrics_where_no_term_vanishes(metric):
    q, V = (x, y, z), x**2 * sp.sin(y) + sp.log(z + x) / y
    reader = Reader([*metric, V])
    elements = [reader.element(g) for g in metric]
    for c in levi_civita.LeviCivitaConditions(reader, q, elements, reader.element(V)):
        ours = reader.write(levi_civita.sum_of_products(reader, c.products) * c.scale)
        theirs = eisenhart(metric, V if c.about is None else metric[c.about], c.i, c.j, q)
        difference, size = ((ours - theirs).subs(POINT).evalf(50), theirs.subs(POINT).evalf(50))
        assert abs(size) > 1e-3, "a term that vanishes would hide a mutant"
        assert abs(difference) < 1e-45


def test_all_pairs_and_all_metric_coefficients_are_asked():
    reader = Reader(METRICS[0])
    conditions = list(
        levi_civita.LeviCivitaConditions(reader, (x, y, z), [reader.element(g) for g in METRICS[0]], reader.element(x))
    )
    assert [(c.i, c.j, c.part, c.about) for c in conditions] == [
        *((i, j, "metric", h) for i, j in ((0, 1), (0, 2), (1, 2)) for h in range(3)),
        *((i, j, "potential", None) for i, j in ((0, 1), (0, 2), (1, 2))),
    ]


def test_the_general_condition_is_levi_civitas_formula_for_a_hamiltonian_with_every_kind_of_term():
    H = x * y * px**2 + sp.sin(x + z) * px * py + y**2 * py**2 + x * y**2 * px + z * py * pz + pz**2 * x + sp.exp(x) * y
    q, p = (x, y, z), (px, py, pz)
    reader = Reader([H])
    element = reader.element(H)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        ours = reader.write(
            levi_civita.sum_of_products(reader, levi_civita.general_condition(reader, element, q, p, i, j))
        )
        a, b, c, d = H.diff(p[i]), H.diff(p[j]), H.diff(q[i]), H.diff(q[j])
        theirs = (
            a * b * H.diff(q[i], q[j])
            + c * d * H.diff(p[i], p[j])
            - a * d * H.diff(q[i], p[j])
            - c * b * H.diff(q[j], p[i])
        )
        values = [e.subs(POINT).subs(MOMENTA).evalf(50) for e in (ours - theirs, theirs)]
        assert abs(values[1]) > 1e-3
        assert abs(values[0]) < 1e-44
        jets = ElementJets(reader, [q[i], q[j], p[i], p[j]], IntervalPoint(reader.field, {**POINT, **MOMENTA}, 64))
        enclosure = levi_civita.general_condition_of_jets(jets.element(element))
        with mpmath.workdps(40):
            low, high = (mpmath.mpf(end) for end in enclosure._mpi_)
            assert low <= mpmath.mpf(values[1]) <= high
            assert high - low < 1e-15 * abs(low)


def test_coefficients_in_the_constants_add_up_to_the_whole():
    reader = Reader([x])
    whole = reader.element((px**2 * x + 3 * px * py * y - y**2) / (x + y))
    parts = levi_civita.coefficients(reader, whole, [px, py])
    assert {reader.write(part) for part in parts} == {x / (x + y), 3 * y / (x + y), -(y**2) / (x + y)}


def test_the_enclosure_of_a_residual_is_narrow():
    verdict = decided("Miyamoto–Nagai")
    names = {sp.sstr(s): s for s in verdict.residual.free_symbols}
    point = {names[n]: v for n, v in verdict.witness.point.items() if n in names}
    lower, upper = enclose(verdict.residual, point, 160)
    assert 0 <= (upper - lower) / abs(upper) < 1e-40


@pytest.mark.parametrize("name", list(REFUSED))
def test_a_residual_too_large_to_expand_is_written_out_and_still_has_a_witness(name, monkeypatch):
    monkeypatch.setattr(obstruction, "EXPANSION_TERMS", 0)
    system, pair, part = REFUSED[name]
    verdict = decided(name)
    assert isinstance(verdict, Obstruction)
    assert (verdict.pair, verdict.part) == (pair, part)
    assert verdict.witness.excludes_zero


@pytest.mark.parametrize(
    ("potential", "functions"),
    [
        ("acosh(2 + x**2 + x*y + y**2)", []),
        ("cos(x**2*y)/(2 + sin(x*y))**3", []),
        ("x*f(x, y) + 1/(2 + f(x, y)**2)", ["f(x, y)"]),
    ],
)
def test_a_condition_is_enclosed_by_jets(potential, functions, monkeypatch):
    """S_ij(V) = ∂ᵢ∂ⱼV where T is Euclidean: against the derivative that sympy writes down."""
    monkeypatch.setattr(obstruction, "EXPANSION_TERMS", 0)
    coordinates = {"x": "line", "y": "line"}
    system = System(coordinates, "(dot(x)**2 + dot(y)**2)/2", potential, functions=functions)
    witness = separate(system).witness
    mixed = system.potential.diff(system.symbols["x"], system.symbols["y"]).doit()
    names = {sp.sstr(part): part for part in sp.preorder_traversal(mixed)}
    value = mixed.xreplace({names[name]: v for name, v in witness.point.items() if name in names}).evalf(30)
    assert witness.excludes_zero
    with mpmath.workdps(30):
        assert witness.lower <= mpmath.mpf(value) <= witness.upper


@pytest.mark.nightly_cases("False-3")
@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("separable", [True, False])
def test_random_staeckel_systems_separate_and_their_neighbours_at_1e_9_do_not(n, separable):
    cases = filter(None, (case(1000 * n + seed, n, separable=separable) for seed in range(8 - 2 * n)))
    for known in cases:
        assert isinstance(separate(known.system), Separation if separable else Obstruction), known.seed
