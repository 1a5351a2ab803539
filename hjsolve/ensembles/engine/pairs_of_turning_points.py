"""Turning points of librations in two doubles, with p² to 32 digits, and bounds on their errors.

Newton's method x − F(x)/F′(x) with F in two doubles and F′ in one: the residual decides what is known of a zero, the
slope only how fast it is reached (Higham 2002, §25.2).
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.coordinate_of_orbits import CoordinateOfOrbits, place
from hjsolve.ensembles.engine.program_parts import FINER
from hjsolve.ensembles.engine.programs import sides

_NEWTON = 4
"""Steps of Newton's method: each gains sixteen digits, next to another zero less."""


def in_doubles(one: CoordinateOfOrbits) -> Reals:
    """Return bounds on the errors that the constants have in doubles, of which 32 digits leave a part."""
    # the bound is |low| and 2⁻⁴⁴ of what doubles lose: the latter is undone here, for programs in doubles
    return one.uncertainty + np.maximum(one.uncertainty - np.abs(one.low), 0.0) / FINER


def in_two_doubles(one: CoordinateOfOrbits, side: int, x: Reals, steps: int = _NEWTON) -> tuple[Pair, Reals, Reals]:
    """Return turning points to 32 digits by Newton's method with F′ in doubles, F′ there, and the last step.

    Args:
        one: the coordinate.
        side: 0 for lower ones, 1 for upper ones.
        x: offsets in doubles in the view of that side, shape (n,).
        steps: of Newton's method.
    """
    slopes, squares = one.programs.views[side].slopes, one.programs.exact[side].squares
    with np.errstate(all="ignore"):
        # F to 32 digits over F′ to 16: each step gains sixteen digits, or as many as F′ has
        _, slope = run_rows(slopes, one.parameters, np.stack([x, *one.constants]))
        base = Pair(x, 0.0 * x)
        for _ in range(steps):
            (f,) = run_rows(squares, one.parameters, np.stack([*base, *one.constants, *one.low]))
            step = f / slope
            base = DoubleDouble().sub(base, Pair(step, 0.0 * step))
            _, slope = run_rows(slopes, one.parameters, np.stack([base.high, *one.constants]))
    return base, slope, step


def places_and_errors(
    one: CoordinateOfOrbits, bases: list[Reals], slopes: Reals, fine: Integers
) -> tuple[Reals, Reals]:
    """Return the turning points of some of the orbits, and bounds on their errors."""
    zero, places, errors = np.zeros(len(one.q)), [], []
    given = np.stack([zero, zero, zero, *one.constants, *one.low, *bases, *in_doubles(one)])
    for k, formula in enumerate(sides(one.coordinate)):
        with np.errstate(all="ignore"):
            noise = run_rows(one.programs.exact[k].errors, one.parameters, given)[0]
            x = bases[2 * k]
            q = place(formula, x)
            errors.append((noise / np.abs(slopes[k]) + 2 * EPS * (np.abs(q) + np.abs(x)))[fine])
        places.append(q[fine])
    return np.stack(places), np.stack(errors)
