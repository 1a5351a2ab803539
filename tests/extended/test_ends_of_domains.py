"""Linear motions, and quadratic ones in time, end where a coordinate reaches an end of its domain."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from hjsolve import System, gyroscopic_modes

FREE, SPRING, HILL = "-2*x", "x**2/2", "-x**2/2"
CASES = {
    # V, domain, q, velocity, first and last time (None: none within 40)
    "oscillator": (SPRING, "0 < x", 1, 0, -mp.pi / 2, mp.pi / 2),
    "half a turn more": (SPRING, "-1/2 < x < 2", 1, 0, -2 * mp.pi / 3, 2 * mp.pi / 3),
    "never": (SPRING, "-1.01 < x < 1.01", 1, 0, None, None),
    "nearly": (SPRING, "-1 - 10**(-20) < x", 1, 0, None, None),
    "fall": (FREE, "-1 < x < 2", 0, 0, -mp.sqrt(2), mp.sqrt(2)),
    "downhill": (HILL, "0 < x", 1, -2, None, mp.atanh(mp.mpf(1) / 2)),
    "never over the hill": (HILL, "0 < x", 1, 0, None, None),
    "drift": ("0", "-1 < x < 3", 0, 2, -mp.mpf(1) / 2, mp.mpf(3) / 2),
}


@pytest.mark.parametrize("name", CASES)
def test_a_linear_motion_ends_at_the_end_of_its_domain(name: str) -> None:
    potential, domain, q, velocity, first, last = CASES[name]
    motion = gyroscopic_modes(System({"x": domain}, "dot(x)**2/2", potential)).motion(
        q={"x": q}, velocity={"x": velocity}
    )
    for end, side in ((first, -1), (last, 1)):
        if end is None:
            assert motion.at(40 * side).status == "ok"
            continue
        before, after = motion.at(end * (1 - mp.mpf(10) ** -12)), motion.at([side * 40, end * (1 + mp.mpf(10) ** -12)])
        assert (before.status, list(after.status)) == ("ok", ["reaches_boundary"] * 2)
        assert all(np.isnan(np.asarray(x, dtype=float)).all() for x in (after.q["x"], after.p["x"], after.error.q["x"]))
    assert motion.at(0).q["x"] == q


def test_a_motion_that_touches_an_end_has_ended_there() -> None:
    motion = gyroscopic_modes(System({"x": "-1 < x"}, "dot(x)**2/2", SPRING)).motion(q={"x": 1}, velocity={"x": 0})
    assert list(motion.at(["3.1415", "3.1416", 7]).status) == ["ok", *["reaches_boundary"] * 2]


def left(places: np.ndarray, low: float, high: float) -> int:
    """Return the first sample outside."""
    outside = np.nonzero((places <= low) | (places >= high))[0]
    return int(outside[0]) if outside.size else len(places)


@pytest.mark.parametrize("seed", range(6))
def test_no_motion_is_outside_before_it_ends(seed: int) -> None:
    """Against the same motion on a line, at 1 201 times."""
    dice, times = np.random.default_rng(seed), np.linspace(0, 12, 1201)
    a, b, c, k = dice.uniform(0.3, 2, 4).round(3)
    kinetic, potential = f"(dot(x)**2 + dot(y)**2)/2 + {a}*x*dot(y)", f"{b}*x**2/2 + {c}*y**2/2 - {k}*x*y/4"
    low, high = (-dice.uniform(1.05, 3, 2)).round(3), dice.uniform(1.05, 3, 2).round(3)
    names = {n: f"{low[i]} < {n} < {high[i]}" for i, n in enumerate("xy")}
    start = {"q": {"x": 1, "y": -1}, "velocity": {"x": float(dice.uniform(-1, 1)), "y": float(dice.uniform(-1, 1))}}
    free = (
        gyroscopic_modes(System(dict.fromkeys("xy", "line"), kinetic, potential), digits=15).motion(**start).at(times)
    )
    found = gyroscopic_modes(System(names, kinetic, potential), digits=15).motion(**start).at(times)
    first = min(left(np.asarray(free.q[n], dtype=float), low[i], high[i]) for i, n in enumerate("xy"))
    assert list(found.status == "ok") == [k < first for k in range(len(times))]
    assert np.array_equal(found.q["x"][:first], free.q["x"][:first])


@pytest.mark.parametrize(
    ("potential", "domain"),
    [("(2 + cos(t))*x**2/2", "0 < x"), ("(2 + cos(t))*x**2/2 - x*sin(t)", "-1/3 < x < 2"), ("-x**2*t/5", "-9 < x < 2")],
)
def test_a_motion_of_a_quadratic_system_in_time_ends_there_too(potential: str, domain: str) -> None:
    given = {"q": {"x": 1}, "velocity": {"x": "1/5"}, "t0": "1/3"}
    times = np.linspace(-2.0, 3.0, 101)
    free = hjsolve.solve(System({"x": "line"}, "dot(x)**2/2", potential)).motion(**given).at(times)
    system = System({"x": domain}, "dot(x)**2/2", potential)
    solution = hjsolve.solve(system)
    found = solution.motion(**given).at(times)
    assert solution.kind == "quadratic"
    ends = [float(system.coordinates[0].domain.lower), float(system.coordinates[0].domain.upper or np.inf)]
    x, begun = np.asarray(free.q["x"], dtype=float), int(np.searchsorted(times, 1 / 3))
    first, last = begun - left(x[:begun][::-1], *ends), begun + left(x[begun:], *ends)
    assert (first, last) != (0, len(times))
    inside = np.arange(len(times))
    assert list(found.status == "ok") == list((inside >= first) & (inside < last))
    assert np.isnan(found.q["x"][last:]).all()
