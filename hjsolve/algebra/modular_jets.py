"""Slopes and mixed derivatives of elements at random points modulo a prime: no derivative is written down.

The derivative of an element with a thousand terms has a million when it is multiplied out; its value at a point costs
no more than a few evaluations of the element itself. The point respects all relations of the field (``modular``), and
the generators' derivatives are elements of it, so that the values are those of the derivatives an exact computation
would find.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import ATTEMPTS, ModularPoint, NoRootError
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.reader import Reader

Pair = tuple[int, int]


@dataclass(frozen=True)
class ModularJet:
    """f, ∂ᵢf and ∂ᵢ∂ⱼf (i < j) modulo a prime."""

    value: int
    slopes: Sequence[int]
    mixed: dict[Pair, int]

    def logarithm(self, prime: int) -> ModularJet:
        """Return the jet of ln f but for its value.

        Raises:
            ZeroDivisionError: f vanishes modulo the prime.
        """
        if not self.value:
            raise ZeroDivisionError("a function vanishes modulo the prime")
        inverse = pow(self.value, -1, prime)
        slopes = [s * inverse % prime for s in self.slopes]
        mixed = {(i, j): (m * inverse - slopes[i] * slopes[j]) % prime for (i, j), m in self.mixed.items()}
        return ModularJet(self.value, slopes, mixed)


class ModularJets:
    """Jets of elements at one point.

    Args:
        reader: differentiates the generators.
        symbols: what is differentiated by.
        point: values of the generators.
    """

    def __init__(self, reader: Reader, symbols: Sequence[sp.Symbol], point: ModularPoint):
        self.reader, self.symbols, self.point = reader, symbols, point
        self.pairs = [(i, j) for j in range(len(symbols)) for i in range(j)]
        self._generators: dict[int, ModularJet] = {}
        self._bases: dict[int, ModularJet] = {}

    def element(self, x: Element) -> ModularJet:
        """Return the jet of an element.

        Raises:
            ZeroDivisionError: a generator or a factor vanishes at this point.
            NoRootError: a radicand has no root there.
        """
        p = self.point.prime
        logarithms = [(e, self._base(b)) for b, e in x.factors.items()]
        scale = x.coefficient.numerator * pow(x.coefficient.denominator, -1, p) % p
        for b, e in x.factors.items():
            scale = scale * pow(self._bases[b].value, e, p) % p
        numerator = self._poly(x.numerator)
        slopes = [sum(e * jet.slopes[i] for e, jet in logarithms) % p for i in range(len(self.symbols))]
        mixed = {}
        for i, j in self.pairs:
            rest = sum(e * jet.mixed[i, j] for e, jet in logarithms) + slopes[i] * slopes[j]
            crossed = numerator.slopes[i] * slopes[j] + numerator.slopes[j] * slopes[i]
            mixed[i, j] = scale * (numerator.mixed[i, j] + crossed + numerator.value * rest) % p
        firsts = [scale * (s + numerator.value * l) % p for s, l in zip(numerator.slopes, slopes)]
        return ModularJet(scale * numerator.value % p, firsts, mixed)

    def _base(self, b: int) -> ModularJet:
        if b not in self._bases:
            self._bases[b] = self._poly(self.reader.field.bases[b]).logarithm(self.point.prime)
        return self._bases[b]

    def _poly(self, a: Poly) -> ModularJet:
        """∂ᵢ of a monomial v is v Σ e ∂ᵢ ln g, and so on."""
        p, n = self.point.prime, range(len(self.symbols))
        value, slopes, mixed = 0, [0 for _ in n], dict.fromkeys(self.pairs, 0)
        for m, c in a.items():
            held = poly.exponents(m)
            firsts, seconds = [0 for _ in n], dict[Pair, int]()
            for k, e in held:
                g = self._generator(k)
                c = c * pow(g.value, e, p) % p
                for i in n:
                    firsts[i] += e * g.slopes[i]
                for pair, second in g.mixed.items():
                    seconds[pair] = seconds.get(pair, 0) + e * second
            value += c
            for i in n:
                slopes[i] += c * firsts[i]
            for i, j in self.pairs:
                if (factor := firsts[i] * firsts[j] + seconds.get((i, j), 0)) != 0:
                    mixed[i, j] += c * (factor % p)
        return ModularJet(value % p, [s % p for s in slopes], {pair: m % p for pair, m in mixed.items()})

    def _generator(self, k: int) -> ModularJet:
        """Return the jet of ln g, without the mixed derivatives that vanish."""
        if k not in self._generators:
            value, reader = self.point.value(k), self.reader
            firsts = [reader.generator_diff(k, q) for q in self.symbols]
            seconds = {(i, j): reader.diff(firsts[i], self.symbols[j]) for i, j in self.pairs if not firsts[i].is_zero}
            slopes = [self.point.element(x) for x in firsts]
            mixed = {pair: self.point.element(x) for pair, x in seconds.items()}
            jet = ModularJet(value, slopes, mixed).logarithm(self.point.prime)
            self._generators[k] = ModularJet(value, jet.slopes, {pair: m for pair, m in jet.mixed.items() if m})
        return self._generators[k]


def at_random_points(
    reader: Reader, symbols: Sequence[sp.Symbol], elements: Iterable[Element], points: int = 2
) -> list[tuple[int, list[ModularJet]]] | None:
    """Primes and the jets of the elements at a few random points; None when no such points could be found.

    Args:
        symbols: coordinates that are differentiated by.
        elements: what the jets are of.
    """
    wanted, found = list(elements), list[tuple[int, list[ModularJet]]]()
    for seed in range(ATTEMPTS):
        jets = ModularJets(reader, symbols, ModularPoint(reader.field, seed))
        try:
            found.append((jets.point.prime, [jets.element(x) for x in wanted]))
        except (NoRootError, ZeroDivisionError):
            continue
        if len(found) == points:
            return found
    return None
