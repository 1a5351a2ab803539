"""Hamilton's equations and H as plain functions of numbers, for integrators: y = [q₁ … qₙ, p₁ … pₙ].

q̇ᵢ = ∂H/∂pᵢ,   ṗᵢ = −∂H/∂qᵢ    (Greenwood (4-16), (4-17))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    from hjsolve.mechanics.system import System

MODULES = ("numpy", "mpmath")


def right_hand_side(system: System, hamiltonian: sp.Expr, module: str) -> Callable[[Any, Any], Any]:
    """Return f(t, y), the rate of change of y.

    Args:
        system: its parameters have values.
        hamiltonian: its H(q, p), those values put in.
        module: one of ``MODULES``.
    """
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    rates = [sp.diff(hamiltonian, p) for p in momenta] + [-sp.diff(hamiltonian, q) for q in places]
    compute = _function([*places, *momenta], [rate.xreplace(_signs(system)) for rate in rates], module)

    def rate(t: Any, y: Any) -> Any:  # noqa: ARG001 - integrators give the time
        found = compute(*y)
        if not hasattr(y, "shape"):
            return list(found)
        result = 0.0 * y  # an array like y: a rate that is constant becomes a row of its own
        for index, value in enumerate(found):
            result[index] = value
        return result

    return rate


def energy(system: System, hamiltonian: sp.Expr, module: str) -> Callable[[Any], Any]:
    """Return H(y).

    Args:
        system, hamiltonian, module: as of ``right_hand_side``.
    """
    symbols = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    compute = _function(symbols, [hamiltonian.xreplace(_signs(system))], module)
    return lambda y: compute(*y)[0] + 0 * y[0]


def _signs(system: System) -> dict[sp.Symbol, sp.Expr]:
    """Return what the letters for signs stand for."""
    return {kink.symbol: kink.sign.xreplace(system.defaults) for kink in system.kinks}


def _function(symbols: Sequence[sp.Symbol], formulas: list[sp.Expr], module: str) -> Callable[..., Any]:
    if module not in MODULES:
        raise InvalidInputError(f'module: {module!r:.40} is not known; write "numpy" or "mpmath"')
    if any(formula.has(AppliedUndef) for formula in formulas):
        raise InvalidInputError("a function that is left undetermined has no values; write it out in T or V")
    function: Callable[..., Any] = sp.lambdify(symbols, formulas, modules=module, cse=True)
    return function


__all__ = ["energy", "right_hand_side"]
