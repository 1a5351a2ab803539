"""The section that shows where among all motions of its system a motion lies: the energy–momentum map."""

from __future__ import annotations

from hjsolve.energy_momentum.energy_momentum_map import EnergyMomentumMap, energy_momentum_map
from hjsolve.errors import HJSolveError
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Block, Figures, Inline, Mathematics, Paragraph, Section
from hjsolve.reports.drawings.energy_momentum_figure import figure_of_map
from hjsolve.reports.formulas.names import name_box

_FEWEST_CONSTANTS = 2


def energy_momentum_section(motion: Motion) -> Section | None:
    """Draw the map of a motion's system with the motion on it.

    Returns:
        The section; None for systems with one constant, and where no map could be drawn.
    """
    if len(motion.solution.constants) < _FEWEST_CONSTANTS or not motion.solution.coordinates:
        return None
    try:
        found = energy_momentum_map(motion)
        blocks: list[Block] = [Figures((figure_of_map(found, "energy-momentum"),))]
        blocks += _monodromy(found)
    except HJSolveError:
        return None
    return Section("energy-momentum", "Every motion of this system", tuple(blocks))


def _monodromy(found: EnergyMomentumMap) -> list[Block]:
    if not found.isolated or len(found.coordinates) != 1:
        return []
    value, turned = found.isolated[0], found.monodromy()
    (a, b), (c, d) = turned.matrix
    matrix = f"(({a}, {b}), ({c}, {d}))".replace("-", "−")
    x, y = Mathematics(name_box(found.x)), Mathematics(name_box(found.y))
    gained: list[Inline] = []
    angle = next(iter(turned.winding))  # the ignorable angle whose momentum is a coordinate of the map
    for name, turns in turned.winding.items():
        if turns:
            words = f" gains {abs(turns)} turn{'s' if abs(turns) > 1 else ''}"
            gained += [*([", "] if gained else []), Mathematics(name_box(name)), words]
    text: list[Inline] = [
        "At ", x, f" = {value.x:.6g}, ", y, f" = {value.y:.6g} lies an isolated critical value: the system can rest "
        "there, and motions of one kind surround it. Continued once round it, the two periods of a torus, a turn of ",
        Mathematics(name_box(angle)), " and a cycle of ", Mathematics(name_box(found.coordinates[0].name)),
        f", return multiplied by the monodromy matrix {matrix}: ", *(gained or ["no angle gains a turn"]),
        " per cycle of ", Mathematics(name_box(found.coordinates[0].name)), ". ",
    ]  # fmt: skip
    if not turned.trivial:
        text.append("No choice of actions is therefore smooth on the whole region (Duistermaat; Cushman).")
    return [Paragraph(tuple(text))]
