"""Librations just below a barrier: two zeros of p² close to each other, which doubles do not tell apart (extra fast)."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from benchmarks.kerr_orbits import about_kerr
from hjsolve.arithmetic.machine.compiling import available

pytestmark = pytest.mark.skipif(not available(), reason="numba")
COUNT = 48
WANT = ("actions", "frequencies", "angles")


def in_a_box(seed: int) -> tuple[hjsolve.System, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Two wells between walls at −1 and 1, E from 1e-3 to 1e-12 below the barrier, either well; seen from both walls."""
    dice = np.random.default_rng(seed)
    tilt, height = int(dice.integers(1, 9)), int(dice.integers(4, 30))
    text = f"1/(1 - x**2) + {height}*(1 - x**2)**2 + {tilt}*x/10"

    def potential(x: np.ndarray) -> np.ndarray:
        return 1 / (1 - x**2) + height * (1 - x**2) ** 2 + tilt * x / 10

    grid = np.linspace(-0.99, 0.99, 200_001)
    left, middle, right = np.split(grid, [len(grid) // 3, 2 * len(grid) // 3])
    wells = [side[potential(side).argmin()] for side in (left, right)]
    well = np.where(dice.random(COUNT) < 0.5, *wells)
    top = middle[potential(middle).argmax()]
    for _ in range(60):  # the top of the barrier, where V′ = 0
        slope = 2 * top / (1 - top**2) ** 2 - 4 * height * top * (1 - top**2) + tilt / 10
        top -= slope / (2 / (1 - top**2) ** 2 + 8 * top**2 / (1 - top**2) ** 3 - 4 * height * (1 - 3 * top**2))
    energy = potential(np.array(top)) - 10.0 ** dice.uniform(-12, -3, COUNT)
    p = np.sqrt(2 * (energy - potential(well))) * dice.choice([-1, 1], COUNT)
    return hjsolve.System({"x": "-1 < x < 1"}, "dot(x)**2/2", text), {"x": well}, {"x": p}


def about_a_black_hole(seed: int) -> tuple[hjsolve.System, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Orbits of Kerr's a = 9/10 in the well outside the barrier, 1e-8 … 1e-4 of E below it (Carter 1968)."""
    q, p = about_kerr(np.random.default_rng(seed), 4 * COUNT, barely=True)
    rows = {n: np.broadcast_to(x, q["r"].shape)[:COUNT] for n, x in q.items()}
    momenta = {n: np.broadcast_to(x, q["r"].shape)[:COUNT] for n, x in p.items()}
    return hjsolve.catalog.load("kerr"), rows, momenta


@pytest.mark.nightly_cases("in_a_box-7")
@pytest.mark.parametrize(("make", "seed"), [
    (in_a_box, 7), pytest.param(in_a_box, 1, marks=pytest.mark.nightly),
    pytest.param(about_a_black_hole, 1, marks=pytest.mark.nightly),
])  # fmt: skip
def test_the_engine_alone_knows_them_to_the_last_digits(make, seed) -> None:
    """Nothing is left to single motions; claims are small, and hold against motions in 30 digits."""
    system, q, p = make(seed)
    parameters = {"a": "9/10"} if "r" in q else {}
    batch = hjsolve.ensemble(system, q, p, want=WANT, parameters=parameters, fallback=False)
    assert batch.summary()["ok"] == COUNT
    name = "r" if "r" in q else "x"
    assert np.all(batch.error["frequencies"][name] <= 1e-12 * np.abs(batch.frequencies[name]))
    solution = hjsolve.solve(system)
    for k in range(0, COUNT, 9):
        start = {"q": {n: float(x[k]) for n, x in q.items()}, "p": {n: float(x[k]) for n, x in p.items()}}
        motion = solution.motion(**start, parameters=parameters, digits=30)
        angle = motion.angles(0)[name]
        for quantity, exact in (
            ("actions", motion.actions[name].value), ("frequencies", motion.frequencies[name].value), ("angles", angle),
        ):  # fmt: skip
            missed = mpmath.mpf(float(getattr(batch, quantity)[name][k])) - exact
            missed -= 2 * mpmath.pi * mpmath.nint(missed / (2 * mpmath.pi)) if quantity == "angles" else 0
            assert abs(missed) <= batch.error[quantity][name][k], (k, quantity)
