"""Critical curves of the plane of two constants: where P² has a double zero, or a zero at an end of the domain.

At a double zero of P² that is a maximum the coordinate rests (a relative equilibrium); at a minimum it takes for ever
to arrive (a separatrix). Both are {(x, y): P² = ∂P²/∂q = 0 for a q in the domain}, drawn as a curve with q as
parameter: the resultant of the two by y is a polynomial in x, solved at every q. Points where the double zero is not
real, or outside the domain, are on the discriminant but on no curve.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.root_finding import bisected
from hjsolve.arithmetic.tape import Tape
from hjsolve.display.by_value import ByValue
from hjsolve.display.shown import Shown
from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds
from hjsolve.energy_momentum.isolation import Reals
from hjsolve.errors import required
from hjsolve.lowering import lower

Window = tuple[tuple[float, float], tuple[float, float]]
_FIRST, _MOST_PLACES = 241, 4000
ROUNDS = 9
"""How often places are put between those that lie far apart."""
_STEP = 0.006
"""Longest step along a curve, as part of the window."""
_FARTHEST = 18.0
"""Logarithm of how far and near places are looked at, against a length typical of the coordinate."""
_SMALLEST, _BREAK = 1e-3, 0.1
"""Size of a curve, as part of the window, beneath which it is rounding at an end of the domain, and of a gap in one."""


@dataclass(frozen=True, repr=False, eq=False)
class CriticalCurve(ByValue, Shown):
    """A curve of the map, where the kinds of motion change.

    Attributes:
        kind: ``relative equilibrium`` or ``separatrix``: a double zero of P²; ``end of the domain``: P² vanishes at an
            end that the coordinate then reaches (a collision, a pole); ``edge of escape``: it vanishes at infinity.
        coordinate: whose P² it is.
        x, y: points along the curve.
        q: the place of the double zero at these points; empty where there is none.
        equation: polynomial in the two constants that vanishes on the curve; None where it was not had.
    """

    kind: str
    coordinate: str
    x: Reals = field(repr=False)
    y: Reals = field(repr=False)
    q: Reals = field(repr=False)
    equation: sp.Expr | None = None

    def _label(self) -> str:
        return f"{self.kind} of {self.coordinate}"


# ------------------------------------------------------------------------------------------------ double zeros
@dataclass(frozen=True)
class _Traced:
    """The function of (t; x, y) whose double zeros are looked for: N, or P² itself."""

    tapes: tuple[Tape, Tape]
    powers: tuple[tuple[int, int], ...]
    low: float
    high: float
    length: float

    def tables(self, t: Reals, which: int) -> Reals:
        """Coefficients of the monomials of the function (0) or its derivative (1) at places t, shape (m, i, j)."""
        with np.errstate(all="ignore"):
            values = self.tapes[which].run(Float64(), [t])
        size = [1 + max(p[k] for p in self.powers) for k in (0, 1)]
        table = np.zeros((len(t), *size))
        for (i, j), value in zip(self.powers, values, strict=True):
            table[:, i, j] = value
        return table

    def places(self, v: Reals) -> Reals:
        """Return places t for v from −∞ to ∞."""
        low, high, length = self.low, self.high, self.length
        if np.isfinite(low) and np.isfinite(high):
            return low + (high - low) / (1 + np.exp(-v))
        if np.isfinite(low):
            return low + length * np.exp(v)
        return high - length * np.exp(-v) if np.isfinite(high) else length * np.sinh(v)


def _traced(own: CoordinateKinds) -> _Traced:
    x, y = own.constants
    if own.polynomial is not None:
        s = own.polynomial.substitution
        t, function, ends = s.x, own.polynomial.polynomial, (s.lower, s.upper)
        length = own.polynomial.pieces[0].length
    else:
        coordinate = own.solution.system.coordinate(own.name)
        t, d = coordinate.symbol, coordinate.domain
        function = sp.expand(own.solution.momentum_squared[own.name].subs(dict(own.values)))
        closed = d.kind == "angle"
        ends = tuple(
            (sp.pi * side if closed else sp.oo * side) if end is None else end.subs(dict(own.values))
            for end, side in ((d.lower, -1), (d.upper, 1))
        )
        length = abs(float(own.place - (ends[0] if ends[0].is_finite else 0))) or 1.0
    terms = sp.Poly(function, x, y).terms()
    powers = tuple((int(i), int(j)) for (i, j), _ in terms)
    tapes = lower([c for _, c in terms], [t]), lower([sp.diff(c, t) for _, c in terms], [t])
    return _Traced(tapes, powers, float(ends[0]), float(ends[1]), length)


def double_zeros(own: CoordinateKinds, window: Window, rounds: int = ROUNDS) -> list[CriticalCurve]:
    """Trace the curves on which P² has a double zero that moves along them.

    Args:
        own: the coordinate.
        window: ranges of x and y.
        rounds: how often places are put between those that lie far apart.
    """
    traced = _traced(own)
    top = [max(p[k] for p in traced.powers) for k in (0, 1)]
    if not any(top):
        return []
    if not all(top):
        return _lines(own, traced, 0 if top[0] else 1, window)
    solved = _Solved(traced)
    v = np.linspace(-_FARTHEST, _FARTHEST, _FIRST)
    points = solved.points(traced.places(v))
    branches = _followed(points)
    for _ in range(rounds):
        gaps = _wide_gaps(branches, window)
        if not len(gaps) or len(v) > _MOST_PLACES:
            break
        more = (v[gaps] + v[gaps + 1]) / 2
        order = np.argsort(np.concatenate([v, more]))
        points = np.concatenate([points, solved.points(traced.places(more))])[order]
        v = np.concatenate([v, more])[order]
        branches = _followed(points)
    t = traced.places(v)
    found = [piece for k in range(branches.shape[1]) for piece in _pieces(own, traced, t, branches[:, k], window)]
    return [curve for k, curve in enumerate(found) if not any(_same(curve, other) for other in found[:k])]


def _same(one: CriticalCurve, other: CriticalCurve) -> bool:
    """Return whether two curves are one: the same equilibria at places that mirror each other."""
    if one.kind != other.kind or len(one.x) != len(other.x):
        return False
    pairs = (one.x, other.x), (one.y, other.y)
    return any(all(np.allclose(a, b[::step], rtol=1e-6, atol=1e-9) for a, b in pairs) for step in (1, -1))


class _Solved:
    """The solutions (x, y) of P² = ∂P²/∂t = 0 at places t, by the resultant of both in y.

    Where only even powers of x, or of y, are there, its square is solved for: the resultant would be a square itself.
    """

    def __init__(self, traced: _Traced):
        x, y = sp.symbols("x y")
        self.traced = traced
        self.even = [2 if all(p[k] % 2 == 0 for p in traced.powers) else 1 for k in (0, 1)]
        self.symbols = [[sp.Symbol(f"{letter}{i}_{j}") for i, j in traced.powers] for letter in "ab"]
        F, G = (
            sum(
                c * x ** (i // self.even[0]) * y ** (j // self.even[1])
                for c, (i, j) in zip(letters, traced.powers, strict=True)
            )
            for letters in self.symbols
        )
        coefficients = sp.Poly(sp.resultant(F, G, y), x).all_coeffs()
        self.tape = lower(coefficients, [s for letters in self.symbols for s in letters])
        self.degree = len(coefficients) - 1

    def points(self, t: Reals) -> Reals:
        """Return all real points (x, y) of each place t, NaN for those that are not, shape (m, degree, 2)."""
        F, G = (self.traced.tables(t, which) for which in (0, 1))
        known = [table[:, i, j] for table in (F, G) for i, j in self.traced.powers]
        with np.errstate(all="ignore"):
            rows = np.stack([np.broadcast_to(c, t.shape) for c in self.tape.run(Float64(), known)], axis=1)
        x = real_roots_of_rows(rows)
        y = np.full(x.shape, np.nan)
        F, G = F[:, :: self.even[0], :: self.even[1]], G[:, :: self.even[0], :: self.even[1]]
        for k in range(x.shape[1]):
            y[:, k] = _other(F, G, x[:, k])
        for k, even in enumerate(self.even):
            if even == 2:
                with np.errstate(invalid="ignore"):
                    root = np.sqrt((x, y)[k])
                x, y = (np.concatenate([root, -root] if j == k else [v, v], axis=1) for j, v in enumerate((x, y)))
        return np.stack([np.where(np.isfinite(y), x, np.nan), np.where(np.isfinite(x), y, np.nan)], axis=2)


def real_roots_of_rows(rows: Reals, close: float = 1e-9) -> Reals:
    """Real roots of many polynomials in increasing order, then NaN.

    Args:
        rows: coefficients, the highest power first, shape (m, n + 1).
        close: imaginary part, over the size of the root, that counts as zero.
    """
    m, n = rows.shape[0], rows.shape[1] - 1
    result = np.full((m, max(n, 1)), np.nan)
    size = np.abs(rows).max(axis=1, initial=0)
    good = np.isfinite(rows).all(axis=1) & (np.abs(rows[:, 0]) > 1e-14 * size) & (size > 0)
    if n < 1:
        return result
    if (lower_degree := np.isfinite(rows).all(axis=1) & ~good & (size > 0)).any() and n > 1:
        result[lower_degree, : n - 1] = real_roots_of_rows(rows[lower_degree, 1:], close)
    companion = np.zeros((int(good.sum()), n, n))
    companion[:, 0] = -rows[good, 1:] / rows[good, :1]
    companion[:, np.arange(1, n), np.arange(n - 1)] = 1.0
    roots = np.linalg.eigvals(companion)
    real = np.where(np.abs(roots.imag) <= close * (1e-12 + np.abs(roots)), roots.real, np.nan)
    result[good] = np.sort(real, axis=1)
    return result


def _other(F: Reals, G: Reals, x: Reals) -> Reals:
    """Return the common zeros y of pairs of polynomials in x and y at x; NaN where there is none."""
    f, g = ((table * x[:, None, None] ** np.arange(table.shape[1])[None, :, None]).sum(axis=1) for table in (F, G))
    with np.errstate(all="ignore"):
        if f.shape[1] == 2:
            return np.where(np.abs(f[:, 1]) > 0, -f[:, 0] / f[:, 1], -g[:, 0] / g[:, 1])
        zeros = real_roots_of_rows(np.where(np.isfinite(f), f, np.nan)[:, ::-1], 1e-7)
        powers = zeros[:, :, None] ** np.arange(g.shape[1])
        values = np.abs((powers * g[:, None, :]).sum(axis=2)) / np.abs(powers * g[:, None, :]).sum(axis=2)
        values = np.where(np.isfinite(values), values, np.inf)
        best = np.argmin(values, axis=1)[:, None]
        found = np.take_along_axis(zeros, best, 1)[:, 0]
        return np.where(np.take_along_axis(values, best, 1)[:, 0] <= 1e-6, found, np.nan)


def _followed(points: Reals) -> Reals:
    """Return the same points with every branch where it was at the place before."""
    result = points.copy()
    for i in range(1, len(result)):
        before, here = result[i - 1], result[i]
        if np.isnan(here[:, 0]).all() or np.isnan(before[:, 0]).all() or len(here) < 2:
            continue
        left = [k for k in range(len(here)) if np.isfinite(here[k, 0])]
        order: list[int | None] = [None] * len(here)
        steps = (here[None] - before[:, None]) / (np.abs(before[:, None]) + 1e-9)
        distances = np.hypot(steps[:, :, 0], steps[:, :, 1])
        nearest = np.argsort(distances, axis=None, kind="stable")
        for j, k in zip(*(v.tolist() for v in np.unravel_index(nearest, distances.shape))):
            if not np.isfinite(distances[j, k]):
                break
            if order[j] is None and k in left:
                order[j] = k
                left.remove(k)
        free = [j for j in range(len(here)) if order[j] is None]
        for j, k in zip(free, left):
            order[j] = k
        result[i] = [here[k] if k is not None else (np.nan, np.nan) for k in order]
    return result


def _scaled(points: Reals, window: Window) -> Reals:
    low, size = np.array([r[0] for r in window]), np.array([r[1] - r[0] for r in window])
    return np.asarray((points - low) / size)


def _wide_gaps(branches: Reals, window: Window) -> NDArray[np.int64]:
    """Return where consecutive points near the window lie far apart, or a branch begins or ends."""
    u = _scaled(branches, window)
    near = np.max(np.abs(u - 0.5), axis=2) < 0.75
    with np.errstate(invalid="ignore"):
        far = np.hypot(*np.moveaxis(np.diff(u, axis=0), 2, 0)) > _STEP
    real = np.isfinite(u[:, :, 0])
    ends = real[1:] != real[:-1]
    wide = (far | ends) & (near[1:] | near[:-1])
    return np.flatnonzero(wide.any(axis=1))


def _pieces(own: CoordinateKinds, traced: _Traced, t: Reals, points: Reals, window: Window) -> list[CriticalCurve]:
    """Return the parts of one branch that lie in or near the window, each of one kind."""
    u = _scaled(points, window)
    shown = np.max(np.abs(u - 0.5), axis=1) < 1.5
    stable = _bend(traced, t, points) < 0
    jump = np.zeros(len(t), dtype=bool)
    with np.errstate(invalid="ignore"):
        jump[1:] = np.hypot(*np.diff(u, axis=0).T) > _BREAK
    marks = np.flatnonzero((np.diff(shown.astype(int)) != 0) | (np.diff(stable.astype(int)) != 0) | jump[1:]) + 1
    found = []
    for part in np.split(np.arange(len(t)), marks):
        if len(part) > 1 and shown[part[0]] and np.ptp(u[part], axis=0).max() > _SMALLEST:
            q = t[part] if own.polynomial is None else _inverse(own, t[part])
            kind = "relative equilibrium" if stable[part[0]] else "separatrix"
            found.append(CriticalCurve(kind, own.name, points[part, 0], points[part, 1], q))
    return found


def _inverse(own: CoordinateKinds, t: Reals) -> Reals:
    with np.errstate(all="ignore"):
        return np.asarray(required(own.polynomial).backward.run(Float64(), [t])[0], float)


def _bend(traced: _Traced, t: Reals, points: Reals) -> Reals:
    """Return the second derivative at the double zeros, up to a positive factor, by differences of the first."""
    h = 1e-5 * np.maximum(np.minimum(np.abs(t - traced.low), np.abs(traced.high - t)), 1e-300)
    h = np.where(np.isfinite(h), h, 1e-5 * (1 + np.abs(t)))
    ends = []
    for side in (-1, 1):
        table = traced.tables(t + side * h, 1)
        powers = points[:, 0, None, None] ** np.arange(table.shape[1])[None, :, None]
        powers = powers * points[:, 1, None, None] ** np.arange(table.shape[2])[None, None, :]
        with np.errstate(all="ignore"):
            ends.append((table * powers).sum(axis=(1, 2)))
    return np.asarray(ends[1] - ends[0])


# ------------------------------------------------------------------------------------------------ straight lines
def _lines(own: CoordinateKinds, traced: _Traced, which: int, window: Window) -> list[CriticalCurve]:
    """Critical values of a coordinate whose P² holds only one of the two constants."""
    t = traced.places(np.linspace(-_FARTHEST, _FARTHEST, 8 * _FIRST))
    F, G = (np.moveaxis(traced.tables(t, k), 1 + which, 1)[:, :, 0] for k in (0, 1))
    levels = real_roots_of_rows(F[:, ::-1], 1e-12)
    found = []
    for k in range(levels.shape[1]):
        slope = np.sign((G * levels[:, k, None] ** np.arange(G.shape[1])).sum(axis=1))
        for i in np.flatnonzero(slope[1:] * slope[:-1] < 0):
            place, level = _refined(traced, which, t[i], t[i + 1], levels[i, k])
            found.append(_line(own, which, level, place, slope[i] > 0, window))
    return found


def _refined(traced: _Traced, which: int, a: float, b: float, level: float) -> tuple[float, float]:
    """Return the place between a and b where the level is stationary, and the level there: bisection along F = 0."""

    def at(t: float, near: float) -> tuple[float, float]:
        f, g = (np.moveaxis(traced.tables(np.array([t]), k), 1 + which, 1)[0, :, 0] for k in (0, 1))
        roots = np.roots(f[::-1])
        value = float(roots[np.argmin(np.abs(roots - near))].real)
        return value, float(np.polynomial.polynomial.polyval(value, g))

    level, first = at(a, level)

    def before(t: float) -> bool:
        nonlocal level
        level, slope = at(t, level)
        return slope * first > 0

    a, b = bisected(before, a, b, 60)
    return (a + b) / 2, level


def _line(own: CoordinateKinds, which: int, level: float, place: float, stable: bool, window: Window) -> CriticalCurve:
    q = place if own.polynomial is None else float(_inverse(own, np.array([place]))[0])
    along, across = np.linspace(*window[1 - which], 201), np.full(201, level)
    x, y = (across, along) if which == 0 else (along, across)
    kind = "relative equilibrium" if stable else "separatrix"
    return CriticalCurve(kind, own.name, x, y, np.full(201, q))


def equations(own: CoordinateKinds, letters: Mapping[sp.Symbol, sp.Symbol]) -> sp.Expr | None:
    """Return the discriminant of N by t.

    The polynomial in the two constants that vanishes on every curve of double zeros.

    Args:
        own: the coordinate; None where its P² is not a polynomial.
        letters: symbols to write it in.
    """
    if own.polynomial is None:
        return None
    s = own.polynomial.substitution.x
    found = sp.factor_list(sp.discriminant(own.polynomial.polynomial, s), *own.constants)
    return sp.Mul(*(factor for factor, _ in found[1])).xreplace(dict(letters))
