"""∫ N/√P² between two places, turning points and actions of thousands of motions at once, in doubles, with bounds."""

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
_AROUND = 96, 192
"""Nodes between two turning points, coarse and fine: what 96 know to 1e-12, 192 know to all digits."""
_STEPS = 3
"""Of Newton's rule to a turning point: a place known to 1e-4 of itself has all digits after two."""
_FAREST = 3.2
"""The s beyond which a node is a turning point to all digits: exp(−π sinh 3.2) is 1e-17."""
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
        self.slopes = dict[str, Callable[..., Any]]()
        for name, square in solution.momentum_squared.items():
            numerators = {k: n for k, n in context.numerators[name].items() if k != W}
            formulas = [square, *numerators.values()]
            sizes = [sp.Add(*(_size(t) for t in sp.Add.make_args(sp.expand(f)))) for f in formulas]
            symbols = sorted(set[sp.Symbol]().union(*(f.free_symbols for f in formulas)), key=str)
            made = sp.lambdify(symbols, [*formulas, *sizes], modules=modules("numpy"), cse=True)
            self.functions[name], self.names[name] = ([s.name for s in symbols], made), [W, *numerators]
            slope = sp.diff(square, solution.system.coordinate(name).symbol)
            self.slopes[name] = sp.lambdify(symbols, slope, modules=modules("numpy"), cse=True)

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

    def turned(self, name: str, table: Mapping[str, Reals], at: Reals) -> tuple[Reals, Reals]:
        """Return where a coordinate turns, by steps of Newton's rule for P² from a place, and how far it may be off.

        One step leaves the square of what the place is off: of cos θ next to a pole that is 1e-13 of θ.

        Args:
            name: of the coordinate.
            table: parameters and constants.
            at: places next to turning points.
        """
        for _ in range(_STEPS):
            square, size, slope = self._square(name, table, at)
            with np.errstate(all="ignore"):
                # of a place that is far off the steps are long, and the claim no wider for them
                at, off = at - square / slope, 8 * ULP * size / abs(slope) + 4 * ULP * abs(at)
        return at, off

    def action(self, name: str, table: Mapping[str, Reals], low: Reals, high: Reals) -> tuple[Reals, Reals]:
        """Return (1/π) ∫ √P² dq between two turning points, and how far it may be off; nan where it does not settle.

        By the double exponential rule, q = low + (high − low)/(1 + exp(−π sinh s)), which bears a pole of P² next to a
        turning point, as of an eccentric ellipse (Takahasi and Mori, Publ. RIMS 9 (1974) 721).

        Args:
            name: of the coordinate.
            table: parameters and constants.
            low: the lower turning point.
            high: the upper one.
        """
        found = list[tuple[Reals, Reals]]()
        for count in _AROUND:
            step = 2 * _FAREST / count
            s = (step * (np.arange(count) + 0.5) - _FAREST)[:, None]
            part = 1 / (1 + np.exp(-np.pi * np.sinh(s)))
            q = low + (high - low) * part
            square, size, slope = self._square(name, table, q)
            with np.errstate(all="ignore"):
                p, weight = (
                    np.sqrt(np.where(square > 0, square, 0.0)),
                    (high - low) * step * np.cosh(s) * part * (1 - part),
                )
                off = 8 * ULP * size + 2 * ULP * abs(q * slope)  # of P², by its terms and by the rounding of a node
                found.append((np.sum(weight * p, axis=0), np.sum(weight * off / np.fmax(p, np.sqrt(off)), axis=0)))
        (coarse, _), (fine, lost) = found
        off = abs(fine - coarse)
        settled = off <= _SETTLED * abs(fine)
        return np.where(settled, fine, np.nan), np.where(settled, _SAFETY * off + lost, np.nan)

    def _square(self, name: str, table: Mapping[str, Reals], q: Reals) -> tuple[Reals, Reals, Reals]:
        """P², the size of its terms and its slope at places."""
        names, function = self.functions[name]
        given = [q if n == name else table[n] for n in names]
        with np.errstate(all="ignore"):
            values, count = function(*given), len(self.names[name])
            parts = (values[0], values[count], self.slopes[name](*given))
            square, size, slope = (np.broadcast_to(v, np.shape(q)) for v in parts)
        return square, size, slope

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
