"""Random bound orbits about a rotating black hole, as arrays: generic ones, and some next to the separatrix."""

from __future__ import annotations

from typing import Any

import numpy as np


def about_kerr(rng: np.random.Generator, n: int, *, barely: bool = False) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return starts of bound orbits about a black hole of spin 0.9, in the equator; some only just bound away from it.

    E of a turning point r of given L and Q solves R(r) = 0, R of Carter (1968); the separatrix has that of the barrier.
    """
    a, r, L = 0.9, rng.uniform(8, 14, n), rng.uniform(2.9, 3.6, n)
    upward = rng.uniform(0.3, 1.5, n)

    def turning(r: Any, L: Any, Q: Any) -> Any:
        Δ = r**2 - 2 * r + a**2
        square, twice = (r**2 + a**2) ** 2 - a**2 * Δ, 2 * a * L * r
        return (twice + np.sqrt(twice**2 - square * (a**2 * L**2 - Δ * (r**2 + L**2 + Q)))) / square

    Δ = r**2 - 2 * r + a**2
    if barely:  # the innermost stable circle has r = 2.32, L = 2.1; unbound orbits go over barriers of L > 2.63
        L, upward = rng.uniform(2.25, 2.5, n), rng.uniform(0.1, 0.4, n)
        barrier = turning(np.linspace(1.45, 2.3, 1000)[:, None], L, upward**2).max(axis=0)
        places = np.linspace(2.3, 12.0, 1000)[:, None]
        r = places[turning(places, L, upward**2).argmin(axis=0), 0]
        E, Δ = barrier * (1 - 10 ** rng.uniform(-8, -4, n)), r**2 - 2 * r + a**2
        R = (E * (r**2 + a**2) - a * L) ** 2 - Δ * (r**2 + (L - a * E) ** 2 + upward**2)
        keep = (R > 0) & (E < 1)
        r, L, upward, E, R, Δ = (x[keep] for x in (r, L, upward, E, R, Δ))
        pr = np.sqrt(R) / Δ
    else:
        E, pr = np.sqrt((1 - 2 / r) * (1 + L**2 / r**2)), 0.02 * rng.normal(size=n) * r**2 / Δ
    q = {"t": 0.0, "r": r, "theta": np.full(len(r), np.pi / 2), "phi": 0.0}
    return q, {"t": -E, "r": pr, "theta": upward, "phi": L}
