"""Entries in other coordinates than the book's: the map between them, constraints and their integrals; all rows
there."""

import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.catalog import Entry
from hjsolve.errors import NotSeparableError
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.separation.zero_test.interval_evaluation import Region
from hjsolve.separation.zero_test.zero_test import Zero, free_region, is_zero
from tests.support.book import Mechanics, exact, formula, mechanics
from tests.support.book_table import REFUSED_ROWS, ROWS, entries_of
from tests.support.entries import described, table
from tests.support.pfaff import curvature, one_form

STATED = [n for n in catalog.ids() if table(n).get("stated", {}).get("kinetic") and "kinetic" in table(n)]
CONSTRAINED = [n for n in catalog.ids() if "constraint" in table(n)]
INTEGRATED = [n for n in CONSTRAINED if described(n).system is not None]
NONHOLONOMIC = [n for n in CONSTRAINED if (r := described(n).refusal) and r.kind == "nonholonomic"]


@pytest.mark.parametrize("name", STATED)
def test_the_books_lagrangian_becomes_ours_under_the_map(name: str) -> None:
    """L_stated(map) = L_entry + dF/dt, exactly."""
    stated, own = described(name).stated, mechanics(name)
    assert stated is not None
    book = Mechanics(stated.kinetic, stated.potential, stated.coordinates)
    places = {n: own.of(stated.map[n]) for n in stated.coordinates}
    values = {sp.Symbol(n): x for n, x in places.items()} | {
        sp.Symbol(f"{n}_d"): own.rate(x) for n, x in places.items()
    }
    difference = book.L.xreplace(values) - own.L
    if stated.gauge != "0":
        difference -= own.rate(own.of(stated.gauge))
    if name == "whirling-tube":  # phi is put in as w*t: nothing else is needed
        assert difference.free_symbols <= {sp.Symbol(n) for n in ("m", "r", "g", "w", "theta", "theta_d")}
    if not difference.free_symbols:
        assert difference == 0
        return
    system = described(name).system
    assert system is not None
    region = Region({**free_region(difference).bounds, **domain_bounds(system.coordinates)}, system.defaults)
    known = difference.xreplace({sp.Symbol(n): symbol for n, symbol in system.symbols.items()})
    assert isinstance(is_zero(known, region), Zero)  # exactly
    point = {x: sp.Rational(3 + 2 * i, 7 + i) for i, x in enumerate(sorted(difference.free_symbols, key=str))}
    assert abs(sp.N(difference.xreplace(point), 30, maxn=200)) < sp.Float("1e-25")  # and without hjsolve's own test


def forms(entry: Entry) -> list[list[sp.Expr]]:
    return [one_form(c.form, c.coordinates) for c in entry.constraints]


@pytest.mark.parametrize("name", INTEGRATED)
def test_an_integrable_constraint_is_the_rate_of_its_integral(name: str) -> None:
    """Greenwood (1-20), (1-23): the test of integrability holds, and d(integral)/dt is the constraint itself."""
    entry = described(name)
    assert all(x == 0 for x in curvature(forms(entry), entry.constraints[0].coordinates))
    for c in entry.constraints:
        frame = Mechanics("0", "0", c.coordinates)
        assert exact(frame.rate(frame.of(c.integral)) - frame.of(c.form)) == 0
        if entry.stated and set(c.coordinates) <= set(entry.stated.map):
            own = mechanics(name)
            put = {sp.Symbol(n): own.of(entry.stated.map[n]) for n in c.coordinates}
            assert exact(own.rate(formula(c.integral).xreplace(put))) == 0


@pytest.mark.parametrize("name", NONHOLONOMIC)
def test_a_nonholonomic_constraint_fails_the_test_of_integrability(name: str) -> None:
    entry = described(name)
    assert any(x != 0 for x in curvature(forms(entry), entry.constraints[0].coordinates))


@pytest.mark.parametrize("row", ROWS)
def test_every_row_of_the_book_has_an_entry(row: str) -> None:
    found = entries_of(row)
    assert found, row
    if row in REFUSED_ROWS:
        assert any(described(n).kind in ("refused", "outside") for n in found)


@pytest.mark.parametrize("name", catalog.ids("outside"))
def test_a_refusal_without_t_and_v_shows_what_stands_in_the_way(name: str) -> None:
    refusal = described(name).refusal
    assert refusal is not None
    assert refusal.formulas
    with pytest.raises(NotSeparableError) as caught:
        catalog.load(name)
    for text in (refusal.kind, *refusal.formulas, refusal.reason, refusal.instead):
        assert text in str(caught.value)
