"""What passes between kernels and the rest of the engine: bundles of arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.run import MachineProgram
from hjsolve.arithmetic.machine.writer import MachineCode
from hjsolve.arithmetic.number_types import Integers, Mask, Reals, Which

VECTOR = 8
"""Lanes of a vector of doubles."""

FARTHEST = 6
"""Columns at the end of ``Tables.places``: the farthest places of either view in three parts."""

BLOCK = 16
"""Orbits that are integrated together."""

SLOTS = 392
"""Nodes that are worked out together, of one orbit or of several: what stays in the cache."""


class Tables(NamedTuple):
    """Nodes of all maps and sizes side by side, padded; see ``node_maps``.

    Attributes:
        maps: γ₁, γ₂, K, k′², ρ_d, ρ_c, the symmetry, and 1 for ``nodes_about_barrier_tops``, of every map,
            shape (maps, 8).
        counts: numbers of nodes, shape (sizes,).
        first: the places of the first nodes of every size in the next three, shape (sizes + 1,).
        low, high: (q − a)/W and (b − q)/W at the nodes of all sizes in a row, shape (maps, nodes).
        root: |dq/dχ|/W, the same shape.
        split: how many nodes are seen from the lower end, shape (maps, sizes, 3); see ``kernels.fitting_maps``.
        places: (q − a)/W, (b − q)/W, |dq/dχ|/W and sin²χ where errors are looked at, equally spaced in χ; and for every
            share the farthest that nodes are seen, from below and from above; shape (maps, 4, most + 6).
        samples: how many of them, shape (maps,).
        spans: how many of them are seen from below, and the first and last next to which nodes are seen in both ways,
            shape (maps, 3, 3).
        last, middle: cosines of the convergence test, shape (sizes, 5 or 3, widest).
        cosines: all of them, of one size after the other, rows of as many as there are nodes.
        rows: where those of every size begin, shape (sizes + 1,).
        squares, slopes: ``nodes.shifts``, plain and folded, shape (2, sizes, widest).
    """

    maps: Reals
    counts: Integers
    first: Integers
    low: Reals
    high: Reals
    root: Reals
    split: Integers
    places: Reals
    samples: Integers
    spans: Integers
    last: Reals
    middle: Reals
    cosines: Reals
    rows: Integers
    squares: Reals
    slopes: Reals


class Motions(NamedTuple):
    """One coordinate of n orbits between its turning points.

    Attributes:
        momentum: P₀, shape (n,).
        left, right: q₀ − a and b − q₀.
        width: b − a.
        lower, upper: offsets of the turning points in the views of the lower and of the upper half.
        homes: offsets in the same views of the turning points that places are counted from, shape (2, n).
        signs: +1 or −1, how these offsets grow away from the turning points, shape (2,).
        known: constants, and what else a program knows, shape (n, known).
        uncertainty: bounds on the errors of the constants, shape (n, constants).
        first, least: the map, and the size in the tables, to begin with; a negative size leaves the orbit out.
        fraction: how much is seen from below; see ``kernels.fitting_maps``.
        barrier_top: (q − a)/(b − q) at the crest about which nodes crowd, 1 where there is none.
    """

    momentum: Reals
    left: Reals
    right: Reals
    width: Reals
    lower: Reals
    upper: Reals
    homes: Reals
    signs: Reals
    known: Reals
    uncertainty: Reals
    first: Integers
    least: Integers
    fraction: Integers
    barrier_top: Reals


class Sums(NamedTuple):
    """Integrals of one coordinate; arrays (n,), or (constants, n).

    Attributes:
        action: (1/2π) ∮ |p| dq.
        means: ∂J/∂cⱼ.
        oscillations: ∫₀^χ₀ kⱼ r dχ less its mean growth.
        phase: χ of the start.
        speeds: kⱼ r there.
        action_error, mean_errors, oscillation_errors, phase_error: bounds.
        good: True where the nodes sufficed.
        chosen: size and map that did, shape (2, n).
    """

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

    def put(self, index: Which, other: Sums) -> None:
        """Write the results of some orbits into these.

        Args:
            index: the places of the orbits, ascending positions or a mask.
            other: their results, in the same order.
        """
        everything = len(other.good) == len(self.good)  # as a rule: then nothing is picked
        for mine, theirs in zip(self, other, strict=True):
            mine[..., slice(None) if everything else index] = theirs

    def take(self, index: Which) -> Sums:
        """Return the results of some of the orbits.

        Args:
            index: which, positions or a mask.
        """
        return Sums._make(array[..., index] for array in self)


def no_sums(constants: int, count: int) -> Sums:
    """Return sums that hold nothing: nan, and ``good`` nowhere true.

    Args:
        constants: how many constants of the motion there are.
        count: how many orbits.
    """
    block = np.full((4 + 5 * constants, count), np.nan)  # at once: a call for each array takes longer than few orbits
    action, action_error, phase, phase_error = block[:4]
    means, mean_errors, oscillations, oscillation_errors, speeds = block[4:].reshape(5, constants, count)
    return Sums(
        action, action_error, means, mean_errors, oscillations, oscillation_errors, phase, phase_error, speeds,
        good=np.zeros(count, dtype=bool), chosen=np.zeros((2, count), dtype=np.int64),
    )  # fmt: skip


class Side(NamedTuple):
    """The programs by which one half of a motion is seen, with registers for a block of orbits.

    Attributes:
        fill: of the nodes.
        errors, relative: of the places where errors are looked at; the last one is not used without chords.
    """

    fill: MachineProgram
    errors: MachineProgram
    relative: MachineProgram


class Scratch(NamedTuple):
    """What a block of orbits is worked out in.

    Attributes:
        buffer: F r, r, F and the kernels times r at the nodes of one orbit, shape (3 + kernels, widest).
        fractions: of the nodes, shape (widest,).
        rows: of the same width, shape (3, widest).
        noise: of each orbit bounds on the rounding errors of F (times sin²χ/F; with chords relative ones) and of the
            kernels (times r), shape (block, 1 + kernels, samples).
        drift: what the constants add to the first, times sin²χ/F; without kernels the first as it is; shape
            (block, samples).
        found: mean, its error, last coefficient, rounding, and sizes of the last coefficients and of those before, of
            every integrand, shape (6, 1 + kernels).
        slots: of either view, where errors are looked at: the place, which of them count the constants, the turning
            point and the distance from it, r (|dq/dχ| at first), sin²χ/F (sin²χ at first), and the rounding of the
            place; shape (2, 7, lanes).
        bounds: of either view, what is found there: errors of F and of the kernels, F, F's relative error; shape
            (2, 3 + kernels, lanes).
        residues: what F is at either turning point, shape (block, 2).
        block: int64, of each orbit of the block: which it is, its size and map, its first lanes of either view, and
            those not done yet; shape (6, block).
    """

    buffer: Reals
    fractions: Reals
    rows: Reals
    noise: Reals
    drift: Reals
    found: Reals
    slots: Reals
    bounds: Reals
    residues: Reals
    block: Integers


def scratch(tables: Tables, kernels: int) -> Scratch:
    """Return arrays to work in.

    Args:
        tables: of nodes.
        kernels: how many are wanted.
    """
    widest, most, rows = tables.last.shape[2], tables.places.shape[2] - FARTHEST, 1 + kernels
    slots = looked_at(tables)
    shapes = {
        "buffer": (2 + rows, widest), "fractions": (widest,), "rows": (3, widest), "noise": (BLOCK, rows, most),
        "drift": (BLOCK, most), "found": (6, rows), "slots": (2, 7, slots), "bounds": (2, 2 + rows, slots),
        "residues": (BLOCK, 2),
    }  # fmt: skip
    arrays = {name: np.empty(shape) for name, shape in shapes.items()}
    return Scratch(**arrays, block=np.zeros((6, BLOCK), dtype=np.int64))


def looked_at(tables: Tables) -> int:
    """Return how many lanes a block needs for the places where errors are looked at.

    Args:
        tables: of nodes.
    """
    most = tables.places.shape[2] - FARTHEST
    return VECTOR * (BLOCK * (2 * most + 3) // VECTOR + 1)


def side(
    fill: MachineCode, errors: MachineCode, relative: MachineCode | None, tables: Tables,
    parameters: tuple[float, ...], half: int,
) -> Side:  # fmt: skip
    """Return the programs of one half with registers for a block.

    Args:
        fill, errors, relative: codes.
        tables: of nodes.
        parameters: their values.
        half: 0 for the lower and 1 for the upper one: they may have the same codes.
    """
    slots, nodes = looked_at(tables), max(SLOTS, tables.last.shape[2])
    codes = (fill, nodes), (errors, slots), (errors if relative is None else relative, slots)
    return Side(*(code.program(width, parameters, half) for code, width in codes))


class Modes(NamedTuple):
    """What is wanted.

    Attributes:
        chords: F comes from its slopes between a turning point and the node; of small motions from second ones.
        kernels: ∂J/∂c are wanted.
        oscillations: the phase and the running integrals are, too.
        shifts: the errors of the constants are counted apart; not of small motions, where slopes have them.
        approximate: few nodes, and neither proofs nor errors: for the first steps of a search.
    """

    chords: bool
    kernels: bool
    oscillations: bool
    shifts: bool
    approximate: bool = False


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
