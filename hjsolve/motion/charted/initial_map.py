"""Initial data carried from the user's coordinates to the separated ones: u by the inverse chart, p_u = (∂X/∂u)ᵀP + a.

Everything is worked out twice, to ``BITS`` and to half as many; what is no larger than the difference is zero (a
coordinate plane, a turning point, no angular momentum), the rest is rounded to a rational number that is right to far
more digits than any computation here asks for. The energy is exact: it is that of the user's own coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise

import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Context, Mpf
from hjsolve.coordinates.chart import Chart
from hjsolve.errors import InvalidInputError
from hjsolve.mechanics.system import hamiltonian
from hjsolve.motion.charted.inverse_charts import inverse_chart
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.formulas_at_places import tape_of
from hjsolve.motion.initial_data import Initial, all_exact, clean, read_phase_point, with_numbers
from hjsolve.solution.quadratures import Solution

BITS = 4800
_RISING = ("a1", "a2", "a3", "e1", "e2", "e3", "b", "c")
"""Lengths of a chart, of one kind each, that rise in this order."""
_ANGLES = {
    "polar": (1,), "circular cylinder": (1,), "spherical": (1, 2), "rotational parabolic": (2,),
    "prolate spheroidal": (2,), "oblate spheroidal": (2,),
}  # fmt: skip
"""Coordinates that are angles about an axis or at a pole, by kind of chart."""
_MANY_TURNS = 2**40
"""Twelfths of π, beyond which no place is looked at as a multiple of them."""
Values = Mapping[str, object]
Frame = tuple[list[Mpf], list[Mpf], dict[str, Mpf]]
"""X, P and the lengths of a web."""


def carried(
    solution: Solution, chart: Chart, *, q: Values, velocity: Values | None, p: Values | None, parameters: Values | None
) -> Initial:
    """Read initial data in the user's coordinates and carry them to the separated ones.

    Args:
        chart: how they are tied to the user's.
        q, velocity, p: every one of the user's coordinates → number; velocity or p.
        parameters: name → number, where it differs from the default.

    Raises:
        InvalidInputError: unknown or missing names, or a place where the separated coordinates are singular.
        MissingValueError: a value is missing.
    """
    if (velocity is None) == (p is None):
        raise InvalidInputError(
            "initial data: give either velocity={…} or p={…}, a number for every coordinate of the system as given"
        )
    given = read_phase_point(chart.original, q, velocity, p, parameters)
    far, near = (_numbers(solution, chart, given, bits) for bits in (BITS, BITS // 2))
    energy = clean(with_numbers(hamiltonian(chart.original), given))  # refuses an infinite V, which the map rounds away
    # roots of the inverse chart become fractions of 4 800 bits: constants are worked out from them without more loss
    exact = [rational_of(a, b) for a, b in zip(far, near, strict=True)]
    system, n = solution.system, len(chart.symbols)
    values = {s.symbol: given[s.symbol] for s in system.parameters}
    places = [place_of(a, b) for a, b in zip(far[:n], near[:n], strict=True)]
    values |= {c.symbol: x for c, x in zip(system.coordinates, places, strict=True)}
    values |= {c.momentum: x for c, x in zip(system.coordinates, exact[n : 2 * n], strict=True)}
    constants = dict(zip(solution.constants, exact[2 * n :], strict=False))
    if "E" in solution.constants:
        if "E" in constants:
            _same_energy(chart, energy, far[2 * n + list(solution.constants).index("E")])
        constants["E"] = energy
    return Initial(values, constants, all_exact(q, velocity, p, parameters))


def at_singular_place(
    solution: Solution, chart: Chart, *, q: Values, velocity: Values | None, p: Values | None, parameters: Values | None
) -> tuple[dict[sp.Symbol, sp.Expr], list[sp.Expr], sp.Expr]:
    """Return u where momenta p_u say nothing, with the velocity in the frame of the web, and the energy.

    Args:
        solution, chart, q, velocity, p, parameters: as of ``carried``.

    Returns:
        Parameters and u, exact; Ẋ; E.

    Raises:
        InvalidInputError, MissingValueError: as of ``carried``.
    """
    given = read_phase_point(chart.original, q, velocity, p, parameters)
    rows = []
    for bits in (BITS, BITS // 2):
        field = Multi(bits)

        def value(e: sp.Expr, bits: int = bits) -> Mpf:
            return to_bits(e.xreplace(given))(bits)

        # at a focus u is known and p_u is not: P in the frame of the web is regular there
        X, P, lengths = point_in_frame(chart, value, field.context)
        mass = value(chart.mass)
        u = inverse_chart(chart.kind, X, P, lengths, field)[-len(chart.symbols) :]
        rows.append([*u, *(x / mass for x in P)])
    n = len(chart.symbols)
    values = {s.symbol: given[s.symbol] for s in solution.system.parameters}
    values |= {s: place_of(a, b) for s, a, b in zip(chart.symbols, rows[0][:n], rows[1][:n], strict=True)}
    speed = [rational_of(a, b) for a, b in zip(rows[0][n:], rows[1][n:], strict=True)]
    return values, speed, clean(with_numbers(hamiltonian(chart.original), given))


def _same_energy(chart: Chart, exact: sp.Expr, found: Mpf) -> None:
    """Refuse values of parameters for which V in the coordinates found is not the V given.

    Roots and logarithms were written with the signs that they have at the default values.
    """
    energy = to_bits(exact)(BITS)
    if abs(energy - found) > (1 + abs(energy)) * energy.context.mpf(2) ** (-BITS // 8):
        raise _other_parameters(chart)


def _other_parameters(chart: Chart) -> InvalidInputError:
    return InvalidInputError(
        f"parameters: the {chart.kind} coordinates were found for the default values and do not hold for these; make "
        "these the defaults, System(…, parameters={name: value}), and solve again"
    )


def point_in_frame(chart: Chart, value: Callable[[sp.Expr], Mpf], c: Context) -> Frame:
    """Return X and P in the frame of the web, and its lengths.

    Args:
        chart: of the web.
        value: of an expression, in numbers of the context.
        c: context of mpmath.

    Raises:
        InvalidInputError: the web is none with these values of the parameters.
    """
    outer = chart.outer
    try:
        frame = c.matrix([[value(e) for e in row] for row in chart.frame.tolist()])
        moved = c.matrix([value(x) - value(o) for x, o in zip(outer.place, chart.origin, strict=True)])
        X, P = c.lu_solve(frame, moved), frame.T * c.matrix([value(e) for e in outer.momentum])
        lengths = {name: value(length) for name, length in chart.lengths.items()}
    except (InvalidInputError, ZeroDivisionError):
        raise _other_parameters(chart) from None
    # a confocal family needs its lengths in order: with others the inverse chart takes roots of negative numbers
    rising = [lengths[name] for name in _RISING if name in lengths]
    if lengths.get("a", 1) <= 0 or any(one >= other for one, other in pairwise(rising)):
        raise _other_parameters(chart)
    return list(X), list(P), lengths


def _numbers(solution: Solution, chart: Chart, given: Mapping[sp.Symbol, sp.Expr], bits: int) -> list[Mpf]:
    """u, p_u and the constants of the motion, to so many bits."""
    field = Multi(bits)
    c = field.context

    def value(e: sp.Expr) -> Mpf:
        return to_bits(e.xreplace(given))(bits)

    X, P, lengths = point_in_frame(chart, value, c)
    n = len(chart.symbols)
    u = _inside(chart, inverse_chart(chart.kind, X, P, lengths, field)[-n:])  # on a sphere without r
    _refuse_singular(chart, given, u, field)
    fixed = {s.symbol: value(s.symbol) for s in chart.system.parameters}
    J = sp.Matrix(chart.place).jacobian(chart.symbols)
    slopes = tape_of(tuple(J), (*chart.symbols, *fixed)).run(field, [*u, *fixed.values()])
    # p_u = (∂X/∂u)ᵀ P: the transposed Jacobian, so that no h² is divided by
    lifted = [c.fsum(slopes[i * n + k] * P[i] for i in range(len(P))) for k in range(n)]
    if chart.linear:
        own = tape_of(chart.linear, (*chart.symbols, *fixed)).run(field, [*u, *fixed.values()])
        lifted = [p + a for p, a in zip(lifted, own, strict=True)]
    momenta = [q.momentum for q in solution.system.coordinates]
    formulas = tuple(constant.expression for constant in solution.constants.values())
    try:
        constants = tape_of(formulas, (*chart.symbols, *momenta, *fixed)).run(field, [*u, *lifted, *fixed.values()])
    except InvalidInputError:  # 0/0 on an axis; they are taken from the coordinates that go on there
        constants = []
    return [*u, *lifted, *constants]


def _inside(chart: Chart, u: list[Mpf]) -> list[Mpf]:
    """Return the coordinates of the point that are in their ranges.

    (−u, −v) for (u, v) where one of them has to be positive.

    Raises:
        InvalidInputError: the point is on the edge, where V has a crease.
    """
    domains = [c.domain for c in chart.system.coordinates]
    for k in (0, 1):
        if chart.kind.startswith(("elliptic", "parabolic")) and domains[k].lower == 0:
            if u[k] == 0 or (domains[k].upper is not None and abs(u[k]) == u[k].context.pi):
                raise InvalidInputError(
                    f"q: V is not smooth there ({chart.coordinates[k]} = 0, an edge of the {chart.kind} coordinates)"
                )
            if u[k] < 0:
                return [-u[0], -u[1], *u[2:]]
    return u


def _refuse_singular(chart: Chart, given: Mapping[sp.Symbol, sp.Expr], u: list[Mpf], field: Multi) -> None:
    """Refuse a place where an h² is zero that is not that of an angle: a focus, or the centre of conical coordinates.

    On an axis and at r = 0 the angle is that of the velocity; ``through_poles`` decides whether the motion goes on.
    """
    fixed = {s.symbol: to_bits(given[s.symbol])(field.bits) for s in chart.system.parameters}
    scale = tape_of(chart.scale, (*chart.symbols, *fixed)).run(field, [*u, *fixed.values()])
    # at a focus rounded numbers do not make h² zero, but some root of their last bit
    least = field.context.mpf(2) ** (-field.bits // 4)
    if all(h > least for k, h in enumerate(scale) if k not in _ANGLES.get(chart.kind, ())):
        return
    place = ", ".join(f"{q.name} = {given[q.symbol]}" for q in chart.original.coordinates)
    raise InvalidInputError(
        f"q: {place} is a singular point of the {chart.kind} coordinates in which the system separates (a focus or "
        "the centre), where the momenta do not determine the motion; start it at a place a little before"
    )


def place_of(far: Mpf, near: Mpf) -> sp.Expr:
    """Return a coordinate as an exact number: a multiple of π/12 where it is that but for rounding, else a fraction.

    What vanishes on the equator, at θ = π/2, then does so exactly.

    Args:
        far, near: as of ``rational_of``.
    """
    fraction = 12 * far / far.context.pi
    whole = int(far.context.nint(fraction)) if abs(fraction) < _MANY_TURNS else 0
    # θ = π/2 rounded is not the equator: what must vanish there would be 10⁻¹⁴⁰⁰ instead
    if whole and abs(far - whole * far.context.pi / 12) <= max(abs(far - near), far.context.ldexp(1, -BITS // 3)):
        return sp.pi * sp.Rational(whole, 12)
    return rational_of(far, near)


def rational_of(far: Mpf, near: Mpf) -> sp.Rational:
    """Return a number as a fraction; 0 where it is no more than the rounding of the lower precision.

    Args:
        far: to ``BITS``.
        near: to half as many.
    """
    # no larger than what the rounding of the lower precision makes of it
    if abs(far) <= abs(far - near):
        return sp.S.Zero
    sign, mantissa, exponent, _ = far._mpf_
    whole = int(mantissa) * (-1 if sign else 1)
    return sp.Integer(whole << exponent) if exponent >= 0 else sp.Rational(whole, 1 << -exponent)
