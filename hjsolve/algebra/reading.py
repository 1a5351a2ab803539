"""What roots, logarithms and relations need of the reader that calls them."""

from __future__ import annotations

from typing import Protocol

import sympy as sp

from hjsolve.algebra.field import Element, Field, Generator
from hjsolve.algebra.signs import Bounds


class FieldReader(Protocol):
    """A field that grows while expressions are read into it; ``reader.Reader`` is one.

    Attributes:
        field: what is read into.
        bounds: lower and upper end of the range of a symbol; None is infinite.
        seconds_for_relations: processor time left for finding relations between generators.
    """

    field: Field
    bounds: dict[sp.Symbol, Bounds]
    seconds_for_relations: float

    def element(self, expression: sp.Expr) -> Element:
        """Read an expression."""

    def adjoined(self, g: Generator) -> Element:
        """Add a generator, or find the one that is there."""

    def write(self, x: Element) -> sp.Expr:
        """Write an element as an expression."""
