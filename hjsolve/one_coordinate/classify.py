"""From the initial place of a coordinate to its motion: its kind by the zeros of p² on both sides, and integrals."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

from hjsolve.arithmetic.floats import Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Numeric
from hjsolve.arithmetic.root_finding import bisected
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.one_coordinate import kinks
from hjsolve.one_coordinate.anomaly import Rotation, libration_anomaly, rotation_anomaly
from hjsolve.one_coordinate.anomaly_choice import over_near_zeros, over_other_near_zeros, over_the_best_map
from hjsolve.one_coordinate.barriers import slow_place
from hjsolve.one_coordinate.chain import Chain
from hjsolve.one_coordinate.chebyshev_panels import EndMap
from hjsolve.one_coordinate.coordinate_motion import Anomaly, AtRest, CoordinateMotion, Periodic, Unbounded
from hjsolve.one_coordinate.coordinate_start import CoordinateStart, Winding
from hjsolve.one_coordinate.kind_of_motion import Kind
from hjsolve.one_coordinate.momentum_squared import MomentumSquared, Number
from hjsolve.one_coordinate.open_branch import Branch
from hjsolve.one_coordinate.ray import Ray
from hjsolve.one_coordinate.turning_points import End, first_end

_NEAREST = 200
"""Bits by which a turning point may be nearer to an end of the domain than to the other one."""


_STEP = 20
"""Powers of two by which a step is shorter than |q| that distinguishes a simple zero from others."""
_WIDEST, _CURVED = 2.0**500, 2.0**1000
"""Width of a motion, and p² over its square, from whose inverse to which doubles hold what is worked out with them."""
_LONG = 2**16
"""The natural length of an open motion, over |q|, at most."""
_STEEPEST = 1000
"""Exponents above are taken for those of powers only where they are the same at every distance."""


@dataclass(frozen=True)
class Located:
    """A course with the ends of its region.

    Attributes:
        coordinate_motion: the motion of the coordinate.
        lower, upper: the ends found, in order of q.
    """

    coordinate_motion: CoordinateMotion
    lower: End
    upper: End


def locate(start: CoordinateStart, digits: int) -> Located:
    """Classify the motion of one coordinate and integrate it.

    Raises:
        NotConvergedError: a zero of p² could not be decided, or an integrand stays rough.
    """
    if start.cells:
        return _through_kinks(start, digits)
    # a start at rest moves to where F′ is positive; where F′ = 0, too, it stays
    forward = start.forward or _push(start)
    if forward == 0:
        return at_rest(start, digits)
    if start.winding is not None and (wound := _wound(start, start.winding, digits)) is not None:
        return wound
    ahead = _first_end(start, forward, digits)
    if start.forward == 0:
        # it starts at a turning point: nothing is searched behind it
        behind = End("turning", start.place)
    elif ahead.kind == "round":
        behind = ahead
    else:
        behind = _first_end(start, -forward, digits)
    lower, upper = (behind, ahead) if forward > 0 else (ahead, behind)
    if lower.kind == "turning" and upper.kind == "turning":
        return Located(_libration(start, lower, upper, digits), lower, upper)
    if ahead.kind == "round":
        return Located(_rotation(start, forward, digits), lower, upper)
    return Located(_open(start, forward, lower, upper, digits), lower, upper)


def _through_kinks(start: CoordinateStart, digits: int) -> Located:
    """Return the motion of a coordinate along which p² has kinks.

    Raises:
        NotConvergedError: it comes to rest at a kink that it may leave to either side.
    """
    # a start on a kink belongs to two cells: the sign of p, or of the push, says which p² goes on
    at_kink = kinks.cell_of(start, -1) != kinks.cell_of(start, 1)
    own = kinks.in_its_cell(start, kinks.cell_of(start, start.forward))
    forward = start.forward or (kinks.push(start) if at_kink else _push(own))
    if forward == 0:
        sides = [start.cells[kinks.cell_of(start, side)].radicand for side in (-1, 1)]
        return at_rest(own, digits, sides=None if not at_kink else sides)
    ahead = kinks.reached(start, forward, digits)
    behind = kinks.Reached(kinks.cell_of(start, forward), End("turning", start.place))
    if start.forward:
        behind = kinks.reached(start, -forward, digits)
    # no kink is passed: the motion is that of one analytic p²
    if ahead.cell == behind.cell and "wall" not in {ahead.end.kind, behind.end.kind}:
        return locate(kinks.in_its_cell(start, ahead.cell), digits)
    lower, upper = (behind, ahead) if forward > 0 else (ahead, behind)
    if not {lower.end.kind, upper.end.kind} <= {"turning", "wall"}:
        return Located(_open_through_kinks(start, forward, lower, upper, digits), lower.end, upper.end)
    return Located(kinks.libration(start, lower, upper, start.forward, digits), lower.end, upper.end)


def _push(start: CoordinateStart) -> int:
    """Direction in which a coordinate leaves a turning point: the sign of F′ (Greenwood, item 102); 0 when it rests."""
    if start.exact is not None and _looks_multiple(start) and start.exact.order_at_start() > 1:
        return 0
    # F′ next to a double zero is small: its sign is believed above the rounding of its terms only
    for bits in (256, 1024, 2048):
        q = start.place(bits)
        value, slope, bend = start.radicand.jet(q, bits)
        rounding = multiprecision(bits).mpf(2) ** (32 - bits) * (abs(bend) * max(abs(q), 1) + abs(value) + 1e-300)
        if abs(slope) > rounding:
            return 1 if slope > 0 else -1
    return 0


def _first_end(start: CoordinateStart, side: int, digits: int) -> End:
    """Return the end of the motion on one side; a zero proved to be triple or higher is an asymptote.

    Raises:
        NotConvergedError: a zero of p² could not be decided.
    """
    outward = ray(start, side)
    try:
        return first_end(outward, digits=digits)
    except NotConvergedError:
        q = start.place(1024)
        # a zero of order 3 or more has F″ = 0 as well: no enclosure decides it, exact algebra does
        zeros = start.exact.multiple_zeros() if start.exact is not None else ()
        beyond = [zero for zero in zeros if side * (zero(1024) - q) > 0]
        if not beyond:
            raise
        nearest = min(beyond, key=lambda zero: abs(zero(1024) - q))
        return first_end(
            replace(outward, reach=partial(kinks.distance, start.place, nearest), turns=False), digits=digits
        )


def _looks_multiple(start: CoordinateStart) -> bool:
    """Return whether p² at a turning point grows by much more than its slope lets it."""
    q = start.place(256)
    # F(q ± h) ~ F′h at a simple zero; where it is larger by 2¹⁰ the zero may be multiple
    step = q.context.ldexp(abs(q) or 1, -_STEP)
    try:
        grown = max(abs(start.radicand.value(q + side * step, 256)) for side in (1, -1))
        return bool(abs(start.radicand.jet(q, 256)[1]) * step < q.context.ldexp(grown, -_STEP // 2))
    except (InvalidInputError, TypeError):
        return True


def ray(start: CoordinateStart, side: int) -> Ray:
    """Return the way from the initial place to one side, up to the end of the domain or a full turn.

    Args:
        side: +1 upwards, −1 downwards.
    """
    end = start.upper if side > 0 else start.lower
    if start.angle:
        return Ray(start.radicand, start.place, side, _turn, turns=True)
    if end is None:
        return Ray(start.radicand, start.place, side, None)
    return Ray(start.radicand, start.place, side, partial(kinks.distance, start.place, end))


def _turn(bits: int) -> Mpf:
    return 2 * multiprecision(bits).pi


def at_rest(start: CoordinateStart, digits: int, *, sides: list[MomentumSquared] | None = None) -> Located:
    """Return the motion of a coordinate that rests where it starts.

    Args:
        start: the coordinate, at a double zero of p².
        sides: p² on both sides of a kink.
    """
    bits = bits_for(digits, 96)
    q = start.place(bits)
    _, _, bend = start.radicand.jet(q, bits)
    stable = sides is None and bool(bend < 0) and (start.exact is None or start.exact.order_at_start() == 2)
    scale = (-bend / 2) ** 0.5 if stable else 1
    size, h = abs(q) or 1, multiprecision(bits).mpf(2) ** -20
    # kernels at rest, and by how much they change over |q|: the size that cancellation refers to
    weights, beside = start.radicand.weights(q, bits), start.radicand.weights(q + size * h, bits)
    # the limit of a vanishing libration: ∂J/∂cⱼ = kⱼ/√(−½F″)
    rates = [0 * q if skip else w / scale for w, skip in zip(weights, start.skipped, strict=True)]
    changes = [abs(after - w) / h / scale for w, after in zip(weights, beside, strict=True)]
    sizes = [abs(r) + (c if c < multiprecision(bits).inf else 0) for r, c in zip(rates, changes, strict=True)]
    end = End("turning" if stable else "asymptote", start.place)
    return Located(AtRest(q, rates, sizes, stable, stable or _hollow(q, sides or [start.radicand] * 2)), end, end)


def _hollow(q: Mpf, sides: list[MomentumSquared]) -> bool:
    """Return whether p² is negative on both sides of a place at which it is zero, as far as it shows nearby."""
    try:
        return all(
            sides[side > 0].value(q + side * q.context.ldexp(abs(q) or 1, -power), 512) < 0
            for side in (-1, 1)
            for power in (20, 40)
        )
    except (InvalidInputError, TypeError):
        return False


def _libration(start: CoordinateStart, lower: End, upper: End, digits: int) -> Periodic:
    places = required(lower.place), required(upper.place)
    needed = bits_for(digits, 48)
    nearness = _nearness(start, places)
    if nearness > _NEAREST:
        raise NotConvergedError(
            f"{start.name}: it turns {nearness} powers of two nearer to an end of its domain than to its other turning "
            f"point, and {_NEAREST} are the most that can be integrated"
        )
    ends = places[0](256), places[1](256)
    _refuse_beyond_doubles(start, sum(ends) / 2, ends[1] - ends[0])
    # next to an end of the domain p² is known to fewer bits: twice the powers of two by which the end is nearer
    bits = needed + 80 + 2 * nearness + start.radicand.guard
    while True:
        arithmetic = Multi(bits)
        a, b = (arithmetic.convert(place(bits)) for place in places)
        # the plain anomaly first: circular orbits and oscillators need nothing else
        plain = libration_anomaly(a, b, None, None, arithmetic)
        lost = _lost_bits(start.radicand, plain, bits)
        if bits - lost >= needed:
            break
        if bits > 16384:
            raise NotConvergedError(
                f"{start.name}: the turning points {float(a):.17g} and {float(b):.17g} are too close to separate"
            )
        bits = needed + lost + 16

    def maps() -> Iterator[Anomaly]:
        yield plain
        # the elliptic one takes the next zeros on both sides away; then those inside the motion, one kind after the
        # other
        usual = libration_anomaly(
            a, b, _outside(start, a, b - a, -1, bits), _outside(start, b, b - a, 1, bits), arithmetic
        )
        yield usual
        yield from over_near_zeros(start, usual, bits)

    return over_the_best_map(start, "libration", maps(), digits, bits)


def _refuse_beyond_doubles(start: CoordinateStart, middle: Numeric, width: Mpf) -> None:
    """Refuse to integrate what doubles cannot hold.

    Args:
        middle: a place inside its motion.
        width: of its motion, or a length natural to it.

    Raises:
        NotConvergedError: the width, or p² over its square, is too large or too small.
    """
    if not start.parts:
        return
    # p²/W² is of the size of R, whose root and inverse disks in doubles must hold
    bend = abs(start.radicand.value(middle, 256)) / (width * width) if width else 0
    if width >= _WIDEST or (bend and not 1 / _CURVED < bend < _CURVED):
        raise NotConvergedError(
            f"{start.name}: lengths, momenta or times of this motion are beyond doubles, or their squares are; "
            'write them in other units, or leave integrals out with want=["constants", "turning_points"]'
        )


def _nearness(start: CoordinateStart, turns: tuple[Number, Number]) -> int:
    """Bits by which a turning point is nearer to an end of the domain than to the other turning point."""
    if start.lower is None and start.upper is None:
        return 0
    gaps, width = [], multiprecision(64).mpf(1)
    for bits in (256, 3072):
        a, b = (turn(bits) for turn in turns)
        width = b - a
        gaps = [abs(turn - end(bits)) for turn, end in ((a, start.lower), (b, start.upper)) if end is not None]
        if all(gap > width * multiprecision(64).mpf(2) ** (-bits // 2) for gap in gaps):
            break
    return max((int(multiprecision(64).log(width / gap, 2)) for gap in gaps if 0 < gap < width), default=0)


def _lost_bits(radicand: MomentumSquared, anomaly: Anomaly, bits: int) -> int:
    """Return how many bits p²/((q−a)(b−q)) loses by cancellation, measured against twice the precision."""
    worst = 0
    for χ in (0.3, 1.6, 2.9):
        place = anomaly.place(Multi(bits).convert(χ), Multi(bits))
        # twice the precision is the truth here: their difference is what cancellation takes
        near, exact = radicand.value(place.q, bits), radicand.value(place.q, 2 * bits)
        size = abs(exact)
        if not size:
            return bits
        error = abs(near - exact) / size
        worst = max(worst, int(bits + float(multiprecision(64).log(error, 2))) if error else 0)
    return max(worst, 0)


def _outside(start: CoordinateStart, end: Mpf, width: Mpf, side: int, bits: int) -> Mpf | None:
    """Return the nearest zero of p² beyond a turning point, roughly, or the end of the domain; None where all is far.

    Only the choice of the anomaly depends on it, never the value of an integral.
    """
    context = multiprecision(bits)
    domain = None if start.angle else start.upper if side > 0 else start.lower
    limit = abs(domain(bits) - end) if domain is not None else 64 * width
    # doubling steps from W/2⁷⁰: a zero next to a separatrix may be that near
    inner, step = context.mpf(0), width * context.mpf(2) ** -70
    while step < limit:
        if start.radicand.value(end + side * step, bits) > 0:
            _, step = bisected(lambda x: not start.radicand.value(end + side * x, bits) > 0, inner, step, 24)
            return end + side * step
        inner, step = step, 2 * step
    return domain(bits) if domain is not None else None


def _rotation(start: CoordinateStart, direction: int, digits: int) -> Periodic:
    bits = bits_for(digits, 128) + start.radicand.guard
    arithmetic = Multi(bits)
    slow, gap = slow_place(start, bits)
    anomaly: Rotation = rotation_anomaly(slow, direction, gap, arithmetic)
    phase = anomaly.phase(arithmetic.convert(start.place(bits)), direction, arithmetic)
    # the slow place was found modulo 2π
    whole = arithmetic.context.nint((start.place(bits) - anomaly.place(phase, arithmetic).q) / (2 * arithmetic.pi()))
    slow += 2 * arithmetic.pi() * whole  # turns are counted from the place given, whichever way the motion goes
    anomaly = rotation_anomaly(slow, direction, gap, arithmetic)
    lost = _lost_bits(start.radicand, anomaly, bits)
    if gap is not None:
        # k′² ~ gap²/4: the elliptic functions lose as many bits
        lost += int(max(0.0, -2 * float(arithmetic.context.log(gap, 2))))
    if lost > 64:
        bits += lost
        arithmetic = Multi(bits)
        anomaly = rotation_anomaly(arithmetic.convert(slow), direction, gap, arithmetic)
    maps = itertools.chain([anomaly], over_other_near_zeros(start, anomaly, gap, bits))
    return over_the_best_map(start, "rotation", maps, digits, bits)


def _wound(start: CoordinateStart, winding: Winding, digits: int) -> Located | None:
    """Return the motion along a line over barriers that repeat themselves; None where it turns at one of them."""
    around = replace(winding.start, parts=start.parts)
    if start.forward == 0 or first_end(ray(around, start.forward), digits=digits).kind != "round":
        return None
    coordinate_motion = _rotation(around, start.forward, digits)
    bits = bits_for(digits, 128) + start.radicand.guard
    return Located(replace(coordinate_motion, radian=winding.scale(bits)), End("round"), End("round"))


def _open(start: CoordinateStart, forward: int, lower: End, upper: End, digits: int) -> Unbounded:
    bits = bits_for(digits, 128)
    lower, upper = _judged(start, lower), _judged(start, upper)
    kind = _kind_of_open(lower, upper, forward)
    if "turning" in {lower.kind, upper.kind}:
        ways = (lower, upper, 1) if lower.kind == "turning" else (upper, lower, -1)
        out = _branch(start, *ways, digits)
        return Unbounded(kind, out, out, _open_phase(out.end_map, start, forward, bits))
    here = End("boundary", start.place)
    ahead, behind = (upper, lower) if forward > 0 else (lower, upper)
    one, other = _branch(start, here, ahead, forward, digits), _branch(start, here, behind, -forward, digits)
    return Unbounded(kind, one, other, 0 * start.place(bits))


def _branch(start: CoordinateStart, origin: End, target: End, side: int, digits: int) -> Branch:
    bits = bits_for(digits, 128)
    # the ends to more bits than the integrals: distances from them must keep their relative digits far into the branch
    exact = bits + 512 + start.radicand.guard
    first, turning = required(origin.place)(exact), origin.kind == "turning"
    length = (
        abs(target.place(exact) - first) if target.place is not None else _length(start, first, bits, turning=turning)
    )
    end = "infinity" if target.kind in {"infinity", "round"} else target.kind
    _refuse_beyond_doubles(start, first + side * length / 2, length)
    end_map = EndMap(turning, end, first, side, length, max(0, round(-target.power)))
    return Branch(end_map, start.radicand, start.skipped, digits, bits)


def _open_through_kinks(
    start: CoordinateStart, forward: int, lower: kinks.Reached, upper: kinks.Reached, digits: int
) -> Unbounded:
    """Return a motion that passes kinks, or is thrown back by a wall, and does not come back."""
    bits = bits_for(digits, 128)
    exact = bits + 512 + start.radicand.guard
    low, high = (kinks.Reached(k, _judged(kinks.in_its_cell(start, k), end)) for k, end in (lower, upper))
    kind = _kind_of_open(low.end, high.end, forward)

    def chain(origin: End, begin: int, target: kinks.Reached, side: int) -> Chain:
        ends = kinks.ends_between(start, begin, target, side)
        origins = [origin, *ends[:-1]]
        parts = (
            _branch(kinks.in_its_cell(start, begin + side * k), a, b, side, digits)
            for k, (a, b) in enumerate(zip(origins, ends, strict=True))
        )
        return Chain(tuple(parts), origin.kind == "wall")

    for near, far, side in ((low, high, 1), (high, low, -1)):
        if near.end.kind in {"turning", "wall"}:
            out = chain(near.end, near.cell, far, side)
            place = multiprecision(bits).convert(start.place(exact))
            y = required(0 * place if start.forward == 0 else out.end_map.parameter(place))
            return Unbounded(kind, out, out, y if forward == side else -y)
    here = End("boundary", start.place)
    ahead, behind = (high, low) if forward > 0 else (low, high)
    one, other = (
        chain(here, kinks.cell_of(start, side), target, side) for target, side in ((ahead, forward), (behind, -forward))
    )
    return Unbounded(kind, one, other, 0 * start.place(bits))


def _kind_of_open(lower: End, upper: End, forward: int) -> Kind:
    """Return the kind of a motion that does not come back: what it does in the end, whatever it came from."""
    ahead, behind = (upper, lower) if forward > 0 else (lower, upper)
    match (behind if ahead.kind in {"turning", "wall"} else ahead).kind:
        case "boundary" | "fall":
            return "boundary"
        case "asymptote":
            return "asymptotic"
        case _:
            return "escape"


def _judged(start: CoordinateStart, end: End) -> End:
    """Return an end of a domain; a ``fall`` where an integral has no limit there, an ``asymptote`` where time has none.

    Raises:
        NotConvergedError: p² grows faster than any power there: no map makes the way to that end regular.
    """
    if end.kind != "boundary" or end.place is None:
        return end
    bits = 1024
    context, place, here = multiprecision(bits), end.place(bits), start.place(bits)
    if _outgrows_powers(start.radicand, place, here - place):
        raise NotConvergedError(
            f"p² grows faster than any power of the distance on the way to {start.name} = {float(place):.9g}, an "
            "essential singularity: no integral converges up to there; give the coordinate a domain that ends before"
        )
    sizes = []
    # the integrand at 2⁻²⁰⁰ and 2⁻²¹⁶ of the way: kⱼ/p ~ x^(−s) has no integral for s ≥ 1, a ratio of 2¹⁶ or more
    for power in (200, 216):
        q = place + (here - place) * context.mpf(2) ** -power
        root = abs(start.radicand.value(q, bits)) ** 0.5
        weights = zip(start.radicand.weights(q, bits), start.skipped, strict=True)
        sizes.append([0 * root if skip else abs(w / root) for w, skip in weights])
    # the first kernel is that of the energy: where it has no limit the end is never reached
    endless = [bool(before and after / before > context.mpf(2) ** 15.99) for before, after in zip(*sizes, strict=True)]
    return replace(end, kind="asymptote" if endless[0] else "fall" if any(endless) else "boundary")


def _outgrows_powers(radicand: MomentumSquared, place: Mpf, direction: Mpf) -> bool:
    """Return whether p² grows faster than powers of the distance to a place: the nearer, the greater the exponent."""
    context = direction.context
    values = [abs(radicand.value(place + direction * context.mpf(2) ** -k, context.prec)) for k in (50, 66, 100, 116)]
    if not all(values):
        return False
    # the exponent of p² at 2⁻⁵⁰ and at 2⁻¹⁰⁰: of a power it is the same
    far, near = (context.log(after / before, 2) / 16 for before, after in (values[:2], values[2:]))
    return bool(near > max(_STEEPEST, 2 * abs(far)) or context.log(values[0], 2) > 2**64)


def _length(start: CoordinateStart, place: Mpf, bits: int, *, turning: bool) -> Mpf:
    """Return a length over which p² changes by itself near a place; at a turning point its value is rounding only.

    Next to a narrow feature far away p² hardly changes at all: the length is not much larger than |q|.
    """
    # |F/F′|, or |F′/F″| where F is nearly a parabola: the distance over which F changes by its own size
    value, slope, bend = start.radicand.jet(place, bits)
    own = max(abs(place), abs(place - start.place(bits))) or multiprecision(bits).mpf(1)
    if turning:
        value = 0 * value
    if bend and slope and abs(value) < abs(slope * slope / bend):
        return min(abs(slope / bend), _LONG * own)
    if value and slope:
        return min(abs(value / slope), _LONG * own)
    return own


def _open_phase(end_map: EndMap, start: CoordinateStart, forward: int, bits: int) -> Mpf:
    """Invert the map of a branch that starts at a turning point."""
    if start.forward == 0:
        return multiprecision(bits).mpf(0)
    context = multiprecision(bits)
    # x = y², sin²(y/2) or tanh²y (``chebyshev_panels``), solved for y
    x = abs(start.place(bits) - end_map.start) / end_map.length
    if end_map.end == "infinity":
        y = context.sqrt(x)
    else:
        y = 2 * context.asin(context.sqrt(x)) if end_map.end == "boundary" else context.atanh(context.sqrt(x))
    return y if forward == end_map.side else -y
