"""Random narrow features: what motions and ensembles claim against references that are cut at the features.

    python benchmarks/features.py --count 100 --seed 5 --ways 15,30,many --out features.jsonl

Each line of the file is one draw of ``tests/support/random_features.py`` computed in one way: a single motion in so
many digits, or an ensemble, in which orbits that the vectorised engine hands back are
computed one by one (``recomputed`` in the file). A run that was stopped goes on where it stopped. At the end, and with
``--report FILE`` alone, the counts are printed: right (1e-12 and inside the claim) · loose (inside the claim, off by
more) · false (outside the claim) · refused · foreign.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import signal
import sys
import time
from collections import Counter
from typing import Any

from mpmath import mp, mpf

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

import hjsolve
from tests.support.random_features import Draw, Truth, draw, truth

_GOOD = 1e-12
_REFERENCE = 1e-18
"""Relative error left to the reference."""


class TooLongError(Exception):
    """The motion took longer than it may."""


def _compared(one: Draw, exact: Truth, way: str) -> dict[str, Any]:
    """One motion against its reference."""
    solution = hjsolve.solve(hjsolve.System(dict(one.coordinates), one.kinetic, one.potential))
    begin = time.process_time()
    numbers, more = _single(solution, one, int(way)) if way.isdigit() else _ensemble(solution, one)
    seconds = time.process_time() - begin
    pairs = list(zip(numbers, (exact.action, exact.frequency, exact.lower, exact.upper), strict=True))
    worst, false = 0.0, 0
    with mp.workdps(45):
        for found, value in pairs:
            if value is None:  # a rotation has no turning points
                continue
            error = min(abs(mpf(found.value) - value), abs(mpf(found.value) + value))
            false += bool(error > mpf(found.error) + abs(value) * _REFERENCE)
            worst = max(worst, float(error / abs(value)))
    kind = "false" if false else "right" if worst <= _GOOD else "loose"
    return {"kind": kind, "worst": worst, "seconds": seconds, **more}


def _single(solution: hjsolve.Solution, one: Draw, digits: int) -> tuple[list[Any], dict[str, Any]]:
    motion = solution.motion(q=one.exact("q"), p=one.exact("p"), digits=digits)
    ends = motion.turning_points.get(one.name, (None, None))
    return [motion.actions[one.name], motion.frequencies[one.name], *ends], {"nodes": motion.nodes}


def _ensemble(solution: hjsolve.Solution, one: Draw) -> tuple[list[Any], dict[str, Any]]:
    want = ("actions", "frequencies", "turning_points")
    batch = hjsolve.ensemble(solution, one.q, one.p, want=want, threads=1)
    if batch.status.item() != "ok":
        raise hjsolve.NotConvergedError(batch.status.item())
    columns = [(batch.actions, "actions"), (batch.frequencies, "frequencies")]
    numbers = [hjsolve.Estimate(group[one.name].item(), batch.error[name][one.name].item()) for group, name in columns]
    ends = zip(batch.turning_points[one.name], batch.error["turning_points"][one.name], strict=True)
    numbers += [hjsolve.Estimate(x.item(), e.item()) for x, e in ends]
    return numbers, {"recomputed": bool(batch.recomputed.item())}


def _judged(one: Draw, exact: Truth, way: str, limit: int) -> dict[str, Any]:
    def stop(*_: Any) -> None:
        raise TooLongError

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, limit)
    begin = time.process_time()
    try:
        return _compared(one, exact, way)
    except hjsolve.HJSolveError as error:
        return {"kind": "refused", "why": str(error)[:120], "seconds": time.process_time() - begin}
    except TooLongError:
        return {"kind": "too long", "seconds": time.process_time() - begin}
    except (ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
        return {"kind": "foreign", "why": repr(error)[:120], "seconds": time.process_time() - begin}
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def report(path: pathlib.Path) -> None:
    """Print the counts of a file, a line for each number of digits."""
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    for way in sorted({line["way"] for line in lines}):
        mine = [line for line in lines if line["way"] == way]
        seconds = sorted(line["seconds"] for line in mine)
        counts = ", ".join(f"{kind} {n}" for kind, n in Counter(line["kind"] for line in mine).most_common())
        again = sum(line.get("recomputed", False) for line in mine)
        print(f"{way}: {len(mine)} motions: {counts}; {again} recomputed; median {seconds[len(seconds) // 2]:.2f} s, "
              f"longest {seconds[-1]:.1f} s, over 10 s: {sum(s > 10 for s in seconds)}")  # fmt: skip


def main() -> None:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--ways", default="15,30,many", help="numbers of digits, or many for an ensemble")
    parser.add_argument("--limit", type=int, default=60, help="seconds of processor time a motion may take")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("features.jsonl"))
    parser.add_argument("--report", type=pathlib.Path, help="only print the counts of this file")
    options = parser.parse_args()
    if options.report is None:
        known = options.out.read_text(encoding="utf-8").splitlines() if options.out.exists() else []
        done = {(line["seed"], line["index"], line["way"]) for line in map(json.loads, known)}
        with options.out.open("a", encoding="utf-8") as out:
            for index in range(options.first, options.first + options.count):
                _one_draw(options, index, done, out)
    report(options.report or options.out)


def _one_draw(options: argparse.Namespace, index: int, done: set[tuple[int, int, str]], out: Any) -> None:
    wanted = [way for way in options.ways.split(",") if (options.seed, index, way) not in done]
    if not wanted:
        return
    one = draw(options.seed, index)
    try:
        exact = truth(one)
    except ArithmeticError:
        return
    for way in wanted:
        found = {"seed": options.seed, "index": index, "way": way, "base": one.base, "potential": one.potential}
        out.write(json.dumps({**found, **_judged(one, exact, way, options.limit)}) + "\n")
        out.flush()


if __name__ == "__main__":
    main()
