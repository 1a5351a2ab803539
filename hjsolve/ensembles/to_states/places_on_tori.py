"""Where the coordinates of n tori are at given phases, and how fast places and momenta change along them.

q = a + W sin²(φ/2) between turning points a and b = a + W, the sign of p being that of sin φ; of a rotation φ is q
itself. F = p² comes from 32 digits, seen from the nearer turning point, so that p keeps its digits next to it.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import WIDTH, run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset, place, squares
from hjsolve.ensembles.engine.kernels.followed_librations import moved_ends
from hjsolve.ensembles.engine.kernels.types import Modes
from hjsolve.ensembles.engine.pairs_of_turning_points import in_two_doubles
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import sides
from hjsolve.ensembles.to_states.narrow_tori import narrow_at, narrow_ones, turning_points
from hjsolve.ensembles.to_states.tori import AngleTask, Tori, coordinate_at, kernels, summits

_PLACES = Modes(chords=False, kernels=False, oscillations=False, shifts=False)
_PAIR_STEPS = 4
"""Steps of Newton's method for turning points in two doubles."""
_KNOWN, _SURE = 1e-7, 1e-12
"""Last step of a turning point, over the width, with which it is known on the way to a torus, and on it."""
_NEXT_TO = 0.01
"""How far, over the width, a turning point may lie from that of the last torus on the way and be taken for its own."""
_TURNING, NEXT = 1e-60, 1e-17
"""Sine or cosine of φ/2 that stands for 0, and the distance from a turning point, over W and over F′/½F″, below which F
is linear."""


class Frames(NamedTuple):
    """Between what the coordinates of n tori move.

    Attributes:
        bases: of each coordinate the turning points in two doubles, offsets in the views of the lower and the upper
            half; shape (separated, 4, n).
        widths: W, shape (separated, n).
        directions: −1 for a rotation the other way, else 1, the same shape.
        rotating, resting: which go round, and which stay; the same shape.
        narrow: what is known of narrow librations, shape (separated, ``ROWS``, n).
        good: where turning points are known, shape (n,).
    """

    bases: Reals
    widths: Reals
    directions: Reals
    rotating: Mask
    resting: Mask
    narrow: Reals
    good: Mask

    def take(self, index: Integers | Mask) -> Frames:
        """Return those of some tori."""
        return Frames._make(x[..., index] for x in self)


class Placed(NamedTuple):
    """Coordinates at their phases; arrays (separated, n), kernels (separated, constants, n).

    Attributes:
        q, P: places and shell momenta.
        moves: dq/dφ.
        forces: dP/dφ.
        rates: kernels over P times dq/dφ.
        rounding: what 32 digits of p² leave open of P: next to the turning points of the smallest motions p² has few.
        rest: what the rounding of q leaves of the place.
    """

    q: Reals
    P: Reals
    moves: Reals
    forces: Reals
    rates: Reals
    rounding: Reals
    rest: Reals

    def take(self, index: Integers | Mask) -> Placed:
        """Return those of some states."""
        return Placed._make(x[..., index] for x in self)


def blurred(frames: Frames, at: Placed) -> Reals:
    """Return what the rounding of q to a double, and that of P, do to phases, shape (separated, n).

    The engine reads phases off q, or next to a turning point off P: δφ = δq/W, or φ δP/P.

    Args:
        frames: between what n tori move.
        at: states on them.
    """
    between = ~frames.rotating & ~frames.resting
    with np.errstate(all="ignore"):
        sines = 2 * np.abs(at.moves) / frames.widths
        return np.where(between, EPS * np.abs(at.q) / frames.widths + sines * at.rounding / np.abs(at.P), 0.0)


def frames_of(
    task: AngleTask, tori: Tori, directions: Reals, rotating: Mask, resting: Mask, narrow: Reals
) -> Frames:  # fmt: skip
    """Find the turning points of tori in two doubles.

    Args:
        directions: sign of each rotation.
        rotating, resting: which go round, and which stay at their place; shape (separated, n).
        narrow: what is known of narrow librations, shape (separated, ``ROWS``, n).
    """
    size, n = tori.q.shape
    bases, widths, good = np.zeros((size, 4, n)), np.zeros((size, n)), np.ones(n, dtype=bool)
    tight = narrow_ones(narrow)
    for k in range(size):
        some = np.flatnonzero(tight[k])
        bases[k][:, some], widths[k, some] = turning_points(task.model.separated[k], narrow[k][:, some])
        moving = ~rotating[k] & ~resting[k] & ~tight[k]
        some = np.flatnonzero(moving)
        if not len(some):
            continue
        own = tori.take(some)
        bases[k][:, some], widths[k, some], known = ends_of(
            task, own, k, width_of(task, k, own.ends[k]), pairs=_PAIR_STEPS
        )
        lower, upper = (
            place(formula, bases[k, 2 * side, some]) for side, formula in enumerate(sides(task.model.separated[k]))
        )
        known &= (lower <= own.q[k]) & (own.q[k] <= upper)
        # next to a separatrix a step may go over the barrier, to the far end of another well
        known &= (np.abs(bases[k][::2, some] - own.ends[k][::2]) <= _NEXT_TO * widths[k, some]).all(axis=0)
        left = some[~known]
        if len(left):
            own = tori.take(left)
            F = squares(coordinate_at(*task, own, k), own.q[k])
            one = coordinate_at(*task, own, k, np.sqrt(np.fmax(F, 0)))
            _, found, _ = integrated(one, _PLACES, exact=False, places=True)
            bases[k][:, left] = refined(task, own, k, found.places)
            widths[k, left] = width_of(task, k, bases[k][:, left])
            good[left] &= (F > 0) & (widths[k, left] > 0) & np.isfinite(bases[k][:, left]).all(axis=0)
    return Frames(bases, widths, directions, rotating, resting, narrow, good)


def ends_of(task: AngleTask, tori: Tori, k: int, widths: Reals, *, pairs: int) -> tuple[Reals, Reals, Mask]:
    """Return the turning points of one coordinate that are next to its ``ends``, widths, and which are known.

    Args:
        widths: between its ``ends``, shape (n,).
        pairs: steps to 32 digits.
    """
    one, bases = coordinate_at(*task, tori, k), tori.ends[k].copy()
    last, known = np.empty((2, len(widths))), np.concatenate([one.constants, one.low])
    for side, barrier in enumerate(_barriers(one)):
        slopes, squares = one.programs.views[side].slopes, one.programs.exact[side].squares
        first, second = (code.program(WIDTH, one.parameters, side) for code in (slopes, squares))
        moved_ends(first, second, known, bases[2 * side : 2 * side + 2], widths, pairs, barrier, last[side])
    W = width_of(task, k, bases)
    with np.errstate(invalid="ignore"):
        good = (W > 0) & (last.max(axis=0) * widths <= (_KNOWN if pairs == 1 else _SURE) * W)
    return bases, W, np.asarray(good)


def _barriers(one: CoordinateOfOrbits) -> tuple[bool, bool]:
    """Whether offsets of lower and of upper turning points are distances from an end of the domain."""
    lower, upper = one.coordinate.lower, one.coordinate.upper
    return lower is not None, upper is not None or (lower is not None and lower.origin.high == 0)


def refined(task: AngleTask, tori: Tori, k: int, places: Reals, steps: int = _PAIR_STEPS) -> Reals:
    """Return turning points in two doubles, offsets in the views of both halves, shape (4, n).

    Args:
        k: which coordinate.
        places: lower and upper turning points in doubles, shape (2, n).
        steps: of Newton's method.
    """
    one = coordinate_at(*task, tori, k)
    starts = [offset(formula, x) for formula, x in zip(sides(one.coordinate), places, strict=True)]
    return np.concatenate([in_two_doubles(one, side, x, steps)[0] for side, x in enumerate(starts)])


def width_of(task: AngleTask, k: int, bases: Reals) -> Reals:
    """B − a from turning points in two doubles, each in its own view."""
    D = DoubleDouble()
    ends = []
    for side, formula in enumerate(sides(task.model.separated[k])):
        x = Pair(*bases[2 * side : 2 * side + 2])
        ends.append(D.add(formula.origin, Pair(formula.sign * x.high, formula.sign * x.low)))
    return D.sub(ends[1], ends[0]).high


def placed(
    task: AngleTask, tori: Tori, frames: Frames, φ: Reals, *, exact: bool = True, bounds: bool = False
) -> Placed:
    """Return coordinates at phases.

    Args:
        frames: between what they move.
        φ: phases, shape (separated, n).
        exact: whether librations have p² from 32 digits; doubles do for searches.
        bounds: whether what that leaves open of P is worked out, too.
    """
    size, n = φ.shape
    m = len(task.model.constants)
    found = Placed._make((*(np.zeros((size, n)) for _ in range(4)), np.zeros((size, m, n)), *np.zeros((2, size, n))))
    for k in range(size):
        stays, turns, tight = frames.resting[k], frames.rotating[k], narrow_ones(frames.narrow)[k]
        between = partial(_between, exact=exact, bounds=bounds)
        for some, how in (
            (stays, _at_rest), (turns, _on_turn), (tight, _about_maximum), (~stays & ~turns & ~tight, between),
        ):  # fmt: skip
            index = np.flatnonzero(some)
            if len(index):
                part = how(task, tori.take(index), frames.take(index), k, φ[k, index])
                for whole, own in zip(found, part, strict=True):
                    whole[k][..., index] = own
    return found


_Row = tuple[Reals, Reals, Reals, Reals, Reals, Reals, Reals]


def _at_rest(task: AngleTask, tori: Tori, _: Frames, k: int, φ: Reals) -> _Row:
    """Return a coordinate that stays where F′ = 0: χ is φ, and the kernels over its frequency √(−½F″) are its rates."""
    q, bend = summits(coordinate_at(*task, tori, k), tori.q[k])
    with np.errstate(all="ignore"):
        rates = kernels(coordinate_at(*task, tori._replace(q=changed(tori.q, k, q)), k)) / np.sqrt(-0.5 * bend)
    return q, 0 * φ, 0 * φ, 0 * φ, rates, 0 * φ, 0 * φ


def _on_turn(task: AngleTask, tori: Tori, frames: Frames, k: int, φ: Reals) -> _Row:
    """Return a coordinate that goes round: φ is q in the sense of its rotation."""
    direction = frames.directions[k]
    q = direction * φ
    one = coordinate_at(*task, tori._replace(q=changed(tori.q, k, q)), k)
    given = np.stack([offset(sides(one.coordinate)[0], q), *one.constants])
    with np.errstate(all="ignore"):
        root = np.sqrt(squares(one, q))
        _, slope, _ = run_rows(one.programs.views[0].bend, one.parameters, given)
        slope = slope * sides(one.coordinate)[0].sign
        forces = direction * slope / (2 * root) * direction
        return q, direction * root, direction, forces, kernels(one) / root, 0 * φ, 0 * φ


def _about_maximum(task: AngleTask, tori: Tori, frames: Frames, k: int, φ: Reals) -> _Row:
    """Return a narrow libration."""
    s, c = _sines(φ)
    with np.errstate(all="ignore"):
        at, (square, slope, noise, weights) = narrow_at(coordinate_at(*task, tori, k), frames.narrow[k], s, c, NEXT)
        return _row(at, (square, slope, noise, weights), frames.widths[k] * s * c)


def _sines(φ: Reals) -> tuple[Reals, Reals]:
    """Return sin and cos of φ/2, not 0."""
    s, c = (np.where(np.abs(x) < _TURNING, np.copysign(_TURNING, x), x) for x in (np.sin(0.5 * φ), np.cos(0.5 * φ)))
    return s, c


def _row(at: Pair, squares_: tuple[Reals, Reals, Reals, Reals], moves: Reals) -> _Row:
    """Return a row from p², its slope, what is not known of it, and the kernels over p; ``moves`` is ½ W sin φ."""
    square, slope, noise, weights = squares_
    root = np.sqrt(square)
    turns = np.abs(moves) / root  # finite at turning points
    rounding = np.fmin(0.5 * noise / root, np.sqrt(noise))
    P = np.where(moves < 0, -1.0, 1.0) * root
    return at.high, P, moves, 0.5 * slope * turns, weights * turns, rounding, at.low


def changed(rows: Reals, k: int, values: Reals) -> Reals:
    """Return the arrays of all coordinates with those of one replaced.

    Args:
        rows: shape (separated, …).
        k: which.
        values: its new ones.
    """
    found = rows.copy()
    found[k] = values
    return found


def _between(task: AngleTask, tori: Tori, frames: Frames, k: int, φ: Reals, *, exact: bool, bounds: bool) -> _Row:
    """Return a coordinate between turning points, seen from the nearer one."""
    one, W, bases = coordinate_at(*task, tori, k), frames.widths[k], frames.bases[k]
    D, (s, c) = DoubleDouble(), _sines(φ)
    lower = np.abs(s) <= np.abs(c)
    square, slope, noise, at = np.empty_like(φ), np.empty_like(φ), np.zeros_like(φ), np.empty((2, len(φ)))
    weights = np.empty((len(one.constants), len(φ)))
    for side, formula in enumerate(sides(one.coordinate)):
        index = np.flatnonzero(lower if side == 0 else ~lower)
        if not len(index):
            continue
        away = (1.0, -1.0)[side] * formula.sign
        d = W[index] * (s if side == 0 else c)[index] ** 2
        zero, x = 0.0 * d, bases[2 * side, index] + away * d
        with np.errstate(all="ignore"):
            bend = run_rows(one.programs.views[side].bend, one.parameters, np.stack([x, *one.constants[:, index]]))
            seen = np.fmax(d, NEXT * np.fmin(W[index], 2 * np.abs(bend[1] / bend[2])))
        if exact:
            code, known = one.programs.exact[side].fill, np.stack([*one.constants, *one.low, *bases])[:, index]
            given = np.stack([away * seen, zero, zero + 1.0, zero, *known])
        else:
            code, end = one.programs.views[side].fill, bases[2 * side, index]
            given = np.stack([away * seen, end + away * seen, zero + 1.0, end, *one.constants[:, index]])
        with np.errstate(all="ignore"):
            _, r, F, *rates = run_rows(code, one.parameters, given)
            weights[:, index] = np.stack(rates) / r
            if bounds:
                seen_at = np.stack([away * seen, zero, zero, *known, *one.uncertainty[:, index]])
                noise[index] = run_rows(one.programs.exact[side].errors, one.parameters, seen_at)[0]
            square[index] = np.where(d < seen, F * (d / seen), F)  # linear next to the turning point
        slope[index] = formula.sign * bend[1]
        base = D.add(Pair(*bases[2 * side : 2 * side + 2, index]), Pair(away * d, zero))
        # in two doubles: next to q = 0 places far from the origin of the view keep their digits
        at[:, index] = D.add(formula.origin, Pair(formula.sign * base.high, formula.sign * base.low))
    with np.errstate(all="ignore"):
        return _row(Pair(at[0], at[1]), (square, slope, noise, weights), W * s * c)
