"""H(q, ∂W/∂q) = E over the whole catalog, effects included, on the W that is printed."""

import pytest
import sympy as sp

from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.separation import Separation, separate
from hjsolve.separation.zero_test.zero_test import Zero, is_zero
from hjsolve.solution.laws import check, hamilton_jacobi_residual
from hjsolve.solution.quadratures import Solution, solve
from tests.support import entries
from tests.support.entries import solved

NAMES = entries.separable_with_effects()


@pytest.mark.entries
@pytest.mark.parametrize("name", NAMES)
def test_the_equation_holds_identically(name: str) -> None:
    assert isinstance(is_zero(hamilton_jacobi_residual(solved(name))), Zero)


@pytest.mark.entries
@pytest.mark.parametrize("name", NAMES)
def test_the_momenta_are_the_derivatives_of_w_as_printed(name: str) -> None:
    solution = solved(name)
    for c in solution.system.coordinates:
        difference = sp.diff(solution.characteristic_function, c.symbol) - solution.momenta[c.name]
        assert sp.simplify(difference) == 0


@pytest.mark.entries
@pytest.mark.nightly_cases("perfect-oblate-spheroid")
@pytest.mark.parametrize("name", NAMES)
def test_the_equation_holds_to_40_digits_with_the_roots_as_printed(name: str) -> None:
    """At a point of a real motion, 40 digits, H's own formula: no squaring away, no zero test of ours."""
    solution = solved(name)
    system = solution.system
    numbers = {p.symbol: p.value for p in system.parameters}
    q = {c.symbol: sp.Rational(i + 4, 5) + sp.Rational(1, 7) for i, c in enumerate(system.coordinates)}
    p = {c.momentum: sp.Rational(3 + i, 2) for i, c in enumerate(system.coordinates)}
    values = {c.symbol: c.expression.xreplace({**numbers, **q, **p}) for c in solution.constants.values()}
    momenta = {c.momentum: solution.momenta[c.name].xreplace({**numbers, **q, **values}) for c in system.coordinates}
    E = values[solution.separation.shell.energy]
    H = hamiltonian(system).xreplace({**numbers, **q}).xreplace(momenta)
    assert abs(sp.N(H - E, 40, maxn=300)) < sp.Float("1e-35") * (1 + abs(sp.N(E, 40)))


def test_a_wrong_potential_is_seen() -> None:
    """The check can fail: the solution of Kepler does not solve Kepler with an inverse-cube force."""
    kepler, other = solved("kepler-planar"), solved("kepler-planar+precession")
    forged = Solution(**{**vars(kepler), "system": other.system})
    outcomes = {c.name: c.verdict for c in check(forged)}
    assert outcomes["hamilton-jacobi"] == "failed"
    assert outcomes["involution"] == "failed"


def test_a_system_of_ignorable_coordinates_only() -> None:
    free = System(
        coordinates={"x": "line", "y": "line"},
        kinetic="m/2*(dot(x)**2 + dot(y)**2 + dot(x)*dot(y))",
        parameters={"m": 1},
    )
    verdict = separate(free)
    assert isinstance(verdict, Separation)
    solution = solve(verdict)
    p_x, p_y = (c.momentum for c in free.coordinates)
    assert solution.characteristic_function == p_x * free.coordinates[0].symbol + p_y * free.coordinates[1].symbol
    assert solution.time_law is None
    assert [c.verdict for c in check(solution)] == ["proved"] * 4
