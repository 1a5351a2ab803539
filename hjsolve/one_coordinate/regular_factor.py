"""The regular factor of p² at complex places: R(q) = −F[a, b, q], the second divided difference on the turning points.

With F(a) = F(b) = 0 it is p² = (q − a)(b − q) R(q). The difference is carried through the formula by Leibniz' rule

    (fg)[b, q] = f(b) g[b, q] + f[b, q] g(q),   (fg)[a, b, q] = f(a) g[a, b, q] + f[a, b] g[b, q] + f[a, b, q] g(q),

and through an elementary function Φ by (Φ∘f)[a, b, q] = Φ[f(b), f(q)] f[a, b, q] + f[a, b] f[a, q] Φ[f(a), f(b), f(q)]
(Krawczyk & Neumaier, SIAM J. Numer. Anal. 22 (1985) 604). A difference of Φ is a quotient where its points are far
apart, and a mean value of Φ′ or ½Φ″ over their hull where they are close (Hermite–Genocchi), whichever is known better.
However small b − a is, nothing cancels, and constants added to F do not matter. What depends on a and b alone is worked
out once; the rest runs over disks, or over points in complex doubles where a few digits are enough.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, hull, tighter
from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.tape import Operation, Tape

_DISKS = Disks()
_ONE = _DISKS.rational(1, 1)


class ComplexPoints(Float64):
    """Complex doubles, where a few digits are enough."""

    def unary(self, name: str, x: Any) -> Any:
        if name == "turned":
            return 1j * x
        if name == "abs":  # the analytic function ±z
            return np.where(np.real(x) < 0, -x, x)
        if name == "sech":
            decay = np.exp(np.where(np.real(x) < 0, x, -x))
            return 2 * decay / (1 + decay * decay)
        return Float64().unary(name, np.asarray(x, dtype=complex))

    def power(self, x: Any, n: int) -> Any:
        return x**n


_CLOSE = 1e-4
"""Relative distance of two points below which a quotient of differences loses more than a mean value leaves out."""


class EndValues(NamedTuple):
    """f(a), f(b) and f[a, b] as disks; a constant has only the first."""

    lower: Disk
    upper: Disk
    chord: Disk | None = None


class DividedValues(NamedTuple):
    """f(q), f[a, b, q], f[b, q] and f[a, q]."""

    here: Any
    second: Any
    from_upper: Any
    from_lower: Any


class ProgramLine(NamedTuple):
    """One operation of the program, ``add``, ``mul``, ``inverse`` or a function: the slot it fills, what it takes."""

    code: str
    target: int
    first: int
    other: int = -1


@dataclass(frozen=True)
class Deflated:
    """The second difference of a formula on two fixed places, ready to be run.

    Attributes:
        ends: what is known of each slot of the program at a and b.
        lines: what is left to do at q.
        output: the slot of the formula.
    """

    ends: tuple[EndValues, ...]
    lines: tuple[ProgramLine, ...]
    output: int

    def over(self, q: Disk, from_lower: Disk, from_upper: Disk) -> tuple[Disk, Any]:
        """Enclose R over disks that hold q, q − a and q − b.

        Args:
            q: disks, shape (m,).
            from_lower, from_upper: q − a and q − b, known better than by subtraction.

        Returns:
            The disks, and which of ``ways`` gave each of them: the one that is known best.
        """
        result = self._run(_OverDisks(), q)
        best, way = result.second, np.zeros(np.shape(result.second.radius), dtype=int)
        for number, (above, below) in enumerate(
            ((result.from_upper, from_lower), (result.from_lower, from_upper), (result.here, None)), 1
        ):
            other = _DISKS.div(above, below if below is not None else _DISKS.mul(from_lower, from_upper))
            better = (other.radius < best.radius) | (~np.isfinite(best.radius) & np.isfinite(other.radius))
            best = Disk(*(np.where(better, x, y) for x, y in zip(other, best, strict=True)))
            way = np.where(better, number, way)
        return Disk(-best.centre, best.radius), way

    def at(self, q: Any, from_lower: Any, from_upper: Any, way: Any = 0) -> Any:
        """Return R at complex places, in doubles, in one of the ``ways``.

        Args:
            q: complex, shape (m,).
            from_lower, from_upper: q − a and q − b, known better than by subtraction.
            way: position among the ``ways``; one for all places, or one for each.
        """
        return np.choose(way, np.broadcast_arrays(*self.ways(q, from_lower, from_upper)))

    def ways(self, q: Any, from_lower: Any, from_upper: Any) -> tuple[Any, Any, Any, Any]:
        """Return R at complex places as −F[a, b, q], −F[b, q]/(q − a), −F[a, q]/(q − b), −F(q)/((q − a)(q − b)).

        They are the same, and each of them may have lost all digits where another one has not.
        """
        found = self._run(_AtPoints(), q)
        quotients = found.from_upper / from_lower, found.from_lower / from_upper, found.here / (from_lower * from_upper)
        return -found.second, -quotients[0], -quotients[1], -quotients[2]

    def _run(self, on: _Rules, q: Any) -> DividedValues:
        one, zero = on.fixed(_ONE), on.fixed(Disk(np.complex128(0), np.float64(0)))
        slots: list[DividedValues | None] = [None] * len(self.ends)
        slots[0] = DividedValues(q, zero, one, one)
        for line in self.lines:
            slots[line.target] = on.step(line, self.ends, slots)
        found = slots[self.output]
        return DividedValues(zero, zero, zero, zero) if found is None else found


class _Rules(ABC):
    """The rules for second differences, over some kind of numbers."""

    @abstractmethod
    def fixed(self, disk: Any) -> Any:
        """Return what is known at a and b as a number of this kind."""

    @abstractmethod
    def plus(self, x: Any, y: Any) -> Any:
        """Return x + y."""

    @abstractmethod
    def times(self, x: Any, y: Any) -> Any:
        """Return x·y."""

    @abstractmethod
    def reciprocal(self, x: Any) -> Any:
        """Return 1/x."""

    @abstractmethod
    def call(self, name: str, x: Any) -> Any:
        """Return Φ(x)."""

    @abstractmethod
    def chord(self, name: str, x: Any, y: Any, at_x: Any, at_y: Any) -> Any:
        """Return Φ[x, y]."""

    @abstractmethod
    def bend(self, name: str, places: tuple[Any, Any, Any], chord: Any, near_a: Any, near_b: Any) -> Any:
        """Return Φ[a, b, q] from Φ[a, b], Φ[a, q] and Φ[b, q]."""

    def step(self, line: ProgramLine, ends: tuple[EndValues, ...], slots: list[DividedValues | None]) -> DividedValues:
        """Return f(q) and the differences of one line."""
        x, y, f, g = ends[line.first], ends[line.other], slots[line.first], slots[line.other]
        if line.code in {"add", "mul"}:
            if f is None or g is None:
                constant, other = (x, g) if f is None else (y, f)
                assert other is not None
                return self._with_constant(line.code, self.fixed(constant.lower), other)
            return self._sum(f, g) if line.code == "add" else self._product(x, f, g)
        assert f is not None
        return self._inverse(x, f) if line.code == "inverse" else self._unary(line.code, x, f)

    def _with_constant(self, code: str, constant: Any, f: DividedValues) -> DividedValues:
        if code == "add":
            return f._replace(here=self.plus(constant, f.here))
        return DividedValues(*(self.times(constant, part) for part in f))

    def _sum(self, f: DividedValues, g: DividedValues) -> DividedValues:
        return DividedValues(*(self.plus(*parts) for parts in zip(f, g, strict=True)))

    def _product(self, x: EndValues, f: DividedValues, g: DividedValues) -> DividedValues:
        lower, upper, chord = self.fixed(x.lower), self.fixed(x.upper), self.fixed(x.chord)
        outer = self.plus(self.times(lower, g.second), self.times(chord, g.from_upper))
        return DividedValues(
            self.times(f.here, g.here),
            self.plus(outer, self.times(f.second, g.here)),
            self.plus(self.times(upper, g.from_upper), self.times(f.from_upper, g.here)),
            self.plus(self.times(lower, g.from_lower), self.times(f.from_lower, g.here)),
        )

    def _inverse(self, x: EndValues, f: DividedValues) -> DividedValues:
        """(1/f)[a, b, q] = (f[a, b] f[a, q] − f(a) f[a, b, q])/(f(a) f(b) f(q)), (1/f)[b, q] = −f[b, q]/(f(b) f(q))."""
        here = self.reciprocal(f.here)
        ends = self.fixed(_DISKS.mul(_DISKS.inverse(x.lower), _DISKS.inverse(x.upper)))
        minus = self.fixed(Disk(-x.lower.centre, x.lower.radius))
        inner = self.plus(self.times(self.fixed(x.chord), f.from_lower), self.times(minus, f.second))
        upper, lower = (
            self.times(self.fixed(Disk(-part.centre, part.radius)), here)
            for part in (_DISKS.inverse(x.upper), _DISKS.inverse(x.lower))
        )
        return DividedValues(
            here,
            self.times(self.times(ends, here), inner),
            self.times(upper, f.from_upper),
            self.times(lower, f.from_lower),
        )

    def _unary(self, name: str, x: EndValues, f: DividedValues) -> DividedValues:
        a, b, q = self.fixed(x.lower), self.fixed(x.upper), f.here
        at_a, at_b = (self.fixed(_DISKS.unary(name, end)) for end in (x.lower, x.upper))
        here = self.call(name, q)
        near_a, near_b = self.chord(name, a, q, at_a, here), self.chord(name, b, q, at_b, here)
        twice = self.bend(name, (a, b, q), self.fixed(_first_disk(name, x.lower, x.upper)), near_a, near_b)
        inner = self.times(self.times(self.fixed(x.chord), f.from_lower), twice)
        second = self.plus(self.times(near_b, f.second), inner)
        return DividedValues(here, second, self.times(near_b, f.from_upper), self.times(near_a, f.from_lower))


class _OverDisks(_Rules):
    def fixed(self, disk: Any) -> Any:
        return disk

    def plus(self, x: Any, y: Any) -> Any:
        return _DISKS.add(x, y)

    def times(self, x: Any, y: Any) -> Any:
        return _DISKS.mul(x, y)

    def reciprocal(self, x: Any) -> Any:
        return _DISKS.inverse(x)

    def call(self, name: str, x: Any) -> Any:
        return _DISKS.unary(name, x)

    def chord(self, name: str, x: Any, y: Any, at_x: Any, at_y: Any) -> Any:
        """The quotient, or the mean of Φ′ over the hull: the smaller disk."""
        quotient = _DISKS.div(_DISKS.sub(at_y, at_x), _DISKS.sub(y, x))
        return tighter(quotient, _DISKS.derivative(name, hull(x, y)))

    def bend(self, name: str, places: tuple[Any, Any, Any], chord: Any, near_a: Any, near_b: Any) -> Any:
        """One of two quotients, or half the mean of Φ″ over the hull: the smallest disk."""
        a, b, q = places
        one = _DISKS.div(_DISKS.sub(near_b, chord), _DISKS.sub(q, a))
        other = _DISKS.div(_DISKS.sub(near_b, near_a), _DISKS.sub(b, a))
        mean = _DISKS.times(_DISKS.bend(name, hull(hull(a, b), q)), 0.5)
        return tighter(tighter(one, other), mean)


class _AtPoints(_Rules):
    def fixed(self, disk: Any) -> Any:
        return disk.centre

    def plus(self, x: Any, y: Any) -> Any:
        return x + y

    def times(self, x: Any, y: Any) -> Any:
        return x * y

    def reciprocal(self, x: Any) -> Any:
        return 1 / x

    def call(self, name: str, x: Any) -> Any:
        return _DISKS.unary(name, Disk(x, 0.0)).centre

    def chord(self, name: str, x: Any, y: Any, at_x: Any, at_y: Any) -> Any:
        apart = y - x
        close = np.abs(apart) < _CLOSE * np.maximum(np.abs(x), 1e-3)
        quotient = (at_y - at_x) / np.where(close, 1, apart)
        if not np.any(close):
            return quotient
        return np.where(close, _DISKS.derivative(name, Disk((x + y) / 2, 0.0)).centre, quotient)

    def bend(self, name: str, places: tuple[Any, Any, Any], chord: Any, near_a: Any, near_b: Any) -> Any:
        a, b, q = places
        one, other = np.broadcast_arrays(q - a, b - a + 0 * q)
        widest = np.maximum(np.abs(one), np.abs(other))
        quotient = np.where(np.abs(one) > np.abs(other), (near_b - chord) / one, (near_b - near_a) / other)
        close = widest < _CLOSE * np.maximum(np.abs(a), 1e-3)
        if not np.any(close):
            return quotient
        return np.where(close, _DISKS.bend(name, Disk((a + b + q) / 3, 0.0)).centre / 2, quotient)


def _first_disk(name: str, x: Disk, y: Disk) -> Disk:
    return _OverDisks().chord(name, x, y, _DISKS.unary(name, x), _DISKS.unary(name, y))


def deflated(tape: Tape, inputs: Sequence[Disk], lower: Disk, upper: Disk, width: Disk) -> Deflated:
    """Make a formula ready for its second differences on two places.

    Args:
        tape: the formula, one output; q is its first input.
        inputs: the other inputs.
        lower, upper, width: a, b and b − a.
    """
    with np.errstate(all="ignore"):
        builder = _Builder(lower, upper, width, inputs)
        for operation in tape.operations:
            builder.add(operation)
        return Deflated(tuple(builder.ends), tuple(builder.lines), builder.slots[tape.outputs[0]])


class _Builder:
    """Writes the lines of a program and works out what is known at the ends."""

    def __init__(self, lower: Disk, upper: Disk, width: Disk, inputs: Sequence[Disk]):
        self.ends: list[EndValues] = [EndValues(lower, upper, _ONE), *(EndValues(x, x) for x in inputs)]
        self.lines: list[ProgramLine] = []
        self.width = width
        self.slots = list(range(len(self.ends)))
        self.known: dict[ProgramLine, int] = {}

    def add(self, operation: Operation) -> None:
        self.slots.append(self._slot(operation, [self.slots[i] for i in operation.operands]))

    def _slot(self, operation: Operation, x: list[int]) -> int:
        match operation.code:
            case "rational":
                return self._constant(_DISKS.rational(*operation.payload))
            case "pi":
                return self._constant(_DISKS.pi())
            case "add" | "mul":
                return self._line(operation.code, *x)
            case "sub":
                return self._line("add", x[0], self._negative(x[1]))
            case "div":
                return self._line("mul", x[0], self._line("inverse", x[1]))
            case "power":
                return self._power(x[0], operation.payload[0])
            case "neg":
                return self._negative(x[0])
            case _:
                return self._line(operation.code, x[0])

    def _constant(self, value: Disk) -> int:
        self.ends.append(EndValues(value, value))
        return len(self.ends) - 1

    def _negative(self, x: int) -> int:
        return self._line("mul", self._constant(_DISKS.rational(-1, 1)), x)

    def _power(self, x: int, n: int) -> int:
        if n < 0:
            return self._line("inverse", self._power(x, -n))
        result = x if n else self._constant(_ONE)
        for bit in bin(n)[3:]:
            result = self._line("mul", result, result)
            result = self._line("mul", result, x) if bit == "1" else result
        return result

    def _line(self, code: str, x: int, y: int = -1) -> int:
        f, g = self.ends[x], self.ends[y]
        at = self._at(code, f.lower, g.lower), self._at(code, f.upper, g.upper)
        if f.chord is None and (y < 0 or g.chord is None):
            return self._constant(at[0])
        line = ProgramLine(code, len(self.ends), x, y)
        self.ends.append(EndValues(*at, self._chord(code, f, g, at)))
        self.lines.append(line)
        return line.target

    def _at(self, code: str, x: Disk, y: Disk) -> Disk:
        match code:
            case "add":
                return _DISKS.add(x, y)
            case "mul":
                return _DISKS.mul(x, y)
            case "inverse":
                return _DISKS.inverse(x)
            case _:
                return _DISKS.unary(code, x)

    def _chord(self, code: str, f: EndValues, g: EndValues, at: tuple[Disk, Disk]) -> Disk:
        """The first difference on a and b, by rule or as a quotient."""
        zero, d = Disk(np.complex128(0), np.float64(0)), _DISKS
        first, second = f.chord or zero, g.chord or zero
        match code:
            case "add":
                found = d.add(first, second)
            case "mul":
                found = d.add(d.mul(f.lower, second), d.mul(first, g.upper))
            case "inverse":
                found = d.mul(d.mul(*at), Disk(-first.centre, first.radius))
            case _:
                found = d.mul(_first_disk(code, f.lower, f.upper), first)
        return tighter(found, d.div(d.sub(at[1], at[0]), self.width))
