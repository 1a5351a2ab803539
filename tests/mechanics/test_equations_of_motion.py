"""Hamilton's equations and the Routhian against the Lagrangian, and against the book."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import momenta, velocities

NAMES = ["kepler-planar", "kepler-spherical", "lagrange-top", "double-pendulum", "projectile", "spherical-pendulum"]


@pytest.mark.parametrize("name", NAMES)
def test_the_routhian_is_the_lagrangian_less_the_ignorable_momenta(name: str) -> None:
    """R = L − Σ β q̇ (2-122) with β = ∂T/∂q̇: put the momenta back, and the definition must stand there."""
    system = hjsolve.catalog.load(name)
    held = system.kinetic.free_symbols | system.potential.free_symbols
    gone = [c for c in system.coordinates if c.symbol not in held]
    slopes = {c.momentum: momenta(system)[c.name] for c in gone}
    lagrangian = system.kinetic - system.potential
    difference = (
        system.routhian.xreplace(slopes) - lagrangian + sp.Add(*(slopes[c.momentum] * c.velocity for c in gone))
    )
    assert not system.routhian.free_symbols & {c.velocity for c in gone}
    assert sp.simplify(difference) == 0


def test_the_routhian_of_kepler_is_the_books() -> None:
    """(2-133) with a mass: R = ½ m ṙ² − β²/(2 m r²) + k/r."""
    system = hjsolve.catalog.load("kepler-planar")
    r, theta = system.coordinates
    m, k = (system.symbols[name] for name in "mk")
    book = m * r.velocity**2 / 2 - theta.momentum**2 / (2 * m * r.symbol**2) + k / r.symbol
    assert sp.expand(system.routhian - book) == 0


@pytest.mark.parametrize("name", NAMES)
def test_hamiltons_equations_are_lagranges(name: str) -> None:
    """q̇ is the inverse of p = ∂T/∂q̇, and −∂H/∂q at fixed p is ∂L/∂q at fixed q̇ (4-14)."""
    system = hjsolve.catalog.load(name)
    equations = system.canonical_equations
    assert list(equations) == [c.name for c in system.coordinates] + [f"p_{c.name}" for c in system.coordinates]
    rates = {c.velocity: velocities(system)[c.name] for c in system.coordinates}
    point = {
        s: sp.Rational(2 * i + 5, 7 + i)
        for i, s in enumerate(
            sorted(
                {s for e in equations.values() for s in e.rhs.free_symbols} | {c.symbol for c in system.coordinates},
                key=str,
            )
        )
    }
    for c in system.coordinates:
        assert equations[c.name].lhs == c.velocity
        expected = sp.diff(system.kinetic - system.potential, c.symbol).xreplace(rates)
        found = equations[c.momentum.name].rhs
        assert sp.N((found - expected).xreplace(point), 40, chop=True) == pytest.approx(0, abs=1e-30)
        assert sp.N((equations[c.name].rhs - rates[c.velocity]).xreplace(point), 40) == pytest.approx(0, abs=1e-30)


def test_a_relativistic_particle_has_no_routhian_here() -> None:
    system = hjsolve.catalog.load("relativistic-kepler")
    with pytest.raises(hjsolve.InvalidSystemError, match="not T - V"):
        _ = system.routhian


@pytest.mark.parametrize("name", ["kepler-planar", "kepler-spherical", "lagrange-top", "projectile", "harmonic-oscillator",
                                  "relativistic-kepler", "kepler-parabolic"])  # fmt: skip
def test_the_determinant_of_a_solution_is_that_of_w(name: str) -> None:
    """|∂²W/∂q∂α| straight from W, over all coordinates, against the product of blocks (5-154)."""
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    W = solution.characteristic_function
    order = [*solution.coordinates, *(c.name for c in solution.separation.shell.ignorable)]
    rows = [solution.system.coordinate(n).symbol for n in order]
    constants = [c.symbol for c in solution.constants.values()]
    whole = sp.Matrix([[sp.diff(W, q, a) for a in constants] for q in rows]).det(method="berkowitz")
    value = (whole - solution.determinant) / solution.determinant
    symbols = sorted(value.free_symbols, key=str)
    point = {s: sp.Rational(30 + i, 31) for i, s in enumerate(symbols)} | {
        s: sp.Integer(40) for s in symbols if s.name in ("E", "alpha_2")
    }
    assert abs(sp.N(value.doit(integrals=False).xreplace(point), 30)) < 1e-25
