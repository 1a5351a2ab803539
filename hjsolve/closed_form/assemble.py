"""From the verified integrals of the coordinates to the equations and numbers of the whole motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.closed_form.anomalies import anomaly_forms
from hjsolve.closed_form.curves import W
from hjsolve.closed_form.elliptic_inverses import in_moduli
from hjsolve.closed_form.energy_from_actions import solved_for_energy
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.inverses import inverse_forms, orbit_formulas, parametric_formulas
from hjsolve.closed_form.involutions import why_no_form
from hjsolve.closed_form.named_quantities import Where
from hjsolve.closed_form.names_of_regime import names_of
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.regime import Regime, positive_in, settled
from hjsolve.closed_form.tidy import LONGEST, elliptic, longer_than, shortened_powers
from hjsolve.closed_form.workshop import Stratum, Workshop
from hjsolve.solution.quadratures import Solution

Integrals = Mapping[str, CoordinateIntegrals]


def assembled(shop: Workshop, pieces: Integrals, made: Regime, special: Stratum) -> RegimeForms:
    """Put the integrals into Jacobi's equations, and the values over cycles into actions and frequencies.

    Args:
        shop: of the solution.
        pieces: separated coordinate → its integrals; those of coordinates without a curve are missing.
        made: the regime.
        special: constant → what it is there.
    """
    solution, why_not = shop.solution, dict[str, str]()
    reasons = {name: why_no_form(own) for name, own in shop.curves.items()}
    time_law = _equation(solution, solution.time_law, shop.constants[0], pieces, special, reasons)
    if isinstance(time_law, str):
        time_law = why_not.setdefault("time_law", time_law) and None
    equations = dict[str, sp.Eq]()
    for name, equation in solution.orbit_equations.items():
        found = _equation(solution, equation, solution.constants[name].symbol, pieces, special, reasons)
        if isinstance(found, str):
            why_not[f"orbit_equations.{name}"] = found
        elif found is not None:
            equations[name] = found
    function = _closed(solution, solution.characteristic_function, W, pieces, special, reasons)
    if isinstance(function, str):
        why_not["characteristic_function"], function = function, None
    where: Where = {symbol: meaning for own in pieces.values() for symbol, meaning in own.where.items()}
    names = names_of(solution, pieces, where)
    numbers = _numbers(shop, pieces, special, made, why_not, where)
    inverse = inverse_forms(shop, pieces, special, why_not, names)
    orbit = orbit_formulas(shop, pieces, special, names)
    parametric = parametric_formulas(shop, pieces, special, names)
    anomaly = anomaly_forms(shop, pieces, names, inverse, why_not)
    energy = solved_for_energy(shop, numbers["actions"], made, why_not)

    def plain(group: Mapping[str, sp.Expr]) -> dict[str, sp.Expr]:
        return {name: settled(made, in_moduli(value, names, of_roots=True)) for name, value in group.items()}

    def relation(equation: sp.Eq) -> sp.Eq:
        return sp.Eq(equation.lhs, settled(made, in_moduli(equation.rhs, names)), evaluate=False)

    form = RegimeForms(
        solution, made, None if time_law is None else relation(time_law),
        {name: relation(equation) for name, equation in equations.items()},
        None if function is None else settled(made, in_moduli(function, names)), _turning_points(pieces, made),
        plain(numbers["periods"]), plain(numbers["actions"]), plain(numbers["frequencies"]),
        plain(numbers["mean_velocities"]), plain(inverse), plain(orbit), plain(parametric), plain(anomaly), energy,
        where, why_not,
    )  # fmt: skip
    for symbol in set(where) - names.roots:
        if symbol.name.startswith("Omega_"):
            where[symbol] = in_moduli(sp.sympify(where[symbol]), names, of_roots=True)
    where = names.kept(form.named().values(), lambda e: settled(made, shortened_powers(e)))
    return replace(form, where=where)


def _equation(
    solution: Solution, equation: sp.Eq | None, key: sp.Symbol, pieces: Integrals, special: Stratum,
    reasons: Mapping[str, str],
) -> sp.Eq | str | None:  # fmt: skip
    if equation is None:
        return None
    right = _closed(solution, equation.rhs, key, pieces, special, reasons)
    return right if isinstance(right, str) else sp.Eq(equation.lhs, right, evaluate=False)


def _closed(
    solution: Solution, expression: sp.Expr, key: sp.Symbol, pieces: Integrals, special: Stratum,
    reasons: Mapping[str, str],
) -> sp.Expr | str:  # fmt: skip
    """An expression with its integrals replaced; the reason where one has no form."""
    table = dict[sp.Expr, sp.Expr]()
    for integral in sorted(expression.atoms(sp.Integral), key=sp.default_sort_key):
        q, start, end = integral.limits[0]
        name = next(n for n in solution.coordinates if solution.system.coordinate(n).symbol == q)
        own = pieces.get(name)
        if own is None:
            return f"{name}: {reasons.get(name, 'its momentum enters H to first degree')}"
        if key in own.integrals:
            value = shortened_powers(own.integrals[key].value)
            table[integral] = value.xreplace({q: end}) - value.xreplace({q: start})
        elif integral.function.subs(dict(special)) == 0:
            table[integral] = sp.S.Zero
        else:
            return f"{name}: {own.why_not.get(key, 'no form was found')}"
    return expression.xreplace(table).xreplace(dict(special))


def _numbers(
    shop: Workshop, pieces: Integrals, special: Stratum, made: Regime, why_not: dict[str, str], where: Where
) -> dict[str, dict[str, sp.Expr]]:  # fmt: skip
    """Actions, frequencies, periods and mean velocities, where they exist; long frequencies are named in ``where``."""
    solution = shop.solution
    actions, frequencies, velocities = dict[str, sp.Expr](), dict[str, sp.Expr](), dict[str, sp.Expr]()
    cyclic = [n for n in solution.coordinates if n in pieces and pieces[n].kind in ("libration", "rotation")]
    for c in solution.system.coordinates:
        if c.name in cyclic:
            J = _cycle(pieces[c.name], W)
            if pieces[c.name].kind == "rotation" and not isinstance(J, str):
                J = _without_shift(J, solution.shift[c.name].subs(dict(special)), c.symbol)
            if isinstance(J, str):
                why_not[f"actions.{c.name}"] = J
            else:
                actions[c.name] = shortened_powers(J / (2 * sp.pi) if elliptic(J) else sp.expand(J / (2 * sp.pi)))
        elif c.name not in solution.coordinates and c.domain.kind == "angle":
            actions[c.name] = c.momentum.subs(dict(special))
    if len(cyclic) == len(solution.coordinates) and solution.coordinates:
        _rates(shop, pieces, frequencies, velocities, why_not)
    elif not solution.coordinates:
        for c in solution.system.coordinates:
            rate = sp.diff(solution.separation.shell.potential, c.momentum)
            (frequencies if c.domain.kind == "angle" else velocities)[c.name] = rate
    periods = {
        name: shortened_powers(2 * sp.pi / _size(name, rate, pieces.get(name), made, where))
        for name, rate in frequencies.items()
    }
    return {
        "actions": actions, "frequencies": frequencies, "mean_velocities": velocities,
        "periods": {name: value for name, value in periods.items() if not value.has(sp.zoo)},
    }  # fmt: skip


def _without_shift(cycle: sp.Expr, shift: sp.Expr, q: sp.Symbol) -> sp.Expr | str:
    """∮ (P − A) dq over a turn, of a trigonometric polynomial A(q); why not, of any other."""
    z = sp.Dummy("z")
    laurent = sp.expand(sp.expand(shift.rewrite(sp.exp)).subs(q, sp.log(z) / sp.I))
    terms = sp.Add.make_args(sp.expand(sp.powsimp(laurent)))
    if any(not term.as_independent(z)[1].as_base_exp()[1].is_Integer for term in terms):
        return "the mean of A in p = P − A over a turn has no form here"
    return cycle - 2 * sp.pi * sp.Add(*(term for term in terms if not term.has(z)))


def _turning_points(pieces: Integrals, made: Regime) -> dict[str, tuple[sp.Expr | None, sp.Expr | None]]:
    """The roots of P between which each coordinate moves, as places q."""
    found = dict[str, tuple[sp.Expr | None, sp.Expr | None]]()
    for name, own in pieces.items():
        if not own.regions or own.roots is None:
            continue
        (curve, region), roots = own.regions[0], own.roots
        s = curve.substitution
        ends = [
            settled(made, shortened_powers(s.inverse.subs(s.x, roots[k]))) if what == "root" else None
            for what, k in (region.lower, region.upper)
        ]
        if any(end is not None for end in ends):
            low, high = ends if s.increasing else reversed(ends)
            found[name] = (low, high)
    return found


def _cofactor(M: list[list[sp.Expr]], row: int) -> sp.Expr:
    """The cofactor of a row and the first column, written as it stands: no zero test, nothing multiplied out."""
    rest = [line[1:] for k, line in enumerate(M) if k != row]
    value = sp.Add(*(line[0] * _cofactor(rest, k) for k, line in enumerate(rest))) if rest else sp.S.One
    return -value if row % 2 else value


def _size(name: str, rate: sp.Expr, own: CoordinateIntegrals | None, made: Regime, where: Where) -> sp.Expr:
    """|Ω|: a separated coordinate's is positive on the branch p > 0; of a long formula by a name."""
    if own is not None:
        return rate
    if longer_than(rate, LONGEST):
        symbol = sp.Symbol(f"Omega_{name}", real=True)
        where[symbol] = rate
        return sp.Abs(symbol)
    if rate.is_positive:
        return rate
    plain = sp.Mul(*(f for f in sp.Mul.make_args(rate) if not isinstance(f, sp.sign)))
    return plain if positive_in(made, plain) else sp.Abs(rate)


def _cycle(own: CoordinateIntegrals, key: sp.Symbol) -> sp.Expr | str:
    """∮ N dq/P over a full cycle, or why there is no form."""
    if key in own.why_not:
        return own.why_not[key]
    if key not in own.integrals:
        return sp.S.Zero
    cycle = own.integrals[key].cycle
    return "no form of the complete integral" if cycle is None else cycle


def _rates(
    shop: Workshop, pieces: Integrals, frequencies: dict[str, sp.Expr], velocities: dict[str, sp.Expr],
    why_not: dict[str, str],
) -> None:  # fmt: skip
    """Ω = ∂E/∂J from 2π ∂J/∂c = ∮ ∂p/∂c dq, by inverting the matrix of the separated coordinates."""
    solution, names = shop.solution, list(shop.solution.coordinates)
    ignorable = {c.momentum: c for c in solution.separation.shell.ignorable}
    inner = [c for c in shop.constants if c not in ignorable]
    rows = [[_cycle(pieces[name], c) for c in inner] for name in names]
    missing = next((f"{n}: {x}" for n, row in zip(names, rows, strict=True) for x in row if isinstance(x, str)), None)
    if missing is not None:
        for name in (*names, *(c.name for c in ignorable.values() if c.domain.kind == "angle")):
            why_not[f"frequencies.{name}"] = why_not[f"periods.{name}"] = missing
        return
    M = [[value / (2 * sp.pi) for value in row] for row in rows]
    cofactors = [_cofactor(M, i) for i in range(len(names))]
    determinant = sp.Add(*(row[0] * cofactor for row, cofactor in zip(M, cofactors, strict=True)))
    top = [cofactor / determinant for cofactor in cofactors]
    if len(names) > 1:
        top = [value if elliptic(value) else sp.cancel(sp.together(value)) for value in top]
    Ω = {name: shortened_powers(value) for name, value in zip(names, top, strict=True)}
    for c in solution.system.coordinates:
        if c.name in Ω:
            frequencies[c.name] = Ω[c.name]
            continue
        parts = [_cycle(pieces[name], c.momentum) for name in names]
        missing = next((f"{n}: {x}" for n, x in zip(names, parts, strict=True) if isinstance(x, str)), None)
        if missing is not None:
            for group in ("frequencies", "periods"):
                why_not[f"{group}.{c.name}"] = missing
            continue
        rate = shortened_powers(sp.Add(*(-Ω[n] * part / (2 * sp.pi) for n, part in zip(names, parts, strict=True))))
        (frequencies if c.domain.kind == "angle" else velocities)[c.name] = rate if elliptic(rate) else sp.factor(rate)
