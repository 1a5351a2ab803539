"""Ends of a coordinate's domain, rest, and the sleeping top: each against a closed form at 50 digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from tests.support import hard_exact

pytestmark = pytest.mark.rotating_file(9)

DIGITS = 50


@cache
def line(potential: str, domain: str = "line") -> Any:
    return hjsolve.solve(hjsolve.System({"x": domain}, "dot(x)**2/2", potential))


@cache
def entry(name: str) -> Any:
    return hjsolve.solve(hjsolve.catalog.load(name))


@dataclass(frozen=True)
class Ending:
    """A motion that reaches an end of a coordinate's domain, or creeps towards it."""

    solution: Callable[[], Any]
    start: Mapping[str, Any]
    name: str
    kind: str
    time: Callable[[], mpf] | None
    place: Callable[[mpf], mpf]
    times: tuple[str, ...]


def fallen(t: mpf) -> mpf:
    """r of a body released at rest at 1."""
    return mp.findroot(
        lambda r: hard_exact.radial_fall_time(r) - abs(t),
        (mpf("1e-6"), mpf("0.999999")),
        solver="anderson",
        tol=1e-90,
        maxsteps=200,
    )


ENDINGS = {
    "a turning point at the end of the domain": Ending(
        lambda: line("-x", "0 < x"), {"q": {"x": 1}, "velocity": {"x": "-sqrt(2)"}}, "x", "boundary",
        lambda: mp.sqrt(2), lambda t: (1 - t / mp.sqrt(2)) ** 2, ("1", "1.4", "1.414213", "-2")),
    "an oscillator that just touches its walls": Ending(
        lambda: line("x**2/2", "-1 < x < 1"), {"q": {"x": 0}, "velocity": {"x": 1}}, "x", "boundary",
        lambda: mp.pi / 2, mp.sin, ("1", "1.5", "1.5707", "-1.2")),
    "one that hits them at a grazing speed": Ending(
        lambda: line("x**2/2", "-1 < x < 1"), {"q": {"x": 0}, "velocity": {"x": "1 + 1e-12"}}, "x", "boundary",
        lambda: mp.asin(1 / (1 + mpf(10) ** -12)), lambda t: (1 + mpf(10) ** -12) * mp.sin(t), ("1", "1.57079", "-1.2")),
    "one that turns a trillionth before them": Ending(
        lambda: line("x**2/2", "-1 < x < 1"), {"q": {"x": 0}, "velocity": {"x": "1 - 1e-12"}}, "x", "libration",
        None, lambda t: (1 - mpf(10) ** -12) * mp.sin(t), ("1", "1.5707", "1.6", "1e6")),
    "a double zero at the end of the domain": Ending(
        lambda: line("-x**2/2", "0 < x"), {"q": {"x": 1}, "velocity": {"x": -1}}, "x", "asymptotic",
        None, lambda t: mp.exp(-t), ("1", "10", "25", "-3")),
    "a triple zero at the end of the domain": Ending(
        lambda: line("-x**3", "0 < x"), {"q": {"x": 1}, "velocity": {"x": "-sqrt(2)"}}, "x", "asymptotic",
        None, lambda t: (1 + t / mp.sqrt(2)) ** -2, ("1", "10", "1000", "-0.5")),
    "collision, released at rest": Ending(
        lambda: entry("kepler-planar"), {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": 0}}, "r", "boundary",
        lambda: mp.pi / mp.sqrt(8), fallen, ("0.5", "1", "1.11", "-1.1")),
    "collision at the parabolic energy": Ending(
        lambda: entry("kepler-planar"), {"q": {"r": 1, "theta": 0}, "velocity": {"r": "-sqrt(2)", "theta": 0}}, "r", "boundary",
        lambda: mp.sqrt(2) / 3, lambda t: (1 - 3 * t / mp.sqrt(2)) ** (mpf(2) / 3), ("0.1", "0.4", "0.47", "-50")),
    "a spherical pendulum that never quite reaches the upper pole": Ending(
        lambda: entry("spherical-pendulum"),
        {"q": {"theta": 1, "phi": 0}, "velocity": {"theta": "2*cos(1/2)", "phi": 0}, "parameters": {"g": 1}}, "theta", "asymptotic",
        None, lambda t: hard_exact.pendulum(mpf(1), t + mp.asinh(mp.tan(mpf("0.5"))))[0], ("0.5", "3", "20", "-0.5")),
}  # fmt: skip


@pytest.mark.parametrize("case", ENDINGS.values(), ids=list(ENDINGS))
def test_motion_to_an_end_of_the_domain(case: Ending) -> None:
    motion = case.solution().motion(**case.start)
    state = motion.at(np.array(case.times, dtype=object))

    assert motion.kinds[case.name] == case.kind
    with mp.workdps(DIGITS):
        if case.time is not None:
            found = motion.boundary_times[case.name]
            assert abs(mpf(found.value) - case.time()) <= found.error <= 1e-14
            assert motion.at(float(found.value) * 1.001).status == "reaches_boundary"
        for m, t in enumerate(case.times):
            value, claim = case.place(mpf(t)), mpf(state.error.q[case.name][m])
            missed = abs(mpf(state.q[case.name][m]) - value)
            assert missed <= claim
            assert missed <= 1e-13 * max(abs(value), 1 if case.kind == "boundary" else mpf(10) ** -300), t


@pytest.mark.nightly
def test_an_exponential_approach_and_escape_as_far_as_doubles_reach() -> None:
    """x = e^(−t): e^(−1000) is not a double, and e^600 nearly none; panels grow with the logarithm of x."""
    motion = line("-x**2/2", "0 < x").motion(q={"x": 1}, velocity={"x": -1})

    with mp.workdps(DIGITS):
        for t in ("100", "700", "1000", "-100", "-300", "-600"):
            state = motion.at(t)
            assert abs(mpf(state.q["x"]) - mp.exp(-mpf(t))) <= mpf(state.error.q["x"]), t
            assert state.error.q["x"] <= 1e-14 * abs(float(t)) * state.q["x"] + 1e-300


def midpoint_period(speed_squared: Callable[[mpf], mpf], a: mpf, nodes: int) -> mpf:
    """Period between −a and a over q = a sin α, with high precision in place of care."""
    total = mpf(0)
    for k in range(nodes):
        x = a * mp.sin(mp.pi * (k + mpf("0.5")) / nodes - mp.pi / 2)
        total += mp.sqrt((a * a - x * x) / speed_squared(x))
    return 2 * mp.pi * total / nodes


@pytest.mark.parametrize("spin", ["3", "2", "1"])
def test_the_sleeping_top(spin: str) -> None:
    """b + c = 0 reduced by hand to one coordinate, regular at the top: stable for c² > 4, critical at 4 (Greenwood §3-6)."""
    top = line(f"sin(x) + {spin}**2/2*(1 - sin(x))/(1 + sin(x))")
    asleep = top.motion(q={"x": "pi/2"}, velocity={"x": 0})

    assert asleep.kinds["x"] == "equilibrium"
    state = asleep.at(["-1e9", "5", "1e9"])
    assert np.all(abs(state.q["x"] - np.pi / 2) <= state.error.q["x"])
    if spin == "3":
        with mp.workdps(DIGITS):
            frequency = asleep.frequencies["x"]
            assert abs(mpf(frequency.value) - mp.sqrt(mpf(spin) ** 2 / 4 - 1)) <= frequency.error
    else:
        assert "x" not in asleep.frequencies


@pytest.mark.parametrize(("spin", "tilt"), [("3", "1e-3"), ("3", "1e-6"), ("2", "1e-3"), ("2", "1e-6")])
def test_neighbours_of_the_sleeping_top(spin: str, tilt: str) -> None:
    """At c² = 4 the minimum is of fourth order: the period grows like 1/amplitude."""
    motion = line(f"sin(x) + {spin}**2/2*(1 - sin(x))/(1 + sin(x))").motion(
        q={"x": f"pi/2 - {tilt}"}, velocity={"x": 0}
    )

    with mp.workdps(100):
        a, c = mpf(tilt), mpf(spin)

        def energy(ε: mpf) -> mpf:
            return mp.cos(ε) + c * c / 2 * mp.tan(ε / 2) ** 2

        true = midpoint_period(lambda ε: 2 * (energy(a) - energy(ε)), a, 96)
        assert abs(true / midpoint_period(lambda ε: 2 * (energy(a) - energy(ε)), a, 64) - 1) < 1e-20
        assert abs(mpf(motion.periods["x"].value) - true) <= motion.periods["x"].error <= 1e-15 * true
    assert motion.nodes <= 64


def test_a_conical_pendulum_and_a_steady_top_keep_their_rates_for_a_billion_turns() -> None:
    cone = entry("spherical-pendulum").motion(
        q={"theta": "pi/3", "phi": 0}, velocity={"theta": 0, "phi": "sqrt(2)"}, parameters={"g": 1}
    )
    top = entry("lagrange-top").motion(
        q={"theta": "pi/6", "psi": 0, "phi": 0}, velocity={"theta": 0, "psi": -1, "phi": "5/2"}
    )

    assert cone.kinds["theta"] == top.kinds["theta"] == "equilibrium"
    with mp.workdps(DIGITS):
        for motion, name, rate, small in (
            (cone, "phi", mp.sqrt(2), mp.sqrt(mpf(7) / 2)),  # Ω² = g(1 + 3 cos²)/(l cos)
            (top, "psi", mpf(-1), mpf(1)),
        ):
            assert abs(mpf(motion.frequencies["theta"].value) - small) <= motion.frequencies["theta"].error
            for t in ("7", "1e9", "-1e12"):
                state = motion.at(t)
                missed = abs(hard_exact.principal(mpf(state.q[name]) - rate * mpf(t)))
                assert missed <= mpf(state.error.q[name]) <= 1e-14


@pytest.mark.nightly_cases("-U/(exp(a*x) - 1)", "-U/log(1 + a*x)")
@pytest.mark.parametrize("potential", ["-U/sinh(a*x)", "-U/(exp(a*x) - 1)", "-U/log(1 + a*x)", "-U*coth(a*x)"])
def test_a_fall_to_a_pole_of_a_function_with_a_letter_for_the_mass(potential):
    # the kernel of E is m itself, a formula without operations: the pole was then not seen, and the fall not followed
    values = {"m": "3/2", "U": "2", "a": "2/3"}
    system = hjsolve.System({"x": "0 < x"}, "m*dot(x)**2/2", potential, values)
    motion = hjsolve.solve(system).motion(q={"x": 1}, velocity={"x": "-1/5"}, digits=25)
    assert motion.kinds["x"] == "boundary"
    names = {name: getattr(mp, name) for name in ("sinh", "exp", "log", "coth")}
    with mp.workdps(60):
        m, U, a = mp.mpf("1.5"), mp.mpf(2), mp.mpf(2) / 3

        def V(x):
            return eval(potential, {"U": U, "a": a, "x": x, **names})

        E = m * mp.mpf("0.04") / 2 + V(mp.mpf(1))
        fall = mp.quad(lambda s: 2 * s / mp.sqrt(2 * (E - V(s * s)) / m), [0, 0.5, 1], method="gauss-legendre")
        time = motion.boundary_times["x"]
        assert abs(time.value - fall) <= time.error + mp.mpf(10) ** -30
        assert time.error < 1e-22
