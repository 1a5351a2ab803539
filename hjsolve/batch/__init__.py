"""Many orbits of one system at once, in doubles, each with a status and an error: the engine below ``ensemble``.

``build`` reads a solution once; ``Engine.run`` takes arrays of starts. An orbit comes back with status ``OK`` and a
claimed error that is not below the true error for exactly these inputs, or with another status and NaN: it then
belongs to the single-orbit engine (``hjsolve.motion``), which has as many digits as it takes.
"""

from hjsolve.batch.columns import QUANTITIES as QUANTITIES
from hjsolve.batch.columns import Columns as Columns
from hjsolve.batch.columns import Status as Status
from hjsolve.batch.engine import Engine as Engine
from hjsolve.batch.engine import build as build
from hjsolve.batch.engine import ready as ready
