"""Constraints that a user types: holonomic and integrable ones are eliminated, the others refused with a proof.

Forms Σ aᵢ(q) q̇ᵢ = 0, solved for some velocities as q̇_d = Σ B_dk q̇_k, are integrable if and only if

    X_k(B_dl) − X_l(B_dk) = 0,   X_k = ∂/∂q_k + Σ B_dk ∂/∂q_d      (Frobenius; Greenwood (1-20), (1-23))

for all d, k, l; the time is one more coordinate where a constraint moves. Otherwise Hamilton's principle does not hold
in its standard form, and there is no Hamilton–Jacobi equation (Greenwood (5-22)–(5-25)).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.algebra.integration import closed_form_potential
from hjsolve.algebra.nonzero import strict_sign
from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.reader import Reader
from hjsolve.coordinates.multipliers import TIME, forces_of, read_constraint
from hjsolve.coordinates.typed_change import SECONDS, short_form, stays_inside, transformed
from hjsolve.errors import InvalidSystemError, NonholonomicError
from hjsolve.mechanics.coordinates_and_parameters import Parameter, free_name, parameter, read_coordinates
from hjsolve.mechanics.energy_shell import domain_bounds
from hjsolve.mechanics.kinetic_energy import degree, velocity_coefficients
from hjsolve.mechanics.system import System
from hjsolve.separation.zero_test.interval_evaluation import Region
from hjsolve.separation.zero_test.zero_test import NonZero, Zero, is_zero

_CURE = "write T and V in coordinates in which the constraint holds"


@dataclass
class _Eliminated:
    """What is left while constraints are eliminated one by one.

    Attributes:
        formulas: old coordinate → its formula in those that are left.
        domains: those that are left → domain, as ``System`` takes it.
    """

    formulas: dict[sp.Symbol, sp.Expr]
    domains: dict[str, str]


def without_constraints(system: System, constraints: Iterable[str]) -> System:
    """Return the system with fewer coordinates in which the constraints hold.

    Args:
        system: in coordinates without constraints.
        constraints: equations such as ``x**2 + y**2 = l**2``, ``2*dot(x) + 3*dot(y) = 0``; the right side may be left
            out where it is 0.

    Raises:
        InvalidSystemError: a constraint that is not integrable, that moves, or that was not solved.
        ExpressionError: one cannot be read.
    """
    texts = (constraints,) if isinstance(constraints, str) else tuple(constraints)
    if system.kinks or system.relativity is not None:
        raise InvalidSystemError(f"constraints: not with kinks of V or relativity; {_CURE}")
    speeds = frozenset(c.velocity for c in system.coordinates)
    given = [
        (f"constraints[{n}]", read_constraint(system, text, f"constraints[{n}]")) for n, text in enumerate(texts, 1)
    ]
    first, formulas = _reduced(system, [(s, g) for s, g in given if degree(g, speeds) == 0], [])
    put = dict(zip([c.symbol for c in system.coordinates], formulas, strict=True))
    rates = {
        c.velocity: sp.diff(put[c.symbol], TIME)
        + sp.Add(*(sp.diff(put[c.symbol], Q.symbol) * Q.velocity for Q in first.coordinates))
        for c in system.coordinates
    }
    moving = [(s, sp.expand(g.xreplace({**put, **rates}))) for s, g in given if degree(g, speeds) > 0]
    forms = [(s, _coefficients(g, [c.velocity for c in first.coordinates], s)) for s, g in moving]
    levels, constants = list[tuple[str, sp.Expr]](), list[Parameter]()
    try:
        integrals = _integrals(first, [form for form in forms if any(a != 0 for a in form[1])])
    except NonholonomicError as error:
        error.equations = forces_of(system, texts, [g for _, g in given])
        raise
    for source, f in integrals:
        name = free_name(f"c_{len(constants) + 1}", first.symbols)
        # f is a coordinate that stays
        sign = "positive" if domain_bounds(first.coordinates).get(f) == (0, None) else "real"
        constants.append(parameter(name, assume=sign, meaning=f"constant of integration of {source}"))
        levels.append((source, f - constants[-1].symbol))
    second, later = _reduced(first, levels, constants)
    onward = dict(zip([c.symbol for c in first.coordinates], later, strict=True))
    whole = [(c.name, f.xreplace(onward)) for c, f in zip(system.coordinates, formulas, strict=True)]
    kept = {c.name: c.symbol for c in second.coordinates}
    remembered = {"eliminated": tuple((name, f) for name, f in whole if f != kept.get(name)),
                  "unconstrained": system, "constraints": texts}  # fmt: skip
    for key, value in remembered.items():
        object.__setattr__(second, key, value)
    return second


def _reduced(
    system: System, fixed: list[tuple[str, sp.Expr]], constants: list[Parameter]
) -> tuple[System, list[sp.Expr]]:
    """Return system in the coordinates that equations g(q) = 0 leave, and the formula of every coordinate in them."""
    if not fixed:
        return system, [c.symbol for c in system.coordinates]
    left = _Eliminated(
        {c.symbol: c.symbol for c in system.coordinates},
        {c.name: c.domain.written(c.name) for c in system.coordinates},
    )
    for source, g in fixed:
        _eliminate(system, left, source, g)
    new = read_coordinates(left.domains, (*system.parameters, *constants))
    own = {sp.Symbol(c.name, real=True): c.symbol for c in new}
    formulas = [f.xreplace(own) for f in left.formulas.values()]
    bounds = {c.symbol: (None, None) if c.domain.kind == "angle" else (c.domain.lower, c.domain.upper) for c in new}
    return transformed(system, new, formulas, bounds, left.domains, constants), formulas


def _coefficients(given: sp.Expr, speeds: Sequence[sp.Symbol], source: str) -> list[sp.Expr]:
    if degree(given, frozenset(speeds)) != 1:
        raise InvalidSystemError(f"{source}: a constraint on velocities must be linear in them; {_CURE}")
    found = velocity_coefficients(given, list(speeds))
    return [*(found.get((i,), sp.S.Zero) for i in range(len(speeds))), found.get((), sp.S.Zero)]


# ------------------------------------------------------------------------------------------------ velocities
def _integrals(system: System, forms: list[tuple[str, list[sp.Expr]]]) -> list[tuple[str, sp.Expr]]:
    """Return a function for each form that is constant where all of them hold."""
    if not forms:
        return []
    symbols = [c.symbol for c in system.coordinates] + [TIME]
    moves = any(form[-1] != 0 or any(TIME in a.free_symbols for a in form) for _, form in forms)
    if not moves:
        symbols, forms = symbols[:-1], [(source, form[:-1]) for source, form in forms]
    region = Region(domain_bounds(system.coordinates), system.defaults)
    found = [(source, _exact(symbols, form, region)) for source, form in forms]
    if any(f is None for _, f in found):
        solved = _solved(symbols, forms, region)
        found = [(source, _exact(symbols, form, region)) for source, form in solved]
    for source, f in found:
        if f is None:
            integral = "f(q, t)" if moves else "f(q)"
            raise InvalidSystemError(
                f"{source}: it is integrable, but its integral was not found; write the integral, "
                f'"{integral} = constant"'
            )
    return [(source, f) for source, f in found if f is not None]


def _exact(symbols: list[sp.Symbol], form: list[sp.Expr], region: Region) -> sp.Expr | None:
    """F with df = μ Σ aᵢ dqᵢ, μ = 1 or one over a coefficient or over all; None where no such form is closed."""
    variable = [a for a in form if a.free_symbols & set(symbols)]
    for factor in (sp.S.One, *(1 / a for a in variable), 1 / sp.Mul(*variable)):
        scaled = [sp.cancel(a * factor) for a in form]
        curls = [
            sp.diff(scaled[i], symbols[j]) - sp.diff(scaled[j], symbols[i])
            for i in range(len(symbols)) for j in range(i)
        ]  # fmt: skip
        if not all(isinstance(is_zero(c, region, budget=SECONDS), Zero) for c in curls):
            continue
        try:
            reader = Reader(scaled, dict(region.bounds), Budget.processor_seconds(SECONDS))
            f = closed_form_potential(reader, symbols, [reader.element(a) for a in scaled])
        except (WorkLimitError, ZeroDivisionError):
            continue
        if not f.has(sp.Integral):
            return f
    return None


def _solved(
    symbols: list[sp.Symbol], forms: list[tuple[str, list[sp.Expr]]], region: Region
) -> list[tuple[str, list[sp.Expr]]]:
    """Return the forms solved for some velocities, once Frobenius' conditions are proved."""
    A = sp.Matrix([form for _, form in forms])
    reduced, pivots = A.rref(simplify=True)
    if len(pivots) < len(forms):
        raise InvalidSystemError("constraints: those on velocities are not independent; leave one out")
    others = [k for k in range(len(symbols)) if k not in pivots]
    B = {(d, k): -reduced[row, k] for row, d in enumerate(pivots) for k in others}

    def along(k: int, f: sp.Expr) -> sp.Expr:
        return sp.diff(f, symbols[k]) + sp.Add(*(B[d, k] * sp.diff(f, symbols[d]) for d in pivots))

    for d in pivots:
        for position, k in enumerate(others):
            for m in others[:position]:
                curvature = along(k, B[d, m]) - along(m, B[d, k])
                answer = is_zero(curvature, region, budget=SECONDS)
                if not isinstance(answer, Zero):
                    raise _not_integrable(forms, short_form(curvature, region.bounds), answer)
    return [
        (source, [sp.S.One if i == d else -B[d, i] if i in others else sp.S.Zero for i in range(len(symbols))])
        for (source, _), d in zip(forms, pivots, strict=True)
    ]


def _not_integrable(forms: list[tuple[str, list[sp.Expr]]], curvature: sp.Expr, answer: object) -> InvalidSystemError:
    names = ", ".join(source for source, _ in forms)
    if not isinstance(answer, NonZero):
        return InvalidSystemError(f"{names}: whether it is integrable was not decided; {_CURE}")
    place = ", ".join(f"{name} = {value}" for name, value in answer.witness.point.items())
    return NonholonomicError(
        f"{names}: not integrable, since {curvature} in Frobenius' condition (1-20) is not zero"
        + (f" at {place}" if place else "")
        + "; the system is nonholonomic, and the Hamilton-Jacobi method does not apply to it (5-22)-(5-25); "
        "constraint_forces gives its equations with multipliers"
    )


# ------------------------------------------------------------------------------------------------ coordinates
def _eliminate(system: System, left: _Eliminated, source: str, g: sp.Expr) -> None:
    """Solve one equation, and put the solution into everything that is left."""
    bounds = _bounds(system, left)
    g = sp.expand(g.subs(left.formulas, simultaneous=True))
    solution = _linear(g, bounds) or _quadric(system, left, g, bounds)
    if solution is None:
        raise InvalidSystemError(
            f"{source}: not solved for a coordinate (it is neither linear in one nor an ellipse or spheroid along the "
            f"axes); {_CURE}"
        )
    for q, f in solution.items():
        own = next((ends for symbol, ends in domain_bounds(system.coordinates).items() if symbol.name == q.name), None)
        if own is not None and not stays_inside(f, own, bounds):
            raise InvalidSystemError(f"{source}: {q.name} = {f} was not proved to stay in its domain; {_CURE}")
        left.domains.pop(q.name)
    for q, f in left.formulas.items():
        left.formulas[q] = f.subs(solution, simultaneous=True)
    if not left.domains:
        raise InvalidSystemError("constraints: they leave nothing that moves")


def _bounds(system: System, left: _Eliminated) -> dict[sp.Symbol, tuple[sp.Expr | None, sp.Expr | None]]:
    return {q: ends for q, ends in domain_bounds(system.coordinates).items() if q.name in left.domains}


def _linear(
    g: sp.Expr, bounds: Mapping[sp.Symbol, tuple[sp.Expr | None, sp.Expr | None]]
) -> dict[sp.Symbol, sp.Expr] | None:
    """Return the simplest solution for a coordinate of first degree in g whose coefficient never vanishes."""
    found = []
    for q in bounds:
        slope = sp.diff(g, q)
        if slope == 0 or slope.has(q) or not strict_sign(short_form(slope, bounds), bounds):
            continue
        found.append((q, short_form(-g.subs(q, 0) / slope, bounds)))
    if not found:
        return None
    q, f = min(reversed(found), key=lambda pair: sp.count_ops(pair[1]))
    return {q: f}


def _quadric(
    system: System, left: _Eliminated, g: sp.Expr,
    bounds: Mapping[sp.Symbol, tuple[sp.Expr | None, sp.Expr | None]],
) -> dict[sp.Symbol, sp.Expr] | None:  # fmt: skip
    """Return angles on a circle, ellipse, sphere or spheroid, g = Σ kᵢ (qᵢ − cᵢ)² − K with K/kᵢ > 0.

    Its coordinates are lines. The angles are polar ones of the circle or sphere that stretching along the axes gives.
    """
    held = [q for q in bounds if g.has(q)]
    if len(held) not in (2, 3) or any(left.domains[q.name] != "line" for q in held):
        return None
    origin = dict.fromkeys(held, 0)
    k = {q: sp.diff(g, q, 2) / 2 for q in held}
    if any(factor == 0 or factor.has(*held) for factor in k.values()):
        return None
    centre = {q: -sp.diff(g, q).subs(origin) / (2 * k[q]) for q in held}
    K = sp.Add(*(k[q] * centre[q] ** 2 for q in held)) - g.subs(origin)
    if sp.simplify(g - sp.Add(-K, *(k[q] * (q - centre[q]) ** 2 for q in held))) != 0:
        return None
    squares = {q: short_form(K / k[q], bounds) for q in held}
    nonzero = {x.symbol: sp.Dummy(x.name, nonzero=True) for x in system.parameters if x.symbol.is_zero is None}
    if any(strict_sign(square.xreplace(nonzero), bounds) != 1 for square in squares.values()):
        return None
    axis = _axis(squares)
    if axis is None:
        return None
    round_ = len(set(squares.values())) == 1
    names = [free_name(name, {*system.symbols, *left.domains}) for name in ("theta" if round_ else "u", "phi")]
    first, phi = (sp.Symbol(name, real=True) for name in names)
    if len(held) == 2:
        place = dict(zip(held, (sp.cos(first), sp.sin(first)), strict=True))
        left.domains[names[0]] = "angle"
    else:
        across = [q for q in held if q != axis]
        place = dict(zip(across, (sp.sin(first) * sp.cos(phi), sp.sin(first) * sp.sin(phi)), strict=True))
        place[axis] = sp.cos(first)
        left.domains |= {names[0]: f"0 < {names[0]} < pi", names[1]: "angle"}
    semiaxes = {q: sp.sqrt(square).replace(sp.Abs, lambda a: a) for q, square in squares.items()}  # of either sign
    return {q: centre[q] + semiaxes[q] * place[q] for q in held}


def _axis(squares: Mapping[sp.Symbol, sp.Expr]) -> sp.Symbol | None:
    """Return the axis of revolution of three semi-axes, the last one where there are more; of two the last."""
    for q in reversed(squares):
        if len(squares) == 2 or len({square for other, square in squares.items() if other != q}) == 1:
            return q
    return None
