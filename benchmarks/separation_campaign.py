"""Random Stäckel systems and near misses: ``python benchmarks/separation_campaign.py [--cases 500] [--seconds N]``.

Half of the cases separate by construction; in the other half one term of size 1e-9 has been added. The univariate
functions are polynomials, trigonometric, exponential, radical, rational and logarithmic. No verdict may be wrong: the
process ends with status 1 when one is. It reports the fraction of ``Undecided``, median and worst processor time of
``separate`` by number of coordinates (the budget is wall time), and the seeds of what was wrong or undecided.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from hjsolve.errors import InvalidInputError
from hjsolve.separation import Obstruction, Separation, separate
from tests.support.random_staeckel import Case, case

FRACTIONS = {2: 0.56, 3: 0.38, 4: 0.06}


def cases(count: int) -> Iterator[tuple[int, Case]]:
    """As many separable cases as near misses, in turn; n = 2, 3 and 4 mixed throughout, so that a part is a sample."""
    wanted = {n: round(fraction * count) for n, fraction in FRACTIONS.items()}
    sources = {n: _alternating(n) for n in FRACTIONS}
    for k in range(max(wanted.values())):
        for n, number in wanted.items():
            if k * number // max(wanted.values()) < (k + 1) * number // max(wanted.values()):
                for _ in range(2):
                    yield n, next(sources[n])


def _alternating(n: int) -> Iterator[Case]:
    """Yield a separable case and a near miss from the same seed, wherever the random metric is regular."""
    seed = 100_000 * n
    while True:
        seed += 1
        try:
            pair = [case(seed, n, separable=separable) for separable in (True, False)]
        except InvalidInputError:
            continue
        yield from (known for known in pair if known is not None)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=500, help="of each kind (default 500)")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after this time")
    parser.add_argument("--budget", type=float, default=20.0, help="of one decision, in seconds")
    given = parser.parse_args()
    start, times, verdicts = time.monotonic(), dict[tuple[int, bool], list[float]](), Counter[tuple[int, bool, str]]()
    wrong, undecided = [], []
    for n, known in cases(given.cases):
        if time.monotonic() - start > given.seconds:
            break
        begin = time.process_time()
        verdict = separate(known.system, budget=given.budget)
        times.setdefault((n, known.separable), []).append(time.process_time() - begin)
        verdicts[n, known.separable, type(verdict).__name__] += 1
        right = Separation if known.separable else Obstruction
        if isinstance(verdict, Obstruction if known.separable else Separation):
            wrong.append((n, known.seed, known.separable))
        elif not isinstance(verdict, right):
            undecided.append((n, known.seed, known.separable))
    for (n, separable), found in sorted(times.items()):
        kind = "separable" if separable else "near miss"
        here = {name: c for (m, s, name), c in verdicts.items() if (m, s) == (n, separable)}
        figures = f"median {median(found):7.3f} s  worst {max(found):7.2f} s"
        print(f"n = {n} {kind:10s} {len(found):4d} cases  {figures}  {here}")
    total = sum(verdicts.values())
    print(
        f"{total} cases, {len(wrong)} wrong, {len(undecided)} undecided ({100 * len(undecided) / max(total, 1):.2f} %)"
    )
    print(f"wrong: {wrong}\nundecided: {undecided}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
