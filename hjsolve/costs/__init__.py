"""Accuracy against time: every method that applies to a scene, measured side by side."""

from hjsolve.costs.side_by_side import cost
from hjsolve.costs.table import Cost, Row

__all__ = ["Cost", "Row", "cost"]
