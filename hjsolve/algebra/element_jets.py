"""Slopes and mixed derivatives of elements at a point: no derivative is written down.

The derivative of an element with a thousand terms has a million when it is multiplied out; its value at a point costs
no more than a few evaluations of the element itself. Modulo a prime (``modular``) the values are those of the
derivatives that an exact computation would find, because the point respects all relations of the field and the
generators' derivatives are elements of it; in intervals they are bounds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.element_point import ElementPoint, Value
from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import ATTEMPTS, ModularPoint, NoRootError
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reader import Reader

Pair = tuple[int, int]


@dataclass(frozen=True)
class ElementJet:
    """f, ∂ᵢf and ∂ᵢ∂ⱼf (i < j)."""

    value: Value
    slopes: Mapping[int, Value]
    mixed: Mapping[Pair, Value]


class ElementJets:
    """Jets of elements at one point.

    Args:
        reader: differentiates the generators.
        symbols: what is differentiated by.
        point: values of the generators.
    """

    def __init__(self, reader: Reader, symbols: Sequence[sp.Symbol], point: ElementPoint):
        self.reader, self.symbols, self.point = reader, symbols, point
        self.pairs = [(i, j) for j in range(len(symbols)) for i in range(j)]
        self._generators: dict[int, ElementJet] = {}
        self._bases: dict[int, ElementJet] = {}

    def logarithm(self, f: ElementJet) -> ElementJet:
        """Return the jet of ln f but for its value; a derivative that f does not name is zero.

        Raises:
            ArithmeticError: f vanishes at this point, or may vanish.
        """
        inverse, reduced = self.point.raised(f.value, -1), self.point.reduced
        slopes = {i: reduced(s * inverse) for i, s in f.slopes.items()}
        mixed = {pair: m * inverse for pair, m in f.mixed.items()}
        for i, j in self.pairs:
            if i in slopes and j in slopes:
                mixed[i, j] = mixed.get((i, j), 0) - slopes[i] * slopes[j]
        return ElementJet(f.value, slopes, {pair: reduced(m) for pair, m in mixed.items()})

    def element(self, x: Element) -> ElementJet:
        """Return the jet of an element.

        Raises:
            ArithmeticError: a generator or a factor vanishes at this point, or may vanish; or it has no value there.
        """
        n, reduced = range(len(self.symbols)), self.point.reduced
        logarithms = [(e, self._base(b)) for b, e in x.factors.items()]
        scale = self.point.fraction(x.coefficient)
        for e, jet in logarithms:
            scale = reduced(scale * self.point.raised(jet.value, e))
        numerator = self._poly(x.numerator)
        value = numerator.value
        slopes = [reduced(sum(e * jet.slopes[i] for e, jet in logarithms)) for i in n]
        mixed = {}
        for i, j in self.pairs:
            rest = sum(e * jet.mixed[i, j] for e, jet in logarithms) + slopes[i] * slopes[j]
            crossed = numerator.slopes[i] * slopes[j] + numerator.slopes[j] * slopes[i]
            mixed[i, j] = reduced(scale * (numerator.mixed[i, j] + crossed + value * rest))
        firsts = {i: reduced(scale * (numerator.slopes[i] + value * slopes[i])) for i in n}
        return ElementJet(reduced(scale * value), firsts, mixed)

    def _base(self, b: int) -> ElementJet:
        if b not in self._bases:
            self._bases[b] = self.logarithm(self._poly(self.reader.field.bases[b]))
        return self._bases[b]

    def _poly(self, a: Poly) -> ElementJet:
        """∂ᵢ of a monomial v is v Σ e ∂ᵢ ln g, and so on."""
        power, reduced = self.point.power, self.point.reduced
        value: Value = self.point.fraction(Fraction(0))
        slopes, mixed = dict.fromkeys(range(len(self.symbols)), value), dict.fromkeys(self.pairs, value)
        for m, c in a.items():
            firsts, seconds = dict[int, Value](), dict[Pair, Value]()
            for k, e in poly.exponents(m):
                g, c = self._generator(k), c * power(k, e)
                for i, first in g.slopes.items():
                    firsts[i] = firsts.get(i, 0) + e * first
                for pair, second in g.mixed.items():
                    seconds[pair] = seconds.get(pair, 0) + e * second
            c = reduced(c)
            value = value + c
            for i, first in firsts.items():
                slopes[i] = slopes[i] + c * first
            for i, j in self.pairs:
                if i in firsts and j in firsts:
                    seconds[i, j] = seconds.get((i, j), 0) + firsts[i] * firsts[j]
            for pair, second in seconds.items():
                mixed[pair] = mixed[pair] + c * reduced(second)
        return ElementJet(
            reduced(value),
            {i: reduced(s) for i, s in slopes.items()},
            {pair: reduced(m) for pair, m in mixed.items()},
        )

    def _generator(self, k: int) -> ElementJet:
        """Return g and the derivatives of its logarithm, without those that vanish."""
        if k not in self._generators:
            reader, element = self.reader, self.point.element
            firsts = {i: d for i, q in enumerate(self.symbols) if not (d := reader.generator_diff(k, q)).is_zero}
            seconds = {(i, j): reader.diff(firsts[i], self.symbols[j]) for i, j in self.pairs if i in firsts}
            slopes = {i: element(x) for i, x in firsts.items()}
            mixed = {pair: element(x) for pair, x in seconds.items() if not x.is_zero}
            jet = ElementJet(self.point.value(k), slopes, mixed)
            self._generators[k] = self.logarithm(jet) if slopes else jet
        return self._generators[k]


def at_random_points(
    reader: Reader, symbols: Sequence[sp.Symbol], elements: Iterable[Element], points: int = 2
) -> list[tuple[ElementJets, list[ElementJet]]] | None:
    """Return the jets of the elements at a few random points modulo primes; None when no such points could be found.

    Args:
        symbols: coordinates that are differentiated by.
        elements: what the jets are of.
    """
    wanted, found = list(elements), list[tuple[ElementJets, list[ElementJet]]]()
    for seed in range(ATTEMPTS):
        jets = ElementJets(reader, symbols, ModularPoint(reader.field, seed))
        try:
            found.append((jets, [jets.element(x) for x in wanted]))
        except (NoRootError, ZeroDivisionError):
            continue
        if len(found) == points:
            return found
    return None
