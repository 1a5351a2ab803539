"""What is reported of a system that does not separate beyond the obstruction: other coordinates, and how it moves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from hjsolve.coordinates.find import find_coordinates
from hjsolve.errors import HJSolveError
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import read_phase_point
from hjsolve.reports.document import Block, Code, Figures, Inline, Note, Number, Paragraph, Section
from hjsolve.reports.drawings.refused_figures import contour_figure, section_figure
from hjsolve.reports.sections.coordinates import found_answer, found_sections
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.rounded_numbers import bound
from hjsolve.scenes.surface_of_section import (
    AGREEMENT,
    TOLERANCES,
    SurfaceOfSection,
    path,
    plane_motion,
    surface_of_section,
)


def other_coordinates(system: System) -> Section:
    """Say what ``hjsolve coordinates`` answers.

    Args:
        system: one that does not separate as it is given.
    """
    blocks: list[Block]
    try:
        found = find_coordinates(system)
    except HJSolveError as error:
        asked = " ".join(str(error).removeprefix("find_coordinates: ").split())
        prose = typeset_prose(f"Not looked for: {asked}{'' if asked.endswith('.') else '.'}", system)
        blocks = [Paragraph(prose)]
        return Section("coordinates", "In which coordinates would it separate?", tuple(blocks))
    blocks = [Paragraph(found_answer(found))]
    for part in found_sections(found):
        blocks += part.blocks
    if found.webs and system.id:
        solved = Code(f"hjsolve report {system.id} --find -o out.html")
        blocks.append(Note(("The report of its solution in the first of them: ", solved, ".")))
    return Section("coordinates", "In which coordinates would it separate?", tuple(blocks))


def section_of_refused_motion(system: System, initial: Mapping[str, Any], *, returns: bool = True) -> Section | None:
    """Draw how a system moves that is not solved by quadratures, by integration with its error.

    Args:
        system: one that does not separate.
        initial: keywords of ``Solution.motion``.
        returns: whether a surface of section is drawn, which takes most of the time.

    Returns:
        The section; None where other than two coordinates are left when ignorable ones are gone, or the initial data
        do not say a place and a velocity.
    """
    if system.relativity is not None or not {"q"} < set(initial) <= {"q", "velocity", "p", "parameters", "t0"}:
        return None
    start = (initial["q"], initial.get("velocity"), initial.get("p"), initial.get("parameters"))
    plane = plane_motion(system, read_phase_point(system, *start))
    if plane is None:
        return None
    times, states = path(plane)
    if not np.isfinite(states).all() or times[-1] == 0:
        return None
    figures = [contour_figure(plane, times, states, "contours")]
    found = surface_of_section(plane) if returns else None
    E = float(plane.energy(plane.start))
    lost = float(np.max(np.abs(plane.energy(states) - E)))
    prose: list[Inline] = [
        "No quadratures are available, so the motion is integrated numerically (extrapolation, order 12). The error of "
        "each step is below ", Number(f"1e{round(math.log10(TOLERANCES[0]))}"),
        " of the range of each variable. Along the path drawn the energy is constant to within ",
        bound(lost), ".",
    ]  # fmt: skip
    if found is not None:
        figures.append(section_figure(plane, found, "surface-of-section"))
        prose += _validated(found)
    elif returns:
        prose.append(" The motion returns too rarely to one surface for a section to be drawn.")
    return Section("refused-motion", "How it moves", (Paragraph(tuple(prose)), Figures(tuple(figures))))


def _validated(found: SurfaceOfSection) -> list[Inline]:
    """Return the evidence for a section: what the energy lost, and how long two runs agree."""
    number = np.isfinite(found.points[0]).sum(axis=1)
    least = int(np.min(found.settled))
    fraction = "all of them" if (found.settled >= number).all() else f"the first {least} of each motion and more"
    return [
        " Every motion of the surface of section was computed twice, with tolerances a hundred times apart. The runs "
        f"agree to {AGREEMENT:g} of the figure in {fraction}, {int(np.minimum(found.settled, number).sum())} of "
        f"{int(number.sum())} returns; at no return does the energy differ from E by more than ",
        bound(found.drift), ".",
    ]  # fmt: skip
