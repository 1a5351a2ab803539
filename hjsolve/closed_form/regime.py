"""The regime of a form: for which constants it holds, in words, as relations, and decided at numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.evaluation import magnitude
from hjsolve.closed_form.regions import RootInterval, region_exists
from hjsolve.closed_form.signs import Signs
from hjsolve.display.shown import Shown
from hjsolve.precision import mp


@dataclass(frozen=True, repr=False)
class Regime(Shown):
    """For which motions a form holds.

    Attributes:
        words: the kinds of motion and the relations, as text.
        relations: between the constants and parameters; all hold.
        kinds: separated coordinate → libration, rotation, escape or boundary.
        example: symbol → exact value, of a motion of this regime.
        special: constant → what it is, where the regime fixes it (E = 0).
        conditions: expression → its sign.
        regions: the curves used, and where on them the motion is.
    """

    words: str
    relations: tuple[sp.Basic, ...]
    kinds: Mapping[str, str]
    example: Mapping[sp.Symbol, sp.Expr] = field(repr=False)
    special: Mapping[sp.Symbol, sp.Expr] = field(repr=False)
    conditions: Mapping[sp.Expr, int] = field(repr=False)
    regions: tuple[tuple[MomentumCurve, RootInterval], ...] = field(repr=False)

    def _label(self) -> str:
        return str(self)

    def __str__(self) -> str:
        return self.words

    def holds(self, values: Mapping[sp.Symbol, sp.Expr]) -> bool:
        """Return whether there is a motion of this regime with given constants.

        Args:
            values: symbol → exact number, of every parameter and constant.
        """
        at = Signs(values, mp.mpf(0))
        for constant, expression in self.special.items():
            off, size = at.number(constant - expression), at.number(magnitude(constant - expression))
            # exact constants agree in all 60 digits; 30 leave room for irrational ones. E = 0 is 0, in any unit
            if not abs(off) <= size * mp.mpf(10) ** -30:
                return False
        return at.agree(self.conditions) and all(
            region_exists(curve, region, at.numbers) for curve, region in self.regions
        )


def described_regime(
    kinds: Mapping[str, str], special: Mapping[sp.Symbol, sp.Expr], conditions: Mapping[sp.Expr, int],
    regions: tuple[tuple[MomentumCurve, RootInterval], ...], example: Mapping[sp.Symbol, sp.Expr], ordering: str,
) -> Regime:  # fmt: skip
    """Put a regime into words and relations.

    Args:
        kinds: separated coordinate → kind.
        special: constant → what it is.
        conditions: expression → its sign.
        regions: the curves used, and where on them the motion is.
        example: a motion's parameters and constants.
        ordering: what is said of roots of higher degree.
    """
    relations: list[sp.Basic] = [sp.Eq(c, e, evaluate=False) for c, e in special.items()]
    for expression, sign in conditions.items():
        relation = plain_relation(expression, sign)
        if relation is not None and relation not in relations:
            relations.append(relation)
    # E > 0 says E ≠ 0 already
    signed = {f for r in relations if _side(r) and r.rhs == 0 for f in (r.lhs, *sp.Mul.make_args(r.lhs))}
    relations = _without_known_signs([r for r in relations if not (isinstance(r, sp.Ne) and r.lhs in signed)])
    what = [f"{name}: {kind}" for name, kind in kinds.items()] or ["every motion"]
    texts = [_written(relation) for relation in relations]
    words = "; ".join(filter(None, (", ".join(what), ", ".join(texts), ordering)))
    return Regime(words, tuple(relations), kinds, example, special, conditions, regions)


def _without_known_signs(relations: list[sp.Basic]) -> list[sp.Basic]:
    """Leave out of products what other relations say: A E > 0 is A > 0 where E > 0."""
    # a sign that is found shortens other products, whose signs shorten more: until none does
    while True:
        signed = {r.lhs: _side(r) for r in relations if _side(r) and r.lhs.is_Symbol and r.rhs == 0}
        table = {s: side * sp.Dummy(s.name, positive=True) for s, side in signed.items()}
        names = {d: sp.sign(e) * symbol for symbol, e in table.items() for d in e.free_symbols}
        shorter = list[sp.Basic]()
        for r in relations:
            if _side(r) and r.rhs == 0 and not r.lhs.is_Symbol and r.lhs.free_symbols & set(table):
                rest = plain_relation(r.lhs.xreplace(table), _side(r))
                rest = None if rest is None else rest.xreplace(names)
                same = rest is not None and sp.expand(rest.lhs - rest.rhs) in (sp.expand(r.lhs), sp.expand(-r.lhs))
                r = r if same else rest
            if r is not None and _side(r) and r.rhs == 0:
                r = _without_signed_sums(r, relations)
            if r is not None and r not in shorter:
                shorter.append(r)
        if shorter == relations:
            return relations
        relations = shorter


def _without_signed_sums(relation: sp.Basic, relations: list[sp.Basic]) -> sp.Basic | None:
    """Leave out of a product the sums whose signs other relations say: g l (E + a) > 0 is g l > 0 where E + a > 0."""
    sums = {r.lhs - r.rhs: _side(r) for r in relations if _side(r) and r != relation and (r.lhs - r.rhs).is_Add}
    rest, side = sp.S.One, _side(relation)
    for factor in sp.Mul.make_args(relation.lhs):
        known = sums.get(factor, 0) or -sums.get(-factor, 0)
        rest, side = (rest, side * known) if known else (rest * factor, side)
    return relation if rest == relation.lhs else plain_relation(rest, side)


def _side(relation: sp.Basic) -> int:
    """Return 1 of >, −1 of <, else 0."""
    return {sp.StrictGreaterThan: 1, sp.StrictLessThan: -1}.get(type(relation), 0)


def _written(relation: sp.Basic) -> str:
    if isinstance(relation, sp.Eq):
        return f"{relation.lhs} = {relation.rhs}"
    if isinstance(relation, sp.Ne):
        return f"{relation.lhs} ≠ {relation.rhs}"
    return str(relation)


def plain_relation(expression: sp.Expr, sign: int) -> sp.Basic | None:
    """Return a relation without factors whose sign is known: 2Em < 0 is E < 0; None where it is always true.

    Args:
        expression: of the constants.
        sign: its sign.
    """
    rest, squares = sp.S.One, list[sp.Expr]()
    for factor in sp.Mul.make_args(sp.factor(expression)):
        if factor.is_positive:
            continue
        if factor.is_negative:
            sign = -sign
            continue
        base, power = factor.as_base_exp()
        # a square says that it is not zero, and nothing of the sign
        if power.is_Integer and power % 2 == 0:
            squares.append(base)
            continue
        rest *= base
    if rest == 1:
        # next to another factor a square says nothing that is not said elsewhere
        unknown = [base for base in squares if base.is_nonzero is None]
        return sp.Ne(unknown[0], 0) if unknown else None
    if rest.is_nonnegative and sign > 0:
        base = rest.as_base_exp()[0]
        return sp.Ne(base.args[0] if isinstance(base, sp.Abs) else base, 0)
    left, right = _sides(rest)
    return sp.Gt(left, right) if sign > 0 else sp.Lt(left, right)


def _sides(expression: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """E − a as E against a; what is not a sum of two like that against zero."""
    terms = sp.Add.make_args(expression)
    if len(terms) == 2:
        plus = [t for t in terms if not t.could_extract_minus_sign()]
        minus = [t for t in terms if t.could_extract_minus_sign()]
        if len(plus) == 1 and len(minus) == 1:
            return plus[0], -minus[0]
    return expression, sp.S.Zero


def settled(made: Regime, expression: sp.Expr) -> sp.Expr:
    """Return an expression with roots, |E| and sign(E) written plainly where the regime says E > 0 or E < 0.

    Args:
        made: the regime.
        expression: of a form.
    """
    table, signed = dict[sp.Expr, sp.Expr](), dict[sp.Expr, sp.Expr]()
    for relation in made.relations:
        if isinstance(relation, (sp.StrictGreaterThan, sp.StrictLessThan)):
            side = 1 if isinstance(relation, sp.StrictGreaterThan) else -1
            # |a − b| and |b − a|, of which sympy knows no canonical one
            for gap in (relation.lhs - relation.rhs, relation.rhs - relation.lhs):
                table |= {
                    sp.Abs(gap): side * (relation.lhs - relation.rhs),
                    sp.sign(relation.lhs - relation.rhs): sp.Integer(side),
                }
            if relation.lhs.is_Symbol and relation.rhs == 0:
                signed[relation.lhs] = side * sp.Dummy(relation.lhs.name, positive=True)
    back = {d: s * sp.sign(e) for s, e in signed.items() for d in e.free_symbols}
    plain = expression.xreplace(table).xreplace(signed).xreplace(back)
    if not plain.has(sp.Abs, sp.sign):
        return plain
    at = Signs(made.example, mp.mpf(0))
    return plain.replace(lambda e: e.is_Mul, lambda e: _without_signs(e, made.relations, at))


def _without_signs(product: sp.Expr, relations: Iterable[sp.Basic], at: Signs) -> sp.Expr:
    """Return a product without |a| |b| and sign(a) sign(b), where the sign of a b is that of the whole regime."""
    signed, rest = sp.S.One, sp.S.One
    for factor in sp.Mul.make_args(product):
        # |a||b| = ± a b where a b has one sign in the regime, though neither a nor b need have
        base, power = factor.as_base_exp()
        if isinstance(base, (sp.Abs, sp.sign)) and power.is_odd and base.free_symbols <= at.numbers.keys():
            signed *= base.args[0]
            rest *= base.args[0] ** power if isinstance(base, sp.Abs) else 1
        else:
            rest *= factor
    if signed == 1 or not sign_is_fixed(relations, signed):
        return product
    return at.there(signed) * rest


def sign_is_fixed(relations: Iterable[sp.Basic], expression: sp.Expr) -> bool:
    """Whether an expression has one sign by strict relations: signs of products are those of their factors.

    Elimination modulo 2: E m < 0 and k m > 0 give the sign of k/E.

    Args:
        relations: that hold.
        expression: of parameters and constants.
    """
    # a sign is a vector over the field of two elements, a product of factors the sum of their vectors
    echelon = dict[sp.Expr, frozenset[sp.Expr]]()
    for row in (_open_factors(r.lhs - r.rhs) for r in relations if _side(r)):
        if left := _without(row, echelon):
            echelon[min(left, key=sp.default_sort_key)] = left
    return not _without(_open_factors(expression), echelon)


@lru_cache(maxsize=1024)
def _open_factors(expression: sp.Expr) -> frozenset[sp.Expr]:
    """Return the factors of odd powers, up to their sign, that may have either sign."""
    found = set[sp.Expr]()
    for factor in sp.Mul.make_args(sp.factor(expression)):
        base, power = factor.as_base_exp()
        if base.is_positive or base.is_negative or (power.is_integer and power.is_even):
            continue
        found.add(-base if base.could_extract_minus_sign() else base)
    return frozenset(found)


def _without(row: frozenset[sp.Expr], echelon: Mapping[sp.Expr, frozenset[sp.Expr]]) -> frozenset[sp.Expr]:
    """Return what Gauss's elimination modulo 2 leaves of a row."""
    for pivot, other in echelon.items():
        if pivot in row:
            row ^= other
    return row


def positive_in(made: Regime, expression: sp.Expr) -> bool:
    """Whether an expression is positive by the regime's conditions on single symbols; False is not a proof of anything.

    Args:
        made: the regime.
        expression: of parameters and constants.
    """
    table = dict[sp.Symbol, sp.Expr]()
    for relation in made.relations:
        if not relation.lhs.is_Symbol or relation.rhs != 0:
            continue
        if isinstance(relation, (sp.StrictGreaterThan, sp.StrictLessThan)):
            # by a symbol that sympy knows to be positive: its own rules for sums and products do the rest
            size = sp.Dummy(relation.lhs.name, positive=True)
            table[relation.lhs] = size if isinstance(relation, sp.StrictGreaterThan) else -size
        elif isinstance(relation, sp.Ne):
            table.setdefault(relation.lhs, sp.Dummy(relation.lhs.name, real=True, nonzero=True))
    return bool(expression.xreplace(table).is_positive)
