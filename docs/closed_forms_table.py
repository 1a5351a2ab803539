"""Print the table of docs/closed-forms.md: what of each separable entry of the catalog has a closed form, by regime.

    python docs/closed_forms_table.py [ENTRY …]

Processor seconds are those of finding, verifying and assembling all regimes of an entry.
"""

from __future__ import annotations

import sys
import time

import hjsolve
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.tidy import elliptic


def described(form: RegimeForms) -> str:
    """``elementary``, ``elliptic``, ``partly`` or ``none``: of time law, orbit equations, W and numbers of cycles."""
    wanted = [name for name in form.why_not if not name.startswith(("inverse", "energy"))]
    trivial = {name for name in form.named() if name.startswith("actions")}
    have = [name for name in form.named() if name not in trivial]
    if not have:
        return "none"
    if wanted:
        return "partly"
    return "elliptic" if any(elliptic(e) for e in form.named().values()) else "elementary"


def main(names: list[str]) -> None:
    """Print the table and the counts.

    Args:
        names: entries; all where there are none.
    """
    counts, seconds = dict[str, int](), list[float]()
    print("| Entry | Regime | Forms | Inverses | Without |\n|---|---|---|---|---|")
    for name in names or hjsolve.catalog.ids("separable"):
        solution, begin = hjsolve.solve(name), time.process_time()
        forms = hjsolve.closed_forms(solution)
        seconds.append(time.process_time() - begin)
        for form in forms:
            kind = described(form)
            counts[kind] = counts.get(kind, 0) + 1
            hidden = ("inverse", "energy", "periods", "frequencies")
            without = ", ".join(n for n in form.why_not if not n.startswith(hidden))
            inverses = ", ".join([*form.inverse, *(f"{n} along the orbit" for n in form.orbit)])
            print(f"| {name} | {form.regime.words} | {kind} | {inverses} | {without} |", flush=True)
    seconds.sort()
    print(f"\n{counts}; seconds: median {seconds[len(seconds) // 2]:.2f}, worst {seconds[-1]:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
