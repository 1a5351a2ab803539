"""Does a solution solve? The Hamilton–Jacobi equation and Jacobi's theorem, tested exactly on what was printed.

No integral is evaluated: W enters only through its derivatives, so every law below is an identity between elementary
functions, decided by the zero test of ``hjsolve.separation``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import sympy as sp

from hjsolve.display.shown import Shown
from hjsolve.mechanics.brackets import bracket, conjugate_pairs
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.kinetic_energy import degree, velocity_coefficients
from hjsolve.mechanics.system import hamiltonian
from hjsolve.separation.zero_test.on_domain import vanishes
from hjsolve.separation.zero_test.zero_test import NonZero, Unproved, Zero
from hjsolve.solution.quadratures import Solution

NUMERIC_ZERO = sp.Float("1e-35")
Outcome = Literal["proved", "numeric", "undecided", "failed"]
_ORDER: tuple[Outcome, ...] = ("proved", "numeric", "undecided", "failed")


@dataclass(frozen=True, repr=False)
class Check(Shown):
    """One law and whether it holds.

    Attributes:
        name: short and stable, e.g. ``hamilton-jacobi``.
        statement: the law in words and symbols.
        verdict: ``proved`` (exact), ``numeric`` (not proved; zero to 40 digits at a point of the domain), ``undecided``
            (neither was reached), ``failed`` (proved not to hold, or not zero at 40 digits).
        residual: zero when proved, else the expression that should have vanished.
    """

    name: str
    statement: str
    verdict: Outcome
    residual: sp.Expr


def check(solution: Solution, *, budget: float = 20.0) -> tuple[Check, ...]:
    """Test a solution against the laws it must obey.

    The canonical property needs no integral: with −β_k = ∂W/∂α_k taken along α = κ(q, p) and the κ in involution,
    (α_j, β_k) = Σᵢ ∂κ_j/∂pᵢ ∂²W/∂qᵢ∂α_k, and (β_j, β_k) = 0 then follows from the symmetry of ∂²W/∂α_j∂α_k
    (Greenwood (6-76)–(6-79), (6-215)).

    Args:
        solution: what ``solve`` gave.
        budget: seconds for each zero test.

    Returns:
        The Hamilton–Jacobi equation, the momenta, the involution of the constants, the canonical property.
    """
    laws = (
        ("hamilton-jacobi", "H(q, dW/dq) = E identically in q and the constants (5-69)",
         [hamilton_jacobi_residual(solution)]),
        ("momenta", "p = dW/dq gives back every momentum when the constants are functions of (q, p) (5-72)",
         _momentum_residuals(solution)),
        ("involution", "the constants are integrals, (alpha, H) = 0, and in involution, (alpha_i, alpha_j) = 0 (6-236)",
         _bracket_residuals(solution)),
        ("canonical", "(alpha_j, beta_k) = delta_jk, so (q, p) -> (alpha, beta) is canonical (6-215)",
         _canonical_residuals(solution)),
    )  # fmt: skip
    return tuple(_decide(solution, name, statement, residuals, budget) for name, statement, residuals in laws)


def hamilton_jacobi_residual(solution: Solution) -> sp.Expr:
    """H(q, ∂W/∂q) − E, with every root squared away where it occurs squared; zero for a solution.

    H is Legendre's transform of the system's own T and V (4-109)–(4-112), not of the shell. Of a relativistic particle
    H − V = c √(…) is a root itself, positive like E − V: there it is (H − V)² − (E − V)², (7-165), (7-170).

    Args:
        solution: with W(q) and E.
    """
    system, shell = solution.system, solution.separation.shell
    roots = {name: sp.Dummy(f"P_{name}") for name in solution.momentum_squared}
    momenta = {system.coordinate(n).momentum: solution.momenta[n] for n in solution.coordinates}
    momenta |= {system.coordinate(n).momentum: root - solution.shift[n] for n, root in roots.items()}
    energy = shell.energy if solution.coordinates else shell.potential
    H = hamiltonian(system)
    if system.relativity is not None:
        square, other = sp.expand_mul((H - system.potential) ** 2), (energy - system.potential) ** 2
        return _squared_away(sp.expand_mul(square.xreplace(momenta)), roots, solution) - other
    return _squared_away(sp.expand_mul(H.xreplace(momenta)), roots, solution) - energy


def _squared_away(H: sp.Expr, roots: dict[str, sp.Dummy], solution: Solution) -> sp.Expr:
    """Replace Pᵢ² by its expression; what is odd in a root stays and must cancel by itself."""
    if not roots:
        return H
    total = sp.S.Zero
    for powers, coefficient in _coefficients(H, list(roots.values())):
        for (name, root), power in zip(roots.items(), powers, strict=True):
            coefficient *= solution.momentum_squared[name] ** (power // 2) * root ** (power % 2)
        total += coefficient
    return total


def _coefficients(H: sp.Expr, roots: list[sp.Dummy]) -> list[tuple[tuple[int, ...], sp.Expr]]:
    """H as a polynomial in some symbols: powers and coefficients; a quadratic one is read off, not expanded."""
    if degree(H, frozenset(roots)) <= 2:
        found = velocity_coefficients(H, roots)
        return [(tuple(key.count(k) for k in range(len(roots))), c) for key, c in found.items()]
    return list(sp.Poly(sp.expand_mul(H), *roots).terms())


def _on_motion(solution: Solution) -> dict[sp.Symbol, sp.Expr]:
    """E and the separation constants as functions of (q, p)."""
    own = {c.momentum for c in solution.separation.shell.ignorable}
    return {c.symbol: c.expression for c in solution.constants.values() if c.symbol not in own}


def _momentum_residuals(solution: Solution) -> Iterator[sp.Expr]:
    values = _on_motion(solution)
    for name in solution.coordinates:
        P = solution.system.coordinate(name).momentum + solution.shift[name]
        if name not in solution.momentum_squared:
            yield solution.momenta[name].xreplace(values) - P
            continue
        yield solution.momentum_squared[name].xreplace(values) - P**2


def _bracket_residuals(solution: Solution) -> Iterator[sp.Expr]:
    H, pairs = hamiltonian(solution.system), conjugate_pairs(solution.system.coordinates)
    energy = solution.separation.shell.energy
    expressions = {c.symbol: c.expression for c in solution.constants.values()}
    if energy in expressions:
        yield expressions.pop(energy) - H
    yield from (bracket(u, H, pairs) for u in expressions.values())
    yield from (bracket(u, v, pairs) for u, v in combinations(expressions.values(), 2))


def _canonical_residuals(solution: Solution) -> Iterator[sp.Expr]:
    """K·M − 1 with K_ji = ∂κ_j/∂pᵢ and M_ik = ∂/∂qᵢ of the right side of Jacobi's k-th equation."""
    values = _on_motion(solution)
    equations = {name: equation.rhs for name, equation in solution.orbit_equations.items()}
    if solution.time_law is not None:
        equations = {solution.separation.shell.energy.name: solution.time_law.rhs, **equations}
    names = list(equations)
    coordinates = [c.name for c in solution.system.coordinates]
    slopes = {k: [_slope(solution, equations[k], c).xreplace(values) for c in coordinates] for k in names}
    for j in names:
        κ = solution.constants[j].expression
        gradient = [κ.diff(c.momentum) for c in solution.system.coordinates]
        for k in names:
            yield sp.Add(*(a * b for a, b in zip(gradient, slopes[k], strict=True))) - (1 if j == k else 0)


def _slope(solution: Solution, right: sp.Expr, name: str) -> sp.Expr:
    """∂/∂q of the right side of a Jacobi equation, its root Pᵢ written pᵢ + Aᵢ."""
    coordinate = solution.system.coordinate(name)
    integrals = [term for term in sp.Add.make_args(right) if isinstance(term, sp.Integral)]
    slope = sp.diff(sp.Add(right, *(-term for term in integrals)), coordinate.symbol)
    if name in solution.coordinates:
        root, P = solution.momenta[name] + solution.shift[name], coordinate.momentum + solution.shift[name]
        mine = [term.function for term in integrals if term.variables == [coordinate.symbol]]
        slope += sp.Add(*(integrand * root for integrand in mine)) / P
    return slope


def _decide(solution: Solution, name: str, statement: str, residuals: Iterable[sp.Expr], budget: float) -> Check:
    verdict, worst = _ORDER[0], sp.S.Zero
    for residual in residuals:
        outcome = _outcome(solution, residual, budget)
        if _ORDER.index(outcome) > _ORDER.index(verdict):
            verdict, worst = outcome, residual
    return Check(name, statement, verdict, worst)


def _outcome(solution: Solution, residual: sp.Expr, budget: float) -> Outcome:
    if residual == 0:
        return "proved"
    system = solution.system
    parameters = [p.symbol for p in system.parameters]
    match vanishes(residual, domain_bounds(system.coordinates), parameters, system.defaults, budget):
        case Zero():
            return "proved"
        case NonZero():
            return "failed"
        case Unproved(value=None):
            return "undecided"
        case Unproved(value=value):
            return "numeric" if abs(sp.Float(value)) < NUMERIC_ZERO else "failed"
