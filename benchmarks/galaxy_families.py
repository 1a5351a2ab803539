"""Stars of a Kuzmin–Kutuzov galaxy: the five families of the references, and a disc with a halo.

GM = Δ = 1, a/c = 5 (c² = 1/24): Φ(R, z) = −1/(√λ + √ν) with λ, ν the roots of the prolate quadratic. All rows are
cylindrical, R, v_R, v_T, z, v_z, in doubles; ``prolate`` carries them over with one rounding.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import hjsolve
from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair

DATA = Path(__file__).resolve().parents[1] / "tests" / "support"
FAMILIES = ("generic", "near-circular", "near-planar", "near-radial", "near-unbound")
_C2 = 1 / 24
_A2 = 25 / 24
Array = Any


def galaxy() -> hjsolve.Solution:
    """Return the galaxy in prolate coordinates as somebody types it, c² being a parameter."""
    return hjsolve.solve(
        hjsolve.System(
            coordinates={"u": "0 < u", "w": "-pi/2 < w < pi/2", "phi": "angle"},
            kinetic="1/2*(sinh(u)**2 + cos(w)**2)*(dot(u)**2 + dot(w)**2) + 1/2*sinh(u)**2*cos(w)**2*dot(phi)**2",
            potential="-(sqrt(c2 + cosh(u)**2) - sqrt(c2 + sin(w)**2))/(sinh(u)**2 + cos(w)**2)",
            parameters={"c2": "1/24"},
        )
    )


def potential(R: Array, z: Array) -> Array:
    """Φ(R, z): √λ + √ν is the root of λ + ν + 2√(λν)."""
    total, product = R**2 + z**2 + _A2 + _C2, _A2 * _C2 + _C2 * R**2 + _A2 * z**2
    return -1 / np.sqrt(total + 2 * np.sqrt(product))


def circular_speed(R: Array) -> Array:
    """v_c in the plane, where λ = R² + a² and ν = c²."""
    root = np.sqrt(R**2 + _A2)
    return R / (np.sqrt(root) * (root + np.sqrt(_C2)))


def family(name: str, count: int, seed: int = 1) -> Array:
    """Rows of one of ``FAMILIES``; small quantities are spread evenly in their logarithm from 1e-2 to 1e-10.

    Args:
        name: of the family.
        count: number of stars.
        seed: of the generator.
    """
    rng = np.random.default_rng(seed)
    R, z = rng.uniform(0.3, 3.0, count), rng.uniform(-1.0, 1.0, count)
    small = 10 ** rng.uniform(-10, -2, count)
    if name == "near-circular":
        v, ξ = circular_speed(R), rng.uniform(-1, 1, (4, count))
        return np.stack([R, small * v * ξ[0], v * (1 + small * ξ[1]), small * R * ξ[2], small * v * ξ[3]], axis=1)
    if name == "near-planar":
        z = z * small
    fraction = 1 - small if name == "near-unbound" else rng.uniform(0.15, 0.8, count) ** 2
    v = np.sqrt(-2 * potential(R, z) * fraction)
    direction = rng.normal(size=(3, count))
    if name == "near-planar":
        direction[2] *= small
    if name == "near-radial":
        direction[1] *= small
    vR, vT, vz = v * direction / np.sqrt((direction**2).sum(axis=0))
    return np.stack([R, vR, np.where(vT == 0, 1e-3, vT), z, vz], axis=1)


def disc_and_halo(count: int, seed: int = 2) -> Array:
    """Return a thin disc (75 %), a thick disc (15 %) and a halo (10 %), roughly those of the Milky Way with Δ = 4 kpc.

    Discs: surface density falls like exp(−R/0.65) beyond R = 0.2, heights like sech² of 0.07 or 0.22; dispersions of
    v_R, v_T, v_z of 0.16, 0.11, 0.09 of v_c, or 0.3, 0.22, 0.2, and the mean v_T lags by 0.02 or 0.12 v_c. Halo: radii
    like r^−3 between 0.4 and 8, speeds below 0.95 of the speed of escape in directions that prefer the radius twofold.
    """
    rng = np.random.default_rng(seed)
    kind = rng.choice(3, size=count, p=[0.75, 0.15, 0.1])
    R = 0.2 + rng.gamma(2.0, 0.65, count)
    z = np.array([0.07, 0.22, 0.0])[kind] * np.arctanh(rng.uniform(-0.995, 0.995, count))
    v = circular_speed(R)
    spread = np.array([[0.16, 0.11, 0.09], [0.3, 0.22, 0.2], [0, 0, 0]])[kind].T
    vR, vT, vz = v * spread * rng.normal(size=(3, count))
    vT = vT + v * (1 - np.array([0.02, 0.12, 0.0])[kind])
    halo = kind == 2
    r, cosine = 0.4 * 20.0 ** rng.uniform(0, 1, count), rng.uniform(-1, 1, count)
    R, z = np.where(halo, r * np.sqrt(1 - cosine**2), R), np.where(halo, r * cosine, z)
    escape = np.sqrt(-2 * potential(R, z))
    direction = rng.normal(size=(3, count))
    outward = 2 * (direction[0] * np.sqrt(1 - cosine**2) + direction[2] * cosine)
    direction[0] += outward * np.sqrt(1 - cosine**2)
    direction[2] += outward * cosine
    direction = direction / np.sqrt((direction**2).sum(axis=0)) * escape * 0.95 * rng.uniform(0, 1, count) ** (1 / 3)
    vR, vT, vz = (np.where(halo, new, old) for new, old in zip(direction, (vR, vT, vz), strict=True))
    slow = np.minimum(1.0, 0.95 * escape / np.sqrt(vR**2 + vT**2 + vz**2))  # the tails of the discs stay bound, too
    return np.stack([R, slow * vR, slow * vT, z, slow * vz], axis=1)


def prolate(cylindrical: Array) -> Array:
    """Carry rows R, v_R, v_T, z, v_z over to u, w, p_u, p_w, p_φ: sinh(u + iw) = R + iz, in 32 digits, rounded once."""
    D = DoubleDouble()
    R, vR, vT, z, vz = (Pair(x, 0.0 * x) for x in cylindrical.T)
    first = np.arcsinh(cylindrical[:, 0] + 1j * cylindrical[:, 3])
    u, w = Pair(first.real, 0.0 * first.real), Pair(first.imag, 0.0 * first.imag)
    for _ in range(2):
        s, c, sn, cn = D.unary("sinh", u), D.unary("cosh", u), D.unary("sin", w), D.unary("cos", w)
        A, B = D.mul(c, cn), D.mul(s, sn)
        f, g = D.sub(D.mul(s, cn), R), D.sub(D.mul(c, sn), z)
        size = D.add(D.mul(A, A), D.mul(B, B))
        u = D.sub(u, D.div(D.add(D.mul(A, f), D.mul(B, g)), size))
        w = D.sub(w, D.div(D.sub(D.mul(A, g), D.mul(B, f)), size))
    s, c, sn, cn = D.unary("sinh", u), D.unary("cosh", u), D.unary("sin", w), D.unary("cos", w)
    A, B = D.mul(c, cn), D.mul(s, sn)
    pu, pw = D.add(D.mul(A, vR), D.mul(B, vz)), D.sub(D.mul(A, vz), D.mul(B, vR))
    return np.stack([x.high for x in (u, w, pu, pw, D.mul(R, vT))], axis=1)


def velocities(rows: Array) -> Array:
    """Carry rows u, w, p_u, p_w, p_φ over to u, w and the velocities u̇, ẇ, φ̇, in doubles."""
    u, w, pu, pw, pφ = rows.T
    size = np.sinh(u) ** 2 + np.cos(w) ** 2
    return np.stack([u, w, pu / size, pw / size, pφ / (np.sinh(u) * np.cos(w)) ** 2], axis=1)
