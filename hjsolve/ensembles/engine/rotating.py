"""Motions that go round and round: p² > 0 all along the turn of a periodic coordinate.

J = (1/2π) ∮ |p| dq and ∂J/∂cⱼ = (1/2π) ∮ kⱼ dq/|p| over one turn, by the midpoint rule (``kernels.turn_integrals``;
Trefethen & Weideman, SIAM Review 56 (2014) 385, §3) in the anomaly of the slow places (``rotation_anomalies``).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.over_rows import WIDTH
from hjsolve.arithmetic.machine.run import MachineProgram
from hjsolve.arithmetic.number_types import Complexes, Integers, Reals
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits
from hjsolve.ensembles.engine.kernels.minima_over_a_turn import POINTS, Valleys, ValleyScratch, valleys_of_turns
from hjsolve.ensembles.engine.kernels.turn_integrals import Rounds, Turns, TurnScratch, series_of_turns
from hjsolve.ensembles.engine.kernels.turn_integrals import rotations as integrated
from hjsolve.ensembles.engine.kernels.types import Modes, Sums, no_sums
from hjsolve.ensembles.engine.maps_of_turns import COUNTS, turn_maps
from hjsolve.ensembles.engine.nodes import rotation_nodes
from hjsolve.ensembles.engine.program_parts import FINER
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.engine.rotation_anomalies import SlowPlaces, slow_places
from hjsolve.ensembles.engine.strips_of_analyticity import covered_turn
from hjsolve.ensembles.engine.turned_circle import moved_disks

_GRID = np.pi * (1 + 2 * np.arange(POINTS) / POINTS)
"""Where p² > 0 is looked at."""
_CROWDED = 28, 7
"""Nodes that stretched anomalies mostly need, and how many more for each level; fewer are not tried. Half and twice of
either change last bits and no time."""
_FIRST = 32
"""Nodes that circular anomalies are tried with first: fewer suffice for p² that hardly varies, and cost as much."""
_FRACTION_OF_ROUGH = 0.5
"""Of the nodes with which rough integrals begin: half as many digits."""
_UNKNOWN, _CAUTIOUS, _HOPELESS = 0.4, 0.7, 2.0
"""The nodes needed grow nearly like the fraction of the radius that is missing, at least with this power; for stretched
anomalies, and where nothing is known, as if the fraction were 0.4 at least. Twice as many as there are is too many.
Tried size by size, orbits whose p² has singularities next to the turn, √(11/10 + cos φ), take 1.3 to 1.6 times as long;
half and twice of each change no bit of 24 000 other orbits."""
_CLOSE = 0.5
"""A fraction of a coarse cover from which on a finer one may be enough: it was for each of 526 of 700 orbits of
1/(11/10 − cos 2φ) + cos φ; orbits of entire p² ask for none."""
_NODES = 1 << 20
"""Of all orbits that are looked at together."""


class Rotations(NamedTuple):
    """Orbits that go round.

    Attributes:
        orbits: which they are, shape (n,).
        slow: how their nodes crowd.
    """

    orbits: Integers
    slow: SlowPlaces


def going_round(one: CoordinateOfOrbits) -> Rotations:
    """Find those of many orbits that go round.

    Args:
        one: a periodic coordinate of the orbits.
    """
    program = one.programs.views[0].bend.program(WIDTH, one.parameters)
    valleys = Valleys(*np.empty((len(Valleys._fields), len(one.q))))
    work = ValleyScratch(np.empty((POINTS, WIDTH)), np.empty((2, WIDTH)))
    valleys_of_turns(program, one.constants, _GRID, valleys, work)
    going = np.flatnonzero(np.isfinite(valleys.place) & np.isfinite(one.P) & (one.P != 0))
    with np.errstate(all="ignore"):
        slow = slow_places(Valleys(*(x[going] for x in valleys)))
    # p² at its minimum decides whether it goes round
    sure = np.flatnonzero(slow.least > 0)
    return Rotations(going[sure], slow.take(sure))


def rotations(one: CoordinateOfOrbits, slow: SlowPlaces, modes: Modes, *, finely: bool) -> Sums:
    """Integrate orbits that go round.

    Args:
        one: the coordinate of these orbits.
        slow: how their nodes crowd.
        finely: whether with p² to 32 digits.

    Returns:
        The sums, good only where this was enough.
    """
    if modes.approximate:  # a guess for Newton's method on actions: no claim, hence no proof
        least = _roughly_enough(slow)
    else:
        least = _least(sides(one.coordinate)[0].clearance, slow, np.sign(one.P))
    sums, motions = no_sums(len(one.constants), len(one.q)), _rounds(one, slow, least, finely=finely)
    programs, tables, work = _programs(one, modes, finely=finely)
    integrated(*programs, motions, tables, modes, sums, work, finely)
    return sums


def rough_series(one: CoordinateOfOrbits, slow: SlowPlaces, coefficients: Reals) -> Sums:
    """Integrate orbits that go round by rough integrals, with the series of their running integrals.

    Args:
        one: the coordinate of these orbits.
        slow: how their nodes crowd.
        coefficients: filled, shape (n, constants, 2 terms).

    Returns:
        The sums, good only where this was enough.
    """
    modes = Modes(chords=False, kernels=True, oscillations=True, shifts=False, approximate=True)
    sums, motions = no_sums(len(one.constants), len(one.q)), _rounds(one, slow, _roughly_enough(slow), finely=False)
    programs, tables, work = _programs(one, modes, finely=False)
    series_of_turns(*programs, motions, tables, modes, sums, work, coefficients)
    return sums


def _roughly_enough(slow: SlowPlaces) -> Integers:
    """Return the size with which rough integrals begin."""
    return np.searchsorted(COUNTS, _FRACTION_OF_ROUGH * _usual(slow)).astype(np.int64)


def _rounds(one: CoordinateOfOrbits, slow: SlowPlaces, least: Integers, *, finely: bool) -> Rounds:
    zero = 0.0 * slow.centre
    # the bound that programs in doubles need, as in ``librating``
    lost = np.maximum(one.uncertainty - np.abs(one.low), 0.0) / FINER  # by doubles, of the constants
    known = [*one.constants, *one.low, slow.centre, zero, slow.centre, zero] if finely else one.constants
    return Rounds(
        centre=slow.centre, left=one.q - slow.centre, opposite=slow.opposite, ratio=slow.ratio,
        direction=np.sign(one.P), known=np.ascontiguousarray(np.stack([*known], axis=1)),
        uncertainty=np.ascontiguousarray((one.uncertainty + (lost if finely else 0.0)).T),
        map=turn_maps().index(slow.level, slow.several), least=least,
    )  # fmt: skip


def _programs(
    one: CoordinateOfOrbits, modes: Modes, *, finely: bool
) -> tuple[tuple[MachineProgram, MachineProgram], Turns, TurnScratch]:
    """Return the programs of nodes and of bounds on errors there, tables that hold the maps in use, and scratch."""
    view, exact, tables = one.programs.views[0], one.programs.exact[0], turn_maps().tables
    width = tables.angle.shape[2]
    codes = (exact.fill, exact.errors) if finely else (view.turn, view.errors)
    work = TurnScratch(np.empty(1 + (len(one.constants) if modes.kernels else 0)), np.empty((2, width)))
    nodes, bounds = (code.program(width, one.parameters) for code in codes)
    return (nodes, bounds), tables, work


def _least(clearance: Clearance, slow: SlowPlaces, direction: Reals) -> Integers:
    """Return the first size that is proved to resolve each orbit, −1 for none: p² is known between the nodes.

    See ``proof_of_resolution``; what is proved for a number of nodes is proved for more, whose strip is narrower.
    """
    found = np.full(len(slow.level), -1, dtype=np.int64)
    # fewer nodes than these hardly ever suffice: to look for a proof would cost more than the nodes
    hint = _usual(slow)
    codes = 2 * slow.level + slow.several
    for k, count in enumerate(COUNTS):
        chosen = np.flatnonzero((found < 0) & (hint <= count))
        for left in np.array_split(chosen, len(chosen) * count // _NODES + 1) if len(chosen) else []:
            fraction = np.zeros(len(left))
            for code in np.unique(codes[left]):
                part = np.flatnonzero(codes[left] == code)
                # fewer and larger disks first; the finer cover where they came near
                for coarse in (True, False):
                    some = left[part]
                    fraction[part] = _fraction(clearance, slow.take(some), direction[some], count, coarse=coarse)
                    part = part[(fraction[part] >= _CLOSE) & (fraction[part] < 1) & (code >= 2)]
                    if not len(part):
                        break
            found[left[fraction >= 1]] = k
            floor = np.where((fraction > 0) & (slow.level[left] == 0), 0.0, _UNKNOWN)
            # the strip of N nodes is as wide as 1/N: a radius that is too small by a factor asks for about as many more
            # nodes
            guess = count * np.fmax(fraction, np.fmax(floor, 1e-3)) ** -_CAUTIOUS
            hint[left] = np.where(guess < _HOPELESS * COUNTS[-1], np.minimum(guess, COUNTS[-1]), np.inf)
    return found


def _usual(slow: SlowPlaces) -> Reals:
    """Return the nodes over half a turn that orbits mostly need, at least."""
    return np.where(slow.level > 0, np.maximum(_FIRST, _CROWDED[0] + _CROWDED[1] * slow.level), float(_FIRST))


def _fraction(clearance: Clearance, slow: SlowPlaces, direction: Reals, count: int, *, coarse: bool) -> Reals:
    """Return the least radius that is known over the one needed, of orbits with the same nodes.

    0 where am has a pole.
    """
    over = covered_turn(rotation_nodes(2 * count, int(slow.level[0]), 1 + int(slow.several[0])), coarse=coarse)
    if not over.inside:
        # am has a logarithmic branch point in the strip: no disk covers it
        return np.zeros(len(slow.level))
    angle: Complexes | Reals = over.angle
    radii = over.reach
    if slow.several[0]:
        angle, radii = moved_disks(over.angle, over.reach, slow.ratio[:, None])
    with np.errstate(all="ignore"):
        places = slow.centre[:, None] + direction[:, None] * angle
        known = clearance.radius(places.ravel()).reshape(places.shape)
        least: Reals = (known / radii).min(axis=1)
    return least
