"""Random open motions with narrow features, and their times by mpmath's quadrature cut at the features.

A base on which a motion escapes, and one to three features: Gaussians, sech², Lorentzians and steps, of widths from
10⁻¹ to 10⁻⁶. Nothing of the references comes from hjsolve.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

import sympy as sp
from mpmath import mp

x = sp.Symbol("x")
BASES = (
    "0", "-x/2", "-1/cosh(x)**2", "tanh(x)/4", "-1/sqrt(1+x**2)", "exp(-x**2)/4", "-x**2/8", "1/(1+exp(-x))/3",
    "-exp(-x**2/2)", "1/(4+x**2)", "-log(1+x**2)/4",
)  # fmt: skip
SHAPES = ("({h})*exp(-(x-({c}))**2/({w})**2)", "({h})/cosh((x-({c}))/({w}))**2", "({h})/(1+(x-({c}))**2/({w})**2)",
          "({h})*tanh((x-({c}))/({w}))")  # fmt: skip


@dataclass(frozen=True)
class Feature:
    """A bump or step: text of the potential, place and width."""

    text: str
    place: sp.Rational
    width: sp.Rational


@dataclass(frozen=True)
class Escape:
    """A motion along x with T = ẋ²/2 that passes its features to the right, or starts at rest on a slope.

    Attributes:
        potential: V as text. start, velocity: as text.
        features: where V is narrow.
        goals: places to the right of the start that are passed.
    """

    potential: str
    start: str
    velocity: str
    features: tuple[Feature, ...]
    goals: tuple[str, ...]

    def cuts(self, end: Any) -> list[Any]:
        """Return where the quadrature to a place is cut, in order."""
        begin = mp.mpf(sp.Rational(self.start).p) / sp.Rational(self.start).q
        cuts = {begin, end, *(mp.mpf(k) / 2 for k in range(-2, 13))}
        for f in self.features:
            place, width = (mp.mpf(v.p) / v.q for v in (f.place, f.width))
            for k in range(-2, 24):
                cuts |= {place - width * mp.mpf(2) ** k, place, place + width * mp.mpf(2) ** k}
        cuts |= {begin + (end - begin) * mp.mpf(2) ** -k for k in range(1, 40)} if self.velocity == "0" else set()
        k = mp.mpf(6)
        while k < end:
            cuts.add(k)
            k *= 2
        return sorted(c for c in cuts if begin <= c <= end)

    def time(self, end: Any) -> Any:
        """Return the time from the start to a place, in the precision of mpmath's context."""
        V = sp.lambdify(x, sp.sympify(self.potential), "mpmath")
        begin = mp.mpf(sp.Rational(self.start).p) / sp.Rational(self.start).q
        speed = mp.mpf(sp.Rational(self.velocity).p) / sp.Rational(self.velocity).q
        height = V(begin)
        if speed:
            return mp.quad(lambda q: 1 / mp.sqrt(speed**2 + 2 * (height - V(q))), self.cuts(end))
        # q = begin + s²: the square root at the start is gone
        cuts = [mp.sqrt(c - begin) for c in self.cuts(end)]
        return mp.quad(lambda s: 2 * s / mp.sqrt(2 * (height - V(begin + s * s))), cuts)


def draw(chance: random.Random, *, narrowest: float = -6.0) -> Escape:
    """Return a random escape.

    Args:
        chance: the source.
        narrowest: log₁₀ of the least width.
    """
    base = chance.choice(BASES)
    features = []
    for _ in range(chance.randint(1, 3)):
        width = sp.Rational(f"{10 ** chance.uniform(narrowest, -1):.2e}")
        place = sp.Rational(f"{chance.uniform(0.3, 4):.4f}")
        height = f"{chance.choice((-1, 1)) * chance.uniform(0.02, 0.25):.3f}"
        shape = chance.choice(SHAPES)
        features.append(Feature(shape.format(h=height, c=place, w=width), place, width))
    potential = " + ".join([base, *(f.text for f in features)])
    start, velocity = f"{chance.uniform(-1, 0):.3f}", f"{chance.uniform(1.7, 2.5):.3f}"
    if (
        base == "-x/2"
        and chance.random() < 0.5
        and all(abs(sp.Rational(f.text.split(")")[0][1:])) < 0.1 for f in features)
    ):
        velocity = "0"
    return Escape(potential, start, velocity, tuple(features), ("5", f"{10 ** chance.uniform(1, 4):.3f}"))
