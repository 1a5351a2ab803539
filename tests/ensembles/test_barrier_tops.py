"""Orbits that pass slowly over a crest of their potential stay in the batch, with claims that hold."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.error_free import Pair
from hjsolve.ensembles.engine.kernels.start_phase import moved_by_barrier_top
from hjsolve.ensembles.engine.nodes import barrier_top_nodes, barrier_top_places
from hjsolve.ensembles.engine.strips_of_analyticity import _halves, barrier_top_disks, half_width

digits = mpmath.mp.clone()
digits.dps = 40


def double_well(v: float, x: float) -> tuple[float, float]:
    """Ω and θ of x⁴/4 − x²/2 at x, with speed v over the crest, going up (DLMF 22.15.11).

    p² = v² + x² − x⁴/2 = ½ (a² − x²)(x² + b²).
    """
    energy = 2 * digits.mpf(v) ** 2
    root = digits.sqrt(1 + energy)
    a2, b2 = 1 + root, energy / (1 + root)
    parameter = a2 / (a2 + b2)
    scale = digits.sqrt((a2 + b2) / 2)
    Ω = digits.pi * scale / (2 * digits.ellipk(parameter))
    # x = a cn(u): u from the upper turning point, which is half a turn after the lower one
    return float(Ω), float(digits.pi - Ω * digits.ellipf(digits.acos(x / digits.sqrt(a2)), parameter) / scale)


@pytest.mark.parametrize("v", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 2e-6])
def test_a_double_well_passed_slowly_has_its_closed_form(v: float) -> None:
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4 - x**2/2"))
    x = np.array([0.0, 1e-7, -3e-4, 0.02, -0.7, 1.2])
    p = np.array([np.sqrt(v**2 + s * s - s**4 / 2) for s in x])
    batch = hjsolve.ensemble(
        solution, q={"x": x}, p={"x": p}, want={"frequencies", "angles", "constants"}, fallback=False
    )
    assert (batch.codes == 0).all()
    for k, s in enumerate(x):
        # of the constants that the batch has from q and p, which are doubles
        speed = digits.sqrt(digits.mpf(p[k]) ** 2 - digits.mpf(s) ** 2 + digits.mpf(s) ** 4 / 2)
        Ω, θ = double_well(speed, float(s))
        assert abs(batch.frequencies["x"][k] - Ω) <= batch.error["frequencies"]["x"][k]
        assert abs(np.remainder(batch.angles["x"][k] - θ + np.pi, 2 * np.pi) - np.pi) <= batch.error["angles"]["x"][k]


POTENTIALS = (
    ("x**2/2 + 2*exp(-3*(x - 1/4)**2)", 0.2731),
    ("x**4/4 - x**2/2 + x/10", 0.1010),
    ("x**6/6 - x**4 + 3*x**2/2 + x/20", -0.9873),
    ("x**2/5 + 2/(1 + 30*(x - 4/5)**2)", 0.7957),
    ("cosh(x) + 5/cosh(3*x - 1)**2", 0.3231),
)


@pytest.mark.nightly
@pytest.mark.parametrize(("potential", "near"), POTENTIALS)
def test_crests_anywhere_agree_with_single_motions(potential: str, near: float) -> None:
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", potential))
    x, p = np.full(5, near), np.array([0.3, -3e-2, 1e-3, 1e-4, -1e-4])
    want = {"actions", "frequencies", "angles"}
    batch = hjsolve.ensemble(solution, q={"x": x}, p={"x": p}, want=want, fallback=False)
    assert (batch.codes == 0).all()
    for k in range(5):
        motion = solution.motion(q={"x": near}, p={"x": float(p[k])}, digits=30)
        for name, value in (("actions", motion.actions["x"]), ("frequencies", motion.frequencies["x"])):
            assert abs(float(value) - getattr(batch, name)["x"][k]) <= batch.error[name]["x"][k]
        away = float(motion.angles(0)["x"]) - batch.angles["x"][k]
        assert abs(np.remainder(away + np.pi, 2 * np.pi) - np.pi) <= batch.error["angles"]["x"][k]


@pytest.mark.parametrize("level", [1, 7, 20, 44])
def test_nodes_about_a_crest_are_those_of_cn(level: int) -> None:
    χ = np.array([1e-3, 0.4, 1.4, np.pi / 2, 1.8, 3.1])
    complement, quarter, x, y, root = barrier_top_places(Pair(χ, 0 * χ), level)
    k2, K = 1 - digits.mpf(complement), digits.mpf(quarter)
    for j, anomaly in enumerate(χ):
        u = 2 * digits.ellipk(k2) * digits.mpf(anomaly) / digits.pi
        sn, cn, dn = (digits.ellipfun(name, u, m=k2) for name in ("sn", "cn", "dn"))
        for found, true in ((x[j], (1 - cn) / 2), (y[j], (1 + cn) / 2), (root[j], K / digits.pi * sn * dn)):
            assert abs(found - true) <= 1e-15 * abs(true)


@pytest.mark.parametrize("barrier_top", [1.0, 0.3, 7.0, 1e-4, 1e5])
def test_the_middle_goes_to_the_crest(barrier_top: float) -> None:
    def ratio(X: mpmath.mpf) -> mpmath.mpf:  # x/(1 − x) = crest X/(1 − X)
        times = digits.mpf(barrier_top) * X / (1 - X)
        return times / (1 + times)

    for X in (0.5, 0.01, 0.3, 0.8):
        x, y, root = moved_by_barrier_top(X, 1 - X, 1.0, barrier_top)
        assert x == pytest.approx(float(ratio(digits.mpf(X))), rel=1e-15)
        assert x + y == pytest.approx(1.0, rel=1e-15)
        assert root == pytest.approx(float(digits.diff(ratio, digits.mpf(X))), rel=1e-14)


@pytest.mark.parametrize(("level", "count"), [(1, 32), (6, 96), (14, 192), (30, 512)])
def test_every_place_of_the_strip_about_a_crest_lies_in_a_disk(level: int, count: int) -> None:
    dice, table = np.random.default_rng(level), barrier_top_nodes(count, level)
    low, high, radii = barrier_top_disks(table)
    assert np.isfinite(radii).all()
    χ = dice.uniform(0, np.pi, 400) + 1j * half_width(count, 1) * dice.uniform(0, 1, 400)
    x, y = _halves(χ, table)
    near = np.minimum(np.abs(x[:, None] - low), np.abs(y[:, None] - high)) <= radii * (1 + 1e-9)
    assert near.any(axis=1).all()


def test_a_strip_with_a_pole_of_the_map_is_not_covered() -> None:
    assert np.isinf(barrier_top_disks(barrier_top_nodes(16, 20))[2]).all()
