"""Derivatives of many orbits: what they cost next to the values, and whether every claim holds.

    python -m benchmarks.batch_derivatives price [--orbits 20000]
    python -m benchmarks.batch_derivatives claims [--motions 10000] [--seconds 3600] [--seed 1]

``price``: processor time of ``ensemble_derivatives`` over that of ``ensemble`` with actions and frequencies, one
thread, least of three each, in turns. ``claims``: random central fields, none of the catalog: sums of a
harmonic, a logarithmic, a Kepler and a narrow Gaussian term, lengths from 1e−3 to 1e3, from nearly circular to nearly
radial; against finite parts of sums on the real axis in 500 bits, which share nothing with the paths of the ensemble,
and some against ``Motion.derivatives`` to 30 digits. Status 1 where an error is larger than was claimed.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import flint
import mpmath
import numpy as np
from flint import arb

import hjsolve
from benchmarks import galaxy_families as stars
from hjsolve.errors import HJSolveError

number = mpmath.mp.clone()
number.dps = 40
_AT_ONCE = 100
"""Random motions in one field."""
_BITS, _CHECKED = 500, 200
"""Of the sums that claims are held against; and every which motion is held against ``Motion.derivatives`` instead."""
Array = Any


def galaxy_orbits(rows: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Places and momenta of stars in prolate coordinates."""
    u, w, pu, pw, pφ = stars.prolate(rows).T
    return {"u": u, "w": w, "phi": 0 * u}, {"u": pu, "w": pw, "phi": pφ}


def cases(count: int) -> Iterator[tuple[str, Any, dict[str, Array], dict[str, Array]]]:
    """Yield the five families, a disc with a halo, and orbits round the first one of catalog entries."""
    galaxy = stars.galaxy()
    for name in stars.FAMILIES:
        yield name, galaxy, *galaxy_orbits(stars.family(name, count))
    yield "disc and halo", galaxy, *galaxy_orbits(stars.disc_and_halo(count))
    rng = np.random.default_rng(1)
    for name in ("isochrone", "spherical-pendulum", "two-centres-space"):
        solution = hjsolve.solve(hjsolve.catalog.load(name))
        start = solution.motion(**hjsolve.catalog.describe(name).initial.arguments).initial.values
        q = {c.name: float(start[c.symbol]) * rng.uniform(0.9, 1.1, count) for c in solution.system.coordinates}
        p = {c.name: float(start[c.momentum]) * rng.uniform(0.8, 1.2, count) for c in solution.system.coordinates}
        yield name, solution, q, p


def price(count: int) -> None:
    """Print the table."""
    print("| orbits | values, µs | derivatives, µs | ratio | ok |\n|---|---|---|---|---|")
    for name, solution, q, p in cases(count):
        times: dict[str, list[float]] = {"values": [], "derivatives": []}
        for turn in range(4):
            begin = time.process_time()
            hjsolve.ensemble(solution, q, p, want={"actions", "frequencies"}, threads=1)
            middle = time.process_time()
            found = hjsolve.ensemble_derivatives(solution, q, p, threads=1)
            if turn:
                times["values"].append(middle - begin)
                times["derivatives"].append(time.process_time() - middle)
        values, derivatives = (1e6 * min(t) / count for t in times.values())
        ok = float((found.status == "ok").mean())
        print(f"| {name} | {values:.1f} | {derivatives:.1f} | {derivatives / values:.1f} | {ok:.2%} |", flush=True)


Term = Callable[[Any], Any]


def field(rng: random.Random) -> tuple[Any, Term, dict[str, Array], dict[str, Array]]:
    """Return a random field, its V in many digits, and random motions in it."""
    scale = 10.0 ** rng.uniform(-3, 3)
    r, unit = f"(r/{scale!r})", arb(repr(scale))
    k, s, c, Q, A, w = (
        rng.uniform(low, high) for low, high in ((0.1, 2), (0.1, 2), (0.05, 2), (0.2, 3), (-0.5, 0.5), (0.01, 0.3))
    )
    K, S, C, M, D, B = (arb(repr(x)) for x in (k, s, c, Q, A, w))
    parts: list[tuple[str, Term]] = [
        (f"{k!r}*{r}**2", lambda x: K * x * x),
        (f"{s!r}*log({c!r} + {r}**2)", lambda x: S * (C + x * x).log()),
        (f"-{Q!r}/{r}", lambda x: -M / x),
        (f"{A!r}*exp(-({r} - 1)**2/{w!r})", lambda x: D * (-(x - 1) * (x - 1) / B).exp()),
    ]
    chosen = rng.sample(parts, rng.randint(1, 3))
    system = hjsolve.System(
        {"r": "0 < r", "phi": "angle"}, "dot(r)**2/2 + r**2*dot(phi)**2/2", " + ".join(text for text, _ in chosen)
    )  # fmt: skip
    places = np.array([scale * 10.0 ** rng.uniform(-1, 1) for _ in range(_AT_ONCE)])
    radial = np.array([rng.choice((0.0, 1.0)) * 10.0 ** rng.uniform(-8, 0) for _ in range(_AT_ONCE)])
    turning = np.array([10.0 ** rng.uniform(-3, 0.5) for _ in range(_AT_ONCE)])
    q, p = {"r": places, "phi": 0 * places}, {"r": radial, "phi": turning * places}
    return hjsolve.solve(system), lambda x: sum((term(x / unit) for _, term in chosen), arb(0)), q, p


def turning_point(F: Term, x: Any) -> Any:
    """Return the zero of F next to x, by secants."""
    here, step = arb(x).mid(), arb(2) ** -60
    before, value = F(here - step).mid(), F(here).mid()
    for _ in range(80):
        if value == before:
            break
        step = (-value * step / (value - before)).mid()
        here, before = (here + step).mid(), value
        value = F(here).mid()
        if abs(step) <= arb(2) ** -(flint.ctx.prec - 80):
            break
    return here


def by_finite_parts(V: Term, start: tuple[float, float, float], ends: tuple[float, float]) -> Array | None:
    """Return J_E, J_L, J_EE, J_EL, J_LL of the radial action, by sums on the real axis in many digits.

    J = (1/2π) ∮ √F dx over x = log r, F = 2r² (E − V) − L². With x = m − h cos χ and F = h² sin²χ S the integrands of
    J_jk are g/sin²χ, whose midpoint sums of N terms are too large by N (g(0) + g(π))/2. None where 1024 nodes leave
    more than 20 digits open.
    """
    r, pr, L = map(arb, start)
    E = (pr * pr + (L / r) ** 2) / 2 + V(r)

    def F(x: Any) -> Any:
        r = x.exp()
        return 2 * r * r * (E - V(r)) - L * L

    a, b = (turning_point(F, arb(x).log()) for x in ends)
    middle, h = (a + b) / 2, (b - a) / 2
    tiny, last, n = h * arb(2) ** -100, None, 32

    def rows(x: Any, S: Any) -> list[Any]:
        """G of J_EE, J_EL, J_LL, then J_E, J_L and what is regular in J_LL."""
        flat, steep, root = 2 * (2 * x).exp(), -2 * L, S.sqrt()
        common = -1 / (4 * h * h * S * root)
        second = [flat * flat * common, flat * steep * common, steep * steep * common]
        return [*second, flat / (2 * root), steep / (2 * root), -1 / root]

    tips = [rows(x, abs(F(x + tiny) - F(x - tiny)) / (4 * h * tiny)) for x in (a, b)]
    while n <= 1024:
        total = [arb(0)] * 6
        for j in range(n):
            χ = arb.pi() * (2 * j + 1) / (2 * n)
            square = χ.sin() ** 2
            x = middle - h * χ.cos()
            found = rows(x, F(x) / (h * h * square))
            total = [t + (f / square if k < 3 else f) for k, (t, f) in enumerate(zip(total, found, strict=True))]
        means = [t / n for t in total]
        means[:3] = [m - n * (x + y) / 2 for m, x, y in zip(means[:3], *tips, strict=False)]
        made = [means[3], means[4], means[0], means[1], means[2] + means[5]]
        sizes = [*means[3:5], *(n * x for x in tips[0][:3])]
        if last is not None and all(
            abs((x - y).mid()) <= 1e-20 * abs(x.mid()) + 1e-28 * abs(s.mid())
            for x, y, s in zip(made, last, sizes, strict=True)
        ):
            return np.array([number.mpf(x.mid().str(40, radius=False)) for x in made])
        last, n = made, 2 * n
    return None


def truths(solution: Any, V: Term, start: dict[str, dict[str, float]], ends: tuple[float, float], check: bool) -> Any:
    """Return the derivatives of one motion, of the shape of those of the batch; by ``Motion.derivatives`` to check."""
    if check:
        return solution.motion(**start, digits=30).derivatives({"actions", "frequencies"}, {"constants"}).value
    found = by_finite_parts(V, (start["q"]["r"], start["p"]["r"], start["p"]["phi"]), ends)
    if found is None:
        return None
    J_E, J_L, J_EE, J_EL, J_LL = found
    return {
        "actions": {"r": {"E": J_E, "p_phi": J_L}, "phi": {"E": number.mpf(0), "p_phi": number.mpf(1)}},
        "frequencies": {
            "r": {"E": -J_EE / J_E**2, "p_phi": -J_EL / J_E**2},
            "phi": {"E": (J_L * J_EE / J_E - J_EL) / J_E, "p_phi": (J_L * J_EL / J_E - J_LL) / J_E},
        },
    }


def judged(start: dict[str, dict[str, float]], truth: Any, k: int, found: Any) -> tuple[list[str], float]:
    """Claims that do not hold for one motion, and its largest error of ∂Ω/∂α over |Ω/α| and the derivative itself."""
    broken, worst = [], 0.0
    for quantity in truth:
        for name, constants in found.value[quantity].items():
            for constant, column in constants.items():
                true = number.convert(truth[quantity][name][constant])
                error = abs(number.mpf(float(column[k])) - true)
                claim = float(found.error[quantity][name][constant][k])
                own = abs(float(found.batch.frequencies[name][k]) / float(found.batch.constants[constant][k]))
                if quantity == "frequencies":
                    worst = max(worst, float(error / (abs(true) + own)))
                if error > claim + 1e-25 * (1 + abs(true)):
                    broken.append(f"{start} {quantity} {name} {constant}: {float(error):.2g}, claimed {claim:.2g}")
    return broken, worst


def claims(motions: int, seconds: float, seed: int) -> int:
    """Print false claims, and how many there are."""
    begin, done, lost, unknown, faults, errors, index = time.monotonic(), 0, 0, 0, 0, [0.0], 0
    flint.ctx.prec = _BITS
    while done < motions and time.monotonic() - begin < seconds:
        solution, V, q, p = field(random.Random(f"batch/{seed}/{index}"))
        index += 1
        found = hjsolve.ensemble_derivatives(solution, q, p, threads=1)
        lost += int((found.status == "not_converged").sum())
        for k in np.flatnonzero(found.status == "ok"):
            if time.monotonic() - begin > seconds:
                break
            start = {g: {n: float(x[k]) for n, x in own.items()} for g, own in (("q", q), ("p", p))}
            ends = float(found.batch.turning_points["r"][0][k]), float(found.batch.turning_points["r"][1][k])
            try:
                truth = truths(solution, V, start, ends, (done + 1) % _CHECKED == 0)
            except HJSolveError:
                truth = None
            if truth is None:
                unknown += 1
                continue
            broken, worst = judged(start, truth, int(k), found)
            done, faults = done + 1, faults + len(broken)
            errors.append(worst)
            for line in broken:
                print(index - 1, solution.system.potential, line, flush=True)
    median, most = np.quantile(errors, [0.5, 0.99])
    print(f"{done} motions in {index} fields, {lost} not converged, {unknown} without a truth: {faults} claims do not "
          f"hold; errors of frequencies' derivatives, relative, {median:.1e} (median), {most:.1e} (99 %)")  # fmt: skip
    return 1 if faults else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=("price", "claims"))
    parser.add_argument("--orbits", type=int, default=20_000)
    parser.add_argument("--motions", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.part == "claims":
        return claims(options.motions, options.seconds, options.seed)
    price(options.orbits)
    return 0


if __name__ == "__main__":
    sys.exit(main())
