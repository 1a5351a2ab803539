"""Resonances of Kerr's geodesics: how well the ratio is met, how near to the separatrix, and in what time.

    python -m benchmarks.kerr_resonances [200] [--seed 1] [--digits 30] [--only 3,17]

Spin to 0.998, e from 0.05 to 0.8, any inclination; p − p_s of the separatrix from 1e-10 to 10, even in its logarithm
(the first of all is at 1e-10 itself). The ratio asked is the simplest within a thousandth of the ratio there, which
closed forms give: a part in a thousand of it moves p − p_s by some per cent. The unknown is p, of every fourth case e
or x.

What is found is held against elliptic integrals in 40 digits that have nothing in common with hjsolve: E and L from
R(r₁) = R(r₂) = 0 (Carter, Physical Review 174 (1968) 1559, (64)) by Newton's method, Mino's frequencies by Fujita and
Hikida, Classical and Quantum Gravity 26 (2009) 135002, (15) and (20) (van de Meent, ibid. 37 (2020) 145007, (13)), and
p_s from R(r₁) = R(r₂) = R′(r₂) = 0.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

import hjsolve
from hjsolve.errors import HJSolveError

mp = mpmath.MPContext()
mp.dps = 40
_NEXT = "1e-10"
"""The least distance from the separatrix."""


def radial(a: Any, x: Any, E: Any, L: Any) -> list[Any]:
    """Return the coefficients of R(r), highest power first: Carter's potential of unit mass, M = 1."""
    Q = (1 - x**2) * (a**2 * (1 - E**2) + (L / x) ** 2)
    return [E**2 - 1, 2, a**2 * (E**2 - 1) - L**2 - Q, 2 * ((a * E - L) ** 2 + Q), -(a**2) * Q]


def energy_and_momentum(a: Any, p: Any, e: Any, x: Any, near: tuple[Any, Any]) -> tuple[Any, Any]:
    """Return E and L of turning points p/(1 ∓ e) by Newton's method from values nearby."""

    def at_ends(E: Any, L: Any) -> list[Any]:
        return [mp.polyval(radial(a, x, E, L), r) for r in (p / (1 - e), p / (1 + e))]

    E, L = mp.findroot(at_ends, near, tol=mp.mpf(10) ** -60, maxsteps=60)
    return E, L


def quotient(a: Any, p: Any, e: Any, x: Any, near: tuple[Any, Any]) -> Any:
    """Return Ω_r/Ω_θ by complete elliptic integrals: the ratio of Mino's frequencies."""
    E, L = energy_and_momentum(a, p, e, x, near)
    free, small = 1 - E**2, 1 - x**2
    Q = small * (a**2 * free + (L / x) ** 2)
    r1, r2 = p / (1 - e), p / (1 + e)
    total, product = 2 / free - r1 - r2, a**2 * Q / (free * r1 * r2)
    r3 = (total + mp.sqrt(total**2 - 4 * product)) / 2
    r4 = product / r3
    across = (r1 - r3) * (r2 - r4)
    in_r = mp.sqrt(free * across) / mp.ellipk((r1 - r2) * (r3 - r4) / across)
    in_θ = mp.sqrt(Q / small) / mp.ellipk(a**2 * free * small**2 / Q)
    return in_r / in_θ


def last_p(a: Any, e: Any, x: Any, near: tuple[Any, Any, Any]) -> Any:
    """Return p at which the pericentre is a double root of R, by Newton's method from p, E and L nearby."""

    def double(p: Any, E: Any, L: Any) -> list[Any]:
        R = radial(a, x, E, L)
        value, slope = mp.polyval(R, p / (1 + e), derivative=1)
        return [mp.polyval(R, p / (1 - e)), value, slope]

    return mp.findroot(double, near, tol=mp.mpf(10) ** -60, maxsteps=60)[0]


@dataclass(frozen=True)
class Case:
    """A resonance to be found: the elements it is near, and the ratio asked."""

    a: Fraction
    shape: dict[str, Fraction]
    unknown: str
    ratio: Fraction

    def words(self) -> str:
        """Return what names the case in a line."""
        told = " ".join(f"{name}={float(value):.13g}" for name, value in self.shape.items())
        return f"{self.ratio} a={float(self.a)} {told} unknown {self.unknown}"


def started(a: Any, p: Any, e: Any, x: Any) -> tuple[Any, Any]:
    """Return E and L as hjsolve has them, which Newton's method makes its own."""
    from hjsolve.arithmetic.floats import multiprecision
    from hjsolve.resonances.kerr_elements import kerr_constants

    context = multiprecision(200)
    found = kerr_constants(*(context.mpf(mp.nstr(mp.mpf(y), 38)) for y in (a, p, e, x)), 160)
    return mp.mpf(found.energy), mp.mpf(found.angular_momentum)


def cases(count: int, seed: int) -> list[Case]:
    """Return the resonances that are looked for."""
    rng, found = np.random.default_rng(seed), []
    for k in range(count):
        a, e = Fraction(f"{rng.uniform(0, 0.998):.3f}"), Fraction(f"{rng.uniform(0.05, 0.8):.3f}")
        x = Fraction(f"{rng.choice([-1, 1]) * rng.uniform(0.05, 0.99):.3f}")
        a = Fraction("0.998") if k % 10 == 0 else a
        away = Fraction(_NEXT) if k == 0 else Fraction(f"{10 ** rng.uniform(-10, 1):.3e}")
        edge = hjsolve.separatrix(a, e, x, digits=30).value
        p = Fraction(mp.nstr(mp.mpf(edge), 32)) + away
        exact = [mp.mpf(y.numerator) / y.denominator for y in (a, p, e, x)]
        there = quotient(*exact, started(*exact))
        least = Fraction(mp.nstr(there, 20))
        ratio = next(
            r for n in range(1, 5000) if abs((r := least.limit_denominator(n)) / least - 1) < Fraction(1, 1000)
        )
        unknown = "p" if k % 4 or not k else ("e", "x")[k // 4 % 2]
        found.append(Case(a, {"p": p, "e": e, "x": x}, unknown, ratio))
    return found


def held_against(case: Case, motion: Any) -> tuple[float, float, float]:
    """Return how far the ratio is off: by the frequencies, by closed forms; and p beyond the separatrix."""
    f, wanted = motion.frequencies, mp.mpf(case.ratio.numerator) / case.ratio.denominator
    own = abs(mp.mpf(f["r"].value) / mp.mpf(f["theta"].value)) / wanted - 1
    r2, r1 = (mp.mpf(end.value) for end in motion.turning_points["r"])
    a = mp.mpf(case.a.numerator) / case.a.denominator
    e, p = (r1 - r2) / (r1 + r2), 2 * r1 * r2 / (r1 + r2)
    θ = mp.mpf(motion.turning_points["theta"][0].value)
    x = mp.sin(θ) * (-1 if motion.constants["p_phi"].value < 0 else 1)
    E, L = -mp.mpf(motion.constants["p_t"].value), mp.mpf(motion.constants["p_phi"].value)
    edge = mp.mpf(hjsolve.separatrix(case.a, mp.nstr(e, 32), mp.nstr(x, 32), digits=30).value)
    room = p - last_p(a, e, x, (edge, *started(a, edge + mp.mpf(10) ** -20, e, x)))
    return float(abs(own)), float(abs(quotient(a, p, e, x, (E, L)) / wanted - 1)), float(room)


def main() -> None:
    """Print what was missed, and a summary."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--digits", type=int, default=30)
    parser.add_argument("--only", help="numbers of cases, 0,7,…")
    chosen = parser.parse_args()
    kerr = hjsolve.solve(hjsolve.catalog.load("kerr"))
    own, closed, rooms, seconds, missed = [], [], [], [], []
    for k, case in enumerate(cases(chosen.count, chosen.seed)):
        if chosen.only and k not in map(int, chosen.only.split(",")):
            continue
        fixed = {"a": case.a} | {name: value for name, value in case.shape.items() if name != case.unknown}
        begin = time.process_time()
        try:
            ratio = {"r": case.ratio.numerator, "theta": case.ratio.denominator}
            motions = kerr.torus(ratio=ratio, fixed=fixed, digits=chosen.digits)
        except HJSolveError as fault:
            missed.append(k)
            print(f"{k}: {case.words()}: {type(fault).__name__}: {str(fault)[:300]}", flush=True)
            continue
        finally:
            seconds.append(time.process_time() - begin)
        for motion in motions if isinstance(motions, tuple) else (motions,):
            off = held_against(case, motion)
            for column, value in zip((own, closed, rooms), off, strict=True):
                column.append(value)
            if max(off[:2]) > 1e-12 or k % 20 == 0:
                told = f"off by {off[0]:.1e}, {off[1]:.1e} by closed forms, {off[2]:.3e} beyond the separatrix"
                print(f"{k}: {case.words()}: {told}, {seconds[-1]:.1f} s", flush=True)
    told = f"({len(own)} tori), digits={chosen.digits}; missed {missed}"
    print(f"{len(seconds) - len(missed)} of {len(seconds)} found {told}")
    print(f"ratio off by at most {max(own):.1e}, by closed forms in 40 digits {max(closed):.1e}")
    print(f"p beyond the separatrix by {min(rooms):.2e} to {max(rooms):.2e}; {np.median(seconds):.1f} s each (median)")


if __name__ == "__main__":
    main()
