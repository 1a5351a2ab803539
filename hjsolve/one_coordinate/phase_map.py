"""What every map from a phase to a coordinate answers, and where it puts the coordinate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import ClassVar, NamedTuple, Self

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Numeric, Reals
from hjsolve.one_coordinate.fourier_series import midpoints


class Place(NamedTuple):
    """Where the anomaly χ puts the coordinate.

    Attributes:
        q: position.
        speed: dq/dχ, with the sign of the motion.
        product: (q − a)(b − q), or 1 for a rotation.
        stretch: |dq/dχ| / √product.
        rate: dχ/dψ where the phase is ψ and not χ itself; ``speed`` and ``stretch`` are without it.
        below, above: q − a and b − q, each with its relative accuracy; None for a rotation.
    """

    q: Numeric
    speed: Numeric
    product: Numeric
    stretch: Numeric
    rate: Numeric | int = 1
    below: Numeric | None = None
    above: Numeric | None = None


class Unstretched:
    """A map whose phase is χ itself; ``stretched_anomaly.Stretched`` answers the same questions for a phase ψ."""

    even: ClassVar[bool]

    def place(self, χ: Numeric, arithmetic: Float64 | Multi) -> Place:
        """Return the place at χ, |χ| ≤ 2π.

        Args:
            χ: phase; a number of the arithmetic, or an array of doubles.
        """
        raise NotImplementedError

    def places(self, nodes: int, arithmetic: Multi) -> Iterator[Place]:
        """Yield the places at the midpoints of equal parts of half a turn (of a turn where it is not even).

        Args:
            nodes: how many parts.
        """
        for χ in midpoints(nodes, even=self.even, bits=arithmetic.bits):
            yield self.place(χ, arithmetic)

    def slope_at(self, χ: Reals) -> Reals | float:  # noqa: ARG002  (asked like a stretched one's)
        """Return dχ/dψ, which is 1."""
        return 1.0

    def rounding(self, χ: Reals) -> Reals:
        """Return the rounding of the map from phases to χ as an uncertainty of the phase: there is none."""
        return 0.0 * χ

    def in_doubles(self) -> Self:
        """Return the same with its constants rounded to doubles, for vectorised use."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
        return type(self)(**{name: v if isinstance(v, int) else float(v) for name, v in values.items()})

    def lowered(self, arithmetic: Multi) -> Self:
        """Return the same with its constants rounded to fewer digits."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
        numbers = {n: arithmetic.convert(v) for n, v in values.items() if not isinstance(v, int | float | None)}
        return replace(self, **numbers)  # type: ignore[type-var]
