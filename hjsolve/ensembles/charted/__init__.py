"""Ensembles given in the user's coordinates: arrays of x, v become starts in the coordinates in which H separates.

In: a solution with a chart, arrays. Out: ``Starts`` for the engine, whose momenta carry the errors of the map.
Read ``chart_map.py`` first (the formulas as tapes), then ``charted_starts.py``.
"""

from hjsolve.ensembles.charted.chart_map import ChartMap, chart_map
from hjsolve.ensembles.charted.charted_starts import run_charted

__all__ = ["ChartMap", "chart_map", "run_charted"]
