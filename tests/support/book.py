"""The book's results as functions: each returns its relative error (0 for an exact identity), or fails.

``@result("C39", "P2-9")`` registers one; its docstring says what the book prints. The tests of the chapters
run them, and ``book_table`` writes docs/book.md from the same run.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp
from mpmath import mp

from hjsolve import catalog
from hjsolve.mechanics.system import System, hamiltonian, momenta
from tests.support.entries import loaded, motion, solution
from tests.support.pfaff import formula, names_of

t = sp.Symbol("t", real=True)


@dataclass(frozen=True)
class Result:
    """One checkable result of the book: row of the table, equation or problem, statement, and how good it must be."""

    row: str
    place: str
    statement: str
    error: Callable[[], Any]
    tolerance: float

    @property
    def name(self) -> str:
        return f"{self.row} {self.place}: {self.statement}"


RESULTS: dict[str, list[Result]] = {}


def result(row: str, place: str, tolerance: float = 1e-12) -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    """Register a check of the module it stands in."""

    def register(function: Callable[[], Any]) -> Callable[[], Any]:
        statement = " ".join((function.__doc__ or "").split("\n\n")[0].split()).rstrip(".")
        place_of = RESULTS.setdefault(function.__module__, [])
        place_of.append(Result(row, place, statement, functools.cache(function), tolerance))
        return function

    return register


def exact(*residuals: Any) -> int:
    """Every residual is identically zero: by simplification, and at a random rational point if that gets stuck."""
    for residual in residuals:
        for entry in sp.Matrix([residual]) if not isinstance(residual, sp.MatrixBase) else residual:
            left = sp.simplify(entry)
            assert left == 0 or _vanishes(left), left
    return 0


def _vanishes(expression: sp.Expr) -> bool:
    symbols = sorted(expression.free_symbols, key=str)
    for k in range(3):
        point = {s: sp.Rational(3 + 2 * i + k, 7 + i) for i, s in enumerate(symbols)}
        if abs(sp.N(expression.xreplace(point), 30, maxn=200)) > sp.Float("1e-25"):
            return False
    return True


def differs(expression: sp.Expr) -> int:
    """The expression is not identically zero."""
    assert not _vanishes(sp.expand(expression)), expression
    return 0


def off(value: Any, expected: Any) -> Any:
    """|value − expected|/|expected|, for numbers or arrays of them; the worst."""
    if hasattr(value, "__len__"):
        return max(off(a, b) for a, b in zip(value, expected, strict=True))
    return abs((mp.mpf(float(value)) - mp.mpf(expected)) / mp.mpf(expected))


def start(entry: str, q: Mapping[str, Any], velocity: Mapping[str, Any], **parameters: Any) -> Any:
    """A motion with numbers of one's own."""
    return solution(entry).motion(q=q, velocity=velocity, parameters=parameters)


class Mechanics:
    """T and V with plain symbols: θ is ``theta``, θ̇ is ``theta_d``, θ̈ is ``theta_dd``, the time is ``t``."""

    def __init__(self, kinetic: str, potential: str, coordinates: Sequence[str]):
        self.names = tuple(coordinates)
        self.T, self.V = self.of(kinetic), self.of(potential)
        self.L = self.T - self.V

    def of(self, text: str) -> sp.Expr:
        """A formula of the book; ``dot(q)`` may be written for ``q_d``."""
        return formula(text, self.names)

    def momentum(self, name: str) -> sp.Expr:
        return self.L.diff(sp.Symbol(f"{name}_d"))

    def rate(self, function: sp.Expr) -> sp.Expr:
        """d/dt along a motion."""
        total = function.diff(sp.Symbol("t"))
        for n in self.names:
            q, v, a = (sp.Symbol(n + s) for s in ("", "_d", "_dd"))
            total += function.diff(q) * v + function.diff(v) * a
        return total

    def equation(self, name: str) -> sp.Expr:
        """Lagrange's d/dt ∂L/∂q̇ − ∂L/∂q."""
        return self.rate(self.momentum(name)) - self.L.diff(sp.Symbol(name))

    @property
    def mass(self) -> sp.Matrix:
        return sp.hessian(self.T, [sp.Symbol(f"{n}_d") for n in self.names])

    @property
    def jacobi(self) -> sp.Expr:
        """h = T₂ − T₀ + V (2-150)."""
        return sp.Add(*(sp.Symbol(f"{n}_d") * self.momentum(n) for n in self.names)) - self.L


def mechanics(entry: str) -> Mechanics:
    """The T and V of a catalog file."""
    table, _ = catalog.read(entry)
    return Mechanics(table["kinetic"], table.get("potential", "0"), [c["name"] for c in table["coordinates"]])


def on_shell(equations: Iterable[sp.Expr], motion_of: Mapping[str, sp.Expr]) -> list[sp.Expr]:
    """Equations of motion with functions of t put in for the coordinates."""
    values: dict[sp.Symbol, sp.Expr] = {}
    time = sp.Symbol("t")
    for name, function in motion_of.items():
        for order, suffix in enumerate(("", "_d", "_dd")):
            values[sp.Symbol(name + suffix)] = function.diff(time, order) if order else function
    return [equation.xreplace(values) for equation in equations]


def plain(expression: sp.Expr) -> sp.Expr:
    """An expression of hjsolve with its symbols made plain, to be compared with a formula of the book."""
    return expression.xreplace(
        {s: sp.Symbol(s.name.replace("dot(", "").replace(")", "_d")) for s in expression.free_symbols}
    )


def H_of(system: System | str) -> sp.Expr:
    """H(q, p) in plain symbols, momenta ``p_theta``."""
    return plain(hamiltonian(loaded(system) if isinstance(system, str) else system))


def p_of(entry: str) -> dict[str, sp.Expr]:
    """The momenta in q and q̇, plain symbols."""
    return {n: plain(p) for n, p in momenta(loaded(entry)).items()}


def levi_civita(H: sp.Expr, i: tuple[str, str], j: tuple[str, str]) -> sp.Expr:
    """Levi-Civita's expression for the pairs (qᵢ, pᵢ), (qⱼ, pⱼ); it vanishes identically where H separates."""
    (a, b), (c, d) = ([sp.Symbol(x) for x in pair] for pair in (i, j))
    return (
        H.diff(b) * H.diff(d) * H.diff(a, c) - H.diff(b) * H.diff(c) * H.diff(a, d)
        - H.diff(a) * H.diff(d) * H.diff(b, c) + H.diff(a) * H.diff(c) * H.diff(b, d)
    )  # fmt: skip


def bracket(u: sp.Expr, v: sp.Expr, pairs: Sequence[tuple[str, str]]) -> sp.Expr:
    """(u, v) of (6-212)."""
    symbols = [(sp.Symbol(q), sp.Symbol(p)) for q, p in pairs]
    return sp.Add(*(u.diff(q) * v.diff(p) - u.diff(p) * v.diff(q) for q, p in symbols))


__all__ = [
    "RESULTS", "H_of", "Mechanics", "Result", "bracket", "differs", "exact", "formula", "levi_civita", "mechanics",
    "motion", "names_of", "off", "on_shell", "p_of", "plain", "result", "solution", "start", "t",
]  # fmt: skip
