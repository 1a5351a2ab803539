"""What a period in closed form costs in doubles, in units of one sine of the same array.

    python -m benchmarks.closed_form_doubles

Of the first kind, with roots in radicals or of a cubic. Both are measured in turn in processor time, the least of five
each; the ratio changes little on a busy machine.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import hjsolve

ENTRIES = ("pendulum", "double-well", "spherical-pendulum")
_ORBITS = 20_000
_SINES = 100


def spent(call: Callable[[], Any]) -> float:
    """Processor seconds of a call."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def sines(energies: np.ndarray) -> None:
    for _ in range(_SINES):
        np.sin(energies)


def main() -> None:
    """Print one line for each entry."""
    for name in ENTRIES:
        form = hjsolve.closed_forms(name)[0]
        function = form.lambdify("numpy")[f"periods.{next(iter(form.periods))}"]
        example = {s.name: float(v) for s, v in form.regime.example.items()}
        given = {n: np.full(_ORBITS, example[n]) for n in function.names}
        pairs = [(spent(lambda: function(**given)), spent(lambda: sines(given["E"]))) for _ in range(5)]
        ours, theirs = (min(times) for times in zip(*pairs, strict=True))
        print(f"{name}: a period costs {_SINES * ours / theirs:.0f} sines")


if __name__ == "__main__":
    main()
