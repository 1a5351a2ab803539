"""The refused entries: the obstruction, its witness, and words that help."""

import mpmath
import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.errors import NotSeparableError
from hjsolve.separation import Obstruction, separate
from hjsolve.solution.quadratures import solve
from tests.support import entries

IDS = catalog.ids("refused")


def obstruction(name: str) -> Obstruction:
    found = separate(catalog.load(name))
    assert isinstance(found, Obstruction), found
    return found


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_it_is_refused_for_the_reason_the_entry_names(name: str) -> None:
    entry, found = entries.described(name), obstruction(name)
    assert sorted(found.pair) == sorted(entry.expect["pair"])
    assert found.part == entry.expect["part"]


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_the_residual_lies_in_its_enclosure_at_the_witness(name: str) -> None:
    """The enclosure is checked with a plain evaluation at 60 digits, not with the interval arithmetic that made it."""
    found = obstruction(name)
    values = {symbol: found.witness.point[symbol.name] for symbol in found.residual.free_symbols}
    with mpmath.workdps(60):
        value = mpmath.mpf(sp.N(found.residual.xreplace(values), 60))
    assert found.witness.lower <= value <= found.witness.upper
    assert found.witness.lower > 0 or found.witness.upper < 0


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_it_says_why_and_what_to_do_instead(name: str) -> None:
    entry = entries.described(name)
    assert entry.kind == "refused"
    assert entry.reason.endswith(".")
    assert entry.instead.endswith(".")


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_solving_it_raises_with_the_verdict(name: str) -> None:
    with pytest.raises(NotSeparableError, match="does not separate") as caught:
        solve(catalog.load(name))
    assert isinstance(caught.value.verdict, Obstruction)


def test_the_refused_neighbour_separates_when_the_coupling_is_taken_away() -> None:
    """Anisotropic Kepler with gamma = 1 is Kepler: the same text, one parameter apart."""
    table = {
        "coordinates": [{"name": "r", "domain": "0 < r"}, {"name": "theta", "domain": "angle"}],
        "parameters": [{"name": "k", "value": "1", "assume": "positive"}],
        "kinetic": "1/2*(dot(r)**2 + r**2*dot(theta)**2)",
        "potential": "-k/(r*sqrt(cos(theta)**2 + sin(theta)**2))",
    }
    assert not isinstance(separate(catalog.from_table(table)), Obstruction)
