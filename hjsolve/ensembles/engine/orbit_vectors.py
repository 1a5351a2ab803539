"""The text of a loop over many orbits that LLVM makes vectors of, however long its body is.

LLVM makes vectors where it can tell arrays apart, and compares no more than a few of them. So some orbits at a time are
copied into one cell of numbers, in which the distance between two rows is known when the text is written.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.pair_source import needed
from hjsolve.arithmetic.python_source import PythonSource
from hjsolve.ensembles.engine.compiled_types import VECTOR


def vector_text(name: str, given: int, source: PythonSource, results: Sequence[str]) -> str:
    """Return the text of ``name(given, made, cell)``: rows of n orbits in, rows out.

    Args:
        name: of the function.
        given: how many rows come in; the program knows them as g0, g1, …
        source: the program of one orbit.
        results: what is written to the rows of ``made``, variables or literals.
    """
    body = [
        *(f"g{k} = cell[{k * VECTOR} + j]" for k in range(given)),
        *needed(source.lines, results),
        *(f"cell[{(given + k) * VECTOR} + j] = {result}" for k, result in enumerate(results)),
    ]
    lines = [
        f"def {name}(given, made, cell):",
        f"    for first in range(0, given.shape[1], {VECTOR}):",
        f"        stop = min({VECTOR}, given.shape[1] - first)",
        *_copied(given, 0, "cell[{place}] = given[k, first + j]"),
        f"        for j in range({VECTOR}):",
        *(f"            {line}" for line in body),
        *_copied(len(results), given, "made[k, first + j] = cell[{place}]"),
    ]
    return "\n".join(lines) + "\n"


def _copied(rows: int, before: int, line: str) -> list[str]:
    place = f"(k + {before}) * {VECTOR} + j"
    return [
        f"        for k in range({rows}):",
        "            for j in range(stop):",
        "                " + line.format(place=place),
    ]


def run_in_vectors(function: Callable[[Reals, Reals, Reals], None], given: Reals, results: int) -> Reals:
    """Run such a function, compiled.

    Args:
        function: from ``vector_text``.
        given: what it takes, shape (given, n).
        results: how many rows it writes.

    Returns:
        An array of shape (results, n).
    """
    made = np.empty((results, given.shape[1]))
    function(np.ascontiguousarray(given), made, np.zeros((len(given) + results) * VECTOR))
    return made
