"""What half an ulp of the input does: the floor under any computation that starts from floats.

A motion takes a float for the exact binary number it is, and its errors are those of the computation. If the float
itself is only the rounding of what was meant, every result is in doubt by Σ |∂Q/∂xⱼ| · ½ ulp(xⱼ) besides; near a
separatrix or a circular orbit that can be far more than the computation's own error. Here it is measured: each float
input is moved by half an ulp and the numbers are worked out again, with digits enough to see the difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

_DIGITS = 40  # changes by half an ulp, 10⁻¹⁶ of a number, leave 24 of them
_GROUPS = ("q", "velocity", "p", "constants", "parameters")
QUANTITIES = ("constants", "actions", "frequencies", "periods")


def input_sensitivities(
    again: Callable[[int, Mapping[str, object]], Any], given: Mapping[str, object]
) -> dict[str, dict[str, float]]:
    """Return how far each number can move when every float input moves by half a unit in its last place.

    Args:
        again: the rule that starts the motion anew: digits, changed groups of the input ↦ Motion.
        given: the groups of the input as they came.

    Returns:
        Quantity (``constants``, ``actions``, ``frequencies``, ``periods``) → name → absolute doubt; all zero for input
        given exactly (ints, decimal strings, fractions). A number that ceases to exist when an input moves (a frequency
        at a separatrix) is in infinite doubt.
    """
    base = again(_DIGITS, {})
    uncertainty = {quantity: dict.fromkeys(getattr(base, quantity), 0.0) for quantity in QUANTITIES}
    for change in _changes(given):
        moved = again(_DIGITS, change)
        for quantity, names in uncertainty.items():
            for name in names:
                there = getattr(moved, quantity).get(name)
                here = getattr(base, quantity)[name]
                names[name] += float(abs(there.value - here.value)) if there is not None else math.inf
    return uncertainty


def _changes(given: Mapping[str, Any]) -> list[dict[str, Any]]:
    """One changed input group for every float among the inputs."""
    return [
        {group: {**given[group], name: Fraction(value) + Fraction(math.ulp(value)) / 2}}
        for group in _GROUPS
        for name, value in (given.get(group) or {}).items()
        if isinstance(value, float)
    ]
