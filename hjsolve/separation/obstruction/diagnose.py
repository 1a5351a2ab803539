"""What else there is to say about a refusal: how far from separable, in which blocks, at which energy.

None of this changes the verdict, and all of it has a budget of its own: what does not fit into it stays unsaid.

At one energy only (conformal separation, the additive part of R-separation):
½ Σ gⁱⁱ pᵢ² + V − E = 0 separates at this one E iff there are λᵢⱼ with S_ij(gʰʰ) = λᵢⱼ gʰʰ for every h and
S_ij(V − E) = λᵢⱼ (V − E): Levi-Civita's L_ij then vanishes where H = E, not everywhere (docs/theory).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from hjsolve.algebra.field import Element
from hjsolve.algebra.modular import Filter, Products
from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.energy_shell import ReductionStep
from hjsolve.separation.forms import levi_civita
from hjsolve.separation.forms.levi_civita import LeviCivitaConditions
from hjsolve.separation.obstruction import advice
from hjsolve.separation.obstruction.blocks import finest
from hjsolve.separation.obstruction.distance import distance_from_separable
from hjsolve.separation.obstruction.obstruction import Setting
from hjsolve.separation.verdicts import Obstruction


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


SECONDS, TERMS = 0.5, 100_000


def diagnosed(found: Obstruction, setting: Setting, conditions: LeviCivitaConditions) -> Obstruction:
    """Return the obstruction with ``distance``, ``blocks`` and ``conformal``, and the words for them.

    Args:
        found: the obstruction of an orthogonal shell.
        setting: the shell as elements.
        conditions: its Levi-Civita conditions.
    """
    found = _measured(found, setting)
    field = setting.reader.field
    whole = field.budget
    for step in (_with_blocks, _with_energy):
        field.budget = whole.part(SECONDS, TERMS)
        try:
            found = step(found, setting, conditions)
        except (WorkLimitError, ZeroDivisionError):
            continue
        finally:
            field.budget = whole
    return found


def _measured(found: Obstruction, setting: Setting) -> Obstruction:
    shell = setting.shell
    distance = distance_from_separable(
        setting.symbols, shell.inverse_metric, shell.potential, found.part, setting.region
    )
    if distance is None:
        return found
    what = "inverse metric" if found.part == "metric" else "potential"
    text = (
        f"In Stäckel form, values on the coordinate lines through one point determine the {what}. Rebuilt from these "
        f"values, it has a relative error of {distance:.2g} here (median over sample points); a separable one has 0. "
        "This shows how far the system is from separable. It is not part of the proof."
    )
    return replace(found, distance=distance, evidence=(*found.evidence, ReductionStep("Distance", text)))


def _with_blocks(found: Obstruction, setting: Setting, conditions: LeviCivitaConditions) -> Obstruction:
    """Two coordinates are one block; with more, the pairs that fail are found by the filter and the rest is proved."""
    names = [c.name for c in setting.shell.coordinates]
    if len(names) == 2:
        return replace(found, blocks=(tuple(names),))
    failing = {(c.i, c.j) for c in conditions if c.passes_filter is False}
    places = {name: k for k, name in enumerate(names)}
    failing.add((places[found.pair[0]], places[found.pair[1]]))
    partition = finest(setting.reader, setting.symbols, setting.metric, setting.potential, failing)
    blocks = tuple(tuple(names[k] for k in block) for block in partition)
    return _with_words(replace(found, blocks=blocks), "Blocks", advice.about_blocks(blocks))


def _with_energy(found: Obstruction, setting: Setting, conditions: LeviCivitaConditions) -> Obstruction:
    element = energy_of_separation(conditions)
    if element is None:
        return replace(found, conformal=False)
    energy = shortest_form(setting.reader, element)
    words = advice.about_energy(found.system, energy)
    return _with_words(replace(found, conformal=True, conformal_energy=energy), "One energy", words)


def _with_words(found: Obstruction, title: str, words: str) -> Obstruction:
    if not words:
        return found
    return replace(found, advice=f"{words} {found.advice}", evidence=(*found.evidence, ReductionStep(title, words)))
