"""Frequencies of Kerr geodesics, one orbit and many, against quadratures and closed forms at many digits.

Conventions of the catalog entry: H = ½ gᵅᵝ pₐp_β = −½, time is proper time, so frequencies are per unit of proper time; Mino's are
these times ⟨r² + a² cos²θ⟩, those of a far observer these divided by ⟨dt/dτ⟩. Ratios do not depend on the time chosen.
"""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from tests.reference.kerr import Orbit, by_quadrature, from_start, from_turning_points, in_closed_form

NAMES = ("r", "theta", "phi")
SEPARATRIX = ("0.9", "0.3", "0.7")


@pytest.fixture(scope="module")
def solution() -> hjsolve.Solution:
    return hjsolve.solve(hjsolve.catalog.load("kerr"))


def start(orbit: Orbit, r: mpf) -> dict[str, dict[str, str]]:
    """In the equator at r, outward and northward, as exact decimals."""
    p = {"t": -orbit.E, "r": orbit.momentum(r), "theta": -mp.sqrt(orbit.Q), "phi": orbit.L}
    return {
        "q": {"t": "0", "r": mp.nstr(r, mp.dps), "theta": "pi/2", "phi": "0"},
        "p": {name: mp.nstr(value, mp.dps) for name, value in p.items()},
    }


def separatrix(a: mpf, e: mpf, x: mpf) -> mpf:
    """The p at which r₂ = r₃, by bisection."""

    def bound(p: mpf) -> bool:
        r = from_turning_points(a, p, e, x).roots
        return isinstance(r[2], mpf) and r[1] > r[2]

    low, high = mpf(3), mpf(6)
    for _ in range(4 * mp.dps):
        middle = (low + high) / 2
        low, high = (low, middle) if bound(middle) else (middle, high)
    return high


@pytest.mark.nightly_cases("0.9-6-0.3-0.7")
@pytest.mark.parametrize(
    ("a", "p", "e", "x"), [("0.9", "6", "0.3", "0.7"), ("0.9", "12", "0.6", "-0.8"), ("0.01", "9", "0.01", "0.4")]
)
def test_the_references_agree_and_one_orbit_with_them(a, p, e, x, solution) -> None:
    with mp.workdps(32):
        orbit = from_turning_points(mpf(a), mpf(p), mpf(e), mpf(x))
        truth, closed = by_quadrature(orbit), in_closed_form(orbit)
        assert all(abs(truth[name] / closed[name] - 1) < mpf(10) ** -26 for name in NAMES)
        motion = solution.motion(**start(orbit, mpf(p)), parameters={"a": a}, want=["frequencies"])
        for name in NAMES:
            assert abs(mpf(motion.frequencies[name].value) * truth["tau"] / truth[name] - 1) <= 4e-16


def test_a_step_of_1e_10_from_the_separatrix(solution) -> None:
    with mp.workdps(46):
        a, e, x = map(mpf, SEPARATRIX)
        orbit = from_turning_points(a, separatrix(a, e, x) + mpf("1e-10"), e, x)
        assert 0 < orbit.roots[1] - orbit.roots[2] < 1e-9
        truth = in_closed_form(orbit)
        motion = solution.motion(
            **start(orbit, (orbit.roots[0] + orbit.roots[1]) / 2), parameters={"a": SEPARATRIX[0]}, want=["frequencies"]
        )
        assert motion.kinds["r"] == "libration"
        for name in NAMES[1:]:
            ratio = mpf(motion.frequencies[name].value) / mpf(motion.frequencies["r"].value)
            assert abs(ratio * truth["r"] / truth[name] - 1) <= 1e-15


@pytest.mark.nightly
def test_many_orbits_at_once() -> None:
    rng, count = np.random.default_rng(7), 8
    with mp.workdps(32):
        orbits = [
            from_turning_points(
                mpf("0.9"), mpf(rng.uniform(5, 12)), mpf(rng.uniform(0.02, 0.7)), mpf(rng.uniform(0.3, 0.95))
            )
            for _ in range(count)
        ]
        begins = [start(o, 2 / (1 / o.roots[0] + 1 / o.roots[1])) for o in orbits]
        angle = float(mp.pi / 2)
        q = {n: np.array([angle if n == "theta" else float(mpf(b["q"][n])) for b in begins]) for n in begins[0]["q"]}
        p = {n: np.array([float(mpf(b["p"][n])) for b in begins]) for n in begins[0]["p"]}
        batch = hjsolve.ensemble(hjsolve.catalog.load("kerr"), q=q, p=p, parameters={"a": "0.9"}, want={"frequencies"})
        assert (batch.status == "ok").all()
        for i in range(count):
            given = (q["r"][i], q["theta"][i], p["t"][i], p["r"][i], p["theta"][i], p["phi"][i])
            truth = by_quadrature(from_start(mpf("0.9"), *map(mpf, given)))
            for name in NAMES:
                error = abs(mpf(batch.frequencies[name][i]) - truth[name] / truth["tau"])
                assert error <= batch.error["frequencies"][name][i]
                assert error <= 1e-13 * truth[name] / truth["tau"]
