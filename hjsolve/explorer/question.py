"""What the page asks and what it is told, as plain texts and numbers that may travel between processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

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
    file: str = ""
