"""One separated coordinate of a motion as numbers to draw: its effective potential, its levels, its momentum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arithmetic.floats import Float64
from hjsolve.arithmetic.tape import Tape
from hjsolve.lowering import lower
from hjsolve.mechanics.coordinates_and_parameters import Coordinate
from hjsolve.mechanics.kinks import with_quotients
from hjsolve.motion.motion import Motion
from hjsolve.reports.formulas.from_sympy import compact
from hjsolve.solution.quadratures import Solution

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FormulaCurve:
    """A formula of one variable, every other symbol replaced by a number."""

    tape: Tape
    others: tuple[float, ...]

    def __call__(self, q: Array | float) -> Array:
        """Evaluate; infinite or undefined places give inf or nan without a warning."""
        places = np.asarray(q, float)
        with np.errstate(all="ignore"):
            value = self.tape.run(Float64(), [places, *self.others])[0]
        return np.broadcast_to(np.asarray(value, float), places.shape).copy()


def formula_curve(formula: sp.Expr, variable: sp.Symbol, values: Mapping[sp.Symbol, sp.Expr]) -> FormulaCurve:
    """Make a formula a function of one variable.

    Args:
        variable: what stays free.
        values: exact numbers for all other symbols.

    Returns:
        The function, double precision.
    """
    rest = sorted(formula.free_symbols - {variable}, key=str)
    return FormulaCurve(lower([formula], [variable, *rest]), tuple(float(sp.N(values[s], 30)) for s in rest))


@dataclass(frozen=True)
class EffectivePotential:
    """A separated coordinate: P² = weight(q)·(level − potential(q)), p = P − shift(q).

    Attributes:
        name: the coordinate.
        level_name: the constant that plays the part of the energy: E, or a separation constant; empty where P² is not
            linear in any, and then the potential is −P²/2 and the level 0.
        sign: −1 where it is minus that constant which plays this part, else +1.
        level: the value of sign times that constant in the motion.
        formula: the effective potential as a formula.
        domain: (low, high), infinite where open.
        periodic: an angle on which everything has period 2π.
        window: the range of q worth showing.
        kind: of the motion in this coordinate.
        place: where it starts.
        direction: ±1, the sign of P at the start; 0 at a turning point.
        ends: turning points of the motion, None where it has none on that side.
    """

    name: str
    level_name: str
    sign: int
    level: float
    formula: sp.Expr
    potential: FormulaCurve
    weight: FormulaCurve
    shift: FormulaCurve
    domain: tuple[float, float]
    periodic: bool
    window: tuple[float, float]
    kind: str
    place: float
    direction: int
    ends: tuple[float | None, float | None]

    def momentum_squared(self, q: Array, level: float) -> Array:
        """Return p²(q) at some level; the level of the motion gives the motion's own.

        Args:
            q: places, shape (m,).
            level: of the curve that is drawn.
        """
        with np.errstate(all="ignore"):
            return np.asarray(self.weight(q) * (level - self.potential(q)))


def effective_potential_of(motion: Motion, name: str) -> EffectivePotential:
    """Look at one separated coordinate of a motion.

    Args:
        name: one of ``motion.solution.coordinates``.

    Returns:
        The view.
    """
    solution, exact = motion.solution, exact_values_of(motion)
    coordinate = solution.separation.shell.coordinates[solution.coordinates.index(name)]
    F = sp.expand(solution.momentum_squared[name])
    low, high = (_end(end, exact) for end in (coordinate.domain.lower, coordinate.domain.upper))
    domain = (-np.inf if low is None else low, np.inf if high is None else high)
    periodic = coordinate.domain.kind == "angle"
    ends = [None if end is None else float(end.value) for end in motion.turning_points.get(name, (None, None))]
    place = float(sp.N(exact[coordinate.symbol], 30))
    whole = (-np.pi, np.pi) if periodic else domain
    window = _window(whole, (ends[0], ends[1]), place, motion.kinds[name])
    level_name, sign, weight, potential = _level(solution, F, coordinate.symbol, exact, window)
    level = sign * float(motion.constants[level_name].value) if level_name else 0.0
    V, A, shift = (
        formula_curve(with_quotients(formula, solution.system.kinks), coordinate.symbol, exact)
        for formula in (potential, weight, solution.shift[name])
    )
    return EffectivePotential(
        name,
        level_name,
        sign,
        level,
        potential,
        V,
        A,
        shift,
        domain,
        periodic,
        window,
        motion.kinds[name],
        place,
        _direction(solution, coordinate, exact),
        (ends[0], ends[1]),
    )


def _direction(solution: Solution, coordinate: Coordinate, exact: Mapping[sp.Symbol, sp.Expr]) -> int:
    P = sp.N(coordinate.momentum.subs(exact) + solution.shift[coordinate.name].subs(exact), 30)
    return int(np.sign(float(P)))


def exact_values_of(motion: Motion) -> dict[sp.Symbol, sp.Expr]:
    """Give every symbol of a motion its exact value: parameters, initial place, constants."""
    constants = {c.symbol: motion.initial.constants[name] for name, c in motion.solution.constants.items()}
    return {**motion.initial.values, **constants}


def _level(
    solution: Solution, F: sp.Expr, q: sp.Symbol, exact: Mapping[sp.Symbol, sp.Expr], window: tuple[float, float]
) -> tuple[str, int, sp.Expr, sp.Expr]:
    """Find the constant that P² is linear in, with a weight that keeps away from zero, E first: F = A·(level − V)."""
    low, high = window
    places = low + (high - low) * (np.arange(60) + 0.5) / 60
    for name, constant in solution.constants.items():
        A = sp.diff(F, constant.symbol)
        if A == 0 or A.has(constant.symbol) or name.startswith("p_"):
            continue
        weight = formula_curve(A, q, exact)(places)
        if np.min(np.abs(weight)) < 0.003 * np.max(np.abs(weight)) or np.ptp(np.sign(weight)):
            continue
        sign = int(np.sign(weight[0]))
        alone = name == "E" and len(solution.coordinates) == 1
        potential = (
            solution.separation.shell.potential if alone else readable_quotient(sign * (constant.symbol * A - F) / A)
        )
        return name, sign, sign * sp.factor_terms(A), potential
    return "", 1, sp.Integer(2), -F / 2


def readable_quotient(expression: sp.Expr) -> sp.Expr:
    """Expand a quotient and cancel term by term, as an effective potential is read; many terms as one fraction."""
    terms = sp.Add.make_args(sp.expand(expression))
    whole = sp.Add(*(sp.powsimp(sp.cancel(term) if term.is_rational_function() else term) for term in terms))
    return compact(whole)


def _end(end: sp.Expr | None, exact: Mapping[sp.Symbol, sp.Expr]) -> float | None:
    return None if end is None else float(sp.N(sp.sympify(end).subs(exact), 30))


def _window(
    domain: tuple[float, float], ends: tuple[float | None, ...], place: float, kind: str
) -> tuple[float, float]:
    """Show the motion with room around it; a bounded domain is shown whole unless the motion is small in it."""
    low, high = domain
    a, b = ends
    small = a is not None and b is not None and 0 < b - a < 0.25 * (high - low)
    if np.isfinite(low) and np.isfinite(high) and not small:
        return low, high
    if a is not None and b is not None and b > a:
        width = b - a
        left, right = a - 0.55 * width, b + 0.75 * width
    else:
        anchor = a if a is not None else b if b is not None else place
        size = max(abs(anchor), abs(place - anchor) * 1.5, 0.5 if kind == "equilibrium" else 1.0, 1e-300)
        left, right = anchor - 1.2 * size, anchor + (4.0 if kind == "escape" and b is None else 1.5) * size
        if kind == "escape" and a is None and b is not None:
            left, right = b - 4.0 * size, b + 1.2 * size
        left, right = min(left, place - 0.3 * size), max(right, place + 0.3 * size)
    return (left, right) if small and np.isclose(high - low, 2 * np.pi) else (max(left, low), min(right, high))
