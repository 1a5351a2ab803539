"""Proof that the nodes of an orbit resolve p² and its kernels, so that nothing can hide between them.

The midpoint rule judges itself by its last coefficients (``midpoint_rule``): that says nothing of a dip narrower than
the distance of the nodes. So the rule is only believed where p² is proved to be known between the nodes: its parts
(``clearance``) are analytic in the strip about the nodes (``strips_of_analyticity``) and do not grow there. Their
coefficients then fall geometrically from the first one on, and what is beyond the nodes is less than the rounding that
claims count.

What is left are zeros of p² near the way, branch points of the integrands that clearances do not show. They cannot
hide, because S = p²/((q − a)(b − q)) is a function that its values at the nodes determine: where it nearly vanishes it
does so over several nodes, and the integrands, which go like S^(±½), then have last coefficients that do not fall.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hjsolve.arithmetic.number_types import Complexes, Elementwise, Integers, Reals
from hjsolve.ensembles.engine.clearance import Clearance
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula
from hjsolve.ensembles.engine.nodes import COUNTS, Nodes, node_table
from hjsolve.ensembles.engine.radicand_views import DifferenceEvaluation, DoubleDoubleEvaluation, Knowns, View
from hjsolve.ensembles.engine.strips_of_analyticity import (
    CoveredStrip,
    CoveredTurn,
    across,
    covered_strip,
    covered_turn,
    disks,
)  # fmt: skip
from hjsolve.ensembles.engine.turned_circle import moved_disks

if TYPE_CHECKING:
    from hjsolve.ensembles.engine.orbit_regions import OrbitRegions

_UNKNOWN, _CAUTIOUS, _HOPELESS = 0.4, 0.7, 2.0
"""The nodes needed grow nearly like the share of the radius that is missing, at least with this power; for stretched
anomalies, and where nothing is known, as if the share were 0.4 at least. Twice as many as there are is too many."""
_CROWDED = 28, 7
"""Nodes that stretched anomalies mostly need, and how many more for each level; fewer are not tried."""
_CLOSE = 0.5
"""A share of a coarse cover from which on a finer one may be enough."""
_SMALL = 0.03
"""Motions smaller than this, in units of the distance from the origin, get a disk of their own if it must be."""
_NODES = 1 << 20
"""Of all orbits that are looked at together: about two disks a node, with a few complex numbers each."""
_ALONG = np.linspace(-0.5, 0.5, 5)


class _Disks(NamedTuple):
    """Disks that cover strips of some orbits, in one view of p².

    Attributes:
        orbits: which they are, shape (n,).
        centres: offsets in the formula of the view.
        radii: both (n, disks).
    """

    orbits: Integers
    centres: Reals | Complexes
    radii: Reals


def room(clearance: Clearance, middle: Reals, width: Reals) -> Reals:
    """Return the radius of the disk about the middle of a motion in which p² is known, in units of half its width.

    Args:
        clearance: of p².
        middle: offset of (a + b)/2 in the formula.
        width: b − a; arrays (n,).
    """
    with np.errstate(all="ignore"):
        return clearance.radius(middle) / (0.5 * width)


def least(region: OrbitRegions, first: int) -> Reals:
    """Return the first number of nodes tried that is proved to resolve each orbit; inf for none.

    What is proved for a number of nodes is proved for more: the strip is narrower.

    Args:
        region: where the orbits move.
        first: number of nodes to begin with, one of ``COUNTS``.
    """
    needed, mostly = np.full(len(region.width), np.inf), _CROWDED[0] + _CROWDED[1] * region.level
    hint = np.where(region.level > 0, np.maximum(first, mostly), float(first))
    codes = region.level * 8 + region.node_map
    for count in COUNTS:
        chosen = np.flatnonzero(np.isinf(needed) & (hint <= count))
        for left in np.array_split(chosen, len(chosen) * count // _NODES + 1) if len(chosen) else []:
            share = _shares(region.take(left), count, codes[left], coarse=True)
            close = np.flatnonzero((share >= _CLOSE) & (share < 1) & (region.level[left] > 0))
            share[close] = _shares(region.take(left[close]), count, codes[left[close]], coarse=False)
            needed[left[share >= 1]] = count
            floor = np.where((share > 0) & (region.level[left] == 0), 0.0, _UNKNOWN)
            guess = count * np.fmax(share, np.fmax(floor, 1e-3)) ** -_CAUTIOUS
            hint[left] = np.where(guess < _HOPELESS * COUNTS[-1], np.minimum(guess, COUNTS[-1]), np.inf)
    return needed


def _shares(region: OrbitRegions, count: int, codes: Integers, *, coarse: bool) -> Reals:
    """The least radius that is known over the one that is needed; only whether it is below 1 is exact."""
    share = np.zeros(len(region.width))
    below: list[_Disks] = []
    above: list[_Disks] = []
    for code in np.unique(codes):
        part, table = np.flatnonzero(codes == code), node_table(region.turning, count, int(code) // 8, int(code) % 8)
        if region.turning and table.complement == 1.0:
            share[part] = _at_a_glance(region.take(part), table)
            part = part[~(share[part] >= 1)]
        if not len(part):
            continue
        if region.turning:
            share[part] = np.inf
            low, high = _disks(region.take(part), part, table, covered_strip(table, coarse=coarse))
            below.append(low)
            above += [] if high is None else [high]
        elif (turn := covered_turn(table, coarse=coarse)).inside:
            share[part] = np.inf
            below.append(_turned(region.take(part), part, table, turn))
    for view, seen in ((region.below, below), (region.above, above)):
        _looked_up(view, seen, share)
    return share


def _looked_up(view: View, seen: list[_Disks], share: Reals) -> None:
    """Lower the shares to what is known of some disks, by one look at the table."""
    if not seen:
        return
    formula, _, base = _seen(view)
    places = [d.centres + (base[d.orbits] if np.ndim(base) else base) for d in seen]
    found = formula.clearance.radius(np.concatenate([x.ravel() for x in places]))
    ends = np.cumsum([x.size for x in places])
    for one, known in zip(seen, np.split(found, ends[:-1]), strict=True):
        with np.errstate(all="ignore"):
            least_share = (known.reshape(one.centres.shape) / one.radii).min(axis=1)
        share[one.orbits] = np.minimum(share[one.orbits], least_share)


def _at_a_glance(region: OrbitRegions, table: Nodes) -> Reals:
    """The same by one disk about the middle of each motion."""
    formula, knowns, base = _seen(region.below)
    middle = np.ravel(base) + region.lower + region.below.sign * 0.5 * region.width
    radius = across(len(table.χ), table.node_map, table.symmetry)
    share = room(formula.clearance, middle, region.width) / radius
    small = np.flatnonzero((share < 1) & (region.width < _SMALL * np.abs(middle)))
    if len(small):  # cells are too large for it
        x, W = middle[small, None], region.width[small, None]
        share[small] = formula.clearance.holds(knowns.take(small).constants, x, 0.5 * radius * W, x + W * _ALONG)
    return share


def _seen(view: View) -> tuple[LoweredFormula, Knowns, Elementwise]:
    """The formula of a view, what is known, and the offset in the formula of the view's zero."""
    if isinstance(view, DifferenceEvaluation):
        return view.formula, view.knowns, view.start[:, None]
    if isinstance(view, DoubleDoubleEvaluation):
        return view.raw.formula, view.raw.knowns, view.base.high[:, None]
    return view.formula, view.knowns, 0.0


def _disks(region: OrbitRegions, orbits: Integers, table: Nodes, over: CoveredStrip) -> tuple[_Disks, _Disks | None]:
    """The disks that cover the strip, seen from the lower and from the upper end; where one view has all, no second."""
    W, half = region.width[:, None], len(over.above) if table.symmetry == 2 else len(over.above) // 2
    low, high, radii = disks(over, 0.0 * W if table.complement == 1.0 else region.near_lower[:, None])
    with np.errstate(all="ignore"):
        lower = region.lower[:, None] + region.below.sign * W * low[:, :half]
        upper = region.upper[:, None] - region.above.sign * W * high[:, half:]
        if region.below is region.above:
            return _Disks(orbits, np.concatenate([lower, upper], axis=1), W * radii), None
        rest = _Disks(orbits, upper, W * radii[:, half:]) if half < len(over.above) else None
        return _Disks(orbits, lower, W * radii[:, :half]), rest


def _turned(region: OrbitRegions, orbits: Integers, table: Nodes, over: CoveredTurn) -> _Disks:
    """The disks that cover the strip of rotations."""
    angle, radii = moved_disks(over.angle, over.reach, region.near_lower[:, None]) if table.slow == 2 else (
        over.angle, over.reach
    )  # fmt: skip
    offset = region.lower[:, None] + np.sign(region.momentum)[:, None] * angle
    return _Disks(orbits, offset, radii + 0.0 * np.real(offset))
