"""Rough integrals of many librations next to known ones: turning points that are followed, and few nodes.

On the way to a torus its neighbours are known. Their turning points are next to its own, so that Newton's method finds
these without a search, at last with p² to 32 digits: a narrow motion has a width. The midpoint rule with few nodes
(``cycle_integrals``) then gives J and ∂J/∂c, and its nodes the running integrals at every phase at once: with
kⱼ r = Σ aₖ cos kχ they are a₀ χ + Σ (aₖ/k) sin kχ. There are neither proofs nor bounds. Series of rotations, which
have sines, too, come from ``turn_integrals``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.compiling import helper, kernel
from hjsolve.arithmetic.machine.elementary import sincos
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.cycle_integrals import gathered, packed
from hjsolve.ensembles.engine.kernels.midpoint_rule import dot, means
from hjsolve.ensembles.engine.kernels.neighbours import solve
from hjsolve.ensembles.engine.kernels.start_phase import anomaly, stretch
from hjsolve.ensembles.engine.kernels.turn_integrals import Turns, phase_of_turn
from hjsolve.ensembles.engine.kernels.types import BLOCK, Motions, Scratch, Side, Tables

_STEPS_OF_A_BLOCK = 12  # of Newton's method for turning points; steps that have not settled then are told
_CLOSEST, _FARTHEST = 1.0 / 16.0, 3.0  # a place moves out to four times its distance from the end of the domain
_SETTLED = 1e-6  # step over the width, after which the next one is below 1e-12
_ORBIT, _SIZE, _MAP, _LOW, _HIGH, _LEFT = range(6)  # rows of ``Scratch.block``
_ROUNDS = 24  # evaluations of θ
_LONGEST = 1.0  # radians that a phase moves in one step
_NEARLY = 1e-6  # residual after which the next step is the last: it leaves 1e-12, less than the integrals do
_LEAST_STEP = 2.0**-20  # fraction of a step below which an orbit is given up


class RunningSeries(NamedTuple):
    """Running integrals of all coordinates of n orbits.

    Attributes:
        means: ∂J/∂c, shape (separated, constants, n).
        coefficients: aₖ/k, k = 1, 2, …, shape (separated, n, constants, nodes); of rotations Aₖ/k in the first half and
            −Bₖ/k in the second, for Σ Aₖ cos kχ + Bₖ sin kχ.
        map, size: of the nodes, places in the tables, shape (separated, n).
        turns: of a rotation the centre of its nodes in its sense, the ratio of ``turned_circle``, χ where angles begin,
            and there the sums over the coefficients, shape (separated, 3 + constants, n); NaN for librations.
    """

    means: Reals
    coefficients: Reals
    map: Integers
    size: Integers
    turns: Reals


class PhaseScratch(NamedTuple):
    """What one orbit is worked out in.

    Attributes:
        waves: sin kχ and k cos kχ, then cos kχ and −k sin kχ, shape (4, nodes).
        running: Σ (aₖ/k) sin kχ of all constants, shape (constants,).
        rates: ∂(running integrals)/∂φ, shape (separated, separated): constant, coordinate.
        matrix: scratch of the same shape.
        rows: χ, θ − χ, the residual, the step, φ where it begins, the step as it is kept, φ; shape (7, separated).
    """

    waves: Reals
    running: Reals
    rates: Reals
    matrix: Reals
    rows: Reals


@kernel
def moved_ends(
    slopes: MachineProgram, squares: MachineProgram, known: Reals, ends: Reals, width: Reals, pairs: int,
    barrier: bool, last: Reals,
) -> None:  # fmt: skip
    """Move turning points of neighbours to where F = 0.

    Next to an end x = 0 of the domain F is mostly A − B/x², and Newton's method in 1/x² finds its zero at once.

    Args:
        slopes, squares: programs of the view, of the same number of lanes.
        known: constants, then their low parts, shape (2 constants, n).
        ends: turning points in two doubles, shape (2, n); changed.
        width: of the motions, about, shape (n,).
        pairs: how many steps are taken with F to 32 digits.
        barrier: whether x > 0 is counted from an end of the domain.
        last: filled with the last step, over the width, shape (n,).
    """
    n, lanes, m = ends.shape[1], slopes.registers.shape[1], known.shape[0] // 2
    x, low = slopes.registers[0], squares.registers[1]
    high, F = squares.registers[0], squares.registers[squares.outputs[0]]
    f, slope = slopes.registers[slopes.outputs[0]], slopes.registers[slopes.outputs[1]]
    for first in range(0, n, lanes):
        count = min(lanes, n - first)
        used = (count + 7) // 8 * 8
        for k in range(2 * m):
            row = squares.registers[2 + k]
            for j in range(count):
                row[j] = known[k, first + j]
        for k in range(m):
            row = slopes.registers[1 + k]
            for j in range(count):
                row[j] = known[k, first + j]
        for j in range(count):
            x[j], low[j] = ends[0, first + j], ends[1, first + j]
        for _ in range(_STEPS_OF_A_BLOCK if pairs < 2 else 0):
            run(slopes, used)
            most = 0.0
            for j in range(count):
                step = f[j] / slope[j]
                if barrier:  # x ↦ x/√(1 + 2F/(x F′))
                    part = 1.0 + 2.0 * step / x[j]
                    step = x[j] * (1.0 - 1.0 / np.sqrt(part) if part > _CLOSEST else -_FARTHEST)
                x[j], low[j] = x[j] - step, 0.0
                most = max(most, abs(step) / width[first + j])
            if not most > _SETTLED:
                break
        for _ in range(pairs):
            for j in range(count):
                high[j] = x[j]
            run(slopes, used)
            run(squares, used)
            for j in range(count):
                step = F[j] / slope[j]
                # two_sum(x, −step), and the low part
                total = x[j] - step
                part = total - x[j]
                rest = low[j] + ((x[j] - (total - part)) + (-step - part))
                x[j] = total + rest
                low[j] = rest - (x[j] - total)
                last[first + j] = abs(step) / width[first + j]
        for j in range(count):
            ends[0, first + j], ends[1, first + j] = x[j], low[j]


@helper
def _series(row: Reals, cosines: Reals, n: int, factor: float, coefficients: Reals) -> None:
    """Write aₖ/k of one integrand from its values at the nodes."""
    for k in range(1, n):
        coefficients[k - 1] = factor / k * dot(row, cosines[(k - 1) * n :], n)


@kernel
def rough_integrals(
    below: Side, above: Side, motions: Motions, tables: Tables, series: bool, action: Reals, slopes: Reals,
    coefficients: Reals, good: Mask, work: Scratch,
) -> None:  # fmt: skip
    """Integrate one coordinate of many orbits with few nodes.

    Args:
        below, above: programs of the lower and of the upper half.
        motions: of n orbits; those whose ``least`` is negative are left out.
        tables: of nodes.
        series: whether the coefficients of the running integrals are wanted.
        action, slopes: filled with J, shape (n,), and ∂J/∂c, shape (constants, n).
        coefficients: filled, shape (n, constants, nodes).
        good: filled: where F > 0 at all nodes.
        work: scratch.
    """
    block, n, orbit = work.block, motions.width.shape[0], 0
    while orbit < n:
        count = 0
        while orbit < n and count < BLOCK:
            if motions.least[orbit] >= 0:
                block[_ORBIT, count], block[_LEFT, count] = orbit, count
                block[_SIZE, count], block[_MAP, count] = motions.least[orbit], motions.first[orbit]
                count += 1
            orbit += 1
        begin = 0
        while begin < count:
            end = packed(below, above, motions, (begin, count), tables, work)
            for t in range(begin, end):
                i, m, size = block[_ORBIT, t], block[_MAP, t], block[_SIZE, t]
                nodes = tables.counts[size]
                gathered(below, above, work, t, nodes, tables.split[m, size, motions.fraction[i]])
                good[i] = means(work, nodes)
                action[i] = work.found[0, 0]
                for k in range(slopes.shape[0]):
                    slopes[k, i] = work.found[0, 1 + k]
                if series:
                    symmetry, cosines = tables.maps[m, 6], tables.cosines[tables.rows[size] :]
                    for k in range(slopes.shape[0]):
                        _series(work.buffer[3 + k], cosines, nodes, 2.0 / (nodes * symmetry), coefficients[i, k])
            begin = end


@helper
def _phase(φ: float, orbit: RunningSeries, k: int, i: int, tables: Tables) -> tuple[float, float]:
    """χ of a libration, and dχ/dφ."""
    map_, turns = tables.maps[orbit.map[k, i]], 2.0 * np.pi * np.rint(φ / (2.0 * np.pi))
    place = φ - turns
    s, c = sincos(0.5 * abs(place))
    χ = anomaly(s * s, c * c, map_, 1.0)
    turn = 1.0 / np.sqrt(stretch(χ, s * s, c * c, map_, 1.0))
    return turns + (χ if place >= 0.0 else -χ), turn


@helper
def _waves(χ: float, first: float, count: int, waves: Reals) -> None:
    """Write sin kχ, k cos kχ, cos kχ and −k sin kχ for the multiples k of ``first``."""
    s1, c1 = sincos(first * χ)
    s, c = s1, c1
    for p in range(count):
        k = (p + 1) * first
        waves[0, p], waves[1, p], waves[2, p], waves[3, p] = s, k * c, c, -k * s
        s, c = s * c1 + c * s1, c * c1 - s * s1


@helper
def _run_along(φ: Reals, orbit: RunningSeries, i: int, tables: Tables, turns: Turns, work: PhaseScratch) -> None:
    """Leave χ, θ − χ, the running integrals and their rates at the phases of one orbit."""
    size, constants, half = orbit.means.shape[0], orbit.means.shape[1], orbit.coefficients.shape[3] // 2
    waves = work.waves
    for j in range(constants):
        work.running[j] = 0.0
    for k in range(size):
        begin = orbit.turns[k, 2, i]
        round_ = begin == begin
        if round_:
            map_ = turns.maps[orbit.map[k, i]]
            χ, speed, _ = phase_of_turn(φ[k] - orbit.turns[k, 0, i], orbit.turns[k, 1, i], map_)
            turn, terms = 1.0 / speed, turns.counts[orbit.size[k, i]] // 2 - 1
            work.rows[0, k] = χ - begin
            _waves(χ, 1.0, terms, waves)
        else:
            χ, turn = _phase(φ[k], orbit, k, i, tables)
            terms = tables.counts[orbit.size[k, i]] - 1
            work.rows[0, k] = χ
            _waves(χ, tables.maps[orbit.map[k, i], 6], terms, waves)
        for j in range(constants):
            row = orbit.coefficients[k, i, j]
            work.running[j] += dot(row, waves[0], terms)
            rate = orbit.means[k, j, i] + dot(row, waves[1], terms)
            if round_:
                work.running[j] += dot(row[half:], waves[2], terms) - orbit.turns[k, 3 + j, i]
                rate += dot(row[half:], waves[3], terms)
            if j < size:
                work.rates[j, k] = rate * turn
    for j in range(size):
        work.rows[1, j] = work.running[j]
        for k in range(size):
            work.matrix[j, k] = orbit.means[k, j, i]
    solve(work.matrix, work.rows[1])


@kernel
def begun_series(orbits: RunningSeries, which: Integers, opposite: Reals, k: int, turns: Turns, waves: Reals) -> None:
    """Write χ where angles of rotations begin, and the sums over the coefficients there.

    Args:
        orbits: running integrals; ``turns`` has the centres and ratios.
        which: of them go round.
        opposite: places where their angles begin, less the centre, in the sense of the rotation; as long.
        k: the coordinate.
        turns: tables of nodes.
        waves: scratch, shape (4, nodes).
    """
    half = orbits.coefficients.shape[3] // 2
    for place in range(which.shape[0]):
        i = which[place]
        map_, terms = turns.maps[orbits.map[k, i]], turns.counts[orbits.size[k, i]] // 2 - 1
        χ = 0.0  # opposite to the one slow place
        if map_[5] == 2.0:
            χ, _, _ = phase_of_turn(opposite[place], orbits.turns[k, 1, i], map_)
        orbits.turns[k, 2, i] = χ
        _waves(χ, 1.0, terms, waves)
        for j in range(orbits.means.shape[1]):
            row = orbits.coefficients[k, i, j]
            orbits.turns[k, 3 + j, i] = dot(row, waves[0], terms) + dot(row[half:], waves[2], terms)


@kernel
def angles_of_series(φ: Reals, orbits: RunningSeries, tables: Tables, turns: Turns, anomalies: Reals, advance: Reals,
                     running: Reals, work: PhaseScratch) -> None:  # fmt: skip
    """Work out angles at phases.

    Args:
        φ: phases, shape (separated, n).
        orbits: running integrals.
        tables, turns: of nodes, of librations and of rotations.
        anomalies, advance: filled with χ and θ − χ, of the same shape.
        running: filled with the running integrals less their mean growth, shape (constants, n).
        work: scratch.
    """
    own = work.rows[4]
    for i in range(φ.shape[1]):
        for k in range(φ.shape[0]):
            own[k] = φ[k, i]
        _run_along(own, orbits, i, tables, turns, work)
        for k in range(φ.shape[0]):
            anomalies[k, i], advance[k, i] = work.rows[0, k], work.rows[1, k]
        for j in range(running.shape[0]):
            running[j, i] = work.running[j]


@kernel
def phases_of_series(θ: Reals, φ: Reals, orbits: RunningSeries, tables: Tables, turns: Turns, curve: Reals, good: Mask,
                     work: PhaseScratch) -> None:  # fmt: skip
    """Find the phases at which angles are as given, by damped Newton's method.

    Args:
        θ: angles, shape (separated, n).
        φ: phases to begin with; those that are found replace them.
        orbits: running integrals.
        tables, turns: of nodes, of librations and of rotations.
        curve: filled with the largest κ of rₖ₊₁ = κ rₖ² of the last full steps, at least 1, shape (n,).
        good: filled: which were found.
        work: scratch.
    """
    size, residual, step, base = φ.shape[0], work.rows[2], work.rows[3], work.rows[4]
    kept, trial = work.rows[5], work.rows[6]
    for i in range(φ.shape[1]):
        merit, fraction, good[i], curve[i] = np.inf, 1.0, False, np.inf
        for k in range(size):
            trial[k] = φ[k, i]
        for _ in range(_ROUNDS):
            _run_along(trial, orbits, i, tables, turns, work)
            most = 0.0
            for k in range(size):
                off = θ[k, i] - work.rows[0, k] - work.rows[1, k]
                off -= 2.0 * np.pi * np.rint(off / (2.0 * np.pi))
                residual[k] = off
                most = max(most, abs(off)) if abs(off) >= 0.0 else np.nan
            if not most < (1.0 - 0.25 * fraction) * merit:
                fraction *= 0.25
                if fraction < _LEAST_STEP or merit == np.inf:
                    break
            else:
                if fraction == 1.0 and merit < 1.0:
                    curve[i] = max(most / (merit * merit), 1.0)
                merit = most
                # ∂θ/∂φ = M⁻¹ R, so that the step is R⁻¹ M r
                for j in range(size):
                    base[j] = trial[j]
                    step[j] = 0.0
                    for k in range(size):
                        step[j] += orbits.means[k, j, i] * residual[k]
                solve(work.rates, step)
                longest = 0.0
                for k in range(size):
                    kept[k] = step[k]
                    longest = max(longest, abs(step[k])) if abs(step[k]) >= 0.0 else np.inf
                if not longest < np.inf:
                    break
                fraction = min(1.0, _LONGEST / longest) if longest > 0.0 else 1.0
                if merit < _NEARLY:
                    good[i] = True
                    for k in range(size):
                        φ[k, i] = base[k] + kept[k]
                    break
            for k in range(size):
                trial[k] = base[k] + fraction * kept[k]
