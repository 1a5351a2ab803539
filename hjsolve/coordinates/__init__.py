"""Where else does it separate? ``find_coordinates`` in the plane and in space, ``normal_modes`` for small oscillations."""

from .find import find_coordinates
from .results import Coordinates, ParameterValues, Web

__all__ = ["Coordinates", "ParameterValues", "Web", "find_coordinates"]
