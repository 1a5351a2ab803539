"""Sweeps: an ensemble that a scene declares, computed part by part into a folder of Parquet files; resumable."""

from hjsolve.sweeps.conduct import Swept, sweep

__all__ = ["Swept", "sweep"]
