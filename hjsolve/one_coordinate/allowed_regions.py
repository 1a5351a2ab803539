"""Where else a coordinate could move with the same constants: the other intervals on which p² ≥ 0.

The search of ``turning_points`` walks through forbidden places as well, with −p² in place of p²: what it passes is
proved negative, so no well is stepped over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.interval import Interval
from hjsolve.arithmetic.jet import Derivatives
from hjsolve.arithmetic.number_types import Mpf, Numbers, Numeric
from hjsolve.errors import ForbiddenMotionError, NotConvergedError, required
from hjsolve.one_coordinate.classify import ray
from hjsolve.one_coordinate.coordinate_start import CoordinateStart
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.turning_points import End, first_end

MOST_REGIONS = 4
"""Regions looked for on each side (a coordinate that winds for ever may have infinitely many)."""


class AllowedRegion(NamedTuple):
    """An interval on which p² ≥ 0, in order of q; both ends at one place where the coordinate could only rest."""

    lower: End
    upper: End


@dataclass(frozen=True)
class _Negated(MomentumSquared):
    """−p²."""

    def value(self, q: Numeric, bits: int) -> Mpf:
        return -super().value(q, bits)

    def jet(self, q: Numeric, bits: int) -> Derivatives[Mpf]:
        return Derivatives(*(-part for part in super().jet(q, bits)))

    def sign_beyond(self, side: int, start: float) -> int:
        return -super().sign_beyond(side, start)

    def sign_in_the_end(self, side: int, end: Mpf | None) -> int:
        return -super().sign_in_the_end(side, end)

    def sign_before(self, end: Mpf, side: int, distance: Mpf) -> int:
        return -super().sign_before(end, side, distance)

    def enclose(self, low: Numbers, high: Numbers, bits: int = 53) -> Derivatives[Interval]:
        return Derivatives(*(Interval(-part.high, -part.low) for part in super().enclose(low, high, bits)))


def others(start: CoordinateStart, lower: End, upper: End, digits: int) -> list[AllowedRegion]:
    """Return the regions next to the one a motion is in, in order of q.

    Args:
        lower, upper: ends of the region the motion is in.
        digits: relative digits wanted of their ends.
    """
    # p² > 0 all round: there is no other region
    if "round" in (lower.kind, upper.kind):
        return []
    if start.angle:
        return _along(start, upper, 1, digits, last=lower)
    return _along(start, lower, -1, digits)[::-1] + _along(start, upper, 1, digits)


def every_region(start: CoordinateStart, digits: int) -> list[AllowedRegion]:
    """Return every region of a coordinate, in order of q.

    Args:
        start: any place in its domain with p² ≠ 0.
        digits: relative digits wanted of their ends.

    Raises:
        NotConvergedError: p² could not be decided somewhere.
    """
    if start.radicand.value(start.place(256), 256) > 0:
        upper = first_end(ray(start, 1), digits=digits)
        if upper.kind == "round":
            return [AllowedRegion(upper, upper)]
        lower = first_end(ray(start, -1), digits=digits)
        own = AllowedRegion(lower, upper)
        if start.angle:
            return [own, *_along(start, upper, 1, digits, last=lower)]
        return [*_along(start, lower, -1, digits)[::-1], own, *_along(start, upper, 1, digits)]
    here = End("turning", start.place)
    if start.angle:
        return _along(start, here, 1, digits, last=here)
    return [*_along(start, here, -1, digits)[::-1], *_along(start, here, 1, digits)]


def _along(
    start: CoordinateStart, end: End, side: int, digits: int, last: End | None = None, most: int = MOST_REGIONS
) -> list[AllowedRegion]:
    """Regions from an end outward; for an angle, up to the first region itself a turn later (``last``)."""
    found: list[AllowedRegion] = []
    while end.place is not None and end.kind != "boundary" and len(found) < most:
        # the gap is a region of −p²: the search for its end is the same as for a motion's
        if not _adjoins(start, end):
            end = first_end(ray(_at(start, end, negated=True), side), digits=digits)
        if end.place is None or end.kind == "boundary" or (last is not None and _passed(end, last)):
            break
        # a double zero with p² < 0 on both sides is a region of one place
        rests = end.kind == "asymptote" and not _adjoins(start, end)
        far = end if rests else first_end(ray(_at(start, end), side), digits=digits)
        found.append(AllowedRegion(end, far) if side > 0 else AllowedRegion(far, end))
        end = far
    return found


def _at(start: CoordinateStart, end: End, *, negated: bool = False) -> CoordinateStart:
    own = start.radicand
    radicand = _Negated(own.squared, own.kernels, own.inputs, own.guard) if negated else own
    return replace(start, place=required(end.place), radicand=radicand)


def _adjoins(start: CoordinateStart, end: End) -> bool:
    """Return True at a double zero with p² > 0 on both sides: the next region begins where the last one ends."""
    return end.kind == "asymptote" and end.place is not None and bool(start.radicand.jet(end.place(512), 512)[2] > 0)


def _passed(end: End, last: End) -> bool:
    """Return True when an end is the beginning of the first region, a turn later."""
    turn = 2 * multiprecision(256).pi
    return bool(required(end.place)(256) - required(last.place)(256) > turn * (1 - 2.0**-100))


def forbidden(start: CoordinateStart, digits: int = 15) -> ForbiddenMotionError:
    """Make the error for p² < 0 at the initial place, with the nearest regions on both sides.

    Args:
        start: the coordinate, at a place where p² < 0.
        digits: decimal digits to which the regions are located.
    """
    here = End("turning", start.place)
    value = float(start.radicand.value(start.place(256 + start.radicand.guard), 256))
    beside: list[tuple[float, tuple[float | None, float | None]]] = []
    for side in (-1, 1):
        for region in _nearest(start, here, side, digits):
            ends = tuple(None if e.place is None else float(e.place(64)) for e in region)
            near = required(ends[0] if side > 0 else ends[1])
            beside.append((abs(near - float(start.place(64))), (ends[0], ends[1])))
    regions = tuple(ends for _, ends in sorted(beside, key=lambda pair: pair[0]))
    return ForbiddenMotionError(
        f"{start.name}: no real motion passes through {float(start.place(64)):.12g}, p² = {value:.3g} < 0 there; "
        + (f"motion is possible {' and '.join(_described(start.name, *r) for r in regions)}" if regions else
           "no place was found where these constants allow it"),
        name=start.name,
        regions=regions,
    )  # fmt: skip


def _nearest(start: CoordinateStart, here: End, side: int, digits: int) -> list[AllowedRegion]:
    """Return the first region on one side; none where it could not be decided."""
    try:
        return _along(start, here, side, digits, most=1)
    except NotConvergedError:
        return []


def _described(name: str, low: float | None, high: float | None) -> str:
    if low == high and low is not None:
        return f"at rest at {name} = {low:.12g}"
    if low is None:
        return f"for {name} ≤ {high:.12g}"
    return f"for {name} ≥ {low:.12g}" if high is None else f"for {low:.12g} ≤ {name} ≤ {high:.12g}"
