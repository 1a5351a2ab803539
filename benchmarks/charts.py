"""From x, y, z to x(t), y(t), z(t): motions in coordinates that were found, against Hamilton's equations in x, y, z.

    python -m benchmarks.charts --starts 50 --out charts.jsonl [--zeros] [--followed 4] [--seconds 3600] [--only NAME]
        [--random 100] [--print]

Every system of ``charted_systems``, random starts, or with ``--zeros`` starts on axes and planes and at rest; x and v
after 1, 10² and 10⁴ of the longest periods (10, 10³, 10⁵ units of time where there is none), each with the error
claimed. Truth is the same motion at 30 digits, and its own truth is heyoka's Taylor series of Hamilton's equations in
x, y, z, which share nothing with it: after one period in quadruple precision, after 10² in extended double precision
(where close encounters cost it its digits, in quadruple), and after 10⁴ for the first ``--followed`` starts in extended
double precision, but for close encounters. A state of 30 digits that is right after a period to 10⁻²⁵ holds frequencies
that are right after 10⁴ to 10⁻²⁰. Results go to a file, a line a motion, so that a run can be stopped and goes on.
Printed: one row a system, every motion that is not right, ends, is refused, is not a number or took more than 10 s, and
every coordinate plane through the middle of the starts that no motion crosses although V is finite there.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import signal
import time
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import heyoka as hy
import mpmath
import numpy as np
import sympy as sp

import hjsolve
from benchmarks.charted_starts import Start, anywhere, solved, value_of, with_zeros, without_wall
from benchmarks.charted_systems import PLANE, SPACE, centre_of, system_named
from benchmarks.quad_twin import _FUNCTIONS, Quad, quad

Row = Mapping[str, Any]
"""A finding, as it is read from the file."""
PERIODS = (1, 100, 10_000)
_DIGITS, _LIMIT, _SLOW = 30, 60, 10.0
_MOST_STEPS = {"quad": 20_000, "long": 2_000_000}
_LOOKS = 60
"""Further times at which it is looked which octants a motion visits, and whether a number is missing."""
_AGREE = {0: 1e-20, 1: 1e-11, 2: 1e-7}
"""How far the two truths may be apart after 1, 10² and 10⁴ periods, in units of the orbit."""


@dataclass
class Finding:
    """What one motion showed; lists run over PERIODS.

    Attributes:
        outcome: ok, or the error's name and words.
        status: of the states.
        over: the largest true error over its claim, of x and v.
        claim, error: the largest, in units of the orbit.
        apart: how far the two truths are apart in units of the orbit; None where they were not compared.
        visited: signs of x, y, z, as text, about the middle of the box of starts.
        missing: states with the status ok that hold no number or claim no finite error.
    """

    system: str
    start: int
    given: dict[str, dict[str, str]]
    outcome: str = "ok"
    kinds: str = ""
    status: list[str] = field(default_factory=list)
    over: list[float] = field(default_factory=list)
    claim: list[float] = field(default_factory=list)
    error: list[float] = field(default_factory=list)
    apart: list[float | None] = field(default_factory=list)
    visited: list[str] = field(default_factory=list)
    missing: int = 0
    seconds: float = 0.0


class _TooLongError(Exception):
    pass


def _extended(x: Any) -> Any:
    with mpmath.workdps(45):
        return np.longdouble(mpmath.nstr(mpmath.mpf(x), 30))


class Twin:
    """Hamilton's equations in x, y, z, in quadruple or extended double precision."""

    def __init__(self, system: hjsolve.System, precision: str):
        self.rounded, kind = {"quad": (quad, Quad), "long": (_extended, np.longdouble)}[precision]
        self.most = _MOST_STEPS[precision]
        places = [c.symbol for c in system.coordinates]
        known: dict[sp.Symbol, Any] = {s: hy.make_vars(f"x{k}") for k, s in enumerate(places)}
        speeds = [hy.make_vars(f"v{k}") for k in range(len(places))]
        equations = [(known[s], v) for s, v in zip(places, speeds, strict=True)]
        slopes = [self._built(-sp.diff(system.potential, s), known) for s in places]
        equations += list(zip(speeds, slopes, strict=True))
        begin = np.array([self.rounded("0.3")] * len(equations), dtype=kind)
        self.flow = hy.taylor_adaptive(equations, begin, fp_type=kind, compact_mode=True)

    def _built(self, expr: sp.Expr, known: Mapping[sp.Symbol, Any]) -> Any:
        if expr in known:
            return known[expr]
        if not expr.free_symbols:
            return hy.expression(self.rounded(sp.N(expr, 45)))
        parts = [self._built(a, known) for a in expr.args]
        if expr.is_Add:
            return hy.sum(parts)
        if expr.is_Mul:
            return hy.prod(parts)
        if expr.is_Pow:
            return hy.sqrt(parts[0]) if expr.exp == sp.Rational(1, 2) else parts[0] ** parts[1]
        return {**_FUNCTIONS, sp.acos: hy.acos, sp.acosh: hy.acosh}[expr.func](parts[0])

    def states(self, start: Sequence[str], times: Sequence[float]) -> Iterator[list[Any] | None]:
        """Places and velocities at rising times; None where the integration did not get there."""
        with mpmath.workdps(45):
            self.flow.state[:] = [self.rounded(value_of(x)) for x in start]
        self.flow.time = self.rounded(0)
        for t in times:
            outcome = self.flow.propagate_until(self.rounded(t), max_steps=self.most)[0]
            if outcome != hy.taylor_outcome.time_limit:
                return
            with mpmath.workdps(45):
                yield [mpmath.mpf(str(x)) for x in self.flow.state]


@cache
def twin(name: str, precision: str) -> Twin:
    """Return the integration of a system, compiled once."""
    return Twin(system_named(name), precision)


def judged(name: str, index: int, start: Start, *, followed: bool) -> Finding:
    """Compute a motion and compare it."""
    finding = Finding(name, index, start)
    try:
        solution, _ = solved(name)
    except Exception as error:  # noqa: BLE001  (a crash is what a table like this is for)
        finding.outcome = f"solve: {type(error).__name__}: {str(error)[:200]}"
        return finding
    for precision in ("quad", "long"):
        twin(name, precision)
    signal.signal(signal.SIGPROF, _give_up)
    signal.setitimer(signal.ITIMER_PROF, _LIMIT)
    begin = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            motion = solution.motion(**finding.given)
            unit = max((float(p.value) for p in motion.periods.values()), default=10.0)
            times = [unit * n for n in PERIODS]
            state = motion.at(times)
            claims = state.error
        finding.seconds = time.process_time() - begin
        finding.kinds = ", ".join(f"{q} {kind}" for q, kind in motion.kinds.items())
        _look_around(finding, motion, unit)
        better = solution.motion(**finding.given, digits=_DIGITS).at(times)
    except _TooLongError:
        finding.outcome, finding.seconds = "too long", time.process_time() - begin
        return finding
    except Exception as error:  # noqa: BLE001  (a crash is what a table like this is for)
        finding.outcome = f"{type(error).__name__}: {str(error)[:200]}"
        return finding
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    _compare(finding, state, claims, better)
    _compare_truths(finding, better, times, followed=followed)
    return finding


def _give_up(*_: Any) -> None:
    raise _TooLongError


def _look_around(finding: Finding, motion: hjsolve.Motion, unit: float) -> None:
    """Take down the octants visited, and states without numbers."""
    dice = random.Random(f"{finding.system} {finding.start} looks")
    state = motion.at([unit * dice.uniform(0, PERIODS[-1]) for _ in range(_LOOKS)])
    names = list(finding.given["q"])
    good = np.asarray([str(s) == "ok" for s in state.status])
    for group in (state.q, state.velocity, state.error.q, state.error.velocity):
        finding.missing += sum(int(np.sum(good & ~np.isfinite(np.asarray(group[c], dtype=float)))) for c in names)
    signs = zip(*(np.asarray(state.q[c], dtype=float)[good] > o
                  for c, o in zip(names, centre_of(finding.system), strict=False)), strict=True)  # fmt: skip
    finding.visited = sorted({"".join("-+"[int(s)] for s in place) for place in signs})


def _numbers(state: Any, names: Sequence[str], k: int) -> list[Any]:
    return [mpmath.mpf(group[c][k]) for group in (state.q, state.velocity) for c in names]


def _compare(finding: Finding, state: Any, claims: Any, better: Any) -> None:
    """Compare the state in doubles with the one of 30 digits."""
    names = list(finding.given["q"])
    with mpmath.workdps(45):
        for k in range(len(PERIODS)):
            pair = str(state.status[k]), str(better.status[k])
            finding.status.append(pair[0] if pair[0] == pair[1] else f"{pair[0]} but {pair[1]} at {_DIGITS} digits")
            if pair != ("ok", "ok"):
                continue
            mine, truth = _numbers(state, names, k), _numbers(better, names, k)
            bounds = [mpmath.mpf(g[c][k]) for g in (claims.q, claims.velocity) for c in names]
            off = [abs(a - b) for a, b in zip(mine, truth, strict=True)]
            size = max(abs(x) for x in truth)
            over = [float(e / b) if b else (math.inf if e else 0.0) for e, b in zip(off, bounds, strict=True)]
            finding.over.append(max(over) if all(x == x for x in over) else math.inf)
            finding.claim.append(float(max(bounds) / size))
            finding.error.append(float(max(off) / size))


def _compare_truths(finding: Finding, better: Any, times: Sequence[float], *, followed: bool) -> None:
    """Compare the state of 30 digits with Taylor series."""
    start = [*finding.given["q"].values(), *finding.given["velocity"].values()]
    names = list(finding.given["q"])
    near = twin(finding.system, "quad").states(start, times[:2])
    far = twin(finding.system, "long").states(start, times)
    next(far, None)
    finding.apart = [_apart(better, other, names, k) for k, other in enumerate((next(near, None), next(far, None)))]
    if not (finding.apart[1] or 0) <= _AGREE[1]:
        finding.apart[1] = _apart(better, next(near, None), names, 1)
    elif followed:
        finding.apart.append(_apart(better, next(far, None), names, 2))


def _apart(better: Any, other: Sequence[Any] | None, names: Sequence[str], k: int) -> float | None:
    if other is None or str(better.status[k]) != "ok":
        return None
    with mpmath.workdps(45):
        truth = _numbers(better, names, k)
        size = max(abs(x) for x in truth)
        return float(max(abs(a - b) for a, b in zip(truth, other, strict=True)) / size)


def fault_of(finding: Row) -> str:
    """Return what is not right about a motion; empty where all is."""
    if finding["outcome"] != "ok":
        return str(finding["outcome"])
    faults = [s for s in finding["status"] if s != "ok"]
    over = zip(PERIODS, finding["over"], strict=False)
    faults += [f"error/claim {x:.3g} after {n} periods" for n, x in over if not x <= 1]
    faults += [
        f"truths {x:.1e} apart after {PERIODS[k]} periods"
        for k, x in enumerate(finding["apart"])
        if x is not None and not x <= _AGREE[k]
    ]
    faults += [f"{finding['missing']} numbers missing"] if finding["missing"] else []
    faults += [f"{finding['seconds']:.0f} s"] if finding["seconds"] > _SLOW else []
    return "; ".join(faults)


def _row(name: str, found: Sequence[Row]) -> str:
    """Return a row of the table."""
    solution, spent = solved(name)
    web = solution.chart.kind if solution.chart else "as given"
    seconds = sorted(f["seconds"] for f in found)
    claims = [c for f in found for c in f["over"]]
    right = sum(x <= 1 for x in claims)
    by_time = [[f["claim"][k] for f in found if len(f["claim"]) > k] for k in range(len(PERIODS))]
    errors = [[f["error"][k] for f in found if len(f["error"]) > k] for k in range(len(PERIODS))]
    pairs = ", ".join(f"{max(c, default=math.nan):.0e}/{max(e, default=math.nan):.0e}"
                      for c, e in zip(by_time, errors, strict=True))  # fmt: skip
    octants = len({o for f in found for o in f["visited"]})
    compared = Counter(k for f in found for k, x in enumerate(f["apart"]) if x is not None)
    return (
        f"| {name} | {web} | {spent:.1f} | {seconds[len(seconds) // 2]:.2f}, {seconds[-1]:.1f} | {len(found)} | "
        f"{right} of {len(claims)} | {max(claims, default=math.nan):.2f} | {pairs} | {octants} | "
        f"{_planes(name, found)} | {'/'.join(str(compared[k]) for k in range(3))} |"
    )


def _crossed(name: str, found: Sequence[Row]) -> list[bool]:
    """For every coordinate, whether a motion is seen on both sides of the plane through the middle of the starts."""
    count = len(without_wall(name))
    return [any(len({place[k] for place in f["visited"]}) == 2 for f in found) for k in range(count)]


def _planes(name: str, found: Sequence[Row]) -> str:
    """Which of the planes without a wall are crossed."""
    pairs = zip("xyz", _crossed(name, found), without_wall(name), strict=False)
    told = [(c, crossed) for c, crossed, free in pairs if free]
    return f"{' '.join(c for c, crossed in told if crossed) or 'none'} of {' '.join(c for c, _ in told) or 'none'}"


def table(findings: Sequence[Row], names: Sequence[str]) -> None:
    """Print the rows, then what is not right."""
    columns = "system web solve,_s motion,_s starts states_right error/claim claim/error octants planes_crossed heyoka"
    print("| " + " | ".join(c.replace("_", " ") for c in columns.split()) + " |")
    print("|" + "---|" * 11)
    for name in names:
        if found := [f for f in findings if f["system"] == name and not f["outcome"].startswith("solve: ")]:
            print(_row(name, found), flush=True)
            for c, crossed, free in zip("xyz", _crossed(name, found), without_wall(name), strict=False):
                if free and not crossed:
                    print(f"{name}: no motion crosses the plane across {c}, where V is finite")
    for f in findings:
        if fault := fault_of(f):
            print(f"{f['system']} {f['start']}: {fault} ({f['kinds']})")


def main() -> None:
    """Run or resume, then print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--followed", type=int, default=4, help="starts a system that heyoka follows for 10⁴ periods")
    parser.add_argument("--out", type=Path, default=Path("charts.jsonl"), help="a line a motion; resumed if there")
    parser.add_argument("--zeros", action="store_true", help="starts with some of x, y, z and the velocities exactly 0")
    parser.add_argument("--random", type=int, default=0, help="so many random potentials in place of the systems named")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=math.inf, help="stop after this time")
    parser.add_argument("--only", help="systems whose name holds this")
    parser.add_argument("--print", action="store_true", help="print the table of what is there")
    given = parser.parse_args()
    known = [json.loads(line) for line in given.out.read_text().splitlines()] if given.out.exists() else []
    done, begin = {(f["system"], f["start"]) for f in known}, time.monotonic()
    rows = [f"random {k}" for k in range(given.random)] or [*PLANE, *SPACE]
    names = [n for n in rows if not given.only or given.only in n]
    todo = [(n, k) for k in range(given.starts) for n in names if (n, k) not in done]
    with given.out.open("a") as file:
        for name, k in todo if not given.print else []:
            if time.monotonic() - begin > given.seconds:
                break
            start = (with_zeros if given.zeros else anywhere)(name, k, given.seed)
            if start is None:
                continue
            known.append(asdict(judged(name, k, start, followed=k < given.followed)))
            file.write(json.dumps(known[-1], ensure_ascii=False) + "\n")
            file.flush()
    table([f for f in known if f["system"] in names], names)


if __name__ == "__main__":
    main()
