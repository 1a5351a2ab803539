"""Whether a shell separates at one energy only (conformal separation, the additive part of R-separation).

½ Σ gⁱⁱ pᵢ² + V − E = 0 separates at this one E iff there are λᵢⱼ with S_ij(gʰʰ) = λᵢⱼ gʰʰ for every h and
S_ij(V − E) = λᵢⱼ (V − E): Levi-Civita's L_ij then vanishes where H = E, not everywhere (docs/theory).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter, Products
from hjsolve.algebra.reader import Reader
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.forms.levi_civita import LeviCivitaConditions


def energy_of_separation(conditions: LeviCivitaConditions) -> Element | None:
    """Return the one energy at which the shell separates, in terms of parameters and constant momenta.

    None if none is proved.

    The caller has found that the shell does not separate at every energy.

    Args:
        conditions: of the shell with V_eff.
    """
    reader, n = conditions.reader, len(conditions.symbols)
    sieve = Filter(reader.field)
    minus = [reader.field.coerce(-1)]
    energy: Element | None = None
    if any(_cannot_hold(conditions, i, j) for i, j in combinations(range(n), 2)):
        return None
    for i, j in combinations(range(n), 2):
        λ = conditions.of_metric(i, j, i)
        for h in range(n):
            if h != i and not levi_civita.sum_vanishes(
                reader, difference(conditions.of_metric(i, j, h), λ, minus), sieve
            ):
                return None
        of_pair = _energy_of_pair(conditions, i, j, λ, sieve)
        if of_pair is None:
            return None
        if not of_pair:
            continue
        if energy is not None and not (energy - of_pair[0]).is_zero:
            return None
        energy = of_pair[0]
    return energy


def _cannot_hold(conditions: LeviCivitaConditions, i: int, j: int) -> bool:
    """Return whether random points modulo primes rule out that a pair separates at some energy."""
    if conditions.one_factor(i, j) is False:
        return True
    return bool(conditions.passes_filter(i, j, i)) and conditions.passes_filter(i, j, None) is False


def difference(a: Products, b: Products, minus: Sequence[Element]) -> Products:
    """Return the sum of products a − b.

    Args:
        a, b: sums of products.
        minus: −1 as a sum of elements.
    """
    return [*a, *([list(minus), *factors] for factors in b)]


def _energy_of_pair(
    conditions: LeviCivitaConditions, i: int, j: int, λ: Products, sieve: Filter
) -> tuple[Element] | tuple[()] | None:
    """E = V − S_ij(V)/λᵢⱼ where that is constant; () where the pair separates at every energy, None at none."""
    reader, field = conditions.reader, conditions.reader.field
    of_V = conditions.of_potential(i, j)
    if conditions.passes_filter(i, j, i) is not False and levi_civita.sum_vanishes(reader, λ, sieve):
        return () if levi_civita.sum_vanishes(reader, of_V, sieve) else None
    ratio = levi_civita.sum_of_products(reader, of_V) / levi_civita.sum_of_products(reader, λ)
    energy = field.cancelled(conditions.potential - ratio)
    if any(not _is_constant(reader, energy, conditions, k) for k in range(len(conditions.symbols))):
        return None
    return (energy,)


def _is_constant(reader: Reader, x: Element, conditions: LeviCivitaConditions, k: int) -> bool:
    return not x.depends_on(conditions.symbols[k]) or reader.diff(x, conditions.symbols[k]).is_zero
