"""Compiled loops over many times (extra ``fast``): the same operations in the same order as the numpy path.

Only ``hjsolve.time_law.compiled`` imports this module, when there is enough to do. The loops hold no lock (``nogil``)
and no state, so that threads may share them; machine code is kept on disk between processes where that can be written.
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign
from typing import Any, TypeVar

import numba
import numpy as np

from hjsolve.arithmetic.error_free import TOO_MANY
from hjsolve.arithmetic.number_types import Integers, Reals

F = TypeVar("F", bound=Callable[..., object])

_SPLITTER = 134217729.0  # 2²⁷ + 1, Dekker: each half of a double has at most 26 bits
_TURN = 2 * np.pi
_BLOCK = 512  # places of a block, 8 kB with their panels: they stay in the first cache


def _kernel(function: F) -> F:
    """Compile on the first call; keep the machine code on disk where a directory for it can be written."""
    njit: Any = numba.njit
    try:
        return njit(nogil=True, cache=True, error_model="numpy")(function)
    except RuntimeError:
        return njit(nogil=True, error_model="numpy")(function)


@_kernel
def fill_relative(times: Reals, high: float, low: float, upper: Reals, lower: Reals) -> None:
    """Fill ``upper`` + ``lower`` with times − (high + low).

    Args:
        times: t, doubles, shape (m,).
        high, low: t₀ as the sum of two doubles.
        upper, lower: filled here; shape (m,).
    """
    for i in range(times.size):
        t = times[i]
        # two_sum of t and −high (Knuth): difference + error is exact, then the low part comes off
        difference = t - high
        part = difference - t
        upper[i] = difference
        lower[i] = (t - (difference - part)) - (high + part) - low


@_kernel
def _counted(n: float, more: float) -> int:
    """Return the sum of whole numbers as an integer; ± ``TOO_MANY`` beyond them, 0 for nan."""
    if abs(n) < TOO_MANY:
        return int(n) + int(more)
    return 0 if n != n else (-TOO_MANY if n < 0 else TOO_MANY)


@_kernel
def turns(
    rate: tuple[float, float], upper: Reals, lower: Reals, start: tuple[float, float], whole: Integers, rest: Reals
) -> None:
    """Fill whole turns and rest of start + rate·time; see ``phase_reduction.turns_and_rest``.

    Args:
        rate: turns in a unit of time, as two doubles whose sum it is.
        upper, lower: time, as the sum of two doubles; shape (m,).
        start: turns at time zero, as ``rate``.
        whole, rest: filled here; shape (m,).
    """
    rh, rl, sh, sl = rate[0], rate[1], start[0], start[1]
    # Dekker's splitting by 2²⁷ + 1: the halves have 26 bits, and their products are exact
    c = _SPLITTER * rh
    ah = c - (c - rh)
    al = rh - ah
    for i in range(upper.size):
        t = upper[i]
        p = rh * t
        cb = _SPLITTER * t
        bh = cb - (cb - t)
        bl = t - bh
        # p + e = rh·t exactly; the low parts of rate and time come next, to 106 bits
        e = ((ah * bh - p) + ah * bl + al * bh) + al * bl
        e = e + (rh * lower[i] + rl * t)
        # whole turns first: p − n is exact, and what is left is below one
        n = np.rint(p)
        a = p - n
        s = a + sh
        part = s - a
        # two_sum of the rest and the start, and all that was too small for it
        w = ((a - (s - part)) + (sh - part)) + (e + sl)
        more = np.rint(s + w)
        whole[i] = _counted(n, more)
        rest[i] = (s - more) + w


@_kernel
def _place(argument: Reals, edges: Reals, guide: Integers, parity: int, panels: Integers, places: Reals) -> None:
    """Fill the panel of each argument, and its place x in [−1, 1] there."""
    last, cells = edges.size - 2, guide.size - 1
    first, scale = edges[0], cells / (edges[last + 1] - edges[0])
    for i in range(argument.size):
        θ = argument[i]
        u = abs(θ) if parity else θ
        # equally spaced cells, four a panel: the guide gives the panel nearly always without a search
        cell = min(max(int((u - first) * scale), 0), cells - 1)
        k, beyond = guide[cell], guide[cell + 1] + 1
        # bisection where edges crowd into one cell, then a walk of at most four
        while beyond - k > 4:
            middle = (k + beyond) >> 1
            if edges[middle] <= u:
                k = middle
            else:
                beyond = middle
        while k < last and edges[k + 1] <= u:
            k += 1
        left, right = edges[k], edges[k + 1]
        panels[i] = k
        places[i] = ((u - left) - (right - u)) / (right - left)


@_kernel
def _polynomial(panels: Integers, places: Reals, rows: Reals, out: Reals) -> None:
    """Horner's rule of degree ``table.DEGREE``, written out so that it becomes vector instructions."""
    for i in range(panels.size):
        k, x = panels[i], places[i]
        # the operations of ``InterpolationTable._chunk`` in their order: results do not depend on which of the two ran
        value = rows[k, 11] * x + rows[k, 10]
        value = (value * x + rows[k, 9]) * x + rows[k, 8]
        value = (value * x + rows[k, 7]) * x + rows[k, 6]
        value = (value * x + rows[k, 5]) * x + rows[k, 4]
        value = (value * x + rows[k, 3]) * x + rows[k, 2]
        out[i] = (value * x + rows[k, 1]) * x + rows[k, 0]


@_kernel
def look_up(argument: Reals, edges: Reals, guide: Integers, rows: Reals, parity: int, out: Reals) -> None:
    """Fill ``out`` with a tabulated quantity; see ``table.InterpolationTable``.

    First the panel and the place x in it, then the polynomial, block by block: a loop of its own with a fixed degree
    is what the compiler turns into vector instructions.

    Args:
        argument: θ, shape (m,).
        edges: panel ends, shape (panels + 1,).
        guide: last panel that begins at or before each of equally spaced places, from the first to the last edge.
        rows: powers of x on each panel, lowest first, shape (panels, ``DEGREE`` + 1).
        parity: 0 for a table that is not folded, 1 for an even quantity, −1 for an odd one.
        out: shape (m,).
    """
    panels, places = np.empty(_BLOCK, dtype=np.int64), np.empty(_BLOCK)
    for begin in range(0, argument.size, _BLOCK):
        count = min(_BLOCK, argument.size - begin)
        part = argument[begin : begin + count]
        _place(part, edges, guide, parity, panels, places)
        _polynomial(panels[:count], places, rows, out[begin : begin + count])
        if parity < 0:
            for i in range(count):
                out[begin + i] = out[begin + i] * copysign(1.0, part[i])


@_kernel
def fill_principal(angle: Reals, value: Reals, count: Integers) -> None:
    """Fill ``value`` in (−π, π] and the turns taken away.

    Args:
        angle: in radians, shape (m,).
        value, count: filled here; shape (m,).
    """
    for i in range(angle.size):
        x = angle[i]
        # (−π, π], the upper end included: −π becomes π
        n = np.ceil((x - np.pi) / _TURN)
        count[i] = _counted(n, 0.0)
        value[i] = x if n == 0 else x - _TURN * n
