"""Levi-Civita's conditions: does a Hamiltonian separate in the coordinates it is written in?

General form, any H(q, p), all i < j, identically in q and p (Levi-Civita, Math. Ann. 59 (1904) 383), with Hⁱ =
∂H/∂pᵢ, Hᵢ = ∂H/∂qᵢ:

    L_ij = Hⁱ Hʲ H_ij + Hᵢ Hⱼ Hⁱʲ − Hⁱ Hⱼ H_iʲ − Hᵢ Hʲ H_jⁱ = 0.

Orthogonal shells, H = ½ Σ gᵃᵃPₐ² + U (Eisenhart, Ann. Math. 35 (1934) 284; Benenti):

    S_ij(f) = ∂ᵢ∂ⱼf − (∂ᵢ ln gʲʲ) ∂ⱼf − (∂ⱼ ln gⁱⁱ) ∂ᵢf = 0    for f = every gʰʰ and every coefficient of U in the
    constants.

Metric conditions are taken in logarithmic form, S_ij(f)/f = ∂ᵢ∂ⱼ ln f + ∂ᵢ ln f ∂ⱼ ln f − (∂ᵢ ln gʲʲ) ∂ⱼ ln f − (∂ⱼ
ln gⁱⁱ) ∂ᵢ ln f: a metric that is a product then needs only small fractions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.algebra import poly
from hjsolve.algebra.element_jets import ElementJet, ElementJets, at_random_points
from hjsolve.algebra.element_point import Value
from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter, Products
from hjsolve.algebra.poly import Poly
from hjsolve.algebra.readable import printed_length
from hjsolve.algebra.reader import Reader

Sum = list[Element]


@dataclass(frozen=True)
class Condition:
    """One condition that must vanish identically.

    Attributes:
        i: position of the first coordinate.
        j: position of the second.
        part: ``metric`` or ``potential``.
        about: position h for the condition on gʰʰ, or None for the potential.
        owner: the conditions it is one of.
    """

    i: int
    j: int
    part: str
    about: int | None
    owner: LeviCivitaConditions

    @cached_property
    def products(self) -> Products:
        """The condition as a sum of products of sums of elements; nothing is multiplied out but derivatives."""
        if self.about is None:
            return self.owner.of_potential(self.i, self.j)
        return self.owner.of_metric(self.i, self.j, self.about)

    @property
    def scale(self) -> Element:
        """The element the sum has been divided by (gʰʰ), to give S_ij itself back."""
        return self.owner.reader.field.one if self.about is None else self.owner.metric[self.about]

    @property
    def passes_filter(self) -> bool | None:
        """Whether it holds at random points modulo primes; False shows that no normal form is zero, None nothing."""
        return self.owner.passes_filter(self.i, self.j, self.about)


class LeviCivitaConditions:
    """The conditions of an orthogonal shell; derivatives are taken when they are asked for, and once.

    In its methods i and j are positions of two coordinates.

    Args:
        reader: reads and differentiates.
        symbols: essential coordinates.
        metric: gᵃᵃ, one element per coordinate.
        potential: U or V_eff; the constants in it are generators, so that vanishing means vanishing coefficient by
            coefficient.
    """

    def __init__(self, reader: Reader, symbols: Sequence[sp.Symbol], metric: Sequence[Element], potential: Element):
        self.reader, self.symbols, self.metric, self.potential = reader, symbols, metric, potential
        self.minus = [reader.field.coerce(-1)]

    def __iter__(self) -> Iterator[Condition]:
        """Metric conditions of all pairs first, then those of the potential."""
        n = len(self.symbols)
        pairs = [(i, j) for j in range(n) for i in range(j)]
        for i, j in pairs:
            for h in range(n):
                yield Condition(i, j, "metric", h, self)
        for i, j in pairs:
            yield Condition(i, j, "potential", None, self)

    @cached_property
    def log(self) -> list[list[Sum]]:
        """∂ᵢ ln gʰʰ, by h and i."""
        return [[self.reader.log_diff_terms(g, q) for q in self.symbols] for g in self.metric]

    @cached_property
    def slope(self) -> list[Sum]:
        """∂ᵢU."""
        return [self.reader.diff_terms(self.potential, q) for q in self.symbols]

    @cached_property
    def _jets(self) -> list[tuple[ElementJets, list[ElementJet], ElementJet]] | None:
        """Jets of ln gᵃᵃ and of U at random points."""
        found = at_random_points(self.reader, self.symbols, [*self.metric, self.potential])
        if found is None:
            return None
        return [(jets, [jets.logarithm(x) for x in metric], potential) for jets, (*metric, potential) in found]

    def passes_filter(self, i: int, j: int, about: int | None) -> bool | None:
        """Return whether S_ij(gʰʰ), or S_ij(U) where ``about`` is None, vanishes at random points modulo primes.

        None when no point could be found.

        Args:
            about: h, or None for the potential.
        """
        if self._jets is None:
            return None
        return not any(self._value(i, j, about, *place) for place in self._jets)

    def one_factor(self, i: int, j: int) -> bool | None:
        """Return whether S_ij(gʰʰ)/gʰʰ is the same for every h at random points modulo primes; None for no points."""
        if self._jets is None:
            return None
        n = range(len(self.symbols))
        return all(len({self._value(i, j, h, *place) for h in n}) == 1 for place in self._jets)

    def _value(
        self, i: int, j: int, about: int | None, jets: ElementJets, log: Sequence[ElementJet], potential: ElementJet
    ) -> Value:
        f = potential if about is None else log[about]
        square = 0 if about is None else f.slopes[i] * f.slopes[j]
        return jets.point.reduced(condition_of_jets(f, log[i], log[j], i, j) + square)

    def holds(self, condition: Condition, sieve: Filter) -> bool:
        """Return a proof that a condition holds; False is not a proof of the opposite.

        Args:
            condition: one of these.
            sieve: the modular filter of the field.
        """
        return condition.passes_filter is not False and sum_vanishes(self.reader, condition.products, sieve)

    def of_metric(self, i: int, j: int, h: int) -> Products:
        """S_ij(gʰʰ)/gʰʰ.

        Args:
            h: position of the entry of the inverse metric.
        """
        log, minus = self.log, self.minus
        mixed = [self._again(log[h][i], j)]
        if h == i:
            return [mixed, [minus, log[j][i], log[i][j]]]
        if h == j:
            return [mixed, [minus, log[i][j], log[j][i]]]
        return [mixed, [log[h][i], log[h][j]], [minus, log[j][i], log[h][j]], [minus, log[i][j], log[h][i]]]

    def of_potential(self, i: int, j: int) -> Products:
        """S_ij(U)."""
        mixed = [self._again(self.slope[i], j)]
        return [mixed, [self.minus, self.log[j][i], self.slope[j]], [self.minus, self.log[i][j], self.slope[i]]]

    def _again(self, terms: Sum, j: int) -> Sum:
        """Return the derivative of a sum with respect to coordinate j, as a sum."""
        return [y for x in terms for y in self.reader.diff_terms(x, self.symbols[j])]


def sum_vanishes(reader: Reader, products: Products, sieve: Filter) -> bool:
    """Return a proof that a sum of products is zero: the modular filter, then the exact normal form.

    False is not a proof of the opposite.

    Args:
        products: Σ Π Σ of elements.
        sieve: the modular filter of the field.
    """
    return sieve.vanishes(products) is not False and sum_of_products(reader, products).is_zero


def sum_of_products(reader: Reader, products: Products) -> Element:
    """Return the sum of products of sums as one element."""
    field = reader.field
    return field.total(field.product([field.total(elements) for elements in factors]) for factors in products)


def condition_of_jets(f: ElementJet, log_i: ElementJet, log_j: ElementJet, i: int, j: int) -> Value:
    """Return S_ij(f) = ∂ᵢ∂ⱼf − (∂ᵢ ln gʲʲ) ∂ⱼf − (∂ⱼ ln gⁱⁱ) ∂ᵢf at a point.

    Args:
        f: gʰʰ, or the potential.
        log_i, log_j: ln gⁱⁱ and ln gʲʲ.
        i, j: positions of the two coordinates.
    """
    return f.mixed[i, j] - log_j.slopes[i] * f.slopes[j] - log_i.slopes[j] * f.slopes[i]


def general_condition(
    reader: Reader, hamiltonian: Element, q: Sequence[sp.Symbol], p: Sequence[sp.Symbol], i: int, j: int
) -> Products:
    """L_ij of any Hamiltonian, as a sum of four products (Levi-Civita 1904).

    Greenwood gives no such test, see p. 208.

    Args:
        hamiltonian: H(q, p) as an element.
        q, p: symbols of the essential coordinates and of their momenta.
        i, j: positions of the two coordinates.
    """
    d = reader.diff
    hi, hj = d(hamiltonian, q[i]), d(hamiltonian, q[j])
    ui, uj = d(hamiltonian, p[i]), d(hamiltonian, p[j])
    return [
        [[ui], [uj], [d(hi, q[j])]],
        [[hi], [hj], [d(ui, p[j])]],
        [[-ui], [hj], [d(hi, p[j])]],
        [[-hi], [uj], [d(hj, p[i])]],
    ]


def general_condition_of_jets(h: ElementJet) -> Value:
    """Return L_ij at a point.

    Args:
        h: the Hamiltonian, by qᵢ, qⱼ, pᵢ and pⱼ.
    """
    hi, hj, ui, uj = (h.slopes[k] for k in range(4))
    return ui * uj * h.mixed[0, 1] + hi * hj * h.mixed[2, 3] - ui * hj * h.mixed[0, 3] - hi * uj * h.mixed[1, 2]


def coefficients(reader: Reader, x: Element, symbols: Sequence[sp.Symbol]) -> list[Element]:
    """Return the coefficients of a polynomial in some symbols, cheapest first.

    The element itself if a denominator holds them.

    Args:
        symbols: its variables; everything else counts as a coefficient.
    """
    field = reader.field
    numbers = {k for s in symbols if (k := field.number_of(s)) is not None}
    holding = [(b, e) for b, e in x.factors.items() if numbers & set(poly.generators(field.bases[b]))]
    if any(e < 0 for _, e in holding):
        return [x]
    numerator = x.numerator
    for b, e in holding:
        for _ in range(e):
            numerator = field.reduce(poly.mul(numerator, field.bases[b], field.budget))
    groups: dict[int, Poly] = {}
    for m, c in numerator.items():
        inner = sum(e << (poly.BITS * k) for k, e in poly.exponents(m) if k in numbers)
        groups.setdefault(inner, {})[m - inner] = c
    kept = {b: e for b, e in x.factors.items() if (b, e) not in holding}
    found = [field.cancelled(field.from_poly(a, x.coefficient, kept)) for a in groups.values()]
    return sorted(found, key=printed_length)
