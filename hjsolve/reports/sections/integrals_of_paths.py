"""What integrals along curves give: ∫ L dt along a path, and ∮ p dq of a closed curve of states as it moves."""

from __future__ import annotations

from hjsolve.reports.document import Block, Number, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.rounded_numbers import bound, quantity
from hjsolve.reports.sections.system_and_verdict import formula, math
from hjsolve.theorem.action_along_path import PathAction
from hjsolve.theorem.loop_integrals import LoopIntegral


def action_section(found: PathAction) -> Section:
    """Write down the Lagrangian along a path, and its integral."""
    start, stop = found.between
    blocks: list[Block] = [
        Paragraph(("Along the path",)),
        *(formula(name_box(name), f) for name, f in found.path.items()),
        Paragraph(("the Lagrangian is",)),
        formula(Glyph("L"), found.lagrangian),
        Paragraph((
            "Its integral over the time from ", math(start), " to ", math(stop), " (4-2) is ",
            quantity(found.value), ".",
        )),
    ]  # fmt: skip
    return Section("action", "The action of the path", tuple(blocks))


def loop_section(found: LoopIntegral) -> Section:
    """Write down the integral of p dq along a closed curve at several times."""
    rows: list[tuple[Text, ...]] = [
        ((f"{t:.10g}",), (Number(f"{x:.16g}"),), (bound(float(e)),))
        for t, x, e in zip(found.times, found.value, found.error, strict=True)
    ]
    words = "They agree within their errors." if found else "They do not agree within their errors."
    caption = f"Poincaré's invariant, by {found.points} motions (6-396)"
    table = Table((("t",), ("∮ ∑p dq",), ("Error",)), tuple(rows), caption)
    return Section("loop", "The loop integral", (table, Paragraph((words,))))


__all__ = ["action_section", "loop_section"]
