"""On what length p² of a coordinate along a line bends: in SI units that of an atom is 1e-10, that of an orbit 1e11.

Next to 0 every part of p² is a power of q. On logarithmic scales the power changes where the part has a length of its
own; a power alone has none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.number_types import Mask, Mpf, Reals
from hjsolve.arithmetic.tape import Tape
from hjsolve.errors import HJSolveError
from hjsolve.motion.initial_data import to_bits

_OCTAVES, _WELL_SAMPLED = np.arange(-140, 141, 2), np.arange(-14, 18, 2)
"""Octaves of q in which a bend is looked for, and those around a length of 1 that samples show well enough."""
_BEND = 0.25
"""Change of the power of q from one pair of octaves to the next that is a bend."""
_KNOWN = 2.0**-30
"""The part of p² above which a change of it in doubles is more than rounding."""
_BITS = 512
"""Digits in which 1 − exp(−q) keeps half of them at the least q."""


def natural_length(
    tapes: tuple[Tape, Tape], parameters: Sequence[sp.Expr], constants: int, action: float | None
) -> float:
    """Return the least distance from 0 at which a part of p² bends; 1 where samples about 1 show it well enough.

    Where none bends, it is the distance that motions of an action reach; 1 where no action is known.

    Args:
        tapes: of p² and of ½ ∂p²/∂κⱼ; inputs q, constants, parameters.
        parameters: their values, exact.
        constants: how many there are.
        action: of the motions that are looked for, roughly; None where it is not known.
    """
    if _bends(_changes_in_doubles(tapes, parameters, constants), len(_WELL_SAMPLED)).any():
        return 1.0
    changes = _changes(tapes, parameters, constants)
    octaves = _OCTAVES[1:-1][_bends(changes, len(_OCTAVES))]
    if not len(octaves) and action is not None and np.isfinite(changes[0]).any():
        # p q ~ J
        far = np.abs(np.tile(_OCTAVES, 2) + changes[0] / 2 - math.log2(action))
        octaves = np.tile(_OCTAVES, 2)[[int(np.nanargmin(far))]]
    return 1.0 if np.isin(octaves, _WELL_SAMPLED).any() or not len(octaves) else float(2.0 ** octaves[0])


def _changes_in_doubles(tapes: tuple[Tape, Tape], parameters: Sequence[sp.Expr], constants: int) -> Reals:
    """Return log₂ of the change of every part from q = 0 to ±2ᵏ; NaN where it is not known."""
    q = np.concatenate([[0.0], 2.0**_WELL_SAMPLED, -(2.0**_WELL_SAMPLED)])
    numbers = [float(to_bits(x)(64)) for x in parameters]
    with np.errstate(all="ignore"):
        rows = [row for tape, κ in zip(tapes, (0.0, 1.0), strict=True)
                for row in tape.run(Float64(), [q, *[κ] * constants, *numbers])]  # fmt: skip
        parts = np.stack([np.broadcast_to(np.asarray(row, dtype=float), q.shape) for row in rows])
        change, size = np.abs(parts - parts[:, :1]), np.fmax(np.abs(parts), np.abs(parts[:, :1]))
        return np.where(change > _KNOWN * size, np.log2(change), np.nan)[:, 1:]


def _changes(tapes: tuple[Tape, Tape], parameters: Sequence[sp.Expr], constants: int) -> Reals:
    """Return the same in many digits, for all octaves."""
    arithmetic = Multi(_BITS)
    known = [to_bits(x)(_BITS) for x in parameters]

    def parts(q: float) -> list[Mpf] | None:
        found = []
        for tape, κ in zip(tapes, (0, 1), strict=True):
            try:
                found += tape.run(arithmetic, [arithmetic.convert(q), *[arithmetic.rational(κ, 1)] * constants, *known])
            except (HJSolveError, ArithmeticError, ValueError):
                return None
        return [arithmetic.convert(x) for x in found]

    at_zero = parts(0.0)
    if at_zero is None:
        return np.full((1, 2 * len(_OCTAVES)), np.nan)
    columns = []
    for q in np.concatenate([2.0**_OCTAVES, -(2.0**_OCTAVES)]):
        here = parts(float(q))
        columns.append([math.nan] * len(at_zero) if here is None else list(map(_logarithm, here, at_zero)))
    return np.array(columns).T


def _logarithm(here: Mpf, there: Mpf) -> float:
    """Return log₂ of the difference, NaN where rounding may have made it."""
    context, change = here.context, abs(here - there)
    if not context.isfinite(change) or change <= max(abs(here), abs(there)) * context.mpf(2) ** (100 - _BITS):
        return math.nan
    return float(context.log(change, 2))


def _bends(logarithms: Reals, octaves: int) -> Mask:
    """Return at which octaves but the first and the last a part begins to bend on either side of 0.

    An exponential bends from its length on, everywhere.
    """
    with np.errstate(invalid="ignore"):
        powers = np.diff(logarithms.reshape(len(logarithms), 2, octaves), axis=2) / 2
        bends = np.asarray((np.abs(np.diff(powers, axis=2)) > _BEND).any(axis=(0, 1)))
    return bends & ~np.concatenate([[False], bends[:-1]])
