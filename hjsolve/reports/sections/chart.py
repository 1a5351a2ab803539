"""The section that says in which coordinates a system was solved that does not separate in its own."""

from __future__ import annotations

from hjsolve.coordinates.chart import Chart
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Block, Note, Paragraph, Section
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.resonances import frequency_relations
from hjsolve.reports.sections.system_and_verdict import formula


def chart_section(chart: Chart, motion: Motion | None = None) -> Section:
    """Tell the system as given, why these coordinates, and the user's coordinates in them.

    Args:
        motion: the motion reported, whose frequencies tell the relations that a superintegrable system has.
    """
    blocks: list[Block] = [
        Paragraph(("The system was given as",)),
        formula(Glyph("T"), chart.original.kinetic),
        formula(Glyph("V"), chart.original.potential),
        Paragraph((f"{chart.reason[:1].upper()}{chart.reason[1:]}:",)),
        *(formula(name_box(name), value) for name, value in chart.transformation.items()),
    ]
    if chart.remark:
        blocks.append(Note((chart.remark,)))
    relations = () if motion is None or chart.independent <= len(chart.coordinates) else frequency_relations(motion)
    if relations:
        blocks.append(Paragraph((f"Of this motion, to all digits known: {', '.join(relations)}.",)))
    blocks.append(
        Paragraph(
            ("Everything below is in the coordinates found. Motions are still started and reported in the given ones.",)
        )
    )
    return Section("chart", f"Coordinates found: {chart.kind}", tuple(blocks))
