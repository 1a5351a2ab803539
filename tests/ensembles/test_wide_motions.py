"""Motions much wider than the features of their potential, and barriers that a search steps over."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve

WANT = {"actions", "frequencies", "turning_points", "angles"}


def by_quadrature(V: Any, energy: Any, cuts: list[Any]) -> tuple[Any, Any]:
    """J and Ω of one freedom between the first and the last cut, with x = c + h sin s in the outer pieces."""
    with mp.workdps(40):
        low, high = cuts[0], cuts[-1]
        middle, half = (low + high) / 2, (high - low) / 2
        angles = [mp.asin((c - middle) / half) for c in cuts]

        def momentum(s: Any) -> Any:
            return mp.sqrt(abs(2 * (energy - V(middle + half * mp.sin(s)))))

        action = mp.quad(lambda s: momentum(s) * half * mp.cos(s), angles) / mp.pi
        return action, mp.pi / mp.quad(lambda s: half * mp.cos(s) / momentum(s), angles)


@pytest.mark.parametrize("height", [30.0, 900.0, 2e4])
def test_a_motion_far_wider_than_the_rounded_tip_of_its_potential(height: float) -> None:
    # branch points at ±i are 1/height of the motion away: 123 of 400 such orbits went to single motions
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "sqrt(1 + x**2)")
    batch = hjsolve.ensemble(system, q={"x": [height, 0.3 * height]}, p={"x": 0.0}, want=WANT, fallback=False)
    assert (batch.status == "ok").all()
    for k, end in enumerate((mpf(height), mpf(0.3 * height))):
        with mp.workdps(40):
            cuts = sorted([*(s * 2**j for s in (-1, 1) for j in range(-3, int(mp.log(end, 2)))), -end, 0, end])
            action, rate = by_quadrature(lambda x: mp.sqrt(1 + x * x), mp.sqrt(1 + end * end), cuts)
        assert abs(batch.actions["x"][k] - action) <= batch.error["actions"]["x"][k]
        assert abs(batch.frequencies["x"][k] - rate) <= batch.error["frequencies"]["x"][k]
        assert batch.error["frequencies"]["x"][k] < 1e-11 * rate


def test_singularities_beside_the_middle_are_found() -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "sqrt(1/10 + (x - 7)**2) + x/3")
    x = 7 + np.geomspace(0.1, 1000, 40)
    batch = hjsolve.ensemble(system, q={"x": x}, p={"x": 0.1}, want=WANT, fallback=False)
    assert (batch.status == "ok").all()
    motion = hjsolve.solve(system).motion(q={"x": float(x[-1])}, p={"x": 0.1}, digits=25)
    assert abs(batch.actions["x"][-1] - mpf(motion.actions["x"].value)) <= batch.error["actions"]["x"][-1]


def test_a_barrier_that_the_search_stepped_over_ends_the_motion() -> None:
    # of 400 orbits 126 were refused, and each took the time of a single motion
    def V(x: Any) -> Any:
        return x * x / 2 + 3 * mp.exp(-20 * (x - mpf(1) / 2) ** 2)

    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2 + 3*exp(-20*(x - 1/2)**2)")
    x, p = np.array([2.246, -2.059, 1.906, 1.969]), np.array([0.45, 9.6e-5, 0.34, 0.086])
    batch = hjsolve.ensemble(system, q={"x": x}, p={"x": p}, want=WANT, fallback=False)
    assert (batch.status == "ok").all()
    with mp.workdps(40):
        for k in range(4):
            energy = mpf(float(p[k])) ** 2 / 2 + V(mpf(float(x[k])))
            inner = mp.findroot(lambda y, E=energy: V(y) - E, (0.5 + 0.1 * np.sign(x[k]), 0.5 + 0.4 * np.sign(x[k])))
            outer = mp.findroot(lambda y, E=energy: V(y) - E, mpf(float(x[k])) * (1 + mpf(1) / 50))
            low, high = sorted([inner, outer])
            action, rate = by_quadrature(V, energy, [low, low + (high - low) / 3, low + 2 * (high - low) / 3, high])
            assert abs(batch.actions["x"][k] - action) <= batch.error["actions"]["x"][k]
            assert abs(batch.frequencies["x"][k] - rate) <= batch.error["frequencies"]["x"][k]
            for side, place in enumerate((low, high)):
                claim = batch.error["turning_points"]["x"][side][k]
                assert abs(batch.turning_points["x"][side][k] - place) <= claim
