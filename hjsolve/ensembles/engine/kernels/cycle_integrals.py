"""The integrals of one coordinate over a cycle, for many orbits: blocks of orbits, each with the nodes that it needs.

With F = (q − a)(b − q) S and the anomaly χ of ``node_maps``, J = (1/2π) ∮ √F dq and ∂J/∂cⱼ = (1/2π) ∮ kⱼ dq/√F,
kⱼ = ½ ∂F/∂cⱼ, are means of F r and of kⱼ r over equally spaced χ, r = |dq/dχ|/√F. These are analytic, even and periodic
in χ, so the midpoint rule converges geometrically (Trefethen & Weideman, SIAM Review 56 (2014) 385, §3).

Nodes of many orbits are worked out in one run of the machine, as one orbit has too few to fill its lanes.
"""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.floats import UNIT
from hjsolve.arithmetic.machine.compiling import helper, inlined, kernel, reducing
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.engine.kernels.midpoint_rule import dot, means, next_rule, rule, shifted_action
from hjsolve.ensembles.engine.kernels.start_phase import moved_by_barrier_top, phase, running_weights
from hjsolve.ensembles.engine.kernels.types import (
    BLOCK,
    FARTHEST,
    SLOTS,
    Modes,
    Motions,
    Scratch,
    Side,
    Sums,
    Tables,
)

_TRIES = 6  # numbers of nodes that an orbit tries
_PLACE = 2.0 * UNIT  # roundings that made a place, in proportion to it or to the distance it is counted from
_ORBIT, _SIZE, _MAP, _LOW, _HIGH, _LEFT = range(6)  # rows of ``Scratch.block``


@helper
def _shifts(work: Scratch, residue: tuple[float, float], E: Reals, place: tuple[int, int, int], tables: Tables,
            tilted: bool) -> None:  # fmt: skip
    """Add to the bounds what small shifts of F do: constants 2 kⱼ δcⱼ and the residues; see ``nodes.shifts``.

    Below the middle F is seen from the lower turning point and has its residue, above it that of the upper one; or it
    lacks a linear function between the two, which is tilted by no more than twice the larger one.
    """
    (m, size, fraction), buffer, scratch, found = place, work.buffer, work.rows, work.found
    n, split, symmetry = tables.counts[size], tables.split[m, size, fraction], int(tables.maps[m, 6])
    squares, slopes = tables.squares[symmetry - 1, size], tables.slopes[symmetry - 1, size]
    # (q − a)/W at the nodes: a linear function of it is what the tilt takes
    low = tables.low[m, tables.first[size] : tables.first[size + 1]]
    shaken, flatter, moved = scratch[0], scratch[1], scratch[2]  # sin²χ/F, that over r, and k r δF sin²χ/F
    r, F = buffer[1], buffer[2]
    # a shift δF at a turning point moves it, and the integrand is singular there: bounds take the finite part alone
    for j in range(n):
        shaken[j] = squares[j] / F[j]
        flatter[j] = shaken[j] / r[j]
    residues = residue[0] != 0.0 or residue[1] != 0.0
    for k in range(buffer.shape[0] - 3):
        row = buffer[3 + k]
        if residues:
            for j in range(n):
                moved[j] = row[j] * shaken[j] * (residue[0] if j < split else residue[1])
            total = _variation(moved, slopes, n) + (2.0 * _tilt(moved, low, slopes, n) if tilted else 0.0)
            found[1, 1 + k] += total
            found[2, 1 + k] += 0.5 * total
        # δF = 2 kₗ δcₗ moves ∂J/∂cₖ as it moves ∂J/∂cₗ: the matrix of second derivatives is symmetric
        for l in range(k + 1):
            if E[l] != 0.0 or E[k] != 0.0:
                other = buffer[3 + l]
                for j in range(n):
                    moved[j] = row[j] * other[j] * flatter[j]
                total = _variation(moved, slopes, n)
                found[1, 1 + k] += 2.0 * E[l] * total
                found[2, 1 + k] += E[l] * total
                if l < k:
                    found[1, 1 + l] += 2.0 * E[k] * total
                    found[2, 1 + l] += E[k] * total


@reducing
def _variation(g: Reals, slopes: Reals, n: int) -> float:
    """Σ |Δg| cot χ/π, from node to node."""
    after, total = g[1:], 0.0
    for j in range(n - 1):
        total += abs(after[j] - g[j]) * slopes[j]
    return total


@reducing
def _tilt(g: Reals, low: Reals, slopes: Reals, n: int) -> float:
    """Σ |g| Δ(q − a)/W cot χ/π."""
    after, total = low[1:], 0.0
    for j in range(n - 1):
        total += abs(g[j]) * abs(after[j] - low[j]) * slopes[j]
    return total


@helper
def _placed(slots: Reals, at: int, end: tuple[float, float, float], W: float, places: Reals,
            span: tuple[int, int, int], barrier_top: float, which: int, kernels: bool) -> int:  # fmt: skip
    """Write into ``slots``, from one on, where a view is looked at; return the first lane after them.

    Samples, the farthest place and the turning point; with kernels the former once more, the constants being certain.
    Places are counted from the turning point h, distances from b.
    """
    (start, count, farthest), (b, s, h) = span, end
    tip = count + 1
    near = barrier_top if which == 0 else 1.0 / barrier_top
    after = at + tip + 1 + (count + 1 if kernels else 0)
    where, counted, ends, away = slots[0, at:after], slots[1, at:after], slots[2, at:after], slots[3, at:after]
    roots, squares, rounding_error = slots[4, at:after], slots[5, at:after], slots[6, at:after]
    for g in range(after - at):
        where[g], counted[g], ends[g], away[g] = b, 0.0, b, 0.0
        roots[g], squares[g], rounding_error[g] = 0.0, 0.0, _PLACE * abs(b)
    own, other = places[which], places[1 - which]
    for g in range(tip):
        place = start + g if g < count else farthest
        # counted from where F is anchored: q − h has digits of its own next to h
        x, y, root = own[place], other[place], places[2, place]
        if barrier_top != 1.0:
            x, y, root = moved_by_barrier_top(x, y, root, near)
        offset = s * W * x
        moved = offset if h == b else -s * W * y
        where[g], counted[g], away[g] = h + moved, 1.0, offset
        rounding_error[g] = _PLACE * max(abs(h + moved), abs(moved))
        roots[g], squares[g] = W * root, places[3, place]
    if kernels:
        for g in range(tip):
            again = tip + 1 + g
            where[again], away[again], rounding_error[again] = where[g], away[g], rounding_error[g]
    return after


@inlined
def _known(program: MachineProgram, first: int, span: tuple[int, int], c: Reals) -> None:
    """Write the values of one orbit into some lanes, from one register on."""
    for k in range(c.shape[0]):
        row, value = program.registers[first + k, span[0] : span[1]], c[k]
        for g in range(span[1] - span[0]):
            row[g] = value


@helper
def _looked(side: Side, slots: Reals, bounds: Reals, total: int, chords: bool) -> None:
    """Leave F, bounds on the errors of F and of the kernels, and F's relative one, of the lanes in ``bounds``."""
    rows, width = bounds.shape[0] - 2, (total + 7) // 8 * 8
    for k, row in ((0, 0), (1, 6), (2, 1)):
        register = side.errors.registers[k]
        for g in range(total):
            register[g] = slots[row, g]
    run(side.errors, width)
    for k in range(rows + 1):
        result = side.errors.registers[side.errors.outputs[k]]
        for g in range(total):
            bounds[k, g] = result[g]
    if chords:
        for k, row in ((0, 2), (1, 3), (2, 0), (3, 6)):
            register = side.relative.registers[k]
            for g in range(total):
                register[g] = slots[row, g]
        run(side.relative, width)
        result = side.relative.registers[side.relative.outputs[0]]
        for g in range(total):
            bounds[rows + 1, g] = result[g]
    for g in range(total):  # r, and sin²χ/F
        F = max(abs(bounds[rows, g]), 1e-300)
        slots[4, g] /= np.sqrt(F)
        slots[5, g] /= F


@helper
def _noted(work: Scratch, t: int, which: int, at: int, span: tuple[int, int, int], both: tuple[int, int],
           modes: Modes) -> float:  # fmt: skip
    """Note what one view says of samples; and of all between which both are used, by its farthest place.

    F and its errors vary along the motion like F/sin²χ, and errors of kernels like 1/r: so they are noted by these.
    Returns what F is at the turning point, which is left out where F comes from chords.
    """
    bounds, slots, noise, drift = work.bounds[which], work.slots[which], work.noise[t], work.drift[t]
    rows, (start, count, _) = noise.shape[0], span
    tip = at + count + 1
    end = abs(bounds[rows, tip]) + bounds[0, tip] if modes.chords else 0.0
    # kernels' second lanes have certain constants: here − again is what the uncertain ones do
    for g in range(count + 1):
        first, last = (start + g, start + g) if g < count else both
        r, fraction, here = slots[4, at + g], slots[5, at + g], bounds[0, at + g]
        again = bounds[0, tip + 1 + g] if modes.kernels else here
        own = bounds[rows + 1, at + g] if modes.chords else again * fraction
        moved = (end + here - again) * fraction if modes.kernels else here
        for to in range(first, last + 1):
            for k in range(1, rows):
                noise[k, to] = max(noise[k, to], bounds[k, at + g] * r)
            noise[0, to], drift[to] = max(noise[0, to], own), max(drift[to], moved)
    return end


@inlined
def _cleared(work: Scratch, t: int, samples: int) -> None:
    drift = work.drift[t]
    for g in range(samples):
        drift[g] = 0.0
    for k in range(work.noise.shape[1]):
        row = work.noise[t, k]
        for g in range(samples):
            row[g] = 0.0


@inlined
def _spans(tables: Tables, m: int, fraction: int, which: int) -> tuple[int, int, int]:
    """Return the samples that a view looks at, and its farthest place."""
    inside, farthest = tables.spans[m, fraction, 0], tables.places.shape[2] - FARTHEST + 2 * fraction
    return (0, inside, farthest) if which == 0 else (inside, tables.samples[m] - inside, farthest + 1)


@helper
def _samples(below: Side, above: Side, motions: Motions, count: int, tables: Tables, work: Scratch,
             modes: Modes) -> None:  # fmt: skip
    """Bounds on the errors of F and of the kernels at a few places of each orbit, each seen as the nodes next to it."""
    block, constants = work.block, motions.uncertainty.shape[1]
    known = motions.known.shape[1]
    for which in range(2):
        side, after = (below, 0) if which == 0 else (above, 0)
        for t in range(count):
            i = block[_ORBIT, t]
            m, fraction = motions.first[i], motions.fraction[i]
            span, begin = _spans(tables, m, fraction, which), after
            block[_LOW + which, t] = begin
            if span[1] == 0:
                continue
            b = motions.lower[i] if which == 0 else motions.upper[i]
            end = (b, motions.signs[which], motions.homes[which, i])
            slots, W = work.slots[which], motions.width[i]
            barrier_top = motions.barrier_top[i]
            after = _placed(slots, begin, end, W, tables.places[m], span, barrier_top, which, modes.kernels)
            _known(side.errors, 3, (begin, after), motions.known[i])
            _known(side.errors, 3 + known, (begin, after), motions.uncertainty[i, :constants])
            if modes.chords:
                _known(side.relative, 4, (begin, after), motions.known[i])
        if after > 0:
            _looked(side, work.slots[which], work.bounds[which], after, modes.chords)
    for t in range(count):
        i = block[_ORBIT, t]
        m, fraction = motions.first[i], motions.fraction[i]
        _cleared(work, t, tables.samples[m])
        both = (tables.spans[m, fraction, 1], tables.spans[m, fraction, 2])
        residue = _noted(work, t, 0, block[_LOW, t], _spans(tables, m, fraction, 0), both, modes)
        work.residues[t, 0], work.residues[t, 1] = residue, residue
        span = _spans(tables, m, fraction, 1)
        if span[1] > 0:
            work.residues[t, 1] = _noted(work, t, 1, block[_HIGH, t], span, both, modes)


@helper
def _nodes(fill: MachineProgram, which: int, at: int, motions: Motions, i: int, place: tuple[int, int, int, int],
           tables: Tables) -> None:  # fmt: skip
    """Write nodes of one orbit that are seen from one end into the lanes of a program, from one lane on."""
    m, size, first, stop = place
    begin, n, W, after = tables.first[size] + first, stop - first, motions.width[i], at + stop - first
    low, high, root = tables.low[m, begin : begin + n], tables.high[m, begin : begin + n], tables.root[m, begin:]
    near, far = (low, high) if which == 0 else (high, low)
    b, s, h = (motions.lower[i] if which == 0 else motions.upper[i]), motions.signs[which], motions.homes[which, i]
    distances, places = fill.registers[0, at:after], fill.registers[1, at:after]
    roots, ends = fill.registers[2, at:after], fill.registers[3, at:after]
    if motions.barrier_top[i] != 1.0:
        barrier_top = motions.barrier_top[i] if which == 0 else 1.0 / motions.barrier_top[i]
        for j in range(n):
            x, y, r = moved_by_barrier_top(near[j], far[j], root[j], barrier_top)
            distances[j], roots[j], ends[j] = s * W * x, W * r, b
            places[j] = b + s * W * x if h == b else h - s * W * y
        _known(fill, 4, (at, after), motions.known[i])
        return
    for j in range(n):
        distances[j] = s * W * near[j]
        roots[j] = W * root[j]
        ends[j] = b
    if h == b:
        for j in range(n):
            places[j] = b + s * W * near[j]
    else:
        for j in range(n):
            places[j] = h - s * W * far[j]
    _known(fill, 4, (at, after), motions.known[i])


@helper
def packed(below: Side, above: Side, motions: Motions, span: tuple[int, int], tables: Tables,
            work: Scratch) -> int:  # fmt: skip
    """Work out the nodes of as many orbits, of those not done yet, as have room; return the first that has none."""
    block, at, low, high = work.block, span[0], 0, 0
    while at < span[1]:
        t = block[_LEFT, at]
        i, m, size = block[_ORBIT, t], block[_MAP, t], block[_SIZE, t]
        # nodes below ``split`` are seen from the lower turning point, the others from the upper one
        n, split = tables.counts[size], tables.split[m, size, motions.fraction[i]]
        # the first orbit is taken whatever it needs: programs are as wide as the widest rule
        if at > span[0] and (low + split > SLOTS or high + n - split > SLOTS):
            break
        _nodes(below.fill, 0, low, motions, i, (m, size, 0, split), tables)
        if split < n:
            _nodes(above.fill, 1, high, motions, i, (m, size, split, n), tables)
        block[_LOW, t], block[_HIGH, t] = low, high
        low, high, at = low + split, high + n - split, at + 1
    run(below.fill, (low + 7) // 8 * 8)
    if high > 0:
        run(above.fill, (high + 7) // 8 * 8)
    return at


@inlined
def gathered(below: Side, above: Side, work: Scratch, t: int, n: int, split: int) -> None:
    """Bring the nodes of one orbit into the buffer."""
    low, high, rest = work.block[_LOW, t], work.block[_HIGH, t], n - split
    for k in range(work.buffer.shape[0]):
        row, seen = work.buffer[k], below.fill.registers[below.fill.outputs[k], low : low + split]
        for j in range(split):
            row[j] = seen[j]
        if rest > 0:
            row, seen = row[split:n], above.fill.registers[above.fill.outputs[k], high : high + rest]
            for j in range(rest):
                row[j] = seen[j]


@helper
def _finished(motions: Motions, i: int, t: int, tables: Tables, modes: Modes, results: Sums, work: Scratch,
              steady: Reals) -> None:  # fmt: skip
    """Write the results of an orbit whose nodes sufficed; they are in the buffer."""
    buffer, found, m, size = work.buffer, work.found, work.block[_MAP, t], work.block[_SIZE, t]
    n, symmetry, constants = tables.counts[size], tables.maps[m, 6], results.means.shape[0]
    results.chosen[0, i], results.chosen[1, i] = size, m
    results.good[i], results.action[i], results.action_error[i] = True, found[0, 0], found[1, 0]
    if modes.kernels:
        if (modes.shifts or modes.chords) and not modes.approximate:
            fraction, low, high = motions.fraction[i], work.residues[t, 0], work.residues[t, 1]
            steps = (low, high) if modes.shifts else (max(low, high), max(low, high))
            shaken = motions.uncertainty[i] if modes.shifts else steady
            results.action_error[i] += shifted_action(work, steps, shaken, n, tables.split[m, size, fraction])
            _shifts(work, steps, shaken, (m, size, fraction), tables, not modes.shifts)
        for k in range(constants):
            results.means[k, i], results.mean_errors[k, i] = found[0, 1 + k], found[1, 1 + k]
    if modes.oscillations:
        results.phase[i], results.phase_error[i] = phase(work, motions, i, t, (m, size), tables, modes)
        for k in range(constants):
            results.speeds[k, i] = dot(buffer[3 + k], work.fractions, n)
        cosines = tables.cosines[tables.rows[size] :]
        running_weights(work.fractions, work.rows, symmetry * results.phase[i], n, cosines)
        for k in range(constants):
            results.oscillations[k, i] = 2.0 / (n * symmetry) * dot(buffer[3 + k], work.fractions, n)
            results.oscillation_errors[k, i] = 4.0 * found[2, 1 + k]


@kernel
def integrals(below: Side, above: Side, motions: Motions, tables: Tables, modes: Modes, results: Sums,
              work: Scratch, steady: Reals) -> None:  # fmt: skip
    """Integrate one coordinate of many orbits.

    Args:
        below, above: programs of the lower and of the upper half.
        motions: of n orbits.
        tables: of nodes.
        modes: what is wanted.
        results: arrays filled here.
        work: scratch.
        steady: as many zeros as there are constants.
    """
    block, n, orbit = work.block, motions.width.shape[0], 0
    while orbit < n:
        count = 0
        while orbit < n and count < BLOCK:
            if motions.width[orbit] > 0.0 and motions.least[orbit] >= 0:
                block[_ORBIT, count], block[_LEFT, count] = orbit, count
                block[_SIZE, count], block[_MAP, count] = motions.least[orbit], motions.first[orbit]
                count += 1
            orbit += 1
        # errors do not depend on the number of nodes: sampled once for all rules that an orbit tries
        if modes.approximate:
            for t in range(count):
                _cleared(work, t, tables.samples[motions.first[block[_ORBIT, t]]])
        else:
            _samples(below, above, motions, count, tables, work, modes)
        left = count
        for attempt in range(_TRIES):
            begin, kept = 0, 0
            while begin < left:
                end = packed(below, above, motions, (begin, left), tables, work)
                for at in range(begin, end):
                    t = block[_LEFT, at]
                    i, m, size = block[_ORBIT, t], block[_MAP, t], block[_SIZE, t]
                    gathered(below, above, work, t, tables.counts[size], tables.split[m, size, motions.fraction[i]])
                    if modes.approximate:
                        if means(work, tables.counts[size]):
                            _finished(motions, i, t, tables, modes, results, work, steady)
                        continue
                    more, crowded = rule(work, t, tables, size, modes, motions.first[i])
                    if more < 0.0:
                        _finished(motions, i, t, tables, modes, results, work, steady)
                        continue
                    size, m = next_rule(tables.counts, (size, m), (more, crowded), motions.first[i], attempt)
                    if size >= 0:
                        block[_SIZE, t], block[_MAP, t] = size, m
                        block[_LEFT, kept] = t
                        kept += 1
                begin = end
            left = kept  # each orbit is done as soon as its own nodes suffice: results do not depend on the block
            if left == 0:
                break
