"""The shape of a scene file: which keys there are, and one line for every fault. Data; it knows no mechanics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from hjsolve import arguments
from hjsolve.catalog import schema, toml_file
from hjsolve.catalog.schema import Key
from hjsolve.catalog.toml_file import Toml
from hjsolve.display.first_lines import MOST_LINES
from hjsolve.errors import CatalogError
from hjsolve.motion.velocity_frame import COORDINATE, ORTHONORMAL
from hjsolve.scenes.initial_grid import STATE, sweep_faults

METHODS = ("quadratures", "integrate")
COORDINATES = ("as given", "find")
WANTED = (
    "constants", "kinds", "turning_points", "actions", "periods", "frequencies", "mean_velocities", "angles",
    "boundary_times", "orbit", "trajectory",
)  # fmt: skip
_TEXT, _NUMBERS = Key("text"), Key("numbers")
_EVENT = {
    "kind": Key("text", True, choices=("impulse", "wall", "impact")), "at": Key("table", True, keys={
        "t": Key("number"), "coordinate": _TEXT, "value": Key("number"), "passage": Key("number"), "surface": _TEXT}),
    "momentum": _NUMBERS, "velocity": _NUMBERS, "restitution": Key("number"), "surface": _TEXT, "name": _TEXT,
    "constraints": Key("texts"), "lasts": Key("flag"),
}  # fmt: skip
_TIMES = {"start": Key("number", True), "stop": Key("number", True), "count": Key("number", True)}
SCENE = {
    "title": _TEXT, "summary": _TEXT, "effects": Key("texts"), "parameters": _NUMBERS, "motion": _TEXT,
    "initial": Key("table", keys={"q": Key("numbers", True), "velocity": _NUMBERS, "p": _NUMBERS, "t": Key("number")}),
    "want": Key("texts"), "method": Key("text", choices=METHODS), "coordinates": Key("text", choices=COORDINATES),
    "velocity_frame": Key("text", choices=(COORDINATE, ORTHONORMAL)),
    "accuracy": Key("table", keys={"digits": Key("number"), "seconds": Key("number")}),
    "orbit": Key("table", keys={"of": Key("text", True), "along": Key("text", True)}),
    "events": Key("tables", keys=_EVENT),
}  # fmt: skip
"""The keys of a scene, but for ``system``, ``times``, ``sweep`` and ``orbit.values``, which may be of several types."""
LONGEST = 10_000_000
MOST_PASSAGES = 100_000


def is_scene(file: str | Path) -> bool:
    """Return whether a file is a scene's and not an entry's: it has keys that no entry has.

    Args:
        file: its path, or the id of an entry.
    """
    if not str(file).endswith(".toml"):
        return False
    try:
        table = toml_file.exact_table(Path(file), str(file))
    except CatalogError:
        return False  # the reader of entries says what is wrong with the file
    return not {"system", "want", "times", "events"}.isdisjoint(table)


def scene_faults(table: Toml) -> Iterator[str]:
    """List where a scene does not have the required shape, one line each.

    Args:
        table: the file as it was read.
    """
    plain = {key: value for key, value in table.items() if key not in ("system", "times", "sweep")}
    keys = {**SCENE, "system": _TEXT, "times": _TEXT, "sweep": _TEXT}
    if isinstance(orbit := plain.get("orbit"), Mapping) and "values" in orbit:
        plain["orbit"] = {key: value for key, value in orbit.items() if key != "values"}
        yield from _list_faults(orbit["values"], "orbit.values")
    surfaces = {k for k, e in enumerate(_events(plain), start=1) if "surface" in e and "at" not in e}
    follows = tuple(f"events[{k}].at: missing" for k in surfaces)  # it stands at its surface: that is the fault
    yield from (fault for fault in schema.faults(plain, keys) if not fault.startswith(follows))
    yield from _system_faults(table)
    if "sweep" in table:
        yield from sweep_faults(table["sweep"], table)
    if "times" in table:
        yield from _time_faults(table["times"])
    if isinstance(want := table.get("want"), list):
        known = {*WANTED, *([STATE] if "sweep" in table else [])}
        others = [word for word in want if isinstance(word, str) and word not in known]
        for count, word in enumerate(others):
            yield f'want: "{word}" is not known{schema.nearest(word, WANTED) if count < MOST_LINES else ""}'
    accuracy = table.get("accuracy")
    digits = accuracy.get("digits") if isinstance(accuracy, Mapping) else None
    if isinstance(accuracy, Mapping) and ("digits" in accuracy) == ("seconds" in accuracy):
        yield "accuracy: give digits or seconds, one of the two: {digits = 30}, or {seconds = 5}"
    if digits is not None and (not isinstance(digits, int) or isinstance(digits, bool) or not 1 <= digits <= 500):
        yield f"accuracy.digits: must be a whole number from 1 to 500, not {arguments.described(digits)}"
    if isinstance(events := table.get("events"), list):
        for place, event in enumerate(events, start=1):
            if isinstance(event, Mapping):
                yield from _event_faults(event, f"events[{place}]")


def _events(table: Toml) -> list[Toml]:
    events = table.get("events")
    return [e if isinstance(e, Mapping) else {} for e in events] if isinstance(events, list) else []


def _system_faults(table: Toml) -> Iterator[str]:
    system = table.get("system")
    if system is None:
        yield "system: missing; write a catalog id, the path of a .toml file, or a table [system]"
    elif isinstance(system, Mapping):
        effects = Key("named", keys=schema.ENTRY["effects"].keys)
        keys = {**schema.SYSTEM, "effects": effects}
        yield from schema.faults(system, keys, "system")
    elif not isinstance(system, str):
        yield f"system: must be a catalog id, the path of a .toml file, or a table, not {system!r:.40}"


def _time_faults(times: object) -> Iterator[str]:
    if isinstance(times, list):
        yield from _list_faults(times, "times")
    elif isinstance(times, Mapping):
        yield from schema.faults(times, _TIMES, "times")
        count = times.get("count")
        if count is not None and (not isinstance(count, int) or isinstance(count, bool) or not 2 <= count <= LONGEST):
            yield f"times.count: must be a whole number from 2 to {LONGEST}, not {arguments.described(count)}"
    else:
        yield "times: must be a list of times, or {start = …, stop = …, count = …}"


def _list_faults(values: object, where: str) -> Iterator[str]:
    if not isinstance(values, list) or not values:
        yield f"{where}: must be a list of numbers, and not empty"
        return
    for place, value in enumerate(values, start=1):
        if isinstance(value, (bool, list, dict)):
            yield f'{where}[{place}]: must be a number, best as a text such as "1.2", not {value!r:.40}'


def _event_faults(event: Toml, where: str) -> Iterator[str]:
    yield from _at_faults(event, where)
    if event.get("kind") == "impulse":
        if ("momentum" in event) == ("velocity" in event):
            yield f"{where}: an impulse gives momentum or velocity, the jump of one of the two"
        yield from (f"{where}.{key}: belongs to a wall" for key in ("restitution", "surface") if key in event)
    elif event.get("kind") == "wall":
        yield from _wall_faults(event, where)
    elif event.get("kind") == "impact":
        yield from _impact_faults(event, where)
    if event.get("kind") in ("impulse", "wall"):
        yield from (f'{where}.{key}: belongs to kind = "impact"' for key in ("constraints", "lasts") if key in event)


def _at_faults(event: Toml, where: str) -> Iterator[str]:
    at = event.get("at")
    if isinstance(at, Mapping):
        if "surface" in at and event.get("kind") == "impact":
            if len(at) > 1:
                yield f"{where}.at: a surface alone says where; leave the other keys out"
        elif "surface" in at:
            yield f"{where}.at.surface: belongs to an impact; an impulse or a wall stands at a coordinate and its value"
        elif ("t" in at) == ("coordinate" in at):
            yield f"{where}.at: give a time t, or a coordinate with its value"
        elif ("coordinate" in at) != ("value" in at):
            yield f"{where}.at: coordinate and value belong together"
        passage = at.get("passage")
        whole = isinstance(passage, int) and not isinstance(passage, bool)
        if passage is not None and not (whole and 0 <= passage <= MOST_PASSAGES):
            which = f"0 for the first passage after the start, 1 for the next, {MOST_PASSAGES} at most"
            yield f"{where}.at.passage: must be {which}, not {passage}"
        if passage is not None and "coordinate" not in at:
            yield f"{where}.at.passage: belongs to a coordinate and its value; at a time t there is one event"


def _impact_faults(event: Toml, where: str) -> Iterator[str]:
    at = event.get("at")
    others = ("momentum", "velocity", "surface")
    yield from (f"{where}.{key}: an impact says its constraints, not the jump" for key in others if key in event)
    if not event.get("constraints") and not (isinstance(at, Mapping) and "surface" in at):
        yield f'{where}.constraints: missing; write what holds just after, such as ["dot(y) = 0"]'
    if event.get("lasts") and event.get("restitution", 0) not in (0, "0"):
        yield f"{where}.restitution: a constraint that lasts keeps what meets it; leave restitution or lasts out"


def _wall_faults(event: Toml, where: str) -> Iterator[str]:
    at = event.get("at")
    if isinstance(at, Mapping) and ("t" in at or "passage" in at):
        yield f"{where}.at: a wall stands at a coordinate and its value, at all times"
    yield from (f"{where}.{key}: belongs to an impulse" for key in ("momentum", "velocity") if key in event)
    if "surface" in event:
        yield (
            f"{where}.surface: only walls at a coordinate surface, coordinate = value, can be treated: an oblique wall "
            "mixes the separated momenta; choose coordinates in which the wall is such a surface"
        )
