"""Turning points of many orbits: a search outward from the start for F = p² < 0, then Newton's method in the bracket.

The search works in lanes of the machine. A lane whose orbit has found its bracket takes the next orbit, so that none
waits for the slowest. Which sign change is found cannot be proved in doubles: a pair of zeros between two trials goes
unseen unless F falls at one and rises at the next, when the valley between them is looked into by bisection of F′. What
stays unseen leaves a place with p² < 0 between the turning points, and the quadrature refuses those.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.machine.compiling import helper, inlined, kernel
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Reals

_NEWTON_STEPS_OF_A_BLOCK = 5  # then orbits that still move get lanes of their own
_OUTWARD_STEPS = 110  # each up to 1.6 times the last: a factor of 10²² in all
_LONGEST_STEP = 0.2  # radians, of a coordinate that goes round: 31 places a turn
_VALLEY_HALVINGS = 40  # of the bracket of F′ = 0: to 2⁻⁴⁰ of a step, where F is flat to rounding
_NEWTON_STEPS_OF_A_SLOT = 80  # each 16th a bisection

_FREE, _START, _WALK, _VALLEY, _NEWTON, _LAST = range(6)  # what a lane is doing


class SearchSide(NamedTuple):
    """Where turning points are searched for in one view, on one side.

    Attributes:
        start: offsets of the starts, shape (n,).
        momentum: P₀.
        known: constants, shape (constants, n).
        floor: offset of the end of the domain on this side.
        side: +1 or −1, in terms of the offset.
        reach: longest distance of the search.
    """

    start: Reals
    momentum: Reals
    known: Reals
    floor: float
    side: float
    reach: float


class Slots(NamedTuple):
    """What the lanes of a search are doing; scratch.

    Attributes:
        state: int64, shape (5, lanes): the orbit, what is done, how many steps, whether F falls outward, halvings.
        reals: shape (4, lanes): step, both ends of a valley, last step of Newton's method.
        orbits: shape (3, n): the last place with F ≥ 0, the first with F < 0, and how far Newton's method moved.
    """

    state: Integers
    reals: Reals
    orbits: Reals


@inlined
def _first_step(P: float, outward: float, bend: float, size: float) -> float:
    """Distance at which P₀² + outward·d + bend·d² vanishes, and a little more, at most ``size``; less where never."""
    # 1.0625: a little beyond the zero of the parabola, so that F < 0 there and the bracket closes at once
    square = P * P
    root = np.sqrt(outward * outward - 4.0 * bend * square)
    down = (outward + root) / (-2.0 * bend) if outward > 0 else 2.0 * square / (root - outward)
    if math.isfinite(down) and down > 0:
        return min(1.0625 * down, size)
    # F″ does not help: where the tangent vanishes, and a quarter of the scale at most
    crude = -square / outward if outward < 0 else size
    return min(0.25 * size, crude) if crude > 0 else 0.25 * size


@inlined
def _load(bend: MachineProgram, walk: SearchSide, slots: Slots, j: int, i: int, x: float, doing: int) -> None:
    """Give a lane the next orbit; i = n for none."""
    state, registers = slots.state, bend.registers
    state[0, j], state[1, j], state[2, j] = i, doing, 0
    if i == walk.start.shape[0]:
        state[1, j] = _FREE
        return
    registers[0, j] = x
    for k in range(walk.known.shape[0]):
        registers[1 + k, j] = walk.known[k, i]


@inlined
def _onward(walk: SearchSide, inner: float, step: float) -> float:
    """Return the next place outward, not more than three quarters of the distance to the end of the domain."""
    x, side, floor = inner + walk.side * step, walk.side, walk.floor
    return floor + 0.25 * (inner - floor) if side * (x - floor) > -0.25 * side * (floor - inner) else x


@inlined
def _begun(walk: SearchSide, i: int, first: float, second: float) -> float:
    """Return the first step of the search of an orbit, 0 where there is nothing to search."""
    x, P, side, floor = walk.start[i], walk.momentum[i], walk.side, walk.floor
    if not (math.isfinite(first) and (P != 0.0 or first != 0.0) and side * (floor - x) > 0.0):
        return 0.0
    size = min(abs(x) if x != 0.0 else 1.0, side * (floor - x))
    size = min(size, 0.2) if math.isfinite(walk.reach) else size
    return _first_step(P, side * first, 0.5 * second, size)


@inlined
def _walked(walk: SearchSide, slots: Slots, j: int, x: float, f: float, slope: float) -> tuple[bool, float]:
    """One step of the search in a lane: whether it is done, and the next place."""
    state, reals, (inner, outer) = slots.state, slots.reals, (slots.orbits[0], slots.orbits[1])
    i, outward = state[0, j], walk.side * slope
    if state[1, j] == _VALLEY:
        state[4, j] += 1
        if f < 0.0:
            outer[i] = x
            return True, x
        if outward < 0.0:
            reals[1, j] = x
        else:
            reals[2, j] = x
        if state[4, j] < _VALLEY_HALVINGS:
            return False, 0.5 * (reals[1, j] + reals[2, j])
        # no valley: on from the place beyond it, where F ≥ 0 and rises
        state[1, j], state[3, j], inner[i] = _WALK, 0, reals[3, j]
        reals[0, j] = min(1.6 * reals[0, j], _LONGEST_STEP) if math.isfinite(walk.reach) else 1.6 * reals[0, j]
        return False, _onward(walk, inner[i], reals[0, j])
    state[2, j] += 1
    if f < 0.0:
        outer[i] = x
        return True, x
    if f >= 0.0:
        # F fell and rises again, with F ≥ 0 at both places: a valley between may go below zero and hide two zeros
        if state[3, j] == 1 and outward > 0.0:
            state[1, j], state[4, j] = _VALLEY, 0
            reals[1, j], reals[2, j], reals[3, j] = inner[i], x, x
            return False, 0.5 * (inner[i] + x)
        inner[i], state[3, j] = x, 1 if outward < 0.0 else 0
        reals[0, j] = min(1.6 * reals[0, j], _LONGEST_STEP) if math.isfinite(walk.reach) else 1.6 * reals[0, j]
        if abs(x - walk.start[i]) > walk.reach:
            return True, x
    else:  # NaN: out of the formula's domain
        reals[0, j] *= 0.25
    return state[2, j] >= _OUTWARD_STEPS, _onward(walk, inner[i], reals[0, j])


@helper
def _bracketed(bend: MachineProgram, walk: SearchSide, slots: Slots) -> None:
    """Search outward from all starts: the last place with F ≥ 0 and the first with F < 0, NaN for none."""
    n, width = walk.start.shape[0], bend.registers.shape[1]
    state, reals, inner, outer = slots.state, slots.reals, slots.orbits[0], slots.orbits[1]
    x, after = bend.registers[0], min(width, n)
    for j in range(width):
        _load(bend, walk, slots, j, min(j, n), walk.start[min(j, n - 1)], _START)
    active, top = after, (after + 7) // 8 * 8
    while active > 0:
        run(bend, top)
        F, first, second = (bend.registers[bend.outputs[0]], bend.registers[bend.outputs[1]],
                            bend.registers[bend.outputs[2]])  # fmt: skip
        for j in range(top):
            if state[1, j] == _FREE:
                continue
            i = state[0, j]
            if state[1, j] == _START:
                inner[i], outer[i] = walk.start[i], np.nan
                reals[0, j] = _begun(walk, i, first[j], second[j])
                if walk.momentum[i] == 0.0 and walk.side * first[j] < 0.0:  # the start is a turning point
                    outer[i], reals[0, j] = walk.start[i], 0.0
                state[1, j], state[3, j] = _WALK, 1  # F falls from its top, too, where F′ is what rounding leaves
                done, new = not reals[0, j] > 0.0, _onward(walk, inner[i], reals[0, j])
            else:
                done, new = _walked(walk, slots, j, x[j], F[j], first[j])
            if done:
                _load(bend, walk, slots, j, after, walk.start[min(after, n - 1)], _START)
                active, after = (active, after + 1) if after < n else (active - 1, after)
            else:
                x[j] = new


@helper
def _improved(slopes: MachineProgram, walk: SearchSide, places: Reals, orbits: Reals) -> None:
    """Take some steps of Newton's method inside the brackets, without branches, a block of orbits at a time."""
    n, width, x = places.shape[0], slopes.registers.shape[1], slopes.registers[0]
    inner, outer, moved = orbits[0], orbits[1], orbits[2]
    f, slope = slopes.registers[slopes.outputs[0]], slopes.registers[slopes.outputs[1]]
    for first in range(0, n, width):
        count = min(width, n - first)
        for k in range(walk.known.shape[0]):
            row = slopes.registers[1 + k]
            for j in range(count):
                row[j] = walk.known[k, first + j]
        for j in range(count):
            x[j] = places[first + j]
        # each step squares the error, so all orbits take the same few; lanes go on with those that need more
        for _ in range(_NEWTON_STEPS_OF_A_BLOCK):
            run(slopes, (count + 7) // 8 * 8)
            for j in range(count):
                i = first + j
                low = x[j] if f[j] >= 0.0 else inner[i]
                high = outer[i] if f[j] >= 0.0 else x[j]
                new = x[j] - f[j] / slope[j]
                new = new if (new - low) * (new - high) <= 0.0 else 0.5 * (low + high)
                inner[i], outer[i], moved[i] = low, high, abs(new - x[j])
                x[j] = new
        for j in range(count):
            places[first + j] = x[j]


@inlined
def _finishing(walk: SearchSide, places: Reals, slots: Slots, j: int, i: int) -> int:
    """Return whether Newton's method has still to go on for an orbit."""
    slots.reals[3, j] = np.inf
    if i == places.shape[0]:
        return _FREE
    x = places[i]
    # after a step of 1e-9 Newton's next one is below rounding, as errors are squared
    still = min(1e-9 * abs(x), 1e-6 * abs(x - walk.start[i]))
    return _NEWTON if not slots.orbits[2, i] <= still and math.isfinite(slots.orbits[1, i]) else _LAST


@inlined
def _step(walk: SearchSide, slots: Slots, j: int, x: float, f: float, slope: float) -> float:
    """One step of Newton's method for one orbit, to the last bits of x, or as far as p² is known.

    Next to an end of the domain x is small against the start x₀ and has digits of its own: a step that is nothing
    against x₀ does not end the search while steps still shrink.
    """
    i, orbits, state = slots.state[0, j], slots.orbits, slots.state
    if f >= 0.0:
        orbits[0, i] = x
    else:
        orbits[1, i] = x
    new = x - f / slope
    halved = not (new - orbits[0, i]) * (new - orbits[1, i]) <= 0.0 or state[2, j] % 16 == 15
    if halved:
        new = 0.5 * (orbits[0, i] + orbits[1, i])
    step = abs(new - x)
    # steps that shrink by less than 4 are rounding of F
    lost = step <= 4.0 * EPS * abs(walk.start[i]) and step >= 0.25 * slots.reals[3, j] and not halved
    state[2, j] += 1
    slots.reals[3, j] = step
    if step <= 4.0 * EPS * abs(new) or lost:
        state[1, j] = _LAST
    elif state[2, j] >= _NEWTON_STEPS_OF_A_SLOT:
        state[1, j], new = _LAST, np.nan
    return new


@kernel
def turning_points(
    bend: MachineProgram, slopes: MachineProgram, walk: SearchSide, places: Reals, bends: Reals, slots: Slots
) -> None:
    """Find turning points on one side.

    Args:
        bend, slopes: programs of the view.
        walk: the starts.
        places: filled, shape (n,); NaN where there is none.
        bends: filled with F′ and ½F″ there, shape (2, n).
        slots: scratch.
    """
    n, width = places.shape[0], bend.registers.shape[1]
    if n == 0:
        return
    _bracketed(bend, walk, slots)
    for i in range(n):
        places[i] = slots.orbits[1, i]
    _improved(slopes, walk, places, slots.orbits)
    x, after = bend.registers[0], min(width, n)
    for j in range(width):
        i = min(j, n)
        _load(bend, walk, slots, j, i, places[min(i, n - 1)], _finishing(walk, places, slots, j, i))
    active, top = after, (after + 7) // 8 * 8
    while active > 0:
        run(bend, top)
        F, first, second = (bend.registers[bend.outputs[0]], bend.registers[bend.outputs[1]],
                            bend.registers[bend.outputs[2]])  # fmt: skip
        for j in range(top):
            i = slots.state[0, j]
            if slots.state[1, j] == _NEWTON:
                x[j] = places[i] = _step(walk, slots, j, x[j], F[j], first[j])
            elif slots.state[1, j] == _LAST:
                bends[0, i], bends[1, i] = first[j], 0.5 * second[j]
                doing = _finishing(walk, places, slots, j, after)
                _load(bend, walk, slots, j, after, places[min(after, n - 1)], doing)
                active, after = (active, after + 1) if after < n else (active - 1, after)


@kernel
def smallness(bend: MachineProgram, errors: MachineProgram, walk: SearchSide, uncertainty: Reals, small: Reals) -> None:
    """Write the error of p² at the start over about how large p² becomes.

    Args:
        bend, errors: programs of the view, of the same width.
        walk: the starts.
        uncertainty: bounds on the errors of the constants, shape (constants, n).
        small: filled, shape (n,).
    """
    n, width, m = small.shape[0], bend.registers.shape[1], walk.known.shape[0]
    first, second, error = (bend.registers[bend.outputs[1]], bend.registers[bend.outputs[2]],
                            errors.registers[errors.outputs[0]])  # fmt: skip
    for begin in range(0, n, width):
        count = min(width, n - begin)
        for j in range(count):
            x = walk.start[begin + j]
            bend.registers[0, j], errors.registers[0, j] = x, x
            errors.registers[1, j], errors.registers[2, j] = 2.0 * EPS * abs(x), 1.0
        for k in range(m):
            for j in range(count):
                bend.registers[1 + k, j] = errors.registers[3 + k, j] = walk.known[k, begin + j]
                errors.registers[3 + m + k, j] = uncertainty[k, begin + j]
        run(bend, (count + 7) // 8 * 8)
        run(errors, (count + 7) // 8 * 8)
        for j in range(count):
            P = walk.momentum[begin + j]
            # F = P² + F′d + ½F″d² has its top P² − F′²/(2F″)
            top = P * P + (first[j] * first[j] / (-2.0 * second[j]) if second[j] < 0.0 else np.inf)
            small[begin + j] = error[j] / top
