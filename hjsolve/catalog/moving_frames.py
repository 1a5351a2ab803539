"""Moving frames of the catalog: the table ``[frame]`` of an entry, read and verified."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

from hjsolve.catalog import loading
from hjsolve.catalog.toml_file import Toml, TomlTable
from hjsolve.errors import CatalogError, InvalidSystemError
from hjsolve.extended.change_of_frame import TIME as TIME
from hjsolve.extended.change_of_frame import carried_initial_data as carried_initial_data
from hjsolve.extended.change_of_frame import drift as drift
from hjsolve.extended.change_of_frame import verified as verified
from hjsolve.extended.moving_frame import Frame as Frame
from hjsolve.formulas.read import parse
from hjsolve.mechanics.system import Parameter, System
from hjsolve.precision import one_at_a_time


@one_at_a_time
def load(entry: str | Path) -> Frame:
    """Read and verify the frame of a catalog entry: the table ``[frame]`` next to the autonomous system.

    Args:
        entry: id, or path of a .toml file.

    Raises:
        CatalogError: no such entry or frame, or a frame that does not do what it says.
    """
    table, source = loading.read(entry)
    if "frame" not in table:
        raise CatalogError(f"{source}: frame: missing; this entry declares no change of frame")
    try:
        return from_table(table, loading.from_table(table, source=source), source)
    except InvalidSystemError as error:
        raise CatalogError(f"{source}: {error}") from error


def of(entry: str | Path) -> Frame | None:
    """Return the frame of a catalog entry; None where it declares none.

    Args:
        entry: id, or path of a .toml file.

    Raises:
        CatalogError: as ``load``.
    """
    table, _ = loading.read(entry)
    return load(entry) if "frame" in table else None


def from_table(table: Toml, system: System, source: str) -> Frame:
    """Build and verify the frame that an entry's table declares for its system.

    Args:
        system: the autonomous one that the entry gives.
        source: what the entry is called in errors.
    """
    given = table["frame"]
    parameters: TomlTable = {p.name: p for p in system.parameters}
    clock = Parameter(TIME, sp.Symbol(TIME, real=True), None, "real", "", "time")
    original = System(
        coordinates={c["name"]: c["domain"] for c in given["coordinates"]}, kinetic=given["kinetic"],
        potential=given.get("potential", "0"), parameters=parameters | {TIME: clock}, title=table.get("title", ""),
    )  # fmt: skip
    time = original.symbols[TIME]
    names = {**system.symbols, TIME: time}
    place = {
        c.name: parse(given["place"].get(c.name, c.name), names, source=f"{source}: frame.place.{c.name}")
        for c in original.coordinates
    }
    gauge = parse(given.get("gauge", "0"), names, source=f"{source}: frame.gauge")
    return verified(Frame(system, original, place, gauge, time))


__all__ = ["Frame", "drift", "from_table", "load", "of", "verified"]
