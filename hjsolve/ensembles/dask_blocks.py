"""Dask arrays in, dask arrays out: one task a block, nothing computed before it is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np

from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.compute import compute_columns, dtypes
from hjsolve.ensembles.initial_conditions import InitialConditions
from hjsolve.ensembles.layout import Layout
from hjsolve.ensembles.task import EnsembleTask
from hjsolve.errors import MissingExtraError


def lazily(task: EnsembleTask, layout: Layout, given: InitialConditions) -> Batch:
    """Lay an ensemble out as dask arrays.

    A block's task computes all columns of its orbits, as one array of records; each column is a view of it. Blocks are
    those of the input, after broadcasting; the tasks take one thread each, the scheduler has the others.

    Args:
        task: what is to be computed of each orbit.
        layout: names and types of the columns.
        given: initial data, dask arrays that broadcast together.

    Raises:
        MissingExtraError: dask is not installed.
    """
    try:
        import dask.array as da
    except ImportError as error:  # something else gave arrays that look like dask's
        raise MissingExtraError('dask arrays need dask: pip install "hjsolve[cluster]"') from error
    names = [c.name for c in task.system.coordinates]
    arrays = [da.asarray(group[name]) for group in (given.q, given.rates) for name in names]
    spread = da.broadcast_arrays(*arrays)
    record = np.dtype([(name, dtype) for name, dtype in dtypes(layout).items()])
    meta = np.empty((0,) * len(given.shape), dtype=record)
    records = da.map_blocks(_records, *spread, task=task, dtype=record, meta=meta, name=None)
    columns = {name: _column(records, name) for name in record.names or ()}
    return Batch(columns, layout, given.shape)


def _column(records: Any, name: str) -> Any:
    dtype = records.dtype[name]
    return records.map_blocks(_field, name, dtype=dtype, meta=np.empty((0,) * records.ndim, dtype))


def _field(block: Any, name: str) -> Any:
    return np.ascontiguousarray(block[name]).reshape(block.shape)


def _records(*arrays: Any, task: EnsembleTask) -> Any:
    """Return the records of one block."""
    shape, half = arrays[0].shape, len(arrays) // 2
    flat = [np.ascontiguousarray(array).reshape(-1) for array in arrays]
    columns = compute_columns(task, flat[:half], flat[half:], threads=1)
    block = np.empty(shape, dtype=[(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        block[name] = column.reshape(shape)
    return block
