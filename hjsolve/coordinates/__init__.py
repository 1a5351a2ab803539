"""Where else does it separate? ``find_coordinates`` in the plane and in space; ``normal_modes`` of small motion."""

from .find import find_coordinates
from .oscillations import Mode, NormalModes, normal_modes
from .results import Coordinates, ParameterValues, Web

__all__ = ["Coordinates", "Mode", "NormalModes", "ParameterValues", "Web", "find_coordinates", "normal_modes"]
