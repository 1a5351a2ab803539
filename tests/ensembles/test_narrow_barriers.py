"""Librations next to a narrow barrier, p² growing without bound beyond it: a walk outward must not step over it."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve

COUNT = 40


def beside_a_barrier(seed: int) -> tuple[hjsolve.System, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Orbits about −1/r − a/r³ with E from 1e-3 to 1e-9 of the barrier below it, started where V_eff is least.

    V_eff = −1/r + L²/(2r²) − a/r³ has its barrier and its well at r = ½(L² ∓ √(L⁴ − 12a)); the barrier is below 0 for
    L⁴ < 16a.
    """
    dice = np.random.default_rng(seed)
    hundredths = int(dice.integers(20, 200))
    a, L = hundredths / 100, (dice.uniform(12.5, 15.5, COUNT) * hundredths / 100) ** 0.25
    barrier, well = ((L**2 + side * np.sqrt(L**4 - 12 * a)) / 2 for side in (-1, 1))

    def potential(r: np.ndarray) -> np.ndarray:
        return -1 / r + L**2 / (2 * r**2) - a / r**3

    depth = 10.0 ** dice.uniform(-9, -3, COUNT)
    p = np.sqrt(2 * (potential(barrier) * (1 + depth) - potential(well))) * dice.choice([-1, 1], COUNT)
    system = hjsolve.System(
        {"r": "0 < r", "phi": "angle"}, "(dot(r)**2 + r**2*dot(phi)**2)/2", f"-1/r - {hundredths}/100/r**3"
    )
    return system, {"r": well, "phi": np.zeros(COUNT)}, {"r": p, "phi": L}


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [2, 11])
def test_the_well_of_the_start_is_kept(seed: int) -> None:
    """No single motion is needed; actions, frequencies and turning points agree with those in 30 digits."""
    system, q, p = beside_a_barrier(seed)
    want = {"actions", "frequencies", "turning_points"}
    batch = hjsolve.ensemble(system, q, p, want=want, fallback=False)
    assert batch.summary()["ok"] == COUNT
    solution = hjsolve.solve(system)
    for k in range(0, COUNT, 4):
        start = {"q": {n: float(x[k]) for n, x in q.items()}, "p": {n: float(x[k]) for n, x in p.items()}}
        motion = solution.motion(**start, digits=30)
        for quantity in ("actions", "frequencies"):
            exact, found = getattr(motion, quantity)["r"].value, getattr(batch, quantity)["r"][k]
            assert abs(mpmath.mpf(float(found)) - exact) <= batch.error[quantity]["r"][k]
        for end, exact in zip(("lower", "upper"), motion.turning_points["r"], strict=True):
            column = f"turning_points.r.{end}"
            assert abs(mpmath.mpf(float(batch.columns[column][k])) - exact.value) <= batch.columns[f"error.{column}"][k]
