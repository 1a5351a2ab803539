"""The initial conditions of a sweep: any window of a grid or a table, as doubles."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.number_types import Columns, Reals
from hjsolve.catalog.schema import nearest
from hjsolve.ensembles.layout import RECOMPUTED, STATUS
from hjsolve.errors import InvalidInputError, MissingExtraError
from hjsolve.formulas.read import number
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.wanted import OF_MANY_ORBITS
from hjsolve.scenes import Scene
from hjsolve.scenes.initial_grid import GROUPS, STATE, STATES, TORI, Axis, Varied, keys, missing, varied_kind

if TYPE_CHECKING:
    import pyarrow as pa

    from hjsolve.sweeps.parquet_table import ParquetTable


@dataclass(frozen=True, eq=False)
class SweepPoints:
    """Where the orbits of a sweep start.

    Attributes:
        kind: ``p`` or ``velocity``; ``angles`` of tori.
        count: orbits.
        sizes: of the axes of a grid, the last varies fastest; (count,) for a table.
        varied: initial condition (``q.r``) → (its axis, its values along it).
        fixed: initial condition → the one number that it is in all orbits.
        table: a Parquet table, of which every window is read when it is wanted.
        heading: initial condition → its column in that table.
        keep: columns of that table that are written next to the results.
    """

    kind: str
    count: int
    sizes: tuple[int, ...]
    varied: Mapping[str, tuple[int, Reals]]
    fixed: Mapping[str, float]
    table: ParquetTable | None = None
    heading: Mapping[str, str] = field(default_factory=dict)
    keep: tuple[str, ...] = ()

    @property
    def groups(self) -> tuple[str, str]:
        """The groups of initial conditions: places and momenta, velocities, or actions and angles."""
        return TORI if self.kind == "angles" else ("q", self.kind)

    def kept(self, begin: int, end: int) -> dict[str, pa.ChunkedArray]:
        """Return the columns passed on, of the starts begin ≤ number < end, as they are.

        Args:
            begin, end: numbers of the first start and of the one after the last.

        Returns:
            Name → Arrow array of end − begin values.
        """
        if self.table is None or not self.keep:
            return {}
        rows = self.table.read(self.keep, begin, end)
        return {name: rows[name] for name in self.keep}

    def window(self, names: list[str], begin: int, end: int) -> dict[str, Reals]:
        """Return the starts begin ≤ number < end: ``q.r`` … in the order of the coordinates, then ``p.r`` ….

        Angles that nothing says are 0.

        Args:
            begin, end: numbers of the first start and of the one after the last.

        Returns:
            Name → array of shape (end − begin,).
        """
        places = np.unravel_index(np.arange(begin, end), self.sizes)
        columns: dict[str, Reals] = {}
        if self.table is not None:
            columns = self.table.doubles(tuple(dict.fromkeys(self.heading.values())), begin, end)
        result = {}
        for key in [f"{group}.{name}" for group in self.groups for name in names]:
            if key in self.varied:
                axis, values = self.varied[key]
                result[key] = values[places[axis]]
            elif key in self.heading:
                result[key] = columns[self.heading[key]]
            else:
                zero = self.fixed.get(key, 0.0) if self.kind == "angles" else self.fixed[key]
                result[key] = np.full(end - begin, zero, dtype=float)
        return result


def points_of(scene: Scene) -> tuple[SweepPoints, str]:
    """Return the starts that a scene declares, and a digest of the table they come from (empty for a grid).

    Args:
        scene: with a ``sweep``.

    Raises:
        InvalidInputError: the scene has no sweep; the table cannot be read, or does not hold what it should.
        MissingExtraError: the table is a Parquet file and pyarrow is not installed.
    """
    if scene.sweep is None:
        raise InvalidInputError(f"{scene.source}: has no table [sweep] that says what to vary; see docs/ensembles.md")
    varied: dict[str, tuple[int, Reals]] = {}
    rows: ParquetTable | None = None
    heading: dict[str, str] = {}
    if scene.sweep.table is None:
        axes, digest = scene.sweep.axes, ""
        varied = {f"{axis.group}.{axis.name}": (k, _values(axis)) for k, axis in enumerate(axes)}
        sizes = tuple(axis.size for axis in axes)
    elif scene.sweep.table.suffix == ".parquet":
        rows, heading = _parquet(scene, scene.sweep, scene.sweep.table)
        digest, sizes = rows.digest, (rows.rows,)
    else:
        columns, digest = _table(scene, scene.sweep, scene.sweep.table)
        varied = {key: (0, column) for key, column in columns.items()}
        sizes = (len(next(iter(columns.values()))),)
    given = {*varied, *heading}
    kind = varied_kind(given, scene.fixed)
    fixed = {
        f"{group}.{name}": float(to_bits(number(value, source=f"initial.{group}.{name}"))(64))
        for group in ("q", kind)
        for name, value in (scene.fixed.get(group) or {}).items()
        if f"{group}.{name}" not in given
    }
    count = int(np.prod(sizes, dtype=np.int64))
    return SweepPoints(kind, count, sizes, varied, fixed, rows, heading, scene.sweep.keep), digest


def _values(axis: Axis) -> Reals:
    def nearest_double(value: sp.Expr) -> float:
        return float(to_bits(value)(64))

    if axis.listed:
        return np.array([nearest_double(value) for value in axis.listed])
    ends = nearest_double(axis.start), nearest_double(axis.stop)
    return np.geomspace(*ends, axis.count) if axis.spacing == "log" else np.linspace(*ends, axis.count)


# ------------------------------------------------------------------------------------------------ tables
def _table(scene: Scene, sweep: Varied, path: Path) -> tuple[dict[str, Reals], str]:
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        found = {".csv": _csv, ".npz": _npz}[path.suffix](path)
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read ({error.strerror or type(error).__name__})") from error
    names = [c.name for c in scene.system.coordinates]
    heading = {key: sweep.columns.get(key, key) for key in keys(names)}
    rows = len(next(iter(found.values()), ()))
    _refuse(path, _table_faults(list(found), rows, heading, sweep, names, scene))
    return {key: _column(path, name, found[name]) for key, name in heading.items() if name in found}, digest


def _refuse(path: Path, problems: Iterator[str]) -> None:
    if faults := list(problems):
        raise InvalidInputError("\n".join(f"{path}: {problem}" for problem in faults))


def _table_faults(
    found: list[str], rows: int, heading: Mapping[str, str], sweep: Varied, names: list[str], scene: Scene
) -> Iterator[str]:
    for name in found:
        if name.partition(".")[0] in GROUPS and "." in name and name not in heading.values():
            yield f'column "{name}" is not an initial condition{nearest(name, heading)}'
    for key, name in sweep.columns.items():
        if name not in found:
            yield f'no column "{name}" for {key}{nearest(name, found)}'
    present = [key for key, name in heading.items() if name in found]
    groups = {key.partition(".")[0] for key in present}
    if groups & {*STATES} and groups & {*TORI}:
        yield "columns of both actions or angles and q, p or velocity; give states or tori"
    elif (STATE in scene.want) != bool(groups & {*TORI}) and present:
        cure = f'a table of actions gives states: write want = ["{STATE}"]'
        yield cure if groups & {*TORI} else f'want: "{STATE}" is for a sweep over actions'
    if not present:
        yield f"no column is an initial condition; name them {', '.join(heading)}, or say which in sweep.columns"
    if {"p", "velocity"} <= {key.partition(".")[0] for key in present}:
        yield "columns of both p and velocity; give one of the two"
    yield from missing(present, names, scene.fixed)
    if present and not rows:
        yield "holds no rows"


def _column(path: Path, name: str, values: NDArray[np.generic]) -> Reals:
    array = np.asarray(values)
    if array.ndim != 1 or array.dtype.kind not in "fiu":
        raise InvalidInputError(f'{path}: column "{name}" must hold one number a row, not {array.dtype} {array.shape}')
    return array.astype(np.float64)


def _csv(path: Path) -> Columns:
    """Comma-separated numbers below a line of headings; an empty field is NaN."""
    try:
        head, _, body = path.read_text(encoding="utf-8-sig").partition("\n")
    except UnicodeDecodeError as error:
        raise InvalidInputError(f"{path}: is not UTF-8 text (byte {error.start})") from error
    headings = [word.strip().strip('"') for word in head.split(",")]
    if not body.strip():
        return dict.fromkeys(headings, np.empty(0))
    try:
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2, converters=_number, encoding="utf-8")
    except ValueError as error:
        text = " ".join(str(error).split())
        raise InvalidInputError(f"{path}: is not a table of numbers below one line of headings: {text}") from error
    if rows.shape[1] != len(headings):
        raise InvalidInputError(f"{path}: has {len(headings)} headings and {rows.shape[1]} columns")
    return {name: rows[:, k] for k, name in enumerate(headings)}


def _number(text: str) -> float:
    return float(text) if text.strip() else np.nan


def _npz(path: Path) -> Columns:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except ValueError as error:
        raise InvalidInputError(f"{path}: is no .npz file of plain arrays: {error}") from error
    lengths = {len(array) if array.ndim else -1 for array in found.values()}
    if len(lengths) > 1:
        raise InvalidInputError(f"{path}: its arrays have different lengths")
    return found


def _parquet(scene: Scene, sweep: Varied, path: Path) -> tuple[ParquetTable, dict[str, str]]:
    """Return the table, of which only footers are read, and initial condition → its column."""
    try:
        from hjsolve.sweeps.parquet_table import opened_table
    except ImportError as error:
        raise MissingExtraError(f'{path}: needs pyarrow: pip install "hjsolve[cluster]"') from error
    try:
        table = opened_table(path)
    except OSError as error:
        raise InvalidInputError(f"{path}: cannot be read ({error.strerror or type(error).__name__})") from error
    names, found = [c.name for c in scene.system.coordinates], list(table.schema.names)
    heading = {key: sweep.columns.get(key, key) for key in keys(names)}
    _refuse(path, _table_faults(found, table.rows, heading, sweep, names, scene))
    _refuse(path, _kept_faults(found, sweep))
    present = {key: name for key, name in heading.items() if name in found}
    for name in present.values():
        if not table.numeric(name):
            raise InvalidInputError(
                f'{path}: column "{name}" must hold one number a row, not {table.schema.field(name).type}'
            )
    return table, present


def _kept_faults(found: list[str], sweep: Varied) -> Iterator[str]:
    for name in sweep.keep:
        if name not in found:
            yield f'no column "{name}" to keep{nearest(name, found)}'
        if sweep.keep.count(name) > 1 or _is_written(name):
            yield f'sweep.keep: "{name}" is a column of the results already; rename it'


def _is_written(name: str) -> bool:
    """Return whether a name is, or looks like, one of a column that a sweep writes."""
    first, dot, _ = name.partition(".")
    return name in ("orbit", STATUS, RECOMPUTED) or bool(dot and first in (*GROUPS, *OF_MANY_ORBITS, "error"))
