"""Relations with whole numbers between the frequencies of a motion: Ω_r = Ω_φ, Ω_x = 2 Ω_y, Ω_x + Ω_y = 3 Ω_z."""

from __future__ import annotations

from itertools import combinations, product
from math import gcd

import sympy as sp

from hjsolve.motion.motion import Motion

_MOST_OF_A_FACTOR = {2: 12, 3: 6}
"""Largest whole number that is looked for, in relations of two and of three frequencies."""

_SURELY = 1e-9
"""Errors over the sizes of the terms with which none of the thousands of relations looked for holds by chance."""

Whole = tuple[int, ...]


def frequency_relations(motion: Motion) -> tuple[str, ...]:
    """Find independent relations k·Ω = 0 that hold within the errors of the frequencies, the simplest first.

    That they hold to the digits known proves nothing of other motions; that there are some does the number of integrals
    (``coordinates/superintegrable.py``).

    Returns:
        Each in words; none where the frequencies are too uncertain to tell.
    """
    names, estimates = list(motion.frequencies), list(motion.frequencies.values())
    values, errors = [Ω.value for Ω in estimates], [float(Ω.error) for Ω in estimates]
    found: list[Whole] = []
    for k in _whole_numbers(len(names)):
        error = sum(abs(n) * e for n, e in zip(k, errors, strict=True))
        size = sum(abs(n * float(Ω)) for n, Ω in zip(k, values, strict=True))
        off = abs(sum(n * Ω for n, Ω in zip(k, values, strict=True)))
        if off <= error <= _SURELY * size and sp.Matrix([*found, k]).rank() > len(found):
            found.append(k)
    return tuple(_in_words(k, names) for k in found)


def _whole_numbers(count: int) -> list[Whole]:
    """Rows with two or three that are not 0, the first of these positive, no common divisor; the simplest first."""
    found = []
    for terms, most in _MOST_OF_A_FACTOR.items():
        numbers = [n for n in range(-most, most + 1) if n]
        for k in product(numbers, repeat=terms):
            if k[0] > 0 and gcd(*k) == 1:
                for places in combinations(range(count), terms):
                    row = dict(zip(places, k, strict=True))
                    found.append(tuple(row.get(place, 0) for place in range(count)))
    return sorted(found, key=lambda k: (sum(n != 0 for n in k), sum(map(abs, k)), [-n for n in k]))


def _in_words(k: Whole, names: list[str]) -> str:
    terms = [(n, f"Ω_{name}" if abs(n) == 1 else f"{abs(n)} Ω_{name}") for n, name in zip(k, names, strict=True) if n]
    left, right = [text for n, text in terms if n > 0], [text for n, text in terms if n < 0]
    return f"{' + '.join(left)} = {' + '.join(right)}" if right else f"{' + '.join(left[:-1])} = −{left[-1]}"
