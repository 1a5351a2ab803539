"""What passes between the compiled loops and the programs: bundles of arrays, and types of functions.

A program comes in as a pointer to a function, so that our loops are compiled once for all systems.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Integers, Mask, Reals

VECTOR = 8
"""Lanes of a vector of doubles."""

FARTHEST = 6
"""Columns at the end of ``Tables.places``: the farthest places of either view in three shares."""


class Tables(NamedTuple):
    """Nodes of all maps and sizes side by side, padded; see ``node_maps``.

    Attributes:
        maps: γ₁, γ₂, K, k′², ρ_d, ρ_c and the symmetry of every map, shape (maps, 7).
        counts: numbers of nodes, shape (sizes,).
        low, high: (q − a)/W and (b − q)/W at the nodes, shape (maps, sizes, widest).
        derivative: |dq/dχ| over the root of (q − a)(b − q), the same shape.
        split: how many nodes are seen from the lower end, shape (maps, sizes, 3); see ``node_maps.views``.
        places: (q − a)/W, (b − q)/W, |dq/dχ|/W and sin²χ where errors are looked at, equally spaced in χ; and for every
            share the farthest that nodes are seen, from below and from above; shape (maps, 4, most + 6).
        samples: how many of them, shape (maps,).
        spans: how many of them are seen from below, and the first and last beside which nodes are seen in both ways,
            shape (maps, 3, 3).
        last, middle: cosines of the convergence test, shape (sizes, 5 or 3, widest).
        cosines: all of them, shape (sizes, widest, widest).
        squares, slopes: ``nodes.shifts``, plain and folded, shape (2, sizes, widest).
    """

    maps: Reals
    counts: Integers
    low: Reals
    high: Reals
    derivative: Reals
    split: Integers
    places: Reals
    samples: Integers
    spans: Integers
    last: Reals
    middle: Reals
    cosines: Reals
    squares: Reals
    slopes: Reals


class Motions(NamedTuple):
    """One coordinate of n orbits between its turning points.

    Attributes:
        momentum: P₀, shape (n,).
        left, right: q₀ − a and b − q₀.
        width: b − a.
        lower, upper: offsets of the turning points in the views of the lower and of the upper half.
        low_home, high_home: offsets in the same views of the turning points that places are counted from.
        signs: +1 or −1, how these offsets grow away from the turning points, shape (2,).
        known: constants, and what else a program knows, shape (n, known).
        uncertainty: bounds on the errors of the constants, shape (n, constants).
        first, least: the map, and the size in the tables, to begin with; a negative size leaves the orbit out.
        share: how much is seen from below; see ``node_maps.views``.
    """

    momentum: Reals
    left: Reals
    right: Reals
    width: Reals
    lower: Reals
    upper: Reals
    low_home: Reals
    high_home: Reals
    signs: Reals
    known: Reals
    uncertainty: Reals
    first: Integers
    least: Integers
    share: Integers


class Results(NamedTuple):
    """Arrays that are filled: those of ``midpoint_rule.Sums``, and size and map that were chosen, shape (2, n)."""

    action: Reals
    action_error: Reals
    means: Reals
    mean_errors: Reals
    oscillations: Reals
    oscillation_errors: Reals
    phase: Reals
    phase_error: Reals
    speeds: Reals
    good: Mask
    chosen: Integers


class Scratch(NamedTuple):
    """What one orbit after the other is worked out in.

    Attributes:
        buffer: F r, r, F and the kernels times r at the nodes, shape (3 + kernels, widest).
        shares: of the nodes, shape (widest,).
        rows: of the same width, shape (3, widest).
        noise: bounds on the rounding errors of F (times sin²χ/F; with chords relative ones) and of the kernels (times
            r), shape (1 + kernels, samples).
        drift: what the constants add to the first, times sin²χ/F; without kernels the first as it is; shape (samples,).
        found: mean, its error, last coefficient, rounding, and sizes of the last coefficients and of those before, of
            every integrand, shape (6, 1 + kernels).
        lanes: where errors are looked at, which of them count the constants, the turning point and the distance from
            it, r (|dq/dχ| at first), sin²χ/F (sin²χ at first), and what the roundings of the place are in proportion
            to; shape (7, lanes).
        bounds: what is found there: errors of F and of the kernels, F, F's own error; shape (3 + kernels, lanes).
    """

    buffer: Reals
    shares: Reals
    rows: Reals
    noise: Reals
    drift: Reals
    found: Reals
    lanes: Reals
    bounds: Reals


def scratch(tables: Tables, kernels: int) -> Scratch:
    """Return arrays to work in.

    Args:
        tables: of nodes.
        kernels: how many are wanted.
    """
    widest, most, rows = tables.low.shape[2], tables.places.shape[2] - FARTHEST, 1 + kernels
    lanes = VECTOR * ((2 * most + 6 + VECTOR) // VECTOR)
    shapes = {
        "buffer": (2 + rows, widest), "shares": (widest,), "rows": (3, widest), "noise": (rows, most), "drift": (most,),
        "found": (6, rows), "lanes": (7, lanes), "bounds": (2 + rows, lanes),
    }  # fmt: skip
    return Scratch(**{name: np.empty(shape) for name, shape in shapes.items()})


class Modes(NamedTuple):
    """What is wanted.

    Attributes:
        chords: F comes from its slopes between a turning point and the node; of small motions from second ones.
        kernels: ∂J/∂c are wanted.
        oscillations: the phase and the running integrals are, too.
        shifts: the errors of the constants are counted apart; not of small motions, where slopes have them.
        alike: both halves are seen by the same programs.
    """

    chords: bool
    kernels: bool
    oscillations: bool
    shifts: bool
    alike: bool


class Strips(NamedTuple):
    """Disks over the strips of all maps and sizes; see ``strips_of_analyticity``.

    Attributes:
        enough: radius of the one disk that holds a strip, in units of W/2; infinite for stretched maps.
        along, away, spread: real and imaginary distance of the middles from the end they are seen from, and radii, in
            units of W, of one map and size after the other; those that are seen from the lower end come first.
        counts: how many disks, how many are seen from the lower end, and where they begin, shape (3, maps, sizes); −1
            for not known yet.
    """

    enough: Reals
    along: Reals
    away: Reals
    spread: Reals
    counts: Integers


class Clearances(NamedTuple):
    """A table of radii; see ``clearance``.

    Attributes:
        depth: how often a cell was halved.
        start: where its parts begin.
        radii: of all of them.
    """

    depth: Integers
    start: Integers
    radii: Reals


def signatures() -> dict[str, Any]:
    """Return the types of the functions of a program by their names, in numba's terms; ``program_texts`` lists them."""
    from numba import types

    number, count = types.float64, types.int64
    row, block = types.Array(number, 1, "C"), types.Array(number, 2, "C")
    return {
        "value": number(number, row),
        "bend": types.UniTuple(number, 3)(number, row),
        "slopes": types.void(row, block, row, row),
        "fill": types.void(block, *(number,) * 5, row, row, row, row, count, count, row),
        "uncertainties": types.void(block, row, row, row, row, row),
        "relative": types.void(row, row, row, row, row, row),
        "bounds": types.void(block, row, row, row),
        "slope": types.void(row, block, row),
        "start": types.void(block, block, row),
        "momenta": types.void(block, block, row),
        "carried": types.void(block, block, row),
        "exact_starts": types.void(block, block, row),
        "exact_squares": types.void(row, row, block, row),
    }
