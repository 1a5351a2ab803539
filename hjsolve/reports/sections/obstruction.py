"""The report of a refusal: what would have to vanish, and a witness that it does not."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.arithmetic.printed_digits import shortest
from hjsolve.reports.document import Block, Formula, Inline, Mathematics, Note, Number, Paragraph, Section, Text
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import row
from hjsolve.reports.formulas.line_breaks import display
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.rounded_numbers import rounded_outward
from hjsolve.reports.sections.system_and_verdict import EQUALS
from hjsolve.separation import Obstruction, Undecided


def refusal_section(verdict: Obstruction | Undecided) -> Section:
    """Show the obstruction: residual, witness, advice.

    Args:
        verdict: an obstruction or an open question.
    """
    blocks: list[Block] = []
    if verdict.residual is not sp.nan:  # where the budget ended before there was one
        residual = Formula(display(verdict.residual), str(verdict.residual))
        blocks += [Paragraph(("The expression that would have to vanish identically:",)), residual]
    if isinstance(verdict, Obstruction):
        point = verdict.witness.point
        blocks.append(
            Paragraph(
                (
                    "Counterexample: at ",
                    *_point(point),
                    " its value provably lies between ",
                    Number(rounded_outward(verdict.witness.lower, up=False)),
                    " and ",
                    Number(rounded_outward(verdict.witness.upper, up=True)),
                    ".",
                )
            )
        )
    elif verdict.value is not None:
        value = Number(shortest(verdict.value, 40))
        blocks.append(Paragraph(("At ", *_point(verdict.point), " it is, to 40 digits, ", value, ".")))
    blocks.append(Note(typeset_prose(verdict.advice, verdict.system)))
    title = "The obstruction" if isinstance(verdict, Obstruction) else "What is left open"
    return Section("obstruction", title, tuple(blocks))


def _point(point: Mapping[str, sp.Expr]) -> Text:
    pieces: list[Inline] = []
    for i, (name, value) in enumerate(point.items()):
        pieces += ([", "] if i else []) + [Mathematics(row(name_box(name), EQUALS, box(sp.sympify(value))))]
    return tuple(pieces)
