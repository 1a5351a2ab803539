"""Rows of a Parquet file, or of a folder of them, read part by part: never the whole table, never other columns.

A folder is the files ``*.parquet`` in it and below, in the order of their paths; names that begin with an underscore or
a dot are no data, as for all readers of such folders.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Reals
from hjsolve.errors import InvalidInputError


@dataclass(frozen=True, eq=False)
class ParquetTable:
    """The rows, by group; made by ``opened_table``.

    Attributes:
        files: in order.
        schema: of all of them.
        groups: (file, row group in it) for all groups in order.
        ends: rows up to the end of each group.
        digest: of the content, see ``opened_table``.
    """

    files: tuple[Path, ...]
    schema: pa.Schema
    groups: tuple[tuple[int, int], ...]
    ends: NDArray[np.int64]
    digest: str

    @property
    def rows(self) -> int:
        """How many there are."""
        return int(self.ends[-1]) if len(self.ends) else 0

    def numeric(self, name: str) -> bool:
        """Tell whether a column holds one real number a row."""
        kind = self.schema.field(name).type
        return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind))

    def read(self, names: tuple[str, ...], begin: int, end: int) -> pa.Table:
        """Read some columns of the rows begin ≤ number < end."""
        first, last = np.searchsorted(self.ends, [begin, end - 1], side="right")
        pieces = []
        for group in range(first, last + 1):
            file, number = self.groups[group]
            start = int(self.ends[group - 1]) if group else 0
            low, high = max(begin - start, 0), min(end, int(self.ends[group])) - start
            pieces.append(_group(self.files[file], number, names).slice(low, high - low))
        return pa.concat_tables(pieces)

    def doubles(self, names: tuple[str, ...], begin: int, end: int) -> dict[str, Reals]:
        """Read columns of numbers as doubles; what is missing is NaN."""
        table = self.read(names, begin, end)
        return {name: table[name].to_numpy(zero_copy_only=False).astype(np.float64) for name in names}


@lru_cache(maxsize=4)
def _group(path: Path, number: int, names: tuple[str, ...]) -> pa.Table:
    """One row group; the parts that share it follow each other."""
    with pq.ParquetFile(path) as file:
        return file.read_row_group(number, columns=list(names), use_threads=False)


def opened_table(path: Path) -> ParquetTable:
    """Open a table: only the footers of its files are read.

    The digest of one file is that of its bytes. A folder may hold terabytes: its digest is that of the names, sizes,
    times of modification and schemas of its files.

    Args:
        path: of a file or a folder.

    Raises:
        InvalidInputError: a file is not a Parquet file, or has other columns than the first; there is none.
    """
    found = sorted(path.rglob("*.parquet")) if path.is_dir() else [path]
    files = tuple(p for p in found if p.is_file() and not _hidden(p.relative_to(path)))
    if not files:
        raise InvalidInputError(f"{path}: holds no file *.parquet")
    groups, sizes, digest = [], [], hashlib.sha256()
    first = _footer(files[0]).schema.to_arrow_schema()
    for k, file in enumerate(files):
        footer = _footer(file)
        if not (schema := footer.schema.to_arrow_schema()).equals(first):
            raise InvalidInputError(f"{file}: has other columns than {files[0].name}")
        known = file.stat()
        digest.update(f"{file.relative_to(path).as_posix()}\0{known.st_size}\0{known.st_mtime_ns}\0{schema}\0".encode())
        for number in range(footer.num_row_groups):
            groups.append((k, number))
            sizes.append(footer.row_group(number).num_rows)
    if not path.is_dir():
        with path.open("rb") as whole:
            digest = hashlib.file_digest(whole, "sha256")
    return ParquetTable(files, first, tuple(groups), np.cumsum(sizes, dtype=np.int64), digest.hexdigest())


def _hidden(path: Path) -> bool:
    return any(part.startswith(("_", ".")) for part in path.parts)


def _footer(path: Path) -> pq.FileMetaData:
    try:
        return pq.read_metadata(path)
    except pa.ArrowInvalid as error:
        raise InvalidInputError(f"{path}: is not a Parquet file: {error}") from error
