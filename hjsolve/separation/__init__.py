"""Separation: does a system separate in the coordinates it is written in? A verdict with its evidence.

In: a ``System``. Out: ``Separation``, ``Obstruction`` or ``Undecided``, each a frozen value that carries its proof.
Read ``decision.py`` first; ``forms`` holds the conditions, ``zero_test`` decides identities, ``obstruction`` explains a
no, ``constants`` names the constants of the motion.
"""

from hjsolve.separation.decision import DEFAULT_BUDGET, region_of, separate
from hjsolve.separation.verdicts import (
    Constant,
    Liouville,
    Obstruction,
    Reduced,
    Separation,
    Stackel,
    Undecided,
    Verdict,
)
from hjsolve.separation.zero_test.interval_evaluation import Region, Witness
from hjsolve.separation.zero_test.zero_test import NonZero, Unproved, Zero, is_zero

__all__ = [
    "DEFAULT_BUDGET", "Constant", "Liouville", "NonZero", "Obstruction", "Reduced", "Region", "Separation",
    "Stackel", "Undecided", "Unproved", "Verdict", "Witness", "Zero", "is_zero", "region_of", "separate",
]  # fmt: skip
