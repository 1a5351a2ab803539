"""Where else does it separate? ``find_coordinates`` in the plane and in space; ``normal_modes`` of small motion."""

from hjsolve.coordinates.find import find_coordinates
from hjsolve.coordinates.results import Coordinates, ParameterValues, Web
from hjsolve.coordinates.small_oscillations import Mode, NormalModes, normal_modes

__all__ = ["Coordinates", "Mode", "NormalModes", "ParameterValues", "Web", "find_coordinates", "normal_modes"]
