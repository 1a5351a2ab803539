"""What a sweep varies: the table ``[sweep]`` of a scene, a grid of initial conditions or a file with a row for each.

    [sweep]                                     [sweep]
    chunk = 16384                               table = "starts.csv"          # .csv, .npz or .parquet
    q = {r = {start = "0.8", stop = "2",        columns = {"q.r" = "radius"}  # where the file names them otherwise
              count = 100}}                         keep = ["source_id"]        # of a .parquet: columns passed on
    p = {theta = ["0.9", "1.1"]}

What a sweep does not vary stands in the scene's initial data. A sweep over tori has actions, and angles where they are
not 0, in place of q and p; each of its orbits gives a state.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.catalog import schema
from hjsolve.catalog.schema import Key, nearest
from hjsolve.catalog.toml_file import Toml
from hjsolve.formulas.read import number

STATES, TORI = ("q", "p", "velocity"), ("actions", "angles")
GROUPS = (*STATES, *TORI)
STATE = "state"
"""What is wanted of a sweep over tori."""
SUFFIXES = (".csv", ".npz", ".parquet")
CHUNK = 16_384
"""Orbits of one part of the output."""

_MOST_ORBITS = 10**12
_SPACINGS = ("even", "log")
_RANGE = {
    "start": Key("number", True), "stop": Key("number", True), "count": Key("number", True),
    "spacing": Key("text", choices=_SPACINGS),
}  # fmt: skip
_SWEEP = {
    "chunk": Key("number"), "table": Key("text"), "columns": Key("formulas"), "keep": Key("texts"),
    "kinds": Key("formulas"), "wells": Key("formulas"), **{group: Key("table") for group in GROUPS},
}  # fmt: skip
_NOT_WITH = ("events", "times", "orbit")
_OF_STATES = ("initial", "motion", "velocity_frame")


@dataclass(frozen=True)
class Axis:
    """One initial condition of a grid and the values it takes.

    Attributes:
        group: one of ``GROUPS``.
        name: the coordinate.
        listed: exact values; empty where they are spaced from ``start`` to ``stop``, both included.
        spacing: ``even``, or ``log``: equal ratios.
    """

    group: str
    name: str
    listed: tuple[sp.Expr, ...] = ()
    start: sp.Expr = sp.S.Zero
    stop: sp.Expr = sp.S.Zero
    count: int = 0
    spacing: str = "even"

    @property
    def size(self) -> int:
        """How many values it takes."""
        return len(self.listed) or self.count


@dataclass(frozen=True)
class Varied:
    """The table ``[sweep]``, read.

    Attributes:
        chunk: orbits of one part of the output.
        axes: of the grid; the last varies fastest.
        table: the file, in place of a grid.
        columns: initial condition, ``q.r``, → its column in the file, where that has another name.
        keep: columns of the file that are written next to the results as they are.
        kinds: of tori, separated coordinate → libration or rotation, where both have the same actions.
        wells: of tori, coordinate → a place in the well that is meant, where several have the same actions.
    """

    chunk: int
    axes: tuple[Axis, ...]
    table: Path | None
    columns: Mapping[str, str]
    keep: tuple[str, ...] = ()
    kinds: Mapping[str, str] = field(default_factory=dict)
    wells: Mapping[str, sp.Expr] = field(default_factory=dict)

    @property
    def over_tori(self) -> bool:
        """Whether a grid varies actions."""
        return any(axis.group in TORI for axis in self.axes)


# ------------------------------------------------------------------------------------------------ its shape
def sweep_faults(given: object, scene: Toml) -> Iterator[str]:
    """List where the table does not have the required shape, one line each.

    Args:
        given: the table ``sweep`` as it was read.
        scene: the table of the scene.
    """
    if not isinstance(given, Mapping):
        yield f'sweep: must be a table, e.g. [sweep] q = {{r = ["1", "2"]}}, not {given!r:.40}'
        return
    plain = {key: value for key, value in given.items() if not (key in GROUPS and isinstance(value, Mapping))}
    yield from schema.faults(plain, _SWEEP, "sweep")
    chunk = given.get("chunk", CHUNK)
    if not _is_count(chunk, 1):
        yield f"sweep.chunk: must be a whole number from 1 to {_MOST_ORBITS}, not {arguments.described(chunk)}"
    varied = [group for group in GROUPS if isinstance(given.get(group), Mapping)]
    if ("table" in given) == bool(varied):
        yield "sweep: give a grid (q, p or velocity; or actions, angles) or a table, one of the two"
    if "p" in varied and "velocity" in varied:
        yield "sweep: give p or velocity, one of the two"
    if {*varied} & {*STATES} and {*varied} & {*TORI}:
        yield "sweep: give q and p or velocity, or actions and angles, not both"
    if {*varied} & {*TORI}:
        yield from (f"{key}: a sweep over actions has no places; leave it out" for key in _OF_STATES if key in scene)
        if "coordinates" in scene:
            yield "coordinates: a sweep over actions is in coordinates that separate as they are given; leave it out"
    elif "table" not in given:
        yield from (f"sweep.{key}: belongs to actions" for key in ("kinds", "wells") if key in given)
    if "columns" in given and "table" not in given:
        yield "sweep.columns: belongs to a table"
    if "keep" in given and Path(str(given.get("table", ""))).suffix != ".parquet":
        yield "sweep.keep: belongs to a table that is a .parquet"
    table = given.get("table")
    if isinstance(table, str) and Path(table).suffix not in SUFFIXES:
        yield f'sweep.table: "{table}" must end in {", ".join(SUFFIXES)}'
    for group in varied:
        for name, values in given[group].items():
            yield from _axis_faults(values, f"sweep.{group}.{name}")
    yield from (f"{key}: not in a scene with a sweep, which has many motions" for key in _NOT_WITH if key in scene)
    if scene.get("method") == "integrate":
        yield "method: a sweep is computed by quadratures; leave it out"


def _axis_faults(values: object, where: str) -> Iterator[str]:
    if isinstance(values, Mapping):
        yield from schema.faults(values, _RANGE, where)
        count = values.get("count", 2)
        if not _is_count(count, 2):
            yield f"{where}.count: must be a whole number from 2 to {_MOST_ORBITS}, not {arguments.described(count)}"
    elif isinstance(values, list):
        if not values:
            yield f"{where}: must be a list of numbers, and not empty"
        for place, value in enumerate(values, start=1):
            if isinstance(value, (bool, list, dict)):
                yield f'{where}[{place}]: must be a number, best as a text such as "1.2", not {value!r:.40}'
    elif isinstance(values, bool):
        yield f"{where}: must be a number, a list of numbers, or {{start = …, stop = …, count = …}}, not {values}"


def _is_count(value: object, least: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= _MOST_ORBITS


# ------------------------------------------------------------------------------------------------ its content
def read_sweep(given: Toml | None, folder: Path) -> Varied | None:
    """Read a table that has no ``sweep_faults``; a file is looked for next to the scene first.

    Args:
        given: the table ``sweep``; None where the scene has none.
        folder: of the scene's file.

    Raises:
        ExpressionError: a value that is not a number.
    """
    if given is None:
        return None
    axes = tuple(_axis(group, name, values) for group in GROUPS for name, values in given.get(group, {}).items())
    table = Path(given["table"]) if "table" in given else None
    if table is not None and (folder / table).exists():
        table = folder / table
    columns, kinds, keep = dict(given.get("columns", {})), dict(given.get("kinds", {})), tuple(given.get("keep", ()))
    wells = {name: number(value, source=f"sweep.wells.{name}") for name, value in given.get("wells", {}).items()}
    return Varied(given.get("chunk", CHUNK), axes, table, columns, keep, kinds, wells)


def _axis(group: str, name: str, values: object) -> Axis:
    source = f"sweep.{group}.{name}"
    if isinstance(values, Mapping):
        start, stop = (number(values[key], source=f"{source}.{key}") for key in ("start", "stop"))
        return Axis(group, name, (), start, stop, values["count"], values.get("spacing", "even"))
    several = values if isinstance(values, list) else [values]
    return Axis(group, name, tuple(number(v, source=f"{source}[{k}]") for k, v in enumerate(several, start=1)))


def disagreements(sweep: Varied, names: list[str], fixed: Mapping[str, Mapping[str, object] | None]) -> Iterator[str]:
    """Yield what a sweep says against the system, or leaves open.

    Args:
        sweep: the table.
        fixed: group → the scene's initial data.
    """
    for axis in sweep.axes:
        if axis.name not in names:
            yield f'sweep.{axis.group}: no coordinate "{axis.name}"{nearest(axis.name, names)}'
        if axis.spacing == "log" and not (axis.start.is_positive and axis.stop.is_positive):
            yield f"sweep.{axis.group}.{axis.name}: log spacing needs a positive start and stop"
    for key in sweep.columns:
        if key not in keys(names):
            yield f'sweep.columns: "{key}" is not an initial condition{nearest(key, keys(names))}'
    if sweep.table is None:
        yield from missing([f"{axis.group}.{axis.name}" for axis in sweep.axes], names, fixed)
    elif not sweep.table.is_file() and not (sweep.table.suffix == ".parquet" and sweep.table.is_dir()):
        yield f"sweep.table: {sweep.table} is not there"


def keys(names: Iterable[str]) -> list[str]:
    """Return the initial conditions that a table may have: ``q.r`` and so on."""
    return [f"{group}.{name}" for group in GROUPS for name in names]


def varied_kind(varied: Iterable[str], fixed: Mapping[str, Mapping[str, object] | None]) -> str:
    """``angles`` of tori, else ``p`` or ``velocity``: what the sweep varies, else what the initial data give.

    Args:
        varied: keys of the sweep, such as ``p.r``.
        fixed: the scene's initial data: ``q``, ``p``, ``velocity`` → name → number.
    """
    groups = {key.partition(".")[0] for key in varied} - {"q"}
    if groups & {*TORI}:
        return "angles"
    return min(groups) if groups else "p" if fixed.get("p") else "velocity"


def missing(varied: list[str], names: list[str], fixed: Mapping[str, Mapping[str, object] | None]) -> Iterator[str]:
    """Yield initial conditions that neither the sweep nor the initial data give.

    Args:
        varied: keys of the sweep, such as ``p.r``.
        fixed: the scene's initial data: ``q``, ``p``, ``velocity`` → name → number.
    """
    kind = varied_kind(varied, fixed)
    if kind == "angles":
        without = [name for name in names if f"actions.{name}" not in varied]
        yield from (f"sweep.actions.{name}: missing; every coordinate needs one" for name in without)
        return
    for group in ("q", kind):
        for name in names:
            if f"{group}.{name}" not in varied and name not in (fixed.get(group) or {}):
                yield f"sweep.{group}.{name}: missing; neither the sweep nor initial.{group} says it"
