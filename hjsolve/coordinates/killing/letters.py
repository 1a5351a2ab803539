"""The kernel over Q(letters) from kernels at values of the letters modulo a prime.

Elimination over a field of rational functions drowns in intermediate expressions, where the result is short: a² − c²,
a distance, the half of a sum. At values of the letters modulo a prime the same elimination takes milliseconds, and a
few dozen of them determine the rational functions (``rational_functions``). At values chosen at random the rank is the
generic one, but for a probability of about degree/2¹²⁷ (Schwartz, J. ACM 27 (1980) 701); the result is compared with
the kernel at further values modulo another prime.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add, mul
from random import Random
from typing import Any, cast

import sympy as sp

from hjsolve.algebra.shared_parts import holds, parts
from hjsolve.coordinates.killing.constant_field import EquationTable, FieldElement, Ground
from hjsolve.coordinates.killing.elimination import dense_echelon, equations_at_points, nullspace
from hjsolve.coordinates.killing.rational_functions import PRIMES, Fractional, Interpolation, Point, Terms
from hjsolve.coordinates.killing.samples import Samples

_CHECK = 2**107 - 1
_UNLUCKY = 5
"""How often the search starts anew where the rank at some values is another one than at the first."""


class PrimeField:
    """The integers modulo a prime, as far as the elimination asks for them."""

    is_QQ = False

    def __init__(self, prime: int):
        self.dtype = sp.GF(prime, symmetric=False).dtype
        self.prime, self.zero, self.one = prime, self.dtype(0), self.dtype(1)

    def convert(self, number: object) -> FieldElement:
        """Return the image of a rational number; an element is returned as it is.

        Args:
            number: a rational number of sympy, or an element.
        """
        if isinstance(number, sp.Rational):
            return self.dtype(int(number.p)) / self.dtype(int(number.q))
        return number if isinstance(number, type(self.one)) else self.dtype(int(number))  # type: ignore[call-overload]


class ModularGround:
    """The constants of a potential at values of its letters modulo a prime; stands in for ``Ground``.

    Attributes:
        field, numbers, plain: the integers modulo the prime.
        parameters: none are left.
    """

    parameters: tuple[sp.Symbol, ...] = ()

    def __init__(self, ground: Ground, field: PrimeField, values: Mapping[sp.Symbol, int]):
        self.field = self.numbers = self.plain = field
        opaque = {constant: values[letter] for constant, letter in ground.opaque.items()}
        self._values = {e: field.dtype(x) for e, x in {**values, **opaque}.items()}

    def convert(self, constant: sp.Expr) -> FieldElement:
        """Return the value of an expression in the letters.

        Args:
            constant: made of rational numbers, letters and opaque constants.

        Raises:
            ZeroDivisionError: a denominator vanishes.
        """
        if constant not in self._values:
            self._values[constant] = self._value(constant)
        return self._values[constant]

    def _value(self, node: sp.Expr) -> FieldElement:
        if node.is_Rational:
            return self.field.convert(node)
        if node.is_Pow:
            base, n = self.convert(node.base), int(node.exp)
            return base**n if n >= 0 else self.field.one / base**-n
        return reduce(add if node.is_Add else mul, map(self.convert, node.args))


class KernelAtValues:
    """The kernel at values of the letters, its vectors in reduced echelon form, entry by entry.

    Attributes:
        ground: whose parameters are the letters.
        free: the free columns of the first kernel; the others have to have the same.
    """

    def __init__(self, samples: Samples, table: EquationTable, width: int, prime: int):
        self.samples, self.ground, self.table, self.width = samples, samples.made_of.ground, table, width
        self.field = PrimeField(prime)
        self.free: tuple[int, ...] | None = None
        self._points: int | None = None

    def __call__(self, point: Point) -> list[int]:
        """Return all entries of the basis at a point.

        Args:
            point: values of the letters.

        Raises:
            UnluckyError: the kernel has other free columns there than at the first point.
        """
        basis, free = self._basis(point)
        if self.free is None:
            self.free = free
        if free != self.free:
            raise UnluckyError
        entries: Any = [entry for vector in basis for entry in vector]  # integers modulo the prime
        return [int(entry) % self.field.prime for entry in entries]

    def _basis(self, point: Point) -> tuple[list[list[FieldElement]], tuple[int, ...]]:
        ground = ModularGround(self.ground, self.field, dict(zip(self.ground.parameters, point, strict=True)))
        samples = self.samples.with_constants(cast("Ground", ground))  # it has all that samples ask of a field
        stream = equations_at_points(samples, self.table, self.width)
        echelon, used = dense_echelon(stream, self._points)
        self._points = used if self._points is None else self._points
        return nullspace(echelon, self.width, self.field), tuple(c for c in range(self.width) if c not in echelon)


class UnluckyError(ArithmeticError):
    """At some values of the letters the kernel has another dimension than at others."""


def kernel_in_letters(samples: Samples, table: EquationTable, width: int) -> list[list[FieldElement]] | None:
    """Return a basis of the kernel over Q(letters) in reduced echelon form; None where it is not to be found so.

    Args:
        samples: of the derivatives of V; whose constants are rational functions of letters.
        width: how many tensors there are.
    """
    ground = samples.made_of.ground
    for prime in PRIMES:
        for seed in range(_UNLUCKY):
            try:
                box = KernelAtValues(samples, table, width, prime)
                found = Interpolation(box, len(ground.parameters), prime, seed).found()
                if found is not None and _confirmed(found, samples, table, width):
                    return _in_field(found, ground, width)
                break
            except UnluckyError:
                continue
    return None


def _confirmed(found: Sequence[Fractional], samples: Samples, table: EquationTable, width: int) -> bool:
    """Return whether the kernel at other values, modulo another prime, is the one found."""
    box, dice = KernelAtValues(samples, table, width, _CHECK), Random(5)  # noqa: S311
    for _ in range(2):
        point = tuple(dice.randrange(2, _CHECK - 1) for _ in samples.made_of.ground.parameters)
        values = box(point)
        if len(values) != len(found):
            return False
        if any(
            (_value(top, point) - x * _value(bottom, point)) % _CHECK
            for (top, bottom), x in zip(found, values, strict=True)
        ):
            return False
    return True


def _value(terms: Terms, point: Point) -> int:
    total = 0
    for exponents, c in terms.items():
        term = c.numerator * pow(c.denominator, -1, _CHECK)
        for x, e in zip(point, exponents, strict=True):
            term = term * pow(x, e, _CHECK) % _CHECK
        total += term
    return total % _CHECK


def _in_field(found: Sequence[Fractional], ground: Ground, width: int) -> list[list[FieldElement]]:
    ring = ground.field.field.ring
    base = ground.numbers

    def polynomial(terms: Terms) -> FieldElement:
        return ring.from_dict({m: base(c.numerator) / base(c.denominator) for m, c in terms.items()})

    entries = [ground.field(polynomial(top)) / ground.field(polynomial(bottom)) for top, bottom in found]
    return [entries[k : k + width] for k in range(0, len(entries), width)]


def letters_are_polynomial(samples: Samples) -> bool:
    """Return whether V is a polynomial in its letters, so that elimination over their ring is short.

    Args:
        samples: of the derivatives of V.
    """
    ground = samples.made_of.ground
    letters = set(ground.parameters)
    return not any(
        isinstance(part, sp.Pow)
        and not (part.exp.is_Integer and part.exp.is_nonnegative)
        and part not in ground.opaque
        and holds(part.base, tuple(letters))
        for part in parts(samples.values)
    )
