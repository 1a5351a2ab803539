"""Faults of an entry that its schema cannot see: names that must agree, numbers that parse, references.

One line each, ``key: what is wrong``; ``hjsolve.catalog`` puts the file before it.
"""

from __future__ import annotations

from collections.abc import Iterator

from hjsolve.catalog import schema
from hjsolve.catalog.toml_file import Toml
from hjsolve.errors import ExpressionError
from hjsolve.formulas.read import number

_OF_ENERGIES = (
    "kinetic", "potential", "effects", "relativity", "signature", "frame", "functions", "place", "units",
)  # fmt: skip


def motion_faults(where: str, data: Toml, names: list[str], declared: list[str]) -> Iterator[str]:
    """Yield initial data: every coordinate once, velocity or p, numbers that parse, kinds that are known.

    Args:
        where: place of the table in its file, for the messages.
        data: the table of one motion.
        names: of the coordinates.
        declared: names of the parameters.
    """
    if ("velocity" in data) == ("p" in data):
        yield f"{where}: give velocity or p, one of the two"
    for key in ("q", "velocity", "p"):
        given = data.get(key)
        if given is None:
            continue
        yield from schema.unknown(given, names, f"{where}.{key}", "coordinate")
        yield from (f"{where}.{key}.{name}: missing" for name in names if name not in given)
        yield from _numbers(given, f"{where}.{key}")
    yield from schema.unknown(data.get("parameters", {}), declared, f"{where}.parameters", "parameter")
    yield from _numbers(data.get("parameters", {}), f"{where}.parameters")
    for name, kind in data.get("kinds", {}).items():
        yield from schema.unknown([name], names, f"{where}.kinds", "coordinate")
        yield from schema.unknown([kind], schema.KINDS, f"{where}.kinds.{name}", "kind")


def reference_faults(reference: Toml, where: str, names: list[str], motions: set[str]) -> Iterator[str]:
    """Yield the faults of a reference value: unknown quantity, coordinate or motion; time missing or not wanted.

    Args:
        reference: the table of one reference value.
        where: place of the table in its file, for the messages.
        names: of the coordinates.
        motions: names of the motions of the entry.
    """
    quantity, at = str(reference["quantity"]), reference["at"]
    match = schema.QUANTITY.fullmatch(quantity)
    if match is None:
        yield f'{where}.quantity: "{quantity}" is not known; see "quantities" in catalog/README.md'
    else:
        coordinate = match["coordinate"] or match["turning"]
        yield from schema.unknown([coordinate] if coordinate else [], names, f"{where}.quantity", "coordinate")
        timed = quantity.partition(".")[0] in ("q", "p", "velocity")
        if timed != ("t" in at):
            yield f"{where}.at: {'needs' if timed else 'must not have'} a time t"
    if "motion" in at:
        yield from schema.unknown([str(at["motion"])], sorted(motions), f"{where}.at.motion", "motion")
    yield from _numbers({key: value for key, value in at.items() if key != "motion"}, f"{where}.at")
    yield from _numbers({"value": reference["value"]}, where)


def _numbers(table: Toml, where: str) -> Iterator[str]:
    for name, value in table.items():
        try:
            number(value, source=f"{where}.{name}")
        except ExpressionError as error:
            yield " ".join(str(error).split())


def form_faults(table: Toml) -> Iterator[str]:
    """Yield an entry gives T and V, or H(q, p) in their place; then its motions start from momenta."""
    if "hamiltonian" not in table:
        return
    yield from (f"{key}: belongs to T and V; this entry gives H(q, p)" for key in _OF_ENERGIES if key in table)
    motions = {"initial": table.get("initial", {"p": ()})}
    motions |= {f"motions.{name}": data for name, data in table.get("motions", {}).items()}
    without = [where for where, data in motions.items() if "p" not in data]
    yield from (f"{where}: give p, since this entry gives H(q, p)" for where in without)
