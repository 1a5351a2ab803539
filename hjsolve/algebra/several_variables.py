"""Is a function of several variables constant, and zero? For sums of inverse functions such as atan(x/y) + atan(y/x).

Its derivatives vanish, by the normal form; its domain is a box less the zeros of what is divided by or rooted. Each of
these is a polynomial that does not change its sign on the box. The zeros of an irreducible one then have codimension
two at least (where they had one, it would change sign across them), so that the domain is connected and one value
decides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.constants import constant_is_zero
from hjsolve.algebra.elementary import PRIMITIVES, at_one_place, composed
from hjsolve.algebra.one_variable import vanishes
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.reading import FieldReader
from hjsolve.algebra.signs import sign_of


def constant_zero(
    reader: FieldReader, f: sp.Expr, symbols: Sequence[sp.Symbol], place: Mapping[sp.Symbol, sp.Rational]
) -> bool:
    """Return a proof that f is zero on its domain.

    Args:
        reader: reads and differentiates; its bounds are the box.
        f: inverse functions of rational functions, with constant coefficients, or what else the reader decides.
        symbols: all variables of f.
        place: a place of the box.
    """
    ends = [e for s in symbols for e in reader.bounds.get(s, (None, None)) if e is not None]
    if any(e.free_symbols for e in ends):
        return False
    try:
        if not all(_is_signed(reader, w) for w in _watched(f)):
            return False
        if any(not reader.element(composed(f.diff(s))).is_zero for s in symbols):
            return False
    except (WorkLimitError, ZeroDivisionError):
        return False
    value = at_one_place(f.xreplace(place))
    return not value.has(sp.I, sp.zoo, sp.nan) and constant_is_zero(value) is True


def is_one_constant(reader: FieldReader, f: sp.Expr, symbol: sp.Symbol, inside: sp.Expr, budget: Budget) -> bool:
    """Return a proof that f, whose derivative by a variable vanishes, has one value along it: that it does not jump.

    x − atan(tan x) is constant between the poles of the tangent, and another constant beyond each of them.

    Args:
        reader: reads f; its bounds are the box.
        inside: a value of the variable in its interval.
        budget: of the proof.
    """
    ends = reader.bounds.get(symbol, (None, None))
    try:
        if not reader.element(f).depends_on(symbol) or all(_is_signed(reader, w) for w in _watched(f)):
            return True
        part = sp.Add(*(term for term in sp.Add.make_args(f) if term.has(symbol)))
        alone = part.free_symbols == {symbol} and all(e is None or e.is_number for e in ends)
        return alone and vanishes(part - part.subs(symbol, inside), symbol, ends, budget)
    except (WorkLimitError, ZeroDivisionError):
        return False


def _watched(f: sp.Expr) -> list[sp.Expr]:
    """Return what must not vanish: denominators, radicands, arguments of log, 1 − u² of asin u, cos x of tan x."""
    found = [p.base for p in f.atoms(sp.Pow) if p.base.free_symbols and (p.exp.is_negative or not p.exp.is_Integer)]
    for p in f.atoms(*PRIMITIVES):
        u = p.args[0]
        if isinstance(p, sp.log):
            found.append(u)
        elif isinstance(p, (sp.asin, sp.acos, sp.acosh, sp.atanh)):
            found.append(1 - u**2)
    found += [below(p.args[0]) for p in f.atoms(*_BELOW) for below in [_BELOW[p.func]]]
    return [w for w in found if w.free_symbols]


_BELOW = {
    sp.tan: sp.cos, sp.sec: sp.cos, sp.cot: sp.sin, sp.csc: sp.sin, sp.coth: sp.sinh, sp.csch: sp.sinh,
    sp.sign: lambda u: u,
}  # fmt: skip
"""Function → what vanishes where it has a pole, or jumps."""


def _is_signed(reader: FieldReader, x: sp.Expr) -> bool:
    """Return whether every factor is a polynomial in the variables that keeps its sign on the box."""
    field = reader.field
    y = field.factored(reader.element(x))
    return all(
        sign_of(field, base, reader.bounds) != 0
        and all(field.generators[k].kind == "symbol" for k in poly.generators(base))
        for base, _ in y.bases
    )
