"""What many orbits cost: the whole public call, over all kinds of orbits, hjsolve and galpy's C taking turns.

    python -m benchmarks.ensembles [PART …] [--orbits N] [--repeats N] [--write]    PART: families small velocity fresh
    others

Times are processor time of the process (one thread), medians of the second and later calls of all contestants in turn;
a busy machine changes the ratios little. Every sample ends with 40 orbits of the same family whose actions and
frequencies are known to 32 digits; the errors and claims next to the times are of those. "error/limit" is the largest
error over max(1e-12, 20 times what half an ulp of the input does). The tables are Markdown; ``--write`` puts them, with
what the machine was doing, into ``docs/ensembles.md`` where comments name the part.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import hjsolve
from benchmarks import galaxy_families as stars
from benchmarks.kerr_orbits import about_kerr

WANTS = (("actions",), ("actions", "frequencies"), ("actions", "frequencies", "angles"))
SHORT = {WANTS[0]: "actions", WANTS[1]: "+ frequencies", WANTS[2]: "+ angles"}
COLUMNS = (("actions", "u"), ("actions", "w"), ("frequencies", "u"), ("frequencies", "phi"), ("frequencies", "w"))
PAGE = Path(__file__).resolve().parents[1] / "docs" / "ensembles.md"
_ALONE = 6
"""Orbits of the disc and halo whose references are computed here; their limit is 1e-12."""
_DISC = 5
"""How many times as many orbits the disc and halo have."""
Call = Callable[[], Any]


def in_turn(calls: dict[str, Call], repeats: int) -> tuple[dict[str, float], dict[str, Any]]:
    """Median processor seconds of each call, after one that does not count; and what the calls gave."""
    spent: dict[str, list[float]] = {name: [] for name in calls}
    given = {name: call() for name, call in calls.items()}
    for _ in range(repeats):
        for name, call in calls.items():
            begin = time.process_time()
            call()
            spent[name].append(time.process_time() - begin)
    return {name: statistics.median(times) for name, times in spent.items()}, given


def known() -> dict[str, Any]:
    """Return the orbits with references; see ``tests/support/kuzmin_kutuzov``."""
    with np.load(stars.DATA / "kuzmin_kutuzov.npz") as file:
        return dict(file)


def galpy_rule() -> Any | None:
    """Galpy's actionAngleStaeckel in C at order 20; None where it is not installed."""
    try:
        from galpy.actionAngle import actionAngleStaeckel
        from galpy.potential import KuzminKutuzovStaeckelPotential
    except ImportError:
        return None
    potential = KuzminKutuzovStaeckelPotential(amp=1.0, ac=5.0, Delta=1.0)
    return actionAngleStaeckel(pot=potential, delta=1.0, c=True, order=20)


def galpy_call(rule: Any, want: tuple[str, ...], rows: Any) -> Call:
    """Return the same by galpy: rows J_R, J_φ, J_z, Ω_R, Ω_φ, Ω_z and angles."""
    R, vR, vT, z, vz = rows.T
    if want == WANTS[0]:
        return lambda: rule(R, vR, vT, z, vz)
    if want == WANTS[1]:
        return lambda: rule.actionsFreqs(R, vR, vT, z, vz)
    return lambda: rule.actionsFreqsAngles(R, vR, vT, z, vz, 0.0 * R)


def by_single_motions(rows: Any) -> dict[str, Any]:
    """Return references for prolate rows by the engine of single motions, in 30 digits."""
    high, low, names = [], [], ("u", "w", "phi")
    for u, w, *momenta in rows.tolist():
        motion = stars.galaxy().motion(
            q=dict(zip(names, (u, w, 0.3), strict=True)),
            p=dict(zip(names, momenta, strict=True)),
            digits=30,
            want=WANTS[1],
        )
        exact = [getattr(motion, quantity)[name].value for quantity, name in COLUMNS]
        high.append([float(x) for x in exact])
        low.append([float(x - float(x)) for x in exact])
    found = {"reference_prolate_high": np.array(high), "reference_prolate_low": np.array(low)}
    return {**found, "floor_prolate": np.zeros((len(high), len(COLUMNS)))}


def sample(family: str, count: int) -> tuple[Any, dict[str, Any]]:
    """Cylindrical rows, those with references at the end, and the references; of a disc and halo five times as many."""
    if family not in stars.FAMILIES:
        return stars.disc_and_halo(_DISC * count), {}
    data = known()
    chosen = data["family"] == stars.FAMILIES.index(family)
    rows = np.concatenate([stars.family(family, count - chosen.sum()), data["cylindrical"][chosen]])
    return rows, {key: value[chosen] for key, value in data.items() if len(value) == len(chosen)}


def our_call(solution: Any, rows: Any, **how: Any) -> Call:
    """Return the public call, everything from arrays to a batch."""
    u, w, pu, pw, pφ = rows.T
    q, p = {"u": u, "w": w, "phi": 0.3}, {"u": pu, "w": pw, "phi": pφ}
    return lambda: hjsolve.ensemble(solution, q, p, threads=1, **how)


def quality(batch: hjsolve.Batch, references: dict[str, Any]) -> tuple[float, float, float]:
    """Largest error over its limit, over its claim, and largest relative claim."""
    found = []
    for k, (quantity, name) in enumerate(COLUMNS):
        if references and quantity in batch.layout.want:
            high, low, floor = (
                references[key][:, k] for key in ("reference_prolate_high", "reference_prolate_low", "floor_prolate")
            )
            error = np.abs((getattr(batch, quantity)[name][-len(high) :] - high) - low)
            claim = batch.error[quantity][name][-len(high) :]
            limit = np.maximum(1e-12, 20 * floor) * np.abs(high)
            found.append((np.max(error / limit), np.max(error / claim), np.max(claim / np.abs(high))))
    return tuple(np.max(found, axis=0)) if found else (np.nan,) * 3


def worth(batch: hjsolve.Batch, references: dict[str, Any]) -> tuple[str, ...]:
    """Error over limit, error over claim, the largest claim, and how many orbits are ok, in per cent."""
    return *(f"{x:.1g}" for x in quality(batch, references)), f"{100 * batch.summary().get('ok', 0) / len(batch):.2f}"


def galpy_quality(found: Any, references: dict[str, Any]) -> tuple[float, float]:
    """Median relative error of galpy's actions, and the fraction of orbits that are lost (NaN, or 9999.99)."""
    values = np.stack([np.asarray(x, float) for x in found])
    lost = (~np.isfinite(values) | (np.abs(values - 9999.99) < 0.01)).any(axis=0)
    errors = [
        np.abs(values[row][-40:] / references["reference_cylindrical_high"][:, k] - 1)
        for row, k in ((0, 0), (2, 1))
        if references
    ]
    kept = np.array(errors)[:, ~lost[-40:]] if references else np.empty(0)
    return float(np.median(kept)) if kept.size else np.nan, float(lost.mean())


def head(text: str) -> Iterator[str]:
    """Yield the first two lines of a table."""
    yield f"| {text} |"
    yield f"|{'---|' * (text.count('|') + 1)}"


def row(*cells: str) -> str:
    """One line of it."""
    return f"| {' | '.join(cells)} |"


def families(count: int, repeats: int) -> Iterator[str]:
    """Yield times and errors of all kinds of orbits."""
    solution, rule = stars.galaxy(), galpy_rule()
    yield from head(
        "orbits | wanted | ours, µs | galpy C, µs | ours/galpy | error/limit | error/claim | largest claim | ok, % "
        "| galpy: error of J, lost"
    )
    for family in (*stars.FAMILIES, "disc and halo"):
        rows, references = sample(family, count)
        carried = stars.prolate(rows)
        if references:
            carried[-40:] = references["prolate"]
        ours_alone = references or by_single_motions(carried[-_ALONE:])
        for want in WANTS:
            calls = {"ours": our_call(solution, carried, want=want)}
            if rule is not None:
                calls["galpy"] = galpy_call(rule, want, rows)
            with np.errstate(all="ignore"):
                seconds, given = in_turn(calls, repeats)
            ours, theirs = (1e6 * seconds.get(name, np.nan) / len(rows) for name in ("ours", "galpy"))
            rival = "{:.0e}, {:.0%}".format(*galpy_quality(given["galpy"], references)) if rule is not None else "–"
            times = (f"{x:.1f}" for x in (ours, theirs))
            yield row(family, SHORT[want], *times, f"{ours / theirs:.2f}", *worth(given["ours"], ours_alone), rival)


def small(count: int, repeats: int) -> Iterator[str]:
    """Few orbits, and values of parameters and formulas that nobody has seen, after a call that loads the kernels."""
    yield from head("what | orbits | µs an orbit | over the known call of as many")
    kepler = hjsolve.catalog.load("kepler-planar")
    numbers, formulas = iter(range(10**6)), iter(range(10**6))

    def call(n: int, kind: str) -> Call:
        rng = np.random.default_rng(n)
        r, p = rng.uniform(0.5, 2, n), rng.uniform(-0.3, 0.3, n)
        given = {"q": {"r": r, "theta": 0.0}, "p": {"r": p, "theta": rng.uniform(0.4, 1.1, n) * np.sqrt(r)}}

        def ours() -> hjsolve.Batch:
            system, more = kepler, {}
            if kind == "new value":
                more = {"parameters": {"k": f"1.{next(numbers):06d}1"}}
            if kind == "new formula":
                system = hjsolve.System(
                    {"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2",
                    f"-1/r - r**2/{10**6 + next(formulas)}",
                )  # fmt: skip
            return hjsolve.ensemble(system, **given, want=WANTS[1], threads=1, **more)

        return ours

    for n in (100, 1000, 20_000, 5 * count):
        seconds, _ = in_turn({kind: call(n, kind) for kind in ("known", "new value", "new formula")}, repeats)
        for kind, spent in seconds.items():
            yield row(kind, str(n), f"{1e6 * spent / n:.1f}", f"{spent / seconds['known']:.2f}")


def velocity(count: int, repeats: int) -> Iterator[str]:
    """Velocities instead of momenta, of the disc and halo, in the potential as it is typed."""
    solution, rows = stars.galaxy(), stars.prolate(stars.disc_and_halo(_DISC * count))
    q = {"u": rows[:, 0], "w": rows[:, 1], "phi": 0.3}
    rates = dict(zip(("u", "w", "phi"), stars.velocities(rows).T[2:], strict=True))
    yield from head("wanted | `p=`, µs | `velocity=`, µs | ratio | claim, `p=` | claim, `velocity=` | ok, %")
    for want in WANTS:
        calls: dict[str, Call] = {
            "p": our_call(solution, rows, want=want),
            "v": lambda want=want: hjsolve.ensemble(solution, q, velocity=rates, want=want, threads=1),
        }
        seconds, given = in_turn(calls, repeats)
        one, other = (1e6 * seconds[name] / len(rows) for name in "pv")
        claims = [
            np.nanmax(np.abs(batch.error[quantity][name] / getattr(batch, quantity)[name]))
            for batch in given.values()
            for quantity, name in (("actions", "u"),)
        ]
        good = 100 * given["v"].summary().get("ok", 0) / len(rows)
        numbers = (f"{one:.1f}", f"{other:.1f}", f"{other / one:.2f}", f"{claims[0]:.0e}", f"{claims[1]:.0e}")
        yield row(SHORT[want], *numbers, f"{good:.2f}")


_FRESH = """
import time
begin = time.process_time(), time.perf_counter()
import numpy as np
import hjsolve
system = hjsolve.System(
    {{"x": "line", "y": "line"}}, "dot(x)**2/2 + dot(y)**2/2", "{a}*x**2/2 + x**4/4 + cosh({a}*y) + y**4/{b}"
)
rng = np.random.default_rng(3)
q = {{"x": rng.uniform(0.5, 1.5, 1000), "y": rng.uniform(-0.5, 0.5, 1000)}}
p = {{"x": rng.uniform(-1, 1, 1000), "y": rng.uniform(0.1, 1, 1000)}}
for call in range(2):
    batch = hjsolve.ensemble(system, q, p, want={want!r}, threads=1)
    print(time.process_time() - begin[0], time.perf_counter() - begin[1])
    begin = time.process_time(), time.perf_counter()
"""


def fresh() -> Iterator[str]:
    """1 000 orbits of a new system: import, compilation and all, and the second call."""
    yield from head("1 000 orbits, new system | kernels | first call, s | (wall) | second call, ms")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o700)
        surroundings = {**os.environ, "HJSOLVE_CACHE_DIR": folder, "OMP_NUM_THREADS": "1"}
        for attempt, kernels in enumerate(("compiled", "on disk")):
            for want in (WANTS[0], WANTS[2]):
                code = _FRESH.format(a=f"1.{attempt}37", b=3 + len(want), want=want)
                done = subprocess.run(
                    [sys.executable, "-c", code], env=surroundings, capture_output=True, text=True, check=True
                )
                (first, wall), (second, _) = ([float(x) for x in line.split()] for line in done.stdout.splitlines())
                yield row(SHORT[want], kernels, f"{first:.1f}", f"{wall:.1f}", f"{1e3 * second:.0f}")


def others(count: int, repeats: int) -> Iterator[str]:
    """Unbounded orbits, Kerr's frequencies, and profiles of galaxies as they are typed."""
    yield from head("what | orbits | µs an orbit | statuses")
    for what, call, number in _others(count):
        seconds, given = in_turn({"ours": call}, repeats)
        yield row(what, str(number), f"{1e6 * seconds['ours'] / number:.0f}", str(given["ours"].summary()))


def _others(count: int) -> Iterator[tuple[str, Call, int]]:
    rng = np.random.default_rng(6)
    rows = stars.family("generic", 4000)
    rows[:, [1, 2, 4]] *= (
        1.2 / np.sqrt((rows[:, [1, 2, 4]] ** 2).sum(axis=1) / (-2 * stars.potential(rows[:, 0], rows[:, 3])))[:, None]
    )  # speeds of 1.2 times the speed of escape
    for number in (40, 4000):
        yield "unbounded, actions", our_call(stars.galaxy(), stars.prolate(rows[:number]), want="actions"), number
    kerr, n = hjsolve.solve(hjsolve.catalog.load("kerr")), min(count, 20_000)
    how = {"parameters": {"a": "9/10"}, "want": "frequencies", "threads": 1, "fallback": False}
    for family, (q, p) in (("", about_kerr(rng, n)), (" next to the separatrix", about_kerr(rng, n, barely=True))):
        yield f"Kerr (a = 0.9){family}, frequencies", partial(hjsolve.ensemble, kerr, q, p, **how), n
    for name, potential in PROFILES.items():
        yield f"{name}, frequencies", _in_a_disc(potential), 200


PROFILES = {
    "Dehnen's cusp, c = 3/2": "G*M/a/(2 - c)*((R/(R + a))**(2 - c) - 1)",
    "Jaffe": "G*M/a*log(R/(R + a))",
    "an exponential of a root": "-G*M/R*(1 - exp(-(R/a)**(1/3)))",
    "three parts": "-G*M/(R + a) - G*M/20*log(1 + R/20)/R + G*M/9/a*log(R/(R + 2))",
}
"""In kpc, km/s and solar masses; about every fifth orbit runs away."""


def _in_a_disc(potential: str) -> Call:
    """200 stars in a plane, in a system that is new at every call: what it takes to know the potential counts."""
    rng, numbers = np.random.default_rng(77), {"G": "4.30091e-6", "M": "6e10", "a": "3", "c": "3/2"}
    R, outward, along = rng.uniform(2, 12, 200), rng.normal(0, 30, 200), rng.normal(190, 30, 200)
    call = iter(range(1, 1000))

    def ours() -> hjsolve.Batch:
        fresh = {**numbers, "a": f"3.{next(call)}"}
        known = {name: value for name, value in fresh.items() if name != "c" or "c)" in potential}
        system = hjsolve.System({"R": "0<R", "phi": "angle"}, "(dot(R)**2 + R**2*dot(phi)**2)/2", potential, known)
        velocity = {"R": outward, "phi": along / R}
        return hjsolve.ensemble(
            system, q={"R": R, "phi": 0.0}, velocity=velocity, want="frequencies", threads=1, fallback=False
        )

    return ours


def write(part: str, lines: list[str]) -> None:
    """Put the lines of a part into the page, in place of those that stand there, if they do."""
    page = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- benchmarks.ensembles {part} -->\n", f"<!-- end of {part} -->\n"
    if begin not in page:
        return
    before, rest = page.split(begin)
    _, after = rest.split(end)
    text = "\n".join(["", *lines, "", ""])
    PAGE.write_text(f"{before}{begin}{text}{end}{after}", encoding="utf-8")


def surroundings() -> str:
    """Return what the machine is doing: its load over the last minute, and its cores."""
    return f"load {os.getloadavg()[0]:.0f} on {os.cpu_count()} cores"


def main() -> None:
    """Run the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help="families, small, velocity, fresh, others; or all")
    parser.add_argument("--orbits", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/ensembles.md")
    given = parser.parse_args()
    count, repeats = given.orbits, given.repeats
    parts: dict[str, Callable[[], Iterator[str]]] = {
        "families": lambda: families(count, repeats),
        "small": lambda: small(count, repeats),
        "velocity": lambda: velocity(count, repeats),
        "fresh": fresh,
        "others": lambda: others(count, repeats),
    }
    for unknown in set(given.parts) - parts.keys():
        parser.error(f"{unknown}: known are {', '.join(parts)}")
    for part in given.parts or parts:
        before, lines = surroundings(), []
        for line in parts[part]():
            print(line, flush=True)
            lines.append(line)
        orbits = "" if part == "fresh" else f"{count} orbits (disc and halo {_DISC * count}), medians of {repeats}; "
        lines += ["", f"{orbits}{before} before, {surroundings()} after."]
        print(*lines[-2:], "", sep="\n", flush=True)
        if given.write:
            write(part, lines)


if __name__ == "__main__":
    main()
