"""One pass over a chunk of orbits: constants, integrals, and what is wanted of them, with errors.

q, p ↦ c, to 32 digits (``constants``); c ↦ Jᵢ, ∂Jᵢ/∂cⱼ and the running integrals Gᵢⱼ of each coordinate (``librating``,
``rotating``); these ↦ J, Ω, θ by Ω·∂J/∂c = ∂E/∂c (``actions_and_angles``; Greenwood (5-83) for ignorable coordinates).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Codes, Integers, Mask, Reals
from hjsolve.ensembles.engine.actions_and_angles import combine_integrals
from hjsolve.ensembles.engine.columns import Columns, blank
from hjsolve.ensembles.engine.constants import InitialConstants, initial_constants
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits
from hjsolve.ensembles.engine.escapes import escaping
from hjsolve.ensembles.engine.kernels.types import Modes, Sums, no_sums
from hjsolve.ensembles.engine.librating import SMALL, Kept, TurningPoints, approximate_ones, librations
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.programs import SystemPrograms
from hjsolve.ensembles.engine.rotating import going_round, rotations
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import ENDLESS, UNDECIDED, Status

TOLERANCE = 1e-10
"""Largest claimed relative error with which an orbit is called ``OK``; of an angle, relative to ten radians."""

_RADIANS = 10.0
"""What the error of an angle is over: θ runs to 2π, and next to 0 a relative error would say nothing."""
TIMED = frozenset({"frequencies", "periods", "angles"})

Names = dict[str, tuple[str, ...]]
"""Quantity → names of its columns."""


def run_pass(
    model: Model, programs: SystemPrograms, names: Names, starts: Starts, *, tolerance: float, exact: bool
) -> Columns:
    """Compute everything for some orbits.

    Args:
        model: the lowered solution.
        programs: of the system.
        names: quantity → names of its columns.
        starts: of n orbits.
        tolerance: largest claimed error of an orbit that is ``OK``.
        exact: whether p² is taken to 32 digits where doubles do not know it well.

    Returns:
        Columns; ``unresolved`` where only the claim was too large. The status is ``ENDLESS`` where no turning point was
        met on the way out.
    """
    count = starts.q.shape[1]
    columns = blank(names, count)
    # E − V is a small difference for nearly unbound or nearly circular orbits: constants in two doubles
    start = initial_constants(model, programs, starts)
    modes = modes_of(names)
    status = np.full(count, Status.OK, dtype=np.uint8)
    directions = np.ones((len(model.separated), count))
    sums = []
    for k, coordinate in enumerate(model.separated):
        left = np.flatnonzero(status == Status.OK)  # what is lost in one coordinate is lost
        total = no_sums(len(model.constants), count)
        one = CoordinateOfOrbits.of(model, programs, start, k).take(left)
        part, found, round_ = integrated(one, modes, exact=exact, places="turning_points" in names)
        total.put(left, part)
        directions[k, left[round_]] = np.sign(start.P[k, left[round_]])
        if "turning_points" in names:
            _put_turning_points(columns, coordinate.name, left, found.places, found.errors)
        # no turning point on a side: not a failure of the quadrature, but a motion that may run away
        endless = np.isnan(found.offsets).any(axis=0) & ~round_
        status[left[~part.good]] = np.where(endless, ENDLESS, UNDECIDED)[~part.good]
        # momenta from velocities are rounded: next to a turning point χ ~ P, so that δχ is at most δP/P
        total.phase_error[:] += start.rounding[k]
        sums.append(total)
    _results(model, names, columns, sums, directions, start)
    if modes.oscillations and any(c.shifted for c in model.separated):
        status[status == Status.OK] = UNDECIDED
    # what is resolved but claims too much is worth a second pass; what is not resolved is not
    resolved = status == Status.OK
    _settle(columns, status, tolerance)
    columns.unresolved[:] = resolved & (columns.status != Status.OK)
    return columns


def modes_of(names: Names) -> Modes:
    """Return what the integrals must give; how F is seen is settled for each kind of motion.

    Args:
        names: quantity → names of its columns.
    """
    return Modes(chords=False, kernels=bool(TIMED & names.keys()), oscillations="angles" in names, shifts=False)


def integrated(
    one: CoordinateOfOrbits, modes: Modes, *, exact: bool, places: bool, kept: Kept = SMALL
) -> tuple[Sums, TurningPoints, Mask]:
    """Integrate one coordinate: rotations where it goes round, librations elsewhere.

    Args:
        one: the coordinate of n orbits.
        modes: what is wanted.
        exact: whether p² is taken to 32 digits where doubles do not know it well.
        places: whether turning points are wanted.
        kept: which errors do not need that.

    Returns:
        The sums, the turning points, and which of the orbits go round.
    """
    n = len(one.q)
    sums, round_ = no_sums(len(one.constants), n), np.zeros(n, dtype=bool)
    found = TurningPoints(*(np.full((2, n), np.nan) for _ in range(3)))
    if one.coordinate.periodic and not one.coordinate.shifted:
        going = going_round(one)
        round_[going.orbits] = True
        if len(going.orbits):
            some = one.take(going.orbits)
            part = rotations(some, going.slow, modes, finely=False)
            # next to a barrier top p² of a rotation is the small difference E − V: 32 digits have it
            approximate = (
                np.flatnonzero(~part.good | approximate_ones(part, modes, kept)) if exact else going.orbits[:0]
            )
            if len(approximate):
                better = rotations(some.take(approximate), going.slow.take(approximate), modes, finely=True)
                fine = np.flatnonzero(better.good)
                part.put(approximate[fine], better.take(fine))
            sums.put(going.orbits, part)
    others = np.flatnonzero(~round_)
    if len(others):
        part, seen = librations(one.take(others), modes, exact=exact, places=places, kept=kept)
        sums.put(others, part)
        for name in ("offsets", "places", "errors"):
            getattr(found, name)[:, others] = getattr(seen, name)
    return sums, found, round_


def run_escapes(model: Model, programs: SystemPrograms, names: Names, starts: Starts) -> Columns:
    """Prove of some orbits that they run away; fill their constants, turning points, and actions that they have.

    Args:
        model: of the system.
        programs: of the system.
        names: quantity → columns wanted.
        starts: of n orbits.

    Returns:
        Columns; the status is ``UNBOUNDED`` where a coordinate runs away and every other one does or is known to
        librate or to rotate, and ``UNDECIDED`` elsewhere.
    """
    count = starts.q.shape[1]
    columns = blank(names, count)
    start = initial_constants(model, programs, starts)
    left = np.ones(count, dtype=bool)
    endless = np.zeros((len(model.separated), count), dtype=bool)
    sums: list[Sums] = []
    # kernels wherever programs have them: without, nothing counts what constants and turning points do to chords
    directions, modes = np.ones(endless.shape), modes_of(names)._replace(oscillations=False)
    for k, coordinate in enumerate(model.separated):
        one = CoordinateOfOrbits.of(model, programs, start, k)
        total, found, round_ = integrated(one, modes, exact=True, places="turning_points" in names)
        directions[k, round_] = np.sign(start.P[k, round_])
        # where p is shifted, or p² repeats itself along a line, a coordinate may go round for ever: that is left to
        # single motions
        returns = coordinate.periodic or coordinate.repeats
        away = np.zeros(count, dtype=bool) if returns else ~total.good & ~round_
        out = np.flatnonzero(left & away & np.isnan(found.offsets).any(axis=0))
        endless[k, out], errors = escaping(one.take(out), model, found.offsets[:, out])
        found.errors[:, out] = errors
        if "turning_points" in names:
            _put_turning_points(columns, coordinate.name, np.arange(count), found.places, found.errors)
        with np.errstate(all="ignore"):
            # every other coordinate must be known to return, or to run away itself
            fine = total.good & (total.action_error <= TOLERANCE * np.abs(total.action))
        left &= fine | (total.good & (total.action_error == 0)) | endless[k]
        sums.append(total)
    _results(model, {q: columns_ for q, columns_ in names.items() if q not in TIMED}, columns, sums, directions, start)
    if "actions" in names:
        for k, coordinate in enumerate(model.separated):
            for group in (columns.actions[coordinate.name], columns.error[f"actions.{coordinate.name}"]):
                group[endless[k]] = np.nan
    left &= endless.any(axis=0)
    columns.status[:] = np.where(left, Status.UNBOUNDED, UNDECIDED)
    return columns


def _put_turning_points(columns: Columns, name: str, index: Integers, places: Reals, errors: Reals) -> None:
    for k, side in enumerate(("lower", "upper")):
        columns.turning_points[f"{name}.{side}"][index] = places[k]
        columns.error[f"turning_points.{name}.{side}"][index] = errors[k]


def _results(
    model: Model,
    names: dict[str, tuple[str, ...]],
    columns: Columns,
    sums: list[Sums],
    directions: Reals,
    start: InitialConstants,
) -> None:
    if "constants" in names:
        for j, name in enumerate(model.constants):
            _fill(columns, "constants", name, start.values[j], start.uncertainty[j])
    _actions(model, names, columns, sums, directions, start)
    if TIMED & names.keys():
        _timed(model, names, columns, sums, directions, start.starts.q)


def _fill(columns: Columns, quantity: str, name: str, value: Reals, error: Reals) -> None:
    columns.group(quantity)[name][:] = value
    columns.error[f"{quantity}.{name}"][:] = error if quantity == "constants" else error + EPS * np.abs(value)


def _actions(
    model: Model,
    names: dict[str, tuple[str, ...]],
    columns: Columns,
    sums: list[Sums],
    directions: Reals,
    start: InitialConstants,
) -> None:
    if "actions" not in names:
        return
    for k, coordinate in enumerate(model.separated):
        _fill(columns, "actions", coordinate.name, directions[k] * sums[k].action, sums[k].action_error)
    for name in model.angles:
        k = model.names.index(name)
        columns.actions[name][:], columns.error[f"actions.{name}"][:] = start.starts.p[k], start.starts.uncertainty[k]


def _timed(
    model: Model, names: dict[str, tuple[str, ...]], columns: Columns, sums: list[Sums], directions: Reals, q: Reals
) -> None:
    torus = combine_integrals(model, sums, directions, q, angles="angles" in names)
    for name, (rate, error) in torus.frequencies.items():
        if "frequencies" in names:
            _fill(columns, "frequencies", name, rate, error)
        if "periods" in names:
            with np.errstate(all="ignore"):
                # δT/T = δΩ/Ω, to first order
                period = 2 * np.pi / np.abs(rate)
                _fill(columns, "periods", name, period, period * (error / np.abs(rate) + EPS))
    for name, (angle, error) in torus.angles.items():
        _fill(columns, "angles", name, angle, error)


def worst(columns: Columns) -> Reals:
    """Return the largest claimed error of every orbit: relative (of angles to 10 radians); NaN for none."""
    largest = np.zeros(len(columns.status))
    for key, error in columns.error.items():
        quantity, name = key.split(".", 1)
        if quantity in {"actions", "frequencies", "periods", "angles"}:
            value = columns.group(quantity)[name]
            scale = _RADIANS if quantity == "angles" else np.abs(value)
            with np.errstate(all="ignore"):
                # 0/0 of a quantity that is exactly 0 counts as exact
                relative = np.where((error == 0) & np.isfinite(value), 0.0, error / scale)
            largest = np.maximum(largest, relative)
    return largest


def _settle(columns: Columns, status: Codes, tolerance: float) -> None:
    """Keep the orbits whose errors are small enough; NaN for the others."""
    status[(status == Status.OK) & ~(worst(columns) <= tolerance)] = UNDECIDED
    columns.status[:] = status
    # no number of an orbit that is not ``OK``: a value without a claim would be taken for one with
    lost = status != Status.OK
    for key, error in columns.error.items():
        quantity, name = key.split(".", 1)
        error[lost] = np.nan
        columns.group(quantity)[name][lost] = np.nan
