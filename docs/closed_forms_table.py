"""Print docs/closed-forms-table.md: of each separable entry the forms of its own motion, or the reason, and operations.

    python docs/closed_forms_table.py [--seconds 20] [ENTRY …] > docs/closed-forms-table.md

Seconds are those of the processor for the regime of the entry's own motion, verified. Operations of a form are counted
by sympy; those of its definitions (``form.where``) are counted once each, and apart.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median

import sympy as sp

import hjsolve
from hjsolve.closed_form.closed_forms import own_form
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.tidy import elliptic

_BESIDE = ("inverse", "energy")
"""What may be missing of a regime whose integrals all have forms."""
LONGEST = 10


@dataclass(frozen=True)
class Row:
    """An entry.

    Attributes:
        name: of the entry.
        form: of its own motion; None of one at rest.
        seconds: of the processor.
    """

    name: str
    form: RegimeForms | None
    seconds: float

    @property
    def operations(self) -> dict[str, int]:
        """Of every form."""
        return {} if self.form is None else {n: int(sp.count_ops(e)) for n, e in self.form.named().items()}

    @property
    def definitions(self) -> dict[str, int]:
        """Of every definition that is not a root of a polynomial."""
        where = {} if self.form is None else self.form.where
        return {s.name: int(sp.count_ops(e)) for s, e in where.items() if not isinstance(e, tuple)}


def row_of(name: str, seconds: float) -> Row:
    """Derive the forms of an entry's own motion.

    Args:
        name: of the entry.
        seconds: of the processor that it may take.
    """
    motion = hjsolve.solve(name).motion(**next(iter(hjsolve.catalog.describe(name).motions.values())).arguments)
    begin = time.process_time()
    form = own_form(motion, seconds=seconds)
    return Row(name, form, time.process_time() - begin)


def described(form: RegimeForms | None) -> str:
    """Return what kind of forms there are of time law, orbit equations, W and numbers of cycles.

    Args:
        form: of a regime.
    """
    if form is None:
        return "at rest"
    wanted = [name for name in form.why_not if not name.startswith(_BESIDE)]
    have = [name for name in form.named() if not name.startswith(("actions", "turning_points", "orbit."))]
    if not have:
        return "none"
    if wanted:
        return "partly"
    return "elliptic" if any(elliptic(e) for e in form.named().values()) else "elementary"


def _line(row: Row) -> str:
    form = row.form
    if form is None:
        return f"| {row.name} | at rest |  |  |  | {row.seconds:.1f} |"
    motion = [f"{q}(t)" for q in form.inverse]
    motion += [f"{q} by parameter" for q in form.anomaly] + [f"{q}(τ)" for q in form.parametric]
    motion += [f"{q} along the orbit" for q in form.orbit]
    ops = list(row.operations.values())
    counts = f"{median(ops):g} / {max(ops)}" if ops else ""
    energy = "E(J)" if form.energy is not None else ""
    told = f"| {row.name} | {described(form)} | {', '.join(motion)} | {energy} | {counts} |"
    return f"{told} {row.seconds:.1f} |"


def _reasons(rows: Iterable[Row]) -> list[str]:
    """Each reason once for each entry, with whether it is proved."""
    found = list[str]()
    for row in rows:
        groups = dict[str, list[str]]()
        for name, reason in ({} if row.form is None else row.form.why_not).items():
            mark = "proved" if reason.proved else "not found"
            groups.setdefault(f"{mark}: {reason}", []).append(f"`{name}`")
        found += [f"- {row.name}, {', '.join(names)}: {text}." for text, names in groups.items()]
    return found


def main(arguments: Sequence[str]) -> None:
    """Print the table.

    Args:
        arguments: of the command line.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("entries", nargs="*")
    options = parser.parse_args(arguments)
    rows = list[Row]()
    for name in options.entries or hjsolve.catalog.ids("separable"):
        rows.append(row_of(name, options.seconds))
        print(name, f"{rows[-1].seconds:.1f} s", file=sys.stderr, flush=True)
    forms = sorted(((n, row.name, key) for row in rows for key, n in row.operations.items()), reverse=True)
    named = [n for row in rows for n in row.definitions.values()]
    times = sorted(row.seconds for row in rows)
    print("# Closed forms of the catalog\n")
    print("Printed by `python docs/closed_forms_table.py`. Each entry is at its own motion. Of "
          f"{len(rows)} entries {sum(described(r.form) == 'elementary' for r in rows)} have elementary forms, "
          f"{sum(described(r.form) == 'elliptic' for r in rows)} elliptic ones,\n"
          f"{sum(described(r.form) in ('partly', 'none') for r in rows)} lack an integral.")  # fmt: skip
    print(f"{len(forms)} forms have a median of {median(n for n, *_ in forms):g} operations; "
          f"{len(named)} definitions have a median of {median(named):g} more.")  # fmt: skip
    print(f"Seconds of the processor an entry: median {median(times):.1f}, worst {times[-1]:.1f}.\n")
    print("| Entry | Forms | Motion | Energy | operations: median / most | seconds |\n|---|---|---|---|---|---|")
    print("\n".join(map(_line, rows)))
    print("\n## The longest forms\n\n| Entry | Form | operations |\n|---|---|---|")
    print("\n".join(f"| {entry} | `{key}` | {n} |" for n, entry, key in forms[:LONGEST]))
    print("\n## Why quantities have no form\n")
    print("\n".join(_reasons(rows)))


if __name__ == "__main__":
    main(sys.argv[1:])
