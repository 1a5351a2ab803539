"""Draw docs/work-precision.svg and docs/cost-growth.svg from docs/work-precision.json.

python benchmarks/draw_work_precision.py
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.work_precision import LOOKS, depth, legend_line, log_axes, shape

DOCS = Path(__file__).resolve().parents[1] / "docs"
NAMES = ("float64", "mpmath", "certified", "closed form", "DOP853", "heyoka")
Points = list[tuple[float, float]]


def points_of(rows: Sequence[dict[str, Any]], method: str) -> Points:
    """(log₁₀ seconds, log₁₀ error) of the rows of one method that have an answer."""
    return [
        (math.log10(row["seconds"]), math.log10(max(row["error"], 10.0 ** -(row["digits"] + 6))))
        for row in rows
        if row["method"] == method and row["error"] is not None and row["seconds"] and row["status"] != "lost"
    ]


def medians(entries: Sequence[dict[str, Any]], method: str) -> list[tuple[float, float, int]]:
    """Median log₁₀ seconds, median log₁₀ error and number of entries, for each accuracy.

    Only entries that reached every accuracy count: otherwise the high ones would be medians of the easy systems.
    """
    found = {one["id"]: [r for r in one.get("rows", ()) if points_of([r], method)] for one in entries}
    most = max((len(rows) for rows in found.values()), default=0)
    whole = [points_of(rows, method) for rows in found.values() if rows and len(rows) == most]
    return [
        (float(np.median([p[k][0] for p in whole])), float(np.median([p[k][1] for p in whole])), len(whole))
        for k in range(most)
    ]


def overview(entries: Sequence[dict[str, Any]]) -> str:
    """Every entry a faint line, the median over all entries a thick one."""
    every = [p for one in entries for name in NAMES for p in points_of(one.get("rows", ()), name)]
    deepest = -min(y for _, y in every)
    low, high = math.floor(min(x for x, _ in every)), math.ceil(max(x for x, _ in every))
    frame = svg.DrawingFrame(
        (low, high), (-1.04 * -depth(deepest), 0.0), width=760, height=420, left=58, right=150, bottom=44
    )
    inside, above, below = [], [], log_axes(frame)
    for k, name in enumerate(NAMES):
        look, middle = LOOKS[name], medians(entries, name)
        for one in entries:
            pairs = points_of(one.get("rows", ()), name)
            inside.append(f'<g opacity=".16">{curve(frame, pairs, look.line)}</g>')
        if middle:
            above.append(curve(frame, [(x, y) for x, y, _ in middle], look.line))
            places = [(float(frame.px(x)), float(frame.py(depth(-y)))) for x, y, _ in middle]
            above += [shape(look.shape, *place, look.mark) for place in places]
            below += legend_line(frame, k, name, several=len(middle) > 1)
            count = max(n for _, _, n in middle)
            left, top = frame.width - frame.right + 45, frame.top + 8 + 34 * k + 15
            below.append(f'<text class="tick" x="{left:g}" y="{top:g}">{count} systems</text>')
    title = "Accuracy against time over the catalog"
    description = "; ".join(
        f"{name}: {10 ** middle[0][0]:.1e} s for an error of {10 ** middle[0][1]:.0e}"
        for name in NAMES
        if (middle := medians(entries, name))
    )
    return svg.assemble(frame, "overview", title, f"Medians. {description}.", below, inside, above)


def curve(frame: svg.DrawingFrame, pairs: Points, style: str) -> str:
    xs, ys = (np.array([pair[i] for pair in pairs], float) for i in (0, 1))
    return svg.curve(frame, xs, np.array([depth(-y) for y in ys]), style) if len(pairs) > 1 else ""


# ------------------------------------------------------------------------------------------------ how the cost grows
STYLES = (
    ("motion", "redmark", "disc"), ("proof", "redmark", "square"), ("level", "bluemark", "triangle"),
    ("edge", "bluemark", "square"), ("curve", "inkmark", "diamond"), ("energy", "inkmark", "disc"),
)  # fmt: skip


def panel(series: dict[str, Points], x_name: str, y_name: str, key: str, *, seconds: bool) -> str:
    """Lines over two logarithmic axes; places and values are log₁₀."""
    every = [p for pairs in series.values() for p in pairs]
    x = (math.floor(min(p[0] for p in every) - 0.05), math.ceil(max(p[0] for p in every) + 0.05))
    y = (math.floor(min(p[1] for p in every) - 0.05), math.ceil(max(p[1] for p in every) + 0.05))
    top = 26.0 + 17 * len(series) + 8
    frame = svg.DrawingFrame(x, y, width=360, height=270 + top, left=62, right=14, top=top + 14, bottom=44)
    below = axes(frame, x_name, y_name, seconds=seconds)
    inside, above = [], []
    for k, (name, pairs) in enumerate(series.items()):
        line, mark, form = STYLES[k]
        inside.append(svg.curve(frame, np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs]), line))
        above += [shape(form, float(frame.px(a)), float(frame.py(b)), mark) for a, b in pairs]
        height = 16 + 17 * k
        below.append(f'<path class="{line}" d="M{frame.left:g} {height}h22"/>')
        below.append(shape(form, frame.left + 11, height, mark))
        below.append(f'<text class="tick" x="{frame.left + 30:g}" y="{height + 4}">{name}</text>')
    return svg.assemble(frame, key, f"{y_name} against {x_name}", ", ".join(series), below, inside, above)


def axes(frame: svg.DrawingFrame, x_name: str, y_name: str, *, seconds: bool) -> list[str]:
    bottom, left, right = frame.height - frame.bottom, frame.left, frame.width - frame.right
    parts = [f'<path class="axis" d="M{left} {frame.top}V{bottom}H{right}"/>']
    wide, tall = (max(1, math.ceil((b - a) / 6)) for a, b in (frame.x, frame.y))
    for power in range(int(frame.x[0]), int(frame.x[1]) + 1, wide):
        place = float(frame.px(power))
        parts.append(f'<path class="grid" d="M{place:.1f} {frame.top}V{bottom}"/>')
        parts.append(f'<text class="tick" x="{place:.1f}" y="{bottom + 17}" text-anchor="middle">{ten(power)}</text>')
    for power in range(int(frame.y[0]), int(frame.y[1]) + 1, tall):
        place = float(frame.py(power))
        text = f"{ten(power)} s" if seconds else ten(power)
        parts.append(f'<path class="grid" d="M{left} {place:.1f}H{right}"/>')
        parts.append(f'<text class="tick" x="{left - 7}" y="{place + 4:.1f}" text-anchor="end">{text}</text>')
    parts.append(f'<text class="name" x="{right}" y="{bottom + 36}" text-anchor="end">{x_name}</text>')
    parts.append(f'<text class="name" x="{left - 7}" y="{frame.top - 9}">{y_name}</text>')
    return parts


def ten(power: int) -> str:
    raised = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return {0: "1", 1: "10", 2: "100"}.get(power, f"10{raised}")


def growth(results: dict[str, Any]) -> str:
    """Three panels side by side: digits, closeness to a separatrix, number of times."""

    def logs(rows: list[dict[str, float]], x: str, y: str) -> Points:
        return [(math.log10(row[x]), math.log10(row[y])) for row in rows]

    first = {name: logs(rows, "digits", "seconds") for name, rows in results["digits"].items()}
    second = {name: logs(rows, "gap", "evaluations") for name, rows in results["separatrix"].items()}
    third = {name: logs(rows, "times", "seconds") for name, rows in results["times"].items()}
    drawings = [
        panel(first, "digits", "time", "by-digits", seconds=True),
        panel(second, "1 − k²", "evaluations", "by-gap", seconds=False),
        panel(third, "number of times", "time", "by-times", seconds=True),
    ]
    height = max(float(d.split('viewBox="')[1].split('"')[0].split()[3]) for d in drawings)
    parts = []
    for k, drawing in enumerate(drawings):
        own = float(drawing.split('viewBox="')[1].split('"')[0].split()[3])
        place = f'x="{k * 374}" y="{height - own:g}" width="360" height="{own:g}" '
        parts.append(drawing.replace("<svg ", f"<svg {place}", 1))
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="fig" viewBox="0 0 {3 * 374 - 14} {height:g}" role="img">'
    title = "<title>How the cost of a digit grows</title>"
    title += "<desc>With digits, near a separatrix, with the number of times.</desc>"
    return f"{head}{title}{''.join(parts)}</svg>"


def draw(results: dict[str, Any]) -> None:
    """Write both figures."""
    (DOCS / "work-precision.svg").write_text(svg.standalone(overview(results["catalog"])), encoding="utf-8")
    if results.get("growth"):
        (DOCS / "cost-growth.svg").write_text(svg.standalone(growth(results["growth"])), encoding="utf-8")


if __name__ == "__main__":
    draw(json.loads((DOCS / "work-precision.json").read_text(encoding="utf-8")))
