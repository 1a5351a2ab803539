"""The arcs of a motion through umbilics, and where on its arc it is at a time.

On an arc xᵢ goes from one end of its path to the other, dᵢ = ±1, and Jacobi's equations are

    d₁ L₁(x₁) + d₂ L₂(x₂) = D,        t = τ + d₁ T₁(x₁) + d₂ T₂(x₂).

Near an umbilic, in y = (√M₁₁ δ₁, √M₂₂ δ₂)/√h, places are functions of the square (y₁ + i y₂)², as in conformal
coordinates. A motion goes straight on through the origin of the square, so that y₁ + i y₂ turns by a right angle: what
leaves has y₂ : y₁ as what came had y₁ : y₂. With εᵢ = 1 − |xᵢ| → 0 and d₁L₁ = −c ln ε₁ + d₁K₁, d₂L₂ = c ln ε₂ + d₂K₂
this turns d into −d and D into D − 2 Σ dᵢKᵢ + 2 c ν, where y₂/y₁ = e^ν ε₂/ε₁ (Hart 1849, that the tangents of the half
angles at one umbilic form a geometric progression, is the special case of geodesics on an ellipsoid).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError, required
from hjsolve.motion.through_umbilics.paths import Path

_MOST_ARCS = 100_000  # of one motion, kept one by one
_NEWTON_STEPS = 200  # each at most three in z
_LONGEST = 3
"""Of a step of z."""


@dataclass(frozen=True)
class UmbilicArc:
    """From one umbilic to the next.

    Attributes:
        directions: d₁, d₂; of a coordinate that rests, the end of its path at which it does.
        level: D; None where a coordinate rests.
        offset: τ.
        rest: the coordinate that stays at its double zero, None where both move.
    """

    directions: tuple[int, int]
    level: Mpf | None
    offset: Mpf
    rest: int | None = None

    def ends(self, paths: tuple[Path, Path]) -> tuple[Mpf, Mpf]:
        """Return the times at which it leaves an umbilic and reaches the next."""
        moving = [(p, d) for k, (p, d) in enumerate(zip(paths, self.directions, strict=True)) if k != self.rest]
        one = self.offset.context.mpf(1)
        # xᵢ = dᵢ at the end and −dᵢ at the beginning; Tᵢ is finite there, Lᵢ is not
        begin, end = (self.offset + sum(d * p.time(side * d * one) for p, d in moving) for side in (-1, 1))
        return begin, end

    def sides(self, direction: int) -> tuple[int, int]:
        """Return the ends of both paths at which an end of the arc is.

        Args:
            direction: 1 for where it goes, −1 for where it comes from.
        """
        one, two = (d if k == self.rest else direction * d for k, d in enumerate(self.directions))
        return one, two

    def turned(self, rest: int | None) -> tuple[int, int]:
        """Return the directions with those of moving coordinates changed.

        Args:
            rest: the coordinate that does not move.
        """
        one, two = (d if k == rest else -d for k, d in enumerate(self.directions))
        return one, two


@dataclass(frozen=True)
class Corner:
    """An umbilic at the end of an arc.

    Attributes:
        passable: whether the motion goes on there.
        ratio: ν of y₂/y₁ = e^ν ε₂/ε₁.
    """

    passable: bool
    ratio: Mpf


Corners = Callable[[tuple[int, int]], Corner]
"""The umbilic at the ends of both paths, 1 or −1."""


def following(arc: UmbilicArc, paths: tuple[Path, Path], corner: Corner) -> UmbilicArc:
    """Return the arc after an umbilic.

    Args:
        arc: that ends there.
        corner: the umbilic.
    """
    d, rest = arc.directions, None if arc.rest is None else 1 - arc.rest
    turned = arc.turned(rest)
    _, end = arc.ends(paths)
    # τ of the new arc makes it begin when the old one ends
    begin = UmbilicArc(turned, None, 0 * end, rest).ends(paths)[0]
    if arc.level is None:
        return UmbilicArc(turned, None, end - begin, rest)
    c = paths[0].residues[d[0] > 0]
    # D ← D − 2 Σ dᵢKᵢ + 2 c ν, with d₁, d₂ before they turn (head of this file)
    level = arc.level - 2 * sum(k * p.constant(k) for k, p in zip(d, paths, strict=True)) + 2 * c * corner.ratio
    return UmbilicArc(turned, level, end - begin)


def reversed_arc(arc: UmbilicArc) -> UmbilicArc:
    """Return the same arc in the other direction of time."""
    return UmbilicArc(arc.turned(arc.rest), None if arc.level is None else -arc.level, -arc.offset, arc.rest)


def leaving(
    paths: tuple[Path, Path], directions: tuple[int, int], corner: Corner, slope: Mpf | None, rest: int | None, t: Mpf
) -> UmbilicArc:
    """Return the arc that leaves an umbilic in a given direction.

    Args:
        directions: d₁, d₂.
        corner: the umbilic.
        slope: ln(y₂/y₁); None where a coordinate rests.
        t: the time.
    """
    level = None
    if slope is not None:
        # D = Σ dᵢLᵢ with ln(ε₂/ε₁) = ln(y₂/y₁) − ν
        c = paths[0].residues[directions[0] < 0]
        level = sum(d * p.constant(-d) for d, p in zip(directions, paths, strict=True)) - c * (slope - corner.ratio)
    arc = UmbilicArc(directions, level, 0 * t, rest)
    return UmbilicArc(directions, level, t - arc.ends(paths)[0], rest)


def places_on(arc: UmbilicArc, paths: tuple[Path, Path], t: Mpf) -> tuple[Mpf | None, Mpf | None]:
    """Return z₁, z₂ of xᵢ = tanh zᵢ at a time on an arc; None for a coordinate that rests.

    Both equations are nearly linear in z far from the middle, the second one in the logarithm of the time that is left,
    or that has passed: Newton's method, with steps of three at most, and half of that each time it turns back.

    Args:
        arc: on which the motion is.
        t: a time after its beginning and before its end.

    Raises:
        NotConvergedError: Newton's method does not come to its end.
    """
    begin, end = arc.ends(paths)
    # the time left keeps its digits only towards the nearer end
    side = 1 if t - begin > end - t else -1  # towards the end that is nearer
    goal = abs((end if side > 0 else begin) - t)
    search = _Search(arc, paths, side, goal)
    return search.alone() if arc.rest is not None else search.both()


@dataclass(frozen=True)
class _Search:
    arc: UmbilicArc
    paths: tuple[Path, Path]
    side: int
    goal: Mpf

    def _clock(self, k: int, z: Mpf) -> tuple[Mpf, Mpf, Mpf, Mpf]:
        """Time left, its slope, level and its slope of one coordinate, slopes by z."""
        path, d, c = self.paths[k], self.arc.directions[k], z.context
        x, width = c.tanh(z), c.sech(z) ** 2
        time, level = path.rates(z, x)
        left = self.side * d * (path.time(c.mpf(self.side * d)) - path.time(x))
        return left, -self.side * d * time * width, d * path.level(z, x), d * level * width

    def alone(self) -> tuple[Mpf | None, Mpf | None]:
        """Return a coordinate that moves while the other one rests."""
        k, c = 1 - int(self.arc.rest or 0), self.goal.context

        def step(z: list[Mpf]) -> list[Mpf]:
            left, slope, *_ = self._clock(k, z[0])
            # ln of the time left is linear in z next to the end: for the time itself steps would be half a unit of z
            return [-c.log(left / self.goal) * left / slope]

        (z,) = self._found(step, [0 * self.goal], self.paths[k].bits)
        return (z, None) if k == 0 else (None, z)

    def both(self) -> tuple[Mpf, Mpf]:
        """Both coordinates, from the place on the level where the logarithms alone would have them half way."""
        c, d, D = self.goal.context, self.arc.directions, required(self.arc.level)

        def step(z: list[Mpf]) -> list[Mpf]:
            rows = [self._clock(k, z[k]) for k in (0, 1)]
            left, level = rows[0][0] + rows[1][0], rows[0][2] + rows[1][2] - D
            off, (p, q), (a, b) = c.log(left / self.goal), (r[1] / left for r in rows), (r[3] for r in rows)
            # Cramer's rule for D (slopes a, b) and ln(time left) (slopes p, q)
            turn = a * q - b * p
            return [(b * off - q * level) / turn, (p * level - a * off) / turn]

        # far out d₁L₁ ≈ 2c z₁ and d₂L₂ ≈ −2c z₂ (ε = 2e^−2z): half of D to each of them
        own = D / (4 * self.paths[0].residues[d[0] > 0])
        one, two = self._found(step, [d[0] * own, -d[1] * own], self.paths[0].bits)
        return one, two

    def _found(self, step: Callable[[list[Mpf]], list[Mpf]], z: list[Mpf], bits: int) -> list[Mpf]:
        """Newton's method for one or both; the longest step is halved when steps turn back."""
        longest, last = self.goal.context.mpf(_LONGEST), [0 * v for v in z]
        for _ in range(_NEWTON_STEPS):
            change = step(z)
            size = max(abs(s) for s in change)
            # a step back over the last one says that the longest was too long; without it two places can alternate
            if sum(s * t for s, t in zip(change, last, strict=True)) < 0:
                longest /= 2
            last = [s * min(1, longest / size) if size else s for s in change]
            z = [v + s for v, s in zip(z, last, strict=True)]
            if size <= self.goal.context.ldexp(1, -bits // 3):
                return z
        raise NotConvergedError(
            "a place between two umbilics could not be found; ask for a time a little earlier or later"
        )


class Arcs:
    """All arcs of a motion, worked out as far as they are asked for.

    Args:
        first: the arc on which it starts.
        paths: of both coordinates.
        corners: the rule that gives the umbilics.
    """

    def __init__(self, first: UmbilicArc, paths: tuple[Path, Path], corners: Corners):
        self.paths, self.corners = paths, corners
        self.met: dict[tuple[int, int], Corner] = {}
        self.known = {1: [first], -1: [reversed_arc(first)]}

    def longest(self) -> Mpf:
        """Return the duration of the first arc."""
        begin, end = self.known[1][0].ends(self.paths)
        return end - begin

    def smallest(self, t: Mpf) -> Mpf:
        """Return a time that is nothing beside another one."""
        return t.context.ldexp(1 + abs(t), -self.paths[0].bits // 3)

    def at(self, t: Mpf) -> tuple[int, UmbilicArc] | None:
        """Return the number of the arc that holds a time, counted from the first, and the arc; None where it has ended.

        Raises:
            NotConvergedError: there are too many arcs before.
        """
        begin, end = self.known[1][0].ends(self.paths)
        if begin <= t <= end:
            return 0, self.known[1][0]
        direction = 1 if t > end else -1
        arcs, k = self.known[direction], 0
        while direction * t > arcs[k].ends(self.paths)[1]:
            corner = self._corner(arcs[k].directions)
            if not corner.passable:
                return None
            if k + 1 == len(arcs):
                if k >= _MOST_ARCS:
                    raise NotConvergedError(f"t: more than {_MOST_ARCS} passages of umbilics before that time")
                arcs.append(following(arcs[k], self.paths, corner))
            k += 1
        return direction * k, arcs[k] if direction > 0 else reversed_arc(arcs[k])

    def _corner(self, sides: tuple[int, int]) -> Corner:
        if sides not in self.met:
            self.met[sides] = self.corners(sides)
        return self.met[sides]
