"""A web: one orthogonal coordinate system in which a system separates, and where it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sympy as sp

from hjsolve.display.shown import Shown

if TYPE_CHECKING:
    from hjsolve.mechanics.system import System

Vector = tuple[sp.Expr, ...]


@dataclass(frozen=True, repr=False)
class Geometry(Shown):
    """Where a web is: its kind, frame and lengths, in Cartesian coordinates of equal mass.

    Attributes:
        kind: ``cartesian``, ``polar``, ``parabolic``, ``elliptic`` in the plane; ``cartesian``, ``circular cylinder``,
            ``elliptic cylinder``, ``parabolic cylinder``, ``spherical``, ``prolate spheroidal``, ``oblate spheroidal``,
            ``rotational parabolic``, ``conical``, ``ellipsoidal``, ``paraboloidal`` in space.
        centre: pole, centre or (parabolic kinds) focus; the origin for Cartesian webs.
        axes: orthonormal vectors in the order the transformation uses them; the last one is the axis of rotation or of
            the cylinder, the first one carries the foci of an elliptic web and is the axis of a parabolic one.
        foci: focal points, exact; empty where the kind has none.
        lengths: named constants of the transformation, e.g. ``{"a": focal half-distance}``.
        freedom: number of continuous parameters of the family of webs that this one represents; 0 for a single web.
        family: what may be varied, in words; empty for a single web.
    """

    kind: str
    centre: Vector
    axes: tuple[Vector, ...]
    foci: tuple[Vector, ...] = ()
    lengths: Mapping[str, sp.Expr] = field(default_factory=dict)
    freedom: int = 0
    family: str = ""

    @property
    def complexity(self) -> int:
        """How far the constants are from 0 and ±1; for choosing the simplest web of a family."""
        vectors = (*self.foci, self.centre, *self.axes, tuple(self.lengths.values()))
        entries = [c for v in vectors for c in v if c not in (0, 1, -1, sp.S.Half)]
        return sum(1 if c.is_Rational else 10 + int(sp.count_ops(c)) for c in entries)


@dataclass(frozen=True, repr=False)
class Web(Shown):
    """One orthogonal coordinate system in which the Hamilton–Jacobi equation separates.

    Attributes:
        kind, centre, axes, foci, lengths, freedom, family: as in ``Geometry``.
        coordinates: names of the new coordinates.
        transformation: old coordinate → expression in the new ones.
        system: the transformed ``System``, ready for ``separate``.
        verdict: what ``separate`` says of it.
        remark: what the reader should know (octants, order of constants), or empty.
    """

    kind: str
    centre: Vector
    axes: tuple[Vector, ...]
    foci: tuple[Vector, ...]
    lengths: Mapping[str, sp.Expr]
    freedom: int
    family: str
    coordinates: tuple[str, ...]
    transformation: Mapping[str, sp.Expr]
    system: System
    verdict: Any
    remark: str = ""

    @property
    def certified(self) -> bool:
        """Whether ``separate`` proved that the transformed system separates."""
        return type(self.verdict).__name__ == "Separation"

    def __str__(self) -> str:
        """Return one line: the kind and where it is."""
        where = f"{self.kind}, centre {point_text(self.centre)}" if self.kind != "cartesian" else self.kind
        parts = [where, f"axes {', '.join(map(point_text, self.axes))}"]
        if self.foci:
            parts.append(f"foci {', '.join(map(point_text, self.foci))}")
        if self.family:
            parts.append(f"one of a family with {self.freedom} free parameter{'s' * (self.freedom > 1)}: {self.family}")
        return "; ".join(parts)


def point_text(vector: Sequence[sp.Expr]) -> str:
    """Write the components of a vector, in brackets."""
    return "(" + ", ".join(map(str, vector)) + ")"
