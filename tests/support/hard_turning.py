"""Tops and spherical pendulums in hard states: the start, what is hard, and the truth by elliptic functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy
from mpmath import mp, mpf

import hjsolve
from tests.support import hard_exact
from tests.support.hard_cases import real, spread

AMPLE = 90
"""Digits for the references: 1 − z loses as many as the distance to the pole is small."""


@dataclass(frozen=True)
class Turning:
    """A tilted axis released where it nods at its highest or lowest.

    Attributes:
        name: short and unique. why: what makes it hard.
        entry: of the catalog. q, velocity: the start. parameters: other than the default.
        h, axial: mgl and I_a (I_t = 1); axial 0 for a pendulum.
        span: times ± span.
        kind: of theta.
    """

    name: str
    why: str
    entry: str
    q: Mapping[str, str]
    velocity: Mapping[str, str]
    span: float
    h: str = "1"
    axial: str = "0"
    parameters: Mapping[str, str] | None = None

    @property
    def times(self) -> tuple[str, ...]:
        return spread(self.span)

    def motion(self, digits: int = 15) -> Any:
        return solved(self.entry).motion(q=self.q, velocity=self.velocity, parameters=self.parameters, digits=digits)

    def truth(self) -> hard_exact.Nutation:
        """The reference; to be called with ``AMPLE`` digits."""
        θ = mpf(sympy.N(sympy.sympify(self.q["theta"], rational=True), AMPLE + 20))
        if self.entry == "spherical-pendulum":
            return hard_exact.Nutation(real(self.h), mp.sin(θ) ** 2 * real(self.velocity["phi"]), mpf(0), -mp.cos(θ))
        ψ̇, φ̇ = real(self.velocity["psi"]), real(self.velocity["phi"])
        c = real(self.axial) * (φ̇ - ψ̇ * mp.sin(θ))
        return hard_exact.Nutation(
            real(self.h), -c * mp.sin(θ) + ψ̇ * mp.cos(θ) ** 2, c, mp.sin(θ), 1 / real(self.axial)
        )

    def place(self, truth: hard_exact.Nutation, t: mpf) -> dict[str, mpf]:
        """Coordinates at t; azimuth and spin unwrapped, counted from the start."""
        z, ψ, φ = truth.at(t)
        if self.entry == "spherical-pendulum":
            return {"theta": mp.acos(-z), "phi": ψ}
        return {"theta": mp.asin(z), "psi": ψ, "phi": φ}


@cache
def solved(entry: str) -> Any:
    return hjsolve.solve(hjsolve.catalog.load(entry))


def pendulum(name: str, why: str, theta: str, rate: str, span: float = 60.0) -> Turning:
    return Turning(name, why, "spherical-pendulum", {"theta": theta, "phi": "0"}, {"theta": "0", "phi": rate}, span,
                   parameters={"g": "1"})  # fmt: skip


def top(name: str, why: str, theta: str, psi: str, phi: str, span: float = 60.0) -> Turning:
    return Turning(name, why, "lagrange-top", {"theta": theta, "psi": "0", "phi": "0"},
                   {"theta": "0", "psi": psi, "phi": phi}, span, axial="1/2")  # fmt: skip


def turning() -> list[Turning]:
    """All of them."""
    pole = "a pole of the centrifugal barrier just outside the motion; phi jumps by π there"
    small = "turning points closer than the rounding of the constants"
    return [
        *(pendulum(f"spherical pendulum, dphi/dt = {v} at theta = 1", pole, "1", v) for v in ("1e-3", "1e-6", "1e-12")),
        pendulum("spherical pendulum, nearly upright and nearly through both poles", pole + "; long dwell at the top", "3.14", "1e-9"),
        *(pendulum(f"nearly conical pendulum, one part in 1e{n}", small, "acos(1/4)", f"2.{'0' * (n - 1)}2") for n in (4, 8, 12)),
        top("top with cusps", "the precession stops at the upper turning point", "1/2", "0", "6"),
        top("top with loops", "the precession changes its sign", "1/2", "-0.3", "6"),
        top("top with waves", "neighbour of the cusps", "1/2", "1e-9", "6"),
        *(top(f"nearly steady top, one part in 1e{n}", small, "pi/6", f"-1.{'0' * (n - 1)}1", "5/2") for n in (4, 8, 12)),
        *(top(f"nearly sleeping top, {name}, tilted by {x}", "both turning points next to the pole" if name == "stable" else "next to the separatrix of the sleeping top", f"pi/2 - {x}", "-1/2", phi, 40.0)
          for name, phi in (("stable", "6"), ("critical", "4"), ("unstable", "2")) for x in ("1/1000", "1e-6")),
    ]  # fmt: skip
