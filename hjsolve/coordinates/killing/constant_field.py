"""The field that the constants of some expressions live in: algebraic numbers, parameters, opaque constants."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self, TypeAlias

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.polys.constructor import construct_domain
from sympy.polys.domains.domain import Domain
from sympy.polys.fields import FracElement

from hjsolve.algebra.shared_parts import holds


class FieldElement(Protocol):
    """A number of some field: a rational, an algebraic number, or a quotient of polynomials in the parameters."""

    def __add__(self, other: Self, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Self, /) -> Self: ...
    def __truediv__(self, other: Self, /) -> Self: ...
    def __rsub__(self, other: int, /) -> Self: ...
    def __rmul__(self, other: int, /) -> Self: ...
    def __pow__(self, exponent: int, /) -> Self: ...
    def __neg__(self) -> Self: ...
    def __bool__(self) -> bool: ...


EquationTable: TypeAlias = list[list[list[tuple[int, list[tuple[tuple[int, ...], FieldElement]]]]]]
"""[equation][tensor] = (derivative of V, its coefficient): a polynomial in x as exponents and numbers."""
Rows: TypeAlias = list[list[FieldElement]]
"""Linear equations, or vectors."""


@dataclass(frozen=True)
class Ground:
    """The field of constants: Q(algebraic numbers)(parameters and opaque constants)."""

    field: Domain
    parameters: tuple[sp.Symbol, ...]
    opaque: Mapping[sp.Expr, sp.Symbol]

    @property
    def numbers(self) -> Domain:
        """The algebraic numbers of the field."""
        return self.field.domain if self.parameters else self.field

    @property
    def plain(self) -> Domain:
        """What numbers are computed with: rational ones as they are, until they meet a parameter; else the field."""
        return self.numbers if self.numbers.is_QQ else self.field

    def convert(self, constant: sp.Expr) -> FieldElement:
        """Return the element of an expression without coordinates; a number or a polynomial where it is one.

        Args:
            constant: an expression in the parameters and opaque constants.
        """
        if constant.is_Rational:
            return self.plain.from_sympy(constant)
        element = self.field.from_sympy(sp.together(constant.xreplace(dict(self.opaque))))
        return numerator_alone(element) if self.numbers.is_QQ else element

    def restore(self, element: FieldElement) -> sp.Expr:
        """Return the expression of a field element."""
        expression = self.field.to_sympy(element)
        return expression.xreplace({dummy: constant for constant, dummy in self.opaque.items()})


def numerator_alone(element: FieldElement) -> FieldElement:
    """Return a quotient of polynomials whose denominator is 1 as a polynomial, which needs no cancelling."""
    return element.numer if isinstance(element, FracElement) and element.denom == 1 else element


def ground_field(expressions: Iterable[sp.Expr], coordinates: Sequence[sp.Symbol]) -> Ground:
    """Find the field that the constants of some expressions live in.

    Args:
        expressions: whatever will be computed with.
        coordinates: the symbols that are no constants.
    """
    inside = tuple(coordinates)
    parameters: set[sp.Symbol] = set()
    numbers: set[sp.Expr] = set()
    opaque: dict[sp.Expr, sp.Symbol] = {}

    compound = (AppliedUndef, sp.Subs, sp.Derivative, sp.Add, sp.Mul)
    seen: set[sp.Expr] = set()

    def visit(node: sp.Expr) -> None:
        if node in seen:
            return
        seen.add(node)
        if node.is_Symbol:
            if node not in inside:
                parameters.add(node)
        elif node.is_Rational:
            return
        elif holds(node, inside) or isinstance(node, compound) or (node.is_Pow and node.exp.is_Integer):
            for argument in node.args:
                visit(argument)
        elif not node.free_symbols and node.is_algebraic and node.is_real:
            numbers.add(node)
        elif node not in opaque:
            opaque[node] = sp.Dummy(f"c{len(opaque)}", real=True)

    for expression in expressions:
        visit(expression)
    base = construct_domain(sorted(numbers, key=str), extension=True)[0] if numbers else sp.QQ
    base = base if base.is_Field else base.get_field()
    symbols = tuple(sorted(parameters, key=str)) + tuple(opaque.values())
    return Ground(base.frac_field(*symbols) if symbols else base, symbols, opaque)
