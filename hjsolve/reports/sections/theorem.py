"""What the tools of the theorem answer, as sections: complete integrals, canonical maps, and what is wrong with one."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.reports.document import Block, Formula, Mathematics, Note, Paragraph, Section, Strong, Table, Text
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Box, Glyph, Script
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.system_and_verdict import equation, formula, math
from hjsolve.separation import Undecided
from hjsolve.theorem.answers import Flaw
from hjsolve.theorem.canonical_maps import CanonicalMap
from hjsolve.theorem.complete_integral import CompleteIntegral

_FUNCTIONS = ("F1", "F2", "F3", "F4")
_EQUATIONS = {"F1": "(6-18)", "F2": "(6-46)", "F3": "(6-52)", "F4": "(6-57)"}


def complete_integral_section(answer: CompleteIntegral) -> Section:
    """Write down what follows from a complete integral: the determinant, the momenta, Jacobi's equations.

    Args:
        answer: proved.
    """
    blocks: list[Block] = [
        Paragraph(("The Hamilton-Jacobi equation holds identically. With the principal function",)),
        formula(Glyph("S"), answer.principal_function, "Greenwood (5-52)"),
        Paragraph(("the determinant of ∂²S/∂q ∂α is not identically zero, so that the constants are independent:",)),
        Formula(box(answer.determinant), str(answer.determinant), "Greenwood (5-48)"),
        Paragraph(("The momenta:",)),
        *(formula(name_box(f"p_{name}"), p, "Greenwood (5-50)") for name, p in answer.momenta.items()),
        Paragraph(("Jacobi's equations, which give the motion:",)),
        *(equation(relation, "Greenwood (5-54)") for relation in answer.equations.values()),
    ]
    return Section("complete-integral", "A complete integral", tuple(blocks))


def canonical_section(answer: CanonicalMap) -> Section:
    """Write down a canonical map: its valence, the exact differential, generating functions, K.

    Args:
        answer: proved.
    """
    μ, ψ = Glyph("μ"), Glyph("ψ")
    blocks: list[Block] = [
        Paragraph(("The map",)),
        *(formula(name_box(name), f) for name, f in answer.map.items()),
        Paragraph(("has the brackets of a canonical map, with the valence",)),
        formula(μ, answer.valence, "Greenwood (6-277)"),
        Paragraph(("The differential μ ∑p dq − ∑P dQ at fixed time is that of",)),
        formula(ψ, answer.psi, "Greenwood (6-23)"),
    ]
    if answer.generating:
        blocks.append(Paragraph(("Generating functions, each verified by its own equations:",)))
        for name, function in answer.generating.items():
            blocks.append(formula(_indexed(name), function, f"Greenwood {_EQUATIONS[name]}"))
            where = answer.where.get(name, "")
            blocks += [Note((Mathematics(_indexed(name)), f": verified where {where}."))] if where else []
    rows = tuple(((Mathematics(_indexed(n)),), (answer.why_not[n],)) for n in _FUNCTIONS if n in answer.why_not)
    if rows:
        blocks.append(Table((("Function",), ("Why there is none",)), rows, "Generating functions not given"))
    if answer.hamiltonian is not None:
        blocks += [Paragraph(("The new Hamiltonian, in the old variables:",)), formula(Glyph("K"), answer.hamiltonian)]
    elif answer.added_hamiltonian != 0:
        blocks += [Paragraph(("The map moves; the new Hamiltonian is K = μH + k with",)),
                   formula(Glyph("k"), answer.added_hamiltonian, "Greenwood (6-26)")]  # fmt: skip
    return Section("canonical", "A canonical map", tuple(blocks))


def flaw_section(answer: Flaw) -> Section:
    """Say what fails, with the expression that is not zero and the point that shows it.

    Args:
        answer: the refutation.
    """
    blocks: list[Block] = [Paragraph((_sentence(answer.statement),))]
    if answer.witness is not None:
        blocks += [Paragraph(("This ought to vanish:",)), Formula(box(answer.residual), str(answer.residual))]
        blocks.append(Note(_witness(answer.witness.point, answer.witness.lower, answer.witness.upper)))
    return Section("flaw", "What fails", tuple(blocks))


def undecided_section(answer: Undecided) -> Section:
    """Say which expression was not decided, and what would help.

    Args:
        answer: without a proof.
    """
    blocks: list[Block] = [Paragraph(("Whether this vanishes was not proved, and not refuted:",))]
    if answer.residual is not None:
        blocks.append(Formula(box(answer.residual), str(answer.residual)))
    return Section("undecided", "Not decided", (*blocks, Note((_sentence(answer.advice),))))


def theorem_answer(answer: CompleteIntegral | CanonicalMap | Flaw | Undecided) -> Text:
    """Give the answer in one sentence.

    Args:
        answer: of ``verify`` or ``canonical``.
    """
    if isinstance(answer, CompleteIntegral):
        return (Strong("Yes"), ": a complete integral.")
    if isinstance(answer, CanonicalMap):
        return (Strong("Yes"), ": canonical, with the valence ", math(answer.valence), ".")
    if isinstance(answer, Flaw):
        return (Strong("No"), f": {_sentence(answer.statement)}")
    return (Strong("Not decided"), ".")


def theorem_section(answer: CompleteIntegral | CanonicalMap | Flaw | Undecided) -> Section:
    """Give the section of an answer.

    Args:
        answer: of ``verify`` or ``canonical``.
    """
    if isinstance(answer, CompleteIntegral):
        return complete_integral_section(answer)
    if isinstance(answer, CanonicalMap):
        return canonical_section(answer)
    return flaw_section(answer) if isinstance(answer, Flaw) else undecided_section(answer)


def _indexed(name: str) -> Box:
    return Script(Glyph(name[0]), sub=Glyph(name[1:]))


def _sentence(text: str) -> str:
    return text if text.endswith(".") else f"{text}."


def _witness(point: Mapping[str, object], lower: sp.Expr, upper: sp.Expr) -> Text:
    place = ", ".join(f"{name} = {value}" for name, value in point.items())
    where = f"at {place} " if place else ""
    return (f"A witness: {where}its value lies between {float(lower):.9g} and {float(upper):.9g}.",)


__all__ = [
    "canonical_section", "complete_integral_section", "flaw_section", "theorem_answer", "theorem_section",
    "undecided_section",
]  # fmt: skip
