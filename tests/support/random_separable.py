"""Random Liouville and Stäckel systems as text, and what the textbook integrals and Hamilton's equations make of them.

A system is a matrix Φ whose i-th row depends on qᵢ alone and a column ψᵢ(qᵢ): gⁱⁱ = (Φ⁻¹)₁ᵢ, T = ½ Σ q̇ᵢ²/gⁱⁱ and V = Σ gⁱⁱ ψᵢ
(Stäckel 1891). The signs of the entries make every gⁱⁱ positive. A Liouville system has the row (fᵢ, ±1 …) over Mᵢ. The
truths know nothing of hjsolve: pᵢ² = 2 (Σⱼ Φᵢⱼ αⱼ − ψᵢ) with α from the initial data, its zeros by scanning, tanh-sinh
quadrature, and Taylor series of Hamilton's equations.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import sympy as sp
from mpmath import mp

import hjsolve
from tests.reference.taylor import Flow
from tests.support.random_potentials import Line

NAMES = ("x", "y", "z")


@dataclass(frozen=True)
class Separable:
    """A random system with initial data.

    Attributes:
        matrix, column: Φ and ψ in plain symbols x, y, z.
        q, velocity: exact decimal text.
    """

    matrix: sp.Matrix
    column: sp.Matrix
    q: dict[str, str]
    velocity: dict[str, str]

    @property
    def names(self) -> tuple[str, ...]:
        return NAMES[: self.matrix.rows]

    @cached_property
    def inverse_metric(self) -> list[sp.Expr]:
        """gⁱⁱ, by cofactors of the first column."""
        det = sum(self.matrix[i, 0] * self.matrix.cofactor(i, 0) for i in range(self.matrix.rows))
        return [self.matrix.cofactor(i, 0) / det for i in range(self.matrix.rows)]

    @cached_property
    def potential(self) -> sp.Expr:
        return sum(g * ψ for g, ψ in zip(self.inverse_metric, self.column, strict=True))

    def motion(self, **more: Any) -> Any:
        """The motion through the public names, from text."""
        kinetic = " + ".join(f"dot({n})**2/(2*({g}))" for n, g in zip(self.names, self.inverse_metric, strict=True))
        system = hjsolve.System(dict.fromkeys(self.names, "line"), kinetic, str(self.potential))
        return hjsolve.solve(system).motion(q=self.q, velocity=self.velocity, **more)

    def begin(self) -> tuple[dict[sp.Symbol, Any], list[Any]]:
        """q and p at t = 0, exact."""
        place = {sp.Symbol(n): sp.Rational(self.q[n]) for n in self.names}
        metric = [g.subs(place) for g in self.inverse_metric]
        return place, [sp.Rational(self.velocity[n]) / g for n, g in zip(self.names, metric, strict=True)]

    def lines(self) -> list[Line]:
        """pᵢ² of every coordinate."""
        place, p = self.begin()
        known = sp.Matrix([p[i] ** 2 / 2 + self.column[i].subs(place) for i in range(len(p))])
        α = self._number(self.matrix.subs(place)) ** -1 * self._number(known)
        result = []
        for i, n in enumerate(self.names):
            q = sp.Symbol(n)
            parts = sp.lambdify(q, [*self.matrix.row(i), self.column[i]], "mpmath")
            doubles = sp.lambdify(q, [*self.matrix.row(i), self.column[i]], "numpy")
            result.append(
                Line(_remembered(_square(parts, α)), _square(doubles, [float(a) for a in α]), self._one(place[q]))
            )
        return result

    def growths(self, lines: list[Line], ends: list[tuple[Any, Any]]) -> Any:
        """The matrix (1/2π) ∮ ∂pᵢ/∂αⱼ dqᵢ."""
        n = len(lines)
        return mp.matrix([[self._growth(i, j, lines[i], *ends[i]) for j in range(n)] for i in range(n)])

    def _growth(self, i: int, j: int, line: Line, a: Any, b: Any) -> Any:
        weight = sp.lambdify(sp.Symbol(self.names[i]), self.matrix[i, j], "mpmath")
        return mp.quad(lambda x: weight(x) / mp.sqrt(abs(line.square(x)) or mp.eps), [a, (a + b) / 2, b]) / mp.pi

    def flow(self, digits: int) -> Flow:
        """Hamilton's equations."""
        place, p = self.begin()
        q, momenta = list(place), [sp.Symbol(f"p_{n}") for n in self.names]
        H = sum(g * m**2 / 2 for g, m in zip(self.inverse_metric, momenta, strict=True)) + self.potential
        return Flow(H, q, momenta, {}, [self._one(v) for v in (*place.values(), *p)], digits=digits)

    def _one(self, value: sp.Expr) -> Any:
        return mp.mpf(sp.N(value, mp.dps + 10))

    def _number(self, matrix: sp.Matrix) -> Any:
        return mp.matrix(matrix.rows, matrix.cols) + mp.matrix(
            [[self._one(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)]
        )


def _square(parts: Any, α: Any) -> Any:
    def square(q: Any) -> Any:
        *row, ψ = parts(q)
        return 2 * (sum(f * a for f, a in zip(row, α, strict=True)) - ψ)

    return square


def _remembered(square: Any) -> Any:
    """The same function, each value worked out once a precision."""
    known = cache(lambda q, _: square(q))
    return lambda q: known(q, mp.prec)


class _Dice:
    """Random functions of one coordinate, with coefficients of one or two decimals."""

    def __init__(self, seed: int):
        self.rng = random.Random(seed)

    def number(self, low: float, high: float) -> sp.Rational:
        return sp.Rational(round(100 * self.rng.uniform(low, high)), 100)

    def positive(self, q: sp.Symbol) -> sp.Expr:
        """At least ½ everywhere, and at most like q²."""
        a, b, c, d = self.number(0.7, 2), self.number(0.1, 1), self.number(0.4, 2), self.number(-1, 1)
        return self.rng.choice([
            a + sp.Integer(0), a + b * q**2, a + b + b * sp.sin(c * q + d), a + b / (q**2 + c), sp.sqrt(a + b * q**2),
            a + b * sp.exp(-c * q**2), a + b * sp.log(1 + c * q**2), a + b + b * sp.tanh(c * q),
        ])  # fmt: skip

    def bounded(self, q: sp.Symbol) -> sp.Expr:
        """Between 0 and ½."""
        b, c = self.number(0.1, 0.4), self.number(0.5, 2)
        return self.rng.choice(
            [b + sp.Integer(0), b / (1 + c * q**2), b * sp.exp(-c * q**2), b * (1 + sp.cos(c * q)) / 2]
        )

    def column(self, q: sp.Symbol) -> sp.Expr:
        """A well, with something in it."""
        a, b, c, d = self.number(0.2, 1), self.number(-2, 2), self.number(0.5, 3), self.number(-1, 1)
        inside = [b * q**2, b * sp.sin(c * q + d), b * q, b / (q**2 + c), b * sp.exp(-(q**2)), sp.Integer(0)]
        return a * q**4 + self.rng.choice(inside)


def liouville(seed: int, n: int) -> Separable:
    """T = ½ (Σ fᵢ) Σ Mᵢ q̇ᵢ², V = Σ vᵢ/Σ fᵢ."""
    dice = _Dice(seed)
    q = [sp.Symbol(name) for name in NAMES[:n]]
    rows, column = [], []
    for i, x in enumerate(q):
        f, M = dice.positive(x), dice.positive(x)
        constants = [int(i == j) - int(i == n - 1) for j in range(n - 1)]
        rows.append([f * M, *(-c * M for c in constants)])
        column.append(M * dice.column(x))
    return _started(dice, rows, column)


def staeckel(seed: int, n: int) -> Separable:
    """A random matrix Φ: positive functions with the signs that make all cofactors of its first column positive."""
    dice = _Dice(seed)
    q = [sp.Symbol(name) for name in NAMES[:n]]
    if n == 2:
        rows = [[dice.positive(q[0]), -dice.positive(q[0])], [dice.positive(q[1]), dice.positive(q[1])]]
    else:
        x, y, z = q
        rows = [
            [dice.positive(x), -(dice.positive(x) + 1), -dice.bounded(x)],
            [dice.positive(y), dice.positive(y), -dice.positive(y)],
            [dice.positive(z), dice.bounded(z), dice.positive(z) + 1],
        ]
    return _started(dice, rows, [dice.column(x) for x in q])


def _started(dice: _Dice, rows: list[list[sp.Expr]], column: list[sp.Expr]) -> Separable:
    names = NAMES[: len(rows)]
    q = {n: str(round(dice.rng.uniform(-1.2, 1.2), 2)) for n in names}
    v = {n: str(round(dice.rng.choice([-1, 1]) * dice.rng.uniform(0.2, 1.5), 2)) for n in names}
    return Separable(sp.Matrix(rows), sp.Matrix(column), q, v)
