"""Ensembles: arrays of initial conditions in, arrays of actions, frequencies, angles and periods out."""

from hjsolve.ensembles.batch import Batch, Status
from hjsolve.ensembles.orbits import ensemble

__all__ = ["Batch", "Status", "ensemble"]
