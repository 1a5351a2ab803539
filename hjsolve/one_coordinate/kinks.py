"""The motion of a coordinate along which p² has kinks: found piece by piece, from one kink to the next.

Between two kinks p² is one analytic formula. At a kink its limits F₋ and F₊ decide: both positive, the motion goes on;
F₊ < 0 < F₋, it is thrown back by the jump of V; F₋ = 0, it turns as at any simple zero.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from hjsolve.arithmetic.floats import Multi, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import InvalidInputError, NotConvergedError, required
from hjsolve.one_coordinate.chebyshev_panels import EndMap
from hjsolve.one_coordinate.coordinate_start import Cell, CoordinateStart
from hjsolve.one_coordinate.kinked_libration import KinkedLibration, PieceByPiece, PieceMap, SmoothPiece, integrated
from hjsolve.one_coordinate.momentum_squared import MomentumSquared, Number
from hjsolve.one_coordinate.open_branch import Branch
from hjsolve.one_coordinate.ray import Ray
from hjsolve.one_coordinate.turning_points import End, first_end

_BITS = 1024
"""Bits at which p² next to a kink is looked at."""
_MORE = 5
"""Digits to which pieces are integrated, more than asked."""


class Reached(NamedTuple):
    """Where a way through kinks ends: the cell, and its end."""

    cell: int
    end: End


def cell_of(start: CoordinateStart, forward: int) -> int:
    """Return the cell in which a motion goes on; that of the higher places at a kink, if it does not go down.

    Args:
        forward: sign of its momentum.
    """
    q = start.place(_BITS)
    for k, cell in enumerate(start.cells):
        if cell.upper is None or q < cell.upper(_BITS) or (forward < 0 and q == cell.upper(_BITS)):
            return k
    return len(start.cells) - 1


def in_its_cell(start: CoordinateStart, k: int) -> CoordinateStart:
    """Return the coordinate with the p² of one cell, which ends where that does."""
    cell = start.cells[k]
    return replace(start, radicand=cell.radicand, lower=cell.lower, upper=cell.upper, cells=())


def push(start: CoordinateStart) -> int:
    """Return where a coordinate at rest at a kink is pushed; 0 where it stays.

    Args:
        start: the coordinate, its place a kink, p² = 0 there.

    Raises:
        NotConvergedError: to both sides: more than one motion begins there.
    """
    below, above = cell_of(start, -1), cell_of(start, 1)
    q = start.place(_BITS)
    up, down = (_rises(start.cells[k].radicand, q, side) for k, side in ((above, 1), (below, -1)))
    if (up > 0 and down > 0) or (_at_kink(start.cells[below], 1) or 0) > 0:
        # the force points away from the kink on both sides: more than one motion begins there
        raise _undetermined(start.name, q)
    return int(up > 0) - int(down > 0)


def _undetermined(name: str, q: Mpf) -> NotConvergedError:
    return NotConvergedError(
        f"{name} comes to rest at {float(q):.9g}, a kink of V, and may leave it to either side in a finite time: "
        "the motion is not determined; change the energy a little"
    )


def reached(start: CoordinateStart, side: int, digits: int) -> Reached:
    """Walk through kinks to the first place at which the coordinate turns, or to where its way ends.

    Args:
        side: +1 upwards, −1 downwards.

    Raises:
        NotConvergedError: it comes to rest at a kink from which it may go on or go back.
    """
    k, origin = cell_of(start, side), start.place
    # only a start inside a cell has p² analytic on both sides of it
    inner = cell_of(start, -side) == k
    while True:
        cell = start.cells[k]
        last = cell.upper if side > 0 else cell.lower
        reach = None if last is None else partial(distance, origin, last)
        # a start at the far end of its cell goes on in the next one at once
        if reach is None or reach(_BITS) > 0:
            begin = origin if inner and origin is start.place else _inside(cell.radicand, origin, side, reach)
            reach = None if last is None else partial(distance, begin, last)
            end = first_end(Ray(cell.radicand, begin, side, reach), digits=digits)
        else:
            end = End("boundary", origin)
        beyond = k + side
        # it turned inside the cell, or the cell ends with the domain
        if end.kind not in {"boundary", "asymptote"} or last is None or not 0 <= beyond < len(start.cells):
            return Reached(k, end)
        q = last(_BITS)
        # a double zero before the kink; one at the kink is one of this side only
        if end.kind == "asymptote" and end.place is not None and abs(end.place(_BITS) - q) > abs(q) * 1e-30:
            return Reached(k, end)
        here, there = _at_kink(cell, side), _at_kink(start.cells[beyond], -side)
        if here is None or there is None:
            return Reached(k, end)
        # p² < 0 beyond: V jumps up there, and the motion is thrown back; with p² = 0 here it turns
        if there < 0:
            return Reached(k, End("wall" if here > 0 else "turning", last))
        if there == 0 or here == 0:
            # p² = 0 at the kink and negative behind it: an ordinary turning point, whose slope is that of this side
            if there == 0 and _rises(start.cells[beyond].radicand, q, side) < 0:
                return Reached(k, End("wall" if here > 0 else "turning", last))
            raise _undetermined(start.name, q)
        k, origin = beyond, last


def ends_between(start: CoordinateStart, begin: int, target: Reached, side: int) -> list[End]:
    """Return the kinks on the way from a cell to an end, and the end.

    Args:
        begin: the cell in which the way begins.
        target: where it ends.
        side: +1 upwards, −1 downwards.
    """
    cells = [start.cells[k] for k in range(begin, target.cell, side)]
    return [*(End("kink", cell.upper if side > 0 else cell.lower) for cell in cells), target.end]


def _inside(radicand: MomentumSquared, kink: Number, side: int, reach: Number | None) -> Number:
    """Return the kink; where p² has no slope there, as |x|^(1/2), a place beyond it up to which p² is proved positive.

    Raises:
        NotConvergedError: there is none.
    """
    q = kink(_BITS)
    try:
        # a finite F′ at the kink: the cell can be searched from the kink itself
        if all(abs(part) < part.context.inf for part in radicand.jet(q, _BITS)):
            return kink
    except InvalidInputError:
        pass
    length = reach(_BITS) if reach is not None else abs(q) or q.context.mpf(1)
    for power in range(1, _BITS, 2):
        x = q + side * q.context.ldexp(length, -power)
        # F itself may be enclosed where F′ is infinite: the search begins where p² is proved positive up to
        low = radicand.enclose(np.array([min(q, x)], dtype=object), np.array([max(q, x)], dtype=object), 256)[0].low[0]
        if low > 0:
            return partial(_beyond, kink, side, length, power)
    raise NotConvergedError(f"p² could not be decided next to the kink at q = {float(q):.15g}")


def _beyond(kink: Number, side: int, length: Mpf, power: int, bits: int) -> Mpf:
    context = multiprecision(bits)
    return context.convert(kink(bits)) + side * context.ldexp(context.convert(length), -power)


def _at_kink(cell: Cell, side: int) -> Mpf | None:
    """p² at an end of a cell; None where it is infinite."""
    value = cell.at_upper if side > 0 else cell.at_lower
    return None if value is None else value(_BITS)


def _rises(radicand: MomentumSquared, q: Mpf, side: int) -> int:
    """Return the sign of p² just beyond a kink where it is zero, as far as it shows nearby."""
    values = [radicand.value(q + side * q.context.ldexp(1 + abs(q), -power), _BITS) for power in (80, 120)]
    return int(values[1].context.sign(values[1])) if values[0] * values[1] > 0 else 0


def distance(one: Number, other: Number, bits: int) -> Mpf:
    """Return the distance of two places in so many bits."""
    return abs(other(bits) - one(bits))


def libration(start: CoordinateStart, lower: Reached, upper: Reached, forward: int, digits: int) -> KinkedLibration:
    """Integrate a libration through kinks.

    Args:
        lower, upper: its ends.
        forward: sign of its momentum; 0 at an end.
    """
    more = max(digits, 15) + _MORE
    bits = bits_for(more, 128)
    # the kinks and turning points are ends of pieces, from which distances are counted
    exact = bits + 256 + start.radicand.guard
    places = [
        required(lower.end.place),
        *(_upper(start.cells[k]) for k in range(lower.cell, upper.cell)),
        required(upper.end.place),
    ]
    pieces = []
    for k, (low, high) in enumerate(itertools.pairwise(places)):
        a, b = low(exact), high(exact)
        first, last = k == 0 and lower.end.kind == "turning", k == len(places) - 2 and upper.end.kind == "turning"
        # each piece is integrated from its turning point, if it has one: the inverse root is at y = 0 of its map
        end_map = EndMap(first or last, "kink", b if last else a, -1 if last else 1, b - a)
        radicand = start.cells[lower.cell + k].radicand
        pieces.append(
            SmoothPiece(
                Branch(end_map, radicand, start.skipped, more, bits), PieceMap(a, b - a, int(last) - int(first))
            )
        )
    anomaly = PieceByPiece(tuple(p.map for p in pieces), places[0](exact), places[-1](exact))
    kernels, momentum, density = integrated(pieces, more, bits)
    arithmetic = Multi(bits)
    χ = anomaly.phase(arithmetic.convert(start.place(exact)), forward, arithmetic)
    return KinkedLibration("libration", anomaly, kernels, momentum, density, χ, start.radicand)  # type: ignore[arg-type]


def _upper(cell: Cell) -> Number:
    if cell.upper is None:
        raise InvalidInputError("a cell between kinks ends at a kink")
    return cell.upper
