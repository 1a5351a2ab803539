"""From the verified integrals of the coordinates to the equations and numbers of the whole motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import sympy as sp

from hjsolve.closed_form.along_motion import along_the_motion
from hjsolve.closed_form.common_factors import with_common_factors
from hjsolve.closed_form.common_parameter import others_in_parameter
from hjsolve.closed_form.curves import W
from hjsolve.closed_form.elliptic_inverses import in_moduli
from hjsolve.closed_form.energy_from_actions import solved_for_constants
from hjsolve.closed_form.form_context import FormContext, SpecialCase
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.inverses import inverse_forms, orbit_formulas, parametric_formulas
from hjsolve.closed_form.named_quantities import NamedQuantities, Where, without_sign
from hjsolve.closed_form.names_of_regime import in_named_rates, names_of
from hjsolve.closed_form.pieces import CoordinateIntegrals
from hjsolve.closed_form.regime import Regime, positive_in, settled
from hjsolve.closed_form.roots_of_quotients import under_one_root
from hjsolve.closed_form.tidy import (
    LONGEST,
    collected,
    elliptic,
    longer_than,
    multiplied_out,
    plain_roots,
    shortened_powers,
)
from hjsolve.closed_form.why_not import Contains, NotFound, OfCoordinate, WhyNot

Integrals = Mapping[str, CoordinateIntegrals]


def assembled(context: FormContext, pieces: Integrals, made: Regime, special: SpecialCase) -> RegimeForms:
    """Put the integrals into Jacobi's equations, and the values over cycles into actions and frequencies.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals; those of coordinates without a curve are missing.
        made: the regime.
        special: constant → what it is there.
    """
    solution, why_not = context.solution, dict[str, WhyNot]()
    where: Where = {symbol: meaning for own in pieces.values() for symbol, meaning in own.where.items()}
    names = names_of(solution, pieces, where)
    pieces = in_named_rates(solution, pieces, names)
    closing = _Closing(context, pieces, special, names)
    time_law = closing.equation("time_law", solution.time_law, context.constants[0], why_not)
    equations = dict[str, sp.Eq]()
    for name, equation in solution.orbit_equations.items():
        found = closing.equation(f"orbit_equations.{name}", equation, solution.constants[name].symbol, why_not)
        if found is not None:
            equations[name] = found
    function = closing.closed("characteristic_function", solution.characteristic_function, W, why_not)
    numbers = _numbers(context, pieces, special, made, why_not, names)
    inverse = inverse_forms(context, pieces, special, why_not, names)
    orbit = orbit_formulas(context, pieces, special, names)
    parametric = parametric_formulas(context, pieces, special, names)
    parametric |= others_in_parameter(context, pieces, special, parametric, names)
    anomaly = along_the_motion(context, pieces, names, inverse, why_not)
    _with_reasons(why_not)
    constants = solved_for_constants(context, numbers["actions"], made, names, why_not)

    short = names.short_rates()

    def plain(group: Mapping[str, sp.Expr]) -> dict[str, sp.Expr]:
        return {name: parted(in_moduli(value, names, of_roots=True)) for name, value in group.items()}

    def parted(value: sp.Expr) -> sp.Expr:
        return in_factors(names.with_named_parts(settled(made, value)))

    def in_factors(value: sp.Expr) -> sp.Expr:
        return names.oriented(with_common_factors(under_one_root(made, settled(made, value))))

    def written(group: Mapping[str, sp.Expr]) -> dict[str, sp.Expr]:
        return plain({name: shortened_powers(value.xreplace(short)) for name, value in group.items()})

    def relation(equation: sp.Eq) -> sp.Eq:
        return sp.Eq(equation.lhs, closed(equation.rhs), evaluate=False)

    def closed(value: sp.Expr) -> sp.Expr:
        return parted(names.in_brackets(in_moduli(value, names)))

    def place(value: sp.Expr) -> sp.Expr:
        return in_factors(shortened_powers(in_factors(value)))

    constants = {name: in_factors(_divided(value)) for name, value in constants.items()}
    form = RegimeForms(
        solution, made, None if time_law is None else relation(time_law),
        {name: relation(equation) for name, equation in equations.items()},
        None if function is None else closed(function), _turning_points(pieces, made, place),
        written(numbers["periods"]), written(numbers["actions"]), written(numbers["frequencies"]),
        written(numbers["mean_velocities"]), plain(inverse), plain(orbit), plain(parametric), plain(anomaly),
        constants.get(context.constants[0].name), where, why_not, constants,
    )  # fmt: skip
    for symbol in set(where) - names.roots:
        if symbol.name.startswith(("Omega_", "J_")):
            where[symbol] = in_moduli(sp.sympify(where[symbol]), names, of_roots=True)
    where = names.kept(form.named().values(), lambda e: in_factors(shortened_powers(e)))
    return replace(form, where=where)


def _with_reasons(why_not: dict[str, WhyNot]) -> None:
    """Give what contains another coordinate's q(t) the reason of that, which may have been found later."""
    for name, reason in why_not.items():
        if isinstance(reason, Contains) and reason.reason is None:
            why_not[name] = replace(reason, reason=why_not.get(f"inverse.{reason.other.removesuffix('(t)')}"))


class _Closing:
    """Equations of a solution with their integrals done.

    Args:
        context: of the solution.
        pieces: separated coordinate → its integrals.
        special: constant → what it is.
        names: of the quantities of the forms.
    """

    def __init__(self, context: FormContext, pieces: Integrals, special: SpecialCase, names: NamedQuantities):
        self.solution, self.pieces, self.special, self.names = context.solution, pieces, dict(special), names
        self.reasons = {name: context.why_no_integral(name) for name in context.curves if name not in pieces}

    def equation(
        self, name: str, equation: sp.Eq | None, key: sp.Symbol, why_not: dict[str, WhyNot]
    ) -> sp.Eq | None:  # fmt: skip
        """Return an equation in closed form; None where it has none, with the reason."""
        right = None if equation is None else self.closed(name, equation.rhs, key, why_not)
        return None if equation is None or right is None else sp.Eq(equation.lhs, right, evaluate=False)

    def closed(self, name: str, expression: sp.Expr, key: sp.Symbol, why_not: dict[str, WhyNot]) -> sp.Expr | None:
        """Return an expression with its integrals done; None where one has no form, with the reason."""
        table = dict[sp.Expr, sp.Expr]()
        for integral in sorted(expression.atoms(sp.Integral), key=sp.default_sort_key):
            found = self._integral(integral, key)
            if isinstance(found, WhyNot):
                why_not[name] = found
                return None
            table[integral] = found
        return expression.xreplace(table).xreplace(self.special)

    def _integral(self, integral: sp.Integral, key: sp.Symbol) -> sp.Expr | WhyNot:
        q, start, _ = integral.limits[0]
        name = next(n for n in self.solution.coordinates if self.solution.system.coordinate(n).symbol == q)
        own = self.pieces.get(name)
        if own is None:
            return OfCoordinate(name, self.reasons.get(name, NotFound("its momentum enters H to first degree")))
        if key in own.integrals:
            here, there = self.names.amplitudes(shortened_powers(own.integrals[key].value), q, start)
            return here - there
        if integral.function.subs(self.special) == 0:
            return sp.S.Zero
        return OfCoordinate(name, own.why_not.get(key, NotFound("no form was found")))


def _numbers(
    context: FormContext, pieces: Integrals, special: SpecialCase, made: Regime, why_not: dict[str, WhyNot],
    names: NamedQuantities,
) -> dict[str, dict[str, sp.Expr]]:  # fmt: skip
    """Actions, frequencies, periods and mean velocities, where they exist; long frequencies are named in ``where``."""
    solution = context.solution
    actions, frequencies, velocities = dict[str, sp.Expr](), dict[str, sp.Expr](), dict[str, sp.Expr]()
    cyclic = [n for n in solution.coordinates if n in pieces and pieces[n].kind in ("libration", "rotation")]
    for c in solution.system.coordinates:
        if c.name in cyclic:
            J = _cycle(pieces[c.name], W)
            # J of a rotation is ∮ p dq with p = P − A; over a libration A cancels between there and back
            if pieces[c.name].kind == "rotation" and not isinstance(J, WhyNot):
                J = _without_shift(J, solution.shift[c.name].subs(dict(special)), c.symbol)
            if isinstance(J, WhyNot):
                why_not[f"actions.{c.name}"] = J
            else:
                actions[c.name] = shortened_powers(J / (2 * sp.pi) if elliptic(J) else _plain_action(J / (2 * sp.pi)))
        elif c.name not in solution.coordinates and c.domain.kind == "angle":
            actions[c.name] = c.momentum.subs(dict(special))
    if len(cyclic) == len(solution.coordinates) and solution.coordinates:
        _rates(context, pieces, frequencies, velocities, why_not, names)
    elif not solution.coordinates:
        for c in solution.system.coordinates:
            rate = sp.diff(solution.separation.shell.potential, c.momentum)
            (frequencies if c.domain.kind == "angle" else velocities)[c.name] = rate
    periods = {
        name: shortened_powers(2 * sp.pi / _size(name, rate, pieces.get(name), made, names.where))
        for name, rate in frequencies.items()
    }
    return {
        "actions": actions, "frequencies": frequencies, "mean_velocities": velocities,
        "periods": {name: value for name, value in periods.items() if not value.has(sp.zoo)},
    }  # fmt: skip


def _divided(value: sp.Expr) -> sp.Expr:
    """Return −(a + b)/m as −a/m − b/m, where that is shorter; nothing else is multiplied out."""
    return min(value, sp.expand_mul(value, deep=False), key=sp.count_ops)


def _plain_action(J: sp.Expr) -> sp.Expr:
    """Return a sum of roots with (E − U)/√(U − E) as −√(U − E), where that is shorter."""
    J = sp.expand(J)
    roots = [p for p in J.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2 and p.base.is_Add]
    if not any(p.exp < 0 for p in roots):
        return J
    plain = plain_roots(J)
    # L²/|L| in a sum over one denominator is |L| in a sum of terms
    terms = sp.Add(*map(shortened_powers, sp.Add.make_args(sp.expand_mul(plain))))
    return min(J, plain, terms, key=sp.count_ops)


def _without_shift(cycle: sp.Expr, shift: sp.Expr, q: sp.Symbol) -> sp.Expr | WhyNot:
    """∮ (P − A) dq over a turn, of a trigonometric polynomial A(q); why not, of any other."""
    z = sp.Dummy("z")
    # the mean of a trigonometric polynomial is its constant term, in z = e^{iq}
    laurent = sp.expand(sp.expand(shift.rewrite(sp.exp)).subs(q, sp.log(z) / sp.I))
    terms = sp.Add.make_args(sp.expand(sp.powsimp(laurent)))
    if any(not term.as_independent(z)[1].as_base_exp()[1].is_Integer for term in terms):
        return NotFound("the mean of A in p = P − A over a turn has no form here")
    return cycle - 2 * sp.pi * sp.Add(*(term for term in terms if not term.has(z)))


def _turning_points(
    pieces: Integrals, made: Regime, written: Callable[[sp.Expr], sp.Expr]
) -> dict[str, tuple[sp.Expr | None, sp.Expr | None]]:
    """Return the roots of P between which each coordinate moves, as places q, written as people read them."""
    found = dict[str, tuple[sp.Expr | None, sp.Expr | None]]()
    for name, own in pieces.items():
        if not own.regions or own.roots is None:
            continue
        (curve, region), roots = own.regions[0], own.roots
        s = curve.substitution
        sides = region.lower, region.upper
        ends = [written(settled(made, s.q(roots[k]))) if what == "root" else None for what, k in sides]
        if any(end is not None for end in ends):
            low, high = ends if s.increasing else reversed(ends)
            found[name] = (low, high)
    return found


def _cofactor(M: list[list[sp.Expr]], row: int) -> sp.Expr:
    """Return the cofactor of a row and the first column, written as it stands: no zero test, nothing multiplied out."""
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
    if positive_in(made, plain):
        return plain
    # of each factor by itself: roots are positive where they are real, and |k| is settled where the regime says k > 0
    return settled(made, without_sign(rate)[0])


def _cycle(own: CoordinateIntegrals, key: sp.Symbol) -> sp.Expr | WhyNot:
    """∮ N dq/P over a full cycle, or why there is no form."""
    if key in own.cycles and own.cycles[key].cycle is not None:
        return own.cycles[key].cycle
    if key in own.why_not:
        return own.why_not[key]
    if key not in own.integrals:
        return sp.S.Zero
    cycle = own.integrals[key].cycle
    return NotFound("no form of the complete integral") if cycle is None else cycle


def _derivative(cycle: sp.Expr, letter: str, names: NamedQuantities, *, several: bool) -> sp.Expr:
    """∂J/∂c = (1/2π) ∮ ∂p/∂c dq; of several coordinates by a name, where it holds elliptic integrals."""
    value = cycle / (2 * sp.pi)
    return names.named(letter, collected(value)) if several and elliptic(value) else value


def _rates(
    context: FormContext, pieces: Integrals, frequencies: dict[str, sp.Expr], velocities: dict[str, sp.Expr],
    why_not: dict[str, WhyNot], named: NamedQuantities,
) -> None:  # fmt: skip
    """Ω = ∂E/∂J from 2π ∂J/∂c = ∮ ∂p/∂c dq, by inverting the matrix of the separated coordinates."""
    solution, names = context.solution, list(context.solution.coordinates)
    ignorable = {c.momentum: c for c in solution.separation.shell.ignorable}
    inner = [c for c in context.constants if c not in ignorable]
    rows = [[_cycle(pieces[name], c) for c in inner] for name in names]
    missing = next(
        (OfCoordinate(n, x) for n, row in zip(names, rows, strict=True) for x in row if isinstance(x, WhyNot)), None
    )
    if missing is not None:
        for name in (*names, *(c.name for c in ignorable.values() if c.domain.kind == "angle")):
            why_not[f"frequencies.{name}"] = why_not[f"periods.{name}"] = missing
        return
    # 2π ∂J_n/∂c = ∮ ∂p_n/∂c dq; ∂E/∂J is the first row of the inverse matrix
    M = [
        [_derivative(value, f"J_{n}_{c}", named, several=len(names) > 1) for value, c in zip(row, inner, strict=True)]
        for row, n in zip(rows, names, strict=True)
    ]
    # Cramer's rule: sympy's inverse would expand elliptic integrals and look for zeros among them
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
        missing = next((OfCoordinate(n, x) for n, x in zip(names, parts, strict=True) if isinstance(x, WhyNot)), None)
        if missing is not None:
            for group in ("frequencies", "periods"):
                why_not[f"{group}.{c.name}"] = missing
            continue
        given = [
            _derivative(part, f"J_{n}_{c.momentum}", named, several=len(names) > 1)
            for n, part in zip(names, parts, strict=True)
        ]
        # J_φ = p_φ: Ω_φ = ∂E/∂p_φ at constant J_n = −Σ Ω_n ∂J_n/∂p_φ
        rate = shortened_powers(sp.Add(*(-Ω[n] * part for n, part in zip(names, given, strict=True))))
        if not elliptic(rate):
            # of a turning frame −Ω + …, each term by itself, is shorter than all over one denominator
            terms = sp.Add(*map(sp.factor, sp.Add.make_args(shortened_powers(multiplied_out(rate)))))
            rate = min(sp.factor(rate), terms, key=sp.count_ops)
        (frequencies if c.domain.kind == "angle" else velocities)[c.name] = rate
