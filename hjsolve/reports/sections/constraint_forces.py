"""Constraint forces: Lagrange's equations with multipliers, and contact that ends where a multiplier changes sign."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.coordinates.multipliers import ConstraintForces, constraint_forces
from hjsolve.errors import HJSolveError
from hjsolve.mechanics.system import System
from hjsolve.reports.document import Block, Code, Mathematics, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.system_and_verdict import equation, formula

if TYPE_CHECKING:
    from hjsolve.arithmetic.estimate import Estimate
    from hjsolve.scenes.one_sided_contact import Contact

_MOST_OPERATIONS = 150
"""Of one multiplier: a longer one fills a page, and is not read."""


def force_blocks(system: System) -> list[Block]:
    """Write down the forces of the constraints that were eliminated; nothing where there are none.

    Args:
        system: in the coordinates that are left.
    """
    if system.unconstrained is None:
        return []
    try:
        found = constraint_forces(system)
    except HJSolveError:
        return []
    if any(sp.count_ops(λ) > _MOST_OPERATIONS for λ in found.reduced):
        return [Paragraph(("The constraint forces are long; ", Code("hjsolve.constraint_forces"), " has them."))]
    return [
        Paragraph(("The constraints exert the forces λ ∂g/∂q on the coordinates without them, with",)),
        *_multipliers(found.texts, found.reduced),
    ]


def _multipliers(texts: tuple[str, ...], values: tuple[sp.Expr, ...]) -> list[Block]:
    names = [Glyph("λ") if len(texts) == 1 else name_box(f"lambda_{n}") for n in range(1, len(texts) + 1)]
    told = [Paragraph(("Of ", Code(text), ":")) for text in texts]
    shown = [formula(name, λ) for name, λ in zip(names, values, strict=True)]
    return [block for pair in zip(told, shown, strict=True) for block in pair] if len(texts) > 1 else list(shown)


def forces_section(found: ConstraintForces) -> Section:
    """Write down the equations with multipliers.

    Args:
        found: what ``constraint_forces`` returned.
    """
    blocks: list[Block] = [
        Paragraph(("Lagrange's equations with a multiplier for each constraint:",)),
        *(equation(e, "Greenwood (5-22)") for e in found.equations.values()),
        Paragraph(("The constraints hold all the time, which determines the multipliers:",)),
        *(formula(name_box(s.name), λ) for s, λ in zip(found.symbols, found.multipliers, strict=True)),
        Paragraph(("So the accelerations are",)),
        *(formula(name_box(f"ddot({name})"), f) for name, f in found.accelerations.items()),
    ]  # fmt: skip
    return Section("constraint-forces", "Constraint forces", tuple(blocks))


def contact_section(found: Contact) -> Section:
    """Write down where contact ends.

    Args:
        found: what ``contact`` returned.
    """
    blocks: list[Block] = [Paragraph(("The multiplier of each one-sided constraint, which pushes while λ > 0:",))]
    for text, λ in found.multipliers.items():
        blocks += [Paragraph((Code(text),)), formula(Glyph("λ"), λ)]
        if text in found.along:
            blocks += [Paragraph(("along the motion, in its constants:",)), formula(Glyph("λ"), found.along[text])]
    if found.time is None:
        before = "" if found.until is None else f" before t = {found.until}"
        words = (
            f"No multiplier changes its sign: contact does not end{before}." if found.proved
            else f"No change of sign was found{before} at the samples along the motion."
        )  # fmt: skip
        return Section("contact", "Contact", (*blocks, Paragraph((words,))))
    many = len(found.ended) > 1
    pieces: list[str | Code] = [p for n, x in enumerate(found.ended) for p in ((" and ", Code(x)) if n else (Code(x),))]
    earlier = (
        "That no multiplier vanishes before is proved."
        if found.proved
        else "The signs before were sampled along the motion; nothing is proved about them."
    )
    ends: Text = ("Contact ends at t = ", str(found.time), ": ", *pieces, f" let{'' if many else 's'} go. ", earlier)
    head: tuple[Text, ...] = (("Coordinate",), ("Position",), ("Velocity",))
    rows = [_row(name, x, found.velocity) for name, x in found.q.items()]
    return Section("contact", "Contact", (*blocks, Paragraph(ends), Table(head, tuple(rows), "Where contact ends")))


def _row(name: str, x: Estimate, velocity: Mapping[str, Estimate]) -> tuple[Text, ...]:
    return ((Mathematics(name_box(name)),), (str(x),), (str(velocity[name]),))
