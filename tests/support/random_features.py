"""Random potentials with narrow features, and what composite Gauss–Legendre rules in 40 digits make of their motions.

A draw is a smooth base (oscillator, quartic, Morse, pendulum, cosh, a rotor, a radial well) with one to three features
in it: a Gaussian, sech², Lorentzian, tanh step or a wave packet, 1e-1 … 1e-6 wide, in the middle of the motion, beside
a turning point, or just outside. It is a function of (seed, index) alone. Places and momenta are dyadic, so a double,
its text and the exact number are the same. Nothing in the references comes from hjsolve: turning points are scanned
for on grids that are fine about every feature, and the integrals are cut into pieces that grow from each of them.
"""

from __future__ import annotations

import functools
import itertools
import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from mpmath import mp, mpf

DIGITS = 40
_AGREE = 1e-19
"""How well two rules have to agree, relative to the integral."""
_CLOSE = 1e-5
"""p² smaller than this part of its largest value, away from a turning point: a separatrix is close, not drawn."""


@dataclass(frozen=True)
class Feature:
    """One narrow feature.

    Attributes:
        shape: of ``SHAPES``. place, height, width: as text, exact numbers.
        reach: half width of what is worth looking at, in units of ``width``.
    """

    shape: str
    place: str
    height: str
    width: str
    reach: float


@dataclass(frozen=True)
class Draw:
    """One random system with a start.

    Attributes:
        index: of the draw. base: name of the potential without features.
        coordinates: name → domain; the first one has the features.
        kinetic, potential: text.
        q, p: coordinate → double (mass 1: on a line p is the velocity).
        features: what is in the potential.
        effective: 2 (V + what ignorable momenta add), text in x, exact.
    """

    index: int
    base: str
    coordinates: Mapping[str, str]
    kinetic: str
    potential: str
    q: Mapping[str, float]
    p: Mapping[str, float]
    features: tuple[Feature, ...]
    effective: str

    @property
    def name(self) -> str:
        """The coordinate that has the features."""
        return next(iter(self.coordinates))

    def exact(self, group: str) -> dict[str, str]:
        """``q`` or ``p`` as exact text, for single motions."""
        return {n: repr(value) for n, value in getattr(self, group).items()}


@dataclass(frozen=True)
class Truth:
    """Numbers of the motion, in 40 digits; a rotation has no turning points.

    Attributes:
        lower, upper: turning points. action: (1/2π) ∮ p dq. frequency: 2π over the period.
    """

    lower: mpf | None
    upper: mpf | None
    action: mpf
    frequency: mpf


_LINE = ({"x": "line"}, "dot(x)**2/2")
_POLAR = ({"r": "0 < r", "theta": "angle"}, "dot(r)**2/2 + r**2*dot(theta)**2/2")
BASES: dict[str, tuple[tuple[dict[str, str], str], str, tuple[float, float], tuple[float, float]]] = {
    "oscillator": (_LINE, "x**2/2", (-1, 1), (0.3, 2)),
    "quartic": (_LINE, "x**4/4", (-1, 1), (0.3, 1.5)),
    "Morse": (_LINE, "(1 - exp(-x))**2", (-0.3, 0.6), (0.2, 1)),
    "pendulum": (_LINE, "1 - cos(x)", (-1, 1), (0.2, 1.2)),
    "cosh": (_LINE, "cosh(x) - 1", (-1, 1), (0.3, 1.5)),
    "rotor": (({"x": "angle"}, _LINE[1]), "cos(x)/4", (-3, 3), (1.3, 2)),
    "Kepler": (_POLAR, "-1/r", (0.8, 1.2), (0.05, 0.4)),
    "isochrone": (_POLAR, "-1/(1 + sqrt(1 + r**2))", (0.8, 1.2), (0.05, 0.3)),
    "logarithm": (_POLAR, "log(1 + r**2)/2", (0.8, 1.2), (0.05, 0.6)),
}
"""System, potential, and the intervals that places and momenta are drawn from."""

SHAPES = {
    "Gaussian": ("exp(-{u}**2)", 7.0),
    "sech2": ("1/cosh({u})**2", 20.0),
    "Lorentzian": ("1/(1 + {u}**2)", 30.0),
    "step": ("tanh({u})", 20.0),
    "packet": ("exp(-({u}/{waves})**2)*sin({u})", 7.0),
}
"""Of u = (x − place)/width; of sin((x − place)/2)·2/width on the circle."""


def draw(seed: int, index: int) -> Draw:
    """Return the draw of a seed and an index; its motion is bounded and not close to a separatrix."""
    return next(drawn for attempt in itertools.count() if (drawn := _attempt(seed, index, attempt)) is not None)


def _attempt(seed: int, index: int, attempt: int) -> Draw | None:
    rng = random.Random(f"{seed}/{index}/{attempt}")
    base = list(BASES)[index % len(BASES)]
    (coordinates, kinetic), potential, places, speeds = BASES[base]
    name = next(iter(coordinates))
    q, p = {name: _dyadic(rng.uniform(*places))}, {name: _dyadic(rng.uniform(*speeds)) * rng.choice((-1, 1))}
    momentum = 0.0
    if "theta" in coordinates:
        momentum = _dyadic(rng.uniform(0.5, 0.9))
        q["theta"], p["theta"] = 0.0, momentum
    centrifugal = f" + ({momentum!r})**2/{name}**2" if momentum else ""
    smooth = Draw(index, base, coordinates, kinetic, potential, q, p, (), f"2*({potential}){centrifugal}")
    found = _motion(smooth)
    if found is None:
        return None
    features = tuple(_feature(rng, smooth, found) for _ in range(rng.choice((1, 1, 1, 1, 2, 2, 3))))
    whole = " + ".join([potential, *(_text(f, name, base) for f in features)])
    full = Draw(index, base, coordinates, kinetic, whole, q, p, features, f"2*({whole}){centrifugal}")
    return full if _motion(full) is not None else None


def _dyadic(value: float) -> float:
    return round(4096 * value) / 4096


def _feature(rng: random.Random, smooth: Draw, found: tuple[float, float]) -> Feature:
    """A feature somewhere in the motion of a smooth potential."""
    a, b = found
    width, where = 10 ** rng.uniform(-6, -1), rng.random()
    if where < 0.75:
        place = (a + b) / 2 - (b - a) / 2 * math.cos(rng.uniform(0.1, 3.0))
    else:
        place = rng.choice(found) + width * rng.uniform(-6, 6)
    shape = rng.choice([s for s in SHAPES if smooth.base != "rotor" or s not in {"step", "packet"}])
    waves = rng.choice((3, 10, 30))
    room = 0.5 * float(_square(smooth)[1](np.float64((a + b) / 2)))
    height = rng.choice((-1, 1)) * room * 10 ** rng.uniform(-3, -0.3)
    reach = SHAPES[shape][1] * (waves if shape == "packet" else 1)
    return Feature(
        f"packet of {waves}" if shape == "packet" else shape, f"{place:.12g}", f"{height:.4g}", f"{width:.3g}", reach
    )


def _text(feature: Feature, name: str, base: str) -> str:
    shape, _, waves = feature.shape.partition(" of ")
    u = f"(({name} - ({feature.place}))/{feature.width})"
    if base == "rotor":
        u = f"(2*sin(({name} - ({feature.place}))/2)/{feature.width})"
    return f"({feature.height})*" + SHAPES[shape][0].format(u=u, waves=waves)


@functools.lru_cache(maxsize=256)
def _functions(effective: str, name: str) -> tuple[Callable[[mpf], mpf], Callable[[Any], Any]]:
    x = sp.Symbol(name)
    expression = sp.sympify(effective, rational=True)
    return sp.lambdify(x, expression, "mpmath"), sp.lambdify(x, expression, "numpy")


def _square(drawn: Draw) -> tuple[Callable[[mpf], mpf], Callable[[Any], Any]]:
    """p² of the coordinate with the features, in many digits and in doubles."""
    exact, doubles = _functions(drawn.effective, drawn.name)
    q0, p0 = drawn.q[drawn.name], drawn.p[drawn.name]

    def squared(x: mpf) -> mpf:
        return mp.mpf(p0) ** 2 + exact(mp.mpf(q0)) - exact(x)

    def approximate(x: Any) -> Any:
        with np.errstate(all="ignore"):
            return p0**2 + doubles(np.float64(q0)) - doubles(x)

    return squared, approximate


def _grid(drawn: Draw, low: float, high: float) -> Any:
    """Places at which nothing that is drawn can be overlooked."""
    parts = [np.linspace(low, high, 4001)]
    for f in drawn.features:
        c, w = float(f.place), float(f.width)
        far = w * f.reach * 1.03 ** np.arange(0, 400)
        near = w * np.arange(-f.reach, f.reach, 0.05)
        turns = (0.0,) if drawn.base != "rotor" else (-2 * np.pi, 0.0, 2 * np.pi)
        parts += [c + turn + part for turn in turns for part in (near, far, -far)]
    grid = np.unique(np.concatenate(parts))
    return grid[(grid > low) & (grid < high)]


def _motion(drawn: Draw) -> tuple[float, float] | None:
    """The turning points in doubles (a turn, for a rotation); None where there are none, or it is a close thing."""
    start = drawn.q[drawn.name]
    if drawn.base == "rotor":
        grid = _grid(drawn, start, start + 2 * math.pi)
        values = _square(drawn)[1](grid)
        return (start, start + 2 * math.pi) if values.min() > _CLOSE * values.max() else None
    low = 1e-3 if "theta" in drawn.coordinates else start - 12.0
    grid = _grid(drawn, low, start + 12.0)
    values = _square(drawn)[1](grid)
    middle = int(np.searchsorted(grid, start))
    below, above = np.flatnonzero(~(values[:middle] > 0)), middle + np.flatnonzero(~(values[middle:] > 0))
    if not len(below) or not len(above):
        return None
    inside = values[below[-1] + 1 : above[0]]
    size = inside.max(initial=0.0)
    dips = (inside[1:-1] < inside[:-2]) & (inside[1:-1] < inside[2:]) & (inside[1:-1] < _CLOSE * size)
    slopes = [abs(values[k] - values[k + 1]) / (grid[k + 1] - grid[k]) for k in (below[-1], above[0] - 1)]
    if len(inside) < 8 or dips.any() or min(slopes) < 1e-3 * size / (grid[above[0]] - grid[below[-1]]):
        return None
    return float(grid[below[-1]]), float(grid[above[0]])


def truth(drawn: Draw) -> Truth:
    """Return the values of a draw, right to 17 digits and more.

    Raises:
        ArithmeticError: two rules did not agree.
    """
    with mp.workdps(DIGITS):
        squared = _square(drawn)[0]
        found = _motion(drawn)
        if found is None:
            raise ArithmeticError("no motion that was drawn")
        if drawn.base == "rotor":
            a = mp.mpf(found[0])
            edges = [a, *(mp.mpf(x) for x in _edges(drawn, *found)), a + 2 * mp.pi]
            action, time = _sums(lambda x: (squared(x), mp.one), edges)
            return Truth(None, None, action / (2 * mp.pi), 2 * mp.pi / time)
        a, b = (_zero(squared, drawn, place, side) for place, side in zip(found, (1, -1), strict=True))
        W = b - a

        def at(χ: mpf) -> tuple[mpf, mpf]:
            low, high = W * mp.sin(χ / 2) ** 2, W * mp.cos(χ / 2) ** 2
            q = a + low if low < high else b - high
            return squared(q), mp.sqrt(low * high)

        edges = [2 * mp.asin(mp.sqrt((mp.mpf(x) - a) / W)) for x in _edges(drawn, *found) if a < x < b]
        action, time = _sums(at, [mp.zero, *edges, mp.pi])
        return Truth(a, b, action / mp.pi, mp.pi / time)


def _zero(squared: Callable[[mpf], mpf], drawn: Draw, place: float, side: int) -> mpf:
    """The zero next to a place of the grid, by bisection and secants that keep the bracket."""
    grid = _grid(drawn, place - 1.0, place + 1.0)
    k = int(np.searchsorted(grid, place))
    outer, inner = mp.mpf(place), mp.mpf(float(grid[k + side]))
    while not squared(outer) < 0:  # the grid saw the zero itself, or its rounding
        outer -= side * abs(inner - outer) / 4
    while not squared(inner) > 0:
        inner += side * abs(inner - outer) / 4
    for _ in range(40):
        middle = (inner + outer) / 2
        inner, outer = (middle, outer) if squared(middle) > 0 else (inner, middle)
    return mp.findroot(squared, (inner, outer), solver="anderson", tol=mp.mpf(10) ** (-2 * DIGITS + 6), verify=False)


def _edges(drawn: Draw, low: float, high: float) -> list[float]:
    """Pieces that grow from every feature like the distance from it."""
    found = {low + (high - low) * k / 12 for k in range(1, 12)}
    for f in drawn.features:
        c, w = float(f.place), float(f.width)
        steps = np.arange(-f.reach, f.reach, 2.0) if f.shape.startswith("packet") else np.arange(-4.0, 4.01, 0.5)
        far = [w * steps[-1] * 1.5**k for k in range(60)]
        turns = (0.0,) if drawn.base != "rotor" else (-2 * np.pi, 0.0, 2 * np.pi)
        for turn in turns:
            found |= {c + turn + x for x in (*(w * steps), *far, *(-x for x in far))}
    return sorted(float(x) for x in found if low < x < high)


@functools.lru_cache(maxsize=4)
def _rule(count: int) -> list[tuple[mpf, mpf]]:
    """Gauss–Legendre on (−1, 1): numpy's nodes, improved by Newton's method."""
    found = []
    with mp.workdps(DIGITS + 10):
        for guess in np.polynomial.legendre.leggauss(count)[0]:
            x = mp.mpf(float(guess))
            for _ in range(3):
                below, here = mp.one, x
                for n in range(2, count + 1):
                    below, here = here, ((2 * n - 1) * x * here - (n - 1) * below) / n
                slope = count * (x * here - below) / (x * x - 1)
                x -= here / slope
            found.append((+x, 2 / ((1 - x * x) * slope**2)))
    return found


def _sums(at: Callable[[mpf], tuple[mpf, mpf]], edges: list[mpf]) -> tuple[mpf, mpf]:
    """∫ √(F)·s and ∫ s/√F over the pieces, (F, s) = at(χ)."""
    scale = (edges[-1] - edges[0]) * at((edges[0] + edges[-1]) / 2 + (edges[-1] - edges[0]) / 31)[1]
    total = [mp.zero, mp.zero]
    for a, b in itertools.pairwise(edges):
        for k, part in enumerate(_piece(at, a, b, scale)):
            total[k] += part
    return total[0], total[1]


def _piece(at: Callable[[mpf], tuple[mpf, mpf]], a: mpf, b: mpf, scale: mpf, depth: int = 12) -> list[mpf]:
    approximate, fine = (_once(at, a, b, count) for count in (20, 28))
    if all(abs(x - y) <= _AGREE * (abs(y) + abs(scale)) for x, y in zip(approximate, fine, strict=True)):
        return fine
    if not depth:
        raise ArithmeticError("two rules do not agree")
    halves = (_piece(at, *ends, scale, depth - 1) for ends in ((a, (a + b) / 2), ((a + b) / 2, b)))
    return [x + y for x, y in zip(*halves, strict=True)]


def _once(at: Callable[[mpf], tuple[mpf, mpf]], a: mpf, b: mpf, count: int) -> list[mpf]:
    action = time = mp.zero
    half = (b - a) / 2
    for x, weight in _rule(count):
        F, s = at(a + half * (1 + x))
        root = mp.sqrt(F)
        action += weight * root * s
        time += weight * s / root
    return [action * half, time * half]


def draws(seed: int, count: int) -> Iterator[Draw]:
    """Return the first draws of a seed."""
    return (draw(seed, index) for index in range(count))
