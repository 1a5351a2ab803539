"""Which map from phases to places a bounded motion is integrated over: the one that is proved to need fewest nodes.

A barrier that is just overcome is a pair of complex zeros c ± iδ of F = p² close to the real axis: there F has a
minimum, and F ≈ F(c) + ½F″(c)(q − c)² vanishes at δ = √(2F/F″). A pair of poles (a softened centre of force) is a
maximum in the same way, with δ = √(2F/|F″|) up to a factor of order one. The pairs only choose a change of variable;
no integral depends on how well they are known.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Float64, Multi, multiprecision
from hjsolve.arithmetic.fourier import smooth
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import stationary
from hjsolve.arithmetic.work_counter import count
from hjsolve.errors import NotConvergedError
from hjsolve.one_coordinate import resolution
from hjsolve.one_coordinate.anomaly import Libration, Rotation, barrier_anomaly, two_barrier_anomaly
from hjsolve.one_coordinate.coordinate_motion import Anomaly, Kind, Periodic
from hjsolve.one_coordinate.cycle_integrals import bounded
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.stretched_anomaly import Inner, Stretched, stretched

if TYPE_CHECKING:
    from hjsolve.one_coordinate.coordinate_start import CoordinateStart

_GRID_PLACES = 257  # between the turning points, where extrema of p² are looked for
_NEWTON_STEPS = 40
"""A simple zero of F′ takes log₂(bits) of them from nearby; a multiple one gains a bit a step."""

_FEW, _MANY = 32, 120
"""Nodes above which a second and another change of variable is tried, for a double and half a cycle. 27 motions took 30
to 50 % longer with half of both, and 3 to 8 % less, no more than the noise, with twice."""
_MOST_NODES = 20000
"""Nodes above which a motion is given up, for a double."""


def over_the_best_map(start: CoordinateStart, kind: Kind, maps: Iterator[Anomaly], digits: int, bits: int) -> Periodic:
    """Integrate over the first map for which few nodes are proved to be enough, or over the best of them.

    Args:
        kind: libration or rotation.
        maps: anomalies to try, in order.

    Raises:
        NotConvergedError: for none of them it could be proved how many nodes are enough, or they are too many.
    """
    best: tuple[int, Anomaly] | None = None
    # the plain map must be good to be taken; a costlier one is taken if it is not bad
    limits: Iterator[int] = itertools.chain([_FEW], itertools.repeat(_MANY))
    if not start.parts:  # nothing is integrated
        best, limits = (1, next(maps)), iter(())
    tried: list[Anomaly] = []
    for few, anomaly in zip(limits, maps, strict=False):
        tried.append(anomaly)
        best = _better(best, _proved(start, anomaly, digits, bits))
        if best is not None and best[0] <= few * max(1.0, digits / 15) * (1 if anomaly.even else 2):
            break
    if best is not None and best[0] > (
        _MOST_NODES * max(1.0, digits / 15) if isinstance(best[1], Stretched) else _MANY
    ):
        # many nodes: finer squares next to the obstacles may prove a wider strip
        best = _better(best, _proved(start, best[1], digits, bits, resolution.FINE))
    if best is None:
        return _next_to_a_separatrix(start, kind, tried, digits, bits)
    if best[0] > _MOST_NODES * max(1.0, digits / 15):
        raise NotConvergedError(
            f"{start.name}: no fewer than {best[0]} nodes are proved to resolve p² between its turning points"
        )
    return _integrated(start, kind, *best, digits, bits)


def _proved(
    start: CoordinateStart, anomaly: Anomaly, digits: int, bits: int, *coarse: float, zeros: bool = True
) -> tuple[int, Anomaly] | None:
    """Return the nodes that are proved to be enough over a map; None where nothing is."""
    # the number of nodes is proved before one of them is computed
    subject = resolution.integrands_to_resolve(anomaly, start.radicand, start.skipped, start.parts, bits)
    found = resolution.strip(subject, digits, *coarse, zeros=zeros)
    return None if found is None else (smooth(found.nodes(digits) * (1 if anomaly.even else 2)), anomaly)


def _better(one: tuple[int, Anomaly] | None, other: tuple[int, Anomaly] | None) -> tuple[int, Anomaly] | None:
    return min((x for x in (one, other) if x is not None), key=lambda x: x[0], default=None)


def _integrated(start: CoordinateStart, kind: Kind, nodes: int, anomaly: Anomaly, digits: int, bits: int) -> Periodic:
    phase = anomaly.phase(Multi(bits).convert(start.place(bits)), start.forward, Multi(bits))
    return bounded(kind, anomaly, start.radicand, phase, start.skipped, digits, bits, nodes, start.parts)


def _next_to_a_separatrix(start: CoordinateStart, kind: Kind, maps: list[Anomaly], digits: int, bits: int) -> Periodic:
    """Integrate where doubles cannot tell the regular factor R of p² from 0, between ends that are all but double.

    So many nodes that R and the kernels are proved to be their interpolants, and then as many as the coefficients of
    the integrands ask for: a zero of R that is too close cannot hide, it is in the values of R.

    Raises:
        NotConvergedError: not even R is proved to be resolved, or that takes too many nodes.
    """
    for anomaly in reversed(maps):
        # a zero of R so near that doubles do not know its sign: only R and the kernels are proved to be resolved
        least = _proved(start, anomaly, digits, bits, zeros=False)
        nodes = least[0] if least is not None else _MOST_NODES
        while nodes < _MANY * 8 * max(1.0, digits / 15):
            found = _integrated(start, kind, nodes, anomaly, digits, bits)
            # with R proved to be its interpolant, the coefficients of the integrands can be believed
            if found.tail <= 10.0 ** -(digits + 1):
                return found
            nodes = smooth(int(1.4 * nodes))
    raise NotConvergedError(f"{start.name}: no number of nodes is proved to resolve p² between its turning points")


def over_near_zeros(start: CoordinateStart, usual: Libration, bits: int) -> Iterator[Anomaly]:
    """Anomalies of a libration that are slow where p² comes close to zero or to a pole inside the motion.

    Args:
        usual: its anomaly between the turning points.
    """
    arithmetic = Multi(bits)
    # first the places that a proof did not get past; then the nearest pair by an elliptic map of its own
    yield from _spread(start, usual, bits)
    found = complex_zero_pairs(start.radicand, usual.lower, usual.upper, bits)
    if found:
        first = barrier_anomaly(usual.lower, usual.upper, found[0].place, found[0].gap, arithmetic)
        yield first
        yield from _spread(start, first, bits)


def over_other_near_zeros(start: CoordinateStart, anomaly: Rotation, gap: Mpf | None, bits: int) -> Iterator[Anomaly]:
    """Anomalies of a rotation that are slow at all barriers, not only at the highest.

    Args:
        anomaly: slow at the highest maximum only.
        gap: distance of the complex zero of p² next to that maximum from the real axis; None where it is far.
    """
    arithmetic = Multi(bits)
    # the barrier at which the angle begins is known already: it is left out of the search
    turn, margin = 2 * arithmetic.pi(), arithmetic.pi() / 512
    yield from _spread(start, anomaly, bits)
    found = complex_zero_pairs(start.radicand, anomaly.slow + margin, anomaly.slow + turn - margin, bits)
    if found and gap is not None:
        both = two_barrier_anomaly(anomaly.slow, gap, found[0].place, found[0].gap, anomaly.direction, arithmetic)
        yield both
        yield from _spread(start, both, bits)


def _spread(start: CoordinateStart, inner: Inner, bits: int) -> Iterator[Stretched]:
    """Stretch the phase of an anomaly through the places where its integrands are rough; nothing where none is."""
    subject = resolution.integrands_to_resolve(inner, start.radicand, start.skipped, start.parts, bits)
    places = resolution.approximate_places(subject)
    map_ = stretched(inner, places) if places else None
    if map_ is not None:
        yield map_


class ComplexZeroPair(NamedTuple):
    """A complex pair place ± i·gap of zeros or poles of p²."""

    place: Mpf
    gap: Mpf


def complex_zero_pairs(radicand: MomentumSquared, lower: Mpf, upper: Mpf, bits: int) -> list[ComplexZeroPair]:
    """Return the pairs over a stretch of q, the closest to the real axis first.

    Args:
        radicand: p².
        lower, upper: ends of the stretch, in many digits.
    """
    context = multiprecision(bits)
    width = upper - lower
    found = [
        pair
        for q in _extrema(radicand, float(lower), float(upper))
        if (pair := _refined(radicand, context.convert(q), lower, upper, bits)) and pair.gap < width / 4
    ]
    distinct: list[ComplexZeroPair] = []
    for pair in sorted(found, key=lambda c: c.gap):
        # Newton's method from two points of the grid may end at one place
        if all(abs(pair.place - other.place) > width / _GRID_PLACES for other in distinct):
            distinct.append(pair)
    return distinct


def _extrema(radicand: MomentumSquared, lower: float, upper: float) -> list[float]:
    """Return places on a grid where p² stops growing or falling."""
    q = np.linspace(lower, upper, _GRID_PLACES + 2)[1:-1]
    count(squares=q.size)
    inputs = [float(x) for x in radicand.inputs(64)]
    with np.errstate(all="ignore"):
        # a grid in doubles: a pair it misses costs nodes, never a digit
        rise = np.diff(np.broadcast_to(radicand.squared.run(Float64(), [q, *inputs])[0], q.shape))
    return [float(x) for x in q[1:-1][rise[:-1] * rise[1:] <= 0]]


def _refined(radicand: MomentumSquared, q: Mpf, lower: Mpf, upper: Mpf, bits: int) -> ComplexZeroPair | None:
    """Newton's method for F′ = 0; None where it leaves the stretch."""
    tiny = (upper - lower) * Multi(bits).context.mpf(2) ** (32 - bits)
    place = stationary(lambda x: radicand.jet(x, bits), q, lambda _, x: lower < x < upper, tiny, _NEWTON_STEPS)
    if place is None:
        return None
    value, _, bend = radicand.jet(place, bits)
    # δ = √(2F/|F″|) of the parabola through the minimum of p², or through the maximum next to a pair of poles
    return ComplexZeroPair(place, (2 * abs(value / bend)) ** 0.5) if value > 0 and bend else None
