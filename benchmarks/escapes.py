"""Random open motions with narrow features: is every claimed error at least the true one, and how many are right?

    python benchmarks/escapes.py --count 200 --digits 15 --out escapes.jsonl

Potentials and references are those of ``tests/support/random_escapes.py``: times of passage t(q) by mpmath's quadrature
cut at the features, at twice the digits; and q(t), whose reference is t(q) of the place found, the difference times the
velocity. One line a motion; status 1 when a claim is below the true error, or something else than an error of
hjsolve's own was raised.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from mpmath import mp

import hjsolve
from tests.support.random_escapes import Escape, draw


def compared(escape: Escape, digits: int) -> list[tuple[str, float, float, float]]:
    """Return (what, true error, claim, size) of times and places of one motion."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", escape.potential)
    motion = hjsolve.solve(system).motion(q={"x": escape.start}, velocity={"x": escape.velocity}, digits=digits)
    rows = []
    for goal in escape.goals:
        found = motion.time_at("x", goal)
        with mp.workdps(2 * digits):
            truth = escape.time(mp.mpf(goal))
            rows.append((f"t({goal})", float(abs(mp.mpf(found.value) - truth)), float(found.error), float(truth)))
        t = float(found.value) * 0.9
        state = motion.at(t)
        with mp.workdps(2 * digits):
            q = mp.mpf(state.q["x"])
            miss = abs(escape.time(q) - mp.mpf(t)) * abs(mp.mpf(state.velocity["x"]))
            rows.append((f"x({t})", float(miss), float(state.error.q["x"]), float(max(1, abs(q)))))
    return rows


def one(seed: int, digits: int) -> dict[str, Any]:
    """Return what one motion showed."""
    escape = draw(random.Random(seed))
    result: dict[str, Any] = {"seed": seed, "potential": escape.potential, "start": escape.start, "v": escape.velocity}
    begin = time.process_time()
    try:
        system = hjsolve.System({"x": "line"}, "dot(x)**2/2", escape.potential)
        motion = hjsolve.solve(system).motion(q={"x": escape.start}, velocity={"x": escape.velocity}, digits=digits)
        motion.time_at("x", escape.goals[-1])
        result["seconds"] = time.process_time() - begin
        rows = compared(escape, digits)
    except hjsolve.HJSolveError as error:
        result |= {"status": "refused", "seconds": time.process_time() - begin, "message": str(error)[:200]}
        return result
    except (ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
        result |= {"status": "crash", "seconds": time.process_time() - begin, "message": repr(error)[:200]}
        return result
    false = [row for row in rows if row[1] > row[2]]
    right = all(error <= 1e-12 * 10.0 ** (15 - digits) * size for _, error, _, size in rows)
    result |= {"status": "false" if false else "right" if right else "unresolved", "rows": rows}
    return result


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--digits", type=int, default=15)
    parser.add_argument("--out", type=Path, default=Path("escapes.jsonl"))
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    slowest = 0.0
    with options.out.open("a") as out:
        for seed in range(options.first, options.first + options.count):
            found = one(seed, options.digits)
            counts[found["status"]] += 1
            slowest = max(slowest, found["seconds"])
            out.write(json.dumps(found) + "\n")
            out.flush()
            if found["status"] != "right":
                print(json.dumps(found), flush=True)
    print(dict(counts), f"slowest {slowest:.1f} s")
    return int(bool(counts["false"] or counts["crash"]))


if __name__ == "__main__":
    sys.exit(main())
