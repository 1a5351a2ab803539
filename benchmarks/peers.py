"""The same work by hjsolve and by its peers: ratios of time, error next to time, all sides interleaved in one run.

    python -m benchmarks.peers [--json FILE] [--repeats N] [WORK …]      WORK: pendulum kepler kerr galaxy

Rivals come with the extra ``bench``; one that is not installed is named and left out. Every contestant does one
warming call (its time is "first": tables, compilation), then all take turns; times are medians of processor time per
unit of work, all threads added up, so other programs on the machine hardly count. Errors are against closed forms or
quadratures at 30 digits or more, on a sample. The inputs count as exact.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import json
import math
import os
import platform
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

import hjsolve
from benchmarks.motion_engine import exact_kepler, exact_pendulum


@dataclass(frozen=True)
class Side:
    """A contestant: who, what it does in one call, and how far off its answer is."""

    who: str
    call: Callable[[], Any]
    error: Callable[[Any], float]
    path: str = "1"


@dataclass(frozen=True)
class Row:
    """One line of the table; seconds per unit of work, ``first`` for the whole first call."""

    work: str
    case: str
    who: str
    seconds: float
    first: float
    error: float
    ratio: float


MISSING: set[str] = set()


def rival(name: str) -> Any | None:
    """Import a peer; None, and its name in the closing note, where it is not installed."""
    with contextlib.suppress(ImportError):
        return importlib.import_module(name)
    MISSING.add(name.partition(".")[0])
    return None


def contest(work: str, case: str, units: int, sides: list[Side], repeats: int) -> Iterator[Row]:
    """Let all sides take turns; ratios are against the first side."""

    def timed(side: Side) -> tuple[float, Any]:
        os.environ["HJSOLVE_COMPILED"] = side.path
        begin = time.process_time()
        result = side.call()
        return time.process_time() - begin, result

    firsts = [timed(side) for side in sides]
    slow = max(first for first, _ in firsts) > 5
    rounds = [[timed(side)[0] for side in sides] for _ in range(1 if slow else repeats)]
    medians = [statistics.median(column) / units for column in zip(*rounds, strict=True)]
    for side, (first, result), seconds in zip(sides, firsts, medians, strict=True):
        yield Row(work, case, side.who, seconds, first, side.error(result), seconds / medians[0])


def far(found: Any, truth: list[Any], chosen: list[int], relative: bool = False) -> float:
    """Largest error on a sample; NaN in the answer is an infinite error."""
    errors = [
        abs(mpmath.mpf(float(found[i])) - x) / (abs(x) if relative else 1) for i, x in zip(chosen, truth, strict=True)
    ]
    return max(float(e) if e == e else math.inf for e in errors)


def pendulum(repeats: int) -> Iterator[Row]:
    special, integrate, hy = rival("scipy.special"), rival("scipy.integrate"), rival("heyoka")
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    for gap in ("0.9", "0.1", "1e-6", "1e-12"):
        rate = f"2*(1-{gap})"
        motion = solution.motion(q={"theta": 0}, velocity={"theta": rate}, parameters={"m": 1, "g": 1, "l": 1})
        k = 1 - float(gap)
        for periods in (10, 10**3, 10**9):
            t = np.sort(np.random.default_rng(1).uniform(0, periods * motion.periods["theta"].value, 100_000))
            chosen = list(range(0, len(t), 2500))
            truth = [exact_pendulum(gap, t[i]) for i in chosen]

            def error(θ: Any, truth: Any = truth, chosen: Any = chosen) -> float:
                return far(θ, truth, chosen)

            sides = [Side(f"hjsolve {name}", lambda t=t, m=motion: m.at(t).q["theta"], error, path)
                     for name, path in (("fast", "1"), ("numpy", "0"))]  # fmt: skip
            if special:
                sides.append(
                    Side("scipy ellipj", lambda t=t, k=k: 2 * np.arcsin(k * special.ellipj(t, k * k)[0]), error)
                )
            if hy and periods == 10:
                sides.append(Side("heyoka Taylor", lambda t=t, k=k: _heyoka_pendulum(hy, 2 * k, t), error))
            if integrate and periods == 10:
                sides.append(Side("DOP853 1e-12", lambda t=t, k=k: _dop853(
                    integrate, lambda _, y: (y[1], -math.sin(y[0])), (0.0, 2 * k), t)[0], error))  # fmt: skip
            yield from contest("pendulum q(t)", f"1-k={gap}, {periods:.0e} periods", len(t), sides, repeats)


def _heyoka_pendulum(hy: Any, rate: float, t: Any) -> Any:
    x, v = hy.make_vars("x", "v")
    integrator = hy.taylor_adaptive([(x, v), (v, -hy.sin(x))], [0.0, rate])
    return integrator.propagate_grid(np.concatenate([[0.0], t]))[-1][1:, 0]


def _dop853(integrate: Any, field: Any, start: Any, t: Any) -> Any:
    return integrate.solve_ivp(field, (0.0, t[-1]), start, method="DOP853", rtol=1e-12, atol=1e-12, t_eval=t).y


def kepler(repeats: int) -> Iterator[Row]:
    hy, integrate = rival("heyoka"), rival("scipy.integrate")
    solution = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
    for e in ("0", "0.1", "0.9", "0.999999", "0.999999999999", "1", "1.0000001", "2"):
        motion = solution.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": f"sqrt(1+{e})"})
        reach = 3 * motion.periods["r"].value if "r" in motion.periods else 3000.0
        t = np.sort(np.random.default_rng(3).uniform(0, reach, 1_000_000))
        chosen = list(range(0, len(t), 12_500))
        truth = [exact_kepler(e, t[i]) for i in chosen]

        def error(r: Any, truth: Any = truth, chosen: Any = chosen) -> float:
            return far(r, truth, chosen, relative=True)

        sides = [Side(f"hjsolve {name}", lambda t=t, m=motion: m.at(t).q["r"], error, path)
                 for name, path in (("fast", "1"), ("numpy", "0"))]  # fmt: skip
        if hy and float(e) < 1:
            sides.append(Side("heyoka kepE", _heyoka_kepler(hy, float(e), t), error))
        if integrate:
            speed = math.sqrt(1 + float(e))
            sides.append(Side("DOP853 1e-12", lambda t=t, v=speed: np.hypot(*_dop853(
                integrate, _attraction, (1.0, 0.0, 0.0, v), t)[:2]), error))  # fmt: skip
        yield from contest("Kepler r(t)", f"e={e}", len(t), sides, repeats)


def _attraction(_: float, y: Any) -> tuple[float, ...]:
    cube = (y[0] * y[0] + y[1] * y[1]) ** 1.5
    return y[2], y[3], -y[0] / cube, -y[1] / cube


def _heyoka_kepler(hy: Any, e: float, t: Any) -> Callable[[], Any]:
    eccentricity, anomaly = hy.make_vars("e", "M")
    function = hy.cfunc([1 - eccentricity * hy.cos(hy.kepE(eccentricity, anomaly))], vars=[eccentricity, anomaly])
    a = 1 / (1 - e)
    return lambda: a * function(np.stack([np.full_like(t, e), np.remainder(t * a**-1.5, 2 * np.pi)]))[0]


def kerr(repeats: int) -> Iterator[Row]:
    from tests.motion.test_kerr import separatrix, start
    from tests.reference.kerr import by_quadrature, from_start, from_turning_points, in_closed_form

    kg, names = rival("kerrgeopy"), ("r", "theta", "phi")
    system = hjsolve.catalog.load("kerr")
    solution = hjsolve.solve(system)
    a, e, x = "0.9", "0.3", "0.7"
    with mpmath.mp.workdps(46):
        edge = separatrix(mpmath.mpf(a), mpmath.mpf(e), mpmath.mpf(x))
        cases = [
            ("generic", mpmath.mpf(6)),
            *((f"separatrix + {d}", mpmath.mpf(float(edge + mpmath.mpf(d)))) for d in ("1e-8", "1e-10")),
        ]
        for case, p in cases:
            orbit = from_turning_points(mpmath.mpf(float(a)), p, mpmath.mpf(float(e)), mpmath.mpf(float(x)))
            truth, begin = in_closed_form(orbit), start(orbit, (orbit.roots[0] + orbit.roots[1]) / 2)

            def error(found: Any, truth: Any = truth) -> float:
                return max(float(abs(mpmath.mpf(float(f)) / mpmath.mpf(float(found[0])) * truth["r"] / truth[n] - 1))
                           for f, n in zip(found, names, strict=True))  # fmt: skip

            def one(begin: Any = begin) -> list[Any]:
                motion = solution.motion(**begin, parameters={"a": float(a)}, want=["frequencies"])
                return [motion.frequencies[n].value for n in names]

            sides = [Side("hjsolve motion", one, error)]
            if kg:
                sides.append(
                    Side(
                        "kerrgeopy", lambda p=p: kg.mino_frequencies(float(a), float(p), float(e), float(x))[:3], error
                    )
                )
            yield from contest("Kerr frequencies", f"one orbit, {case}", 1, sides, repeats)
        rng = np.random.default_rng(7)
        shapes = [(rng.uniform(7, 12), rng.uniform(0.02, 0.7), rng.uniform(0.3, 0.95)) for _ in range(1000)]
        orbits = [from_turning_points(mpmath.mpf(float(a)), *map(mpmath.mpf, shape)) for shape in shapes]
        middles = [(o.roots[0] + o.roots[1]) / 2 for o in orbits]
        columns = np.array(
            [
                [float(v) for v in (r, -o.E, o.momentum(r), mpmath.sqrt(o.Q), o.L)]
                for r, o in zip(middles, orbits, strict=True)
            ]
        ).T
        zero = np.zeros(len(orbits))
        q = {"t": zero, "r": columns[0], "theta": zero + np.pi / 2, "phi": zero}
        momenta = {"t": columns[1], "r": columns[2], "theta": columns[3], "phi": columns[4]}
        given = [
            from_start(mpmath.mpf(float(a)), *(mpmath.mpf(float(v)) for v in (r, np.pi / 2, E, pr, pθ, L)))
            for r, E, pr, pθ, L in columns.T[:6]
        ]
        with mpmath.mp.workdps(25):
            exact = [by_quadrature(o) for o in given]

        def many_error(batch: Any) -> float:
            return max(
                float(abs(mpmath.mpf(float(batch.frequencies[n][i])) * t["tau"] / t[n] - 1))
                for i, t in enumerate(exact)
                for n in names
            )

        sides = [Side("hjsolve ensemble", lambda: hjsolve.ensemble(
            system, q=q, p=momenta, parameters={"a": float(a)}, want={"frequencies"}), many_error)]  # fmt: skip
        if kg:

            def theirs(found: Any) -> float:
                return max(
                    float(abs(mpmath.mpf(float(found[i][k])) / t[n] - 1))
                    for i, t in enumerate(exact)
                    for k, n in enumerate(names)
                )

            sides.append(
                Side("kerrgeopy loop", lambda: [kg.mino_frequencies(float(a), *shape) for shape in shapes], theirs)
            )
        yield from contest("Kerr frequencies", "1000 generic orbits", 1000, sides, repeats)


def galaxy(repeats: int) -> Iterator[Row]:
    system = hjsolve.catalog.load("kuzmin-kutuzov")
    rng, count = np.random.default_rng(5), 2000
    R, z = rng.uniform(0.5, 3, count), rng.uniform(-0.4, 0.4, count)
    vR, vz = rng.uniform(-0.2, 0.2, (2, count))
    vT = rng.uniform(0.3, 0.7, count)
    place = np.arcsinh(R + 1j * z)
    u, w = place.real, place.imag
    q = {"u": u, "w": w, "phi": np.zeros(count)}
    p = {"u": vR * np.cosh(u) * np.cos(w) + vz * np.sinh(u) * np.sin(w), "phi": R * vT,
         "w": -vR * np.sinh(u) * np.sin(w) + vz * np.cosh(u) * np.cos(w)}  # fmt: skip
    solution = hjsolve.solve(system)
    exact = [solution.motion(q={n: float(v[i]) for n, v in q.items()}, p={n: float(v[i]) for n, v in p.items()},
                             digits=30, want=["actions"]).actions for i in range(12)]  # fmt: skip

    def error(columns: Any) -> float:
        return max(
            float(abs(mpmath.mpf(float(c[i])) / t[n].value - 1))
            for n, c in columns.items()
            for i, t in enumerate(exact)
        )

    for want in ({"actions"}, {"actions", "frequencies", "angles"}):
        sides = [Side("hjsolve ensemble", lambda want=want: hjsolve.ensemble(system, q=q, p=p, want=want),
                      lambda b: error({"u": b.actions["u"], "w": b.actions["w"]}))]  # fmt: skip
        if (actions := rival("galpy.actionAngle")) and (potential := rival("galpy.potential")):
            pot = potential.KuzminKutuzovStaeckelPotential(amp=1.0, ac=5.0, Delta=1.0)
            rule = actions.actionAngleStaeckel(pot=pot, delta=1.0, c=True, order=20)
            call = rule if want == {"actions"} else rule.actionsFreqsAngles
            arguments = (R, vR, vT, z, vz) if want == {"actions"} else (R, vR, vT, z, vz, np.zeros(count))
            sides.append(Side("galpy C, order 20", lambda call=call, arguments=arguments: call(*arguments),
                              lambda found: error({"u": found[0], "w": found[2]})))  # fmt: skip
        yield from contest("Kuzmin-Kutuzov galaxy", ", ".join(sorted(want)), count, sides, repeats)


WORKS = {"pendulum": pendulum, "kepler": kepler, "kerr": kerr, "galaxy": galaxy}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("works", nargs="*", choices=[[], *WORKS], help="what to run; all by default")
    parser.add_argument("--json", type=Path, default=Path("peers.json"))
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    rows: list[Row] = []
    print(f"{'work':22} {'case':34} {'who':18} {'per unit':>11} {'first call':>11} {'max error':>10} {'time/ours':>10}")
    for name in arguments.works or WORKS:
        for row in WORKS[name](arguments.repeats):
            rows.append(row)
            print(f"{row.work:22} {row.case:34} {row.who:18} {row.seconds * 1e9:8.0f} ns {row.first:9.3f} s "
                  f"{row.error:10.1e} {row.ratio:10.2f}", flush=True)  # fmt: skip
    for name in sorted(MISSING):
        print(f"{name} is not installed: left out (pip install 'hjsolve[bench]')")
    machine = {"python": platform.python_version(), "machine": platform.machine(), "cores": os.cpu_count()}
    arguments.json.write_text(
        json.dumps({"machine": machine, "missing": sorted(MISSING), "rows": [asdict(r) for r in rows]}, indent=1)
    )


if __name__ == "__main__":
    main()
