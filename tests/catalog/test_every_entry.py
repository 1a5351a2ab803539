"""Every separable entry of the catalog: its verdict, the book's functions, its citations."""

import re
from collections.abc import Iterator

import mpmath
import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.formulas.read import parse
from hjsolve.mechanics.system import hamiltonian
from hjsolve.separation import Separation
from hjsolve.separation.verdicts import Liouville, Stackel
from tests.support import entries
from tests.support.entries import described as entry

IDS = catalog.ids("separable")
EFFECTS = [(name, effect) for name in catalog.ids() for effect, what in entry(name).effects.items() if not what.force]


def verdict(name: str) -> Separation:
    found = entries.verdict(name)
    assert isinstance(found, Separation), found
    return found


def formula(name: str, text: str) -> sp.Expr:
    system = entry(name).system
    momenta = {c.momentum.name: c.momentum for c in system.coordinates}
    return parse(text, {**system.symbols, **momenta}, source="expect")


def points(name: str, count: int = 3) -> Iterator[dict[sp.Symbol, sp.Rational]]:
    """Generic rational points of the domain; parameters stay the same from one point to the next."""
    system = entry(name).system
    fixed = {p.symbol: sp.Rational(7 + 3 * i, 5 + i) for i, p in enumerate(system.parameters)}
    ignorable = [c for c in system.coordinates if c.name in verdict(name).ignorable]
    fixed |= {c.momentum: sp.Rational(3 + i, 4) for i, c in enumerate(ignorable)}
    for n in range(count):
        moving = {c.symbol: sp.Rational(5 + 4 * n + 3 * i, 11 + i) for i, c in enumerate(system.coordinates)}
        moving |= {c.momentum: sp.Rational(2 + n + i, 3 + i) for i, c in enumerate(system.coordinates)}
        yield moving | fixed


def assert_vanishes(name: str, expression: sp.Expr) -> None:
    """Zero at generic points to 40 digits; a check that does not use hjsolve's own zero test."""
    for point in points(name):
        value = sp.N(expression.xreplace(point), 50, maxn=400)
        assert value.is_number
        assert abs(value) < mpmath.mpf(10) ** -40, (expression, value)


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_the_verdict_is_the_expected_one(name: str) -> None:
    expected, found = entry(name).expect["verdict"], verdict(name)
    forms = {"liouville": (True, True), "staeckel": (False, True), "reduced": (False, False)}[expected]
    assert (found.liouville is not None, found.stackel is not None) == forms
    assert (found.reduced.stackel is not None) == bool(found.shell.coordinates)


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_the_ignorable_coordinates_are_the_expected_ones(name: str) -> None:
    assert list(verdict(name).ignorable) == entry(name).expect["ignorable"]


def forms(name: str) -> Iterator[tuple[str, Liouville | Stackel | None, dict, bool]]:
    expect, found = entry(name).expect, verdict(name)
    for key, full, reduced in (
        ("liouville", found.liouville, found.reduced.liouville),
        ("staeckel", found.stackel, found.reduced.stackel),
    ):
        if key in expect:
            yield key, full, expect[key], True
        if key in expect.get("reduced", {}):
            yield key, reduced, expect["reduced"][key], False


def quadratic_form(name: str, coordinates: tuple[str, ...], full: bool) -> tuple[list[sp.Expr], sp.Expr]:
    """(coefficients of p²/2, potential) of H, or of H with the ignorable momenta counted as constants."""
    system = entry(name).system
    H = sp.expand(hamiltonian(system))
    momenta = [system.coordinate(c).momentum for c in coordinates]
    metric = [sp.diff(H, p, 2) for p in momenta]
    return metric, H.xreplace({p: sp.Integer(0) for p in momenta})


def assert_own_coordinate_only(name: str, coordinate: str, expression: sp.Expr) -> None:
    system = entry(name).system
    others = {c.symbol for c in system.coordinates if c.name != coordinate}
    assert not expression.free_symbols & others, (coordinate, expression)


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_the_books_liouville_functions_and_ours_both_reproduce_h(name: str) -> None:
    for key, found, book, full in forms(name):
        if key != "liouville":
            continue
        assert isinstance(found, Liouville)
        coordinates = tuple(book["f"])
        texts = [{c: formula(name, book[part][c]) for c in coordinates} for part in ("f", "R", "v")]
        ours = [dict(zip(found.coordinates, part, strict=True)) for part in (found.f, found.R, found.v)]
        metric, potential = quadratic_form(name, coordinates, full)
        for f, R, v in (texts, ours):
            total = sp.Add(*f.values())
            for c, g in zip(coordinates, metric, strict=True):
                assert_vanishes(name, g - R[c] / total)
                for function in (f[c], R[c], v[c]):
                    assert_own_coordinate_only(name, c, function)
            assert_vanishes(name, potential - sp.Add(*v.values()) / total)


@pytest.mark.entries
@pytest.mark.nightly_cases("kerr")
@pytest.mark.parametrize("name", IDS)
def test_the_books_staeckel_matrix_is_ours_up_to_the_allowed_operations(name: str) -> None:
    """Φ′ = ΦK and ψ′ = ψ + Φk with K, k constant, K's first row (1, 0, …) and k₁ = 0 (Greenwood P5-9, P5-10)."""
    for key, found, book, full in forms(name):
        if key != "staeckel":
            continue
        assert isinstance(found, Stackel)
        Φ, ψ = (
            sp.Matrix([[formula(name, x) for x in row] for row in book["matrix"]]),
            sp.Matrix([formula(name, x) for x in book["column"]]),
        )
        changes = [
            (
                Φ.xreplace(at).inv() * found.matrix.xreplace(at),
                Φ.xreplace(at).inv() * (sp.Matrix(found.column) - ψ).xreplace(at),
            )
            for at in points(name)
        ]
        first = changes[0]
        assert abs(first[0].det().evalf(30)) > 1e-6
        for K, k in changes:
            for place in range(len(ψ)):
                assert abs((K[0, place] - (1 if place == 0 else 0)).evalf(50)) < 1e-40
            assert abs(k[0].evalf(50)) < 1e-40
            assert max(abs(x.evalf(50)) for x in [*(K - first[0]), *(k - first[1])]) < 1e-40
        metric, potential = quadratic_form(name, found.coordinates, full)
        for matrix, column in ((Φ, ψ), (found.matrix, sp.Matrix(found.column))):
            for j in range(len(ψ)):
                product = sp.Add(*(g * matrix[i, j] for i, g in enumerate(metric))) - (1 if j == 0 else 0)
                assert_vanishes(name, product)
            assert_vanishes(name, sp.Add(*(g * column[i] for i, g in enumerate(metric))) - potential)
            for i, c in enumerate(found.coordinates):
                for x in (*matrix.row(i), column[i]):
                    assert_own_coordinate_only(name, c, x)


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_the_separation_constants_enter_linearly_and_not_the_column(name: str) -> None:
    """Greenwood's formula (5-153) with nonlinear constants leaves α in ψ; ours must not (book item 71)."""
    found = verdict(name)
    constants = {c.symbol for c in found.constants.values()} - {c.momentum for c in found.shell.ignorable}
    if not found.shell.coordinates:
        return
    assert found.reduced.stackel is not None
    for x in (*found.reduced.stackel.matrix, *found.reduced.stackel.column):
        assert not x.free_symbols & constants


@pytest.mark.entries
@pytest.mark.parametrize(("name", "effect"), EFFECTS, ids=[f"{n}+{e}" for n, e in EFFECTS])
def test_an_effect_does_to_separability_what_its_entry_says(name: str, effect: str) -> None:
    found = entries.verdict(name, (effect,))
    expected = entry(name).effects[effect].verdict
    if isinstance(found, Separation):
        form = "liouville" if found.liouville else "staeckel" if found.stackel else "reduced"
    else:
        form = "refused"
    assert form == expected


@pytest.mark.parametrize("name", catalog.ids())
def test_the_literature_cited_is_in_the_bibliography(name: str) -> None:
    bibliography = (catalog.folder() / "references.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),$", bibliography, re.MULTILINE)
    assert len(keys) == len(set(keys))
    cited = [*entry(name).cite, *(c for e in entry(name).effects.values() for c in e.cite)]
    cited += [c for reference in entry(name).references for c in reference.cite]
    assert entry(name).cite
    assert {text.split()[0] for text in cited} <= set(keys)


@pytest.mark.parametrize("name", catalog.ids())
def test_an_entry_tells_a_student_what_it_is(name: str) -> None:
    assert entry(name).summary.endswith(".")
    assert len(entry(name).summary) > 60
    system = entry(name).system
    assert system is None or all(p.meaning for p in system.parameters)


@pytest.mark.parametrize("name", IDS)
def test_every_reference_value_has_thirty_digits_or_is_exact(name: str) -> None:
    assert entry(name).references
    for reference in entry(name).references:
        digits = re.sub(r"e.*|[-.]", "", reference.value).lstrip("0")
        assert len(digits) >= 30 or len(digits) <= 12, reference  # 40 digits were written, zeros at the end left out


@pytest.mark.parametrize("name", IDS)
def test_every_motion_says_how_each_coordinate_moves(name: str) -> None:
    for data in entry(name).motions.values():
        assert set(data.kinds) == {c.name for c in entry(name).system.coordinates}
