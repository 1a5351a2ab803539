"""The work-precision figure: error against time, both logarithmic, one line a method, failures marked."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from hjsolve.costs import Cost, Row
from hjsolve.reports.document import Figure, Text
from hjsolve.reports.drawings import svg
from hjsolve.reports.formulas.names import RAISED

_UNITS = ((1e-6, "µs"), (1e-3, "ms"), (1.0, "s"), (1e3, "ks"))
_POWER = 0.62
"""Errors are drawn at (−log₁₀ error)^0.62, so that 5 digits and 100 digits can both be read; the ticks say which."""
_PITCH = 34
_TICKS = (0, 3, 6, 10, 15, 20, 30, 50, 75, 100, 150, 200, 250)


@dataclass(frozen=True)
class Look:
    """How a method is drawn: the class of its line and of its marks, and their shape."""

    line: str
    mark: str
    shape: str


LOOKS: Mapping[str, Look] = {
    "float64": Look("motion", "redmark", "disc"), "mpmath": Look("motion", "redmark", "disc"),
    "certified": Look("proof", "redmark", "square"), "closed form": Look("curve", "inkmark", "diamond"),
    "integrate": Look("motion", "redmark", "disc"), "DOP853": Look("level", "bluemark", "triangle"),
    "heyoka": Look("edge", "bluemark", "square"),
}  # fmt: skip
_SHAPES: Mapping[str, tuple[tuple[float, float], ...]] = {
    "square": ((-1, -1), (1, -1), (1, 1), (-1, 1)), "diamond": ((0, -1.35), (1.35, 0), (0, 1.35), (-1.35, 0)),
    "triangle": ((0, -1.3), (1.2, 0.9), (-1.2, 0.9)),
    "disc": tuple((1.1 * math.cos(k * math.pi / 8), 1.1 * math.sin(k * math.pi / 8)) for k in range(16)),
}  # fmt: skip


def figure(cost: Cost, key: str) -> Figure:
    """Draw a table of costs.

    Args:
        cost: the table.
        key: a name that is unique on the page.

    Returns:
        The figure.
    """
    shown = [row for row in cost.rows if row.answered]
    frame = _frame(cost, shown)
    below = [*log_axes(frame), *_legend(frame, cost)]
    inside, above = [], []
    for method in cost.methods:
        look = LOOKS[method]
        points = [(_x(row), _y(row, cost)) for row in cost.of(method) if row.answered and row.status != "lost"]
        across, down = (np.array([point[i] for point in points], float) for i in (0, 1))
        inside.append(svg.curve(frame, across, down, look.line))
        above += [_mark(frame, row, cost) for row in cost.of(method)]
    description = "; ".join(_said(cost, method) for method in cost.methods)
    data: dict[str, list[float]] = {}
    for method in cost.methods:
        rows = [row for row in cost.of(method) if row.answered]
        data |= {f"{method}: seconds": [row.seconds or 0.0 for row in rows]} if rows else {}
        data |= {f"{method}: error": [min(row.error or 0.0, 1e300) for row in rows]} if rows else {}
    title = "Accuracy against time"
    caption: Text = (
        "True error against time: lower is more accurate, further left is quicker. Red: hjsolve, with error bounds; "
        "black: the catalog's formulas; blue: integrators, without bounds. Hollow: the time for all times was worked "
        "out from some. A cross: did not fit the budget or failed, at the height of the digits asked; or lost, at top.",
    )
    drawing = svg.assemble(frame, key, title, description, below, inside, above)
    return Figure(drawing, title, description, caption, data)


def _frame(cost: Cost, shown: Sequence[Row]) -> svg.DrawingFrame:
    times = [_x(row) for row in shown] or [-3.0, 0.0]
    errors = [_y(row, cost) for row in shown if row.status != "lost"] or [-15.0]
    deepest = min([*errors, *(depth(row.digits) for row in cost.rows if row.digits is not None and _crossed(row))])
    low, high = math.floor(min(times) - 0.15), math.ceil(max(times) + 0.15)
    span = max(2.5, 1.05 * -deepest)
    return svg.DrawingFrame(
        (low, max(high, low + 2)), (-span, 0.0), width=560, height=330, left=54, right=140, bottom=44
    )


def _x(row: Row) -> float:
    return math.log10(max(row.seconds or 0.0, 1e-9))


def _y(row: Row, cost: Cost) -> float:
    """Return where an error is drawn; what is not resolved stands a little below the digits asked."""
    deepest = 10.0 ** -((row.digits or 15.0) + 6.0)
    return depth(-math.log10(min(1.0, max(row.error or 0.0, deepest, cost.floor))))


def depth(digits: float) -> float:
    """Give the height at which an error of 10^−digits is drawn.

    Args:
        digits: −log₁₀ of the relative error.
    """
    return -(max(digits, 0.0) ** _POWER)


def _crossed(row: Row) -> bool:
    return row.status in ("too slow", "not converged", "lost")


def log_axes(frame: svg.DrawingFrame) -> list[str]:
    """Draw the axes: log₁₀ seconds across, errors by ``depth`` upwards.

    Args:
        frame: with log₁₀ seconds and ``depth`` as its axes.
    """
    bottom, left, right = frame.height - frame.bottom, frame.left, frame.width - frame.right
    parts = [f'<path class="axis" d="M{left} {frame.top}V{bottom}H{right}"/>']
    for power in range(int(frame.x[0]), int(frame.x[1]) + 1):
        x = float(frame.px(power))
        parts.append(f'<path class="grid" d="M{x:.1f} {frame.top}V{bottom}"/>')
        parts.append(f'<path class="axis" d="M{x:.1f} {bottom}v4"/>')
        if (int(frame.x[1]) - int(frame.x[0])) <= 7 or power % 2 == 0:
            text = _time(10.0**power)
            parts.append(f'<text class="tick" x="{x:.1f}" y="{bottom + 17}" text-anchor="middle">{text}</text>')
    last = -math.inf
    for digits in _TICKS:
        y, text = (
            float(frame.py(depth(digits))),
            "1" if digits == 0 else f"10{''.join(RAISED[x] for x in str(-digits))}",
        )
        if y > bottom + 0.5 or y - last < 18:
            continue
        last = y
        parts.append(f'<path class="grid" d="M{left} {y:.1f}H{right}"/><path class="axis" d="M{left} {y:.1f}h-4"/>')
        parts.append(f'<text class="tick" x="{left - 8}" y="{y + 4:.1f}" text-anchor="end">{text}</text>')
    parts.append(f'<text class="name" x="{right}" y="{bottom + 36}" text-anchor="end">time</text>')
    parts.append(f'<text class="name" x="{left - 8}" y="{frame.top - 11}">true error</text>')
    return parts


def _time(seconds: float) -> str:
    size, unit = max((u for u in _UNITS if u[0] <= seconds * 1.001), default=_UNITS[0])
    value = seconds / size
    return f"{value:.0f} {unit}" if value > 0.5 else f"{value:.1g} {unit}"


def _legend(frame: svg.DrawingFrame, cost: Cost) -> list[str]:
    """One line a method in the right margin; what could not run has a cross and the reason."""
    left, parts = frame.width - frame.right + 16, list[str]()
    for k, method in enumerate(cost.methods):
        ran = any(row.answered for row in cost.of(method))
        several = sum(row.answered and row.status != "lost" for row in cost.of(method)) > 1
        parts += legend_line(frame, k, method, several=several, ran=ran)
        word, y = ("" if ran else cost.of(method)[0].status), frame.top + 8 + _PITCH * k
        parts.append(f'<text class="tick" x="{left + 29}" y="{y + 17}">{escape(word)}</text>' if word else "")
    return parts


def legend_line(frame: svg.DrawingFrame, k: int, method: str, *, several: bool, ran: bool = True) -> list[str]:
    """Draw the k-th line of the legend in the right margin: the method's line, its mark or a cross, its name.

    Args:
        frame: the drawing.
        k: number of the line, from 0 on.
        method: its name.
        several: whether the method has more than one mark, joined by a line.
        ran: False draws a cross in place of the mark.
    """
    left, y, look = frame.width - frame.right + 16, frame.top + 8 + _PITCH * k, LOOKS[method]
    return [
        f'<path class="{look.line}" d="M{left} {y}h22"/>' if several else "",
        shape(look.shape, left + 11, y, look.mark) if ran else _cross(left + 11, y),
        f'<text class="tick" x="{left + 29}" y="{y + 4}">{escape(method)}</text>',
    ]


def _mark(frame: svg.DrawingFrame, row: Row, cost: Cost) -> str:
    look = LOOKS[row.method]
    said = f"<title>{escape(_row_said(row))}</title>"
    if row.answered and row.status != "lost":
        style = look.mark + (" hollow" if row.status == "extrapolated" else "")
        place = float(frame.px(_x(row))), float(frame.py(_y(row, cost)))
        return f"<g>{said}{shape(look.shape, *place, style)}</g>"
    if not _crossed(row) or row.digits is None:
        return ""
    x = frame.width - frame.right - 5 if row.seconds is None else float(frame.px(_x(row)))
    y = float(frame.py(depth(row.digits))) if row.seconds is None else frame.top
    return f"<g>{said}{_cross(x, y, 'bluemark' if 'blue' in look.mark else 'redmark')}</g>"


def shape(form: str, x: float, y: float, style: str, size: float = 3.7) -> str:
    """Draw a mark: a disc, square, diamond or triangle about a point of the drawing.

    Args:
        form: of the mark.
        x, y: its middle, in units of the drawing.
        style: attributes of SVG.
        size: half its width, in units of the drawing.
    """
    points = "L".join(f"{x + size * a:.1f} {y + size * b:.1f}" for a, b in _SHAPES[form])
    return f'<path class="{style}" d="M{points}Z"/>'


def _cross(x: float, y: float, style: str = "redmark") -> str:
    return f'<path class="{style} cross" d="M{x - 4:.1f} {y - 4:.1f}l8 8m0 -8l-8 8"/>'


def _row_said(row: Row) -> str:
    error = "no answer" if row.error is None else f"error {row.error:.1e}"
    when = "" if row.seconds is None else f" in {row.seconds:.2g} s"
    asked = "" if row.digits is None else f", {row.digits:g} digits asked"
    return f"{row.method}{asked}: {error}{when}" + ("" if row.status == "ok" else f" ({row.status})")


def _said(cost: Cost, method: str) -> str:
    rows = [row for row in cost.of(method) if row.answered]
    if not rows:
        return f"{method}: {cost.of(method)[0].status}"
    parts = [f"error {row.error:.0e} in {row.seconds:.2g} s" for row in (rows[0], rows[-1])]
    return f"{method}: {' to '.join(dict.fromkeys(parts))}"
