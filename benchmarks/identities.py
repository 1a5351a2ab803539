"""Random identities that depend on the domain, and false neighbours: ``python benchmarks/identities.py [--count 600]``.

Half angles, logarithms of powers, roots of squares, sums of inverse functions, constants: true ones and false ones
in equal parts (``tests/support/random_identities.py``, with ``--typed`` ``tests/support/typed_identities.py``). Prints
the share decided by family; status 1 when one is wrong.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from hjsolve.separation.zero_test.interval_evaluation import Region
from hjsolve.separation.zero_test.zero_test import NonZero, Zero, is_zero
from tests.support.random_identities import FAMILIES, identities
from tests.support.typed_identities import TYPED


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--budget", type=float, default=5.0, help="of one decision, in seconds")
    parser.add_argument("--typed", action="store_true", help="the second set of templates")
    parser.add_argument("--show", action="store_true", help="print every identity that stays undecided")
    given = parser.parse_args()
    counts, times, wrong = Counter[tuple[str, bool, str]](), list[float](), 0
    for known in identities(given.seed, given.count, TYPED if given.typed else FAMILIES):
        start = time.process_time()
        answer = is_zero(known.expression, Region(known.bounds), budget=given.budget)
        times.append(time.process_time() - start)
        word = "zero" if isinstance(answer, Zero) else "not zero" if isinstance(answer, NonZero) else "undecided"
        counts[known.family, known.true, word] += 1
        if word == ("not zero" if known.true else "zero"):
            wrong += 1
            print("WRONG", known)
        elif word == "undecided" and given.show:
            print("undecided", known.true, known.expression, {str(s): b for s, b in known.bounds.items()})
    print(f"{'family':20} {'truth':6} decided undecided")
    for family, true in sorted({(f, t) for f, t, _ in counts}):
        decided = sum(counts[family, true, w] for w in ("zero", "not zero"))
        print(f"{family:20} {true!s:6} {decided:7} {counts[family, true, 'undecided']:9}")
    print(f"wrong: {wrong}; median {median(times):.3f} s, worst {max(times):.1f} s of processor time")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
