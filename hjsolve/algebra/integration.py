"""Potential of a closed one-form, exact and verified; an unevaluated integral where no closed form is found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from sympy.integrals.manualintegrate import manualintegrate

from hjsolve.algebra.field import Element
from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader

MAX_OPERATIONS = 80


def closed_form_potential(reader: Reader, symbols: Sequence[sp.Symbol], form: Sequence[Element]) -> sp.Expr:
    """χ with ∂χ/∂q_a = A_a for a closed one-form A.

    χ is built coordinate by coordinate: what ∂χ/∂q_a still lacks is free of the coordinates before (A is closed) and is
    integrated over q_a alone.

    Args:
        symbols: q, in order.
        form: A_a, one element a coordinate.
    """
    χ = sp.S.Zero
    for position, (q, a) in enumerate(zip(symbols, form)):
        lacking = shortest_form(reader, a - reader.element(sp.diff(χ, q)))
        for earlier in symbols[:position]:
            lacking = lacking.subs(earlier, 1) if earlier in lacking.free_symbols else lacking
        χ += antiderivative(reader, lacking, q)
    return χ


def antiderivative(reader: Reader, x: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """∫ x dq in closed form, verified by differentiation, else as an unevaluated ``Integral``."""
    parts = []
    for term in sp.Add.make_args(sp.expand(x) if sp.count_ops(x) < MAX_OPERATIONS else x):
        constant, rest = term.as_independent(q, as_Add=False)
        roots = {p.base for p in term.atoms(sp.Pow) if p.base.is_Symbol and p.exp.is_Rational and p.exp.q % 2 == 0}
        parts.append(constant * _verified(reader, rest, q, roots - {q}))
    return sp.Add(*parts)


def _verified(reader: Reader, x: sp.Expr, q: sp.Symbol, positive: Iterable[sp.Symbol]) -> sp.Expr:
    """∫ x dq; ``positive`` are letters that have an even root, so that no cases of their sign are needed."""
    if x == 1:
        return q
    unevaluated = sp.Integral(x, q)
    if x.atoms(sp.core.function.AppliedUndef, sp.Derivative) or sp.count_ops(x) > MAX_OPERATIONS:
        return unevaluated
    known = {s: sp.Dummy(s.name, positive=True) for s in positive}
    found = manualintegrate(x.xreplace(known), q).xreplace({dummy: s for s, dummy in known.items()})
    if found.atoms(sp.Integral, sp.Piecewise):
        return unevaluated
    try:
        exact = (reader.diff(reader.element(found), q) - reader.element(x)).is_zero
    except (WorkLimitError, ZeroDivisionError):
        exact = False
    return found if exact else unevaluated
