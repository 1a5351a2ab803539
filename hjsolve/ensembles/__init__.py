"""Ensembles: arrays of initial conditions in, arrays of actions, frequencies, angles and periods out.

In: arrays or dask arrays of starts. Out: a ``Batch``: columns with errors, and a status for every orbit.
Read ``orbits.py`` first (``ensemble``), then ``compute.py``; ``engine`` computes in doubles, ``fallback.py`` the rest.
"""

from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.orbits import ensemble

__all__ = ["Batch", "Status", "ensemble"]
