"""Sweeps: an ensemble that a scene declares, computed part by part into a folder of Parquet files; resumable.

In: a scene with a table ``[sweep]``. Out: a folder with a manifest, complete part by part.
Read ``conduct.py`` first, then ``folder.py``.
"""

from hjsolve.sweeps.conduct import SweepResult, sweep

__all__ = ["SweepResult", "sweep"]
