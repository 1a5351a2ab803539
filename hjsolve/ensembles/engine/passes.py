"""One pass over a chunk of orbits: constants, regions, integrals, and what is wanted of them, with errors."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Codes, Mask, Reals, Which
from hjsolve.ensembles.engine.actions_and_angles import combine_integrals
from hjsolve.ensembles.engine.columns import Columns, blank, put
from hjsolve.ensembles.engine.constants import InitialConstants, initial_constants
from hjsolve.ensembles.engine.escapes import escaping
from hjsolve.ensembles.engine.kernels.types import Modes
from hjsolve.ensembles.engine.librations import CoordinateOfOrbits, begin, librations
from hjsolve.ensembles.engine.lowered_solution import Model, Separated
from hjsolve.ensembles.engine.midpoint_rule import Sums, empty, integrate
from hjsolve.ensembles.engine.orbit_groups import group_of
from hjsolve.ensembles.engine.orbit_regions import LocatedRegions, OrbitRegions
from hjsolve.ensembles.engine.outlook import beyond_doubles
from hjsolve.ensembles.engine.programs import SystemPrograms
from hjsolve.ensembles.engine.radicand_views import DifferenceEvaluation, DirectEvaluation, second_slope
from hjsolve.ensembles.engine.regions import ill_known, locate_regions
from hjsolve.ensembles.engine.rotations import going_round
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import UNDECIDED, Status

TOLERANCE = 1e-10
"""Largest claimed relative error with which an orbit is called ``OK``; of an angle, relative to ten radians."""

_RADIANS = 10.0
_SPOILT = 8e-12
"""Above this claim all coordinates get p² to 32 digits; small amplitudes would not gain by it."""

_WIDE = 1e-11
"""Above this claim more digits are tried, whatever is to blame."""

_SEEN_FROM_START = 1e-13
"""Error of p² at the start over its size above which a compiled pass sees a motion from its start; where it is not
small it is seen as others are."""

_BLURRED = 2.0**-51

TIMED = frozenset({"frequencies", "periods", "angles"})


def run_pass(
    model: Model, names: dict[str, tuple[str, ...]], starts: Starts, *, depth: int, tolerance: float = TOLERANCE
) -> Columns:
    """Compute everything for some orbits.

    Args:
        model: of the system.
        names: quantity → columns wanted.
        starts: of n orbits.
        depth: 0 in doubles; 1 with 32-digit constants, slopes for small amplitudes, stretched anomalies; 2 with p² to
            32 digits where doubles do not know it well; 3 with 32 digits for all librations.
        tolerance: largest claimed error of an orbit that is ``OK``.
    """
    count = starts.q.shape[1]
    columns = blank(names, count)
    start = initial_constants(model, starts, precise=depth > 0)
    kernels, oscillations = bool(TIMED & names.keys()), "angles" in names
    # p² at the start is P² next to a turning point: a P that 32 digits do not know well is for the engine of one motion
    unknown = (start.rounding > _BLURRED).any(axis=0) if depth else np.zeros(count, dtype=bool)
    status = np.where(unknown, UNDECIDED, Status.OK).astype(np.uint8)
    sums: list[Sums] = []
    directions = np.ones((len(model.separated), count))
    spared, small = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    located = []
    for k, coordinate in enumerate(model.separated):
        index = None if depth else np.flatnonzero(status == Status.OK)
        located.append(locate_regions(model, coordinate, start, k, depth, index))
        for found in located[k] if depth == 0 else ():
            status[found.index[beyond_doubles(found, kernels=kernels)]] = UNDECIDED
    repeated = (status == Status.OK) & (_seen_as_before(located, count) if depth == 2 else False)
    status[repeated] = Status.NOT_CONVERGED
    for k, coordinate in enumerate(model.separated):
        total = empty(len(model.constants), count)
        for found in located[k]:
            left = status[found.index] == Status.OK  # what is lost in one coordinate is lost
            _integrated(total, found, left, len(model.constants), kernels=kernels, oscillations=oscillations)
            fresh = np.where(
                found.status == Status.OK, np.where(total.good[found.index], 0, Status.NOT_CONVERGED), found.status
            )
            status[found.index] = np.where(status[found.index] == Status.OK, fresh, status[found.index])
            if not found.region.turning:
                directions[k, found.index] = np.sign(start.P[k, found.index])
            if "turning_points" in names:
                _ends(columns, coordinate, found)
            if depth == 1 and found.region.turning and isinstance(found.region.below, DirectEvaluation):
                columns.vague[found.index] |= ill_known(found.region)
            spared[found.index] |= isinstance(found.region.below, DirectEvaluation)
            small[found.index] |= isinstance(found.region.below, DifferenceEvaluation)
        total.phase_error[:] += start.rounding[k]
        sums.append(total)
    _results(model, names, columns, sums, directions, start)
    if oscillations and any(c.shifted for c in model.separated):
        status[status == Status.OK] = UNDECIDED
    claimed = worst(columns)  # before those that are too large are gone: they gain most by more digits
    _settle(columns, status, tolerance)
    spoilt = spared & ~small & (claimed > _SPOILT)
    columns.vague[:] |= spoilt | (claimed > _WIDE)
    if depth == 2:
        again = np.flatnonzero(spoilt | repeated)
        if len(again):
            part = run_pass(model, names, starts.take(again), depth=3, tolerance=tolerance)
            fine = part.status == Status.OK
            put(columns, again[fine], part.take(fine))
    return columns


def _seen_as_before(located: list[list[LocatedRegions]], count: int) -> Mask:
    """Tell which orbits have p² in doubles everywhere, as it is written: a third pass would repeat the second one."""
    plain = np.ones(count, dtype=bool)
    for found in (one for parts in located for one in parts):
        plain[found.index] &= isinstance(found.region.below, DirectEvaluation)
    return plain


def run_compiled(
    model: Model, names: dict[str, tuple[str, ...]], starts: Starts, *, programs: SystemPrograms, tolerance: float, exact: bool
) -> Columns:
    """Compute everything for easy librations by compiled loops, with 32-digit constants; as ``run_pass``.

    A coordinate that goes round is integrated by numpy.

    Args:
        model: the lowered solution.
        names: quantity → names of its columns.
        starts: of n orbits.
        programs: of the system.
        tolerance: largest claimed error of an orbit that is ``OK``.
        exact: whether p² is had to 32 digits where doubles do not know it well.

    Returns:
        Columns; ``vague`` where only the claim was too large.
    """
    count = starts.q.shape[1]
    columns = blank(names, count)
    start = begin(model, programs, starts)
    kernels, oscillations = bool(TIMED & names.keys()), "angles" in names
    modes = Modes(chords=False, kernels=kernels, oscillations=oscillations, shifts=False)
    status = np.full(count, UNDECIDED if "turning_points" in names else Status.OK, dtype=np.uint8)
    directions = np.ones((len(model.separated), count))
    sums = []
    for k in range(len(model.separated)):
        one = CoordinateOfOrbits.of(model, programs, start, k)
        total = librations(one, one.smallness() > _SEEN_FROM_START, modes, exact=exact)
        left = np.flatnonzero((status == Status.OK) & ~total.good)
        if model.separated[k].periodic and len(left):
            found = going_round(group_of(model, model.separated[k], start, k, 1, left))
            everyone = np.ones(len(found.index), dtype=bool)
            _integrated(total, found, everyone, len(model.constants), kernels=kernels, oscillations=oscillations)
            directions[k, found.index] = np.sign(start.P[k, found.index])
        status[~total.good] = UNDECIDED
        total.phase_error[:] += start.rounding[k]
        sums.append(total)
    _results(model, names, columns, sums, directions, start)
    if oscillations and any(c.shifted for c in model.separated):
        status[status == Status.OK] = UNDECIDED
    resolved = status == Status.OK
    _settle(columns, status, tolerance)
    columns.vague[:] = resolved & (columns.status != Status.OK)
    return columns


def run_escapes(model: Model, names: dict[str, tuple[str, ...]], starts: Starts) -> Columns:
    """Prove of some orbits that they run away; fill their constants, turning points, and actions that they have.

    Args:
        model: of the system.
        names: quantity → columns wanted.
        starts: of n orbits.

    Returns:
        Columns; the status is ``UNBOUNDED`` where a coordinate runs away and every other one does or is known to
        librate or to rotate, and ``UNDECIDED`` elsewhere.
    """
    count = starts.q.shape[1]
    columns = blank(names, count)
    start = initial_constants(model, starts, precise=True)
    left: Mask = np.logical_not((start.rounding > _BLURRED).any(axis=0))
    endless = np.zeros((len(model.separated), count), dtype=bool)
    sums: list[Sums] = []
    directions = np.ones(endless.shape)
    for k, coordinate in enumerate(model.separated):
        total = empty(len(model.constants), count)
        for found in locate_regions(model, coordinate, start, k, 1):
            _integrated(total, found, left[found.index], len(model.constants), kernels=False, oscillations=False)
            if not found.region.turning:
                directions[k, found.index] = np.sign(start.P[k, found.index])
            if "turning_points" in names:
                _ends(columns, coordinate, found)
            out = found.take(np.flatnonzero(left[found.index] & (found.status == Status.UNBOUNDED)))
            proved, errors = escaping(coordinate, model, out, start.q[k, out.index])
            endless[k, out.index] = proved
            if "turning_points" in names:
                for side, error in zip(("lower", "upper"), errors, strict=True):
                    columns.error[f"turning_points.{coordinate.name}.{side}"][out.index] = error
        with np.errstate(all="ignore"):
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
            _fill(columns, "constants", name, start.knowns.constants[j], start.knowns.uncertainty[j])
    _actions(model, names, columns, sums, directions, start)
    if TIMED & names.keys():
        _timed(model, names, columns, sums, directions, start.starts.q)


def _integrated(
    total: Sums, found: LocatedRegions, left: Mask, constants: int, *, kernels: bool, oscillations: bool
) -> None:
    """Integrate over the regions of the orbits that are left; coordinates at rest have their limit."""
    left = left & (found.status == Status.OK)
    index = np.flatnonzero(left & ~found.rest)
    if len(index):
        total.put(
            found.index[index],
            integrate(found.region.take(index), constants, kernels=kernels, oscillations=oscillations),
        )
    index = np.flatnonzero(left & found.rest)
    if len(index):
        total.put(found.index[index], _resting(found, index, constants))


def _resting(found: LocatedRegions, index: Which, constants: int) -> Sums:
    """A stable double zero of p²: J = 0 and ∂J/∂cⱼ = kⱼ/√(−½F″), the limit of a vanishing libration."""
    view = found.region.below.take(index)
    assert isinstance(view, DifferenceEvaluation)
    bend, uncertainty = second_slope(view.formula, view.knowns, view.start)
    zero = np.zeros(len(index))
    rows = [np.broadcast_to(w, zero.shape) for w in view.full(zero)[1:]]
    errors = [np.broadcast_to(e, zero.shape) for e in view.errors(zero, kernels=True)[1:]]
    sums = empty(constants, len(index))
    with np.errstate(all="ignore"):
        root = np.sqrt(-bend)
        sums.means[:] = np.stack([w / root for w in rows])
        sums.mean_errors[:] = np.stack(
            [e / root + np.abs(w / root) * uncertainty / -bend for w, e in zip(rows, errors, strict=True)]
        )
    sums.speeds[:] = sums.means
    for part in (
        sums.action,
        sums.action_error,
        sums.oscillations,
        sums.oscillation_errors,
        sums.phase,
        sums.phase_error,
    ):
        part[...] = 0.0
    sums.good[:] = np.isfinite(root)
    return sums


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
                period = 2 * np.pi / np.abs(rate)
                _fill(columns, "periods", name, period, period * (error / np.abs(rate) + EPS))
    for name, (angle, error) in torus.angles.items():
        _fill(columns, "angles", name, angle, error)


def _ends(columns: Columns, coordinate: Separated, found: LocatedRegions) -> None:
    """Turning points, with the error that the rounding of p² there leaves."""
    region = found.region
    if not region.turning:
        return
    for side, view, x in (("lower", region.below, region.lower), ("upper", region.above, region.upper)):
        with np.errstate(all="ignore"):
            slope = np.abs(view.jet(x)[1]) if not isinstance(view, DifferenceEvaluation) else _slope(view, region)
            error = view.errors(x, kernels=False)[0] / slope + EPS * np.abs(x)
            place = view.place(x)
        name = f"{coordinate.name}.{side}"
        error = np.where(found.rest, 0.0, error) + 2 * EPS * (np.abs(place) + np.abs(x))
        columns.turning_points[name][found.index] = place
        columns.error[f"turning_points.{name}"][found.index] = error


def _slope(view: DifferenceEvaluation, region: OrbitRegions) -> Reals:
    """|F′| at the turning points of a small motion, W·S with S taken in the middle."""
    middle = 0.5 * (region.lower + region.upper)
    return 0.5 * view.value(middle) / (0.25 * region.width)


def worst(columns: Columns) -> Reals:
    """Return the largest claimed error of every orbit: relative (of angles to 10 radians); NaN for none.

    Args:
        columns: of n orbits.
    """
    largest = np.zeros(len(columns.status))
    for key, error in columns.error.items():
        quantity, name = key.split(".", 1)
        if quantity in {"actions", "frequencies", "periods", "angles"}:
            value = columns.group(quantity)[name]
            scale = _RADIANS if quantity == "angles" else np.abs(value)
            with np.errstate(all="ignore"):
                relative = np.where((error == 0) & np.isfinite(value), 0.0, error / scale)
            largest = np.maximum(largest, relative)
    return largest


def _settle(columns: Columns, status: Codes, tolerance: float) -> None:
    """Keep the orbits whose errors are small enough; NaN for the others."""
    status[(status == Status.OK) & ~(worst(columns) <= tolerance)] = UNDECIDED
    columns.status[:] = status
    lost = status != Status.OK
    for key, error in columns.error.items():
        quantity, name = key.split(".", 1)
        error[lost] = np.nan
        columns.group(quantity)[name][lost] = np.nan
