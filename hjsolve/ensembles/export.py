"""A batch as a table of pandas, Arrow or xarray, and as a Parquet file.

Columns have the flat names of ``Batch.columns``; the status is written as its word. Orbits come in the order of the
batch, the last axis fastest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from hjsolve.ensembles.orbit_columns import OrbitColumns
from hjsolve.errors import InvalidInputError, MissingExtraError

SUFFIX = ".parquet"


def axis_names(shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return the names of the axes of a batch: ``orbit``, or ``axis_0``, ``axis_1``, … where there are several."""
    return ("orbit",) if len(shape) == 1 else tuple(f"axis_{k}" for k in range(len(shape)))


def with_words(batch: OrbitColumns) -> dict[str, Any]:
    """Return the columns of a batch, the status as words.

    Args:
        batch: results of orbits.
    """
    return {name: batch.status if name == "status" else column for name, column in batch.columns.items()}


def _flat(columns: Mapping[str, Any]) -> dict[str, Any]:
    return {name: np.asarray(column).reshape(-1) for name, column in columns.items()}


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        library = name.partition(".")[0]
        raise MissingExtraError(f'{library} is not installed: pip install "hjsolve[tables]"') from error


def pandas_frame(batch: OrbitColumns) -> Any:
    """Return a ``pandas.DataFrame``, one row an orbit; several axes become a MultiIndex.

    Args:
        batch: of numpy arrays.

    Raises:
        MissingExtraError: pandas is not installed.
    """
    pd = _library("pandas")
    names = axis_names(batch.shape)
    index = (
        pd.RangeIndex(batch.shape[0], name=names[0])
        if len(names) == 1
        else pd.MultiIndex.from_product([range(n) for n in batch.shape], names=names)
        if names
        else None
    )
    return pd.DataFrame(_flat(with_words(batch)), index=index)


def arrow_table(batch: OrbitColumns) -> Any:
    """Return a ``pyarrow.Table``, one row an orbit; the shape is in its metadata.

    Args:
        batch: of numpy arrays.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    pa = _library("pyarrow")
    columns = {name: pa.array(column) for name, column in _flat(with_words(batch)).items()}
    columns["status"] = columns["status"].dictionary_encode()
    return pa.table(columns).replace_schema_metadata({"shape": json.dumps(list(batch.shape))})


def xarray_dataset(batch: OrbitColumns) -> Any:
    """Return an ``xarray.Dataset`` over the axes of the batch.

    Args:
        batch: numpy or dask arrays.

    Raises:
        MissingExtraError: xarray is not installed.
    """
    xr = _library("xarray")
    names = axis_names(batch.shape)
    return xr.Dataset({name: (names, column) for name, column in with_words(batch).items()})


def write_parquet(batch: OrbitColumns, path: str | PathLike[str]) -> Path:
    """Write a Parquet file, completely or not at all.

    Args:
        batch: of numpy arrays.
        path: ends in ``.parquet``.

    Returns:
        The path.

    Raises:
        InvalidInputError: another ending.
        MissingExtraError: pyarrow is not installed.
    """
    target = Path(path)
    if target.suffix != SUFFIX:
        raise InvalidInputError(f"save: {str(path)!r} must end in {SUFFIX}")
    table, parquet = arrow_table(batch), _library("pyarrow.parquet")
    beside = target.with_name(f".{target.name}.writing")
    try:
        parquet.write_table(table, beside, use_dictionary=columns_of_words(table))
        beside.replace(target)
    finally:
        beside.unlink(missing_ok=True)
    return target


def columns_of_words(table: Any) -> list[str]:
    """Name the columns of an Arrow table that a Parquet file keeps as a dictionary: all but numbers.

    Numbers of orbits hardly ever repeat: to look for those that do is five sixths of the time of writing, and the file
    becomes larger by it.

    Args:
        table: of pyarrow.
    """
    known = _library("pyarrow").types
    return [f.name for f in table.schema if not (known.is_primitive(f.type) or known.is_boolean(f.type))]
