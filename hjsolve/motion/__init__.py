"""Motion: one motion of a solved system, from initial data to numbers and states, each with its error.

In: a ``Solution``, initial data, parameters. Out: a frozen ``Motion``: kinds, turning points, actions, periods,
frequencies, and ``State`` at any times.
Read ``motion.py`` first, then ``charted/begin.py`` (how it starts), ``initial_data.py`` (exact constants) and
``state_at.py`` (time to state).
"""
