"""Where else does it separate? ``find_coordinates`` in the plane and in space; ``normal_modes`` of small motion."""

from hjsolve.coordinates.find import find_coordinates
from hjsolve.coordinates.oscillations import Mode, NormalModes, normal_modes
from hjsolve.coordinates.results import Coordinates, ParameterValues, Web

__all__ = ["Coordinates", "Mode", "NormalModes", "ParameterValues", "Web", "find_coordinates", "normal_modes"]
