"""The integrals of motions that go round, p² > 0 all along a turn: the midpoint rule over a whole period.

J = (1/2π) ∮ √F dq and ∂J/∂cⱼ = (1/2π) ∮ kⱼ dq/√F are means of F r and kⱼ r over equally spaced χ, r = |dq/dχ|/√F, with
the anomalies of ``maps_of_turns``: q = centre ± θ(χ), or ± the Möbius transform of θ where p² has two slow places
(``turned_circle``). Both cosines and sines occur: the slow place is not an axis of symmetry of p².
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS, UNIT
from hjsolve.arithmetic.machine.compiling import helper, inlined, kernel
from hjsolve.arithmetic.machine.elementary import sincos
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.ensembles.engine.kernels.midpoint_rule import ROUNDING_FACTOR, dot, enough, sizes
from hjsolve.ensembles.engine.kernels.start_phase import elliptic
from hjsolve.ensembles.engine.kernels.types import Modes, Sums

_MOST_MAPS = 8  # pairs of a number of nodes and a map, tried for one orbit
_HOPELESS = 2.0  # times the largest number of nodes: beyond, that one is not tried
_WISH, _WISH_OF_SERIES, _ROUGH_WISH = 1e-10, 1e-15, 1e-6  # last coefficients over the mean, that more nodes shall give
_ROUGH = 1e-9  # aliasing over the mean of rough integrals, which lead a search to residuals of 1e-8


class Turns(NamedTuple):
    """Nodes of all maps and sizes side by side, padded; see ``maps_of_turns``.

    Attributes:
        maps: 0, 0, K, k′², the least dn, and how many slow places, of every map, shape (maps, 6).
        counts: numbers of nodes over a turn, shape (sizes,).
        angle, speed: θ and dθ/dχ at the nodes, shape (maps, sizes, widest).
        circle: sines and cosines of 2πi/(2n), i < 2n, and ones, shape (sizes, 3, 2 widest).
        last, middle: cosines and sines of the last and middle terms of the series, shape (sizes, 6, widest).
    """

    maps: Reals
    counts: Integers
    angle: Reals
    speed: Reals
    circle: Reals
    last: Reals
    middle: Reals


class Rounds(NamedTuple):
    """One coordinate of n orbits that go round.

    Attributes:
        centre: the slow place, or half way between two, shape (n,).
        left: q₀ less the centre.
        opposite: where angles begin, less the centre; where there is one slow place its opposite, χ = 0.
        ratio: m of the Möbius transformation where there are two slow places.
        direction: +1 or −1.
        known: what the programs know, shape (n, known).
        uncertainty: bounds on the errors of the constants, shape (n, constants).
        map, least: the map, and the size to begin with; a negative size leaves the orbit out.
    """

    centre: Reals
    left: Reals
    opposite: Reals
    ratio: Reals
    direction: Reals
    known: Reals
    uncertainty: Reals
    map: Integers
    least: Integers


class TurnScratch(NamedTuple):
    """What one orbit after the other is worked out in.

    Attributes:
        noise: of the integrands, shape (1 + kernels,).
        rows: of the nodes, shape (2, widest).
    """

    noise: Reals
    rows: Reals


@inlined
def _moved(θ: float, m: float) -> tuple[float, float]:
    """tan(q/2) = m tan(θ/2): q, and dq/dθ."""
    s, c = sincos(0.5 * θ)
    return 2.0 * math.atan2(m * s, c), m / (c * c + (m * s) * (m * s))


@helper
def _nodes(fill: MachineProgram, errors: MachineProgram, motions: Rounds, i: int, place: tuple[int, int, int],
           tables: Turns, finely: bool, rough: bool) -> None:  # fmt: skip
    """Work out F at the nodes of one orbit, and its errors but for rough integrals."""
    (m, size, n), known = place, motions.known.shape[1]
    centre, direction, ratio = motions.centre[i], motions.direction[i], motions.ratio[i]
    two, angles, speeds = tables.maps[m, 5] == 2.0, tables.angle[m, size], tables.speed[m, size]
    for j in range(n):
        # d is kept besides q = centre + d: next to a barrier p² is known to the digits of d, not to those of q
        away, speed = angles[j], speeds[j]
        if two:
            away, factor = _moved(away, ratio)
            speed *= factor
        d = direction * away
        q = centre + d
        fill.registers[0, j], fill.registers[1, j], fill.registers[2, j] = d, q, speed
        fill.registers[3, j] = centre
        errors.registers[0, j] = d if finely else q
        errors.registers[1, j] = 2.0 * UNIT * max(abs(q), abs(centre), abs(d))
        errors.registers[2, j] = 1.0
    for k in range(known):
        c, first, second = motions.known[i, k], fill.registers[4 + k], errors.registers[3 + k]
        for j in range(n):
            first[j], second[j] = c, c
    for k in range(motions.uncertainty.shape[1]):
        e, row = motions.uncertainty[i, k], errors.registers[3 + known + k]
        for j in range(n):
            row[j] = e
    slots = (n + 7) // 8 * 8
    run(fill, slots)
    if not rough:
        run(errors, slots)


@helper
def _positive(F: Reals, n: int) -> bool:
    """Return whether F > 0 at all nodes."""
    positive = True
    for j in range(n):
        positive = positive and F[j] > 0.0
    return positive


@helper
def _noise(fill: MachineProgram, errors: MachineProgram, n: int, noise: Reals) -> None:
    """Write sums of the errors of all integrands over the nodes."""
    kernels = noise.shape[0] - 1
    r, F, δF = fill.registers[fill.outputs[1]], fill.registers[fill.outputs[2]], errors.registers[errors.outputs[0]]
    total = 0.0
    # δ(F r) = ½ r δF, as F r = √F dq/dχ; all signs may agree, so the errors add up
    for j in range(n):
        total += 0.5 * r[j] * δF[j]
    noise[0] = total
    for k in range(kernels):
        kr, e = fill.registers[fill.outputs[3 + k]], errors.registers[errors.outputs[1 + k]]
        total = 0.0
        for j in range(n):  # δ(k r) = r δk − ½ k r δF/F
            total += 0.5 * abs(kr[j]) * δF[j] / F[j] + r[j] * e[j]
        noise[1 + k] = total


@inlined
def _largest(rows: Reals, x: Reals, n: int) -> float:
    """Return the size of the largest of six coefficients."""
    found = 0.0
    for k in range(6):
        found = max(found, abs(dot(rows[k], x, n)))
    return 2.0 / n * found


@helper
def _ruled(fill: MachineProgram, noise: Reals, results: Sums, i: int, place: tuple[int, int], tables: Turns,
           modes: Modes) -> float:  # fmt: skip
    """Apply the rule; returns how many nodes of half a turn are needed, −1 where these suffice."""
    size, n = place
    half, more = 0.5 * n, -1.0
    wish = _ROUGH_WISH if modes.approximate else _WISH_OF_SERIES if modes.oscillations else _WISH
    for k in range(noise.shape[0]):
        row = fill.registers[fill.outputs[0 if k == 0 else 2 + k]]
        mean, scale = dot(row, tables.circle[size, 2], n) / n, sizes(row, n) / n
        if not math.isfinite(mean):
            return 2.0 * half
        tail, middle = _largest(tables.last[size], row, n), _largest(tables.middle[size], row, n)
        rounding = ROUNDING_FACTOR * noise[k] / n + 8.0 * EPS * scale
        alias, fits = enough(tail, middle, rounding, scale, modes.oscillations)
        if modes.approximate:  # a running integral misses what lies beyond its last coefficients
            fits = (tail if modes.oscillations else alias) <= _ROUGH * scale
        if not fits and scale != 0.0:
            # |cₖ| ~ ρᵏ from the mean to the last coefficient; the series of a whole turn has n/2 terms
            excess = min(max(tail, 1e-300) / scale, 0.5)
            more = max(more, min(max(2.0 + (half - 2.0) * math.log(wish) / math.log(excess), half + 1.0), 3.0 * half))
        if k == 0:
            results.action[i], results.action_error[i] = mean, rounding + alias
        else:
            results.means[k - 1, i], results.mean_errors[k - 1, i] = mean, rounding + alias
            results.oscillation_errors[k - 1, i] = 4.0 * (tail + 0.5 * rounding)
    return more


@helper
def phase_of_turn(here: float, ratio: float, map_: Reals) -> tuple[float, float, float]:
    """χ in (−π, π] of a place, dq/dχ there, and a bound on the error of χ; the slow place is χ = π.

    Args:
        here: how far it is from the centre, in the sense of the rotation.
        ratio: m of the Möbius transformation where there are two slow places.
        map_: a row of ``Turns.maps``.
    """
    turn, speed = 2.0 * math.pi, 2.0 * map_[2] / math.pi
    # to half a turn about the slow place, where p² is least and χ = π
    here -= turn * np.floor(here / turn + 0.5)
    bound, whole = 16.0 * EPS * math.pi**2 / (2.0 * map_[2] * map_[4]), 0.0
    if map_[5] == 2.0:
        s, c = sincos(0.5 * here)
        θ = 2.0 * math.atan2(s, ratio * c)
        speed *= (s * s + (ratio * c) * (ratio * c)) / ratio
        bound *= 2.0 * max(ratio, 1.0 / ratio)
        here, whole = (2.0 * θ - math.pi, turn) if θ > 0.0 else (2.0 * θ + math.pi, 0.0)
    # half the angle from the place opposite to the slow one, where χ = 0: sine and cosine change places
    s, c = sincos(0.5 * here)
    sine, cosine = (-c if here > 0.0 else c), abs(s)
    χ = 2.0 * math.atan2(sine, cosine) if map_[3] == 1.0 else elliptic(sine, cosine, map_)
    # dn² = cn² + k′² sn² (DLMF 22.6.1)
    speed *= np.sqrt(cosine * cosine + map_[3] * sine * sine)
    if map_[5] == 2.0:
        χ = 0.5 * (χ + whole + (turn if here > 0.0 else 0.0))
        χ = χ - turn if χ > math.pi else χ
    return χ, speed, bound


@helper
def _interpolation(weights: Reals, χ: float, n: int) -> None:
    """Weights that give the value of the series at χ: (1 + 2 Σ cos k(χ − χⱼ))/n, k < n/2 (Dirichlet's kernel)."""
    for j in range(n):
        away = 0.5 * (χ - (2 * j + 1) * math.pi / n)
        s, _ = sincos(away)
        t, _ = sincos((n - 1) * away)
        weights[j] = (t / s if abs(s) > 1e-30 else n - 1.0) / n


@helper
def _running(weights: Reals, χ: float, sign: float, n: int, circle: Reals) -> None:
    """Add ± Σ sin k(χ − χⱼ)/k, k < n/2, to the weights of the running integral."""
    half, s1, c1 = n // 2, 0.0, 0.0
    s1, c1 = sincos(χ)
    s, c = s1, c1
    sines, cosines = circle[0], circle[1]
    for k in range(1, half):
        odd, even = sign * s / k, sign * c / k
        place, step = k, 2 * k
        for j in range(half):  # χ of the other half is 2π − χ
            weights[j] += odd * cosines[place] - even * sines[place]
            weights[n - 1 - j] += odd * cosines[place] + even * sines[place]
            place += step
            place = place - 2 * n if place >= 2 * n else place
        if k % 16 == 0:  # else roundings of the recurrence add up
            s, c = sincos((k + 1) * χ)
        else:
            s, c = s * c1 + c * s1, c * c1 - s * s1


@helper
def _timed(fill: MachineProgram, motions: Rounds, i: int, place: tuple[int, int, int], tables: Turns, results: Sums,
           work: TurnScratch) -> None:  # fmt: skip
    """Write the phase of the start, and the running integrals up to it less their mean growth."""
    (m, size, n), weights, kernels = place, work.rows[0], work.noise.shape[0] - 1
    direction, ratio, map_ = motions.direction[i], motions.ratio[i], tables.maps[m]
    χ, _, bound = phase_of_turn(direction * motions.left[i], ratio, map_)
    begin = 0.0
    _interpolation(weights, χ, n)
    for k in range(kernels):
        results.speeds[k, i] = dot(fill.registers[fill.outputs[3 + k]], weights, n)
    if map_[5] == 2.0:  # angles begin opposite to the slower place, where χ is not zero
        begin, _, more = phase_of_turn(direction * motions.opposite[i], ratio, map_)
        bound += more
    weights[:n] = 0.0
    _running(weights, χ, 1.0, n, tables.circle[size])
    _running(weights, begin, -1.0, n, tables.circle[size])
    for k in range(kernels):
        results.oscillations[k, i] = 2.0 / n * dot(fill.registers[fill.outputs[3 + k]], weights, n)
    results.phase[i], results.phase_error[i] = χ - begin, bound


@helper
def _resolved(fill: MachineProgram, errors: MachineProgram, motions: Rounds, i: int, tables: Turns, modes: Modes,
              results: Sums, work: TurnScratch, finely: bool) -> bool:  # fmt: skip
    """Write the integrals of one orbit by the first size that is enough, and that size; return whether one is."""
    sizes, m, size = tables.counts.shape[0], motions.map[i], motions.least[i]
    widest = 0.5 * tables.counts[sizes - 1]
    for _ in range(_MOST_MAPS):
        if size < 0 or size >= sizes:
            break
        n = tables.counts[size]
        _nodes(fill, errors, motions, i, (m, size, n), tables, finely, modes.approximate)
        more = float(n)
        if _positive(fill.registers[fill.outputs[2]], n):
            if modes.approximate:
                work.noise[:] = 0.0
            else:
                _noise(fill, errors, n, work.noise)
            more = _ruled(fill, work.noise, results, i, (size, n), tables, modes)
        if more < 0.0:
            results.good[i], results.chosen[0, i], results.chosen[1, i] = True, size, m
            return True
        # the number is an estimate: the widest rule is tried before the orbit is left to others
        if more > widest and more < _HOPELESS * widest:
            more = widest
        size += 1
        while size < sizes and 0.5 * tables.counts[size] < more:
            size += 1
    return False


@kernel
def rotations(fill: MachineProgram, errors: MachineProgram, motions: Rounds, tables: Turns, modes: Modes,
              results: Sums, work: TurnScratch, finely: bool) -> None:  # fmt: skip
    """Integrate one coordinate of many orbits that go round.

    Args:
        fill, errors: programs of the nodes, and of bounds on errors there, wide enough for all nodes of an orbit.
        motions: of n orbits.
        tables: of nodes.
        modes: what is wanted.
        results: arrays filled here; ``good`` only where the nodes sufficed.
        work: scratch.
        finely: whether F comes from 32 digits at distances from the centre.
    """
    for i in range(motions.centre.shape[0]):
        if _resolved(fill, errors, motions, i, tables, modes, results, work, finely) and modes.oscillations:
            size = results.chosen[0, i]
            _timed(fill, motions, i, (motions.map[i], size, tables.counts[size]), tables, results, work)


@helper
def _waves(row: Reals, n: int, circle: Reals, coefficients: Reals) -> None:
    """Write Aₖ/k and −Bₖ/k, k < n/2, of one integrand Σ Aₖ cos kχ + Bₖ sin kχ, from its values at the nodes."""
    half, terms = n // 2, coefficients.shape[0] // 2
    sines, cosines = circle[0], circle[1]
    for k in range(1, half):
        even, odd, place, step = 0.0, 0.0, k, 2 * k
        for j in range(half):  # χ of the other half is 2π − χ
            even += (row[j] + row[n - 1 - j]) * cosines[place]
            odd += (row[j] - row[n - 1 - j]) * sines[place]
            place += step
            place = place - 2 * n if place >= 2 * n else place
        factor = 2.0 / (n * k)
        coefficients[k - 1], coefficients[terms + k - 1] = factor * even, -factor * odd


@kernel
def series_of_turns(fill: MachineProgram, errors: MachineProgram, motions: Rounds, tables: Turns, modes: Modes,
                    results: Sums, work: TurnScratch, coefficients: Reals) -> None:  # fmt: skip
    """Integrate one coordinate of many orbits that go round, with the series of its running integrals.

    Args:
        fill, errors: programs of the nodes, and of bounds on errors there, wide enough for all nodes of an orbit.
        motions: of n orbits.
        tables: of nodes.
        modes: what is wanted.
        results: arrays filled here; ``good`` only where the nodes sufficed, and the series has a place.
        work: scratch.
        coefficients: filled, Aₖ/k in the first half and −Bₖ/k in the second, shape (n, constants, 2 terms).
    """
    for i in range(motions.centre.shape[0]):
        if _resolved(fill, errors, motions, i, tables, modes, results, work, False):
            size = results.chosen[0, i]
            n = tables.counts[size]
            results.good[i] = n <= coefficients.shape[2]
            for k in range(coefficients.shape[1] if results.good[i] else 0):
                _waves(fill.registers[fill.outputs[3 + k]], n, tables.circle[size], coefficients[i, k])
