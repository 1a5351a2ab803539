"""The report of a Hamiltonian H = a(q) p + b(q): what was given, its solution, one motion with numbers.

``summary`` is what the catalog says about a problem, ``meanings`` coordinate → (unit, meaning); both may be empty.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve.catalog.entry import Entry
from hjsolve.extended.linear_hamiltonian import LinearHamiltonian
from hjsolve.reports.document import Block, Document, Mathematics, Note, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Glyph, Script, row
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.literature import literature_section
from hjsolve.reports.sections.prose import domain_text, typeset_prose
from hjsolve.reports.sections.system_and_verdict import EQUALS, formula, math

if TYPE_CHECKING:
    from hjsolve.extended.linear_hamiltonian_motion import LinearMotion

_SHOWN = 9


def hamiltonian_answer(problem: LinearHamiltonian) -> Text:
    """Say in one sentence what the verdict is."""
    q = Mathematics(name_box(problem.coordinate.name))
    return (
        "Separates: ", q, " is the only coordinate, and H is linear in its momentum, so H = E gives the momentum "
        "without a root: one branch, no turning point.",
    )  # fmt: skip


def given_section(problem: LinearHamiltonian, meanings: Mapping[str, tuple[str, str]], summary: str) -> Section:
    """Write down what was given."""
    c = problem.coordinate
    unit, meaning = meanings.get(c.name, ("", ""))
    blocks: list[Block] = [Paragraph(typeset_prose(summary, problem))] if summary else []
    blocks.append(formula(Glyph("H"), problem.hamiltonian))
    cells: tuple[Text, ...] = ((Mathematics(name_box(c.name)),), domain_text(c.domain, c.name))
    blocks.append(
        Table(
            (("Coordinate",), ("Domain",), ("Meaning",), ("Unit",)), ((*cells, (meaning or "–",), (unit or "–",)),),
            "The coordinate",
        )
    )  # fmt: skip
    if problem.parameters:
        rows = tuple(
            ((Mathematics(name_box(p.name)),), ("no default",) if p.value is None else (math(p.value),), (p.meaning,))
            for p in problem.parameters
        )
        blocks.append(Table((("Parameter",), ("Default",), ("Meaning",)), rows, "Parameters"))
    return Section("system", "The system", tuple(blocks))


def hamiltonian_solution_sections(problem: LinearHamiltonian) -> list[Section]:
    """Give p(q; E), W and S, and the time law."""
    name = problem.coordinate.name
    E = Glyph("E")
    functions = (
        Paragraph(("H = E is solved for the momentum; its integral is Hamilton's characteristic function W, and "
                   "S = W − E t solves the Hamilton-Jacobi equation:",)),
        formula(name_box(f"p_{name}"), problem.momentum),
        formula(Glyph("W"), problem.characteristic_function, "Greenwood (5-65)"),
        formula(Glyph("S"), problem.principal_function, "Greenwood P5-1"),
    )  # fmt: skip
    difference = row(Glyph("t"), Glyph("−", "operator"), Script(Glyph("β"), E))
    rate = Glyph("0") if problem.rate == 0 else box(problem.rate)
    law = (
        Paragraph(("The derivative of W by E. ", Mathematics(row(name_box(f"dot({name})"), EQUALS, rate)),
                   " never changes its sign on the way.")),
        formula(difference, problem.time_law, "Greenwood (5-71)"),
    )  # fmt: skip
    return [
        Section("characteristic-function", "Hamilton's characteristic function", functions),
        Section("time-law", "Time law", law),
    ]


def hamiltonian_motion_section(motion: LinearMotion, summary: str) -> Section:
    """Give the energy of one motion and where it is at some times, each number with its error.

    Args:
        motion: the one described.
        summary: what the catalog says about it.
    """
    from hjsolve.arithmetic.estimate import Estimate
    from hjsolve.reports.sections.rounded_numbers import HOW_NUMBERS_ARE_PRINTED, quantity

    c = motion.problem.coordinate
    description: Text = (": ", *typeset_prose(summary, motion.problem)) if summary else ()
    times = [motion.t0 + sp.Rational(k, 2) for k in range(_SHOWN)]
    rows: list[tuple[Text, ...]] = []
    for t in times:
        state = motion.at(t)
        if state.status != "ok":
            break
        numbers = (Estimate(state.q[c.name], state.error.q[c.name]), Estimate(state.p[c.name], state.error.p[c.name]))
        rows.append(((math(t),), *((quantity(x),) for x in numbers)))
    header: tuple[Text, ...] = (
        (Mathematics(Glyph("t")),), (Mathematics(name_box(c.name)),), (Mathematics(name_box(f"p_{c.name}")),),
    )  # fmt: skip
    blocks: list[Block] = [
        Paragraph(("One motion, as an example", *description, ". Its kind: ", motion.kinds[c.name], ".")),
        Table((("Constant",), ("Value",)), (((Mathematics(Glyph("E")),), (quantity(motion.constants["E"]),)),),
              "Constants of the motion"),
        Table(header, tuple(rows), "Where it is" + ("" if len(rows) == len(times) else ", until it leaves its domain")),
        Note((HOW_NUMBERS_ARE_PRINTED,)),
    ]  # fmt: skip
    return Section("numbers", "Results with error bounds", tuple(blocks))


def hamiltonian_document(
    problem: LinearHamiltonian, meanings: Mapping[str, tuple[str, str]], summary: str, motion: LinearMotion | None,
    about: str = "", entry: Entry | None = None,
) -> Document:  # fmt: skip
    """Write the report.

    Args:
        motion: one motion of it, or None.
        about: what the catalog says about that motion.
        entry: of the catalog, whose literature is given; or None.
    """
    sections = [given_section(problem, meanings, summary), *hamiltonian_solution_sections(problem)]
    if motion is not None:
        sections.append(hamiltonian_motion_section(motion, about))
    literature = literature_section(sections, entry)
    sections += [literature] if literature is not None else []
    title = problem.title or "A Hamiltonian of one degree of freedom"
    return Document(title, problem.id, hamiltonian_answer(problem), tuple(sections), "yes")
