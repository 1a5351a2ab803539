"""The rules for second divided differences on two fixed places, over disks and at points in complex doubles.

The rules are those of ``arithmetic.divided_differences``; here both nodes are turning points, and what depends on them
alone is known beforehand.
"""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, hull, tighter
from hjsolve.arithmetic.divided_differences import of_composition, of_product, of_reciprocal
from hjsolve.arithmetic.number_types import Complexes, N
from hjsolve.errors import required

_DISKS = Disks()
_CLOSE = 1e-4
"""Relative distance of two points below which a quotient of differences loses more than a mean value leaves out."""


class EndValues(NamedTuple):
    """f(a), f(b) and f[a, b] as disks; a constant has only the first."""

    lower: Disk
    upper: Disk
    chord: Disk | None = None


class DividedValues(NamedTuple, Generic[N]):
    """f(q), f[a, b, q], f[b, q] and f[a, q]."""

    here: N
    second: N
    from_upper: N
    from_lower: N


class ProgramLine(NamedTuple):
    """One operation of the program, ``add``, ``mul``, ``inverse`` or a function: the slot it fills, what it takes."""

    code: str
    target: int
    first: int
    other: int = -1


class DifferenceRules(ABC, Generic[N]):
    """The rules for second differences, over some kind of numbers.

    Φ is a function of ``tape.UNARY``, called by its name.

    Attributes:
        add, sub, mul, reciprocal: x + y, x − y, x·y and 1/x.
        call: (name, x) ↦ Φ(x).
    """

    add: Callable[[N, N], N]
    sub: Callable[[N, N], N]
    mul: Callable[[N, N], N]
    reciprocal: Callable[[N], N]
    call: Callable[[str, N], N]

    @abstractmethod
    def fixed(self, disk: Disk) -> N:
        """Return what is known at a and b as a number of this kind.

        Args:
            disk: the value at a or b, or the chord between them.
        """

    @abstractmethod
    def chord(self, name: str, x: N, y: N, at_x: N, at_y: N) -> N:
        """Return Φ[x, y].

        Args:
            at_x, at_y: Φ of them.
        """

    @abstractmethod
    def bend(self, name: str, places: tuple[N, N, N], chord: N, near_a: N, near_b: N) -> N:
        """Return Φ[a, b, q] from Φ[a, b], Φ[a, q] and Φ[b, q].

        Args:
            chord, near_a, near_b: Φ[a, b], Φ[a, q] and Φ[b, q].
        """

    def step(
        self, line: ProgramLine, ends: tuple[EndValues, ...], slots: list[DividedValues[N] | None]
    ) -> DividedValues[N]:
        """Return f(q) and the differences of one line.

        Args:
            line: the line of the program.
            ends: what is known of each slot at a and b.
            slots: what is known of the slots that are filled; None for a constant.
        """
        x, y, f, g = ends[line.first], ends[line.other], slots[line.first], slots[line.other]
        if line.code in {"add", "mul"}:
            if f is None or g is None:
                constant, other = (x, g) if f is None else (y, f)
                return self._with_constant(line.code, self.fixed(constant.lower), required(other))
            return self._sum(f, g) if line.code == "add" else self._product(x, f, g)
        f = required(f)
        return self._inverse(x, f) if line.code == "inverse" else self._unary(line.code, x, f)

    def _with_constant(self, code: str, constant: N, f: DividedValues[N]) -> DividedValues[N]:
        if code == "add":
            # differences of a constant are zero
            return f._replace(here=self.add(constant, f.here))
        return DividedValues(*(self.mul(constant, part) for part in f))

    def _sum(self, f: DividedValues[N], g: DividedValues[N]) -> DividedValues[N]:
        return DividedValues(*(self.add(*parts) for parts in zip(f, g, strict=True)))

    def _product(self, x: EndValues, f: DividedValues[N], g: DividedValues[N]) -> DividedValues[N]:
        lower, upper, chord = self.fixed(x.lower), self.fixed(x.upper), self.fixed(required(x.chord))
        down, there = (f.here, f.from_upper, f.second), (g.here, g.from_upper, g.second)
        return DividedValues(
            self.mul(f.here, g.here),
            of_product(self, (lower, chord), down, there),
            of_product(self, (upper,), down, there),
            of_product(self, (lower,), (f.here, f.from_lower), (g.here, g.from_lower)),
        )

    def _inverse(self, x: EndValues, f: DividedValues[N]) -> DividedValues[N]:
        """(1/f)[b, q] = −f[b, q]/(f(b) f(q)), and the second difference by its rule."""
        here = self.reciprocal(f.here)
        inverses = [_DISKS.inverse(end) for end in (x.lower, x.upper)]
        known = self.fixed(x.lower), self.fixed(required(x.chord))
        upper, lower = (self.mul(self.fixed(-inverse), here) for inverse in reversed(inverses))
        return DividedValues(
            here,
            of_reciprocal(self, (*map(self.fixed, inverses), here), known, (f.from_lower, f.second)),
            self.mul(upper, f.from_upper),
            self.mul(lower, f.from_lower),
        )

    def _unary(self, name: str, x: EndValues, f: DividedValues[N]) -> DividedValues[N]:
        a, b, q = self.fixed(x.lower), self.fixed(x.upper), f.here
        ends = [_DISKS.unary(name, end) for end in (x.lower, x.upper)]
        at_a, at_b = map(self.fixed, ends)
        here = self.call(name, q)
        # Φ[f(a), f(q)], Φ[f(b), f(q)] and Φ[f(a), f(b), f(q)]
        near_a, near_b = self.chord(name, a, q, at_a, here), self.chord(name, b, q, at_b, here)
        fixed = self.fixed(_DISKS.chord(name, x.lower, x.upper, *ends))
        # Φ∘f by the chain rule of differences: Φ[f(a), f(b), f(q)] f[a, b] f[a, q] + Φ[f(b), f(q)] f[a, b, q]
        twice = self.bend(name, (a, b, q), fixed, near_a, near_b)
        second = of_composition(self, near_b, twice, self.fixed(required(x.chord)), (f.from_lower, f.second))
        return DividedValues(here, second, self.mul(near_b, f.from_upper), self.mul(near_a, f.from_lower))


class OverDisks(DifferenceRules[Disk]):
    """The rules over disks: of several methods for a difference the narrowest result is taken."""

    add, sub, mul = staticmethod(_DISKS.add), staticmethod(_DISKS.sub), staticmethod(_DISKS.mul)
    reciprocal, call = staticmethod(_DISKS.inverse), staticmethod(_DISKS.unary)

    def fixed(self, disk: Disk) -> Disk:
        """Return the disk as it is."""
        return disk

    def chord(self, name: str, x: Disk, y: Disk, at_x: Disk, at_y: Disk) -> Disk:
        """Return the quotient of differences, or the mean of Φ′ over the hull: the smaller disk."""
        return _DISKS.chord(name, x, y, at_x, at_y)

    def bend(self, name: str, places: tuple[Disk, Disk, Disk], chord: Disk, near_a: Disk, near_b: Disk) -> Disk:
        """Return one of two quotients, or half the mean of Φ″ over the hull: the smallest disk."""
        a, b, q = places
        one = _DISKS.div(_DISKS.sub(near_b, chord), _DISKS.sub(q, a))
        other = _DISKS.div(_DISKS.sub(near_b, near_a), _DISKS.sub(b, a))
        # Φ[a, b, q] is a mean of ½Φ″ over the triangle (Hermite and Genocchi); the hull is convex and holds it
        mean = _DISKS.times(_DISKS.bend(name, hull(hull(a, b), q)), 0.5)
        return tighter(tighter(one, other), mean)


class AtPoints(DifferenceRules[Complexes]):
    """The rules at points in complex doubles."""

    add, sub, mul = staticmethod(operator.add), staticmethod(operator.sub), staticmethod(operator.mul)
    reciprocal = staticmethod(lambda x: 1 / x)

    def fixed(self, disk: Disk) -> Complexes:
        """Return the centre of a disk."""
        return disk.centre

    @staticmethod
    def call(name: str, x: Complexes) -> Complexes:
        return _DISKS.unary(name, Disk(x, np.zeros(()))).centre

    def chord(self, name: str, x: Complexes, y: Complexes, at_x: Complexes, at_y: Complexes) -> Complexes:
        """Return Φ[x, y]: the quotient, or Φ′ in the middle where x and y are close."""
        apart = y - x
        # the quotient loses ε/|y − x| of its digits, Φ′ in the middle leaves out |y − x|²
        close = np.abs(apart) < _CLOSE * np.maximum(np.abs(x), 1e-3)
        quotient = (at_y - at_x) / np.where(close, 1, apart)
        if not np.any(close):
            return quotient
        return np.where(close, _DISKS.derivative(name, Disk((x + y) / 2, np.zeros(()))).centre, quotient)

    def bend(
        self,
        name: str,
        places: tuple[Complexes, Complexes, Complexes],
        chord: Complexes,
        near_a: Complexes,
        near_b: Complexes,
    ) -> Complexes:
        """Return Φ[a, b, q] over the longer of two distances, or ½Φ″ in the middle where all are close."""
        a, b, q = places
        one, other = np.broadcast_arrays(q - a, b - a + 0 * q)
        widest = np.maximum(np.abs(one), np.abs(other))
        # the same number by symmetry of differences; the longer distance loses fewer digits
        quotient = np.where(np.abs(one) > np.abs(other), (near_b - chord) / one, (near_b - near_a) / other)
        close = widest < _CLOSE * np.maximum(np.abs(a), 1e-3)
        if not np.any(close):
            return quotient
        return np.where(close, _DISKS.bend(name, Disk((a + b + q) / 3, np.zeros(()))).centre / 2, quotient)
