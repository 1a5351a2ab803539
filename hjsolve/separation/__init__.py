"""Does it separate? ``separate`` gives a ``Separation``, an ``Obstruction`` or an ``Undecided``, with the evidence."""

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
