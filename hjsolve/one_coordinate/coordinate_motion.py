"""The course of one separated coordinate: what kind of motion it makes, and its regular integrals.

What every kind answers is in ``kind_of_motion.py``; the kinds are in ``periodic_motion.py``,
``resting_motion.py`` and ``unbounded_motion.py``.
"""

from hjsolve.one_coordinate.kind_of_motion import PARTS, Kind, KindOfMotion, Weights, arithmetic_of, elementwise
from hjsolve.one_coordinate.periodic_motion import Anomaly, Periodic
from hjsolve.one_coordinate.resting_motion import AtRest
from hjsolve.one_coordinate.unbounded_motion import Unbounded

CoordinateMotion = Periodic | AtRest | Unbounded

__all__ = [
    "PARTS",
    "Anomaly",
    "AtRest",
    "CoordinateMotion",
    "Kind",
    "KindOfMotion",
    "Periodic",
    "Unbounded",
    "Weights",
    "arithmetic_of",
    "elementwise",
]
