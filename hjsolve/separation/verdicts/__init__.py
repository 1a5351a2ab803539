"""The three verdicts and what they carry; every one is a frozen value with its evidence.

In: what the rooms next to this one find. Out: ``Separation``, ``Obstruction`` or ``Undecided``. Read ``separated.py``
first.
"""

from __future__ import annotations

from hjsolve.separation.verdicts.refused import Obstruction, Undecided
from hjsolve.separation.verdicts.separated import Constant, Liouville, Reduced, Separation, Stackel

Verdict = Separation | Obstruction | Undecided

__all__ = ["Constant", "Liouville", "Obstruction", "Reduced", "Separation", "Stackel", "Undecided", "Verdict"]
