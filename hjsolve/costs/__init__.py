"""Costs: accuracy against time, every method that applies to a scene measured side by side.

In: a system, a motion or a scene. Out: a ``Cost``: one row a method and accuracy, with true errors.
Read ``side_by_side.py`` first, then ``measure.py`` and ``reference.py`` (what true errors are measured against).
"""

from hjsolve.costs.side_by_side import cost
from hjsolve.costs.table import Cost, Row

__all__ = ["Cost", "Row", "cost"]
