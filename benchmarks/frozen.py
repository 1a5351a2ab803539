"""Freeze every number of the catalog, and say later which of them moved, and by how much of what they claim.

    python -m benchmarks.frozen FILE.json [--sample] [--only ENTRY …] [--processes N]
    python -m benchmarks.frozen FILE.json --compare OLD.json

The first command writes FILE.json, sha256 digests of the float64 bytes of every column, and FILE.npz, the values.
A column belongs to an entry, one of its families (the motions of its file), a method (15 digits, 50 digits, certified,
ensemble), a set of wanted quantities and a quantity. Its claimed errors are a column
of their own. What is a text (kind of motion, status, error raised) is kept as it is.

The second command reads two such files. A column whose digest is equal is not mentioned. Of the others it prints the
largest |difference| of a value over the sum of both claims, and which claims changed. It ends with status 1 if any did.

A number of 50 digits is written as four doubles whose sum it is. An ensemble has 16 orbits around the start of the
family: each position and each momentum is scaled by powers of 1.01 and 1.003.
A motion in doubles is asked for its states at three times, one by one, and at 2500 times at once.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import mp

import hjsolve
from hjsolve import catalog
from hjsolve.arithmetic.estimate import Estimate

SAMPLE = (
    "anisotropic-oscillator", "kepler-planar", "kepler-spherical", "kepler-parabolic", "two-centres-plane",
    "two-centres-space", "spherical-pendulum", "kerr", "henon-heiles-separable", "relativistic-kepler",
    "spring-turning-anchor", "pendulum",
)  # fmt: skip
"""One entry of each family of coordinates."""
WANTS = (("actions",), ("actions", "frequencies"), None)
TIMES = ("0.37", "1.9", "12.5")
MANY_TIMES = np.linspace(-31.0, 1234.5, 2500)
"""So many times at once are answered from a table of the inverted time law (``motion.tabulated.FEWEST``)."""
METHODS = {"15 digits": {}, "50 digits": {"digits": 50}, "certified": {"certified": True}}
ESTIMATES = ("constants", "actions", "frequencies", "periods", "boundary_times", "mean_velocities", "betas")
"""Attributes of a motion: name → Estimate."""
PARTS = {"15 digits": 1, "certified": 1, "ensemble": 1, "50 digits": 4}
"""Doubles that hold one number."""
_ORBITS = 16
_PRECISION = 80
"""Decimal digits of the differences, enough for numbers of 50 digits."""
Column = str | np.ndarray
Table = dict[str, Column]


def doubles(values: Iterable[Any], parts: int) -> np.ndarray:
    """Each number as so many doubles, the later ones the rests of the earlier: shape (n, parts)."""
    if parts == 1 and isinstance(values, np.ndarray) and values.dtype == np.float64:
        return values.reshape(-1, 1)
    rows = []
    for value in values:
        with mp.workdps(_PRECISION):
            rest, row = mp.mpf(value), list[float]()
            for _ in range(parts):
                row.append(float(rest))
                rest = rest - mp.mpf(row[-1]) if mp.isfinite(rest) else mp.mpf(0)
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, parts)


def numbers(name: str, values: Iterable[Any], errors: Iterable[Any], parts: int) -> Table:
    """A column and that of its claims; an empty list of errors where none are claimed."""
    claims = doubles(errors, 1)
    return {name: doubles(values, parts), **({f"error.{name}": claims} if claims.size else {})}


def estimates(name: str, found: Mapping[str, Any], parts: int) -> Table:
    """Estimates by name, pairs of turning points among them; a missing end is a text."""
    columns: Table = {}
    for key, value in found.items():
        if isinstance(value, tuple):
            pair = dict(zip(("lower", "upper"), value, strict=True))
            columns |= estimates(f"{name}.{key}", pair, parts)
        elif isinstance(value, Estimate):
            columns |= numbers(f"{name}.{key}", [value.value], [value.error], parts)
        else:
            columns[f"{name}.{key}"] = str(value) if value is None else doubles([value], parts)
    return columns


def refused(error: hjsolve.HJSolveError) -> str:
    """What was raised, without a text that a rewording would change."""
    return f"raised {type(error).__name__}"


def states(motion: Any, parts: int) -> Table:
    """Positions, momenta, velocities and angles at some times."""
    columns: Table = {}
    for t in TIMES:
        state = motion.at(t)
        columns[f"status at {t}"] = str(getattr(state, "status", ""))
        for what in ("q", "p", "velocity"):
            for name, value in getattr(state, what).items():
                columns |= numbers(f"{what}.{name} at {t}", [value], [getattr(state.error, what)[name]], parts)
    return columns


def many_states(motion: Any) -> Table:
    """Return the same at many times at once, in doubles."""
    state, columns = motion.at(MANY_TIMES), dict[str, Column]()
    columns["statuses of many"] = " ".join(sorted(set(np.ravel(state.status).tolist())))
    for what in ("q", "p", "velocity"):
        for name, value in getattr(state, what).items():
            columns |= numbers(f"{what}.{name} at many", value, getattr(state.error, what)[name], 1)
    return columns


def of_one(motion: Any, want: tuple[str, ...] | None, parts: int) -> Table:
    """Every column of a single motion, a text where a quantity is refused."""
    columns: Table = {f"kind.{name}": str(kind) for name, kind in motion.kinds.items()}
    readers: dict[str, Any] = {
        name: lambda name=name: estimates(name, getattr(motion, name), parts)
        for name in ("turning_points", *(ESTIMATES if want is None else want))
    }
    if want is None:
        readers["states"] = lambda: states(motion, parts)
        if motion.digits <= 15 and motion.states is None:
            readers["many states"] = lambda: many_states(motion)
        readers["angles"] = lambda: estimates("angles", motion.angles(TIMES[0]), parts)
        readers["W"] = lambda: estimates("W", {TIMES[0]: motion.characteristic_function(TIMES[0])}, parts)
    for name, read in readers.items():
        try:
            columns |= read()
        except hjsolve.HJSolveError as error:
            columns[name] = refused(error)
    return columns


def around(data: Any, motion: Any) -> dict[str, dict[str, np.ndarray]]:
    """Starts of an ensemble around the start of a motion."""
    values, powers = motion.initial.values, np.arange(_ORBITS) - _ORBITS // 2
    system, given = motion.solution.system, {}
    for which, factor in (("q", 1.01), ("p", 1.003)):
        symbols = {c.name: c.symbol if which == "q" else c.momentum for c in system.coordinates}
        given[which] = {n: float(values[s]) * factor**powers for n, s in symbols.items()}
    return given | ({"parameters": dict(data.parameters)} if data.parameters else {})


def of_many(solution: Any, starts: dict[str, Any], want: tuple[str, ...] | None) -> Table:
    """The columns of an ensemble."""
    batch = hjsolve.ensemble(solution, **starts, want=want, threads=1, shown=False)
    return {name: np.asarray(column, dtype=np.float64).reshape(-1, 1) for name, column in batch.columns.items()}


def columns_of(name: str) -> Table:
    """Every column of one entry."""
    table = dict[str, Column]()
    entry = catalog.describe(name)
    try:
        solution = hjsolve.solve(name)
    except hjsolve.HJSolveError as error:
        return {name: refused(error)}
    for family, data in entry.motions.items():
        first = None
        for want in WANTS:
            wanted = "all" if want is None else "+".join(want)
            for method, options in METHODS.items():
                key = f"{name} / {family} / {method} / {wanted}"
                try:
                    motion = solution.motion(**data.arguments, **options, want=want)
                    first = first or motion
                    found = of_one(motion, want, PARTS[method])
                except hjsolve.HJSolveError as error:
                    found = {"": refused(error)}
                table |= {f"{key} / {column}": values for column, values in found.items()}
            key = f"{name} / {family} / ensemble / {wanted}"
            try:
                if first is None:
                    raise hjsolve.InvalidInputError("no motion begins there")
                found = of_many(solution, around(data, first), want)
            except hjsolve.HJSolveError as error:
                found = {"": refused(error)}
            table |= {f"{key} / {column}": values for column, values in found.items()}
    return table


def digest(column: Column) -> str:
    """Sha256 of the bytes of the float64 numbers in little-endian order, or the text itself."""
    if isinstance(column, str):
        return column
    return hashlib.sha256(np.ascontiguousarray(column, dtype="<f8").tobytes()).hexdigest()


def write(path: Path, table: Table) -> None:
    """Write the digests, with the place of each column in the values, and the values next to them."""
    place, flat, index = 0, [], {}
    for name in sorted(table):
        column = table[name]
        shape = () if isinstance(column, str) else column.shape
        index[name] = [digest(column), place, *shape]
        if not isinstance(column, str):
            flat.append(column.ravel())
            place += column.size
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(row)}" for name, row in index.items())
    path.write_text("{\n" + lines + "\n}\n", encoding="utf-8")
    np.savez_compressed(path.with_suffix(".npz"), values=np.concatenate(flat) if flat else np.zeros(0))


def read(path: Path) -> tuple[dict[str, str], Table]:
    """Digests and columns of a file of ``write``."""
    index = json.loads(path.read_text(encoding="utf-8"))
    with np.load(path.with_suffix(".npz")) as file:
        values = file["values"]
    table: Table = {}
    for name, (found, place, *shape) in index.items():
        table[name] = values[place : place + shape[0] * shape[1]].reshape(shape) if shape else found
    return {name: row[0] for name, row in index.items()}, table


def claims_of(name: str, table: Table, length: int) -> list[Any]:
    """The claims that belong to a column; zeros where it has none."""
    key, _, quantity = name.rpartition(" / ")
    found = table.get(f"{key} / error.{quantity}")
    return [mp.mpf(0)] * length if found is None or isinstance(found, str) else [mp.mpf(x) for x in found[:, 0]]


def moved(name: str, old: Table, new: Table) -> tuple[float, str]:
    """How far a column moved, in units of the sum of both claims, and in words."""
    a, b = old[name], new[name]
    if isinstance(a, str) or isinstance(b, str) or a.shape != b.shape:
        shown = [x if isinstance(x, str) else f"numbers {x.shape}" for x in (a, b)]
        return np.inf, f"{shown[0]} -> {shown[1]}"
    worst = mp.mpf(0)
    claims = [claims_of(name, table, len(a)) for table in (old, new)]
    for x, y, first, second in zip(a, b, *claims, strict=True):
        if np.array_equal(x, y, equal_nan=True):
            continue
        difference, claimed = abs(mp.fsum(map(mp.mpf, x)) - mp.fsum(map(mp.mpf, y))), first + second
        finite = mp.isfinite(difference) and mp.isfinite(claimed)
        worst = max(worst, difference / claimed if finite and claimed else mp.inf)
    return float(worst), f"{mp.nstr(worst, 3)} of the sum of the claims"


def compare(old: Path, new: Path) -> int:
    """Print what moved, the largest first, and give how many columns did."""
    (before, first), (after, second) = read(old), read(new)
    both = sorted(before.keys() & after.keys())
    for title, names in (("gone", before.keys() - after.keys()), ("new", after.keys() - before.keys())):
        for name in sorted(names):
            print(f"{title}: {name}")
    changed = [name for name in both if before[name] != after[name]]
    claims = [name for name in changed if name.rpartition(" / ")[2].startswith("error.")]
    with mp.workdps(_PRECISION):
        rows = [(*moved(name, first, second), name) for name in changed if name not in set(claims)]
    for _, words, name in sorted(rows, reverse=True):
        print(f"moved: {name}: {words}")
    for name in claims:
        print(f"claim: {name}: largest {np.nanmax(first[name]):.3g} -> {np.nanmax(second[name]):.3g}")
    false = sum(size > 1 for size, *_ in rows)
    print(f"{len(both) - len(changed)} of {len(both)} columns equal, {len(claims)} claims changed")
    print(f"{len(rows)} columns moved, {false} of them by more than they claim")
    return len(changed) + len(before.keys() ^ after.keys())


def frozen(names: Iterable[str], processes: int) -> Iterator[Table]:
    """The columns of the entries."""
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(columns_of, names)


def main() -> int:
    """Read the command line."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("file", type=Path)
    options.add_argument("--compare", type=Path, metavar="OLD.json")
    options.add_argument("--sample", action="store_true", help=f"the {len(SAMPLE)} entries of SAMPLE only")
    options.add_argument("--only", nargs="+", metavar="ENTRY")
    options.add_argument("--processes", type=int, default=os.cpu_count())
    asked = options.parse_args()
    if asked.compare:
        return int(compare(asked.compare, asked.file) > 0)
    names = asked.only or (SAMPLE if asked.sample else [*catalog.ids("separable"), *catalog.ids("extended")])
    table = {name: column for part in frozen(names, asked.processes) for name, column in part.items()}
    write(asked.file, table)
    print(f"{len(table)} columns of {len(names)} entries in {asked.file}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
