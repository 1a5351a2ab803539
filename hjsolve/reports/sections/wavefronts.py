"""The section that draws Hamilton's characteristic function: wavefronts, and the orbits that cross them."""

from __future__ import annotations

from hjsolve.errors import HJSolveError
from hjsolve.motion.motion import Motion
from hjsolve.rays.families import wavefronts
from hjsolve.reports.document import Figures, Mathematics, Paragraph, Section, Text
from hjsolve.reports.drawings.wavefront_figure import figure_of_wavefronts, plane_axes
from hjsolve.reports.formulas.layout import Glyph

_COUNTS = {1: (16, 10), 2: (12, 6)}
"""Separated coordinates → how many fronts and orbits are drawn: with two, each is dearer."""


def wavefront_section(motion: Motion) -> Section | None:
    """Draw the family of a motion.

    Returns:
        The section; None where two coordinates do not lie in a plane, or no family could be computed in a short time.
    """
    open_ones = [n for n in motion.solution.coordinates if motion.kinds[n] not in {"libration", "rotation"}]
    if len(open_ones) > 1 or len(motion.solution.coordinates) not in _COUNTS:
        return None
    if not plane_axes(motion.solution.system):
        return None
    fronts, orbits = _COUNTS[len(motion.solution.coordinates)]
    try:
        figure = figure_of_wavefronts(wavefronts(motion, fronts=fronts, orbits=orbits), "wavefronts-figure")
    except HJSolveError:
        return None
    if figure is None:
        return None
    W = Mathematics(Glyph("W"))
    text: Text = (
        "For the constants of this motion ", W, " is a function of position with several sheets. Its gradient is the "
        "momentum, so orbits with these constants cross the lines ", W,
        " = const at right angles in the metric of the kinetic energy.",
    )  # fmt: skip
    return Section("wavefronts", "Wavefronts and orbits", (Paragraph(text), Figures((figure,))))
