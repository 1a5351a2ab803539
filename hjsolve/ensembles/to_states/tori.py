"""n tori of one system: constants in two doubles, a place inside each coordinate's motion, and J with ∂J/∂c there.

F = p² of coordinate i between turning points has one place top next to which it is seen. J = (1/2π) ∮ √F dq and
∂J/∂c come from the engine (``engine.kernels.cycle_integrals``), started at that place. Where F < 0 there, or J is to be
zero, the harmonic libration about the maximum of F takes its place, J = F/(2 √(−½F″)): this continues J analytically
to negative values, so that Newton's method passes through J = 0.
"""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np

from hjsolve.arithmetic.error_free import two_sum
from hjsolve.arithmetic.machine.over_rows import WIDTH, run_rows
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, offset, place, squares
from hjsolve.ensembles.engine.kernels.maxima import climbed
from hjsolve.ensembles.engine.kernels.types import Modes
from hjsolve.ensembles.engine.librating import Kept
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.passes import integrated
from hjsolve.ensembles.engine.programs import SystemPrograms, sides

FINER = 2.0**-100
"""What two doubles leave open of a constant, relatively."""
_KEPT = Kept(3e-13, 1e-10)
"""Relative errors of J, and of ∂J/∂c, up to which p² in doubles does: the latter only lead to the next torus."""
_SUMMIT_STEPS, _STILL = 8, 1e-12
"""Steps of Newton's method for the maximum of p², and the relative step that ends them."""
ALONE = Modes(chords=False, kernels=True, oscillations=False, shifts=False)
APPROXIMATE, DOUBLES, EXACT = range(3)
"""How J is worked out: with few nodes and no errors; in doubles; with p² to 32 digits where doubles are not enough."""


class AngleTask(NamedTuple):
    """A system with its programs."""

    model: Model
    programs: SystemPrograms


class Tori(NamedTuple):
    """n tori.

    Attributes:
        values, low: constants in two doubles, shape (constants, n).
        q: of every separated coordinate a place inside its motion, shape (separated, n).
        ends: turning points next to its own, lower and upper ones in two doubles, offsets in the views of both halves,
            shape (separated, 4, n); NaN where none are known.
    """

    values: Reals
    low: Reals
    q: Reals
    ends: Reals

    def take(self, index: Integers | Mask) -> Tori:
        """Return some of them."""
        return Tori(*(x[..., index] for x in self))

    def moved(self, unknown: Integers, step: Reals) -> Tori:
        """Return tori whose unknown constants are larger by a step.

        Args:
            unknown: positions of the constants.
            step: shape (unknown, n).
        """
        values, low = self.values.copy(), self.low.copy()
        high, rest = two_sum(values[unknown], step)
        values[unknown], low[unknown] = two_sum(high, rest + low[unknown])
        return Tori(values, low, self.q, self.ends)


class Actions(NamedTuple):
    """Actions of n tori; arrays (separated, n).

    Attributes:
        values, errors: J without its sign, and bounds on the errors.
        slopes, slope_errors: ∂J/∂c, and bounds on the errors, shape (separated, constants, n).
        harmonic: where J is that of the harmonic libration.
        good: where everything is known; shape (n,).
        rotations: which go round.
    """

    values: Reals
    errors: Reals
    slopes: Reals
    slope_errors: Reals
    harmonic: Mask
    good: Mask
    rotations: Mask

    def take(self, index: Integers | Mask) -> Actions:
        """Return those of some tori."""
        return Actions._make(x[..., index] for x in self)


def unknown_of(slopes: Reals, constants: Reals) -> Reals:
    """Return what constants in two doubles leave open of J, and p² from them, shape (separated, n).

    Args:
        slopes: ∂J/∂c, shape (separated, constants, n).
        constants: shape (constants, n).
    """
    return FINER * np.einsum("kcn,cn->kn", np.abs(slopes), np.abs(constants))


_Bundle = TypeVar("_Bundle", bound=NamedTuple)


def joined(one: _Bundle, other: _Bundle) -> _Bundle:
    """Return the arrays of two bundles, those of the second after those of the first.

    Args:
        one, other: of the same kind.
    """
    return type(one)._make(np.concatenate(pair, axis=-1) for pair in zip(one, other, strict=True))


def no_actions(size: int, constants: int, count: int) -> Actions:
    """Return actions that hold nothing.

    Args:
        size: separated coordinates.
        constants: constants of the motion.
        count: tori.
    """
    values, errors = (np.full((size, count), np.nan) for _ in range(2))
    harmonic, rotations = (np.zeros((size, count), dtype=bool) for _ in range(2))
    slopes, slope_errors = (np.full((size, constants, count), np.nan) for _ in range(2))
    return Actions(values, errors, slopes, slope_errors, harmonic, np.zeros(count, dtype=bool), rotations)


def coordinate_at(
    model: Model, programs: SystemPrograms, tori: Tori, k: int, P: Reals | None = None, rest: Reals | None = None
) -> CoordinateOfOrbits:
    """Return one coordinate of tori, started at its place.

    Args:
        k: which coordinate.
        P: its momenta there, shape (n,); None for 1.
        rest: what the rounding of the place leaves; None where it is exact.
    """
    uncertainty = np.abs(tori.low) + FINER * np.abs(tori.values)
    momenta = np.ones(tori.q.shape[1]) if P is None else P
    return CoordinateOfOrbits(
        model.separated[k], programs.coordinates[k], programs.parameters, np.ascontiguousarray(tori.q[k]), momenta,
        np.ascontiguousarray(tori.values), np.ascontiguousarray(tori.low), uncertainty, rest,
    )  # fmt: skip


def tops(one: CoordinateOfOrbits) -> tuple[Reals, Reals]:
    """Return the maxima of F next to the places of a coordinate, and F″ there.

    Returns:
        Places and F″ there, shape (n,); F″ ≥ 0 where no maximum was found next to a place.
    """
    formula, x = sides(one.coordinate)[0], np.ascontiguousarray(offset(sides(one.coordinate)[0], one.q))
    program, bend = one.programs.views[0].bend.program(WIDTH, one.parameters), np.empty(len(x))
    climbed(program, x, one.constants, *_ends(one), bend, np.empty((4, WIDTH)))
    with np.errstate(invalid="ignore"):
        return place(formula, x), bend


def summits(one: CoordinateOfOrbits, q: Reals) -> tuple[Reals, Reals]:
    """Return the maxima of F next to places, by Newton's method with F′ from 32 digits, and F″ there.

    Args:
        q: places, shape (n,).
    """
    formula, small = sides(one.coordinate)[0], one.programs.small
    with np.errstate(all="ignore"):
        for _ in range(_SUMMIT_STEPS):
            given = np.stack([offset(formula, q), *one.constants])
            bend = run_rows(one.programs.views[0].bend, one.parameters, given)[2]
            (slope,) = run_rows(small.slope, one.parameters, np.stack([q, *one.constants, *one.low]))
            step = np.where(bend < 0, slope / bend, 0.0)
            q = q - step
            if not (np.abs(step) > _STILL * np.abs(q)).any():
                break
    return q, bend


def _ends(one: CoordinateOfOrbits) -> tuple[float, float]:
    """Offsets of the ends of the domain in the view from the lower one; infinite where there are none."""
    coordinate = one.coordinate
    if coordinate.lower is None:
        return -np.inf, np.inf if coordinate.upper is None else coordinate.upper.origin.high
    if coordinate.upper is None:
        return 0.0, np.inf
    return 0.0, coordinate.upper.origin.high - coordinate.lower.origin.high


def actions_of(
    model: Model, programs: SystemPrograms, tori: Tori, zero: Mask, rotating: Mask, how: int
) -> tuple[Actions, Tori]:
    """Work out the actions of tori, and places next to the maxima of F for them.

    Args:
        zero: where J is to be zero, shape (separated, n).
        rotating: where a coordinate is to go round, shape (separated, n).
        how: ``APPROXIMATE``, ``DOUBLES`` or ``EXACT``.
    """
    size, n = tori.q.shape
    modes = ALONE._replace(approximate=how == APPROXIMATE)
    m = len(model.constants)
    values, errors = np.full((size, n), np.nan), np.zeros((size, n))
    slopes, slope_errors = np.full((size, m, n), np.nan), np.zeros((size, m, n))
    harmonic = np.zeros((size, n), dtype=bool)
    rotations, q, ends = np.zeros((size, n), dtype=bool), tori.q.copy(), tori.ends.copy()
    for k in range(size):
        top, bend = tops(coordinate_at(model, programs, tori, k))
        q[k] = np.where(rotating[k], q[k], top)
        own = tori._replace(q=q)
        F = squares(coordinate_at(model, programs, own, k), q[k])
        harmonic[k] = ~rotating[k] & (zero[k] | ~(F > 0)) & (bend < 0)
        some = np.flatnonzero(harmonic[k])
        if len(some):
            one = coordinate_at(model, programs, own.take(some), k)
            root = np.sqrt(-0.5 * bend[some])
            values[k, some] = F[some] / (2 * root)
            slopes[k][:, some] = kernels(one) / root
        others = np.flatnonzero(~harmonic[k] & (F > 0))
        if len(others):
            one = coordinate_at(model, programs, own.take(others), k, np.sqrt(F[others]))
            sums, found, turned = integrated(one, modes, exact=how == EXACT, places=how == APPROXIMATE, kept=_KEPT)
            if how == APPROXIMATE:
                for side, formula in enumerate(sides(one.coordinate)):
                    ends[k, 2 * side, others] = offset(formula, found.places[side])
                    ends[k, 2 * side + 1, others] = 0.0 * found.places[side]
            fine = sums.good & (turned == rotating[k, others])
            values[k, others] = np.where(fine, sums.action, np.nan)
            errors[k, others] = sums.action_error
            slopes[k][:, others], slope_errors[k][:, others] = sums.means, sums.mean_errors
            rotations[k, others] = turned
    good = np.isfinite(values).all(axis=0) & np.isfinite(slopes).all(axis=(0, 1))
    return Actions(values, errors, slopes, slope_errors, harmonic, good, rotations), tori._replace(q=q, ends=ends)


def kernels(one: CoordinateOfOrbits) -> Reals:
    """Return ½ ∂F/∂c at the places of a coordinate, shape (constants, n)."""
    given = np.stack([one.q, *one.constants, *one.uncertainty])
    with np.errstate(all="ignore"):
        return np.split(run_rows(one.programs.small.kernels, one.parameters, given), 2)[0]
