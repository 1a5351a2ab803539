"""Why a motion has no state at a time: it has ended, or it is so far out that doubles do not hold it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.time_law.open_motion import reaching

if TYPE_CHECKING:
    from hjsolve.motion.separated import SeparatedMotion


def end_statuses(motion: SeparatedMotion, time: tuple[Reals, Reals], ended: Mask) -> NDArray[np.str_]:
    """Return the status of a motion at times.

    Args:
        motion: the motion.
        time: high and low parts of the times relative to t₀, shape (m,).
        ended: where the phases have ended, shape (m,).

    Returns:
        ``ok``; ``reaches_boundary`` past the end of a domain or of all time (infinity in a finite time);
        ``not_converged`` where an unbounded motion is beyond the greatest phase that is integrated. Shape (m,).
    """
    status = np.full(ended.shape, "ok", dtype="<U16")
    for direction in (1, -1):
        chosen = ended & (direction * time[0] > 0)
        if chosen.any():
            span = 2 * float(np.max(np.abs(time[0][chosen])))
            status[chosen] = "reaches_boundary" if _ends(motion, direction, span) else "not_converged"
    status[ended & (time[0] == 0)] = "reaches_boundary"
    return status


def _ends(motion: SeparatedMotion, direction: int, span: float) -> bool:
    """Return True where some coordinate has an end in that direction of time."""
    scheme = motion.scheme
    if scheme is None:
        return False
    for i, course in enumerate(scheme.courses):
        whole = reaching(course, scheme, span, i)
        if whole.finished(direction) or (
            whole.ends(direction) == "asymptote" and np.isfinite(whole.limits()[direction > 0])
        ):
            return True
    return False
