"""Canonical variables that a user names for a map: old (q, p) with their domains, new (Q, P), parameters, the time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.arguments import ascii_name, described
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.coordinates_and_parameters import read_coordinates
from hjsolve.theorem.phase_space import PhaseSpace, Variables
from hjsolve.theorem.reading import new_names

TIME = sp.Symbol("t", real=True)


def read_variables(
    pairs: object, domains: Mapping[str, str], parameters: object, hamiltonian: sp.Expr = sp.S.Zero
) -> PhaseSpace:
    """Return the phase space of variables that a user names.

    Args:
        pairs: coordinate → its momentum.
        domains: variable → domain; the others are any real numbers.
        parameters: names, or name → domain; empty for none.
        hamiltonian: H in these variables.

    Raises:
        InvalidInputError: no pairs, a name twice, or the domain of what is not a variable.
    """
    if not isinstance(pairs, Mapping) or not pairs:
        raise InvalidInputError(f'coordinates: pairs such as {{"q": "p"}} are needed, not {described(pairs)}')
    momenta = [ascii_name(str(p)) for p in pairs.values()]
    names = [ascii_name(str(q)) for q in pairs]
    if len({*names, *momenta, "t"}) != 2 * len(names) + 1:
        raise InvalidInputError("coordinates: a name is used for two variables, or for the time t")
    if others := set(domains) - {*names, *momenta}:
        raise InvalidInputError(f"domains: {sorted(others)[0]} is not one of {', '.join([*names, *momenta])}")
    declared = [read_coordinates({name: domains.get(name, "line")}, ())[0] for name in [*names, *momenta]]
    own = {c.name: c for c in declared}
    coordinates = tuple(replace(own[q], momentum=own[p].symbol) for q, p in zip(names, momenta, strict=True))
    symbols = {"t": TIME} | {c.name: c.symbol for c in declared}
    constants, ranges = new_names(parameters, symbols, "parameters") if parameters else ({}, {})
    bounds = {c.symbol: (c.domain.lower, c.domain.upper) for c in declared if c.domain.kind != "angle"}
    return PhaseSpace(
        Variables(coordinates), hamiltonian, tuple((c.symbol, c.momentum) for c in coordinates), {},
        symbols | constants, tuple(constants.values()), TIME, bounds | ranges,
    )  # fmt: skip


__all__ = ["TIME", "Variables", "read_variables"]
