"""What an impact does, exactly: velocities, momenta, impulses, energies, budgets, and the system that goes on."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.extended.impacts import Impact
from hjsolve.mechanics.system import System
from hjsolve.reports.document import Block, Code, Mathematics, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.system_and_verdict import formula, math


def impact_section(hit: Impact, later: tuple[System, Mapping[str, Mapping[str, sp.Expr]]] | None = None) -> Section:
    """Write down an impact.

    Args:
        hit: what it does.
        later: the system in which the constraints last, and its initial data; None where there is none.
    """
    head: tuple[Text, ...] = (
        ("Coordinate",), ("Place",), ("Velocity before",), ("after",), ("Momentum before",), ("after",), ("Impulse",),
    )  # fmt: skip
    columns = (hit.q, hit.velocity_before, hit.velocity, hit.p_before, hit.p, hit.impulse)
    rows: list[tuple[Text, ...]] = []
    for n in hit.q:
        cells: list[Text] = [(math(x[n]),) for x in columns]
        rows.append(((Mathematics(name_box(n)),), *cells))
    forms = tuple(
        ((Code(text),), (math(e),), (math(λ),))
        for text, e, λ in zip(hit.forms.texts, hit.forms.restitution, hit.multipliers, strict=True)
    )
    balanced = all(x == 0 for x in hit.budget.values())
    words = "Both are balanced, exactly." if balanced else f"What is left over: {hit.budget}."
    blocks: list[Block] = [
        Table((("Constraint",), ("Restitution",), ("λ",)), forms, "Constraints and their impulses"),
        Table(head, tuple(rows), "Δq̇ = M⁻¹aᵀλ, Greenwood (3-42)"),
        Paragraph((
            "Kinetic energy before ", math(hit.kinetic_before), ", after ", math(hit.kinetic), ", lost ",
            math(hit.energy_lost), ".",
        )),
        Paragraph((f"Budgets: Δp = aᵀλ of each coordinate, and ΔT = ½ ∑Q̂ (q̇ + q̇′). {words}",)),
    ]  # fmt: skip
    if later is not None:
        system, data = later
        starts: list[tuple[Text, ...]] = []
        for n, x in {**data["q"], **data["parameters"]}.items():
            speed: Text = (math(data["velocity"][n]),) if n in data["velocity"] else ("–",)
            starts.append(((Mathematics(name_box(n)),), (math(x),), speed))
        blocks += [
            Paragraph(("Where the constraints last, the motion goes on in fewer coordinates:",)),
            formula(Glyph("T"), system.kinetic), formula(Glyph("V"), system.potential),
            *(formula(name_box(n), f) for n, f in system.eliminated),
            Table((("Name",), ("Value",), ("Velocity",)), tuple(starts), "Where it starts"),
        ]  # fmt: skip
    return Section("impact", "The impact", tuple(blocks))
