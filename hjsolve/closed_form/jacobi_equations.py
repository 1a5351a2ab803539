"""Jacobi's equations t − t₀ = …, −β = …: over which coordinates they integrate, what else they hold, free names."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.solution.quadratures import Solution


def without_integrals(side: sp.Expr) -> sp.Expr:
    """Return what a side of an equation holds next to its integrals.

    Args:
        side: of an equation.
    """
    return side.replace(lambda e: isinstance(e, sp.Integral), lambda _: sp.S.Zero)


def integrated_over(solution: Solution, pieces: Mapping[str, CoordinateIntegrals], key: sp.Symbol) -> list[str]:
    """Return the coordinates over which the equation of a constant integrates, those without a curve among them.

    Args:
        solution: whose equations.
        pieces: separated coordinate → its integrals.
        key: the constant.
    """
    return [n for n in solution.coordinates if n not in pieces or key in pieces[n].numerators]


def time_of(solution: Solution) -> tuple[sp.Symbol, ...]:
    """Return the time; none where no coordinate is separated.

    Args:
        solution: whose time law holds it.
    """
    law = solution.time_law
    return () if law is None else tuple(term for term in law.lhs.args if term.is_Symbol)


def common_parameter(solution: Solution) -> sp.Symbol:
    """Return τ of the parametric forms, by a name that the solution does not use."""
    return _free(solution, "tau", "lambda_", "tau_1")


def anomaly_of(solution: Solution) -> sp.Symbol:
    """Return ξ, by a name that the solution does not use."""
    return _free(solution, "xi", "chi", "xi_1")


def _free(solution: Solution, *names: str) -> sp.Symbol:
    taken = {s.name for s in (*solution.characteristic_function.free_symbols, *time_of(solution))}
    return sp.Symbol(next(n for n in names if n not in taken), real=True)
