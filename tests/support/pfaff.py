"""Constraints linear in the velocities: are they integrable (Greenwood (1-20), (1-23); Frobenius' theorem)?"""

from __future__ import annotations

import re
from collections.abc import Sequence

import sympy as sp


def names_of(text: str) -> set[str]:
    """Every name in a formula."""
    return set(re.findall(r"[A-Za-z_]\w*", text)) - {
        "dot",
        "sin",
        "cos",
        "sinh",
        "cosh",
        "tan",
        "sqrt",
        "log",
        "exp",
        "atan",
        "abs",
        "pi",
    }


def formula(text: str, coordinates: Sequence[str] = ()) -> sp.Expr:
    """A formula with plain symbols; ``dot(q)`` becomes ``q_d``."""
    text = re.sub(r"dot\((\w+)\)", r"\1_d", text)
    names = names_of(text) | set(coordinates)
    return sp.sympify(text, locals={n: sp.Symbol(n) for n in names} | {"abs": sp.Abs}, rational=True)


def one_form(text: str, coordinates: Sequence[str]) -> list[sp.Expr]:
    """Coefficients of dq₁ … dqₙ, dt."""
    expression = formula(text, coordinates)
    speeds = [sp.Symbol(f"{n}_d") for n in coordinates]
    at_rest = expression.subs(dict.fromkeys(speeds, 0))
    coefficients = [expression.diff(v) for v in speeds]
    assert sp.simplify(expression - at_rest - sum(c * v for c, v in zip(coefficients, speeds, strict=True))) == 0
    return [*coefficients, at_rest]


def _variables(coordinates: Sequence[str]) -> list[sp.Symbol]:
    return [sp.Symbol(n) for n in (*coordinates, "t")]


def curvature(forms: Sequence[Sequence[sp.Expr]], coordinates: Sequence[str]) -> list[sp.Expr]:
    """dω_k(X, Y) for all X, Y that satisfy the constraints; all vanish iff the system is integrable."""
    x = _variables(coordinates)
    kernel = sp.Matrix(forms).nullspace()
    found = []
    for form in forms:
        d = sp.Matrix(len(x), len(x), lambda i, j: form[j].diff(x[i]) - form[i].diff(x[j]))  # noqa: B023
        found += [sp.simplify((a.T * d * b)[0]) for i, a in enumerate(kernel) for b in kernel[i + 1 :]]
    return found


def reachable(forms: Sequence[Sequence[sp.Expr]], coordinates: Sequence[str]) -> int:
    """Dimension of the space that the allowed directions and their repeated brackets span (time kept still)."""
    x = _variables(coordinates)[:-1]
    fields = sp.Matrix([form[:-1] for form in forms]).nullspace()
    span = list(fields)
    for _ in range(3):
        span += [v.jacobian(x) * u - u.jacobian(x) * v for u in fields for v in span[:12]]
    point = {s: sp.Rational(3 + i, 5) for i, s in enumerate(sorted(sp.Matrix.hstack(*span).free_symbols, key=str))}
    return int(sp.Matrix.hstack(*span).xreplace(point).evalf(30).rank(iszerofunc=lambda v: abs(v) < 1e-20))
