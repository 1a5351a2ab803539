"""Constants of the motion of many orbits, from 32 digits, with bounds on their errors.

E = T + V of a nearly unbound orbit, or the slope of p² at the start of a nearly circular one, is a small difference of
large numbers. So they are computed with 32 digits from the inputs as the exact numbers they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.ensembles.engine.lowered_solution import Model
from hjsolve.ensembles.engine.programs import SystemPrograms
from hjsolve.ensembles.engine.starts import Starts

_FARTHEST = 2.0**228
"""Fourth powers of it, and of its inverse, keep both halves of a pair: 2^−(4·228) times the 2⁻¹⁰⁶ of a product's error
is 2⁻¹⁰¹⁸, still a normal number; constants are compared with its square, as they hold q² at least."""


@dataclass(frozen=True)
class InitialConstants:
    """Initial data of n orbits.

    Attributes:
        q: positions of the separated coordinates, shape (separated, n).
        P: their shell momenta.
        starts: as they were taken, of all coordinates.
        values, low: the constants in two doubles, shape (constants, n).
        uncertainty: bounds on the errors of the first of them.
        rounding: bounds on the relative errors of P where p comes from velocities, shape of P. Next to a turning point
            χ is read off P and grows no faster.
    """

    q: Reals
    P: Reals
    starts: Starts
    values: Reals
    low: Reals
    uncertainty: Reals
    rounding: Reals


def initial_constants(model: Model, programs: SystemPrograms, starts: Starts) -> InitialConstants:
    """Work out the constants to 32 digits.

    Args:
        model: the lowered solution.
        programs: of the system.
        starts: of n orbits.
    """
    starts = starts.precise()
    # low parts of p and their bounds are inputs, too: E inherits what velocities leave open
    m, given = len(model.constants), np.concatenate([starts.q, starts.p, starts.low, starts.spread])
    C, L, E, P = np.split(run_rows(programs.start, programs.parameters, given), [m, 2 * m, 3 * m])
    places = [c.index for c in model.separated]
    # no claim counts underflow of second halves: such orbits go to units of their own
    C[:, _too_far(starts.q[places], C)] = np.nan
    uncertainty, p = starts.uncertainty[places], starts.p[places]
    with np.errstate(all="ignore"):
        # relative to P, because the phase of a start next to a turning point is read off P
        lost = np.where(uncertainty > 0, uncertainty / np.abs(p), 0.0)
    return InitialConstants(starts.q[places], P, starts, C, L, E, lost)


def _too_far(q: Reals, constants: Reals) -> Mask:
    """Tell which orbits are so far out that second halves of pairs may be lost by underflow, which no claim counts.

    Circular orbits of an oscillator at q = 1e76 came with J to 10 digits where the claim had 14: 1/q⁴ is 1e-304 there,
    and its second half below the smallest number. Which product loses it was not followed up; below 1e69 none can.
    """
    with np.errstate(all="ignore"):
        far = (np.abs(q) > _FARTHEST) | ((q != 0) & (np.abs(q) < 1 / _FARTHEST))
        return (far & (np.abs(constants) > _FARTHEST**2).any(axis=0)).any(axis=0)
