"""Scenes: a system with the effects, events, numbers and quantities that one question calls for, and its run."""

from hjsolve.scenes.resting_contact import Rest
from hjsolve.scenes.results import Arc, Run, Trajectory
from hjsolve.scenes.scene import Scene
from hjsolve.scenes.tables import is_scene

__all__ = ["Arc", "Rest", "Run", "Scene", "Trajectory", "is_scene"]
