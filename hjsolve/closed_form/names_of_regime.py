"""The names of a regime's quantities: what has a meaning already, and on which symbols coordinates depend."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.closed_form.carlson import CarlsonMap
from hjsolve.closed_form.elliptic_inverses import modulus
from hjsolve.closed_form.jacobi_equations import anomaly_of, common_parameter, time_of
from hjsolve.closed_form.named_quantities import SHORT, NamedQuantities, Where, without_sign
from hjsolve.closed_form.pieces import CoordinateIntegrals, PieceIntegral
from hjsolve.closed_form.tidy import shortened_powers
from hjsolve.closed_form.verification import sample_numbers, sample_place
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
    # no quantity may have the name of what the user wrote, nor of the actions in E(J)
    taken = {s.name for s in held} | {f"J_{c.name}" for c in coordinates}
    separated = {solution.system.coordinate(n).symbol for n in solution.coordinates}
    variables = {τ, *time_of(solution), *(c.symbol for c in coordinates if c.symbol not in separated)}
    numbers = {s: value for own in pieces.values() for s, value in sample_numbers(own).items()}
    made = NamedQuantities(taken, variables, separated, where, numbers)
    for name, own in pieces.items():
        for symbol in (solution.system.coordinate(name).symbol, solution.lower_limits[name]):
            made.located[symbol] = sample_place(own)
    return made


def in_named_rates(
    solution: Solution, pieces: Mapping[str, CoordinateIntegrals], names: NamedQuantities
) -> dict[str, CoordinateIntegrals]:  # fmt: skip
    """Return the integrals of a regime with the modulus k and the rate of the argument by their names.

    The rate is that of sn u, u = ω (t − t_p), where the time is an integral of the first kind over the coordinate, or
    else of another constant's, so that factors of such integrals need not be written.

    Args:
        solution: of which they are forms.
        pieces: separated coordinate → its integrals.
        names: of the quantities of the forms.
    """
    constants = [c.symbol for c in solution.constants.values()]
    return {name: _renamed(own, constants, names) for name, own in pieces.items()}


def _renamed(own: CoordinateIntegrals, constants: list[sp.Symbol], names: NamedQuantities) -> CoordinateIntegrals:
    table = dict[sp.Expr, sp.Expr]()
    for integral in own.integrals.values():
        change = integral.change
        if change is None or isinstance(change, CarlsonMap) or change.k in table:
            continue
        same = [key for key in constants if key in own.integrals and own.integrals[key].change is change]
        # of the time where it can be: sn(ω(t − t_p)); else of the first constant with an integral of the first kind
        first = next((key for key in same if own.integrals[key].first is not None), None)
        size, _ = without_sign(sp.factor_terms(own.integrals[first].first)) if first is not None else (sp.S.One, 1)
        Ω = sp.sqrt(names.oriented(sp.factor(change.Ω**2)))
        letter = "omega" if first == constants[0] else "kappa"
        table[change.k] = modulus(names, change.m)
        table[change.rate] = size * names.named(letter, shortened_powers(Ω / size), short=SHORT, positive=True)
    if not table:
        return own
    held = {s for e in table.values() for s in e.free_symbols}
    rates = {s: sp.sympify(names.where[s]) for s in names.where if s in held and s not in names.roots}
    names.rates |= rates
    integrals = {key: _written(integral, table) for key, integral in own.integrals.items()}
    made = replace(own, integrals=integrals, rates=rates)
    names.numbers |= {s: v for s, v in sample_numbers(made).items() if s in rates}
    return made


def _written(integral: PieceIntegral, table: Mapping[sp.Expr, sp.Expr]) -> PieceIntegral:
    cycle, change = integral.cycle, integral.change
    if change is not None and not isinstance(change, CarlsonMap):
        change = replace(change, k=table[change.k], rate=table[change.rate])
    return replace(
        integral, value=shortened_powers(integral.value.xreplace(table)), change=change,
        cycle=None if cycle is None else shortened_powers(cycle.xreplace(table)),
    )  # fmt: skip
