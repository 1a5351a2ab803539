"""Semiclassical levels against exact ones: ``python -m benchmarks.levels`` prints the table of docs/levels.md.

The exact ones: closed forms; a matrix over spherical harmonics (spherical pendulum); matrices over the two-dimensional
oscillator in u and in v (hydrogen in a field, energies of resonances whose width is far below the last digit); for the
hydrogen molecular ion at R = 2 the separation constants of Jaffé's series in xi and of Legendre's in eta, made equal.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

import hjsolve

FIELD, GRAVITY, SIZE = 0.0003, 9.81, 20

Row = tuple[str, str, float, float, str]


def sphere(m: int, g: float, size: int = 60) -> np.ndarray:
    """Exact levels of -Laplacian/2 - g cos(theta) on the sphere."""
    l = np.arange(abs(m), abs(m) + size)
    coupling = np.sqrt((l[1:] ** 2 - m**2) / (4 * l[1:] ** 2 - 1.0))
    return np.linalg.eigvalsh(np.diag(l * (l + 1) / 2) - g * (np.diag(coupling, 1) + np.diag(coupling, -1)))


def oscillator_square(m: int, size: int) -> np.ndarray:
    """Return the matrix of r^2 over the states of a two-dimensional oscillator with frequency 1."""
    n = np.arange(size)
    side = -np.sqrt(n[1:] * (n[1:] + m))
    return np.diag(2.0 * n + m + 1) + np.diag(side, 1) + np.diag(side, -1)


def fraction(E: float, field: float, n: int, m: int) -> float:
    """Return the n-th eigenvalue Z of p^2/2 - E r^2 + field r^4/2 in the plane, for one m."""
    frequency = np.sqrt(-2 * E)
    square = oscillator_square(m, SIZE + 4)
    kinetic = (np.diag(2.0 * np.arange(SIZE + 4) + m + 1) - square / 2)[:SIZE, :SIZE]
    scaled = square / frequency
    H = frequency * kinetic - E * scaled[:SIZE, :SIZE] + field / 2 * (scaled @ scaled)[:SIZE, :SIZE]
    return float(np.linalg.eigvalsh(H)[n])


def stark(n1: int, n2: int, m: int, field: float) -> float:
    """E at which the shares of both parabolic coordinates add up to 2, below the barrier; bisection."""

    def excess(E: float) -> float:
        return fraction(E, field, n1, m) + fraction(E, -field, n2, m) - 2

    low, high = -0.6 / (n1 + n2 + m + 1) ** 2, -0.45 / (n1 + n2 + m + 1) ** 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) * excess(low) > 0 else (low, middle)
    return (low + high) / 2


def around(p: float, n: int, m: int, size: int = 60) -> float:
    """Return A of ((1 - y^2) S')' + (A - ... + p^2 y^2 - m^2/(1 - y^2)) S = 0 in normalised Legendre functions."""
    l = np.arange(m, m + size)
    side = np.sqrt(((l[:-1] + 1.0) ** 2 - m * m) / (4 * (l[:-1] + 1.0) ** 2 - 1))
    y = np.diag(side, 1) + np.diag(side, -1)
    return float(np.sort(np.linalg.eigvalsh(np.diag(l * (l + 1.0)) - p * p * (y @ y)))[n])


def outwards(p: float, n: int, m: int, distance: float, size: int = 120) -> float:
    """Return A of the radial equation by Jaffé's series, Z. Physik 87 (1934) 535: a tridiagonal matrix."""
    s, k = 2 * distance / (2 * p) - m - 1, np.arange(size)
    middle = 2 * k * k + (4 * p - 2 * s) * k + p * p - 2 * p * s - (m + 1) * (m + s)
    after, before = (k + 1.0) * (k + m + 1), (k - 1 - s) * (k - 1 - m - s)
    matrix = np.diag(middle) - np.diag(after[:-1], 1) - np.diag(before[1:], -1)
    return float(np.sort(np.linalg.eigvals(matrix).real)[n])


def hydrogen_ion(n: int, nodes: int, m: int, distance: float = 2.0) -> float:
    """Energy of the electron of H2+ with n nodes in xi and others in eta, by bisection of E in -2 ... -0.1."""

    def excess(E: float) -> float:
        p = distance * np.sqrt(-E / 2)
        return outwards(p, n, m, distance) + around(p, nodes, m)

    low, high = -2.0, -0.1
    for _ in range(60):
        centre = (low + high) / 2
        low, high = (centre, high) if excess(centre) * excess(low) > 0 else (low, centre)
    return (low + high) / 2


def rows() -> Iterator[Row]:
    """Yield system, quantum numbers, semiclassical and exact energy, and a mark."""

    def compared(title: str, found: hjsolve.Levels, exact: Callable[[hjsolve.Level], float | None]) -> Iterator[Row]:
        for level in found:
            numbers = ", ".join(str(n) for n in level.numbers.values())
            value = exact(level) if all(n >= 0 for n in level.numbers.values()) else None
            if value is not None:
                mark = "near a separatrix" if level.near_separatrix else ""
                yield title, numbers, float(level.energy.value), value, mark

    levels = hjsolve.levels
    yield from compared(
        "hydrogen", levels("kepler-spherical", up_to="-0.1"), lambda lv: -0.5 / (1 + sum(lv.numbers.values())) ** 2
    )
    yield from compared("oscillator", levels("harmonic-oscillator", up_to=2), lambda lv: lv.numbers["x"] + 0.5)
    quantum = 0.1 * np.sqrt(2)

    def morse(level: hjsolve.Level) -> float:
        harmonic = quantum * (level.numbers["x"] + 0.5)
        return harmonic - harmonic**2 / 4

    yield from compared("Morse, hbar = 0.1", levels("morse", hbar="0.1", numbers={"x": (0, 6, 12)}), morse)
    yield from compared("spherical pendulum, hbar = 1/2", levels("spherical-pendulum", hbar="0.5", up_to=-4),
                        lambda lv: 0.25 * sphere(lv.numbers["phi"], 4 * GRAVITY)[lv.numbers["theta"]])  # fmt: skip
    ionised = levels("stark", up_to="-0.053", parameters={"F": str(FIELD)})
    yield from compared(f"hydrogen in a field, F = {FIELD}", ionised,
                        lambda lv: stark(lv.numbers["u"], lv.numbers["v"], lv.numbers["phi"], FIELD))  # fmt: skip
    yield from compared("H2+, R = 2", levels("two-centres-space", up_to="-0.21", parameters={"k2": 1}),
                        lambda lv: hydrogen_ion(*(abs(n) for n in lv.numbers.values())))  # fmt: skip


def main() -> int:
    """Print the table."""
    found = list(rows())
    print("| system | numbers | semiclassical | exact | difference | |\n|---|---|---|---|---|---|")
    for before, (title, numbers, energy, exact, mark) in pairwise([("", "", 0.0, 0.0, ""), *found]):
        name = title if title != before[0] else ""
        difference = energy - exact
        shown = "0" if abs(difference) < 1e-14 else f"{difference:.1e}"
        print(f"| {name} | {numbers} | {energy:.10f} | {exact:.10f} | {shown} | {mark} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
