"""Every entry of the catalog that separates: which closed forms its first regime has, and why it has no others.

    python -m benchmarks.closed_form_table [--seconds 30] [ENTRY …]

One row an entry: how many forms, the median and the largest number of operations as they are shown, and for each
quantity without a form whether that is proved or a form was only not found. Then the counts, and the ten longest forms.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Sequence

import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import closed_forms
from hjsolve.closed_form.why_not import NotFound, OfCoordinate, WhyNot


def is_proved(reason: WhyNot) -> bool:
    """Whether a reason is data that proves itself.

    Args:
        reason: of a quantity without a form.
    """
    if isinstance(reason, OfCoordinate):
        return is_proved(reason.reason)
    return not isinstance(reason, NotFound) and reason.holds()


def main(arguments: Sequence[str]) -> None:
    """Print the table.

    Args:
        arguments: of the command line.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("entries", nargs="*")
    options = parser.parse_args(arguments)
    lengths, reasons = list[tuple[int, str]](), {"proved": 0, "not found": 0}
    for entry in options.entries or hjsolve.catalog.ids("separable"):
        forms = closed_forms(entry, seconds=options.seconds)
        if not forms:
            print(f"{entry:32s} no regime: every motion found is at rest")
            continue
        form = forms[0]
        own = [(int(sp.count_ops(value)), f"{entry} {name}") for name, value in form.named().items()]
        lengths += own
        missing = list[str]()
        for name, reason in form.why_not.items():
            word = "proved" if is_proved(reason) else "not found"
            reasons[word] += 1
            missing.append(name if word == "proved" else f"{name}? ({reason})")
        sizes = [n for n, _ in own] or [0]
        print(
            f"{entry:32s} {len(own):2d} forms, operations {statistics.median(sizes):5.0f} {max(sizes):5d}"
            f"   without: {', '.join(missing) or 'none'}",
            flush=True,
        )
    lengths.sort(reverse=True)
    print(
        f"{len(lengths)} forms, median {statistics.median(n for n, _ in lengths):.0f} operations; without a form: ",
        end="",
    )
    print(f"{reasons['proved']} proved, {reasons['not found']} not found (names with ?)")
    for n, name in lengths[:10]:
        print(f"    {n:5d} {name}")


if __name__ == "__main__":
    main(sys.argv[1:])
