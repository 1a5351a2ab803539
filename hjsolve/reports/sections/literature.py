"""The section of a report that says which works its labels and its entry mean."""

from __future__ import annotations

from collections.abc import Iterable

from hjsolve.catalog.bibliography import GREENWOOD, cited
from hjsolve.catalog.entry import Entry
from hjsolve.reports.document import Block, Formula, Paragraph, Section, Steps, Text


def literature_section(sections: Iterable[Section | None], entry: Entry | None) -> Section | None:
    """Give every work that the labels of the formulas or the entry name, each with its places.

    Args:
        sections: what the report says so far.
        entry: the catalog's entry, or None.

    Returns:
        The section; None where nothing is cited.
    """
    labelled = any(_labelled(block) for section in sections if section is not None for block in section.blocks)
    references = [*(entry.cite if entry is not None else ()), *([GREENWOOD] if labelled else [])]
    blocks: list[Block] = []
    for source, places in cited(references):
        own: Text = (source.name, f", {places}" if places else "", ": ", source.written)
        if source.key == GREENWOOD and labelled:
            own = (*own, " The labels at the formulas are its equation numbers.")
        blocks.append(Paragraph(own))
    return Section("literature", "Literature", tuple(blocks)) if blocks else None


def _labelled(block: Block) -> bool:
    match block:
        case Formula(tag=tag):
            return tag.startswith("Greenwood")
        case Steps(items):
            return any(step.formula is not None and step.formula.tag.startswith("Greenwood") for step in items)
    return False
