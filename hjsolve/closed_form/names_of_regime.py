"""The names of a regime's quantities: what has a meaning already, and on which symbols coordinates depend."""

from __future__ import annotations

from collections.abc import Mapping

from hjsolve.closed_form.anomalies import anomaly_of
from hjsolve.closed_form.inverses import common_parameter, time_of
from hjsolve.closed_form.named_quantities import NamedQuantities, Where
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.verification import sample_numbers
from hjsolve.solution.quadratures import Solution


def names_of(solution: Solution, pieces: Mapping[str, CoordinateIntegrals], where: Where) -> NamedQuantities:
    """Prepare the names of the forms of one regime.

    Args:
        solution: of which they are forms.
        pieces: separated coordinate → its integrals.
        where: the definitions of roots; new ones are added.
    """
    equations = [e for e in (solution.time_law, *solution.orbit_equations.values()) if e is not None]
    coordinates, τ = solution.system.coordinates, common_parameter(solution)
    held = {s for e in (*equations, solution.characteristic_function) for s in e.free_symbols}
    held |= {p.symbol for p in solution.system.parameters} | {s for c in coordinates for s in (c.symbol, c.momentum)}
    held |= {τ, anomaly_of(solution), *solution.lower_limits.values(), *(c.symbol for c in solution.constants.values())}
    taken = {s.name for s in held} | {f"J_{c.name}" for c in coordinates}
    separated = {solution.system.coordinate(n).symbol for n in solution.coordinates}
    variables = {τ, *time_of(solution), *(c.symbol for c in coordinates if c.symbol not in separated)}
    numbers = {s: value for own in pieces.values() for s, value in sample_numbers(own).items()}
    return NamedQuantities(taken, variables, separated, where, numbers)
