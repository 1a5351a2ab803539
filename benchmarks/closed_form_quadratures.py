"""∫ N/√P² between two places, for thousands of motions at once: Gauss's rule in doubles, with a bound."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import sympy as sp

from benchmarks.closed_form_draws import Reals
from hjsolve.closed_form.curves import W
from hjsolve.closed_form.form_context import FormContext
from hjsolve.functions import modules

ULP = float(np.finfo(float).eps)
_PANELS, _NODES = (6, 10), 20
"""Of Gauss's rule, coarse and fine."""
_APART = 1e-8
"""The rounding of a place by the distance of both, beyond which they are not told apart: both are turning points."""
_SAFETY = 32.0
"""Times the difference of the two rules that the fine one may be off: of a pole nearby it is not the square."""
_SETTLED = 1e-12
"""The relative difference of the two rules beyond which a quadrature is not used."""


class Quadratures:
    """∫ N/√P² of every separated coordinate between two places, in doubles, by Gauss's rule on panels.

    Args:
        context: of a solution.
    """

    def __init__(self, context: FormContext):
        solution, self.names = context.solution, dict[str, list[sp.Symbol]]()
        self.functions = dict[str, tuple[list[str], Callable[..., Any]]]()
        for name, square in solution.momentum_squared.items():
            numerators = {k: n for k, n in context.numerators[name].items() if k != W}
            formulas = [square, *numerators.values()]
            sizes = [sp.Add(*(_size(t) for t in sp.Add.make_args(sp.expand(f)))) for f in formulas]
            symbols = sorted(set[sp.Symbol]().union(*(f.free_symbols for f in formulas)), key=str)
            made = sp.lambdify(symbols, [*formulas, *sizes], modules=modules("numpy"), cse=True)
            self.functions[name], self.names[name] = ([s.name for s in symbols], made), [W, *numerators]

    def between(
        self, name: str, table: Mapping[str, Reals], low: Reals, high: Reals
    ) -> dict[sp.Symbol, tuple[Reals, Reals]]:  # fmt: skip
        """Return W or a constant → the quadrature, and how far it may be off; nan where it does not settle.

        Args:
            name: of the coordinate.
            table: parameters and constants.
            low: where it begins.
            high: where it ends.
        """
        coarse, fine = (self._rule(name, table, low, high, panels) for panels in _PANELS)
        found = dict[sp.Symbol, tuple[Reals, Reals]]()
        for key, (value, lost, size) in fine.items():
            with np.errstate(invalid="ignore"):  # both are infinite where the motion is not
                off = abs(value - coarse[key][0])
                claim = _SAFETY * off + lost
            settled = (off <= _SETTLED * size) & np.isfinite(claim)
            found[key] = np.where(settled, value, np.nan), np.where(settled, claim, np.nan)
        return found

    def _rule(
        self, name: str, table: Mapping[str, Reals], low: Reals, high: Reals, panels: int
    ) -> dict[sp.Symbol, tuple[Reals, Reals, Reals]]:  # fmt: skip
        x, w = np.polynomial.legendre.leggauss(_NODES)
        parts = np.concatenate([(k + (1 + x) / 2) / panels for k in range(panels)])[:, None]
        weights = np.tile(w / 2 / panels, panels)[:, None] * (high - low)
        names, function = self.functions[name]
        given = [low + (high - low) * parts if n == name else table[n] for n in names]
        with np.errstate(all="ignore"):
            values = [np.broadcast_to(v, weights.shape) for v in function(*given)]
            count = len(self.names[name])
            (square, *numerators), (size, *sizes) = values[:count], values[count:]
            root, lost = np.sqrt(square), 8 * ULP * size / square
            moved = 2 * ULP * (abs(low) + abs(high)) / abs(high - low)  # of a node that is rounded
            moved = np.where(moved < _APART, moved, np.nan)
            found = dict[sp.Symbol, tuple[Reals, Reals, Reals]]()
            for key, N, S in zip(self.names[name], [square, *numerators], [size, *sizes], strict=True):
                whole = np.sum(weights * abs(N) / root, axis=0)
                rounding = np.sum(weights * (abs(N) * lost + 8 * ULP * S) / root, axis=0)
                found[key] = np.sum(weights * N / root, axis=0), rounding + moved * whole, whole
            return found


def _size(term: sp.Expr) -> sp.Expr:
    """Return a term with the moduli of its factors, where they are sums themselves."""
    return sp.Mul(*(_base_size(*f.as_base_exp()) for f in sp.Mul.make_args(term)))


def _base_size(base: sp.Expr, power: sp.Expr) -> sp.Expr:
    if base.is_Add and power.is_positive:
        return sp.Add(*(sp.Abs(t) for t in base.args)) ** power
    return sp.Abs(base**power)
