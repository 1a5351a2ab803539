"""The loop over orbits of the compiled pass. Only imported where numba is.

The programs of the coordinate come in as functions, so that the loop is compiled once for all systems.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.engine.compiled_phase import phase, running_weights
from hjsolve.ensembles.engine.compiled_rule import REDUCING, Fill, choose, dot, shifted_action
from hjsolve.ensembles.engine.compiled_types import Modes, Motions, Results, Scratch, Tables
from hjsolve.ensembles.engine.elementary import INLINED

_VECTOR = 8
_FARTHEST = 6
Uncertainties = Callable[[Reals, Reals, Reals, Reals, Reals], None]
Relative = Callable[[Reals, Reals, Reals, Reals], None]


@njit(**INLINED)
def _shifts(work: Scratch, residue: tuple[float, float], E: Reals, place: tuple[int, int, int], tables: Tables,
            tilted: bool) -> None:  # fmt: skip
    """Add to the bounds what small shifts of F do: constants 2 kⱼ δcⱼ and the residues; see ``nodes.shifts``.

    Below the middle F is seen from the lower turning point and has its residue, above it that of the upper one; or it
    lacks a linear function between the two, which is tilted by no more than twice the larger one.
    """
    (m, size, share), buffer, scratch, found = place, work.buffer, work.rows, work.found
    n, split, symmetry = tables.counts[size], tables.split[m, size, share], int(tables.maps[m, 6])
    squares, slopes, low = tables.squares[symmetry - 1, size], tables.slopes[symmetry - 1, size], tables.low[m, size]
    constants = buffer.shape[0] - 3
    for j in range(n):
        scratch[0, j] = squares[j] / buffer[2, j]
        scratch[1, j] = scratch[0, j] / buffer[1, j]
    for k in range(constants):
        row = buffer[3 + k]
        if residue[0] != 0.0 or residue[1] != 0.0:
            for j in range(n):
                scratch[2, j] = row[j] * scratch[0, j] * (residue[0] if j < split else residue[1])
            total = _swing(scratch[2], slopes, n)
            if tilted:
                for j in range(n - 1):
                    total += 2.0 * abs(scratch[2, j]) * abs(low[j + 1] - low[j]) * slopes[j]
            found[1, 1 + k] += total
            found[2, 1 + k] += 0.5 * total
        for l in range(k + 1):
            if E[l] != 0.0 or E[k] != 0.0:
                other = buffer[3 + l]
                for j in range(n):
                    scratch[2, j] = row[j] * other[j] * scratch[1, j]
                total = _swing(scratch[2], slopes, n)
                found[1, 1 + k] += 2.0 * E[l] * total
                found[2, 1 + k] += E[l] * total
                if l < k:
                    found[1, 1 + l] += 2.0 * E[k] * total
                    found[2, 1 + l] += E[k] * total


@njit(**REDUCING)
def _swing(g: Reals, slopes: Reals, n: int) -> float:
    """Σ |Δg| cot χ/π, from node to node."""
    total = 0.0
    for j in range(n - 1):
        total += abs(g[j + 1] - g[j]) * slopes[j]
    return total


@njit(**INLINED)
def _seen(uncertainties: Uncertainties, relative: Relative, b: float, s: float, W: float, places: Reals,
          span: tuple[int, int, int], c: Reals, e: Reals, work: Scratch, modes: Modes) -> float:  # fmt: skip
    """Rounding errors at some places of one view, and F's at the turning point where that is used.

    They are left in ``bounds``: F and the kernels, then F's relative error or its rounding without the constants. The
    lanes are the places, the farthest one, and the turning point.
    """
    lanes, bounds, (start, count, farthest) = work.lanes, work.bounds, span
    x, mask, rows = lanes[0], lanes[1], work.noise.shape[0]
    for g in range(count + 1):
        x[g], mask[g] = b + s * W * places[start + g if g < count else farthest], 1.0
    x[count + 1], mask[count + 1] = b, 0.0
    total, end = count + 2, 0.0
    if modes.kernels:
        for g in range(count + 1):
            x[count + 2 + g], mask[count + 2 + g] = x[g], 0.0
        total = 2 * count + 3
    while total % _VECTOR:
        x[total], mask[total] = x[0], 0.0
        total += 1
    uncertainties(bounds, x[:total], mask[:total], c, e)
    last = bounds[rows + 1]
    if modes.chords:  # F less its rounding at the turning point, which shifts it as a constant does
        end = abs(bounds[rows, count + 1]) + bounds[0, count + 1]
        for g in range(total):
            lanes[2, g], lanes[3, g] = b, x[g] - b
        relative(last[:total], lanes[2, :total], lanes[3, :total], c)
    else:
        for g in range(count + 1):
            last[g] = bounds[0, count + 2 + g] if modes.kernels else bounds[0, g]
    return end


@njit(**INLINED)
def _noted(work: Scratch, span: tuple[int, int, int], both: tuple[int, int], places: Reals, W: float, end: float,
           modes: Modes) -> None:  # fmt: skip
    """Note what one view says of its samples; and of all between which both are used, by its farthest place.

    F and its errors vary along the motion like F/sin²χ, and errors of kernels like 1/r: so they are noted by these.
    """
    bounds, noise, drift, rows = work.bounds, work.noise, work.drift, work.noise.shape[0]
    start, count, farthest = span
    for g in range(count + 1):
        first, last = (start + g, start + g) if g < count else both
        at = start + g if g < count else farthest
        x, y, derivative, square = places[0, at], places[1, at], places[2, at], places[3, at]
        F = max(abs(bounds[rows, g]), 1e-300)
        r, share = derivative * W * np.sqrt(x * y / F), square / F
        own = bounds[rows + 1, g] * (1.0 if modes.chords else share)
        moved = (end + bounds[0, g] - bounds[0, count + 2 + g]) * share if modes.kernels else bounds[0, g]
        for to in range(first, last + 1):
            for k in range(1, rows):
                noise[k, to] = max(noise[k, to], bounds[k, g] * r)
            noise[0, to], drift[to] = max(noise[0, to], own), max(drift[to], moved)


@njit(**INLINED)
def _samples(below: tuple[Uncertainties, Relative], above: tuple[Uncertainties, Relative], motions: Motions, i: int,
             tables: Tables, work: Scratch, modes: Modes) -> tuple[float, float]:  # fmt: skip
    """Bounds on the errors of F and of the kernels at a few places, each seen as the nodes beside it.

    Returns F's error at either turning point, where F comes from chords.
    """
    m, share = motions.first[i], motions.share[i]
    samples, places = tables.samples[m], tables.places[m]
    inside, first, last = tables.spans[m, share, 0], tables.spans[m, share, 1], tables.spans[m, share, 2]
    c, e, W = motions.known[i], motions.uncertainty[i], motions.width[i]
    work.noise[:] = 0.0
    work.drift[:] = 0.0
    farthest = places.shape[1] - _FARTHEST + 2 * share
    span = (0, inside, farthest)
    lower = _seen(below[0], below[1], motions.lower[i], motions.signs[0], W, places[0], span, c, e, work, modes)
    _noted(work, span, (first, last), places, W, lower, modes)
    if inside == samples:
        return lower, lower
    span = (inside, samples - inside, farthest + 1)
    upper = _seen(above[0], above[1], motions.upper[i], motions.signs[1], W, places[1], span, c, e, work, modes)
    _noted(work, span, (first, last), places, W, upper, modes)
    return lower, upper


@njit(**INLINED)
def integrals(fill_below: Fill, fill_above: Fill, uncertainties_below: Uncertainties,
              uncertainties_above: Uncertainties, relative_below: Relative, relative_above: Relative,
              motions: Motions, tables: Tables, modes: Modes, results: Results) -> None:  # fmt: skip
    """The integrals of one coordinate of many orbits.

    Args:
        fill_below, uncertainties_below, relative_below: programs of the view of the lower half; see ``program_texts``.
        fill_above, uncertainties_above, relative_above: of the upper half.
        motions: of n orbits.
        tables: of nodes.
        modes: what is wanted.
        results: arrays filled here.
    """
    constants, widest = results.means.shape[0], tables.low.shape[2]
    rows = constants if modes.kernels else 0
    most = tables.places.shape[2] - _FARTHEST
    lanes = _VECTOR * ((2 * most + 2 + _VECTOR) // _VECTOR)
    work = Scratch(
        np.empty((3 + rows, widest)), np.empty(widest), np.empty((3, widest)), np.empty((1 + rows, most)),
        np.empty(most), np.empty((6, 1 + rows)), np.empty((4, lanes)), np.empty((3 + rows, lanes)),
    )  # fmt: skip
    steady = np.zeros(constants)
    for i in range(motions.width.shape[0]):
        if not motions.width[i] > 0.0 or motions.least[i] < 0:
            continue
        residue = _samples(
            (uncertainties_below, relative_below),
            (uncertainties_above, relative_above),
            motions,
            i,
            tables,
            work,
            modes,
        )
        size, m = choose(fill_below, fill_above, motions, i, tables, work, modes)
        if size < 0:
            continue
        found, buffer, n, symmetry = work.found, work.buffer, tables.counts[size], tables.maps[m, 6]
        results.chosen[0, i], results.chosen[1, i] = size, m
        results.good[i], results.action[i], results.action_error[i] = True, found[0, 0], found[1, 0]
        if modes.kernels:
            if modes.shifts or modes.chords:
                share, largest = motions.share[i], max(residue[0], residue[1])
                if modes.shifts:
                    shaken, steps = motions.uncertainty[i], residue
                else:
                    shaken, steps = steady, (largest, largest)
                split = tables.split[m, size, share]
                results.action_error[i] += shifted_action(work, steps, shaken, n, split)
                _shifts(work, steps, shaken, (m, size, share), tables, not modes.shifts)
            for k in range(constants):
                results.means[k, i], results.mean_errors[k, i] = found[0, 1 + k], found[1, 1 + k]
        if modes.oscillations:
            results.phase[i], results.phase_error[i] = phase(work, motions, i, (m, size), tables, modes.chords)
            for k in range(constants):
                results.speeds[k, i] = dot(buffer[3 + k], work.shares, n)
            running_weights(work.shares, work.rows, symmetry * results.phase[i], n, tables.cosines[size])
            for k in range(constants):
                results.oscillations[k, i] = 2.0 / (n * symmetry) * dot(buffer[3 + k], work.shares, n)
                results.oscillation_errors[k, i] = 4.0 * found[2, 1 + k]
