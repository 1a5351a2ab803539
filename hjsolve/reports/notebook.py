"""What a notebook shows of a value: blocks of the report that there would be about it, one line, a table, a figure."""

from __future__ import annotations

from collections.abc import Mapping
from zlib import crc32

import sympy as sp

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.measured import Measured
from hjsolve.catalog.entry import Entry
from hjsolve.coordinates.results import SeparableCoordinates
from hjsolve.coordinates.small_oscillations import NormalModes
from hjsolve.costs.table import Cost
from hjsolve.display.shown import brief, fields_of
from hjsolve.energy_momentum.energy_momentum_map import EnergyMomentumMap
from hjsolve.errors import NotConvergedError, of_kind
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.rays.families import Wavefronts
from hjsolve.reports.document import Block, Code, Figures, Inline, Mathematics, Paragraph, Section, Strong, Table, Text
from hjsolve.reports.formats.html import block_html
from hjsolve.reports.formats.stylesheet import NOTEBOOK_CSS
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections import system_and_verdict
from hjsolve.reports.sections.coordinates import found_answer, found_sections, modes_answer, modes_section
from hjsolve.reports.sections.obstruction import refusal_section
from hjsolve.reports.sections.prose import heading
from hjsolve.reports.sections.rounded_numbers import quantity
from hjsolve.reports.sections.solution import forms_section, solution_sections
from hjsolve.reports.sections.system_and_verdict import math, system_section
from hjsolve.scenes import Run
from hjsolve.separation import Obstruction, Separation, Undecided
from hjsolve.solution.quadratures import Solution

_ROOM, _MOST_ROWS, _LARGEST = 90, 18, 60


def html_of(value: object) -> str:
    """Write a value as a piece of HTML that stands alone.

    Returns:
        HTML with its style, nothing to fetch and no script.
    """
    body = "\n".join(map(block_html, blocks_of(value)))
    return f'<div class="hjsolve"><style>{NOTEBOOK_CSS}</style>\n{body}\n</div>'


def blocks_of(value: object) -> tuple[Block, ...]:
    """Choose what is shown of a value."""
    match value:
        case System():
            return (_title(value), *_of(system_section(value, {}, "")))
        case Separation():
            return (_title(value.system), _answer(value), *_of(forms_section(value)))
        case Obstruction() | Undecided():
            return (_title(value.system), _answer(value), *_of(refusal_section(value)))
        case Solution():
            return (_title(value.system), *(block for part in solution_sections(value) for block in _of(part)))
        case Motion():
            return _motion(value.as_solved)
        case SeparableCoordinates():
            return (_title(value.system), Paragraph(found_answer(value)), *_all(found_sections(value)))
        case NormalModes():
            return (_title(value.original), Paragraph(modes_answer(value)), *_of(modes_section(value)))
        case Entry() if value.system is not None:
            system = value.system
            return (_title(system), *_of(system_section(system, value.meanings, value.summary)))
        case EnergyMomentumMap():
            from hjsolve.reports.drawings.energy_momentum_figure import figure_of_map

            return (Figures((figure_of_map(value, _key("map", value)),)),)
        case Wavefronts():
            from hjsolve.reports.drawings.wavefront_figure import figure_of_wavefronts

            drawn = figure_of_wavefronts(value, _key("fronts", value))
            return (_fields(value),) if drawn is None else (Figures((drawn,)),)
        case Cost():
            from hjsolve.reports.sections.cost import cost_section

            return _of(cost_section(value))
        case Run():
            from hjsolve.reports.sections.scene import scene_document

            parts = [part for part in scene_document(value).sections if part.key in {"numbers", "path", "drift"}]
            return (Paragraph((Strong(value.scene.title or "A scene"),)), *_all(parts))
    return (_fields(value),)


def _key(kind: str, value: object) -> str:
    """Return what a drawing is called in a page that may have others: names inside drawings are those of the page."""
    return f"{kind}-{crc32(repr(value).encode()):x}"


def _title(system: System) -> Paragraph:
    title = heading(system.title, system.symbols) if system.title else "A mechanical system"
    return Paragraph((Strong(title), *(("  ", Code(system.id)) if system.id else ())))


def _answer(verdict: Separation | Obstruction | Undecided) -> Paragraph:
    return Paragraph(system_and_verdict.answer(verdict))


def _of(section: Section | None) -> tuple[Block, ...]:
    return section.blocks if section is not None else ()


def _all(sections: list[Section]) -> tuple[Block, ...]:
    return tuple(block for part in sections for block in (Paragraph((Strong(part.title),)), *part.blocks))


def _motion(motion: Motion) -> tuple[Block, ...]:
    from hjsolve.reports.drawings import orbit_paths
    from hjsolve.reports.sections.motion import numbers_section

    kinds: list[Inline] = []
    for name, kind in motion.kinds.items():
        kinds += [", " if kinds else "", Mathematics(name_box(name)), f" {kind}"]
    shown = (_title(motion.solution.system), Paragraph(tuple(kinds)), *numbers_section(motion).blocks)
    try:
        trace = orbit_paths.trace(motion)
        key = _key("orbit", (motion, trace.state))
        drawn = orbit_paths.orbit(motion, trace, key) or orbit_paths.history(motion, trace, key)
    except NotConvergedError:
        return shown
    return (*shown, Figures((drawn,)))


# ------------------------------------------------------------------------------------------------ every other value
def _fields(value: object) -> Table:
    rows = tuple(((name.replace("_", " "),), _cell(content)) for name, content in fields_of(value))
    return Table(((type(value).__name__,), ("",)), rows[:_MOST_ROWS])


def _cell(content: object) -> Text:
    if isinstance(content, sp.Basic) and content.count(sp.Basic) <= _LARGEST:
        return (math(content),)
    if hasattr(content, "value") and hasattr(content, "error") and hasattr(content, "certified"):
        return (quantity(content),)
    if isinstance(content, Mapping) and all(_is_number(x) for x in content.values()):
        pieces: list[Inline] = []
        for name, number in content.items():
            pieces += ["; " if pieces else "", Mathematics(name_box(str(name))), " = ", *_written(number)]
        return tuple(pieces)
    if isinstance(content, str):
        return (content,)
    return (Code(brief(content, _ROOM)),)


def _is_number(content: object) -> bool:
    """Return whether it is one number with its error, with a unit or without, or the two ends of a libration."""
    if isinstance(content, tuple):
        return bool(content) and all(x is None or _is_number(x) for x in content)
    if isinstance(content, Measured):
        return isinstance(content.estimate(), Estimate)
    return isinstance(content, Estimate)


def _written(content: object) -> Text:
    if isinstance(content, tuple):
        ends = [("–",) if x is None else _written(x) for x in content]
        return tuple(piece for k, end in enumerate(ends) for piece in ((" … " if k else ""), *end) if piece)
    unit = f" {content.unit}" if isinstance(content, Measured) else ""
    number = of_kind(content.estimate() if isinstance(content, Measured) else content, Estimate)
    return (quantity(number), unit) if unit else (quantity(number),)
