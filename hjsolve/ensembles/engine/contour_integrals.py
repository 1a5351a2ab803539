r"""Second derivatives of actions of many librations, on closed paths round both turning points.

J = (1/2π) ∮ √F dq does not change when its path is drawn away from the turning points, and there it may be
differentiated under the integral sign as often as is wanted, with no term that is large next to an end:

    J_j = (1/2π) ∮ ½ F_j dq/√F,      J_jk = (1/2π) ∮ (½ F_jk − ¼ F_j F_k/F) dq/√F.

Two kinds of path serve. A line χ + iη in the strip about the nodes of ``engine.node_maps``, in the middle of what is
proved to resolve the orbit: 2N steps there see the motion on one side and whatever bounds the strip on the other as
well as N nodes see the latter from the real axis. And q = m + ρ e^{iχ} + (h²/4ρ) e^{−iχ} round m ± h, where there is
room: with D = ρ e^{iχ} − (h²/4ρ) e^{−iχ} it is dq = iD dχ and F = −D²R, so that dq/√F = dχ/√R, and nothing cancels
however small h is. Equal steps converge geometrically (Trefethen & Weideman, SIAM Review 56 (2014) 385, §2); where they
are n, every other one shows what n/2 leave open, c, and n leave about c².
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Complexes, Integers, Mask, Reals
from hjsolve.ensembles.engine.kernels.path_integrals import Paths, PathTable, path_means
from hjsolve.ensembles.engine.kernels.types import SLOTS
from hjsolve.ensembles.engine.node_maps import COUNTS, NodeMap
from hjsolve.ensembles.engine.nodes import libration_nodes
from hjsolve.ensembles.engine.programs_of_paths import PathPrograms, pairs
from hjsolve.ensembles.engine.strips_of_analyticity import half_width, squares

_LONG, _NEAR = 48.0, 8.0
"""2n η of a path e^η away: e^−48 is left where the next singularity is as far; and what is added for small η."""
_PROVED, _EXPECTED = 2.0, 1.5
"""(8c)² is claimed where nothing but the motion and the end of a strip that is proved to resolve it bounds the rate,
and (4c)^1.5 where that is only expected."""
_SAMPLED = 4
"""Every which step errors are bounded at."""
_TABLES = 512
"""Tables of steps that stay."""


class Seconds(NamedTuple):
    """J, J_j, J_jk of one coordinate of m orbits, and bounds on their errors.

    Attributes:
        action, action_error: J and what rounding leaves open of it, shape (m,).
        first, first_error: J_j and bounds on their errors, shape (variables, m).
        second, error: J_jk, one j a constant, shape (constants, variables, m).
        scale: the mean size of what J_jk is the mean of, of the same shape.
        left: what the steps leave open of the J_jk, over their scale at most, shape (m,).
        good: whether the path holds the turning points and nothing else, as far as it shows.
    """

    action: Reals
    action_error: Reals
    first: Reals
    first_error: Reals
    second: Reals
    error: Reals
    scale: Reals
    left: Reals
    good: Mask

    def put(self, orbits: Integers, part: Seconds) -> None:
        """Write what was found of some orbits."""
        for own, new in zip(self, part, strict=True):
            own[..., orbits] = new


class Integrand(NamedTuple):
    """p² of one coordinate.

    Attributes:
        below, above: codes of both halves.
        parameters: of the codes.
        constants: how many of the variables are constants of the motion.
        known: variables of n orbits, and bounds on their errors, shape (n, 2 variables).
    """

    below: PathPrograms
    above: PathPrograms
    parameters: tuple[float, ...]
    constants: int
    known: Reals


def steps(η: Reals) -> Integers:
    """Return how many steps half of a path e^η away takes: more next to the motion, where the integrands grow.

    Args:
        η: how far it is, shape (m,).
    """
    # e^(−2nη) over the path, and e^(−48) wanted; a little more next to the motion
    needed = (_LONG + _NEAR * np.maximum(0.0, -np.log(η))) / η / 2
    return (8 * np.ceil(needed / 8)).astype(np.int64)


def _table(places: tuple[Any, Any, Any, Any], χ: Reals, below: int, *, real: bool = False) -> tuple[PathTable, ...]:
    """Return the steps, and every fourth of them."""
    n = len(χ)
    parts = np.stack([part for z in places for part in (np.real(z), np.imag(z))]).astype(float)
    # alternating signs: the mean over every other step less that over all
    # the difference is exact for what both sums resolve: it shows the first coefficients that the fewer miss
    turned = np.where(np.arange(n) % 2 == 0, 1.0, -1.0) / n
    none = 0.0 * turned
    weights = [turned, none, turned * np.cos(χ), none] if real else [
        none, turned, turned * np.sin(χ), turned * np.cos(χ)
    ]  # fmt: skip
    rows = np.ascontiguousarray(np.stack(weights))
    some = np.ascontiguousarray(parts[:, ::_SAMPLED])
    # of the sampled steps: ``below`` is a multiple of four, or all
    fewer = -(-below // _SAMPLED)
    return PathTable(parts, rows, np.array([below])), PathTable(some, rows, np.array([fewer]))


@lru_cache(maxsize=_TABLES)
def circle(count: int) -> tuple[PathTable, ...]:
    """Return the steps of q = m + A e^{iχ} + B e^{−iχ} above the real axis; below it everything is conjugate.

    Args:
        count: how many, an even number.
    """
    χ = np.pi * (np.arange(count) + 0.5) / count
    out, back = np.exp(1j * χ), np.exp(-1j * χ)
    return _table((out, back, 1j * out, -1j * back), χ, count)


@lru_cache(maxsize=_TABLES)
def turn(count: int) -> tuple[PathTable, ...]:
    """Return the steps of a whole turn, on the real axis, where F > 0 everywhere.

    Args:
        count: how many, an even number.
    """
    # a quarter of a step off 0: from there alternating sums see even functions and odd ones
    q = 2 * np.pi * (np.arange(count) + 0.25) / count
    return _table((q, 0 * q, 1 + 0 * q, 0 * q), q, count, real=True)


@lru_cache(maxsize=_TABLES)
def strip(key: NodeMap, size: int, count: int, side: int) -> tuple[PathTable, ...]:
    """Return the steps of a line half way up the strip of a map and a size: A (q − a)/W, then A (b − q)/W.

    Args:
        key: the map, of motions that are not seen as even.
        size: place in ``COUNTS``.
        count: how many steps, an even number.
        side: 0 or 1 where all steps are seen from the lower or the upper end, 2 where each is from the nearer one.
    """
    table = libration_nodes(COUNTS[size], key.level, key.node_map)
    χ = np.pi * (np.arange(count) + 0.5) / count
    z: Complexes = (χ + 0.5j * half_width(COUNTS[size], 1)).astype(complex)
    sn2, cn2 = squares(z, table)
    x, y = key.stretched(sn2, cn2)
    γ, δ = table.node_map
    slope = 1 + γ * np.cos(z) + δ * np.cos(2 * z)
    # (dq/dχ)² of the plain map, with the crowding's derivative; of stretched maps times their own factor
    square: Any = slope * slope * x * y
    if key.level:
        d, c = 2.0**key.lower - 1, 2.0**key.upper - 1
        square = square * (2 * table.quarter / np.pi) ** 2 * table.complement * (1 + c * y) * (1 + d * x)
    below = int(np.argmax(np.abs(x) > np.abs(y))) // _SAMPLED * _SAMPLED
    seen = (x, y, np.where(np.arange(count) < below, x, y))[side]
    below = below if side == 2 else count
    return _table((seen, 0 * seen, np.sqrt(square), 0 * seen), χ, below)


def along(integrand: Integrand, tables: tuple[PathTable, ...], paths: Paths, view: int, proved: Mask) -> Seconds:
    """Integrate along a path.

    Args:
        integrand: of m orbits.
        tables: its steps.
        paths: where they are.
        view: the half that sees its first steps, 0 or 1.
        proved: whether the path is in the middle of a strip that is proved to resolve the orbit, shape (m,).
    """
    table, fewer = tables
    m, n, varied = len(paths.wide), integrand.constants, paths.known.shape[1] // 2
    each = pairs(n, varied)
    results = varied + len(each)
    made, bounds = np.empty((2 + 3 * results, m)), np.empty((2 + 2 * results, m))
    work = np.empty((7, table.steps.shape[1]))
    for codes, own, filled, bounded in (("means", table, made, False), ("bounds", fewer, bounds, True)):
        width = max(SLOTS, own.steps.shape[1])
        below, above = (
            getattr(programs, codes).program(width, integrand.parameters, half)
            for half, programs in enumerate(((integrand.below, integrand.above)[view], integrand.above))
        )
        path_means(below, above, own, paths, bounded, work, filled)
    rounding, scale = bounds[: 1 + results], bounds[1 + results :]
    values, left = made[2::3], np.maximum(made[3::3], made[4::3])
    with np.errstate(all="ignore"):
        c = left / scale[1:]
        # n steps leave the square of what n/2 leave, if the rate is that of one singularity: proved, or taken with less
        fraction = np.minimum(1.0, np.where(proved, (8 * c) ** _PROVED, (4 * c) ** _EXPECTED))
        open_ = np.where(scale[1:] == 0, 0.0, scale[1:] * fraction)
        fraction = np.where(scale[1:] == 0, 0.0, fraction)
    place = np.zeros((n, varied), dtype=np.int64)
    for position, (j, k) in enumerate(each, varied):
        place[j, k] = position
        if k < n:
            place[k, j] = position
    error = rounding[1:] + open_
    # r continued along half a closed path comes back with its sign if two turning points, and nothing else, are inside
    good = (made[0] > 0) & np.isfinite(made).all(axis=0) & np.isfinite(bounds).all(axis=0)
    return Seconds(
        made[1], rounding[0], values[:varied], rounding[1 : 1 + varied] + 4 * open_[:varied], values[place],
        error[place], scale[1:][place], np.max(fraction[varied:], axis=0), good,
    )  # fmt: skip
