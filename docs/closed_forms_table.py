"""Print docs/closed-forms-table.md: what of each separable entry has a closed form, by regime, and the time.

    python docs/closed_forms_table.py [--seconds 20] [ENTRY …]

Seconds are those of the processor, for finding, verifying and assembling all regimes of an entry, and so is the limit.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence

import hjsolve
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.tidy import elliptic

KINDS = ("elementary", "elliptic", "partly", "none")
_BESIDE = ("inverse", "energy")
"""What may be missing of a regime whose integrals all have forms."""


def described(form: RegimeForms) -> str:
    """One of ``KINDS``, of time law, orbit equations, W and numbers of cycles.

    Args:
        form: of a regime.
    """
    wanted = [name for name in form.why_not if not name.startswith(_BESIDE)]
    have = [name for name in form.named() if not name.startswith(("actions", "turning_points", "orbit."))]
    if not have:
        return "none"
    if wanted:
        return "partly"
    return "elliptic" if any(elliptic(e) for e in form.named().values()) else "elementary"


def regime_row(name: str, form: RegimeForms) -> str:
    """A line of the table of regimes.

    Args:
        name: of the entry.
        form: of the regime.
    """
    kinds = ", ".join(f"{q}: {kind}" for q, kind in form.regime.kinds.items()) or "every motion"
    where = ", ".join(f"{c} = {e}" for c, e in form.regime.special.items())
    inverses = ", ".join(
        [
            *(f"{q}(t)" for q in form.inverse),
            *(f"{q} along the orbit" for q in form.orbit),
            *(f"{q}(τ)" for q in form.parametric),
        ]
    )
    return f"| {name} | {kinds}{'; ' + where if where else ''} | {described(form)} | {inverses} |"


def reasons(forms: Sequence[RegimeForms]) -> list[str]:
    """Why integrals of an entry have no forms, each reason once.

    Args:
        forms: of its regimes.
    """
    given = (r for form in forms for name, r in form.why_not.items() if not name.startswith(_BESIDE))
    return list(dict.fromkeys(given))


def main(arguments: Sequence[str]) -> None:
    """Print the tables and the counts.

    Args:
        arguments: of the command line.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("entries", nargs="*")
    options = parser.parse_args(arguments)
    entries, regimes, best = list[str](), list[str](), Counter[str]()
    missing, seconds, every = list[str](), list[float](), Counter[str]()
    for name in options.entries or hjsolve.catalog.ids("separable"):
        solution, begin = hjsolve.solve(name), time.process_time()
        forms = hjsolve.closed_forms(solution, seconds=options.seconds)
        seconds.append(time.process_time() - begin)
        counts = Counter(map(described, forms))
        every += counts
        best[next((kind for kind in reversed(KINDS) if counts[kind]), "none")] += 1
        entries.append(f"| {name} | {' | '.join(str(counts[kind] or '') for kind in KINDS)} | {seconds[-1]:.1f} |")
        regimes += [regime_row(name, form) for form in forms]
        missing += [f"- {name}: {reason}." for reason in reasons(forms)]
        print(name, dict(counts), f"{seconds[-1]:.1f} s", file=sys.stderr, flush=True)
    seconds.sort()
    print("# Closed forms of the catalog\n")
    print(f"Printed by `python docs/closed_forms_table.py --seconds {options.seconds:g}`. Of {len(seconds)} separable")
    print(f"entries {best['elementary']} have elementary forms in every regime found, {best['elliptic']} elliptic ones")
    print(f"(or both), {best['partly']} lack some integral in some regime, {best['none']} have a regime with none.")
    print(f"Seconds of the processor an entry: median {seconds[len(seconds) // 2]:.1f}, worst {seconds[-1]:.1f}.")
    print("\n## By entry: how many regimes have which forms\n")
    print("| Entry | elementary | elliptic | partly | none | seconds |\n|---|---|---|---|---|---|")
    print("\n".join(entries))
    print("\n## Why integrals have no form\n")
    print("\n".join(missing))
    print("\n## By regime\n")
    print("| Entry | Motion | Forms | Inverses |\n|---|---|---|---|")
    print("\n".join(regimes))


if __name__ == "__main__":
    main(sys.argv[1:])
