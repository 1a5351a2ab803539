"""What the page asks and what it receives, as plain texts and numbers that may travel between processes."""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

from hjsolve.errors import InvalidInputError

Wanted = Literal["answer", "report", "scene"]
LONGEST = 4000
"""Letters that one field may hold."""


@dataclass(frozen=True)
class Drag:
    """Where the initial point was drawn to in the phase plane of one coordinate."""

    name: str
    q: float
    p: float


@dataclass(frozen=True)
class PageQuestion:
    """Everything that was typed.

    Attributes:
        coordinates: one a line, such as ``r: 0 < r``.
        kinetic, potential: T and V.
        parameters: one a line, such as ``k = 1:positive``.
        q, velocity: the start, name → text; empty texts where there is none.
        find: look for coordinates that separate where the given ones do not.
        signature, relativity, functions, place: as ``System`` takes them.
        title: for display.
        wanted: an answer for the page, or a whole file: a report, a scene.
        drag: the initial point was moved there before asking.
        submitted: the system as a whole is meant to be complete; while it is typed, it is not.
    """

    coordinates: str = ""
    kinetic: str = ""
    potential: str = "0"
    parameters: str = ""
    q: Mapping[str, str] = field(default_factory=dict)
    velocity: Mapping[str, str] = field(default_factory=dict)
    find: bool = False
    signature: str = "definite"
    relativity: Mapping[str, str] | None = None
    functions: tuple[str, ...] = ()
    place: Mapping[str, str] = field(default_factory=dict)
    title: str = ""
    wanted: Wanted = "answer"
    drag: Drag | None = None
    submitted: bool = True

    def fragment(self) -> str:
        """Return the text after the # of the address that shows this question again."""
        typed: dict[str, object] = {
            name: getattr(self, name) for name in _SHARED if getattr(self, name) != _defaults()[name]
        }
        text = json.dumps(typed, ensure_ascii=False, separators=(",", ":"), default=list)
        return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")

    @classmethod
    def from_fragment(cls, fragment: str) -> PageQuestion:
        """Return the question that a link asks.

        Args:
            fragment: as ``fragment`` writes it, with or without its #.

        Raises:
            InvalidInputError: it is too long, cut, or holds anything but texts.
        """
        fragment = fragment.removeprefix("#")
        if len(fragment) > LONGEST_LINK:
            raise InvalidInputError(f"the link is too long: {len(fragment)} letters; at most {LONGEST_LINK} are read")
        unpacking = zlib.decompressobj()
        try:
            packed = base64.b64decode(fragment + "=" * (-len(fragment) % 4), altchars=b"-_", validate=True)
            typed = json.loads(unpacking.decompress(packed, _UNPACKED))
        except (binascii.Error, zlib.error, ValueError, RecursionError):
            raise InvalidInputError(_CUT) from None
        if not isinstance(typed, dict) or not all(_readable(name, value) for name, value in typed.items()):
            raise InvalidInputError(_CUT)
        values: dict[str, Any] = {n: tuple(value) if n == "functions" else value for n, value in typed.items()}
        return replace(cls(), **values)


_SHARED = (
    "coordinates", "kinetic", "potential", "parameters", "q", "velocity", "find", "signature", "relativity",
    "functions", "place", "title",
)  # fmt: skip
_CUT = "the link cannot be read; copy it again as a whole"
LONGEST_LINK = 8000
_UNPACKED = 40_000


def _defaults() -> dict[str, object]:
    empty = PageQuestion()
    return {f.name: getattr(empty, f.name) for f in fields(PageQuestion)}


def _readable(name: str, value: object) -> bool:
    """Return whether a field of a link has the type that it has in a question."""
    if name not in _SHARED:
        return False
    if name == "find":
        return isinstance(value, bool)
    if name == "functions":
        return isinstance(value, list) and all(isinstance(text, str) for text in value)
    if name in ("q", "velocity", "place", "relativity"):
        return isinstance(value, dict) and all(isinstance(text, str) for text in value.values())
    return isinstance(value, str)


@dataclass(frozen=True)
class Portrait:
    """A phase plane on which the initial point can be dragged.

    Attributes:
        name: the coordinate.
        svg: the drawing.
        size: (width, height) of the drawing in its own pixels.
        q, p: the ranges shown, (low, high).
        box: (left, right, top, bottom) of the frame in the drawing's pixels.
    """

    name: str
    svg: str
    size: tuple[float, float]
    q: tuple[float, float]
    p: tuple[float, float]
    box: tuple[float, float, float, float]

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Give (q, p) under a pixel; next to the frame, of the nearest place in it.

        Args:
            x, y: pixels of the drawing, from the left and from the top.
        """
        left, right, top, bottom = self.box
        across = min(max((x - left) / (right - left), 0.0), 1.0)
        up = min(max((bottom - y) / (bottom - top), 0.0), 1.0)
        return self.q[0] + across * (self.q[1] - self.q[0]), self.p[0] + up * (self.p[1] - self.p[0])


@dataclass(frozen=True)
class PageAnswer:
    """What the page shows.

    Attributes:
        verdict: ``yes``, ``no``, ``open``, or empty where the system could not be read.
        lead: the verdict in a sentence, HTML.
        details: the argument, or the obstruction, HTML.
        formulas: W, time law, orbit equations, HTML; empty where it does not separate.
        numbers: of the motion, each with its error, HTML.
        drawings: orbit and course in time, HTML.
        portraits: phase planes.
        velocity, q: the start as it is now, where it was dragged.
        coordinates: names read.
        problem: one line of plain text: what is wrong and what to write instead.
        unfinished: one line of plain text: what the boxes together still lack, while the system is typed.
        file: the text of a file that was wanted.
    """

    verdict: str = ""
    lead: str = ""
    details: str = ""
    formulas: str = ""
    numbers: str = ""
    drawings: str = ""
    portraits: tuple[Portrait, ...] = ()
    q: Mapping[str, str] = field(default_factory=dict)
    velocity: Mapping[str, str] = field(default_factory=dict)
    coordinates: tuple[str, ...] = ()
    problem: str = ""
    unfinished: str = ""
    file: str = ""
