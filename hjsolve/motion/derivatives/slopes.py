"""How one separated coordinate changes with its phase and with what is varied, at many phases at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Reals
from hjsolve.motion.derivatives.bounded import Bounded


class Slopes(NamedTuple):
    """Derivatives of place q, shell momentum P and Jacobi's integrals G_j at the phase χ; m phases.

    Attributes:
        q, p: dq/dχ and dP/dχ, shape (m,).
        rates: dG_j/dχ, shape (constants, m).
        q_by, p_by: q_b and P_b at fixed χ, shape (variables, m).
        integrals: (G_j)_b at fixed χ, shape (constants, variables, m).
    """

    q: Bounded
    p: Bounded
    rates: Bounded
    q_by: Bounded
    p_by: Bounded
    integrals: Bounded

    def with_phase_errors(self, beside: Slopes, errors: Reals, step: float) -> Slopes:
        """Return the same with what the errors of the phases do to every function, by its slope.

        Args:
            beside: at phases larger by a step.
            errors: of the phases, shape (m,).
            step: the step.
        """
        return Slopes(*(_uncertain(own, other, errors, step) for own, other in zip(self, beside, strict=True)))


def _uncertain(own: Bounded, other: Bounded, errors: Reals, step: float) -> Bounded:
    slope = np.abs((other.value - own.value).astype(float)) / step
    return Bounded(own.value, own.error + 2 * slope * errors)
