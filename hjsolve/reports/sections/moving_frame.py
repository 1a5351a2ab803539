"""The section about a system with explicit time: as it is posed, the frame that makes it autonomous, and S(q, t)."""

from __future__ import annotations

import sympy as sp

from hjsolve.extended.moving_frame import Frame
from hjsolve.mechanics.system import hamiltonian
from hjsolve.reports.document import Block, Paragraph, Section
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.prose import listed
from hjsolve.reports.sections.system_and_verdict import formula
from hjsolve.solution.quadratures import Solution


def frame_section(frame: Frame, solution: Solution | None) -> Section:
    """Tell what was posed, what it becomes and, where it is solved, Hamilton's principal function.

    Args:
        frame: the verified change.
        solution: of the autonomous system, or None.

    Returns:
        The section.
    """
    old, new = ([c.name for c in system.coordinates] for system in (frame.original, frame.system))
    blocks: list[Block] = [
        Paragraph(("As it is posed, in ", *listed(old), ", the system contains the time:")),
        formula(Glyph("T"), frame.original.kinetic),
        formula(Glyph("V"), frame.original.potential),
        formula(Glyph("H"), hamiltonian(frame.original), "Greenwood (4-109)"),
        Paragraph(("With ", *listed(new), " in place of ", *listed(old), " it does not:")),
        *(formula(name_box(name), place) for name, place in frame.place.items()),
    ]
    if frame.gauge != 0:
        words = "The two Lagrangians differ by the total time derivative of a function, which changes no motion:"
        blocks += [Paragraph((words,)), formula(Glyph("Λ"), frame.gauge)]
    if solution is not None:
        blocks += [
            Paragraph(("Hamilton's principal function of the system as posed, S = W − E t + Λ:",)),
            formula(Glyph("S"), principal_function(frame, solution)),
        ]
    return Section("frame", "The system as posed, and its frame", tuple(blocks))


def principal_function(frame: Frame, solution: Solution) -> sp.Expr:
    """S(q, t) = W(Q(q, t)) − E t + Λ(Q(q, t), t), which solves ∂S/∂t + H(q, ∂S/∂q, t) = 0.

    With L = L′ + dΛ/dt the momenta are p = ∂(S′ + Λ)/∂q, S′ = W − E t of the autonomous system (Greenwood (5-65)).

    Args:
        frame: with Q(q, t) and Λ.
        solution: of the autonomous system, with W(Q).
    """
    energy = solution.separation.shell.energy if solution.coordinates else solution.separation.shell.potential
    S = solution.characteristic_function - energy * frame.time + frame.gauge
    back = {symbol: sp.simplify(formula) for symbol, formula in frame.inverse().items()}
    return S.subs(back, simultaneous=True)
