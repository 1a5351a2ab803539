"""Sums of complete integrals of the third kind with poles beyond the turning points: their residues cancel exactly.

    Π(n, m) = π/(2 √((1 − n)(1 − m/n))) − ⅓ (m/n) R_J(0, 1 − m, 1, 1 − m/n),   n < 0 or m < n < 1

(DLMF 19.21.12 with x = 1, R_C(0, η) = π/(2√η), and 19.25.2). With a coefficient c the first term is c/|c| π/2 √T,
T = c²/((1 − n)(1 − m/n)). At a pole that came from cos θ = ±1 of a top T holds no p_φ and no p_ψ: to pass either end of
the axis adds half a turn to φ and ψ or takes it away, whatever the motion. In a sum these terms are gathered by T, so
that ½ − ½ is zero, and what is left, which may be a part in 10⁴ of them, keeps its digits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mpmath
import sympy as sp

from hjsolve.closed_form.evaluation import number_of
from hjsolve.errors import required
from hjsolve.functions import CarlsonRF, CarlsonRJ

Where = Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]


@dataclass(frozen=True)
class _Pole:
    """A term c Π(n, m) of a sum.

    Attributes:
        coefficient: c.
        n, m: in terms of roots.
        square: T.
        negative: whether n < 0.
    """

    coefficient: sp.Expr
    n: sp.Expr
    m: sp.Expr
    square: sp.Expr
    negative: bool


def connected(expression: sp.Expr, where: Where, example: Mapping[sp.Symbol, mpmath.mpf]) -> sp.Expr:
    """Return an equal expression in which the residues of sums are gathered.

    Args:
        expression: of a form.
        where: symbol → its definition.
        example: symbol → its value at a motion of the regime, of constants and of names.
    """
    new = dict[sp.Expr, sp.Expr]()
    for total in expression.atoms(sp.Add):
        terms = [term for term in total.args if _integral(term) is not None]
        if len(terms) < 2:
            continue
        poles = [_pole(term, where, example) for term in terms]
        known = [pole for pole in poles if pole is not None]
        if len(known) == len(terms) and len({pole.square for pole in known}) < len(known):
            new[total] = sp.Add(*(term for term in total.args if term not in terms), _gathered(known))
    return expression.xreplace(new)


def _integral(term: sp.Expr) -> sp.elliptic_pi | None:
    """Return the factor Π(n, m) of a term; None where there is none, or not one."""
    found = [f for f in sp.Mul.make_args(term) if isinstance(f, sp.elliptic_pi) and len(f.args) == 2]
    return found[0] if len(found) == 1 else None


def _pole(term: sp.Expr, where: Where, example: Mapping[sp.Symbol, mpmath.mpf]) -> _Pole | None:
    """Return a term as one with a pole that the formula serves; None for others."""
    integral = required(_integral(term))
    defined = {s: e for s, e in where.items() if isinstance(e, sp.Expr)}
    parts = [term / integral, *integral.args]
    while held := {s: e for s, e in defined.items() if any(s in part.free_symbols for part in parts)}:
        parts = [part.xreplace(held) for part in parts]
    c, n, m = parts
    if not all(part.free_symbols <= example.keys() for part in parts):
        return None
    value, parameter = number_of(n, example), number_of(m, example)
    if not (value < 0 or parameter < value < 1):
        return None
    square = sp.factor(_without_roots(sp.cancel(c**2 / ((1 - n) * (1 - m / n))), n, where))
    return _Pole(c, n, m, square, bool(value < 0))


def _without_roots(square: sp.Expr, n: sp.Expr, where: Where) -> sp.Expr:
    """Put P(c) in place of the product of all c − x, at the place c where n is infinite."""
    below = sp.fraction(sp.together(n))[1]
    for x in below.free_symbols:
        meaning = where.get(x)
        if not isinstance(meaning, tuple) or sp.degree(below, x) != 1:
            continue
        P, c = meaning[0], sp.solve(below, x)[0]
        roots = [s for s, e in where.items() if isinstance(e, tuple) and e[0] == P]
        if c.free_symbols & set(roots) or len(roots) != P.degree():
            continue
        value = P.as_expr().subs(P.gen, c)
        if value != 0:
            return sp.cancel(square * P.LC() * sp.Mul(*(c - s for s in roots)) / value)
    return square


def _gathered(poles: list[_Pole]) -> sp.Expr:
    residues = dict[sp.Expr, sp.Expr]()
    rest = []
    for pole in poles:
        c, n, m = pole.coefficient, pole.n, pole.m
        d = sp.factor(1 - m)
        far = -sp.factor(c * m / n) * CarlsonRJ(0, d, 1, sp.factor(1 - m / n)) / 3
        direct = c * (CarlsonRF(0, d, 1) + n * CarlsonRJ(0, d, 1, sp.factor(1 - n)) / 3)
        beyond = sp.true if pole.negative else n**2 > m  # next to n = m what is far is a difference of large numbers
        rest.append(sp.Piecewise((far, beyond), (direct, True)))
        residues[pole.square] = residues.get(pole.square, sp.S.Zero) + sp.sign(c) * sp.Piecewise((1, beyond), (0, True))
    return sp.Add(*rest, *(sp.pi / 2 * sp.sqrt(square) * count for square, count in residues.items()))
