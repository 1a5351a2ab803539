"""One orbit of an ensemble by the engine of single motions: exact input, as many digits inside as it takes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from hjsolve.arithmetic.estimate import Estimate
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.layout import ERROR, Layout
from hjsolve.errors import ForbiddenMotionError, InvalidInputError, NotConvergedError
from hjsolve.motion.charted.in_a_plane import MotionInPlane
from hjsolve.motion.motion import Motion
from hjsolve.one_coordinate.coordinate_motion import AtRest
from hjsolve.precision import shared_libraries
from hjsolve.solution.quadratures import Solution

_TIMELESS = ("constants", "turning_points", "actions")
_KINDS = {"escape": Status.UNBOUNDED, "asymptotic": Status.ASYMPTOTIC, "boundary": Status.REACHES_BOUNDARY}
_ONE_WAY = (Status.UNBOUNDED, Status.REACHES_BOUNDARY)
Row = dict[str, float]


def single_orbit(
    solution: Solution, layout: Layout, start: Mapping[str, Any], parameters: Mapping[str, Any], *,
    endless: bool = False,
) -> tuple[Status, Row]:  # fmt: skip
    """Compute one orbit.

    Args:
        start: ``q`` and ``p`` or ``velocity``: coordinate → finite number.
        parameters: name → exact value.
        endless: whether it seems to run away, or into an end of its domain. It then has no frequency, period or angle,
            and the integrals of the time are not worked out unless it turns out that it comes back.

    Returns:
        The status, and the columns that exist.
    """
    with shared_libraries:
        try:
            want = layout.want
            motion = solution.motion(**start, parameters=parameters, want=_TIMELESS if endless else want)
            if endless and _status(motion) not in _ONE_WAY:
                motion = solution.motion(**start, parameters=parameters, want=want)
        except ForbiddenMotionError:
            return Status.FORBIDDEN, {}
        except InvalidInputError:
            return Status.OUTSIDE_DOMAIN, {}
        except NotConvergedError:
            return Status.NOT_CONVERGED, {}
        if isinstance(motion, MotionInPlane):  # it has no actions in the coordinates of the columns: h² vanishes on it
            return Status.ASYMPTOTIC, {}
        try:
            return _status(motion), _row(motion, layout)
        except NotConvergedError:  # angles, next to a separatrix
            return Status.NOT_CONVERGED, {}


def _status(motion: Motion) -> Status:
    kinds = set(motion.kinds.values())
    for kind in ("boundary", "escape", "asymptotic"):
        if kind in kinds:
            return _KINDS[kind]
    frozen = (place.course for place in motion.separated.located.values() if isinstance(place.course, AtRest))
    return Status.OK if all(course.settled for course in frozen) else Status.ASYMPTOTIC


def _row(motion: Motion, layout: Layout) -> Row:
    row: Row = {}

    def put(column: str, estimate: Estimate | None) -> None:
        if estimate is not None:
            row[column], row[ERROR + column] = float(estimate.value), float(estimate.error)

    for quantity, names in layout.names.items():
        values: Any = _angles(motion) if quantity == "angles" else getattr(motion, quantity)
        for name in names:
            if quantity == "turning_points":
                for side, end in zip(("lower", "upper"), values.get(name, (None, None)), strict=True):
                    put(f"{quantity}.{name}.{side}", end)
            elif quantity == "periods" and name not in values and name in motion.frequencies:
                put(f"{quantity}.{name}", Estimate(np.inf, np.inf))
            else:
                put(f"{quantity}.{name}", values.get(name))
    return row


def _angles(motion: Motion) -> dict[str, Estimate]:
    if not motion.frequencies:
        return {}
    values = motion.angles(motion.t0)
    return {name: Estimate(float(value), float(values.error[name])) for name, value in values.items()}
