"""What a value shows of itself: a few short lines in a terminal, blocks of a report in a notebook.

Every public value is a ``Shown``. Its text is made here, from its fields, and imports nothing; what a notebook or
a plot draws is asked of ``renderers`` when it is drawn.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Mapping
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from hjsolve.display.renderers import renderer

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

MOST_LINES, WIDEST = 20, 110
_MOST_ITEMS, _DIGITS, _PIECE = 6, 17, 90
_LONGEST_DENOMINATOR = 10_000
"""Of a fraction that is written as one, where it is also a double."""
_FRACTION = re.compile(r"(?<![\w./*])(\d{1,330})/(\d{5,330})(?![\w.*])")
"""A fraction with a long denominator; an exponent is not its numerator."""


class Shown:
    """A value with a short text, and with HTML for notebooks."""

    __slots__ = ()

    def __repr__(self) -> str:
        return as_text(self)

    def _label(self) -> str:
        """Return what it is called inside another value."""
        for part in ("id", "name", "title", "kind"):
            if text := str(getattr(self, part, "") or ""):
                return text
        system = getattr(self, "system", None)
        return system._label() if isinstance(system, Shown) else "…"

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return str(renderer("notebook").html_of(self))


class ShownMotion(Shown):
    """A motion, which draws itself on axes of matplotlib."""

    __slots__ = ()

    def plot(self, kind: str = "orbit", name: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the motion with matplotlib (extra ``report``).

        Args:
            kind: ``orbit`` in space; ``time``: a coordinate against time; ``phase``: the phase plane of a separated
                coordinate; ``potential``: its effective potential; ``wavefronts``: lines of equal W and caustics.
            name: the coordinate, for time, phase and potential; None for the first.
            ax: axes to draw on; None for new ones.

        Returns:
            The axes.

        Raises:
            InvalidInputError: another kind, or a coordinate that is not separated.
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").plotted(self, kind, name, ax)

    def animate(self, *, seconds: float = 8.0, frames: int = 240, ax: Axes | None = None) -> FuncAnimation:
        """Move a point along the orbit, at equal steps of time (extra ``report``).

        Args:
            seconds: how long it takes to show.
            frames: pictures.
            ax: axes to draw on; None for new ones.

        Returns:
            matplotlib's animation; keep it, and show it with ``to_jshtml()`` or ``save("orbit.gif")``.

        Raises:
            InvalidInputError: a length or a number of pictures that makes no sense.
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").animated(self, seconds, frames, ax)


class ShownSolution(Shown):
    """A solution, which draws a motion of its own."""

    __slots__ = ()

    def plot(self, kind: str = "phase", name: str | None = None, *, ax: Axes | None = None, **initial: object) -> Axes:
        """Start a motion and draw it with matplotlib (extra ``report``).

        Args:
            kind, name, ax: as in ``Motion.plot``.
            initial: q, velocity … as ``Solution.motion`` takes them; without, the catalog's default motion.

        Returns:
            The axes.

        Raises:
            InvalidInputError: initial data are missing or cannot be used; another kind or coordinate.
            MissingExtraError: matplotlib is not installed.
        """
        return renderer("plots").plotted_solution(self, kind, name, ax, initial)


def fields_of(value: Any) -> Iterator[tuple[str, object]]:
    """Give the fields of a value that are shown: those that hold data."""
    names = getattr(value, "_shown_names", None) or [field.name for field in dataclasses.fields(value) if field.repr]
    for name in names:
        content = getattr(value, name)
        if not callable(content) and content is not None and not _is_empty(content):
            yield name, content


def _is_empty(content: object) -> bool:
    return isinstance(content, (Mapping, tuple, list, str)) and not content


def as_text(value: object) -> str:
    """Write a value in at most ``MOST_LINES`` lines of at most ``WIDEST`` letters; in one where it fits."""
    rows = [(name, brief(content, WIDEST)) for name, content in fields_of(value)]
    name = type(value).__name__
    if sum(len(key) + len(text) + 3 for key, text in rows) + len(name) <= WIDEST:
        return f"{name}({', '.join(f'{key}={text}' for key, text in rows)})"
    left = max(len(key) for key, _ in rows)
    lines = [f"  {key:{left}}  {cut(text, WIDEST - left - 4)}" for key, text in rows[: MOST_LINES - 2]]
    return "\n".join([name, *lines, *(["  …"] if len(rows) > MOST_LINES - 2 else [])])


def as_call(name: str, arguments: Mapping[str, object]) -> str:
    """Write the call that makes a value, broken into lines where it is long; Python can read it.

    Args:
        name: what is called.
        arguments: by name; texts, numbers, and lists and mappings of them.
    """
    flat = f"{name}({', '.join(f'{key}={content!r}' for key, content in arguments.items())})"
    if len(flat) <= WIDEST:
        return flat
    return f"{name}(\n" + "".join(f"    {key}={_broken(content)},\n" for key, content in arguments.items()) + ")"


def _broken(content: object) -> str:
    """Return a text in pieces that Python joins again; anything else between its items."""
    if isinstance(content, str):
        return "\n        ".join(repr(piece) for piece in wrap(content, _PIECE, drop_whitespace=False)) or "''"
    pieces, lines = re.split(r"(?<=, )(?=')", repr(content)), [""]
    for piece in pieces:
        if len(lines[-1]) + len(piece) > _PIECE:
            lines.append("")
        lines[-1] += piece
    return "\n        ".join(line.rstrip() for line in lines)


def brief(content: Any, room: int) -> str:
    """Write what a field holds in one line.

    Args:
        room: letters there are for it; what is longer is cut.
    """
    if isinstance(content, Shown):
        return cut(f"{type(content).__name__}({content._label()})", room)
    if isinstance(content, Mapping):
        pairs = (f"{key}: {brief(item, _fraction(room, len(content)))}" for key, item in content.items())
        return cut("{" + _listed(pairs, len(content), room) + "}", room)
    if isinstance(content, (tuple, list)) and not hasattr(content, "_fields"):
        inside = _listed((brief(x, _fraction(room, len(content))) for x in content), len(content), room)
        return cut(f"({inside}{',' if len(content) == 1 else ''})", room)
    if getattr(content, "ndim", 0):
        return cut(f"array {content.shape} of {_ends(content.ravel(), room)}", room)
    if hasattr(content, "error") and hasattr(content, "certified"):
        return f"{content:S}"
    if hasattr(content, "_mpf_") or hasattr(content, "_mpc_"):
        return str(content.context.nstr(content, _DIGITS))
    text = _of_formula(content) if hasattr(content, "free_symbols") else repr(content)
    return cut(" ".join(text.split()), room)


def _of_formula(content: Any) -> str:
    """Write a formula, with the doubles that are in it as such."""
    return _FRACTION.sub(_as_a_double, str(content))


def _as_a_double(fraction: re.Match[str]) -> str:
    double = _double(int(fraction[1]), int(fraction[2]))
    return fraction[0] if double is None else repr(double)


def as_argument(value: Any) -> str | float:
    """Return a formula as it is typed: 0.1 where it is 3602879701896397/36028797018963968, else its text.

    Args:
        value: a sympy expression.
    """
    double = _double(int(value.p), int(value.q)) if getattr(value, "is_Rational", False) else None
    return str(value) if double is None else double


def _double(p: int, q: int) -> float | None:
    """Return a reduced fraction as a double; None where it is not one exactly, or short."""
    exact = q > _LONGEST_DENOMINATOR and q & (q - 1) == 0 and p.bit_length() <= 53 and q.bit_length() <= 1075
    return p / q if exact else None


def _fraction(room: int, count: int) -> int:
    return room // min(max(count, 1), 3)


def _listed(items: Iterator[str], count: int, room: int) -> str:
    """Return the first few of many, as far as there is room; then how many there are."""
    shown: list[str] = []
    for item in items:
        if len(shown) == _MOST_ITEMS or sum(map(len, shown)) > room:
            return f"{', '.join(shown)}, … {count} in all"
        shown.append(item)
    return ", ".join(shown)


def _ends(flat: Any, room: int) -> str:
    places = range(len(flat)) if len(flat) <= 4 else (0, 1, len(flat) - 1)
    words = [brief(flat[i].item() if hasattr(flat[i], "item") else flat[i], room) for i in places]
    return ", ".join(words if len(flat) <= 4 else [*words[:2], "…", words[2]])


def listed_names(names: Iterable[str]) -> str:
    """Write names as a list in a sentence: ``x``, ``x and y``, ``x, y and z``.

    Args:
        names: at least one.
    """
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def cut(text: str, room: int) -> str:
    """Shorten a line.

    Args:
        text: one line.
        room: letters it may have.
    """
    return text if len(text) <= room else text[: max(room - 2, 0)] + " …"
