"""The section about a system with explicit time: as it is posed, the frame that makes it autonomous, and S(q, t)."""

from __future__ import annotations

from hjsolve.extended.moving_frame import Frame
from hjsolve.mechanics.system import System, hamiltonian
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
            formula(Glyph("S"), frame.principal_function(solution)),
        ]
    return Section("frame", "The system as posed, and its frame", tuple(blocks))


def quadratic_section(system: System) -> Section:
    """Tell that S is of second degree in q, and what its coefficients follow from.

    Args:
        system: whose H is of second degree in q and p, with coefficients that hold the time.
    """
    blocks: list[Block] = [
        Paragraph(("H is of second degree in the coordinates and momenta, with coefficients that hold the time:",)),
        formula(Glyph("H"), hamiltonian(system), "Greenwood (4-109)"),
        Paragraph((
            "The Hamilton-Jacobi equation is solved by S = ½ q·A q + B·q + C. A, B and C are functions of the time; "
            "they follow from the linear equations of motion, and are integrated by Taylor series with a proved error.",
        )),
    ]  # fmt: skip
    return Section("quadratic", "A principal function of second degree", tuple(blocks))
