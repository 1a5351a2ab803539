"""The section of closed forms: by regime, the integrals done, their inverses, and what has no form and why."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.closed_form.forms import RegimeForms
from hjsolve.reports.document import Block, Code, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.layout import Glyph, row
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.system_and_verdict import equation, formula, math

_GROUPS = {
    "periods": ("Period", "T_{}"), "frequencies": ("Frequency", "Omega_{}"), "actions": ("Action", "J_{}"),
    "mean_velocities": ("Mean velocity", "v_{}"),
}  # fmt: skip


def closed_form_sections(forms: Sequence[RegimeForms]) -> list[Section]:
    """One section for each regime.

    Args:
        forms: of the solution, or of a motion.
    """
    if not forms:
        text = "No regime was found in which the motion is neither at rest nor asymptotic."
        return [Section("closed-forms", "Closed forms", (Paragraph((text,)),))]
    several = len(forms) > 1
    return [_section(form, number if several else 0) for number, form in enumerate(forms, 1)]


def _section(form: RegimeForms, number: int) -> Section:
    intro: Text = (
        "Holds for: ", *typeset_prose(form.regime.words, form.solution.system), ". Each form was differentiated back "
        "to its integrand and compared with the quadrature to 40 digits; the separated momenta are positive.",
    )  # fmt: skip
    blocks: list[Block] = [Paragraph(intro)]
    for symbol, meaning in form.where.items():
        blocks.append(Paragraph((math(symbol), *_meaning(meaning))))
    if form.time_law is not None:
        blocks.append(equation(form.time_law, "Greenwood (5-71)"))
    blocks += [formula(row(name_box(q), Glyph("(t) ", "text")), e) for q, e in form.inverse.items()]
    blocks += [equation(e, "Greenwood (5-70)") for e in form.orbit_equations.values()]
    blocks += [formula(row(name_box(q), Glyph(" along the orbit ", "text")), e) for q, e in form.orbit.items()]
    if form.characteristic_function is not None:
        blocks.append(formula(Glyph("W"), form.characteristic_function, "Greenwood (5-65)"))
    if form.energy is not None:
        blocks.append(formula(name_box("E"), form.energy))
    rows = [
        ((f"{word} of {q}",), (math(value),))
        for group, (word, _) in _GROUPS.items()
        for q, value in getattr(form, group).items()
    ]
    if rows:
        blocks.append(Table((("Quantity",), ("Closed form",)), tuple(rows), "Numbers of the motion"))
    if form.why_not:
        missing = tuple(((Code(name),), (reason,)) for name, reason in form.why_not.items())
        blocks.append(Table((("Without a form",), ("Why",)), missing, "What has no closed form"))
    suffix = f"-{number}" if number else ""
    title = f"Closed forms, regime {number}" if number else "Closed forms"
    return Section(f"closed-forms{suffix}", title, tuple(blocks))


def _meaning(meaning: object) -> Text:
    if isinstance(meaning, tuple):
        polynomial, index = meaning
        return (f": root number {index + 1}, counted upwards, of the real roots of ", math(polynomial.as_expr()))
    return (" = ", math(sp.sympify(meaning)))
