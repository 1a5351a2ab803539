"""The region in which one coordinate of many orbits moves, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

from hjsolve.arithmetic.number_types import Codes, Integers, Mask, Reals, Which
from hjsolve.ensembles.engine.radicand_views import View


@dataclass(frozen=True)
class OrbitRegions:
    """Where one coordinate moves, for n orbits; arrays (n,).

    Attributes:
        below, above: views of F used in the lower and in the upper half.
        lower, upper: offsets of the turning points in those views; for a rotation ``lower`` is the slow place, or
            half way between two.
        width: b − a.
        near_lower, near_upper, level: ρ_d, ρ_c and the modulus 4^−level (int array); see ``one_coordinate/anomaly``.
            for rotations with two slow places m of ``turned_circle``, and the place opposite to the slower one.
        node_map: which of ``nodes.WARPS`` (int array); for rotations 1 where there are two slow places.
        momentum: P₀ (signed).
        left, right: q₀ − a and b − q₀; for a rotation ``left`` is q₀ − ``lower``.
        turning: False for rotations.
    """

    below: View
    above: View
    lower: Reals
    upper: Reals
    width: Reals
    near_lower: Reals
    near_upper: Reals
    level: Integers
    node_map: Integers
    momentum: Reals
    left: Reals
    right: Reals
    turning: bool = True

    def take(self, index: Which) -> OrbitRegions:
        """Return the region of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        arrays = (
            "lower",
            "upper",
            "width",
            "near_lower",
            "near_upper",
            "level",
            "node_map",
            "momentum",
            "left",
            "right",
        )
        below = self.below.take(index)
        above = below if self.above is self.below else self.above.take(index)
        return OrbitRegions(
            below, above, **{name: getattr(self, name)[index] for name in arrays},
            turning=self.turning,
        )  # fmt: skip


@dataclass(frozen=True)
class LocatedRegions:
    """Regions of some orbits.

    Attributes:
        index: which orbits.
        region: where they move.
        status: of each.
        rest: True where the coordinate stays at a stable double zero of p².
    """

    index: Integers
    region: OrbitRegions
    status: Codes
    rest: Mask

    def take(self, index: Which) -> LocatedRegions:
        """Return some of them.

        Args:
            index: which, positions or a mask.
        """
        return LocatedRegions(self.index[index], self.region.take(index), self.status[index], self.rest[index])
