"""What generated programs of this room call on numbers in two doubles, until they run on the machine."""

from __future__ import annotations

from typing import Any

from hjsolve.arithmetic.machine import pairs

PAIRS: dict[str, Any] = {name: rule for name, rule in vars(pairs).items() if name.startswith("pair_")}
