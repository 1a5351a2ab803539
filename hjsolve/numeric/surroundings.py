"""The integrands of an open motion over disks of its parameter y about a place y₀: bounds, and proof that they are analytic.

p² is seen from where it has a zero or a pole, so that what is small keeps its relative accuracy: from the turning point
a at the start, p² = x G with x = |q − a|; from an end b, p² = ℓᵏ times a factor without zero, ℓ the distance left, k = 2
at an asymptote; or, with all care, from the place of the panel itself, p² = F₀ + F₁u + F₂(q)u² with F₀ and F₁ in many
digits (``numeric.expansion``). Every way is right; where several know something, the narrowest is taken.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hjsolve.errors import InvalidInputError
from hjsolve.numeric.arithmetic import Multi
from hjsolve.numeric.disks import Disk, Disks, tighter
from hjsolve.numeric.expansion import ZERO, Local, Locals
from hjsolve.numeric.panels import Way
from hjsolve.numeric.rates import EXPONENTIAL, Rates, largest
from hjsolve.numeric.reach import Sizes
from hjsolve.numeric.tape import Bound, Tape

if TYPE_CHECKING:
    from hjsolve.numeric.radicand import Radicand

_D = Disks()
_ONE = Disk(np.complex128(1.0), np.float64(0.0))
_FAR, _FARTHER = 100, 116
"""Distances from an end, 2^−…, at which the orders of what vanishes there are taken."""
_EXACT = 2048
_HIGHEST = 16
"""Of the orders; what grows or falls faster is no power."""
_AWAY = 16.0
"""Distance from the start, in natural lengths, from which on a way to infinity is far out."""


class Scale(NamedTuple):
    """|dx/dy| = rate·rᵃ and what the momentum is divided by, pace·rᵇ, r being the root of the share of the way left.

    At a turning point both stand without the root of x that p² brings.
    """

    rate: float
    a: int
    pace: float
    b: int


def scale(way: Way) -> Scale:
    """Return how dx/dy goes along a way; see ``Way.distances`` and ``Way.rest``."""
    length = float(way.length)
    root = length**0.5
    match way.end, way.turning:
        case "infinity", turning:
            return Scale(2 * root, 0, 1 / (2 * root), 0) if turning else Scale(length, 0, 1 / length, 0)
        case "boundary", turning:
            return Scale(root, 1, 1 / root, way.pole) if turning else Scale(2 * length, 1, 1 / (2 * length), way.pole)
        case end, turning:
            b = way.pole if end == "fall" else -2
            return Scale(2 * root, 2, 1 / (2 * root), b) if turning else Scale(length, 2, 1 / length, b)


class Spots(NamedTuple):
    """Where disks of y lie: x, r, and q − q(y₀) times the side; r is 1 on the way to infinity."""

    x: Disk
    root: Disk
    moved: Disk


def spots(way: Way, y: float, rest: float, z: Disk) -> Spots:
    """Map disks of z = y − y₀.

    Args:
        way: the branch.
        y: y₀. rest: what is left from y₀ to the greatest y, if there is one.
        z: the disks.
    """
    d, length = _D, float(way.length)
    here = d.shifted(z, y)
    if way.end == "infinity":
        if way.turning:
            return Spots(d.times(d.power(here, 2), length), _ONE, d.times(d.mul(z, d.shifted(z, 2 * y)), length))
        return Spots(d.times(here, length), _ONE, d.times(z, length))
    if way.end == "boundary":
        left = d.shifted(d.times(z, -1.0), rest)
        if way.turning:
            half, sine, root = d.times(z, 0.5), d.unary("sin", d.times(here, 0.5)), d.unary("sin", d.times(left, 0.5))
            moved = d.mul(d.unary("sin", half), d.unary("sin", d.shifted(half, y)))
            return Spots(d.times(d.power(sine, 2), length), root, d.times(moved, length))
        x = d.mul(here, d.shifted(left, 1.0))
        return Spots(d.times(x, length), left, d.times(d.mul(z, d.shifted(left, rest)), length))
    if way.turning:
        rise, root = d.unary("tanh", here), d.inverse(d.unary("cosh", here))
        before = np.tanh(y) ** 2
        x = d.power(rise, 2)
        moved = d.sub(x, Disk(np.complex128(before), np.float64(2.0**-50 * before)))
        return Spots(d.times(x, length), root, d.times(moved, length))
    root = d.unary("exp", d.times(here, -0.5))
    moved = d.mul(d.unary("exp", Disk(np.complex128(-y), np.float64(0))), d.sub(_ONE, d.unary("exp", d.times(z, -1.0))))
    return Spots(d.times(d.sub(_ONE, d.power(root, 2)), length), root, d.times(moved, length))


@dataclass(frozen=True, eq=False)
class Sight:
    """A branch in doubles, made once for all of its panels.

    Attributes:
        way: the branch. radicand: p² and its kernels. skipped: kernels that are zero everywhere.
        bits: of the branch's numbers.
    """

    way: Way
    radicand: Radicand
    skipped: tuple[bool, ...]
    bits: int

    @cached_property
    def scale(self) -> Scale:
        return scale(self.way)

    @cached_property
    def inputs(self) -> list[Disk]:
        """Constants and parameters."""
        return [_D.point(x) for x in self.radicand.inputs(128)]

    @cached_property
    def squared(self) -> Bound:
        return self.radicand.squared.bind(_D, self.inputs)

    @cached_property
    def kernels(self) -> Bound:
        return self.radicand.kernels.bind(_D, self.inputs)

    @cached_property
    def exponential(self) -> bool:
        """True where a formula has exponentials."""
        tapes = (self.radicand.squared, self.radicand.kernels)
        return any(operation.code in EXPONENTIAL for tape in tapes for operation in tape.operations)

    @cached_property
    def start(self) -> Disk:
        return _D.point(self.way.start)

    @cached_property
    def finish(self) -> Any:
        """Where the way ends, in many digits."""
        return self.way.start + self.way.side * self.way.length

    @cached_property
    def centred(self) -> bool:
        """True where it ends at 0."""
        return bool(abs(self.finish) < abs(self.way.length) * 2.0**-300)

    @cached_property
    def orders(self) -> tuple[list[Any], list[Any]]:
        """Orders of all slots of p² and of the kernels at the end of the way; see ``expansion.Locals``."""
        inputs, length = self.radicand.inputs(_EXACT), abs(self.way.length)
        if self.way.end == "infinity":
            q = [self.way.side * Multi(_EXACT).context.mpf(2) ** k for k in (_FAR, _FARTHER)]
        else:
            q = [self.finish - self.way.side * length * Multi(_EXACT).context.mpf(2) ** -k for k in (_FAR, _FARTHER)]
        return tuple(_orders(tape, q, inputs) for tape in (self.radicand.squared, self.radicand.kernels))

    def integrands(self, squared: Disk, weights: list[Disk], places: Spots, powers: list[int], order: int) -> Sizes:
        """Bound all integrands where |p²| (without x at a turning point) is ``squared``·rᵒ and a kernel is w·rᵖ."""
        r, shape = places.root, np.shape(places.moved.radius)
        with np.errstate(all="ignore"):
            low, high, least = r.least, r.largest, np.sqrt(squared.least)
            middle, centre = np.abs(r.centre), np.sqrt(np.abs(squared.centre))
            most, inside = [], []
            for w, power, skip in zip(weights, powers, self.skipped, strict=True):
                k = self.scale.a + power - order // 2
                if skip:
                    most.append(0 * least)
                    inside.append(0 * least)
                    continue
                most.append(self.scale.rate * _power(low, high, k) * w.largest / least)
                inside.append(self.scale.rate * middle**k * np.abs(w.centre) / centre)
            k = self.scale.b + order // 2
            most.append(self.scale.pace * _power(low, high, k) * np.sqrt(squared.largest))
            inside.append(self.scale.pace * middle**k * centre)
            known = squared.known & (least > 0)
            rows = [np.where(known & np.isfinite(row), row, np.inf) for row in most]
            return Sizes(*(np.stack([np.broadcast_to(row, shape) for row in part]) for part in (rows, _numbers(inside))))


def _numbers(rows: list[Any]) -> list[Any]:
    return [np.nan_to_num(row, posinf=0.0) for row in rows]


def _power(low: Any, high: Any, k: int) -> Any:
    """The largest |r|ᵏ; infinite where r may be 0 and k is negative."""
    return high**k if k >= 0 else 1 / low**-k


def _orders(tape: Tape, places: list[Any], inputs: list[Any]) -> list[Any]:
    """Orders of all slots, from their values at two places 2^16 times apart; empty where they cannot be had."""
    every = Tape(tape.inputs, tape.operations, tuple(range(len(tape.inputs), len(tape.inputs) + len(tape.operations))))
    try:
        far, near = (every.run(Multi(_EXACT), [q, *inputs]) for q in places)
    except (ArithmeticError, InvalidInputError, ValueError):
        return []
    found: list[Any] = []
    for a, b in zip(far, near, strict=True):
        if not a and not b:
            found.append(ZERO)
            continue
        ratio = float(a.context.log(abs(a / b), 2)) / (_FARTHER - _FAR) if a and b else 0.5
        told = abs(ratio) < _HIGHEST and abs(ratio - round(ratio)) < 1e-9
        found.append(round(ratio) if told else None)
    return found


@dataclass(frozen=True, eq=False)
class Surrounding:
    """What is around one place of a branch, called by ``reach.longest`` with disks of y − y₀.

    Attributes:
        sight: the branch.
        y, rest: y₀, and what is left from there to the greatest y.
    """

    sight: Sight
    y: Any
    rest: float

    def __call__(self, z: Disk, careful: bool) -> Sizes:
        places = spots(self.sight.way, float(self.y), self.rest, z)
        sizes = self._plainly(places)
        for look in self._others(careful):
            bad = ~np.all(np.isfinite(sizes.most), axis=0)
            if not bad.any():
                break
            more = look(_chosen(places, bad))
            for part, better in zip(sizes, more, strict=True):
                part[:, bad] = better
        return sizes

    def _others(self, careful: bool) -> list[Callable[[Spots], Sizes]]:
        """Other ways to look at disks about which the plain formula knows nothing, those that apply here."""
        way, here = self.sight.way, []
        if way.end != "infinity":
            here.append(self._from_end)
        elif self._far:
            here += [self._by_rates] * self.sight.exponential + [self._from_end]
        return here + [self._closely] * careful

    @property
    def _far(self) -> bool:
        """True far from the start, where a place is seen best from infinity."""
        x, way = self.sight.way.distances(self.y, Multi(64))[0], self.sight.way
        return bool(x > _AWAY * way.length and way.side * (way.start + way.side * x) > x / 2)

    def _place(self, x: Disk) -> Disk:
        return _D.add(self.sight.start, _D.times(x, float(self.sight.way.side)))

    def _plainly(self, places: Spots) -> Sizes:
        """p² by its formula, or by its first difference from the turning point at the start."""
        sight, q = self.sight, self._place(places.x)
        if sight.way.turning:
            offset = _with_base(places.x)
            local = Locals(offset, 1)
            variable = local.variable(sight.start, float(sight.way.side))
            found = sight.radicand.squared.run(local, [variable, *map(local.constant, sight.inputs)])[0]
            squared = _D.div(_cells(found.parts[0]), places.x)
            if len(found.parts) > 1:
                squared = tighter(_cells(found.parts[1]), squared)
        else:
            squared = sight.squared.run(q)[0]
        return self._plain_sizes(squared, q, places)

    def _plain_sizes(self, squared: Disk, q: Disk, places: Spots) -> Sizes:
        weights = self.sight.kernels.run(q)
        return self.sight.integrands(squared, weights, places, [0] * len(weights), 0)

    def _closely(self, places: Spots) -> Sizes:
        """p² from the place of the panel, where its value and slope are had in many digits."""
        sight, way = self.sight, self.sight.way
        here = way.position(self.y, Multi(sight.bits + 64))[0] if self.y else way.start
        value, slope, _ = sight.radicand.jet(here, 2 * sight.bits + 256)
        local = Locals(_with_base(places.moved), 2)
        variable = local.variable(_D.point(here), float(way.side))
        found = sight.radicand.squared.run(local, [variable, *map(local.constant, sight.inputs)])[0]
        if len(found.parts) < 3:
            return self._plainly(places)
        if self.y:
            start = [_D.point(value), _D.point(way.side * slope)]
        else:
            start = [_D.point(0 * value if way.turning else value), _D.point(way.side * slope)]
        bend = _D.mul(places.moved, _cells(found.parts[2]))
        squared = _D.add(start[0], _D.mul(places.moved, _D.add(start[1], bend)))
        if way.turning:
            squared = _D.add(start[1], bend) if not self.y else _D.div(squared, places.x)
        return self._plain_sizes(squared, self._place(places.x), places)

    def _from_end(self, places: Spots) -> Sizes:
        """p² and the kernels from the end of the way, what vanishes or has a pole there taken out."""
        sight, way = self.sight, self.sight.way
        orders, endless = sight.orders, way.end == "infinity"
        if not orders[0] or orders[0][-1] in (ZERO, None) or not orders[1]:
            return _nothing(places.moved, len(sight.skipped))
        if endless:
            left = _D.times(_D.inverse(self._place(places.x)), float(way.side))
        else:
            left = _D.times(_D.power(places.root, 2), float(way.length))
        outputs = []
        for tape, told in zip((sight.radicand.squared, sight.radicand.kernels), orders, strict=True):
            local = Locals(_with_base(left), 2, told)
            outputs.append(tape.run(local, [self._to_end(local), *map(local.constant, sight.inputs)]))
        squared, weights = outputs[0][0], outputs[1]
        factor, others = self._taken_out(squared, left), [self._taken_out(w, left) for w in weights]
        if way.turning:
            factor = _D.div(factor, places.x)
        if endless:
            return sight.integrands(factor, others, places, [0] * len(others), 0)
        return sight.integrands(factor, others, places, [2 * w.order for w in weights], 2 * squared.order)

    def _to_end(self, local: Locals) -> Local:
        side = float(self.sight.way.side)
        if self.sight.way.end == "infinity":
            return local.inverse_variable(side)
        return local.variable(_D.point(self.sight.finish), -side, centred=self.sight.centred)

    def _taken_out(self, f: Local, left: Disk) -> Disk:
        """f over the power of r in it; far out, where r is 1, f itself."""
        cells = _full(_cells(f.parts[0]), left)
        if self.sight.way.end == "infinity":
            return _D.mul(cells, _D.power(left, f.order)) if f.order else cells
        return _D.times(cells, float(self.sight.way.length) ** f.order)

    def _by_rates(self, places: Spots) -> Sizes:
        """The formulas with their exponentials taken out."""
        sight, q = self.sight, self._place(places.x)
        rates = Rates(q, sight.way.side)
        inputs = [rates.variable(), *map(rates.constant, sight.inputs)]
        squared = sight.radicand.squared.run(rates, inputs)[0]
        weights = sight.radicand.kernels.run(rates, inputs)
        factor = _full(squared.value, q)
        if sight.way.turning:
            factor = _D.div(factor, places.x)
        sizes = sight.integrands(factor, [w.value for w in weights], places, [0] * len(weights), 0)
        growths = [*(w.rate - squared.rate / 2 for w in weights), squared.rate / 2]
        with np.errstate(all="ignore"):
            most = [row * np.exp(largest(q, rate)) for row, rate in zip(sizes.most, growths, strict=True)]
            inside = [row * np.exp(rate * np.real(q.centre)) for row, rate in zip(sizes.inside, growths, strict=True)]
        return Sizes(np.where(np.isfinite(most), most, np.inf), np.nan_to_num(inside, posinf=0.0))


def _with_base(x: Disk) -> Disk:
    """The disks with 0 before them."""
    return Disk(np.concatenate([[0.0], np.ravel(x.centre)]), np.concatenate([[0.0], np.ravel(x.radius)]))


def _cells(x: Disk) -> Disk:
    """The disks without that of the base; a constant stays as it is."""
    return Disk(x.centre[1:], x.radius[1:]) if np.ndim(x.radius) else x


def _full(x: Disk, like: Disk) -> Disk:
    shape = np.shape(like.radius)
    return Disk(np.broadcast_to(x.centre, shape), np.broadcast_to(x.radius, shape))


def _nothing(like: Disk, kernels: int) -> Sizes:
    shape = (kernels + 1, *np.shape(like.radius))
    return Sizes(np.full(shape, np.inf), np.zeros(shape))


def _chosen(places: Spots, which: Any) -> Spots:
    """Some of the places."""
    return Spots(*(Disk(x.centre[which], x.radius[which]) if np.ndim(x.radius) else x for x in places))
