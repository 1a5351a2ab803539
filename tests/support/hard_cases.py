"""The hard cases: a motion each, why it is hard, and its exact course from ``exact``.

A case is data; ``measure`` runs it. Times are decimal strings, so that the input is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
from mpmath import mp, mpf

import hjsolve
from tests.support import hard_exact

CoordinatePath = Callable[[mpf], Mapping[str, mpf]]


@dataclass(frozen=True)
class Case:
    """One motion with its truth.

    Attributes:
        name: short and unique.
        why: what makes it hard.
        solution: makes the solved system.
        start: arguments of ``Solution.motion``.
        kinds: coordinate → kind expected.
        truth: exact t ↦ coordinate → position; an angle is its principal value.
        times: exact decimal strings.
        scale: coordinate → the size errors are measured against (its amplitude).
        periods: coordinate → exact period.
        reach: relative error that must be reached.
        nodes: quadrature nodes that must suffice.
    """

    name: str
    why: str
    solution: Callable[[], Any]
    start: Mapping[str, Any]
    kinds: Mapping[str, str]
    truth: CoordinatePath
    times: tuple[str, ...]
    scale: Mapping[str, float]
    periods: Mapping[str, Callable[[], mpf]] = field(default_factory=dict)
    reach: float = 2e-14
    nodes: int = 250


@dataclass(frozen=True)
class Measured:
    """What came out: relative errors, and claimed ÷ true (at least a ninth of a unit of the last digit) for every number."""

    error: float
    ratios: Any
    period_error: float
    nodes: int
    setup: Any


def real(text: str) -> mpf:
    """An exact decimal string at the working precision."""
    fraction = Fraction(text)
    return mpf(fraction.numerator) / fraction.denominator


def spread(span: float, count: int = 12, begin: str = "0") -> tuple[str, ...]:
    """Times over ±span, four significant digits each, counted from ``begin``."""
    return tuple(
        str(Fraction(begin) + Fraction(f"{span * (2 * k / count - 1) * 0.98317:.4g}")) for k in range(count + 1)
    )


def measure(case: Case, digits: int = 15) -> Measured:
    """Run a case and compare every position, and every period known."""
    motion = case.solution().motion(**case.start, digits=digits)
    assert {n: motion.kinds[n] for n in case.kinds} == dict(case.kinds)
    state = motion.at(np.array(case.times, dtype=object))
    claims = state.error.q
    with mp.workdps(max(hard_exact.DIGITS, digits + 30)):
        error, ratios = 0.0, []
        for m, t in enumerate(case.times):
            for name, value in case.truth(real(t)).items():
                difference = mpf(state.q[name][m]) - value
                if name in state.turns:
                    difference = hard_exact.principal(difference)
                size = max(abs(value), mpf(case.scale[name]))
                error = max(error, float(abs(difference) / size))
                ratios.append(float(mpf(claims[name][m]) / max(abs(difference), size * mpf(10) ** -digits / 9)))
                assert abs(difference) <= mpf(claims[name][m]), (
                    f"{case.name}: {name}({t}) claims {claims[name][m]}, misses by {difference}"
                )
        period_error = 0.0
        for name, period in case.periods.items():
            found = motion.periods[name]
            missed = abs(mpf(found.value) - period())
            assert missed <= found.error, f"{case.name}: period of {name} claims {found.error}, misses by {missed}"
            period_error = max(period_error, float(missed / period()))
    return Measured(error, np.array(ratios), period_error, motion.nodes, motion)


# ------------------------------------------------------------------------------------------------ systems


@cache
def pendulum() -> Any:
    return hjsolve.solve(hjsolve.System({"theta": "angle"}, "dot(theta)**2/2", "-cos(theta)"))


@cache
def kepler() -> Any:
    return hjsolve.solve(hjsolve.catalog.load("kepler-planar"))


@cache
def line(potential: str) -> Any:
    return hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", potential))


@cache
def parabolic() -> Any:
    return hjsolve.solve(hjsolve.catalog.load("kepler-parabolic"))


# ------------------------------------------------------------------------------------------------ families


def libration(v: str, why: str, kind: str = "libration", periods: str = "0") -> Case:
    """A pendulum pushed from the bottom with angular velocity v = 2k, after some number of periods."""
    with mp.workdps(hard_exact.DIGITS):
        k = real(v) / 2
        period = hard_exact.pendulum_period(k) if k != 1 else mpf(8)
        begin = str(int(period * int(periods)))
        amplitude = float(2 * mp.asin(min(k, mpf(1))))
    later = f", {float(periods):.0e} periods on" if periods != "0" else ""
    return Case(
        f"pendulum, thrown with {v}{later}", why, pendulum, {"q": {"theta": 0}, "velocity": {"theta": v}}, {"theta": kind},
        lambda t: {"theta": hard_exact.principal(hard_exact.pendulum(real(v) / 2, t)[0])}, spread(1.3 * float(period), begin=begin),
        {"theta": amplitude}, {} if k == 1 else {"theta": lambda: hard_exact.pendulum_period(real(v) / 2)})  # fmt: skip


def orbit(
    e: str, why: str, kind: str = "libration", span: float = 0.0, m: str = "1", k: str = "1", v: str = ""
) -> Case:
    """A Kepler orbit from r = 1 with the transverse velocity √((1 + e) k/m); e < 0 starts at the apocentre."""
    with mp.workdps(hard_exact.DIGITS):
        ε = real(e)
        period = 2 * mp.pi / (1 - ε) ** mpf("1.5") if ε < 1 else None
        unit = mp.sqrt(real(m) / real(k))
        span = (span or (1.3 * float(period) if period else 30.0)) * float(unit)

    def truth(t: mpf) -> Mapping[str, mpf]:
        r, θ = hard_exact.kepler(real(e), t / mp.sqrt(real(m) / real(k)))
        return {"r": r, "theta": θ}

    periods = {"r": lambda: 2 * mp.pi * mp.sqrt(real(m) / real(k)) / (1 - real(e)) ** mpf("1.5")} if ε < 1 else {}
    scales = f", m = {m}, k = {k}" if (m, k) != ("1", "1") else ""
    return Case(
        f"Kepler, e = {e}{scales}", why, kepler,
        {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": v or f"sqrt(1 + ({e}))"}, "parameters": {"m": m, "k": k}},
        {"r": kind}, truth, spread(span) + _around_pericentre(ε, unit), {"r": 0.0, "theta": 1.0}, periods)  # fmt: skip


def _around_pericentre(ε: mpf, unit: mpf) -> tuple[str, ...]:
    """Times next to the fast passage of an orbit started at its apocentre (ε < 0)."""
    if ε >= 0:
        return ()
    half, fast = mp.pi / (1 - ε) ** mpf("1.5") * unit, ((1 + ε) / 2) ** mpf("1.5")
    return tuple(mp.nstr(half + x * fast, 40) for x in (-30, -1, 0, mpf("0.01"), 5))


def well(a: str, why: str, kind: str = "libration") -> Case:
    """The double well x⁴/4 − x²/2 released from rest; √2 is exactly the barrier."""
    with mp.workdps(hard_exact.DIGITS):
        size = mp.sqrt(2) if a == "sqrt(2)" else real(a)

    def truth(t: mpf) -> Mapping[str, mpf]:
        return {"x": hard_exact.double_well(mp.sqrt(2) if a == "sqrt(2)" else real(a), t)}

    return Case(f"double well, released at {a}", why, lambda: line("x**4/4 - x**2/2"), {"q": {"x": a}, "velocity": {"x": 0}},
                {"x": kind}, truth, spread(30.0), {"x": float(size)}, nodes=400)  # fmt: skip


def cubic(a: str, b: str, c: str, why: str) -> Case:
    """ẋ² = (x − a)(b − x)(c − x) from x = a."""
    span = 1.3 * 4 / float(Fraction(c) - Fraction(a)) ** 0.5 * 3

    def truth(t: mpf) -> Mapping[str, mpf]:
        return {"x": hard_exact.three_roots(real(a), real(b), real(c), t)}

    return Case(f"three roots {a}, {b}, {c}", why, lambda: line(f"-(x - {a})*({b} - x)*({c} - x)/2"),
                {"q": {"x": a}, "velocity": {"x": 0}}, {"x": "libration"}, truth, spread(span), {"x": float(Fraction(b))})  # fmt: skip


def cases() -> list[Case]:
    """All cases with a closed form."""
    return [
        *(orbit(e, "turning points closer than rounding of (E, L)") for e in ("1e-4", "1e-8", "1e-12")),
        orbit("0", "double zero: a relative equilibrium", "equilibrium"),
        *(orbit(e, "close to parabolic: the far turning point runs away", span=1e3) for e in ("0.9", "0.999999", "0.999999999999")),
        orbit("1", "exactly parabolic", "escape", 1e3),
        *(orbit(e, "hyperbolic, close to parabolic", "escape", 1e3) for e in ("1.000000000001", "1.0000001", "2")),
        *(orbit(f"-{e}", "nearly radial: passes close to the centre") for e in ("0.999999", "0.999999999999")),
        *(orbit("0.44", "overflow of squares", m=m, k=k, v=v) for m, k, v in (("1e100", "1e100", "1.2"), ("1e-100", "1e-100", "1.2"), ("1e100", "1e-100", "1.2e-100"), ("1e-100", "1e100", "1.2e100"))),
        *(libration(v, "tiny amplitude: p² is a difference of near-equal numbers") for v in ("1e-4", "1e-8", "1e-12")),
        *(libration(v, "close below the separatrix") for v in ("1.999998", "1.999999999998", "1.999999999999998")),
        libration("2", "the separatrix: infinite time", "asymptotic"),
        *(libration(v, "close above the separatrix", "rotation") for v in ("2.000000000000002", "2.000000000002", "2.000002")),
        *(libration(v, "phase after many periods", periods=n) for v in ("0.2", "1.8", "1.999998", "1.999999999998") for n in ("1000", "1000000000", "1000000000000000")),
        *(libration("3", "turns after many periods", "rotation", periods=n) for n in ("1000", "1000000000000000")),
        well("1.2", "one of two wells"),
        *(well(a, "barely over or under the barrier") for a in ("1.4142135623", "1.4142135624", "1.41421356237309", "1.4142135623730951")),
        well("sqrt(2)", "at the barrier", "asymptotic"),
        well("1.000000000001", "bottom of a well"),
        cubic("1", "1.00000001", "1.00000003", "three nearly equal roots"),
        cubic("1", "1.00000001", "1.0000000100000001", "three nearly equal roots, two of them closer still"),
        cubic("0", "1e-12", "1", "small width next to a large scale"),
    ]  # fmt: skip
