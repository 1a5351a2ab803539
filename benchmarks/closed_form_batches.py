"""Closed forms in doubles, thousands of random motions of each regime at once, against computations of another kind.

    python -m benchmarks.closed_form_batches [--motions 2000] [--seed 7] [--seconds 60] [--each] [ENTRY …]

Numbers of cycles (J, Ω, periods, turning points) are compared with those of the engine of ensembles, which integrates
numerically and bounds its errors; the time law, −β and W with a quadrature of N/√P² between two places; q(t), r(θ) and
the parametric pair lead to where that quadrature ends, E(J) back to E. What is allowed is what the other side claims,
what the errors of the constants do, and ``FAR`` units of the last place times the condition of the form. What differs
by more is worked out again from the form in many digits: where that agrees with the other side, the form only loses
digits in doubles (``beyond``); else it is a fault. ``closed_form_campaign`` compares to 40 digits, and fewer motions.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, islice

import numpy as np
import sympy as sp
from numpy.typing import NDArray

import hjsolve
from benchmarks.closed_form_comparisons import FAR, Met, compare, condition, in_many_digits, taken
from benchmarks.closed_form_draws import Draws, Reals, Seeds, Table, constants_of, ends_of, exact, ignorable
from benchmarks.closed_form_quadratures import ULP, Quadratures
from hjsolve.closed_form.closed_forms import closed_forms
from hjsolve.closed_form.curves import W
from hjsolve.closed_form.derive import form_of_sample, special_of
from hjsolve.closed_form.form_context import FormContext, context_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.sampling import Sample
from hjsolve.closed_form.time_limit import within_seconds
from hjsolve.functions import modules
from hjsolve.motion.rational_values import rational_value
from hjsolve.solution.quadratures import Solution

DRAWN = 4096
"""Motions drawn at once, by their constants."""
BLOCKS = 16
"""Times that, at most, for a set: what is met once in 60 000 motions is left to motions about known ones."""
FEWEST_SETS = 4
"""Sets of parameters, at least, that the motions of a regime have."""
DRAWS = 200
"""Draws at most."""
IDLE = 4
"""Sets of parameters without a motion that is wanted, after which the rest are not drawn."""
MOST = 24
"""Regimes of an entry that are told apart."""
UNKNOWN = 3
"""Motions without a regime of each draw that one is derived for."""
CYCLES = ("periods.", "actions.", "frequencies.", "turning_points.")
_DERIVED = 40.0
"""Seconds for the forms of a regime that is met."""
_STEP = 1e-6
"""Of ξ, by which the rate of the time by the place is worked out."""
_FIRST = 1.5
"""Of an anomaly up to which q grows: below K(k) ≥ π/2, and π of an ellipse."""


def forms_of(solution: Solution) -> list[RegimeForms]:
    """Return the forms whose constants doubles can have: of general constants, or with p_θ = 0.

    Args:
        solution: what is solved.
    """
    ignored = {solution.constants[f"p_{n}"].symbol for n in ignorable(solution) if f"p_{n}" in solution.constants}
    zero = dict.fromkeys(ignored, sp.S.Zero)
    return [form for form in closed_forms(solution) if form.regime.special.items() <= zero.items()]


def campaign(
    solution: Solution, forms: Sequence[RegimeForms], motions: int, seed: int, seconds: float
) -> Iterator[Met]:
    """Yield every regime that was met, as soon as it has its motions, with its forms compared at them.

    Args:
        solution: what is solved.
        forms: that are known; of other regimes that are met they are derived.
        motions: how many of each regime.
        seed: of the draw.
        seconds: of the processor after which no further parameters are drawn.
    """
    context, dice, begin = context_of(solution), np.random.default_rng(seed), time.process_time()
    met, draws, quadrature, idle = [Met(form, context) for form in forms], Draws(solution), Quadratures(context), 0
    for k in range(DRAWS):
        over = time.process_time() - begin > seconds or all(own.motions >= motions for own in met)
        if k and (over or idle >= IDLE):
            break
        known = sum(own.motions for own in met)
        about = _wanted(met, motions) if k % 3 else None
        values = draws.parameters(dice, k, about)
        own_part = -(-motions // FEWEST_SETS)
        chosen = _chosen(met, context, draws, values, about, {"of a set": own_part, "in all": motions}, dice)
        if not chosen:
            idle += 1
            continue
        ends = np.cumsum([0, *(len(next(iter(one.momenta.values()))) for one in chosen)])
        table, momenta = (
            {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}
            for parts in ([one.table for one in chosen], [one.momenta for one in chosen])
        )
        followed = draws.followed(values, table, momenta)
        if followed is None:
            continue
        for one, first, last in zip(chosen, ends, ends[1:], strict=False):
            there, columns = ({n: v[first:last] for n, v in part.items()} for part in followed)
            _compared(one.own, one.turn, there, columns, quadrature, dice)
            if one.own.motions >= motions:  # with its last motions: no more are chosen
                yield one.own
        idle = 0 if sum(own.motions for own in met) > known else idle + 1
    yield from (own for own in met if 0 < own.motions < motions)


@dataclass
class Chosen:
    """Motions of one regime, of one set of parameters.

    Attributes:
        own: the regime.
        turn: which of ``_turns`` its forms hold for.
        table: of the motions.
        momenta: likewise.
    """

    own: Met
    turn: int
    table: Table
    momenta: Table


def _chosen(
    met: list[Met], context: FormContext, draws: Draws, values: Mapping[str, float], about: Seeds | None,
    most: Mapping[str, int], dice: np.random.Generator,
) -> list[Chosen]:  # fmt: skip
    """Draw motions by their constants alone, until every regime has what a set gives: the engine costs 100 times more.

    Args:
        met: the regimes, to which new ones are added.
        context: of the solution.
        draws: of the solution.
        values: of the parameters.
        about: motions of a regime that is wanted; None for any.
        most: motions of a regime of a set, and in all.
        dice: random numbers.
    """
    solution, found, count = context.solution, list[Chosen](), Counter[int]()
    for block in range(BLOCKS):
        wanted = [own for own in met if count[id(own)] < min(most["of a set"], most["in all"] - own.motions)]
        if block and not wanted:
            break
        table, momenta = draws.motions(dice, values, DRAWN, about)
        left = np.all([np.isfinite(table[c.name]) for c in constants_of(solution)], axis=0)
        for own in wanted if block else _with_others(met, context, table, left):
            for turn, (there, _) in enumerate(_turns(solution, table, {})):
                kept = np.flatnonzero(left)
                kept = kept[np.isfinite(_inside(own, taken(there, kept)))] if len(kept) else kept
                left[kept] = False
                kept = kept[: max(0, min(most["of a set"], most["in all"] - own.motions) - count[id(own)])]
                count[id(own)] += len(kept)
                if len(kept):
                    found.append(Chosen(own, turn, taken(table, kept), taken(momenta, kept)))
    found.sort(key=lambda one: (id(one.own), one.turn))
    return [_joined([*group]) for _, group in groupby(found, key=lambda one: (id(one.own), one.turn))]


def _joined(parts: Sequence[Chosen]) -> Chosen:
    """Return the motions of several blocks as one table: what is compared costs as much for ten as for hundreds."""
    table = {n: np.concatenate([one.table[n] for one in parts]) for n in parts[0].table}
    momenta = {n: np.concatenate([one.momenta[n] for one in parts]) for n in parts[0].momenta}
    return Chosen(parts[0].own, parts[0].turn, table, momenta)


def _compared(
    own: Met, turn: int, table: Table, others: Table, quadrature: Quadratures, dice: np.random.Generator
) -> None:  # fmt: skip
    """Compare all forms of a regime at motions that the engine integrated."""
    solution = own.form.solution
    table, others = next(islice(_turns(solution, table, others), turn, None))
    # constants by the engine are those of the formulas to a rounding, and none where it refuses a motion
    left = np.all([np.isfinite(table[c.name]) for c in constants_of(solution)], axis=0)
    kept = np.flatnonzero(left)
    kept = kept[np.isfinite(_inside(own, taken(table, kept)))] if len(kept) else kept
    if not len(kept):
        return
    own.motions += len(kept)
    table, others = taken(table, kept), {n: v[kept] for n, v in others.items()}
    special = frozenset(constant.name for constant in own.form.regime.special)
    own.seeds = Seeds.of(solution, others, table, special).joined(own.seeds, dice)
    own.constants.append({c.name: table[c.name] for c in constants_of(solution)})
    _cycles(own, table, others, quadrature)
    if solution.coordinates:
        _antiderivatives(own, table, others, quadrature, dice)


def _wanted(met: Sequence[Met], motions: int) -> Seeds | None:
    """Motions of the regime that fewest are known of, if one is known at all."""
    few = [own for own in met if own.seeds is not None and own.motions < motions]
    return min(few, key=lambda own: own.motions).seeds if few else None


def _turns(solution: Solution, table: Table, others: Table) -> Iterator[tuple[Table, Table]]:
    """Yield the motions as they are drawn, and with negative angles a turn further: forms hold for one turn each."""
    yield table, others
    for name in solution.coordinates:
        if solution.system.coordinate(name).domain.kind == "angle":
            turn = np.where(table[name] < 0, 2 * np.pi, 0.0)
            ends = {f"turning_points.{name}.{side}" for side in ("lower", "upper")} & others.keys()
            yield {**table, name: table[name] + turn}, {**others, **{n: others[n] + turn for n in ends}}


def _inside(own: Met, table: Table) -> Reals:
    found = np.broadcast_to(own.inside(**{n: table[n] for n in own.inside.names}), np.shape(next(iter(table.values()))))  # type: ignore[attr-defined]
    own_zero = [table[constant.name] == 0 for constant in own.form.regime.special]
    return np.where(np.all(own_zero, axis=0), found, np.nan) if own_zero else found


def _with_others(met: list[Met], context: FormContext, table: Table, left: NDArray[np.bool_]) -> Iterator[Met]:
    """Yield the regimes known, and those of motions that are of none of them."""
    yield from list(met)
    for _ in range(UNKNOWN):
        unknown = np.flatnonzero(left)
        if not len(unknown) or len(met) >= MOST:
            return
        sample, left[unknown[0]] = _sample(context.solution, table, int(unknown[0])), False
        if dict(special_of(context, sample.values)):
            continue
        with within_seconds(_DERIVED):
            form = form_of_sample(context, context.curves, {}, sample)
        if form is not None and form.named():
            met.append(Met(form, context))
            left[unknown[0]] = True
            yield met[-1]
            left[unknown[0]] = False


def _sample(solution: Solution, table: Table, k: int) -> Sample:
    """One motion by exact numbers."""
    system = solution.system
    values = {s: exact(table[s.name][k]) for s in (*(p.symbol for p in system.parameters), *constants_of(solution))}
    return Sample(values, {name: exact(table[name][k]) for name in solution.coordinates})


def _cycles(own: Met, table: Table, others: Table, quadrature: Quadratures) -> None:
    """J, Ω, periods and turning points against the engine of ensembles."""
    _without_the_engine(own, table, others, quadrature)
    solution = own.form.solution
    errors = {s.name: others[f"error.constants.{s.name}"] for s in constants_of(solution)}

    def right(name: str) -> Callable[[int], float]:
        def there(k: int) -> float:
            system = solution.system
            phase = {p.symbol: exact(table[p.name][k]) for p in system.parameters}
            for c in system.coordinates:
                phase |= {c.symbol: exact(others[f"q.{c.name}"][k]), c.momentum: exact(others[f"p.{c.name}"][k])}
            numbers = {p.name: phase[p.symbol] for p in system.parameters}
            for n, c in solution.constants.items():
                value = rational_value(c.expression, phase)
                numbers[n] = sp.Rational(str(sp.N(c.expression.xreplace(phase), 60))) if value is None else value
            return in_many_digits(own.form, name, numbers)

        return there

    for name in own.functions:
        if name.startswith(CYCLES) and name in others:
            other = others[name]
            if name.startswith("turning_points.") and name.split(".")[1] in own.angles:  # of any turn
                other = other + 2 * np.pi * np.round((own.at(name, table) - other) / (2 * np.pi))
            compare(own, name, table, other, others[f"error.{name}"], errors, right(name))
    if "energy" in own.functions:
        _energy(own, table)


def _without_the_engine(own: Met, table: Table, others: Table, quadrature: Quadratures) -> None:
    """J and turning points of a coordinate that turns back where the motion as a whole does not, as next to a horizon.

    The engine hands such motions back. A turning point is where P² is zero, and J is worked out between both.
    """
    solution = own.form.solution
    for name in solution.coordinates:
        sides = [f"turning_points.{name}.{side}" for side in ("lower", "upper")]
        if own.form.regime.kinds.get(name) != "libration" or not set(sides) <= own.functions.keys():
            continue
        alone = np.flatnonzero(np.all([np.isnan(others[n]) for n in sides if n in others], axis=0))
        if not len(alone):
            continue
        table_alone = taken(table, alone)
        # J between the turning points that P² has: those of the form may have lost their digits in doubles
        found = [quadrature.turned(name, table_alone, own.at(n, table_alone)) for n in sides]
        ends = [end for end, _ in found]
        for n, side in zip(sides, found, strict=True):
            compare(own, n, table_alone, *side, {})
        if f"actions.{name}" in own.functions:
            compare(own, f"actions.{name}", table_alone, *quadrature.action(name, table_alone, *ends), {})


def _energy(own: Met, table: Table) -> None:
    """E of the actions that forms have in doubles: E itself, to what roundings of the actions do."""
    actions = {f"J_{n}": own.at(f"actions.{n}", table) for n in own.form.actions}
    names = own.functions["energy"].names  # type: ignore[attr-defined]
    if not set(names) <= actions.keys() | table.keys():
        return
    given = table | actions
    E = table[constants_of(own.form.solution)[0].name]
    size, _ = condition(own, "energy", given, {})
    relative = np.zeros(len(E))
    for n in own.form.actions:
        part, _ = condition(own, f"actions.{n}", table, {})
        relative = np.fmax(relative, part / abs(actions[f"J_{n}"]))
    compare(own, "energy", given, E, FAR * ULP * size * (1 + np.nan_to_num(relative)), {})


def _ends(own: Met, name: str, table: Table, others: Table, dice: np.random.Generator) -> tuple[Reals, Reals]:
    """Two places of each motion, the second above the first, with no turning point between them."""
    q = table[name]
    sides = [f"turning_points.{name}.{side}" for side in ("lower", "upper")]
    low, high = (
        np.where(np.isnan(others[n]), own.at(n, table) if n in own.functions else np.nan, others[n]) for n in sides
    )
    coordinate = own.form.solution.system.coordinate(name)
    at = {p.symbol: sp.Float(table[p.name][0], 17) for p in own.form.solution.system.parameters}
    least, greatest = (None, None) if coordinate.domain.kind == "angle" else ends_of(coordinate, at)
    if least is not None:  # the engine goes on through a pole, and forms end there: q turns back beyond it
        low = np.where(low < least, np.nan, low)
    if greatest is not None:
        high = np.where(high > greatest, np.nan, high)
    start, stop = np.sort(dice.uniform(0.05, 0.95, (2, len(q))), axis=0)
    both, lower, upper = np.isfinite(low) & np.isfinite(high), np.isfinite(low), np.isfinite(high)
    first, second = q, q + (1 + abs(q)) * stop
    if coordinate.domain.kind == "angle":
        second = q + (np.pi - q) * stop
    elif greatest is not None:
        second = q + (greatest - q) * stop
    with np.errstate(all="ignore"):
        first = np.where(lower, low + (q - low) * start, np.where(upper, q, first))
        beyond = np.where(lower, q + (q - low) * stop, np.where(upper, q + (high - q) * stop, second))
        second = beyond if greatest is None else np.where(beyond < greatest, beyond, second)
        return np.where(both, low + (high - low) * start, first), np.where(both, low + (high - low) * stop, second)


def _antiderivatives(
    own: Met, table: Table, others: Table, quadrature: Quadratures, dice: np.random.Generator
) -> None:  # fmt: skip
    """Time law, −β and W between two places against the quadrature; then q(t) and q(τ)."""
    solution = own.form.solution
    E, *rest = constants_of(solution)
    given = table | {name: np.zeros(len(table[E.name])) for name in (*ignorable(solution), "t_0")}
    ends = {name: _ends(own, name, table, others, dice) for name in solution.coordinates}
    for name, (low, high) in ends.items():
        given |= {name: high, solution.lower_limits[name].name: low}
    for name, pair in ends.items():
        if name in own.angles:  # of the turn that the form holds for
            for there in pair:
                known = np.isfinite(_inside(own, {**table, name: there}))
                given[name] = np.where(known, given[name], np.nan)
    parts = {name: quadrature.between(name, table, *pair) for name, pair in ends.items()}
    equations = {(W, "characteristic_function"): solution.characteristic_function}
    if solution.time_law is not None:
        equations[E, "time_law"] = solution.time_law.rhs
    equations |= {(c, f"orbit_equations.{c.name}"): solution.orbit_equations[c.name].rhs for c in rest}
    sides = dict[sp.Symbol, tuple[Reals, Reals]]()
    for (key, name), equation in equations.items():
        value, claim = _total(parts, key)
        outside = _without_integrals(equation, given)
        sides[key] = value + outside, claim + 8 * ULP * abs(outside)
        if name in own.functions:
            compare(own, name, given, *sides[key], {})
    if len(ends) == 1 and E in sides:
        _inverses(own, given, sides, quadrature, dice)


def _without_integrals(equation: sp.Expr, given: Table) -> Reals:
    """Return the terms of an equation that are no integrals, which have no lower limit either."""
    plain = equation.xreplace(dict.fromkeys(equation.atoms(sp.Integral), sp.S.Zero))
    symbols = sorted((s for s in plain.free_symbols if s.name in given), key=str)
    made = sp.lambdify(symbols, plain, modules=modules("numpy"))
    return np.asarray(made(*(given[s.name] for s in symbols)), dtype=float)


def _total(parts: Mapping[str, dict[sp.Symbol, tuple[Reals, Reals]]], key: sp.Symbol) -> tuple[Reals, Reals]:
    pairs = [own[key] for own in parts.values() if key in own]
    shape = next(iter(next(iter(parts.values())).values()))[0].shape
    return sum((v for v, _ in pairs), np.zeros(shape)), sum((c for _, c in pairs), np.zeros(shape))


def _inverses(
    own: Met, given: Table, sides: Mapping[sp.Symbol, tuple[Reals, Reals]], quadrature: Quadratures,
    dice: np.random.Generator,
) -> None:  # fmt: skip
    """q(t), r(θ) and the eccentric anomaly of one separated coordinate: to where the quadrature ends."""
    solution = own.form.solution
    (name,) = solution.coordinates
    low, high = given[solution.lower_limits[name].name], given[name]
    E, *rest = constants_of(solution)
    time_there, off = sides[E]
    place = {**given, "t": time_there}
    if f"inverse.{name}" in own.functions:
        compare(own, f"inverse.{name}", place, high, 4 * ULP * abs(high), {"t": off})
    for c in rest:
        other = c.name.removeprefix("p_")
        if other in given and other not in solution.coordinates:
            Q, lost = sides[c]  # with every β = 0, −β = θ + Q
            if f"inverse.{other}" in own.functions:
                compare(own, f"inverse.{other}", place, -Q, lost, {"t": off})
            if f"orbit.{name}" in own.functions and len(rest) == 1:
                there = np.where(given[c.name] == 0, np.nan, -Q)  # the orbit of a motion with p_θ = 0 is no r(θ)
                compare(own, f"orbit.{name}", {**given, other: there}, high, 4 * ULP * abs(high), {other: lost})
    if f"anomaly.{name}" in own.functions and "anomaly.t" in own.functions:
        there = {**given, "xi": dice.uniform(0.1, _FIRST, len(high))}
        q = own.at(f"anomaly.{name}", there)
        value, lost = quadrature.between(name, given, np.fmin(q, low), np.fmax(q, low))[E]
        back = np.where(q > low, value, -value)
        _pair(own, name, there, q, (back, lost))


def _pair(own: Met, name: str, there: Table, q: Reals, side: tuple[Reals, Reals]) -> None:
    """t(ξ) against the time to the double that q(ξ) is: where that is off, the quadrature ends at another ξ."""
    (back, lost), xi = side, there["xi"]
    size, slope = condition(own, f"anomaly.{name}", there, {"xi": np.ones(len(q))})
    off = FAR * ULP * np.fmax(size, abs(q)) / np.where(slope > 0, slope, np.nan)
    ends = [{**there, "xi": xi + step} for step in (-_STEP, _STEP)]
    (t_below, q_below), (t_above, q_above) = (
        (own.at("anomaly.t", end), own.at(f"anomaly.{name}", end)) for end in ends
    )
    with np.errstate(all="ignore"):
        rate = (t_above - t_below) / (q_above - q_below)

    def right(k: int) -> float:
        at = {n: float(v[k]) for n, v in there.items()}
        beyond = float(q[k]) - in_many_digits(own.form, f"anomaly.{name}", at)
        return in_many_digits(own.form, "anomaly.t", at) + beyond * float(rate[k])

    compare(own, "anomaly.t", there, back, lost + ULP * abs(q * rate), {"xi": off}, right)


HEAD = (
    f"{'motions':>8}{'numbers':>9}{'compared':>9}{'missing':>8}{'nan':>5}{'diff/claim':>11}{'ulp/cond':>10}{'beyond':>7}"
    f"{'faults':>7}  regime"
)


def line(own: Met) -> str:
    """Return a row of the table."""
    rows = own.rows.values()
    return (
        f"{own.motions:>8}{len(rows):>9}{sum(r.count for r in rows):>9}{sum(r.missing for r in rows):>8}"
        f"{sum(r.nan for r in rows):>5}{max((r.worst for r in rows), default=0.0):>11.2g}"
        f"{max((r.ulp for r in rows), default=0.0):>10.3g}{sum(r.beyond for r in rows):>7}"
        f"{sum(len(r.faults) for r in rows):>7}  {own.form.regime.words}"
    )


def spread(own: Met) -> str:
    """Return how far the constants of a regime's motions are spread: decades from the 5th to the 95th in a hundred."""
    words = []
    for name in own.constants[0]:
        sizes = np.abs(np.concatenate([part[name] for part in own.constants]))
        low, high = np.percentile(sizes, (5, 95))
        words.append(f"{name} {np.log10(high / low):.1f}" if low > 0 else f"{name} 0")
    return f"decades of constants, of {len(own.constants)} sets: {', '.join(words)}"


def main(arguments: Sequence[str]) -> None:
    """Print the table.

    Args:
        arguments: of the command line.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--motions", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--each", action="store_true", help="a line for each number")
    parser.add_argument("entries", nargs="*")
    options = parser.parse_args(arguments)
    print(HEAD)
    for entry in options.entries or hjsolve.catalog.ids("separable"):
        begin = time.process_time()
        print(entry, flush=True)
        solution = hjsolve.solve(entry)
        for own in campaign(solution, forms_of(solution), options.motions, options.seed, options.seconds):
            print(f"{line(own)}  [{time.process_time() - begin:.0f} s]")
            if options.each:
                print(f"        {spread(own)}")
            for row in own.rows.values():
                if options.each or row.nan or row.beyond:
                    words = f"{row.count} compared, {row.nan} nan, {row.beyond} beyond, {row.ulp:.3g} ulp"
                    print(f"        {row.name}: {words}")
                for fault in row.faults[:2]:
                    print(f"      {fault}")
            sys.stdout.flush()
        print(f"    {time.process_time() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
