"""The drawing of an energy–momentum map: regions with letters, critical curves, lines of equal action, the motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hjsolve.energy_momentum.critical_curves import CriticalCurve
from hjsolve.energy_momentum.energy_momentum_map import EnergyMomentumMap
from hjsolve.energy_momentum.kinds_of_motion import KindsOfMotion
from hjsolve.energy_momentum.orbits import drawn_actions
from hjsolve.reports.document import Figure, Inline, Mathematics, Text
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.contours import drawn_level, spread_levels
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain, spoken

_ACROSS, _UP = 150, 110
_COARSE = (90, 66)
_LEVELS = 9
LINES = {"relative equilibrium": "curve", "separatrix": "edge", "edge of escape": "energy", "end of the domain": "grid"}
_FILLS = (("blue", 0.13), ("red", 0.12), ("ink", 0.1), ("blue", 0.3), ("red", 0.28), ("ink", 0.24))
_MOST_REGIONS = len(_FILLS)


@dataclass(frozen=True)
class MapGrid:
    """What is drawn of a map.

    Attributes:
        x, y: places of the grid.
        numbers: of the region at each place, shape (up, across).
        regions: those with a motion; their letters are A, B, … in this order.
        letters: place of each letter.
    """

    x: Array
    y: Array
    numbers: NDArray[np.int64]
    regions: list[KindsOfMotion]
    letters: list[tuple[float, float]]


def map_grid(found: EnergyMomentumMap) -> MapGrid | None:
    """Classify the grid that is drawn; None where each point would take too long."""
    if any(own.polynomial is None for own in found.coordinates):
        return None
    x, y, numbers, regions = found.grid(_ACROSS, _UP)
    kept = [k for k, region in enumerate(regions) if all(region.kinds.values())][:_MOST_REGIONS]
    return MapGrid(x, y, numbers, [regions[k] for k in kept], [_deepest(numbers == k, x, y) for k in kept])


def _deepest(mask: NDArray[np.bool_], x: Array, y: Array) -> tuple[float, float]:
    """Return a place of a region that is far from its edge: what is left when its rim is taken off again and again."""
    inner = mask
    while True:
        wide = np.pad(inner, 1)
        smaller = wide[1:-1, 1:-1] & wide[:-2, 1:-1] & wide[2:, 1:-1] & wide[1:-1, :-2] & wide[1:-1, 2:]
        if not smaller.any():
            break
        inner = smaller
    rows, columns = np.nonzero(inner)
    k = len(rows) // 2
    return float(x[columns[k]]), float(y[rows[k]])


def figure_of_map(found: EnergyMomentumMap, key: str) -> Figure:
    """Draw a map.

    Args:
        key: a name that is unique on the page.

    Returns:
        The figure; its caption tells what the letters mean.
    """
    frame = svg.DrawingFrame(found.window[0], found.window[1], height=380.0)
    grid = map_grid(found)
    inside: list[str] = []
    if grid is not None:
        inside += [_filled(frame, grid, k) for k in range(len(grid.regions))] + action_lines(found, frame)
    inside += [svg.curve(frame, *visible(found, grid, curve), LINES[curve.kind]) for curve in found.curves]
    above = [svg.disc(frame, value.x, value.y, "ring") for value in found.isolated]
    if grid is not None:
        above += [
            svg.annotate(frame, *place, chr(65 + k), style="name", anchor="middle", shift=(0, 5))
            for k, place in enumerate(grid.letters)
        ]
    if found.point is not None and _shown(found.point, found.window):
        above.append(svg.disc(frame, *found.point))
    below = [svg.axes(frame, svg.label(name_box(found.x)), svg.label(name_box(found.y)))]
    title = f"Map of the kinds of motion over {spoken(found.x)} and {spoken(found.y)}"
    letters = "; ".join(kinds_by_letter(grid)) if grid is not None else ""
    description = f"{title}. {letters}." + (" The motion is the point." if found.point is not None else "")
    text = svg.assemble(frame, key, title, description, below, inside, above)
    data: dict[str, list[float]] = {}
    for k, curve in enumerate(found.curves):
        data[f"{k}.{found.x}"], data[f"{k}.{found.y}"] = list(map(float, curve.x)), list(map(float, curve.y))
    return Figure(text, title, description, _caption(found, grid), data)


def kinds_by_letter(grid: MapGrid) -> list[str]:
    """Return what each letter of a map means, names of coordinates as in a line of text: ``A: θ librates``."""
    return [f"{chr(65 + k)}: {in_line(region)}" for k, region in enumerate(grid.regions)]


def in_line(region: KindsOfMotion) -> str:
    """Return the kinds of a region in a line of text, ``θ librates``."""
    if not all(region.kinds.values()):
        return region.name
    return ", ".join(f"{plain(name_box(name))} {region.name_of(name)}" for name in region.kinds)


def _shown(point: tuple[float, float], window: Any) -> bool:
    return all(low <= v <= high for v, (low, high) in zip(point, window))


def _filled(frame: svg.DrawingFrame, grid: MapGrid, k: int) -> str:
    """One region as rows of bars."""
    region = grid.regions[k]
    column, row = (int(np.argmin(np.abs(v - p))) for v, p in zip((grid.x, grid.y), region.example))
    mask = grid.numbers == grid.numbers[row, column]
    wide, tall = (float(v[1] - v[0]) / 2 for v in (grid.x, grid.y))
    parts = []
    for i, line in enumerate(mask):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
        top, bottom = (float(frame.py(grid.y[i] + side * tall)) for side in (1, -1))
        for a, b in zip(edges[::2], edges[1::2]):
            left, right = float(frame.px(grid.x[a] - wide)), float(frame.px(grid.x[b - 1] + wide))
            parts.append(f"M{left:.1f} {top:.1f}H{right:.1f}V{bottom:.1f}H{left:.1f}Z")
    colour, strength = _FILLS[k]
    style = f"fill:var(--{colour});opacity:{strength};stroke:none;shape-rendering:crispEdges"
    return f'<path class="map{k}" style="{style}" d="{"".join(parts)}"/>'


def visible(found: EnergyMomentumMap, grid: MapGrid | None, curve: CriticalCurve) -> tuple[Array, Array]:
    """Return the points of a curve, NaN where no real motion lies next to them.

    Args:
        grid: its classified grid; None to leave the curve as it is.
        curve: one of its curves.
    """
    x, y = np.asarray(curve.x, float), np.asarray(curve.y, float)
    if grid is None:
        return x, y
    if len(x) == 2:
        x, y = (np.linspace(v[0], v[1], 201) for v in (x, y))
    empty = np.ones(grid.numbers.shape, dtype=bool)
    for region in grid.regions:
        column, row = (int(np.argmin(np.abs(v - p))) for v, p in zip((grid.x, grid.y), region.example))
        empty &= grid.numbers != grid.numbers[row, column]
    near = np.zeros(len(x), dtype=bool)
    (x0, x1), (y0, y1) = found.window
    i = np.clip((x - x0) / (x1 - x0) * len(grid.x), -2, len(grid.x) + 1).astype(int)
    j = np.clip((y - y0) / (y1 - y0) * len(grid.y), -2, len(grid.y) + 1).astype(int)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            column, row = np.clip(i + a, 0, len(grid.x) - 1), np.clip(j + b, 0, len(grid.y) - 1)
            near |= ~empty[row, column]
    return np.where(near, x, np.nan), np.where(near, y, np.nan)


def action_values(found: EnergyMomentumMap) -> tuple[Array, Array, dict[str, Array]]:
    """Return actions on a coarse grid: x, y, coordinate → J."""
    x, y = (low + (high - low) * (np.arange(n) + 0.5) / n for (low, high), n in zip(found.window, _COARSE))
    X, Y = (v.ravel() for v in np.meshgrid(x, y))
    values = {own.name: drawn_actions(own, X, Y).reshape(len(y), len(x)) for own in found.coordinates}
    moving = np.all([np.isfinite(J) for J in values.values()], axis=0)  # one may have room where another has none
    return x, y, {name: np.where(moving, J, np.nan) for name, J in values.items()}


def action_lines(found: EnergyMomentumMap, frame: svg.DrawingFrame) -> list[str]:
    """Draw the lines of equal action of every coordinate."""
    x, y, values = action_values(found)
    parts = []
    for J in values.values():
        for level in spread_levels(J, _LEVELS):
            path = drawn_level(frame, x, y, J, level)
            parts.append(f'<path class="level" style="opacity:.55;stroke-width:.7" d="{path}"/>')
    return parts


def _caption(found: EnergyMomentumMap, grid: MapGrid | None) -> Text:
    x, y = Mathematics(name_box(found.x)), Mathematics(name_box(found.y))
    pieces: list[Inline] = ["Kinds of motion for every ", x, " and ", y, ". "]
    if grid is not None:
        names = [c.name for c in found.coordinates]
        for k, region in enumerate(grid.regions):
            pieces.append(f"{chr(65 + k)}: ")
            for n, (name, words) in enumerate((name, region.name_of(name)) for name in names):
                pieces += [", " if n else "", Mathematics(name_box(name)), f" {words}"]
            pieces.append(". ")
    kinds = dict.fromkeys(curve.kind for curve in found.curves)
    meanings = {
        "relative equilibrium": "heavy: a coordinate rests", "separatrix": "dashed blue: separatrices",
        "edge of escape": "dotted: edge of escape", "end of the domain": "thin: an end of the domain is reached",
    }  # fmt: skip
    legend = [meaning for kind, meaning in meanings.items() if kind in kinds]
    if grid is not None:
        legend.append("thin blue: equal actions")
    if found.isolated:
        legend.append("ring: isolated critical value")
    if found.point is not None:
        legend.append("red point: the motion of this report")
    return (*pieces, f"{'; '.join(legend)[:1].upper()}{'; '.join(legend)[1:]}." if legend else "")
