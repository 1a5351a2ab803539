"""The section about a system with explicit time: as it is posed, the frame that makes it autonomous, and S(q, t)."""

from __future__ import annotations

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
            formula(Glyph("S"), frame.principal_function(solution)),
        ]
    return Section("frame", "The system as posed, and its frame", tuple(blocks))
