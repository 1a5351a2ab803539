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
from hjsolve.ensembles.engine.compiled_types import FARTHEST, VECTOR, Modes, Motions, Results, Scratch, Tables
from hjsolve.ensembles.engine.elementary import INLINED

Uncertainties = Callable[[Reals, Reals, Reals, Reals, Reals, Reals], None]
Relative = Callable[[Reals, Reals, Reals, Reals, Reals, Reals], None]


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
def _placed(work: Scratch, at: int, end: tuple[float, float, float], W: float, places: Reals,
            span: tuple[int, int, int], which: int, kernels: bool) -> int:  # fmt: skip
    """Write into ``lanes``, from one on, where a view is looked at; return the first lane after them.

    Samples, the farthest place and the turning point; with kernels the former once more, the constants being certain.
    """
    lanes, (start, count, farthest), (b, s, h) = work.lanes, span, end
    tip = at + count + 1
    after = tip + 1 + (count + 1 if kernels else 0)
    for g in range(at, after):
        lanes[1, g], lanes[2, g], lanes[3, g], lanes[4, g], lanes[5, g] = 0.0, b, 0.0, 0.0, 0.0
    for g in range(count + 1):
        place = start + g if g < count else farthest
        offset = s * W * places[which, place]
        away = offset if h == b else -s * W * places[1 - which, place]
        lanes[0, at + g], lanes[1, at + g], lanes[3, at + g] = h + away, 1.0, offset
        lanes[6, at + g] = max(abs(h + away), abs(away))
        lanes[4, at + g], lanes[5, at + g] = W * places[2, place], places[3, place]
        if kernels:
            for row in (0, 3, 6):
                lanes[row, tip + 1 + g] = lanes[row, at + g]
    lanes[0, tip], lanes[6, tip] = b, abs(b)
    return after


@njit(**INLINED)
def _looked(uncertainties: Uncertainties, relative: Relative, total: int, c: Reals, e: Reals, work: Scratch,
            chords: bool) -> None:  # fmt: skip
    """Leave F, bounds on the errors of F and of the kernels, and F's relative one, of the lanes in ``bounds``."""
    lanes, bounds, rows, stop = work.lanes, work.bounds, work.noise.shape[0], total
    while stop % VECTOR:
        for k in range(lanes.shape[0]):
            lanes[k, stop] = lanes[k, 0]
        stop += 1
    uncertainties(bounds, lanes[0, :stop], lanes[6, :stop], lanes[1, :stop], c, e)
    if chords:
        relative(bounds[rows + 1, :stop], lanes[2, :stop], lanes[3, :stop], lanes[0, :stop], lanes[6, :stop], c)
    for g in range(stop):  # r, and sin²χ/F
        F = max(abs(bounds[rows, g]), 1e-300)
        lanes[4, g] /= np.sqrt(F)
        lanes[5, g] /= F


@njit(**INLINED)
def _noted(work: Scratch, at: int, span: tuple[int, int, int], both: tuple[int, int], modes: Modes) -> float:
    """Note what one view says of its samples; and of all between which both are used, by its farthest place.

    F and its errors vary along the motion like F/sin²χ, and errors of kernels like 1/r: so they are noted by these.
    Returns what F is at the turning point, which is left out where F comes from chords.
    """
    bounds, lanes, noise, drift, rows = work.bounds, work.lanes, work.noise, work.drift, work.noise.shape[0]
    start, count, _ = span
    tip = at + count + 1
    end = abs(bounds[rows, tip]) + bounds[0, tip] if modes.chords else 0.0
    for g in range(count + 1):
        first, last = (start + g, start + g) if g < count else both
        r, share, here = lanes[4, at + g], lanes[5, at + g], bounds[0, at + g]
        again = bounds[0, tip + 1 + g] if modes.kernels else here
        own = bounds[rows + 1, at + g] if modes.chords else again * share
        moved = (end + here - again) * share if modes.kernels else here
        for to in range(first, last + 1):
            for k in range(1, rows):
                noise[k, to] = max(noise[k, to], bounds[k, at + g] * r)
            noise[0, to], drift[to] = max(noise[0, to], own), max(drift[to], moved)
    return end


@njit(**INLINED)
def _samples(below: tuple[Uncertainties, Relative], above: tuple[Uncertainties, Relative], motions: Motions, i: int,
             tables: Tables, work: Scratch, modes: Modes) -> tuple[float, float]:  # fmt: skip
    """Bounds on the errors of F and of the kernels at a few places, each seen as the nodes beside it.

    Returns F's error at either turning point, where F comes from chords. Programs that are the same work out both
    views at once: as one vector they take half the time.
    """
    m, share = motions.first[i], motions.share[i]
    samples, places = tables.samples[m], tables.places[m]
    inside, first, last = tables.spans[m, share, 0], tables.spans[m, share, 1], tables.spans[m, share, 2]
    c, e, W = motions.known[i], motions.uncertainty[i], motions.width[i]
    for g in range(samples):
        work.drift[g] = 0.0
        for k in range(work.noise.shape[0]):
            work.noise[k, g] = 0.0
    farthest = places.shape[1] - FARTHEST + 2 * share
    near, far, both = (0, inside, farthest), (inside, samples - inside, farthest + 1), (first, last)
    low_end = motions.lower[i], motions.signs[0], motions.low_home[i]
    high_end = motions.upper[i], motions.signs[1], motions.high_home[i]
    middle = _placed(work, 0, low_end, W, places, near, 0, modes.kernels)
    one_sided = inside == samples
    if one_sided or not modes.alike:
        _looked(below[0], below[1], middle, c, e, work, modes.chords)
        lower = _noted(work, 0, near, both, modes)
        if one_sided:
            return lower, lower
        total = _placed(work, 0, high_end, W, places, far, 1, modes.kernels)
        _looked(above[0], above[1], total, c, e, work, modes.chords)
        return lower, _noted(work, 0, far, both, modes)
    total = _placed(work, middle, high_end, W, places, far, 1, modes.kernels)
    _looked(below[0], below[1], total, c, e, work, modes.chords)
    return _noted(work, 0, near, both, modes), _noted(work, middle, far, both, modes)


@njit(**INLINED)
def integrals(fill_below: Fill, fill_above: Fill, uncertainties_below: Uncertainties,
              uncertainties_above: Uncertainties, relative_below: Relative, relative_above: Relative,
              motions: Motions, tables: Tables, modes: Modes, results: Results, work: Scratch,
              steady: Reals) -> None:  # fmt: skip
    """The integrals of one coordinate of many orbits.

    Args:
        fill_below, uncertainties_below, relative_below: programs of the view of the lower half; see ``program_texts``.
        fill_above, uncertainties_above, relative_above: of the upper half.
        motions: of n orbits.
        tables: of nodes.
        modes: what is wanted.
        results: arrays filled here.
        work: see ``compiled_types.scratch``.
        steady: as many zeros as there are constants.
    """
    constants, buffer, found = results.means.shape[0], work.buffer, work.found
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
        n, symmetry = tables.counts[size], tables.maps[m, 6]
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
