"""Running integrals of many librations over arcs that begin next to their lower turning points.

Between turning points a and b = a + W, q = a + W sin²(φ/2) and φ = φₐ sinh t, the integrals are

    ∫ kⱼ/p dq = ∫ kⱼ/√F · ½ W sin φ · φₐ cosh t dt,

by the rule of Gauss and Legendre on equal pieces in t (Trefethen, SIAM Review 50 (2008) 67, §1). Nodes of as many
orbits as there are lanes are worked out together, those of the lower half by one program, of the upper half by another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.machine.compiling import helper, kernel
from hjsolve.arithmetic.machine.elementary import sincos, sinhcosh
from hjsolve.arithmetic.machine.run import MachineProgram, run
from hjsolve.arithmetic.number_types import Integers, Reals

_TURNING = 1e-60  # sine or cosine of φ/2 that stands for 0: F is linear there, and kⱼ/√F · sin φ finite


class ArcsOfLibrations(NamedTuple):
    """Arcs of one coordinate of n orbits.

    Attributes:
        middle, half: of the arc in t: (t₀ + t₁)/2 and (t₁ − t₀)/2, shape (n,).
        pieces: into how many it is cut, shape (n,).
        scale: φₐ, shape (n,).
        width: W, shape (n,).
        ends: offsets of the turning points in the views of both halves, shape (2, n); 0 where the program knows them.
        away: ±1, how these offsets grow away from the turning points, shape (2,).
        linear: distances from either turning point below which F is linear, shape (2, n).
        known: constants, and what else a program knows, shape (n, known).
    """

    middle: Reals
    half: Reals
    pieces: Integers
    scale: Reals
    width: Reals
    ends: Reals
    away: Reals
    linear: Reals
    known: Reals


class Lanes(NamedTuple):
    """What nodes in the lanes of both programs are for: the orbit, and the weight in its sums; shape (2, lanes)."""

    orbit: Integers
    weight: Reals


def lanes(width: int) -> Lanes:
    """Return empty lanes.

    Args:
        width: how many a program has.
    """
    return Lanes(np.zeros((2, width), dtype=np.int64), np.zeros((2, width)))


@helper
def _emptied(program: MachineProgram, half: int, count: int, sums: Reals, sizes: Reals, work: Lanes) -> None:
    """Run a program over its lanes, and add what comes out to the sums of the orbits."""
    run(program, (count + 7) // 8 * 8)
    orbit, weight = work.orbit[half], work.weight[half]
    for k in range(sums.shape[0]):
        rates, total, size = program.registers[program.outputs[3 + k]], sums[k], sizes[k]
        for j in range(count):
            part = weight[j] * rates[j]
            total[orbit[j]] += part
            size[orbit[j]] += abs(part)


@kernel
def arc_integrals(
    below: MachineProgram, above: MachineProgram, arcs: ArcsOfLibrations, nodes: Reals, weights: Reals, sums: Reals,
    sizes: Reals, work: Lanes,
) -> None:  # fmt: skip
    """Integrate one coordinate of many orbits over arcs.

    Args:
        below, above: programs ``fill`` of the lower and of the upper half, of the same number of lanes.
        arcs: of n orbits.
        nodes, weights: of the rule on −1 … 1, applied to every piece.
        sums, sizes: the integrals, and those of the sizes of their parts, are added to these, shape (constants, n).
        work: of as many lanes.
    """
    width, low, high = below.registers.shape[1], 0, 0
    for i in range(arcs.width.shape[0]):
        W, scale, pieces, half = arcs.width[i], arcs.scale[i], arcs.pieces[i], arcs.half[i]
        for piece in range(pieces):
            for p in range(nodes.shape[0]):
                x = (nodes[p] + (2 * piece + 1)) / pieces - 1.0
                grown, growth = sinhcosh(arcs.middle[i] + half * x)
                s, c = sincos(0.5 * scale * grown)
                s, c = max(abs(s), _TURNING), max(abs(c), _TURNING)
                side = 0 if s <= c else 1
                program, at = (below, low) if side == 0 else (above, high)
                d, away, end = W * (s * s if side == 0 else c * c), arcs.away[side], arcs.ends[side, i]
                seen = max(d, arcs.linear[side, i])
                registers = program.registers
                registers[0, at], registers[1, at] = away * seen, end + away * seen
                registers[2, at], registers[3, at] = W * s * c * scale * growth, end
                for k in range(arcs.known.shape[1]):
                    registers[4 + k, at] = arcs.known[i, k]
                work.orbit[side, at] = i
                work.weight[side, at] = half * weights[p] / pieces * (math.sqrt(seen / d) if d < seen else 1.0)
                if side == 0:
                    low += 1
                    if low == width:
                        _emptied(below, 0, low, sums, sizes, work)
                        low = 0
                else:
                    high += 1
                    if high == width:
                        _emptied(above, 1, high, sums, sizes, work)
                        high = 0
    if low > 0:
        _emptied(below, 0, low, sums, sizes, work)
    if high > 0:
        _emptied(above, 1, high, sums, sizes, work)
