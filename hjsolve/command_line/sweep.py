"""``hjsolve sweep``: arguments to a sweep, and one line about what it wrote."""

from __future__ import annotations

import sys
from argparse import Namespace

from hjsolve.display.first_lines import few_lines
from hjsolve.sweeps.conduct import sweep

_DONE, _INTERRUPTED = 0, 130


def run_sweep(options: Namespace) -> int:
    """Sweep, and say what came of it."""
    out = options.output
    try:
        done = sweep(
            options.scene, out, threads=options.threads, scheduler=options.scheduler, chunk=options.chunk,
            shown=False if options.quiet else None, verify=options.verify,
        )  # fmt: skip
    except KeyboardInterrupt:
        print(f"hjsolve: interrupted; what is in {out} stays; rerun the same command to resume", file=sys.stderr)
        return _INTERRUPTED
    if done.notes:
        print(f"hjsolve: {few_lines(done.notes)}", file=sys.stderr)
    counts = ", ".join(f"{number} {word}" for word, number in done.statuses.items())
    before = f", {done.kept} of them by an earlier run" if done.kept and not options.verify else ""
    verb = "verified" if options.verify else "wrote"
    print(f"{verb} {done.path}: {done.orbits} orbits in {done.parts} files{before}; {counts}")
    return _DONE
