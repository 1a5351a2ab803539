"""The section about a system with explicit time whose S is of second degree: A, B and C, and one motion."""

from __future__ import annotations

from hjsolve.arithmetic.printed_digits import shortest
from hjsolve.errors import NotConvergedError
from hjsolve.extended.explicit_time import QuadraticMotion
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.reports.document import Block, Mathematics, Number, Paragraph, Section, Table, Text
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.system_and_verdict import formula

_DIGITS, _TIMES = 10, (0, 1, 2, 3, 4)
"""Of the table of A, B and C: digits, and times after t₀."""


def quadratic_section(system: System, motion: QuadraticMotion | None = None) -> Section:
    """Tell that S is of second degree in q, and what its coefficients follow from; with a motion, their values.

    Args:
        system: whose H is of second degree in q and p, with coefficients that hold the time.
        motion: of it; None for no table.
    """
    blocks: list[Block] = [
        Paragraph(("H is of second degree in the coordinates and momenta, with coefficients that hold the time:",)),
        formula(Glyph("H"), hamiltonian(system), "Greenwood (4-109)"),
        Paragraph((
            "The Hamilton-Jacobi equation is solved by S = ½ q·A q + B·q + C. A, B and C are functions of the time; "
            "they follow from the linear equations of motion, and are integrated by Taylor series with a proved error.",
        )),
    ]  # fmt: skip
    if motion is not None:
        blocks += _coefficients(motion)
    return Section("quadratic", "A principal function of second degree", tuple(blocks))


def _coefficients(motion: QuadraticMotion) -> list[Block]:
    """Tabulate A, B, C and the place of the motion; at a time conjugate to the start S is not finite."""
    names = [c.name for c in motion.system.coordinates]
    n, rows = len(names), list[tuple[Text, ...]]()
    pairs = [(i, j) for i in range(n) for j in range(i, n)]
    for t in [motion.t0 + k for k in _TIMES]:
        state = motion.at(t)
        try:
            S = motion.coefficients(t)
            values = [*(S.A[i, j] for i, j in pairs), *S.B, S.C.value]
            numbers: list[Text] = [(Number(shortest(x, _DIGITS)),) for x in values]
        except NotConvergedError:
            numbers = [("–",)] * (len(pairs) + n + 1)
        rows.append(((str(t),), *numbers, *((Number(shortest(state.q[name], _DIGITS)),) for name in names)))
    heads: list[Text] = [("t",)]
    heads += [(f"A({names[i]}, {names[j]})",) for i, j in pairs] if n > 1 else [("A",)]
    heads += [(f"B({name})",) for name in names] if n > 1 else [("B",)]
    heads += [("C",), *((Mathematics(name_box(name)),) for name in names)]
    words = "With the initial momenta α constant, S(q, t₀) = α·q, and ∂S/∂q = A q + B is the momentum of the motion."
    return [Paragraph((words,)), Table(tuple(heads), tuple(rows), "A, B, C and the motion, to ten digits")]
