"""The curve H(q, p) = E of one degree of freedom, followed in pieces; time and action by quadrature along it.

On each piece one of q and p is the parameter x and the other is solved for, y(x): a branch of H = E. A piece is kept
only where a disk of the complex x-plane, twice as wide as it, is proved to hold one root y in a disk of its own, by
Newton's operator (Krawczyk 1969; Rump, Acta Numerica 19 (2010) 287, § 13):

    (R |H_x| + |H − E|)/|H_y| ≤ S     over |x − c| ≤ R, |y − y_c| ≤ S.

So y is analytic in the disk, no other branch comes near and no feature of H hides on the piece. Gauss–Legendre
quadrature of f with |f| ≤ M on n nodes is then wrong by no more than (64/15) r M ρ^(−2n)/(1 − ρ^(−2)), ρ = 2 + √3
(Trefethen, Approximation Theory and Approximation Practice, theorem 19.3). With dq/dt = H_p, dp/dt = −H_q the time is
t = ∫ dq/H_p on a piece along q, −∫ dp/H_q on one along p: at a turning point p is the parameter, nothing is singular.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import accumulate
from math import ceil, log

import numpy as np

from hjsolve.arithmetic.complex_disks import Disk, Disks, single
from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import bisected, newton
from hjsolve.arithmetic.tape import BoundTape, Tape
from hjsolve.errors import NotConvergedError, required

_RHO, _WIDER = 2 + 3**0.5, 2.1  # semiaxes 2 and √3: in a disk of twice the radius, with room for rounding
_MOST_PIECES, _FIRST_HALVINGS, _LATER_HALVINGS = 400, 600, 60
"""Pieces of a curve; halvings of a piece before the scale of the curve is known, and after."""
_LAST_BITS, _LOST_BITS = 8, 60
"""Bits of y that the last step may change, and that rounding may take where steps do not become smaller."""
_GUARD_DIGITS, _SHORTEST_PIECE = 8, 2.0**-80
"""Decimal digits to spare in the quadratures; a piece over the longest one, below which a place of rest is near."""


@dataclass(frozen=True)
class Piece:
    """A part of the curve along which one of q and p grows or falls steadily.

    Attributes:
        along: 0 where q is the parameter x, 1 where p is.
        begin, end: x at both ends, in the order of time.
        first: y at the beginning.
        middle, room: y at the middle of the disk of x, in doubles, and the radius within which there is no other root.
        nodes: of the quadratures.
        time, action: ∫ dt and ∫ p dq.
        time_error, action_error: bounds.
    """

    along: int
    begin: Mpf
    end: Mpf
    first: Mpf
    middle: float
    room: float
    nodes: int
    time: Mpf | int = 0
    action: Mpf | int = 0
    time_error: float = 0.0
    action_error: float = 0.0

    def passes(self, point: tuple[Mpf, Mpf]) -> bool:
        """Return True where a point of the curve lies on the piece, its beginning left out.

        Args:
            point: (q, p).
        """
        x, y = point[self.along], point[1 - self.along]
        fraction = (x - self.begin) / (self.end - self.begin)
        return bool(0 < fraction <= 1 and abs(y - self.middle) < self.room)


@dataclass(frozen=True, eq=False)
class Curve:
    """H(q, p) = E.

    In its methods ``along`` is 0 where q is the parameter x, and 1 where p is.

    Attributes:
        tape: of H, ∂H/∂q and ∂H/∂p; inputs q, p, then parameters.
        parameters: their values at any precision.
        energy: E at any precision.
        digits: relative digits wanted.
        bits: of the arithmetic.
    """

    tape: Tape
    parameters: Callable[[int], list[Mpf]]
    energy: Callable[[int], Mpf]
    digits: int
    bits: int

    @cached_property
    def _exact(self) -> BoundTape[Mpf]:
        return self.tape.bind(Multi(self.bits), self.parameters(self.bits))

    @cached_property
    def _disks(self) -> BoundTape[Disk]:
        return self.tape.bind(Disks(), [Disks().point(x) for x in self.parameters(64)])

    @cached_property
    def _level(self) -> Mpf:
        return self.energy(self.bits)

    def at(self, along: int, x: Mpf, y: Mpf) -> tuple[Mpf, Mpf, Mpf]:
        """H − E and its derivatives along x and y.

        Args:
            x, y: the parameter and the other of q and p.
        """
        h, *slopes = self._exact.run(*((x, y) if along == 0 else (y, x)))
        return h - self._level, slopes[along], slopes[1 - along]

    def root(self, along: int, x: Mpf, y: Mpf, size: float | Mpf) -> Mpf:
        """y(x) by Newton's method from a place near it; ``size`` is what its accuracy refers to.

        Args:
            y: where Newton's method begins.
            size: the size of y that the accuracy refers to.

        Raises:
            NotConvergedError: a hundred steps, or one where ∂H/∂y = 0, did not lead to the root.
        """
        fine = multiprecision(self.bits).mpf(2) ** (_LAST_BITS - self.bits) * size
        found = newton(self._steps(along, x), y, fine, 100, rough=2.0 ** (_LOST_BITS - _LAST_BITS))
        if found is None:
            raise NotConvergedError("a branch of H = E could not be solved for")
        return found

    def _steps(self, along: int, x: Mpf) -> Callable[[Mpf], Mpf | None]:
        """Return Newton's step of y, None where ∂H/∂y = 0."""

        def step(y: Mpf) -> Mpf | None:
            h, _, slope = self.at(along, x, y)
            return h / slope if slope else None

        return step

    def piece(self, along: int, point: tuple[Mpf, Mpf], radius: float, tries: int) -> tuple[Piece, float] | None:
        """Return the longest piece from a point, of a half length at most ``radius``.

        And half the time it takes, roughly.

        Args:
            point: (q, p) at its beginning.
            radius: greatest half length, in units of x.
            tries: how often the length is halved before None is given.
        """
        # y is solved for along x, as long as H_y ≠ 0
        x0, y0 = point[along], point[1 - along]
        _, slope, rate = self.at(along, x0, y0)
        if not rate:
            return None
        # dq/dt = H_p, dp/dt = −H_q: the sign of the slope says in which direction time runs
        side = (1 if rate > 0 else -1) * (1 if along == 0 else -1)
        for _ in range(tries):
            c = float(x0 + side * radius)
            # from the tangent at the beginning to the middle of the piece
            found = self._proved(along, c, float(y0 - slope / rate * (c - x0)), radius)
            # the branch that is proved must be the one that the curve has come along
            if found is not None and abs(y0 - found[0]) < found[1]:
                middle, room, bound = found
                steep = abs(float(self.at(along, x0, y0)[2]))
                # (64/15) M ρ^(−2n)/(1 − ρ^(−2)) against the rate at the beginning: 64/15/(1 − ρ⁻²) is below 5
                n = ceil((log(10) * (self.digits + _GUARD_DIGITS) + log(5 * max(bound * steep, 1.0))) / (2 * log(_RHO)))
                return Piece(along, x0, x0 + 2 * side * radius, y0, middle, room, n), radius / steep
            radius /= 2
        return None

    def _proved(self, along: int, c: float, y: float, radius: float) -> tuple[float, float, float] | None:
        """Return middle and radius of the disk that holds y(x) for |x − c| ≤ 2·radius, and a bound on 1/|H_y| there."""
        if not (np.isfinite(c) and np.isfinite(y)):
            return None
        exact = multiprecision(self.bits).mpf
        # towards the root; the proof does not need it to be one
        # six steps: a guess for the centre; what they leave is part of |H − E| in the proof
        near = newton(self._steps(along, exact(c)), exact(y), exact(0), 6, ended=True)
        if near is None:
            return None
        y = float(near)
        h, _, slope = self.at(along, exact(c), exact(y))
        wide, steep = single(c, _WIDER * radius), abs(float(slope))
        across = self._slopes(along, wide, single(y, 0.0))[0]
        # R |H_x| + |H − E|: how far H − E may be from 0 on the disk of x
        moved = float(across.largest) * _WIDER * radius + abs(float(h))
        if not (np.isfinite(moved) and steep > 0):
            return None
        # twice what a constant H_y would need: room for its variation
        room = 2 * moved / steep + 2.0**-50 * abs(y)
        # the least |H_y| over both disks: Krawczyk's operator maps the disk of y into itself if moved/least < room
        least = float(self._slopes(along, wide, single(y, room))[1].least)
        return (y, room, 1 / least) if moved < 0.99 * room * least < np.inf else None

    def _slopes(self, along: int, x: Disk, y: Disk) -> tuple[Disk, Disk]:
        with np.errstate(all="ignore"):
            _, *slopes = self._disks.run(*((x, y) if along == 0 else (y, x)))
            return (_known(slopes[along]), _known(slopes[1 - along]))

    def integrals(self, piece: Piece, end: Mpf) -> tuple[Mpf, Mpf, list[tuple[Mpf, Mpf]]]:
        """∫ dt and ∫ p dq from the beginning of a piece to a place on it; and (x, H_x) at the nodes."""
        along, half, y = piece.along, (end - piece.begin) / 2, piece.first
        time, action, signs, x, slope = 0 * half, 0 * half, [], piece.begin, None
        for node, weight in gauss_legendre(piece.nodes, self.bits):
            new = piece.begin + half * (1 + node)
            # along the tangent from the last node: one or two steps of Newton's method are left
            guess = y if slope is None else y + slope * (new - x)
            x, y = new, self.root(along, new, guess, piece.room)
            _, across, steep = self.at(along, x, y)
            # dy/dx = −H_x/H_y on H = E
            slope = -across / steep
            time += weight * half / (steep if along == 0 else -steep)
            action += weight * half * (y if along == 0 else x * slope)
            signs.append((x, across))
        return time, action, signs

    def finished(self, piece: Piece, end: Mpf) -> tuple[Piece, tuple[Mpf, Mpf], list[tuple[Mpf, Mpf]]]:
        """Return the piece up to an end with its integrals and their bounds, the point there, and H_x at the nodes."""
        time, action, signs = self.integrals(piece, end)
        along, half = piece.along, abs(float(end - piece.begin)) / 2
        y = self.root(along, end, piece.middle + 0 * end, piece.room)
        c = float(piece.begin + end) / 2
        wide = single(c, 2 * half)
        across, steep = self._slopes(along, wide, single(piece.middle, piece.room))
        rate = 1 / float(steep.least)
        largest = abs(piece.middle) + piece.room if along == 0 else (abs(c) + 2 * half) * float(across.largest) * rate
        # Gauss and Legendre's error for |f| ≤ 1 in the ellipse of parameter ρ, which the disk of twice the radius
        # contains
        off = 64 / 15 * half * _RHO ** (-2 * piece.nodes) / (1 - _RHO**-2)
        lost = 2.0 ** (_LOST_BITS - self.bits)
        done = Piece(
            along, piece.begin, end, piece.first, piece.middle, piece.room, piece.nodes, time, action,
            off * rate + lost * abs(float(time)), off * largest + lost * 2 * half * largest,
        )  # fmt: skip
        return done, (end, y) if along == 0 else (y, end), [*signs, (end, self.at(along, end, y)[1])]


def _known(x: Disk) -> Disk:
    return x if np.all(x.known) else single(0.0, np.inf)


@dataclass(frozen=True, eq=False)
class Orbit:
    """A motion that comes back.

    Attributes:
        curve: H = E.
        pieces: in the order of time, from the start on.
        turns: 0 for a libration; 1 or −1 for a rotation of an angle by 2π.
        ends: the least and the greatest q of a libration; None for a rotation.
    """

    curve: Curve
    pieces: tuple[Piece, ...]
    turns: int
    ends: tuple[Mpf, Mpf] | None

    @cached_property
    def _begins(self) -> list[Mpf | int]:
        return [0, *accumulate(piece.time for piece in self.pieces)]

    @property
    def period(self) -> Mpf | int:
        return self._begins[-1]

    @property
    def period_error(self) -> float:
        return sum(piece.time_error for piece in self.pieces)

    @cached_property
    def extents(self) -> tuple[float, float]:
        """How far q and p go once round, at most."""
        far = [0.0, 0.0]
        for piece in self.pieces:
            far[piece.along] += abs(float(piece.end - piece.begin))
            far[1 - piece.along] += 2 * piece.room
        return far[0], far[1]

    @property
    def action(self) -> tuple[Mpf, float]:
        """(1/2π) ∮ p dq and a bound on its error."""
        turn = 2 * multiprecision(self.curve.bits).pi
        return sum(p.action for p in self.pieces) / turn, sum(p.action_error for p in self.pieces) / 6

    def at(self, time: Mpf | int) -> tuple[Mpf, Mpf]:
        """Return (q, p) at a time from the start, 0 ≤ time ≤ period: ∫ dt solved for its upper end.

        Args:
            time: in the units of t.
        """
        # the piece in which the time falls, by the times of the others
        k = min(max(bisect.bisect_right(self._begins, time) - 1, 0), len(self.pieces) - 1)
        piece, left = self.pieces[k], time - self._begins[k]
        x = piece.begin + (piece.end - piece.begin) * left / piece.time
        low, high = sorted((piece.begin, piece.end))

        def solved_for(x: Mpf) -> Mpf:
            return self.curve.root(piece.along, x, piece.middle + 0 * x, piece.room)

        def step(x: Mpf) -> Mpf:
            rate = self.curve.at(piece.along, x, solved_for(x))[2]
            # Newton's method on t(x) = time with dt/dx = 1/H_y
            early = left - self.curve.integrals(piece, x)[0]
            return x - min(max(x + early * (rate if piece.along == 0 else -rate), low), high)

        close = multiprecision(self.curve.bits).mpf(2) ** (16 - self.curve.bits) * (high - low)
        x = required(newton(step, x, close, 60, ended=True))
        return (x, solved_for(x)) if piece.along == 0 else (solved_for(x), x)


def followed(curve: Curve, q: Mpf, p: Mpf, domain: tuple[Mpf | None, Mpf | None], *, angle: bool) -> Orbit:
    """Follow the curve from a point until it comes back, for an angle possibly 2π further.

    Args:
        curve: H = E.
        q, p: the point, no place of rest.
        domain: its ends for q, None where there is none.
        angle: True where H has period 2π in q.

    Raises:
        NotConvergedError: it does not come back: it runs away, tends to a place of rest, ends, or meets a singularity.
    """
    turn = 2 * multiprecision(curve.bits).pi
    goals = {0: (q, p), **({1: (q + turn, p), -1: (q - turn, p)} if angle else {})}
    point, radii, pieces, places = (q, p), [max(abs(float(x)), 1.0) for x in (q, p)], list[Piece](), [q]
    longest = [0.0, 0.0]
    for _ in range(_MOST_PIECES):
        tries = [_LATER_HALVINGS if far else _FIRST_HALVINGS for far in longest]
        # both parameters are tried: the piece that lasts longer in time is taken
        tried = [found for k in (0, 1) if (found := curve.piece(k, point, radii[k], tries[k])) is not None]
        piece = max(tried, key=lambda found: found[1])[0] if tried else None
        if piece is not None:
            # twice as long as the last one that was proved: lengths follow the curve
            radii[piece.along] = 2 * abs(float(piece.end - piece.begin))
            longest[piece.along] = max(longest[piece.along], radii[piece.along])
        if piece is None or radii[piece.along] < _SHORTEST_PIECE * longest[piece.along]:
            raise NotConvergedError(_where("meets an equilibrium, another branch or a singularity of H", point))
        # the start again, or its image a turn away, inside the disk in which the branch is the only one
        back = next((turns for turns, goal in goals.items() if piece.passes(goal)), None)
        end = piece.end if back is None else goals[back][piece.along]
        done, point, signs = curve.finished(piece, end)
        pieces.append(done)
        places += [point[0], *(_extremes(curve, done, signs) if piece.along else [])]
        if any(bound is not None and side * (x - bound) <= 0 for x in places for bound, side in zip(domain, (1, -1))):
            raise NotConvergedError(_where("reaches an end of the domain of q", point))
        if back is not None:
            return Orbit(curve, tuple(pieces), back, None if back else (min(places), max(places)))
    raise NotConvergedError(_where(f"does not come back within {_MOST_PIECES} pieces of the curve H = E", point))


def _where(why: str, point: tuple[Mpf, Mpf]) -> str:
    return (
        f"H(q, p): the motion {why}; it was followed to q = {float(point[0]):.9g}, p = {float(point[1]):.9g}, and only "
        "one that comes back can be computed for such an H"
    )


def _extremes(curve: Curve, piece: Piece, signs: list[tuple[Mpf, Mpf]]) -> list[Mpf]:
    """Return the q where dq/dt = H_p vanishes on a piece along p."""

    def place(p: Mpf) -> Mpf:
        return curve.root(1, p, piece.middle + 0 * p, piece.room)

    found, before = [], (piece.begin, curve.at(1, piece.begin, piece.first)[1])
    for after in signs:
        if before[1] * after[1] < 0:
            sign = before[1]
            low, high = bisected(lambda p: curve.at(1, p, place(p))[1] * sign > 0, before[0], after[0], curve.bits)  # noqa: B023 (called at once)
            found.append(place((low + high) / 2))
        before = after if after[1] else before
    return found


@lru_cache(maxsize=64)
def gauss_legendre(n: int, bits: int) -> list[tuple[Mpf, Mpf]]:
    """Return nodes on (−1, 1), increasing, and weights: Newton's method on Pₙ from nodes in doubles.

    Args:
        n: how many nodes.
    """
    mp, result = multiprecision(bits + 16), []
    for start in np.polynomial.legendre.leggauss(n)[0]:
        x = mp.mpf(float(start))
        for _ in range(2 + max(0, (bits // 50).bit_length())):
            before, value = mp.one, x
            for k in range(2, n + 1):
                before, value = value, ((2 * k - 1) * x * value - (k - 1) * before) / k
            # Pₙ′ = n (Pₙ₋₁ − x Pₙ)/(1 − x²)
            slope = n * (before - x * value) / (1 - x * x)
            # Newton's method on Pₙ, whose zeros are simple: digits double from 15
            x -= value / slope
        result.append((x, 2 / ((1 - x * x) * slope * slope)))
    return result
