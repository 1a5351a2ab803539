"""The constants of every system of the catalog are in involution, and E is the Hamiltonian: sympy at 50 digits."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.mechanics.system import hamiltonian
from hjsolve.separation import Separation, region_of
from tests.support import entries

TOLERANCE = sp.Float("1e-40", 50)


@pytest.mark.entries
@pytest.mark.parametrize("name", entries.separable())
def test_the_constants_of_the_catalog_are_in_involution_and_independent(name):
    """(α_i, α_j) = 0, and the rank of ∂α/∂p is the number of coordinates."""
    system, verdict = entries.loaded(name), entries.verdict(name)
    assert isinstance(verdict, Separation)
    constants = [c.expression for c in verdict.constants.values()]
    assert len(constants) >= len(system.coordinates)
    q = [c.symbol for c in system.coordinates]
    p = [c.momentum for c in system.coordinates]
    H = constants[0] if system.relativity is not None else hamiltonian(system)
    everything = sp.Add(*(sp.Dummy() * f for f in (*constants, H)))
    (point,) = [point for _, point in zip(range(1), region_of(system).points(everything, seed=11))]

    def at(f):
        return f.evalf(50, subs={s: v for s, v in point.items() if s in f.free_symbols})

    assert abs(at(constants[0] - H)) <= TOLERANCE * (1 + abs(at(H)))
    slopes = [[[at(f.diff(s)) for s in symbols] for symbols in (q, p)] for f in constants]
    for j, (fq, fp) in enumerate(slopes):
        for gq, gp in slopes[:j]:
            terms = [x * y for x, y in zip(fq, gp)] + [-x * y for x, y in zip(fp, gq)]
            assert abs(sum(terms)) <= TOLERANCE * (1 + max(map(abs, terms)))
    columns = sp.Matrix([fp for _, fp in slopes])
    assert columns.rank(iszerofunc=lambda x: abs(x) < TOLERANCE) == len(q)
