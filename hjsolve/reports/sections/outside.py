"""The report of an entry that is not given by T and V: what was asked, why it is refused, what to do instead."""

from __future__ import annotations

from hjsolve.catalog.entry import Entry
from hjsolve.errors import required
from hjsolve.reports.document import Block, Document, Note, Paragraph, Section, Strong, Text
from hjsolve.reports.sections.constraint_forces import forces_section
from hjsolve.reports.sections.literature import literature_section
from hjsolve.reports.sections.prose import heading, with_names


def outside_document(entry: Entry) -> Document:
    """Write the report.

    Args:
        entry: with a ``refusal``.
    """
    refusal = required(entry.refusal)
    names = {name for constraint in entry.constraints for name in constraint.coordinates} - {"a"}
    names |= set(entry.stated.coordinates) if entry.stated is not None else set()
    answer: Text = (Strong("Refused"), f": {_WORDS.get(refusal.kind, refusal.kind)}.")
    blocks: list[Block] = [Paragraph(with_names(entry.summary, names))] if entry.summary else []
    if entry.stated is not None and (entry.stated.kinetic or entry.stated.summary):
        stated = entry.stated
        blocks += [Paragraph(with_names(stated.summary, names))] if stated.summary else []
        for letter, text in (("T", stated.kinetic), ("V", stated.potential)):
            blocks += [Paragraph(with_names(f"{letter} = {text}", names))] if text else []
    obstacles: list[Block] = [Paragraph(with_names(formula, names)) for formula in refusal.formulas]
    sections: list[Section] = [
        *([Section("system", "The system", tuple(blocks))] if blocks else []),
        Section(
            "obstruction", "Why it is refused",
            (Paragraph(with_names(refusal.reason, names)), *obstacles, Note(with_names(refusal.instead, names))),
        ),
    ]  # fmt: skip
    if (forces := entry.equations) is not None:
        sections.append(forces_section(forces))
    literature = literature_section(sections, entry)
    sections += [literature] if literature is not None else []
    return Document(heading(entry.title, names), entry.id, answer, tuple(sections), "no")


_WORDS = {
    "nonholonomic": "a nonholonomic constraint",
    "dissipative": "forces that dissipate energy",
    "unilateral": "a unilateral constraint",
    "impulsive": "an impulse",
    "explicit time": "T or V contains the time",
    "no Lagrangian": "there is no Lagrangian",
}
