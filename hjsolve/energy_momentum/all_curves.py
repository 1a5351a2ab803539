"""All critical curves of a coordinate: those that double zeros of P² trace, and those at fixed places."""

from __future__ import annotations

from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.critical_curves import ROUNDS, CriticalCurve, Window, double_zeros
from hjsolve.energy_momentum.end_curves import curves_at_ends, symmetric_curves


def critical_curves(own: CoordinateKinds, window: Window, rounds: int = ROUNDS) -> list[CriticalCurve]:
    """Trace the critical curves of one coordinate in a window of the plane.

    Args:
        own: the coordinate.
        window: ranges of x and y.
        rounds: how often places are put between those that lie far apart.
    """
    return [*double_zeros(own, window, rounds), *symmetric_curves(own, window), *curves_at_ends(own, window)]
