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
from hjsolve.ensembles.engine.strips_of_analyticity import SAFETY, CoveredStrip, across, covered_strip
from hjsolve.ensembles.engine.turned_circle import moved_disks, reach

if TYPE_CHECKING:
    from hjsolve.ensembles.engine.orbit_regions import OrbitRegions

_UNKNOWN, _CAUTIOUS, _HOPELESS = 0.3, 0.7, 2.0
"""The nodes needed grow nearly like the share of the radius that is missing, at least with this power; for stretched
anomalies, and where nothing is known, as if the share were 0.3 at least. Twice as many as there are is too many."""
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
    """Return the least number of nodes, from the first one on, that is proved to resolve each orbit; inf for none.

    What is proved for a number of nodes is proved for more: the strip is narrower.

    Args:
        region: where the orbits move.
        first: number of nodes to begin with, one of ``COUNTS``.
    """
    needed, hint = np.full(len(region.width), np.inf), np.full(len(region.width), float(first))
    codes = region.level * 8 + region.node_map
    for count in COUNTS:
        chosen = np.flatnonzero(np.isinf(needed) & (hint <= count))
        for left in np.array_split(chosen, len(chosen) * count // _NODES + 1) if len(chosen) else []:
            share = _shares(region.take(left), count, codes[left])
            needed[left[share >= 1]] = count
            floor = np.where((share > 0) & (region.level[left] == 0), 0.0, _UNKNOWN)
            guess = count * np.fmax(share, np.fmax(floor, 1e-3)) ** -_CAUTIOUS
            hint[left] = np.where(guess < _HOPELESS * COUNTS[-1], np.minimum(guess, COUNTS[-1]), np.inf)
    return needed


def _shares(region: OrbitRegions, count: int, codes: Integers) -> Reals:
    """The least radius that is known over the one that is needed; only whether it is below 1 is exact."""
    share = np.zeros(len(region.width))
    below: list[_Disks] = []
    above: list[_Disks] = []
    for code in np.unique(codes):
        part, table = np.flatnonzero(codes == code), node_table(region.turning, count, int(code) // 8, int(code) % 8)
        if region.turning and table.complement == 1.0:
            share[part] = _at_a_glance(region.take(part), table)
            part = part[~(share[part] >= 1)]
        over = covered_strip(table, region.turning)
        if over.inside and len(part):
            share[part] = np.inf
            low, high = _disks(region.take(part), part, table, over)
            below.append(low)
            above += [] if high is None else [high]
    for view, disks in ((region.below, below), (region.above, above)):
        _looked_up(view, disks, share)
    return share


def _looked_up(view: View, disks: list[_Disks], share: Reals) -> None:
    """Lower the shares to what is known of some disks, by one look at the table."""
    if not disks:
        return
    formula, _, base = _seen(view)
    places = [d.centres + (base[d.orbits] if np.ndim(base) else base) for d in disks]
    found = formula.clearance.radius(np.concatenate([x.ravel() for x in places]))
    ends = np.cumsum([x.size for x in places])
    for one, known in zip(disks, np.split(found, ends[:-1]), strict=True):
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
    with np.errstate(all="ignore"):
        if not region.turning:
            angle, spread = (over.low, over.spread) if table.slow == 1 else _moved(region.near_lower[:, None], over)
            offset = region.lower[:, None] + np.sign(region.momentum)[:, None] * angle
            return _Disks(orbits, offset, spread + 0.0 * np.real(offset)), None
        W = region.width[:, None]
        low, high, spread = _within(region, table, over)
        half = len(over.low) if table.symmetry == 2 else len(over.low) // 2
        lower = region.lower[:, None] + region.below.sign * W * low[:, :half]
        upper = region.upper[:, None] - region.above.sign * W * high[:, half:]
        if region.below is region.above:
            return _Disks(orbits, np.concatenate([lower, upper], axis=1), W * spread), None
        rest = _Disks(orbits, upper, W * spread[:, half:]) if half < len(over.low) else None
        return _Disks(orbits, lower, W * spread[:, :half]), rest


def _moved(m: Reals, over: CoveredStrip) -> tuple[Complexes, Reals]:
    """The middles and radii of rotations with two slow places."""
    angle, spread = moved_disks(over.low, over.near_low, m)
    return angle, np.where(reach(m) > over.tip, SAFETY * spread, np.inf)  # else q = ∞ lies in the strip


def _within(region: OrbitRegions, table: Nodes, over: CoveredStrip) -> tuple[Complexes, Complexes, Reals]:
    """(q − a)/W and (b − q)/W of the centres, and the radii over W."""
    if table.complement == 1.0:
        one = np.ones((len(region.width), 1))
        return over.low * one, over.high * one, over.spread * one
    d = region.near_lower[:, None]
    below = 1 + d * over.high
    low, high = over.low / below, (1 + d) * over.high / below
    spread = np.zeros(low.shape)
    for near_low, near_high in zip(over.near_low.T, over.near_high.T, strict=True):
        np.maximum(spread, np.abs(near_low / (1 + d * near_high) - low), out=spread)
    spread *= SAFETY
    return low, high, np.where(1 + d * over.tip > 0, spread, np.inf)  # else q = ∞ lies in the strip
