"""Dask arrays in, dask arrays out: one task a block, nothing computed before it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from hjsolve.arithmetic.number_types import Reals
from hjsolve.ensembles.batch import Batch
from hjsolve.ensembles.compute import Columns, compute_columns, dtypes
from hjsolve.ensembles.initial_conditions import InitialConditions
from hjsolve.ensembles.layout import Layout
from hjsolve.ensembles.task import EnsembleTask
from hjsolve.errors import MissingExtraError

BlockOfOrbits = Callable[[list[Reals]], Columns]
"""Inputs of the orbits of one block, arrays of shape (n,), ↦ all of their columns."""


def lazily(task: EnsembleTask, layout: Layout, given: InitialConditions) -> Batch:
    """Lay an ensemble out as dask arrays.

    Args:
        task: what is to be computed of each orbit.
        layout: names and types of the columns.
        given: initial data, dask arrays that broadcast together.

    Raises:
        MissingExtraError: dask is not installed.
    """
    names = [c.name for c in task.system.coordinates]
    arrays = [group[name] for group in (given.q, given.rates) for name in names]
    return by_blocks(partial(_orbits, task), arrays, layout, given.shape)


def _orbits(task: EnsembleTask, inputs: list[Reals]) -> Columns:
    half = len(inputs) // 2
    return compute_columns(task, inputs[:half], inputs[half:], threads=1)


def by_blocks(columns_of: BlockOfOrbits, arrays: list[Any], layout: Layout, shape: tuple[int, ...]) -> Batch:
    """Lay out as dask arrays what is computed from dask arrays.

    A block's task computes all columns of its orbits, as one array of records; each column is a view of it. Blocks are
    those of the input, after broadcasting; the tasks take one thread each, the scheduler has the others.

    Args:
        columns_of: that dask can send to its workers.
        arrays: inputs of the orbits, arrays that broadcast together, some of dask.
        layout: names and types of the columns.
        shape: that the arrays broadcast to.

    Raises:
        MissingExtraError: dask is not installed.
    """
    try:
        import dask.array as da
    except ImportError as error:  # something else gave arrays that look like dask's
        raise MissingExtraError('dask arrays need dask: pip install "hjsolve[cluster]"') from error
    spread = da.broadcast_arrays(*(da.asarray(array) for array in arrays))
    record = np.dtype([(name, dtype) for name, dtype in dtypes(layout).items()])
    meta = np.empty((0,) * len(shape), dtype=record)
    records = da.map_blocks(_records, *spread, columns_of=columns_of, dtype=record, meta=meta, name=None)
    columns = {name: _column(records, name) for name in record.names or ()}
    return Batch(columns, layout, shape)


def _column(records: Any, name: str) -> Any:
    dtype = records.dtype[name]
    return records.map_blocks(_field, name, dtype=dtype, meta=np.empty((0,) * records.ndim, dtype))


def _field(block: Any, name: str) -> Any:
    return np.ascontiguousarray(block[name]).reshape(block.shape)


def _records(*arrays: Any, columns_of: BlockOfOrbits) -> Any:
    """Return the records of one block."""
    shape = arrays[0].shape
    columns = columns_of([np.ascontiguousarray(array).reshape(-1) for array in arrays])
    block = np.empty(shape, dtype=[(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        block[name] = column.reshape(shape)
    return block
