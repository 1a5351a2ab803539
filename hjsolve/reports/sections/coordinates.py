"""The sections that say in which coordinates a system separates: webs found, parameter values, normal modes.

``found`` is what ``find_coordinates`` gave, ``modes`` what ``normal_modes`` gave.
"""

from __future__ import annotations

import shlex

import sympy as sp

from hjsolve.coordinates.results import ParameterValues, SeparableCoordinates, Vector, Web
from hjsolve.coordinates.small_oscillations import NormalModes
from hjsolve.mechanics.system import System
from hjsolve.reports.document import Block, Inline, Mathematics, Note, Paragraph, Section, Strong, Table, Text
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Glyph, row
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import domain_text
from hjsolve.reports.sections.system_and_verdict import EQUALS, formula, math


def found_answer(found: SeparableCoordinates) -> Text:
    """Say the result in a sentence."""
    count = found.kernel_dimension
    several = f" It has {count} quadratic integrals, including the energy."
    integrals = several if count > 1 else " The energy is its only quadratic integral." if count else ""
    if found.webs:
        kinds = ", ".join(web.kind for web in found.webs)
        number = f"{len(found.webs)} orthogonal coordinate system{'s' * (len(found.webs) > 1)}"
        return (Strong("Separates"), f" in {number}: {kinds}.", integrals)
    if found.undecided:
        return (Strong("Not decided"), found.undecided.removeprefix("Not decided"), integrals)
    return (Strong("No orthogonal coordinates"), " were found in which it separates.", integrals)


def found_sections(found: SeparableCoordinates) -> list[Section]:
    """Describe each web with its system, then what else was found.

    Returns:
        A section for every web, and one of remarks.
    """
    sections = [_web_section(index, web) for index, web in enumerate(found.webs, 1)]
    listed = {str(web) for web in found.webs}
    lines = [line.removeprefix("- ").removesuffix(" (not certified)") for line in found.advice.splitlines()]
    listed |= set() if found.webs else {found.undecided}
    rest = [line for line in lines if line not in listed and not line.startswith(("Separates in", "At "))]
    blocks: list[Block] = [Note((line,)) for line in rest]
    if found.special:
        blocks.append(_special(found.special))
    if blocks:
        sections.append(Section("more", "What else there is to say", tuple(blocks)))
    return sections


def _web_section(index: int, web: Web) -> Section:
    what = {True: "certified: it separates", False: "not certified; see `hjsolve check` of the system below"}
    where: list[tuple[Text, ...]] = [(("Centre",), _vectors((web.centre,)))] if web.kind != "cartesian" else []
    where.append((("Axes",), _vectors(web.axes)))
    if web.foci:
        where.append((("Foci",), _vectors(web.foci)))
    where += [((f"Length {name}",), (math(value),)) for name, value in web.lengths.items()]
    where.append((("Verdict",), (what[web.certified],)))
    blocks: list[Block] = [Table((("Where",), ("",)), tuple(where))]
    if web.family:
        free = f"One of a family with {web.freedom} free parameter{'s' * (web.freedom > 1)}: {web.family}."
        blocks.append(Paragraph((free,)))
    if web.remark:
        blocks.append(Note((web.remark,)))
    blocks += [formula(name_box(name), value) for name, value in web.transformation.items()]
    return Section(f"web-{index}", f"{index}. {web.kind.capitalize()} coordinates", (*blocks, *_system(web.system)))


def _system(system: System) -> tuple[Block, ...]:
    """T and V in the new coordinates, and their domains."""
    cells = tuple(((math(c.symbol),), domain_text(c.domain, c.name)) for c in system.coordinates)
    return (
        Table((("New coordinate",), ("Domain",)), cells),
        formula(Glyph("T"), system.kinetic),
        formula(Glyph("V"), system.potential),
    )


def command(system: System) -> str:
    """Write the command line that solves a system of one's own.

    Args:
        system: a system with names that a user may write.

    Returns:
        One line for a shell.
    """
    words = ["hjsolve", "solve"]
    for c in system.coordinates:
        words += ["--coordinate", f"{c.name}: {c.domain.written(c.name)}"]
    words += ["-T", str(system.kinetic), "-V", str(system.potential)]
    for p in system.parameters:
        words += ["--parameter", p.name if p.value is None else f"{p.name}={p.value}"]
    return shlex.join(words)


def _special(values: tuple[ParameterValues, ...]) -> Table:
    rows: list[tuple[Text, ...]] = []
    for value in values:
        where: list[Inline] = []
        for name, e in value.conditions.items():
            where += [*([", "] if where else []), Mathematics(row(name_box(name), EQUALS, box(e)))]
        rows.append((tuple(where), (str(value.kernel_dimension),)))
    header: tuple[Text, ...] = (("Parameters",), ("Quadratic integrals",))
    return Table(header, tuple(rows), "Values of the parameters at which there are more")


def _vectors(vectors: tuple[Vector, ...]) -> Text:
    pieces: list[Inline] = []
    for vector in vectors:
        pieces += [*([", "] if pieces else []), math(sp.Tuple(*map(sp.sympify, vector)))]
    return tuple(pieces)


def modes_answer(modes: NormalModes) -> Text:
    """Say in a sentence that a system separates in its normal modes."""
    return (Strong("Separates"), f" in its {len(modes.modes)} normal modes.")


def modes_section(modes: NormalModes) -> Section:
    """Describe the normal modes of a system."""
    header: tuple[Text, ...] = (("Mode",), ("Frequency squared",), ("Kind",))
    rows = tuple(
        ((Mathematics(name_box(mode.name)),), (math(mode.frequency_squared),), (mode.kind,)) for mode in modes.modes
    )
    remark: list[Block] = [Paragraph((f"The system {modes.remark}.",))] if modes.remark else []
    change = [formula(name_box(name), value) for name, value in modes.transformation.items()]
    return Section("modes", "Normal modes", (*remark, Table(header, rows), *change, *_system(modes.system)))
