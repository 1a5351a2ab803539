"""Where the systems of the catalog are in space: their T is that of the point, or is known not to be."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import sympy as sp

import hjsolve
from hjsolve import catalog
from hjsolve.mechanics.system import mass_matrix

OF_MORE_THAN_THE_POINT = {
    "lagrange-top", "tube-turning-freely", "pendulum-on-block", "dumbbell-in-plane", "kerr",
    "schwarzschild", "slider-on-pivoted-bar", "brachistochrone",
}  # fmt: skip
FOLDER = Path(str(catalog.folder()))
PLACED = sorted(
    file.stem
    for kind in ("systems", "extended", "refused")
    for file in (FOLDER / kind).glob("*.toml")
    if "\nplace = " in file.read_text(encoding="utf-8").split("\n[", 1)[0]
)


def system_of(name: str) -> hjsolve.System:
    file = next(FOLDER.glob(f"*/{name}.toml"))
    return catalog.from_table(catalog.read(file)[0])


@pytest.mark.entries
@pytest.mark.parametrize("name", PLACED)
def test_the_mass_matrix_is_that_of_a_point_at_the_place(name: str) -> None:
    """M = m (∂x/∂q)ᵀ(∂x/∂q) at random points, to 30 digits, with m constant."""
    system = system_of(name)
    J = sp.Matrix(list(system.place.values())).jacobian([c.symbol for c in system.coordinates])
    dice, own = random.Random(name), mass_matrix(system)
    ratios = set()
    for _ in range(3):
        at = {c.symbol: sp.Rational(dice.randint(20, 90), 100) for c in system.coordinates} | system.defaults
        of_point, given = ((matrix.subs(at)).evalf(40) for matrix in (J.T * J, own))
        i = max(range(given.rows), key=lambda k: abs(of_point[k, k]))
        m = given[i, i] / of_point[i, i]
        ratios.add(sp.Float(m, 25))
        differ = max(abs(x) for x in given - m * of_point) > sp.Float("1e-30", 40)
        if name in OF_MORE_THAN_THE_POINT:
            assert differ
            return
        assert not differ
    assert max(ratios) - min(ratios) < sp.Float("1e-22", 30)


def test_three_dozen_entries_say_where_they_are() -> None:
    assert len(PLACED) >= 36


def test_a_place_survives_the_table_of_a_system() -> None:
    kepler = catalog.load("kepler-spherical")
    assert catalog.from_table(catalog.table_of(kepler)) == kepler
    assert kepler.place["z"] == kepler.symbols["r"] * sp.cos(kepler.symbols["theta"])
