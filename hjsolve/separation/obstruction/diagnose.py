"""What else there is to say about a refusal: how far from separable, in which blocks, at which energy.

None of this changes the verdict, and all of it has a budget of its own: what does not fit into it stays unsaid.
"""

from __future__ import annotations

from dataclasses import replace

from hjsolve.algebra.poly import WorkLimitError
from hjsolve.algebra.readable import shortest_form
from hjsolve.mechanics.energy_shell import ReductionStep
from hjsolve.separation.forms.levi_civita import LeviCivitaConditions
from hjsolve.separation.obstruction import advice
from hjsolve.separation.obstruction.blocks import finest
from hjsolve.separation.obstruction.distance import distance_from_separable
from hjsolve.separation.obstruction.obstruction import Setting
from hjsolve.separation.obstruction.one_energy import energy_of_separation
from hjsolve.separation.verdicts import Obstruction

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
