"""Momenta, energy and S of conics in doubles, with their errors: arrays over the conics of ``lambert.py``.

With γ = √(μs/2), ρ = (r₀ − r₁)/c, σ = √(1 − ρ²) (Izzo (2015), algorithm 1),

    v_r₀ = −(γ/r₀)[(x − λy) + ρ (x + λy)],  v_r₁ = (γ/r₁)[(x − λy) − ρ (x + λy)],  v_t = (γσ/r)(y + λx),

E/m = −μu/s, and from the eccentric anomalies ∫ v² dt = 2(μu/s) t + 4γ (x − λy), so that

    S/m = ∫ v² dt − (E/m) t = 3(μu/s) t + 4γ (x − λy)                                     (Greenwood (5-8), (5-65)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Reals
from hjsolve.two_point.kepler.central_places import CentralPlaces
from hjsolve.two_point.kepler.kernels.lambert import Conics, Transfer

_UNITS = 16.0
"""Roundings in one momentum."""


@dataclass(frozen=True)
class Column:
    """Values with errors, shape (n,)."""

    value: Reals
    error: Reals


@dataclass(frozen=True)
class ConicNumbers:
    """What follows from conics, columns over these.

    Attributes:
        p0, p1: in the order of the geometry.
        energy: E.
        principal_function: S.
        conjugate_points: in the plane.
    """

    p0: list[Column]
    p1: list[Column]
    energy: Column
    principal_function: Column
    conjugate_points: Integers


@dataclass(frozen=True)
class Problems:
    """Transfers, each in one direction, arrays of one shape.

    Attributes:
        places: in the direction of the motion.
        path: λ, 1 − λ², c and s.
        attraction: μ = k/m.
        mass: m.
        time: t.
    """

    places: CentralPlaces
    path: Transfer
    attraction: Reals
    mass: float
    time: Reals

    @property
    def wanted(self) -> Reals:
        """The time in the unit of T."""
        s = self.path.s
        return np.sqrt(2 * self.attraction / s) / s * self.time


def numbers_of(problems: Problems, found: Conics, senses: Integers) -> ConicNumbers:
    """Return momenta, E, S and the number of conjugate points of conics.

    Args:
        problems: what was asked.
        found: the conics.
        senses: 1 or −1 for each problem.
    """
    at = found.problem
    places, μ, t = problems.places, np.broadcast_to(problems.attraction, problems.time.shape)[at], problems.time[at]
    s, c, λ = problems.path.s[at], problems.path.chord[at], problems.path.λ[at]
    r0, r1, half = places.r0[at], places.r1[at], places.half_sine[at]
    x, u = np.where(found.w < found.v, found.w - 1, 1 - found.v), found.w * found.v
    γ, closed = np.sqrt(μ * s / 2), c == 0
    chord = np.where(closed, 1.0, c)
    ρ = np.where(closed, 0.0, (r0 - r1) / chord)
    σ = np.where(closed, 0.0, 2 * np.sqrt(r0 * r1) * half / chord)
    with np.errstate(all="ignore"):
        slope = λ * x / found.y  # dy/dx = λ · this
    slope = np.where(np.isfinite(slope), slope, 0.0)
    rest_slope, plus_slope, across_slope = 1 - λ**2 * slope, 1 + λ**2 * slope, λ * slope + λ
    speeds = []
    for r, sign in ((r0, -1), (r1, 1)):
        value = sign * γ / r * (found.rest - sign * ρ * found.plus)
        spread = γ / r * np.abs(rest_slope - sign * ρ * plus_slope) * found.error
        size = γ / r * (np.abs(found.rest) + np.abs(ρ * found.plus))
        around = senses[at] * γ * σ / r * found.across
        around_spread = γ * σ / r * np.abs(across_slope) * found.error + _UNITS * EPS * np.abs(around)
        speeds.append((Column(value, spread + _UNITS * EPS * size), Column(around, around_spread)))
    m = problems.mass
    p0, p1 = (
        [_momentum(m, radial, around, a[at] if np.ndim(a) else a, b[at] if np.ndim(b) else b)
         for a, b in zip(along, tangent, strict=True)]
        for (radial, around), along, tangent in (
            (speeds[0], places.radial0, places.tangent0), (speeds[1], places.radial1, places.tangent1)
        )
    )  # fmt: skip
    energy = -m * μ * u / s
    energy_error = m * μ / s * 2 * np.abs(x) * found.error + _UNITS * EPS * np.abs(energy)
    S = m * (3 * μ * u / s * t + 4 * γ * found.rest)
    S_slope = np.abs(-6 * μ * x / s * t + 4 * γ * rest_slope)
    size = m * (3 * μ * np.abs(u) / s * t + 4 * γ * np.abs(found.rest))
    S_error = m * S_slope * found.error + _UNITS * EPS * size
    N = found.turns
    conjugate = np.where(N == 0, 0, 2 * N - 1 + (found.slope < 0))
    return ConicNumbers(p0, p1, Column(energy, energy_error), Column(S, S_error), conjugate)


def _momentum(m: float, radial: Column, around: Column, along: Reals, tangent: Reals) -> Column:
    value = m * (radial.value * along + around.value * tangent)
    size = np.abs(radial.value * along) + np.abs(around.value * tangent)
    spread = radial.error * np.abs(along) + around.error * np.abs(tangent)
    return Column(value, m * (spread + 6 * EPS * size))
