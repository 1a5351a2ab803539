"""Effects of a catalog entry: terms added to T and V when they are called for, and forces that T and V cannot hold."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from hjsolve.catalog import schema
from hjsolve.catalog.toml_file import Toml, TomlTable
from hjsolve.errors import CatalogError
from hjsolve.formulas.read import parse
from hjsolve.mechanics.system import System


def with_effects(table: Toml, names: Sequence[str], source: str) -> TomlTable:
    """Give a table whose T and V have the terms of the effects added; texts, so that what is absent was never parsed.

    Args:
        names: of the effects wanted.
        source: what the entry is called in errors.

    Raises:
        CatalogError: the table declares no such effect.
    """
    known, result = table.get("effects", {}), dict(table)
    for name in dict.fromkeys(names):
        if name not in known:
            raise CatalogError(f'{source}: no effect "{name}"{schema.nearest(name, known)}')
        effect = known[name]
        for term in ("kinetic", "potential"):
            if effect.get(term):
                result[term] = f"{result.get(term, '0')} + ({effect[term]})"
        result["parameters"] = [*result.get("parameters", []), *effect.get("parameters", [])]
        result["title"] = f"{result.get('title', 'system')}, with {name}"
        result["id"] = f"{result.get('id', 'system')}+{name}"
    return result


def forces(table: Toml, names: Sequence[str], system: System, *, source: str) -> dict[str, sp.Expr]:
    """Give the generalized forces Q(q, q̇) that effects bring, by coordinate; those that have none are left out.

    Args:
        names: of its effects.
        system: with these effects.
        source: for errors.

    Raises:
        ExpressionError: a force is not a formula of coordinates, velocities and parameters.
    """
    speeds, total = {c.name: c.velocity for c in system.coordinates}, TomlTable()
    for name in names:
        for coordinate, text in table["effects"][name].get("force", {}).items():
            force = parse(text, system.symbols, velocities=speeds, source=f"{source}: force.{coordinate}")
            total[coordinate] = total.get(coordinate, 0) + force
    return total
