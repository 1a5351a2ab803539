"""The integrands of an open motion over disks of its parameter y about a place y₀: bounds, proof of analyticity.

p² is seen from where it has a zero or a pole, so that what is small keeps its relative accuracy: from the turning point
a at the start, p² = x G with x = |q − a|; from an end b, p² = ℓᵏ times a factor without zero, ℓ the distance left, k =
2 at an asymptote; or, with all care, from the place of the panel itself, p² = F₀ + F₁u + F₂(q)u² with F₀ and F₁ in many
digits (``arithmetic.local_expansion``). Every way is right; where several know something, the narrowest is taken.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single, tighter
from hjsolve.arithmetic.exponential_factor import EXPONENTIAL, Rates, largest
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.local_expansion import ZERO, LocalExpansion, Locals, exponential_unit
from hjsolve.arithmetic.number_types import Elementwise, Mask, Mpf
from hjsolve.arithmetic.reciprocals import without_overflow
from hjsolve.arithmetic.tape import BoundTape, Tape
from hjsolve.errors import InvalidInputError
from hjsolve.one_coordinate.chebyshev_panels import EndMap
from hjsolve.one_coordinate.momentum_squared import MomentumSquared
from hjsolve.one_coordinate.panel_images import (
    PanelSamples,
    RootBounds,
    Scale,
    largest_power,
    root_bounds,
    samples,
    scale_along,
)
from hjsolve.one_coordinate.panel_length import Sizes

_D = Disks()
_ONE = single(1.0, 0.0)
_FAR, _FARTHER = 100, 116
"""Distances from an end, 2^−…, at which the orders of what vanishes there are taken."""
_EXACT = 2048
"""Bits: at u = 2^−``_FARTHER`` powers up to u^16 cancel to 2⁻¹⁸⁵⁶, and leave digits enough to read an order."""
_HIGHEST = 64
"""Of the orders; what grows or falls faster is not a power."""
_AWAY = 16.0
"""Distance from the start, in natural lengths of at most 1, from which on a way to infinity is far out."""


Order = int | Literal["zero"] | None
"""Of a slot of a tape at a place: of a zero or a pole, that it is 0, or that nothing is known."""


@dataclass(frozen=True, eq=False)
class View:
    """The end of a branch, from which a formula is expanded: u is the distance to it, or 1/|q|, or e^{−c|q|}.

    Attributes:
        end_map: the branch.
        rate: −c·sign q where u is an exponential, else 0.
        length: u = length·r².
        orders: of all slots of p² and of the kernels.
    """

    end_map: EndMap
    rate: float
    length: float
    orders: tuple[list[Order], ...] = ()

    @property
    def _finish(self) -> Mpf:
        return self.end_map.start + self.end_map.side * self.end_map.length

    def samples(self) -> list[Mpf]:
        """Return q where u is 2^−``_FAR`` and 2^−``_FARTHER`` (of the length)."""
        context, end_map = Multi(_EXACT).context, self.end_map
        if end_map.end != "infinity":
            # two places 2¹⁶ apart: the ratio of values tells the order of a zero or a pole
            return [self._finish - end_map.side * end_map.length * context.mpf(2) ** -k for k in (_FAR, _FARTHER)]
        if self.rate:
            return [-k * context.log(2) / self.rate for k in (_FAR, _FARTHER)]
        return [end_map.side * context.mpf(2) ** k for k in (_FAR, _FARTHER)]

    def offset(self, q: Disk, root: Disk) -> Disk:
        """Return u.

        Args:
            q: disks of positions.
            root: disks of r.
        """
        if self.end_map.end != "infinity":
            return _D.times(_D.power(root, 2), self.length)
        return (
            _D.unary("exp", _D.times(q, self.rate)) if self.rate else _D.times(_D.inverse(q), float(self.end_map.side))
        )

    def variable(self, local: Locals) -> LocalExpansion:
        """Return q as it is seen.

        Args:
            local: the arithmetic in which it is used.
        """
        side = float(self.end_map.side)
        if self.end_map.end == "infinity":
            return local.exponent() if self.rate else local.inverse_variable(side)
        # an end at q = 0, but for rounding: q itself is then of first order in u
        centred = bool(abs(self._finish) < abs(self.end_map.length) * 2.0**-300)
        return local.variable(_D.point(self._finish), -side, centred=centred)

    def root(self, q: Disk, places: PanelSamples) -> RootBounds:
        """Return |r|, the root of |u|/length.

        Args:
            q: disks of positions.
            places: what else is known of them.
        """
        if self.end_map.end != "infinity":
            return root_bounds(places.root, places)
        with np.errstate(all="ignore"):
            if self.rate:
                middle, spread = self.rate * np.real(q.centre) / 2, abs(self.rate) * q.radius / 2
                return RootBounds(*(np.exp(middle + sign * spread) for sign in (-1, 0, 1)))
            return RootBounds(q.largest**-0.5, np.abs(q.centre) ** -0.5, q.least**-0.5)


@dataclass(frozen=True, eq=False)
class Sight:
    """A branch in doubles, made once for all of its panels.

    Attributes:
        end_map: the branch.
        radicand: p² and its kernels.
        skipped: kernels that are zero everywhere.
        bits: of the branch's numbers.
    """

    end_map: EndMap
    radicand: MomentumSquared
    skipped: tuple[bool, ...]
    bits: int

    @cached_property
    def scale(self) -> Scale:
        return scale_along(self.end_map)

    @cached_property
    def inputs(self) -> list[Disk]:
        """Constants and parameters."""
        return [_D.point(x) for x in self.radicand.inputs(128)]

    @cached_property
    def tapes(self) -> tuple[Tape, Tape]:
        """p² and its kernels."""
        return without_overflow(self.radicand.squared), without_overflow(self.radicand.kernels)

    @cached_property
    def plain(self) -> tuple[BoundTape, BoundTape]:
        """The same with all but q known."""
        squared, kernels = (tape.bind(_D, self.inputs) for tape in self.tapes)
        return squared, kernels

    @cached_property
    def exponential(self) -> bool:
        """True where a formula has exponentials."""
        return any(operation.code in EXPONENTIAL for tape in self.tapes for operation in tape.operations)

    @cached_property
    def start(self) -> Disk:
        return _D.point(self.end_map.start)

    @cached_property
    def finish(self) -> Disk:
        return _D.point(self.end_map.start + self.end_map.side * self.end_map.length)

    @cached_property
    def view(self) -> View | None:
        """The formulas expanded at the end of the branch; None where that is not known."""
        tapes, end_map = self.tapes, self.end_map
        if end_map.end == "kink":
            return None
        if end_map.end == "infinity":
            unit = exponential_unit(tapes, self.inputs)
            # exponentials with one common rate: u = e^(−c|q|), in which p² is a rational function
            view = View(end_map, -end_map.side * unit, 1.0)
        else:
            view = View(end_map, 0.0, float(end_map.length))
        inputs = self.radicand.inputs(_EXACT)
        squared, kernels = (_orders(tape, view.samples(), inputs) for tape in tapes)
        # kernels may be parameters, on which nothing operates
        if not squared or kernels is None or squared[-1] in {ZERO, None}:
            return None
        return replace(view, orders=(squared, kernels))

    def integrands(self, squared: Disk, weights: list[Disk], root: RootBounds, powers: list[int], order: int) -> Sizes:
        """Bound all integrands where |p²| (without x at a turning point) is ``squared``·rᵒ and a kernel is w·rᵖ.

        Args:
            squared: disks of |p²| without its power of r.
            weights: disks of the kernels without their powers of r.
            root: bounds on r.
            powers: exponents p of the kernels.
            order: o, the exponent of |p²|.
        """
        with np.errstate(all="ignore"):
            # √|p²| from below: 1/p is largest where p is least
            (low, middle, high), least, shape = root, np.sqrt(squared.least), np.shape(root.middle)
            centre = np.sqrt(np.abs(squared.centre))
            most, inside = [], []
            for w, power, skip in zip(weights, powers, self.skipped, strict=True):
                # exponents of r are added before it is bounded: r is small next to the end, and powers that cancel must
                # not be bounded apart
                k = self.scale.a + power - order // 2
                if skip:
                    most.append(0 * least)
                    inside.append(0 * least)
                    continue
                most.append(self.scale.rate * largest_power(low, high, k) * w.largest / least)
                inside.append(self.scale.rate * middle**k * np.abs(w.centre) / centre)
            # |p|/|dq/dy| times ``rest``: finite at the end by the choice of the map
            k = self.scale.b + order // 2
            most.append(self.scale.weighted_rate * largest_power(low, high, k) * np.sqrt(squared.largest))
            inside.append(self.scale.weighted_rate * middle**k * centre)
            known = squared.known & (least > 0)
            rows = [np.where(known & np.isfinite(row), row, np.inf) for row in most]
            both = rows, [np.nan_to_num(row, posinf=0.0) for row in inside]
            return Sizes(*(np.stack([np.broadcast_to(row, shape) for row in part]) for part in both))


def _orders(tape: Tape, places: list[Mpf], inputs: list[Mpf]) -> list[Order] | None:
    """Orders of all slots, from their values at two places 2^16 times apart; None where they are not found."""
    every = Tape(tape.inputs, tape.operations, tuple(range(len(tape.inputs), len(tape.inputs) + len(tape.operations))))
    try:
        far, near = (every.run(Multi(_EXACT), [q, *inputs]) for q in places)
    except (ArithmeticError, InvalidInputError, ValueError):
        return None
    found: list[Order] = []
    for a, b in zip(far, near, strict=True):
        if not a and not b:
            found.append(ZERO)
            continue
        # f ~ uᵏ: log₂ of the ratio over 16 is k; ½ stands for none
        ratio = float(a.context.log(abs(a / b), 2)) / (_FARTHER - _FAR) if a and b else 0.5
        is_whole = abs(ratio) < _HIGHEST and abs(ratio - round(ratio)) < 1e-9
        found.append(round(ratio) if is_whole else None)
    return found


@dataclass(frozen=True, eq=False)
class Surrounding:
    """What is around one place of a branch, called by ``panel_length.longest`` with disks of y − y₀.

    Attributes:
        sight: the branch.
        y, rest: y₀, and what is left from there to the greatest y.
    """

    sight: Sight
    y: Mpf
    rest: float

    def __call__(self, z: Disk, careful: bool) -> Sizes:
        with np.errstate(all="ignore"):
            return self._seen(z, careful)

    def _seen(self, z: Disk, careful: bool) -> Sizes:
        places = samples(self.sight.end_map, float(self.y), self.rest, z)
        sizes = self._plainly(places)
        for look in self._others(careful):
            bad = ~np.all(np.isfinite(sizes.most), axis=0)
            if not bad.any():
                break
            # costlier enclosures for the disks alone that the plain one left open
            more = look(_chosen(places, bad))
            for part, better in zip(sizes, more, strict=True):
                part[:, bad] = better
        return sizes

    def _others(self, careful: bool) -> list[Callable[[PanelSamples], Sizes]]:
        """Other enclosures of disks for which the plain formula gives no bound, those that apply here."""
        end_map = self.sight.end_map
        here: list[Callable[[PanelSamples], Sizes]] = []
        if end_map.end not in {"infinity", "kink"}:
            here.append(self._from_end)
        elif end_map.end == "infinity" and self._far:
            several = self.sight.exponential and not (self.sight.view and self.sight.view.rate)
            here += [self._by_rates] * several + [self._from_end]
        return here + [self._closely] * careful

    @property
    def _far(self) -> bool:
        """True far from the start, where a place is seen best from infinity."""
        x, end_map = self.sight.end_map.distances(self.y, Multi(64))[0], self.sight.end_map
        natural: Elementwise = max(abs(end_map.start), min(end_map.length, 1))
        return bool(x > _AWAY * natural and end_map.side * end_map.start > -x / 2)

    def _place(self, places: PanelSamples) -> Disk:
        """q, from the start or from the end of the branch."""
        sight, side = self.sight, float(self.sight.end_map.side)
        q = _D.add(sight.start, _D.times(places.x, side))
        if sight.end_map.end in {"infinity", "kink"}:
            return q
        left = _D.times(_D.power(places.root, 2), float(sight.end_map.length))
        return tighter(q, _D.sub(sight.finish, _D.times(left, side)))

    def _plainly(self, places: PanelSamples) -> Sizes:
        """p² by its formula, or by its first difference from the turning point at the start."""
        sight, q = self.sight, self._place(places)
        if sight.end_map.turning:
            offset = _with_base(places.x)
            local = Locals(offset, 1)
            variable = local.variable(sight.start, float(sight.end_map.side), q)
            found = sight.tapes[0].run(local, [variable, *map(local.constant, sight.inputs)])[0]
            # p²/x = F[a, q]: the quotient, or the divided difference itself where x may be 0
            squared = _D.div(_cells(found.parts[0]), places.x)
            if len(found.parts) > 1:
                squared = tighter(_cells(found.parts[1]), squared)
        else:
            squared = sight.plain[0].run(q)[0]
        return self._plain_sizes(squared, q, places)

    def _plain_sizes(self, squared: Disk, q: Disk, places: PanelSamples) -> Sizes:
        weights = self.sight.plain[1].run(q)
        return self.sight.integrands(squared, weights, root_bounds(places.root, places), [0] * len(weights), 0)

    def _closely(self, places: PanelSamples) -> Sizes:
        """p² from the place of the panel, where its value and slope are known to many digits."""
        sight, end_map = self.sight, self.sight.end_map
        here = end_map.position(self.y, Multi(sight.bits + 64))[0] if self.y else end_map.start
        # F₀ and F₁ to twice the digits: next to a near zero of p² they are all that is left of it
        value, slope, _ = sight.radicand.jet(here, 2 * sight.bits + 256)
        local = Locals(_with_base(places.moved), 2)
        variable = local.variable(_D.point(here), float(end_map.side), self._place(places))
        found = sight.tapes[0].run(local, [variable, *map(local.constant, sight.inputs)])[0]
        if len(found.parts) < 3:
            return self._plainly(places)
        if self.y:
            start = [_D.point(value), _D.point(end_map.side * slope)]
        else:
            # at the turning point F₀ is 0 exactly, whatever rounding has left
            start = [_D.point(0 * value if end_map.turning else value), _D.point(end_map.side * slope)]
        bend = _D.mul(places.moved, _cells(found.parts[2]))
        squared = _D.add(start[0], _D.mul(places.moved, _D.add(start[1], bend)))
        if end_map.turning:
            squared = _D.add(start[1], bend) if not self.y else _D.div(squared, places.x)
        return self._plain_sizes(squared, self._place(places), places)

    def _from_end(self, places: PanelSamples) -> Sizes:
        """p² and the kernels from the end of the branch, what vanishes or has a pole there taken out."""
        sight, end_map = self.sight, self.sight.end_map
        view = sight.view
        if view is None:
            return _nothing(places.moved, len(sight.skipped))
        q = self._place(places)
        offset = view.offset(q, places.root)
        outputs = []
        for tape, orders in zip(sight.tapes, view.orders, strict=True):
            local = Locals(_with_base(offset), 2, orders, rate=view.rate, q=_with_base(q))
            outputs.append(tape.run(local, [view.variable(local), *map(local.constant, sight.inputs)]))
        squared, *weights = (
            (int(f.order), _D.times(_full(_cells(f.parts[0]), offset), view.length**f.order))
            for f in (*outputs[0], *outputs[1])
        )
        # the root of x that p² has at the turning point goes with the map there
        factor = _D.div(squared[1], places.x) if end_map.turning else squared[1]
        powers = [2 * order for order, _ in weights]
        return sight.integrands(factor, [w for _, w in weights], view.root(q, places), powers, 2 * squared[0])

    def _by_rates(self, places: PanelSamples) -> Sizes:
        """Return the formulas with their exponentials taken out."""
        sight, q = self.sight, self._place(places)
        rates = Rates.over(q, sight.end_map.side)
        inputs = [rates.exponent(), *map(rates.constant, sight.inputs)]
        squared, *weights = (f for tape in sight.tapes for f in tape.run(rates, inputs))
        factor = _full(squared.parts[0], q)
        factor = _D.div(factor, places.x) if sight.end_map.turning else factor
        root = root_bounds(_ONE, places)
        sizes = sight.integrands(factor, [w.parts[0] for w in weights], root, [0] * len(weights), 0)
        half = squared.order / 2
        growths = [rates.rate * order for order in (*(w.order - half for w in weights), half)]
        # the exponent of all factors together, bounded once: e^{λq} of each alone would overflow
        most = [row * np.exp(largest(q, rate)) for row, rate in zip(sizes.most, growths, strict=True)]
        inside = [row * np.exp(rate * np.real(q.centre)) for row, rate in zip(sizes.inside, growths, strict=True)]
        return Sizes(np.where(np.isfinite(most), most, np.inf), np.nan_to_num(inside, posinf=0.0))


def _with_base(x: Disk) -> Disk:
    """Return the disks with 0 before them."""
    return Disk(np.concatenate([[0.0], np.ravel(x.centre)]), np.concatenate([[0.0], np.ravel(x.radius)]))


def _cells(x: Disk) -> Disk:
    """Return the disks without that of the base; a constant stays as it is."""
    return Disk(x.centre[1:], x.radius[1:]) if np.ndim(x.radius) else x


def _full(x: Disk, like: Disk) -> Disk:
    shape = np.shape(like.radius)
    return Disk(np.broadcast_to(x.centre, shape), np.broadcast_to(x.radius, shape))


def _nothing(like: Disk, kernels: int) -> Sizes:
    shape = (kernels + 1, *np.shape(like.radius))
    return Sizes(np.full(shape, np.inf), np.zeros(shape))


def _chosen(places: PanelSamples, which: Mask) -> PanelSamples:
    """Return some of the places."""
    return PanelSamples(*(Disk(x.centre[which], x.radius[which]) if np.ndim(x.radius) else x for x in places))
