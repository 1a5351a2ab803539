"""Hamilton's equations and H as plain functions of numbers, for integrators: y = [q₁ … qₙ, p₁ … pₙ].

q̇ᵢ = ∂H/∂pᵢ,   ṗᵢ = −∂H/∂qᵢ    (Greenwood (4-16), (4-17))
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.arguments import described
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

MODULES = ("numpy", "mpmath")
Y = TypeVar("Y")
"""A state or states, [q…, p…], an array or a list; and their rate of change."""
Signs = Mapping[sp.Symbol, sp.Expr]
"""Letters for signs, and what they stand for."""


def right_hand_side(
    coordinates: Sequence[Coordinate], hamiltonian: sp.Expr, signs: Signs, module: str
) -> Callable[[object, Y], Y]:
    """Return f(t, y), the rate of change of y.

    Args:
        coordinates: q₁ … qₙ.
        hamiltonian: H(q, p), values of parameters put in.
        signs: what the letters for signs stand for; they have no slope.
        module: one of ``MODULES``.
    """
    places, momenta = [c.symbol for c in coordinates], [c.momentum for c in coordinates]
    rates = [sp.diff(hamiltonian, p) for p in momenta] + [-sp.diff(hamiltonian, q) for q in places]
    symbols = [*places, *momenta]
    compute = _function(symbols, [rate.xreplace(dict(signs)) for rate in rates], module)

    def rate(t: object, y: Any) -> Any:  # noqa: ARG001 - integrators give the time
        found = compute(*_of_length(y, symbols))
        if not hasattr(y, "shape"):
            return list(found)
        result = 0.0 * y  # an array like y: a rate that is constant becomes a row of its own
        for index, value in enumerate(found):
            result[index] = value
        return result

    return rate


def energy(
    coordinates: Sequence[Coordinate], hamiltonian: sp.Expr, signs: Signs, module: str
) -> Callable[[Any], Any]:  # fmt: skip
    """Return H(y).

    Args:
        coordinates, hamiltonian, signs, module: as of ``right_hand_side``.
    """
    symbols = [c.symbol for c in coordinates] + [c.momentum for c in coordinates]
    compute = _function(symbols, [hamiltonian.xreplace(dict(signs))], module)
    return lambda y: compute(*_of_length(y, symbols))[0] + 0 * y[0]


def _of_length(y: Any, symbols: Sequence[sp.Symbol]) -> Any:
    """Return y; wrong lengths and kinds, such as t and y exchanged, are refused."""
    if isinstance(y, str | Mapping) or not hasattr(y, "__len__") or getattr(y, "shape", None) == ():
        raise InvalidInputError(f"y: a state [{_listed(symbols)}] is needed, not {described(y)}; call f(t, y), H(y)")
    if len(y) != len(symbols):
        raise InvalidInputError(f"y: {len(symbols)} rows are needed, [{_listed(symbols)}], not {len(y)}")
    return y


def _listed(symbols: Sequence[sp.Symbol]) -> str:
    return ", ".join(s.name for s in symbols)


def _function(symbols: Sequence[sp.Symbol], formulas: list[sp.Expr], module: str) -> Callable[..., Sequence[object]]:
    if module not in MODULES:
        raise InvalidInputError(f'module: {module!r:.40} is not known; write "numpy" or "mpmath"')
    if any(formula.has(AppliedUndef) for formula in formulas):
        raise InvalidInputError("a function that is left undetermined has no values; write it out in T or V")
    function: Callable[..., Sequence[object]] = sp.lambdify(symbols, formulas, modules=module, cse=True)
    return function
