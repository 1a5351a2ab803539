"""Random motions over the whole catalog: parameters, places and velocities drawn around each entry's own motions.

A motion is a function of (seed, index) alone, so a campaign can be stopped, resumed and sampled. Some draws are hard on
purpose: coordinates that start exactly at rest (at a turning point), velocities ten thousand times smaller than the
others, places next to an end of the domain, exact decimal input and floats in equal parts.
"""

from __future__ import annotations

import functools
import math
import random
from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve import catalog
from hjsolve.errors import NotSeparableError
from hjsolve.formulas.read import number
from hjsolve.solution.quadratures import Solution, solve

Given = Mapping[str, object]


@dataclass(frozen=True)
class Draw:
    """Initial data of one random motion; ``times`` are in units of its slowest period, ``far`` is a long one."""

    index: int
    entry: str
    q: Given
    velocity: Given
    parameters: Given
    times: tuple[float, ...]
    far: float

    @property
    def arguments(self) -> dict[str, Given]:
        """The keyword arguments for ``solution.motion``."""
        return {"q": self.q, "velocity": self.velocity, "parameters": self.parameters}


@functools.cache
def entries() -> tuple[str, ...]:
    """All entries of the catalog whose system separates in the coordinates it is given in."""
    return (*catalog.ids("separable"), *(name for name in catalog.ids("extended") if solution(name) is not None))


@functools.cache
def solution(name: str) -> Solution | None:
    """The solution of an entry; None for one that is solved in another frame only, or is not given by T and V."""
    system = catalog.describe(name).system
    try:
        return None if system is None else solve(system)
    except NotSeparableError:
        return None


def draw(seed: int, index: int, attempt: int = 0) -> Draw:
    """Draw a random motion; the next ``attempt`` where one falls outside a domain."""
    rng = random.Random(f"{seed}/{index}/{attempt}")
    name = entries()[index % len(entries())]
    described = catalog.describe(name)
    system, begin = described.system, rng.choice(list(described.motions.values()))
    base = {p.symbol: float(number(begin.parameters.get(p.name, p.value), source=p.name)) for p in system.parameters}
    written = rng.choice([_decimal, float])
    parameters = {
        p.name: written(base[p.symbol] * 10 ** rng.uniform(-0.4, 0.4))
        for p in system.parameters
        if rng.random() < 0.6 and base[p.symbol]
    }
    numbers = base | {p.symbol: float(parameters[p.name]) for p in system.parameters if p.name in parameters}
    places = {c.name: float(number(begin.q[c.name], source=c.name)) for c in system.coordinates}
    given = begin.velocity or begin.p or {}
    speeds = {n: float(number(v, source=n)) for n, v in given.items()}
    scale = max((abs(v) for v in speeds.values()), default=0.0) or 1.0
    return Draw(
        index,
        name,
        {c.name: written(_place(c, places[c.name], numbers, rng)) for c in system.coordinates},
        {c.name: written(_speed(speeds.get(c.name, 0.0), scale, rng)) for c in system.coordinates},
        parameters,
        (0.0, *(rng.uniform(-1, 1) for _ in range(2)), rng.uniform(0, 3), rng.uniform(-12, 12)),
        10 ** rng.uniform(2, 7),
    )


def _decimal(value: float) -> str:
    """Three significant digits as an exact decimal."""
    return f"{value:.3g}"


def _place(coordinate: object, base: float, numbers: Mapping[sp.Symbol, float], rng: random.Random) -> float:
    domain = coordinate.domain
    if domain.kind == "angle":
        return rng.choice([base, rng.uniform(-3.1, 3.1)])
    low, high = (_end(end, numbers) for end in (domain.lower, domain.upper))
    if low is not None and high is not None:
        fraction = rng.uniform(0.05, 0.95) if rng.random() < 0.9 else 10 ** rng.uniform(-4, -1)
        return low + (high - low) * fraction
    if low is not None:
        return low + abs(base - low) * 10 ** rng.uniform(-0.4, 0.4)
    if high is not None:
        return high - abs(high - base) * 10 ** rng.uniform(-0.4, 0.4)
    return 0.0 if rng.random() < 0.1 else base + 0.5 * max(abs(base), 0.5) * rng.gauss(0, 1)


def _end(end: sp.Expr | None, numbers: Mapping[sp.Symbol, float]) -> float | None:
    """An end of a domain; None too where the parameters drawn leave none (the engine refuses them, and says why)."""
    value = None if end is None else sp.N(end.subs(numbers))
    return float(value) if value is not None and value.is_real else None


def _speed(base: float, scale: float, rng: random.Random) -> float:
    chance = rng.random()
    if chance < 0.12:
        return 0.0
    size = base * 10 ** rng.uniform(-0.3, 0.2) if base and chance < 0.6 else scale * rng.gauss(0, 0.7)
    return size * 1e-4 if chance > 0.93 else math.copysign(max(abs(size), 1e-3 * scale), size or 1.0)
