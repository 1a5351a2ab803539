"""Librations of one coordinate of many orbits: turning points, numbers of nodes, integrals, by kernels over blocks.

p² = (q − a)(b − q) S; J and ∂J/∂c are the integrals of ``kernels.cycle_integrals``, a and b those of
``kernels.outward_search``. Where p² keeps its digits decides how a motion is seen: from the start, by second
differences, where the amplitude is small; else from zero or from the ends of the domain; and with p² to 32 digits where
doubles do not know it well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.floats import EPS, UNIT
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset, offset_in_pairs, place
from hjsolve.ensembles.engine.hidden_barriers import before_barriers
from hjsolve.ensembles.engine.kernels import types
from hjsolve.ensembles.engine.kernels.crowding import CLUSTERINGS
from hjsolve.ensembles.engine.kernels.cycle_integrals import integrals
from hjsolve.ensembles.engine.kernels.outward_search import SearchSide, Slots, smallness, turning_points
from hjsolve.ensembles.engine.kernels.small_motions import small_ends
from hjsolve.ensembles.engine.kernels.types import Modes, Motions, Sums, no_sums
from hjsolve.ensembles.engine.libration_ends import LibrationEnds
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula
from hjsolve.ensembles.engine.node_maps import COUNTS, node_maps
from hjsolve.ensembles.engine.nodes_about_barrier_tops import barrier_tops, singular_pairs
from hjsolve.ensembles.engine.pairs_of_turning_points import in_doubles, in_two_doubles, places_and_errors
from hjsolve.ensembles.engine.programs import ExactPrograms, ViewPrograms, sides
from hjsolve.ensembles.engine.programs_of_small_motions import SmallPrograms, has_slopes
from hjsolve.ensembles.engine.proof_of_resolution import ResolutionProof, least_at_a_glance

_SEARCHING = 72
"""Lanes of searches."""

_SEEN_FROM_START = 1e-13
"""Error of p² at the start over its size above which a motion is seen from its start."""

_STANDING = 2.0**-60
"""Last step of Newton's method, over the distance of the zero of p² next to it, with which a turning point is known.

What is left of it does as many times that to an integral as there are nodes.
"""


class Kept(NamedTuple):
    """Relative errors up to which integrals stay as they are, where others get p² to 32 digits.

    Attributes:
        action: of J.
        means: of ∂J/∂c.
    """

    action: float
    means: float


SMALL = Kept(1e-13, 1e-13)
"""A thousandth of ``passes.TOLERANCE``. A tenth and ten times of either change no bit of 16 000 orbits: what doubles
lose in small motions they lose by far more than this, or not at all."""

_RESTING = 2.0**-40
"""F′ at a place of rest, over what is not known of ½F″ and the size of q, that is no more than rounding."""

APPROXIMATE_SIZES = COUNTS.index(24), COUNTS.index(48)
"""Sizes for rough integrals: of circular anomalies, and of stretched ones."""

_Halves = tuple[ViewPrograms | SmallPrograms | ExactPrograms, ViewPrograms | SmallPrograms | ExactPrograms]


@dataclass(frozen=True)
class TurningPoints:
    """Turning points of n orbits; arrays (2, n), the lower ones first.

    Attributes:
        offsets: in the views of the lower and of the upper half, NaN where none was met.
        places, errors: positions, NaN where there are none, and bounds on their errors.
    """

    offsets: Reals
    places: Reals
    errors: Reals

    def put(self, index: Integers, places: Reals, errors: Reals) -> None:
        """Write those of some orbits."""
        self.places[:, index], self.errors[:, index] = places, errors


def librations(
    one: CoordinateOfOrbits, modes: Modes, *, exact: bool, places: bool, kept: Kept = SMALL
) -> tuple[Sums, TurningPoints]:
    """Integrate one coordinate of many orbits.

    Args:
        modes: what is wanted; ``chords`` and ``shifts`` are not looked at.
        exact: whether those whose errors are not small get p² to 32 digits.
        places: whether the turning points are wanted, too.
        kept: which errors are small.

    Returns:
        The sums, good only where this was enough, and the turning points.
    """
    n = len(one.q)
    sums, found = no_sums(len(one.constants), n), TurningPoints(*(np.full((2, n), np.nan) for _ in range(3)))
    # about a deep maximum of p² its value at the start is a difference of large terms: second differences have the rest
    narrow = np.flatnonzero(_smallness(one) > _SEEN_FROM_START)
    if len(narrow):
        _narrow(one.take(narrow), narrow, modes, sums, found, places)
    wide, slow = np.flatnonzero(~sums.good), np.zeros(n, dtype=bool)
    if len(wide):
        some = one.take(wide)
        chords = all(view.relative is not None for view in some.programs.views)
        part, motions, over = _wide(some, modes._replace(chords=chords, shifts=True))
        slow[wide[over]] = True
        sums.put(wide, part)
        found.offsets[:, wide] = motions.lower, motions.upper
        if places:
            found.put(wide, *_turning_points(some, motions.lower, motions.upper))
    # p² next to a crest that is passed slowly may have no digits in doubles
    # slow ones need 32 digits even without a second pass: doubles do not know p² on the crest
    approximate = np.flatnonzero(np.where(sums.good, approximate_ones(sums, modes, kept) if exact else False, slow))
    if len(approximate):
        better, bases, slopes = _exactly(one.take(approximate), modes)
        fine = np.flatnonzero(better.good)
        sums.put(approximate[fine], better.take(fine))
        if places and len(fine):
            found.put(approximate[fine], *places_and_errors(one.take(approximate), bases, slopes, fine))
    return sums, found


def approximate_ones(sums: Sums, modes: Modes, kept: Kept) -> Mask:
    """Tell which errors are not small.

    Args:
        sums: of n orbits.
        modes: what is wanted.
        kept: which are.
    """
    found: Mask = sums.action_error > kept.action * np.abs(sums.action)
    return found | ((sums.mean_errors > kept.means * np.abs(sums.means)).any(axis=0) if modes.kernels else False)


def _smallness(one: CoordinateOfOrbits) -> Reals:
    """Return the error of p² at the start over about how large p² becomes; 0 where small motions have no view."""
    found = np.zeros(len(one.q))
    if has_slopes(one.coordinate.plain):
        view = one.programs.views[0]
        bend, errors = (code.program(_SEARCHING, one.parameters) for code in (view.bend, view.errors))
        smallness(bend, errors, _walk(one, 0), one.uncertainty, found)
    return found


def _walk(one: CoordinateOfOrbits, upper: int) -> SearchSide:
    formula = sides(one.coordinate)[upper]
    side = (2.0 * upper - 1.0) * formula.sign
    origin = (one.coordinate.lower, one.coordinate.upper)[upper]
    # offsets are counted from the end of the domain: it lies at 0
    floor = side * np.inf if origin is None else 0.0
    # beyond a turn p² repeats itself
    reach = 2 * np.pi if one.coordinate.periodic else np.inf
    return SearchSide(np.ascontiguousarray(offset(formula, one.q)), one.P, one.constants, floor, side, reach)


# ------------------------------------------------------------------------------------------------- seen from the ends
def _over_barrier_tops(
    one: CoordinateOfOrbits, motions: Motions, placed: Motions, known: tuple[Sums, Modes, _Halves]
) -> Integers:
    """Integrate motions that pass slowly over a crest or by a pair of singularities, where other nodes were not enough.

    Return which pass over a crest.
    """
    sums, modes, programs = known
    over = np.empty(0, dtype=np.int64)
    # a pair of singularities leaves rough integrals finite: no other nodes are wanted
    for finder in (barrier_tops,) if modes.approximate else (barrier_tops, singular_pairs):
        left = np.flatnonzero(~sums.good & (motions.width > 0))
        if not len(left):
            break
        found = finder(one.take(left), placed.lower[left], placed.width[left])
        some = left[found.orbits]
        if not len(some):
            continue
        # the crest is moved to the middle: each end sees its half
        first, none = node_maps().index(found.maps), np.zeros(len(some), dtype=np.int64)
        own, where = (
            _taken(x, some)._replace(first=first, fraction=none, barrier_top=found.places) for x in (motions, placed)
        )
        sums.put(some, _resolved(one.take(some), own, where, modes, programs))
        over = some if finder is barrier_tops else over
    return over


def _wide(one: CoordinateOfOrbits, modes: Modes) -> tuple[Sums, Motions, Integers]:
    """Integrate motions seen from zero, or from the ends of the domain; good only where this was enough.

    Also return which pass slowly over a crest.
    """
    motions, ends = _between(one)
    sums, slow = _by_any_nodes(one, motions, ends, modes)
    left = np.flatnonzero(~sums.good & (motions.width > 0))
    offered = np.stack([motions.lower[left], motions.upper[left]])
    # F < 0 at a node: the search stepped over a barrier, and the nearer turning point is the right one
    hidden, places = before_barriers(one.take(left), offered)
    hidden = left[hidden]
    if len(hidden):
        own = one.take(hidden)
        nearer, their_ends = _motions(own, places)
        part, _ = _by_any_nodes(own, nearer, their_ends, modes)
        good = np.flatnonzero(part.good)
        sums.put(hidden[good], part.take(good))
        motions.lower[hidden], motions.upper[hidden] = places
        slow = np.setdiff1d(slow, hidden[good])
    return sums, motions, slow


def _by_any_nodes(
    one: CoordinateOfOrbits, motions: Motions, ends: LibrationEnds, modes: Modes
) -> tuple[Sums, Integers]:
    """Integrate motions between turning points with all maps of nodes in turn; return which pass over a crest, too."""
    below, above = one.programs.views
    sums = _resolved(one, motions, motions, modes, (below, above))
    again = np.flatnonzero(~sums.good & (motions.width > 0) & ~ends.even)
    if len(again):  # a zero and a pole beyond an end may hide each other: both ends as if they were like the worse one
        first, fraction = ends.take(again).maps(motions.width[again], alike=True)
        part = _taken(motions, again)._replace(first=first, fraction=fraction)
        sums.put(again, _resolved(one, part, part, modes, (below, above)))
    return sums, _over_barrier_tops(one, motions, motions, (sums, modes, (below, above)))


def _between(one: CoordinateOfOrbits) -> tuple[Motions, LibrationEnds]:
    """Return the motions between their turning points, in doubles."""
    n = len(one.q)
    places, bends = np.empty((2, n)), np.empty((2, 2, n))
    slots = Slots(np.zeros((5, _SEARCHING), dtype=np.int64), np.empty((4, _SEARCHING)), np.empty((3, n)))
    for upper, view in enumerate(one.programs.views):
        walk = _walk(one, upper)
        bend, slopes = (code.program(_SEARCHING, one.parameters) for code in (view.bend, view.slopes))
        turning_points(bend, slopes, walk, places[upper], bends[upper], slots)
    return _placed_between(one, places, bends)


def _motions(one: CoordinateOfOrbits, places: Reals) -> tuple[Motions, LibrationEnds]:
    """Return the motions between turning points that are known, shape (2, n)."""
    bends = np.empty((2, *places.shape))
    for k, view in enumerate(one.programs.views):
        bends[k] = run_rows(view.bend, one.parameters, np.stack([places[k], *one.constants]))[1:]
    bends[:, 1] *= 0.5
    return _placed_between(one, places, bends)


def _placed_between(one: CoordinateOfOrbits, places: Reals, bends: Reals) -> tuple[Motions, LibrationEnds]:
    n, walks = len(one.q), [_walk(one, upper) for upper in (0, 1)]
    distances = [walk.side * (x - walk.start) for walk, x in zip(walks, places, strict=True)]
    below, above = sides(one.coordinate)
    if one.rest is not None:
        distances = [distances[0] + one.rest, distances[1] - one.rest]
    width = distances[0] + distances[1]
    # p²(−q) = p²(q) and a motion about q = 0: the integrands have period π, and half of the nodes do
    even = one.coordinate.even & (np.abs(distances[0] - distances[1] - 2 * one.q) <= 1e-13 * width)
    ends = LibrationEnds(node_maps(), bends, np.array([float(below.sign), -float(above.sign)]), even)
    first, fraction = ends.maps(width)
    homes = np.stack([home(below, places[0], above, places[1]), home(above, places[1], below, places[0])])
    motions = Motions(
        momentum=one.P, left=distances[0], right=distances[1], width=width, lower=places[0], upper=places[1],
        homes=homes, signs=ends.signs, known=np.ascontiguousarray(one.constants.T),
        uncertainty=np.ascontiguousarray(one.uncertainty.T), first=first, least=np.zeros(n, dtype=np.int64),
        fraction=fraction, barrier_top=np.ones(n),
    )  # fmt: skip
    return motions, ends


def _resolved(one: CoordinateOfOrbits, motions: Motions, placed: Motions, modes: Modes, programs: _Halves) -> Sums:
    """Integrate with as many nodes as are proved to resolve every motion, which lies where ``placed`` says."""
    below, above = sides(one.coordinate)
    if modes.approximate:
        # a guess for Newton's method on actions: no claim, hence no proof
        motions.least[:] = np.where(motions.first < len(CLUSTERINGS), *APPROXIMATE_SIZES)
        return _integrated(one, motions, modes, programs)
    # nodes are not believed by their own coefficients: a dip between two of them has none
    proof, n = ResolutionProof(node_maps(), placed, below.clearance, above.clearance), len(motions.width)
    span = np.stack([np.zeros(n, dtype=np.int64), np.full(n, len(COUNTS))])
    least = proof.least(np.arange(n), motions.first, span)
    if modes.oscillations:  # coefficients as they are, not nearly squared: never enough, of stretched maps by far
        most = len(COUNTS) - 1
        least = np.where(least < 0, least, np.minimum(least + np.where(motions.first < len(CLUSTERINGS), 1, 2), most))
    motions.least[:] = least
    sums = _integrated(one, motions, modes, programs)
    # the rule took another map than the one that was proved: it is proved afterwards
    crowded = np.flatnonzero(sums.good & (sums.chosen[1] != motions.first))
    if len(crowded):
        size, map_ = sums.chosen[:, crowded]
        sums.good[crowded] = proof.least(crowded, map_, np.stack([size, size + 1])) >= 0
    return sums


def _integrated(one: CoordinateOfOrbits, motions: Motions, modes: Modes, programs: _Halves) -> Sums:
    tables, m = node_maps().tables, len(one.constants)
    sums = no_sums(m, len(motions.width))
    below, above = sides_of(programs, tables, one.parameters)
    work = types.scratch(tables, m if modes.kernels else 0)
    integrals(below, above, motions, tables, modes, sums, work, np.zeros(m))
    return sums


def sides_of(programs: _Halves, tables: types.Tables, parameters: tuple[float, ...]) -> tuple[types.Side, types.Side]:
    """Return what kernels take of the programs of the lower and of the upper half.

    Args:
        tables: of nodes.
        parameters: values of the parameters.
    """
    below, above = (
        types.side(p.fill, p.errors, p.relative, tables, parameters, half) for half, p in enumerate(programs)
    )
    return below, above


def _turning_points(one: CoordinateOfOrbits, lower: Reals, upper: Reals) -> tuple[Reals, Reals]:
    """Return turning points and bounds on their errors: what the rounding of F there leaves of them."""
    known, places, errors = np.concatenate([one.constants, one.uncertainty]), [], []
    for formula, view, x in zip(sides(one.coordinate), one.programs.views, (lower, upper), strict=True):
        with np.errstate(all="ignore"):
            given = np.stack([x, 2 * UNIT * np.abs(x), np.ones_like(x), *known])
            noise = run_rows(view.errors, one.parameters, given)[0]
            slope = run_rows(view.slopes, one.parameters, np.stack([x, *one.constants]))[1]
            q = place(formula, x)
            errors.append(noise / np.abs(slope) + EPS * np.abs(x) + 2 * EPS * (np.abs(q) + np.abs(x)))
        places.append(q)
    return np.stack(places), np.stack(errors)


# ------------------------------------------------------------------------------------------------- to 32 digits
def _exactly(one: CoordinateOfOrbits, modes: Modes) -> tuple[Sums, list[Reals], Reals]:
    """Integrate with p² to 32 digits, next to turning points to 32 digits: for close zeros of p².

    Also return the turning points, high and low parts of the lower and of the upper one, and F′ there.
    """
    placed, ends = _between(one)
    C = np.concatenate([one.constants, one.low])
    bases, distances, bends = [], [], ends.bends.copy()
    for k, (formula, x) in enumerate(zip(sides(one.coordinate), (placed.lower, placed.upper), strict=True)):
        base, slope, step = in_two_doubles(one, k, x)
        here = offset_in_pairs(formula, one.q, 0.0 if one.rest is None else one.rest)
        with np.errstate(all="ignore"):
            # the distance of the next zero: F′/(½F″) next to a close one
            scale = np.fmin(placed.width, np.abs(slope / bends[k, 1]))
            # a step that still moves, or a slope that changed its sign, is another zero's
            known = (np.abs(step) <= _STANDING * scale) & (slope * bends[k, 0] > 0)
            distances.append(np.where(known, np.abs(DoubleDouble().sub(here, base).high), np.nan))
        bases += [base.high, base.low]
        bends[k, 0] = slope
    left, right = distances
    # F′ at the exact turning points says better than before how near the next zero is
    first, _ = ends._replace(bends=bends).maps(left + right)
    fraction = np.zeros_like(first)  # turning points to 32 digits leave nothing to be lost far from them
    motions = placed._replace(
        left=left, right=right, width=left + right, lower=0.0 * left, upper=0.0 * right,
        homes=np.zeros((2, len(left))), first=first, fraction=fraction,
        known=np.ascontiguousarray(np.stack([*C, *bases], axis=1)),
        uncertainty=np.ascontiguousarray(in_doubles(one).T),
    )  # fmt: skip
    placed = placed._replace(width=motions.width, first=first, fraction=fraction)
    modes = modes._replace(chords=False, shifts=False)
    sums = _resolved(one, motions, placed, modes, one.programs.exact)
    _over_barrier_tops(one, motions, placed, (sums, modes, one.programs.exact))
    return sums, bases, bends[:, 0]


# ------------------------------------------------------------------------------------------------- seen from the start
def seen_from_start(one: CoordinateOfOrbits, modes: Modes) -> tuple[Sums, Reals, Reals]:
    """Integrate motions about a maximum of p² that is deep next to them.

    Args:
        modes: what is wanted; ``chords`` and ``shifts`` are not looked at.

    Returns:
        The sums, good only where motions are as small as that; what programs of small motions know, shape
        (constants + ``SMALL_KNOWN``, n); turning points as offsets from the start, shape (2, n).
    """
    made, n = one.programs.small, len(one.q)
    modes = modes._replace(chords=modes.kernels, shifts=False)
    (first,) = run_rows(made.slope, one.parameters, np.stack([one.q, *one.constants, *one.low]))
    # F = P₀² + x (F′₀ + x t): P₀² from the momentum, which does not cancel
    known = np.stack([*one.constants, one.q, one.P**2, first, 0 * one.q, 0 * one.q])
    floors = np.stack([np.full(n, -np.inf), np.full(n, np.inf)])
    for k, formula in enumerate((one.coordinate.lower, one.coordinate.upper)):
        if formula is not None:
            floors[k] = -formula.sign * offset(formula, one.q)
    ends, work = np.empty((2, n)), (np.empty((7, _SEARCHING)), np.zeros(_SEARCHING, dtype=np.int64))
    value, bounds = (code.program(_SEARCHING, one.parameters) for code in (made.value, made.bounds))
    small_ends(value, bounds, known, one.uncertainty, floors, ends, *work)
    return _small(one, modes, known, ends), known, ends


def _narrow(
    one: CoordinateOfOrbits, index: Integers, modes: Modes, sums: Sums, found: TurningPoints, places: bool
) -> None:
    """Integrate motions about a maximum of p² that is deep next to them, or that stay there."""
    part, known, ends = seen_from_start(one, modes)
    sums.put(index, part)
    if places:
        good = np.flatnonzero(part.good)
        found.put(index[good], *_turning_points_from_start(one.take(good), known[:, good], ends[:, good]))
    # no amplitude at all: a place of rest, if F′ is rounding
    still = np.flatnonzero((one.P == 0) & ~part.good)
    if len(still):
        resting, q = _at_rest(one.take(still), known[len(one.constants) + 2, still]), one.q[still]
        sums.put(index[still], resting)
        fine = np.flatnonzero(resting.good)
        found.put(index[still[fine]], np.stack([q[fine]] * 2), np.stack([4 * EPS * np.abs(q[fine])] * 2))


def _small(one: CoordinateOfOrbits, modes: Modes, known: Reals, ends: Reals) -> Sums:
    plain, (low, high), maps = one.coordinate.plain, ends, node_maps()
    width = high - low
    with np.errstate(invalid="ignore"):
        middle = one.q + 0.5 * (low + high)
        if modes.approximate:
            least = np.full(len(width), APPROXIMATE_SIZES[0])
        else:
            least = least_at_a_glance(maps, plain.clearance, tuple(one.constants), middle, width)
    none = np.zeros(len(width), dtype=np.int64)
    motions = Motions(
        momentum=one.P, left=-low, right=high, width=width, lower=low, upper=high, homes=ends,
        signs=np.array([1.0, -1.0]), known=np.ascontiguousarray(known.T),
        uncertainty=np.ascontiguousarray(one.uncertainty.T), first=none, least=least, fraction=none,
        barrier_top=np.ones(len(width)),
    )  # fmt: skip
    some = np.flatnonzero((least < 0) & (width > 0))
    if len(some):
        placed = motions._replace(lower=one.q + low, upper=one.q + high)
        span = np.stack([np.zeros(len(some), dtype=np.int64), np.full(len(some), len(COUNTS))])
        proof = ResolutionProof(maps, placed, plain.clearance, plain.clearance)
        least[some] = proof.least(some, motions.first[some], span)
    made = one.programs.small
    return _integrated(one, motions, modes, (made, made))


def _turning_points_from_start(one: CoordinateOfOrbits, known: Reals, ends: Reals) -> tuple[Reals, Reals]:
    """Return turning points of small motions.

    |F′| there is W S, with S = 4F/W² from the middle, of which half is taken.
    """
    code, (low, high), errors = one.programs.small.errors, ends, []

    def looked(x: Reals) -> Reals:
        given = np.stack([x, 0 * x, np.ones_like(x), *known, *one.uncertainty])
        return run_rows(code, one.parameters, given)

    with np.errstate(all="ignore"):
        # F in the middle is W²S/4 and |F′| at the ends W S; half of that is taken
        slope = 2 * looked(0.5 * (low + high))[-1] / (high - low)
        places = one.q + ends
        for x, q in zip(ends, places, strict=True):
            errors.append(looked(x)[0] / slope + EPS * np.abs(x) + 2 * EPS * (np.abs(q) + np.abs(x)))
    return places, np.stack(errors)


def _at_rest(one: CoordinateOfOrbits, first: Reals) -> Sums:
    """Return a stable double zero of p²: J = 0 and ∂J/∂cⱼ = kⱼ/√(−½F″), the limit of a vanishing libration."""
    m, made = len(one.constants), one.programs.small
    given = np.stack([one.q, *one.constants, *one.uncertainty])
    sums = no_sums(m, len(one.q))
    with np.errstate(all="ignore"):
        bend, uncertainty = run_rows(made.bounds, one.parameters, given)
        kernels, errors = np.split(run_rows(made.kernels, one.parameters, given), 2)
        # √(−½F″) is the frequency of the vanishing libration, on the scale of the kernels
        root = np.sqrt(-bend)
        sums.means[:] = kernels / root
        sums.mean_errors[:] = errors / root + np.abs(kernels / root) * uncertainty / -bend
        resting = (np.abs(first) <= _RESTING * uncertainty * np.maximum(np.abs(one.q), _RESTING)) & np.isfinite(root)
    sums.speeds[:] = sums.means
    for zero in ("action", "action_error", "oscillations", "oscillation_errors", "phase", "phase_error"):
        getattr(sums, zero)[...] = 0.0
    sums.good[:] = resting
    return sums


# ------------------------------------------------------------------------------------------------- some of them
def _taken(motions: Motions, index: Integers) -> Motions:
    arrays = {name: getattr(motions, name)[index] for name in motions._fields if name not in {"signs", "homes"}}
    return Motions(**arrays, signs=motions.signs, homes=np.ascontiguousarray(motions.homes[:, index]))


def home(view: LoweredFormula, own: Reals, other: LoweredFormula, far: Reals) -> Reals:
    """Return that turning point, as an offset in a view, from which places keep their digits: the one nearer to x = 0.

    Args:
        view, own: of the turning point from which p² is seen there.
        other, far: of the other one.
    """
    # both ends of the domain have offsets of their own: one is expressed in the other's
    moved = DoubleDouble().sub(other.origin, view.origin).high
    found = view.sign * (moved + other.sign * far)
    return np.where((np.abs(found) < np.abs(own)) & (np.abs(moved) <= np.abs(found)), found, own)
