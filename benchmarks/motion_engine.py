"""q(t) of the pendulum and of Kepler, and certified periods: error next to time, rivals in the same run.

    python benchmarks/motion_engine.py

Needs the extras ``bench`` (scipy) and ``certified`` (python-flint). Times are medians of interleaved repeats on one
thread; read the ratios. Errors are against closed forms at 60 digits or more, on a sample of the times.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np

import hjsolve

REPEATS = 5


def timed(function: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds and result of one call."""
    start = time.perf_counter()
    result = function()
    return time.perf_counter() - start, result


def pendulum() -> None:
    from scipy.special import ellipj

    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    print(
        "pendulum q(t), 1e5 times\n"
        " 1-k     periods  nodes   first ns  ns/point  ellipj   ratio  max error  claimed/true"
    )
    for gap in ("0.9", "0.1", "1e-6", "1e-12"):
        motion = solution.motion(
            q={"theta": 0}, velocity={"theta": f"2*(1-{gap})"}, parameters={"m": 1, "g": 1, "l": 1}
        )
        k = 1 - float(gap)
        for periods in (1, 10**3, 10**9):
            t = np.random.default_rng(1).uniform(0, periods * motion.periods["theta"].value, 100_000)
            first, state = timed(lambda t=t: motion.at(t).q["theta"])
            pairs = [
                (timed(lambda t=t: motion.at(t).q["theta"])[0], timed(lambda t=t: ellipj(t, k * k))[0])
                for _ in range(REPEATS)
            ]
            ours, theirs = (statistics.median(side) * 1e4 for side in zip(*pairs, strict=True))
            claimed = motion.at(t).error.q["theta"]
            errors = [
                (abs(exact_pendulum(gap, t[i]) - mpmath.mpf(state[i])), claimed[i]) for i in range(0, 100_000, 2500)
            ]
            worst = max(e for e, _ in errors)
            tolerance = min(float(c / e) if e else np.inf for e, c in errors)
            print(
                f" {gap:6} {periods:8.0e} {motion.nodes:6} {first * 1e4:9.0f} {ours:9.0f} {theirs:8.0f}"
                f" {ours / theirs:7.2f}"
                f"  {float(worst):9.1e}  {tolerance:9.1f}"
            )


def exact_pendulum(gap: str, t: float) -> Any:
    """θ = 2 asin(k sn t), the period taken out at 60 digits."""
    with mpmath.workdps(60):
        k = 1 - mpmath.mpf(gap)
        period = 4 * mpmath.ellipk(k**2)
        rest = mpmath.mpf(t) - period * mpmath.nint(mpmath.mpf(t) / period)
        return 2 * mpmath.asin(k * mpmath.ellipfun("sn", rest, m=k**2))


def kepler() -> None:
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    print("\nKepler r(t), 1e6 times, perihelion 1\n e                 first ns  ns/point  max relative error")
    for e in ("0", "0.1", "0.9", "0.999999", "0.999999999999", "1", "1.0000001", "2"):
        motion = solution.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": f"sqrt(1+{e})"})
        reach = 3 * motion.periods["r"].value if "r" in motion.periods else 3000.0
        rng = np.random.default_rng(3)
        t = rng.uniform(-reach, reach, 1_000_000)
        t[:2000] = 10.0 ** rng.uniform(-12, 0, 2000) * rng.choice([-1, 1], 2000) * min(reach, 1e3)
        first, r = timed(lambda t=t: motion.at(t).q["r"])
        again = statistics.median(timed(lambda t=t: motion.at(t).q["r"])[0] for _ in range(REPEATS))
        chosen = [*range(0, 2000, 25), *range(2000, 1_000_000, 12_500)]
        worst = max(abs(mpmath.mpf(r[i]) / exact_kepler(e, t[i]) - 1) for i in chosen)
        print(f" {e:16} {first * 1e3:9.0f} {again * 1e3:9.0f}  {float(worst):.1e}")


def exact_kepler(eccentricity: str, t: float) -> Any:
    """Distance by universal variables at 60 digits, perihelion 1 at t = 0, k = m = 1."""
    with mpmath.workdps(60):
        e = mpmath.mpf(eccentricity)
        energy, time_left = 1 - e, abs(mpmath.mpf(t))
        if energy > 0:
            period = 2 * mpmath.pi / energy ** mpmath.mpf("1.5")
            time_left = abs(time_left - period * mpmath.nint(time_left / period))

        def stumpff(s: Any) -> tuple[Any, Any]:
            z = energy * s * s
            if abs(z) < mpmath.mpf("1e-8"):
                return (
                    mpmath.fsum((-z) ** n / mpmath.factorial(2 * n + 2) for n in range(9)),
                    mpmath.fsum((-z) ** n / mpmath.factorial(2 * n + 3) for n in range(9)),
                )
            root = mpmath.sqrt(abs(z))
            if z > 0:
                return (1 - mpmath.cos(root)) / z, (root - mpmath.sin(root)) / root**3
            return (mpmath.cosh(root) - 1) / -z, (mpmath.sinh(root) - root) / root**3

        s = mpmath.mpf(1)
        while s + e * s**3 * stumpff(s)[1] < time_left:
            s *= 2
        for _ in range(400):
            c, d = stumpff(s)
            step = (s + e * s**3 * d - time_left) / (1 + e * s * s * c)
            s -= step
            if abs(step) <= mpmath.mpf("1e-50") * abs(s):
                break
        return 1 + e * s * s * stumpff(s)[0]


def processor(function: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of processor time and result of one call."""
    start = time.process_time()
    result = function()
    return time.process_time() - start, result


def certified() -> None:
    """Certified periods: the whole motion, and the integral alone, against one direct ``acb.integral``.

    No two motions of a row have the same energy, so nothing that was worked out for one serves the next.
    """
    import flint

    from hjsolve.arithmetic.ball import working
    from hjsolve.certified.strip_bound import certified_means
    from hjsolve.motion import certified as proof

    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    print(
        "\ncertified pendulum period, processor time: whole motion(...), and its integral alone, the turning points\n"
        "enclosed before, against one direct acb.integral\n"
        " 1-k    digits  motion s  integral    direct  motion/direct  integral/direct  contains   radius"
    )
    for gap in ("0.1", "1e-6", "1e-12"):
        for digits in (15, 50, 100, 300, 1000):
            bits = int(3.33 * digits) + 10

            def ours(gap: str, digits: int = digits) -> Any:
                return solution.motion(
                    q={"theta": 0},
                    velocity={"theta": f"2*(1-{gap})"},
                    parameters={"m": 1, "g": 1, "l": 1},
                    digits=digits,
                    certified=True,
                    want=["periods"],
                )

            def direct(gap: str, bits: int = bits) -> Any:
                with flint.ctx.workprec(bits + 40):
                    k = 1 - flint.arb(gap)
                    return 4 * flint.acb.integral(
                        lambda x, _: 1 / (x.cos() ** 2 + (1 - k * k) * x.sin() ** 2).sqrt(),
                        0,
                        flint.arb.pi() / 2,
                        rel_tol=flint.arb(2) ** -bits,
                        abs_tol=flint.arb(0),
                    )

            def integral(motion: Any, digits: int = digits) -> float:
                work = proof.work_bits(digits)
                radicands = {"theta": motion.separated.located["theta"].coordinate_motion.radicand}
                line = proof.lines(radicands, motion.initial, solution, work)["theta"]
                with working(work):
                    cycle = proof.cycle_of(motion.separated, "theta", line)
                    return processor(lambda: certified_means(cycle, int(3.33 * digits) + 12))[0]

            rows = []
            for n in range(25 if digits < 300 else 3):
                shifted = gap.replace("1", f"1.00{n + 1}", 1) if "e" in gap else f"{gap}00{n + 1}"
                seconds, motion = processor(lambda shifted=shifted: ours(shifted))
                rows.append((seconds, integral(motion), processor(lambda shifted=shifted: direct(shifted))[0]))
            mine, alone, theirs = (statistics.median(side) for side in zip(*rows, strict=True))
            estimate = motion.periods["theta"]
            with mpmath.workdps(digits + 80):
                truth = 4 * mpmath.ellipk((1 - mpmath.mpf(shifted)) ** 2)
                inside = abs(mpmath.mpf(estimate.value) - truth) <= estimate.error
                radius = mpmath.nstr(estimate.error / truth, 2)
            print(
                f" {gap:6} {digits:6} {mine:9.4f} {alone:9.4f} {theirs:9.4f} {mine / theirs:14.2f}"
                f" {alone / theirs:16.2f}  {inside!s:8}  {radius}"
            )


if __name__ == "__main__":
    pendulum()
    kepler()
    certified()
