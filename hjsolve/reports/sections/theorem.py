"""What the tools of the theorem answer, as sections: complete integrals, canonical maps, and what is wrong with one.

An ``answer`` is that of ``verify`` or ``canonical``.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.reports.document import (
    Block,
    Code,
    Formula,
    Mathematics,
    Note,
    Number,
    Paragraph,
    Section,
    Strong,
    Table,
    Text,
)
from hjsolve.reports.formulas.from_sympy import box
from hjsolve.reports.formulas.layout import Box, Glyph, Script
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.rounded_numbers import bound, quantity
from hjsolve.reports.sections.system_and_verdict import equation, formula, math
from hjsolve.separation import Undecided
from hjsolve.theorem.action_along_path import PathAction
from hjsolve.theorem.answers import Flaw, Proof
from hjsolve.theorem.canonical_maps import CanonicalMap
from hjsolve.theorem.complete_integral import CompleteIntegral
from hjsolve.theorem.loop_integrals import LoopIntegral
from hjsolve.theorem.own_motion import OwnMotion

_FUNCTIONS = ("F1", "F2", "F3", "F4")
_EQUATIONS = {"F1": "(6-18)", "F2": "(6-46)", "F3": "(6-52)", "F4": "(6-57)"}


def complete_integral_section(answer: CompleteIntegral) -> Section:
    """Write down what follows from a complete integral: the determinant, the momenta, Jacobi's equations."""
    blocks: list[Block] = [
        Paragraph(("The Hamilton-Jacobi equation holds identically. With the principal function",)),
        formula(Glyph("S"), answer.principal_function, "Greenwood (5-52)"),
        Paragraph(("the determinant of ∂²S/∂q ∂α is not identically zero, so that the constants are independent:",)),
        Formula(box(answer.determinant), str(answer.determinant), "Greenwood (5-48)"),
        Paragraph(("The momenta:" if answer.momenta else "The places, q = −∂F₄/∂p:",)),
        *(formula(name_box(f"p_{name}"), p, "Greenwood (5-50)") for name, p in answer.momenta.items()),
        *(formula(name_box(name), q, "Greenwood (6-57)") for name, q in answer.places.items()),
        Paragraph(("Jacobi's equations, which give the motion:",)),
        *(equation(relation, "Greenwood (5-54)") for relation in answer.equations.values()),
    ]
    return Section("complete-integral", "A complete integral", tuple(blocks))


def canonical_section(answer: CanonicalMap) -> Section:
    """Write down a canonical map: its valence, the exact differential, generating functions, K."""
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


def brackets_section(brackets: Mapping[tuple[str, str], sp.Expr]) -> Section:
    """Write down Poisson brackets.

    Args:
        brackets: the two functions, as they were typed → their bracket.
    """
    rows = tuple(((Code(f),), (Code(g),), (math(value),)) for (f, g), value in brackets.items())
    table = Table((("f",), ("g",), ("(f, g)",)), rows, "Poisson brackets, Greenwood (6-212)")
    return Section("brackets", "Brackets", (table,))


def integrals_section(
    answers: Mapping[str, Proof | Flaw | Undecided], together: Proof | Flaw | Undecided | None = None
) -> Section:
    """Say of functions whether they are integrals of the motion, (f, H) + ∂f/∂t = 0.

    Args:
        answers: function, as it was typed → what was decided.
        together: whether they are in involution; None where that was not asked.
    """
    words = {"Proof": "an integral of the motion", "Flaw": "not an integral", "Undecided": "not decided"}
    rows = tuple(((Code(f),), (words[type(a).__name__],)) for f, a in answers.items())
    blocks: list[Block] = [Table((("f",), ("Is it?",)), rows, "(f, H) + ∂f/∂t = 0, Greenwood (6-235)")]
    for f, a in answers.items():
        if isinstance(a, Flaw) and a.witness is not None:
            blocks += [
                Paragraph((Code(f), " changes at the rate",)), Formula(box(a.residual), str(a.residual)),
                Note(_witness(a.witness.point, a.witness.lower, a.witness.upper)),
            ]  # fmt: skip
        elif isinstance(a, Undecided):
            blocks += [Paragraph((Code(f), ":")), *undecided_section(a).blocks]
    if together is not None:
        sentences = {
            "Proof": "Every two of them have the bracket 0: they are in involution (6-236).",
            "Flaw": f"They are not in involution: {getattr(together, 'statement', '')}.",
            "Undecided": "Whether they are in involution was not decided.",
        }
        blocks.append(Paragraph((sentences[type(together).__name__],)))
    return Section("integrals", "Integrals of the motion", tuple(blocks))


def own_coordinates_section(place: Mapping[str, str]) -> Section:
    """Say what was proved about coordinates that were typed.

    Args:
        place: old coordinate → its formula in the new ones, as it was typed.
    """
    rows = tuple(((Mathematics(name_box(q)),), (Code(f),)) for q, f in place.items())
    words = (
        "The Jacobian |∂q/∂Q| keeps its sign on the whole domain of the new coordinates, and the old ones stay in "
        "theirs. Both are proved."
    )
    blocks: tuple[Block, ...] = (Table((("q",), ("f(Q)",)), rows), Paragraph((words,)))
    return Section("your-coordinates", "Coordinates of your own", blocks)


def own_motion_section(answer: OwnMotion | Undecided) -> Section:
    """Say how a complete integral compares with the motion that quadratures give.

    Args:
        answer: of ``CompleteIntegral.along``.
    """
    title = "Your constants, and the motion"
    if isinstance(answer, Undecided):
        return Section("own-motion", title, undecided_section(answer).blocks)
    constants = tuple(((Mathematics(name_box(n)),), (quantity(x),)) for n, x in answer.constants.items())
    rows = tuple(
        ((Mathematics(name_box(n)),), (Number(f"{x:.2g}"),), (Number(f"{answer.errors[n]:.2g}"),))
        for n, x in answer.deviations.items()
    )
    head: tuple[Text, ...] = (("Of",), ("Deviation",), ("Explained by errors",))
    return Section("own-motion", title, (
        Paragraph((str(answer),)), Table((("Constant",), ("Value",)), constants, "From p = ∂S/∂q, (5-50)"),
        Table(head, rows, "Jacobi's equations (5-54) along the motion"),
    ))  # fmt: skip


def flaw_section(answer: Flaw) -> Section:
    """Say what fails, with the expression that is not zero and the point that shows it."""
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
    """Give the answer in one sentence."""
    if isinstance(answer, CompleteIntegral):
        return (Strong("Yes"), ": a complete integral.")
    if isinstance(answer, CanonicalMap):
        return (Strong("Yes"), ": canonical, with the valence ", math(answer.valence), ".")
    if isinstance(answer, Flaw):
        return (Strong("No"), f": {_sentence(answer.statement)}")
    return (Strong("Not decided"), ".")


def theorem_section(answer: CompleteIntegral | CanonicalMap | Flaw | Undecided) -> Section:
    """Give the section of an answer."""
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
