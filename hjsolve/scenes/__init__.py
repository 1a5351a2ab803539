"""Scenes: a system with the effects, events, numbers and quantities that one question calls for, and its run.

In: a scene file. Out: a ``Run``: arcs, trajectory, and the quantities wanted.
Read ``scene.py`` first, then ``run.py`` and ``arcs.py``.
"""

from hjsolve.scenes.resting_contact import Rest
from hjsolve.scenes.results import Arc, Run, Trajectory
from hjsolve.scenes.scene import Scene
from hjsolve.scenes.tables import is_scene

__all__ = ["Arc", "Rest", "Run", "Scene", "Trajectory", "is_scene"]
