"""A small drawing board: frames with axes, curves, areas, marks, as SVG text that follows the page's colours.

A ``style`` is one of the classes of ``drawing_style.STYLE``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import ceil, floor, isfinite, log10, pi

import numpy as np
from numpy.typing import NDArray

from hjsolve.reports.formulas.layout import Box, Dotted, Glyph, RowBox, Script
from hjsolve.reports.formulas.one_line_text import plain


def ticks(low: float, high: float, wanted: float = 5.0, *, angle: bool = False) -> list[tuple[float, str]]:
    """Choose round places on an axis.

    Args:
        low: start of the range.
        high: its end, above ``low``.
        wanted: about how many.
        angle: True for multiples of π/2, π/4 … where the range is that of an angle.

    Returns:
        (place, label) in order.
    """
    if angle and high - low > pi / 3:
        return _angle_ticks(low, high, wanted)
    raw = (high - low) / wanted
    power = 10.0 ** floor(log10(raw))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= raw * 0.999)
    places = [i * step for i in range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)]
    decimals = max(0, -floor(log10(step) + 1e-9))
    largest = max(abs(low), abs(high))
    if decimals > 4 or largest >= 1e6:
        # many digits: show the offset-free value with as few digits as tell the ticks apart
        digits = max(1, ceil(log10(largest / step) - 1e-9) + 1)
        return [(x, _power_label(x, digits)) for x in places]
    return [(x, f"{x:.{decimals}f}".replace("-", "−") if abs(x) > step / 2 else "0") for x in places]


def _power_label(x: float, digits: int) -> str:
    mantissa, _, exponent = f"{x:.{digits - 1}e}".partition("e")
    superscript = str(int(exponent)).translate(str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"))
    return "0" if x == 0 else f"{mantissa}·10{superscript}".replace("-", "−")


def _angle_ticks(low: float, high: float, wanted: float) -> list[tuple[float, str]]:
    step = next(
        (s for s in (pi / 4, pi / 2, pi, 2 * pi, 4 * pi, 8 * pi, 16 * pi) if (high - low) / s <= wanted + 1.01), 32 * pi
    )
    places = range(ceil(low / step - 1e-9), floor(high / step + 1e-9) + 1)
    return [(i * step, _angle_label(i * round(step / (pi / 4)))) for i in places]


def _angle_label(quarters: int) -> str:
    sign, n = ("−" if quarters < 0 else ""), abs(quarters)
    if n == 0:
        return "0"
    for divisor in (4, 2):
        if n % divisor == 0:
            whole, under = n // divisor, 4 // divisor
            return f"{sign}{'' if whole == 1 else whole}π{'' if under == 1 else f'/{under}'}"
    return f"{sign}{'' if n == 1 else n}π/4"


Array = NDArray[np.float64]


def finite(values: Array) -> list[float]:
    """Return the finite ones of some numbers, as a figure's data hold them."""
    return [float(v) for v in values if isfinite(v)]


@dataclass(frozen=True)
class DrawingFrame:
    """A rectangle of the plane shown in a rectangle of the drawing.

    Attributes:
        x, y: the ranges shown, (low, high).
        width, height: of the whole drawing, in pixels of its view box.
        left, right, top, bottom: margins.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    width: float = 460.0
    height: float = 320.0
    left: float = 56.0
    right: float = 16.0
    top: float = 26.0
    bottom: float = 40.0

    def px(self, x: Array | float) -> Array:
        """Return the horizontal place of x on the drawing, in pixels from the left.

        Args:
            x: data, in the units of the axis.
        """
        low, high = self.x
        return np.asarray(
            self.left + (np.asarray(x, float) - low) / (high - low) * (self.width - self.left - self.right)
        )

    def py(self, y: Array | float) -> Array:
        """Return the vertical place of y on the drawing, in pixels from the top.

        Args:
            y: data, in the units of the axis.
        """
        low, high = self.y
        room = self.height - self.top - self.bottom
        return np.asarray(self.top + (high - np.asarray(y, float)) / (high - low) * room)


def square(frame: DrawingFrame) -> DrawingFrame:
    """Widen one range so that both axes have the same scale.

    Returns:
        A frame that shows at least as much, with equal scales.
    """
    wide, tall = frame.width - frame.left - frame.right, frame.height - frame.top - frame.bottom
    scale = max((frame.x[1] - frame.x[0]) / wide, (frame.y[1] - frame.y[0]) / tall)
    middle = (sum(frame.x) / 2, sum(frame.y) / 2)
    x = (middle[0] - scale * wide / 2, middle[0] + scale * wide / 2)
    y = (middle[1] - scale * tall / 2, middle[1] + scale * tall / 2)
    return DrawingFrame(x, y, frame.width, frame.height, frame.left, frame.right, frame.top, frame.bottom)


# ------------------------------------------------------------------------------------------------ marks on the board
def curve(frame: DrawingFrame, x: Array, y: Array, style: str = "curve") -> str:
    """Draw a curve; gaps where a value is not finite.

    Args:
        y: values, shape (n,).

    Returns:
        SVG text, clipped to the frame by the caller's ``assemble``.
    """
    return f'<path class="{style}" d="{_path(frame, x, y)}"/>' if len(x) else ""


def area(frame: DrawingFrame, x: Array, lower: Array, upper: Array, style: str = "area") -> str:
    """Fill between two curves.

    Args:
        lower: values of one curve, shape (n,).
        upper: values of the other, shape (n,).

    Returns:
        SVG text.
    """
    outline = _path(frame, np.concatenate([x, x[::-1]]), np.concatenate([lower, upper[::-1]]))
    return f'<path class="{style}" d="{outline}Z"/>' if len(x) else ""


def disc(frame: DrawingFrame, x: float, y: float, style: str = "dot", size: float = 4.2) -> str:
    """Draw a small disc.

    Args:
        size: radius in pixels.

    Returns:
        SVG text.
    """
    return f'<circle class="{style}" cx="{_n(frame.px(x))}" cy="{_n(frame.py(y))}" r="{size}"/>'


def annotate(
    frame: DrawingFrame,
    x: float,
    y: float,
    text: str,
    *,
    style: str = "note",
    anchor: str = "start",
    shift: tuple[float, float] = (0.0, 0.0),
) -> str:
    """Write words at a place.

    Args:
        text: SVG text content, already escaped (see ``label``).
        anchor: ``start``, ``middle`` or ``end``.
        shift: pixels to the right and down.

    Returns:
        SVG text.
    """
    left, top = _n(frame.px(x) + shift[0]), _n(frame.py(y) + shift[1])
    return f'<text class="{style}" x="{left}" y="{top}" text-anchor="{anchor}">{text}</text>'


def label(box: Box) -> str:
    """Write a name with its indices as SVG text: letters slanted, indices lowered or raised.

    Args:
        box: the name's box.

    Returns:
        ``tspan`` elements.
    """
    match box:
        case Script(base, sub, sup):
            parts = [label(base)]
            for script, offset in ((sub, 4), (sup, -5)):
                if script is not None:
                    parts.append(
                        f'<tspan dy="{offset}" font-size="78%">{label(script)}</tspan>'
                        f'<tspan dy="{-offset}">&#8203;</tspan>'
                    )
            return "".join(parts)
        case RowBox(items):
            return "".join(label(item) for item in items)
        case Glyph(text, "identifier"):
            return f'<tspan class="it">{escape(text)}</tspan>'
        case Dotted():
            return f'<tspan class="it">{escape(plain(box))}</tspan>'
    return escape(plain(box))


def axes(
    frame: DrawingFrame,
    across: str,
    up: str,
    *,
    angles: tuple[bool, bool] = (False, False),
    zero: bool = False,
    numbers: bool = True,
) -> str:
    """Draw the axes with ticks and names.

    Args:
        across: name of the horizontal axis, SVG text (see ``label``).
        up: name of the vertical axis, written above it.
        angles: whether each axis is an angle.
        zero: draw the zero line of the vertical axis.
        numbers: write the numbers under the horizontal axis.

    Returns:
        SVG text.
    """
    bottom, left = frame.height - frame.bottom, frame.left
    parts = [f'<path class="axis" d="M{_n(left)} {_n(frame.top)}V{_n(bottom)}H{_n(frame.width - frame.right)}"/>']
    if zero and frame.y[0] < 0 < frame.y[1]:
        parts.append(f'<path class="grid" d="M{_n(left)} {_n(frame.py(0.0))}H{_n(frame.width - frame.right)}"/>')
    for place, text in ticks(*frame.x, angle=angles[0]):
        x = frame.px(place)
        parts.append(f'<path class="axis" d="M{_n(x)} {_n(bottom)}v4"/>')
        parts += (
            [f'<text class="tick" x="{_n(x)}" y="{_n(bottom + 17)}" text-anchor="middle">{text}</text>']
            if numbers
            else []
        )
    for place, text in ticks(*frame.y, wanted=min(5.0, (bottom - frame.top) / 34), angle=angles[1]):
        y = frame.py(place)
        parts.append(f'<path class="axis" d="M{_n(left)} {_n(y)}h-4"/>')
        parts.append(f'<text class="tick" x="{_n(left - 8)}" y="{_n(y + 4)}" text-anchor="end">{text}</text>')
    parts.append(
        f'<text class="name" x="{_n(frame.width - frame.right)}" y="{_n(bottom + 34)}" '
        f'text-anchor="end">{across}</text>'
    )
    parts.append(f'<text class="name" x="{_n(left - 8)}" y="{_n(frame.top - 11)}">{up}</text>')
    return "".join(parts)


def assemble(
    frame: DrawingFrame,
    key: str,
    title: str,
    description: str,
    below: Iterable[str],
    inside: Iterable[str],
    above: Iterable[str] = (),
) -> str:
    """Put a drawing together.

    Args:
        frame: its frame.
        key: a name that is unique on the page.
        title: a few words, read out by screen readers.
        description: what the drawing shows.
        below: axes and the like, not clipped.
        inside: curves and areas, clipped to the frame.
        above: marks and words, not clipped.

    Returns:
        One ``<svg>`` element.
    """
    clip = (
        f'<clipPath id="{key}-clip"><rect x="{_n(frame.left)}" y="{_n(frame.top)}" '
        f'width="{_n(frame.width - frame.left - frame.right)}" height="{_n(frame.height - frame.top - frame.bottom)}"/>'
        "</clipPath>"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="fig" viewBox="0 0 {_n(frame.width)} {_n(frame.height)}" '
        'role="img" '
        f'aria-labelledby="{key}-title {key}-desc"><title id="{key}-title">{escape(title)}</title>'
        f'<desc id="{key}-desc">{escape(description)}</desc>{clip}{"".join(below)}'
        f'<g clip-path="url(#{key}-clip)">{"".join(inside)}</g>{"".join(above)}</svg>'
    )


def _path(frame: DrawingFrame, x: Array, y: Array) -> str:
    """Return points in tenths of a pixel; values far outside are drawn in so that coordinates stay small."""
    across = np.clip(frame.px(x), -4 * frame.width, 5 * frame.width)
    down = np.clip(frame.py(y), -4 * frame.height, 5 * frame.height)
    parts, pen, last = [], "M", ""
    for a, b in zip(across, down):
        if not (isfinite(a) and isfinite(b)):
            pen = "M"
            continue
        point = f"{_n(a)} {_n(b)}"
        if point != last or pen == "M":
            parts.append(f"{pen}{point}")
        pen, last = "L", point
    return "".join(parts)


def _n(value: Array | float) -> str:
    text = f"{float(value):.1f}"
    return text.removesuffix(".0") if text != "-0.0" else "0"


def spread(values: Sequence[float] | Array, margin: float = 0.06) -> tuple[float, float]:
    """Give a range that holds all finite values with a margin; never empty.

    Args:
        values: any numbers.
        margin: part of the range left free on each side.

    Returns:
        (low, high).
    """
    finite = np.asarray(values, float)
    finite = finite[np.isfinite(finite)]
    if not finite.size:
        return -1.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    room = (high - low) * margin or max(abs(high), 1.0) * 0.1
    return low - room, high + room
