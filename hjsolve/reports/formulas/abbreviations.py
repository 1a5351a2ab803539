"""Letters for sums that come again and again: Σ = r² + a² cos² θ and Δ = r² − 2Mr + a² of Kerr's metric, defined once.

Within ``abbreviating`` every formula that is laid out has the letters in place of the sums and of their multiples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

_TABLE: ContextVar[Mapping[sp.Expr, sp.Symbol]] = ContextVar("abbreviations", default={})  # noqa: B039 - never changed
_OFTEN, _LEAST_OPERATIONS = 5, 5


@contextmanager
def abbreviating(table: Mapping[sp.Expr, sp.Symbol]) -> Iterator[None]:
    """Abbreviate what is laid out inside.

    Args:
        table: sum, as ``_primitive`` writes it → letter.
    """
    token = _TABLE.set(table)
    try:
        yield
    finally:
        _TABLE.reset(token)


def letters_for_sums(
    expressions: Iterable[sp.Expr], coordinates: Iterable[sp.Symbol], parameters: Iterable[sp.Symbol]
) -> dict[sp.Expr, sp.Symbol]:
    """Find the sums that are worth a letter: Σ for one of several coordinates, Δ for one of a single one.

    Args:
        expressions: the formulas to be shown.
        coordinates, parameters: what a sum may contain.

    Returns:
        Sum → letter; empty where none comes often enough.
    """
    places, allowed = set(coordinates), {*coordinates, *parameters}
    seen: Counter[sp.Expr] = Counter()
    names: set[str] = set()
    for expression in expressions:
        names |= {s.name for s in expression.free_symbols}
        for part in sp.preorder_traversal(expression):
            if part.is_Add and _plain(part) and part.free_symbols <= allowed and part.free_symbols & places:
                seen[_primitive(part)[1]] += 1
    found: dict[sp.Expr, sp.Symbol] = {}
    for name, several in (("Sigma", True), ("Delta", False)):
        good = [
            (count * sp.count_ops(e), str(e), e) for e, count in seen.items()
            if count >= _OFTEN and sp.count_ops(e) >= _LEAST_OPERATIONS
            and (len(e.free_symbols & places) > 1) == several
        ]  # fmt: skip
        if good and name not in names:
            found[max(good)[2]] = sp.Symbol(name, real=True)
    return found


def _primitive(e: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return a number, and the sum that it multiplies.

    Most of its terms are positive, or the sum where every symbol is 1.
    """
    number, rest = e.primitive()
    surplus = sum(-1 if term.could_extract_minus_sign() else 1 for term in rest.args)
    if surplus == 0:
        surplus = sp.N(rest.xreplace(dict.fromkeys(rest.free_symbols, sp.S.One)))
        surplus = surplus if surplus.is_real and surplus != 0 else (-1 if rest.could_extract_minus_sign() else 1)
    return (number, rest) if surplus > 0 else (-number, -rest)


def abbreviated(expression: sp.Basic) -> sp.Basic:
    """Put the letters in, for layout only: a letter depends on the variables that its sum contains.

    Args:
        expression: any sympy object; one with derivatives is left as it is.
    """
    table = _TABLE.get()
    if isinstance(expression, sp.Basic) and expression.has(sp.Derivative, sp.Subs, sp.Lambda):
        return expression
    if not table or not isinstance(expression, sp.Expr | sp.Tuple | Relational | sp.MatrixBase):
        return expression
    if isinstance(expression, sp.MatrixBase):
        return expression.applyfunc(abbreviated)
    known = set().union(*(e.free_symbols for e in table))
    lettered = expression.replace(
        lambda part: part.is_Add and _plain(part) and part.free_symbols <= known and _primitive(part)[1] in table,
        lambda part: _lettered(part, table),
    )
    return lettered if lettered == expression else lettered.replace(_is_negative_integral, _sign_outside)


def _is_negative_integral(part: sp.Basic) -> bool:
    return isinstance(part, sp.Integral) and part.function.could_extract_minus_sign()


def _sign_outside(integral: sp.Integral) -> sp.Expr:
    return -sp.Integral(-integral.function, *integral.limits)


def _plain(part: sp.Expr) -> bool:
    """Return whether it may be abbreviated: no integrals, derivatives or functions that are left open."""
    return not part.has(sp.Integral, sp.Derivative, AppliedUndef)


def _lettered(part: sp.Expr, table: Mapping[sp.Expr, sp.Symbol]) -> sp.Expr:
    number, rest = _primitive(part)
    return number * table[rest]
