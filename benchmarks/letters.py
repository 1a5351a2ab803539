"""What letters cost the search for coordinates: 40 formulas with letters, and with the letters' values in their place.

    python -m benchmarks.letters [NAME ...] [--budget SECONDS]

One line for each: processor seconds of ``solve(…, coordinates="find")`` with numbers and with letters, their ratio, and
the kind of the chart. A chart that is another one is marked. With ``--budget`` the search with letters gets so many
seconds, and the column says by how much the wall clock exceeded them. Read it on a quiet machine.
"""

from __future__ import annotations

import argparse
import time

from hjsolve import NotSeparableError, System, solve
from tests.support.lettered_systems import ALL, Lettered


def answer(system: System, budget: float = 20.0) -> tuple[str, float, float]:
    """Return the kind of the chart or "none", processor seconds and seconds on the wall."""
    wall, cpu = time.monotonic(), time.process_time()
    try:
        chart = solve(system, coordinates="find", budget=budget).chart
        kind = "as given" if chart is None else chart.kind
    except NotSeparableError as refusal:
        kind = "undecided" if "not decided" in str(refusal) or "in the time allowed" in str(refusal) else "none"
    return kind, time.process_time() - cpu, time.monotonic() - wall


def costs(one: Lettered) -> tuple[str, str, float, float]:
    """Return the kinds with numbers and with letters, and the processor seconds of both."""
    kind, seconds, _ = answer(one.with_numbers())
    other, more, _ = answer(one.with_letters())
    return kind, other, seconds, more


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--budget", type=float)
    options = parser.parse_args()
    answer(System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "x**2/2 + x*y**3"))
    chosen = [one for one in ALL if not options.names or any(name in one.label for name in options.names)]
    if options.budget is not None:
        over = [(answer(one.with_letters(), options.budget)[2] - options.budget, one.label) for one in chosen]
        for seconds, label in sorted(over, reverse=True):
            print(f"{label:34} {seconds:+7.2f} s")
        return int(max(over)[0] > 1.0)
    totals, other = [0.0, 0.0], 0
    for one in chosen:
        kind, lettered, seconds, more = costs(one)
        differs = kind != lettered and not one.special
        other += differs
        totals = [totals[0] + seconds, totals[1] + more]
        mark = f"  DIFFERS: {lettered}" if differs else "  (with letters: none, said at which values)" * one.special
        print(f"{one.label:34} {seconds:7.2f} {more:7.2f} {more / seconds:6.2f}  {kind}{mark}")
    print(f"{'all':34} {totals[0]:7.2f} {totals[1]:7.2f} {totals[1] / totals[0]:6.2f}")
    return int(other > 0)


if __name__ == "__main__":
    raise SystemExit(main())
