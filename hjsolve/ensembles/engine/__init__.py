"""The engine below ``ensemble``: many orbits of one system at once, in doubles, each with a status and an error.

In: a solution, read once by ``build``, and arrays of starts. Out: columns: an orbit comes back with status ``OK`` and a
claimed error that is not below the true error for exactly these inputs, or with another status and NaN: it then
belongs to the engine of single motions (``hjsolve.motion``), which raises its precision as needed.
Read ``engine.py`` first, then ``passes.py``; ``librating.py`` and ``kernels`` do most of the work.
"""

from hjsolve.ensembles.engine.columns import QUANTITIES as QUANTITIES
from hjsolve.ensembles.engine.columns import Columns as Columns
from hjsolve.ensembles.engine.engine import Engine as Engine
from hjsolve.ensembles.engine.engine import build as build
from hjsolve.ensembles.engine.starts import MomentumRule as MomentumRule
from hjsolve.ensembles.engine.status import Status as Status
