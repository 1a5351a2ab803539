"""What ``Motion.derivatives`` gives: numbers, their errors, and where a derivative does not exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown

OK = "ok"
SQUARE_ROOT = "square_root"
DEPENDENT = "dependent_constants"
NOT_ALONE = "not_differentiated"
REMARKS = {
    SQUARE_ROOT: "{name} is at rest, J = 0: this number grows like √J next to it and has no derivative; q and p of "
    "{name} are regular variables there, and so is J",
    DEPENDENT: "a coordinate is at rest ({name}): the constants of the motion are not independent there, so the state "
    "has no derivative by one of them alone; the initial data are independent",
    NOT_ALONE: "{name}: this number exists, but its derivatives are not worked out here: another coordinate does not "
    "come back, or an angle is counted from between two barriers",
}
"""Word of a status → what it means."""


@dataclass(frozen=True, repr=False, eq=False)
class MotionDerivatives(ByValue, Shown):
    """Derivatives of a motion.

    Attributes:
        value: quantity → name → variable → derivative, in the units of the quantity over those of the variable; for the
            state ``q`` and ``p`` stand for the quantity. Numbers, or arrays of the shape of the times; for turning
            points pairs (lower, upper), None where there is none.
        error: bounds on their errors, of the same shape.
        status: quantity → name → ``ok``, or why there is no derivative; the numbers are then nan.
        remarks: a sentence for every status that is not ``ok``.
    """

    value: Mapping[str, Mapping[str, Mapping[str, Any]]]
    error: Mapping[str, Mapping[str, Mapping[str, Any]]]
    status: Mapping[str, Mapping[str, str]]
    remarks: tuple[str, ...] = ()
