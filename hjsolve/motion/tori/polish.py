"""Constants of a torus to the digits asked: Newton's method on J(α), with the integrals of the motion itself.

The matrix ∂J/∂α consists of the mean growths of Jacobi's integrals, which the motion knows. One step from constants in
doubles leaves an error near the square of theirs, so most tori need two evaluations. A coordinate whose J is zero
rests at a double zero of p²: there p² = 0 at its maximum takes the place of the action.

A libration against walls (ends of the domain at which p² is finite and p changes its sign) is that through kinks
(``kinked_libration``) with one cell, the whole domain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import sympy as sp

from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.arithmetic.root_finding import stationary
from hjsolve.errors import ForbiddenMotionError, NotConvergedError
from hjsolve.formulas.read import number
from hjsolve.motion.initial_data import Initial, to_bits
from hjsolve.motion.separated import checked, coordinate_start
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.motion.tori.search import Candidate
from hjsolve.one_coordinate import kinks
from hjsolve.one_coordinate.classify import Located, at_rest, locate
from hjsolve.one_coordinate.coordinate_start import Cell, CoordinateStart
from hjsolve.one_coordinate.turning_points import End
from hjsolve.solution.quadratures import Solution

_SPARE = 192
"""Bits of the constants beyond the digits asked: near a separatrix or a circle J depends on the last of them."""
_NEWTON_STEPS, _FALLS = 20, 0.9
"""Steps of Newton's method, and the ratio by which a step must make the residual smaller."""
_FRACTIONS: tuple[Fraction | int, ...] = (1, Fraction(9, 10), *(Fraction(1, 2**k) for k in range(1, 8)))
"""Fractions of a step that are tried. Next to a separatrix J ~ J₀ + δ ln δ, δ the distance of the constants from it,
and Newton's method overshoots it by δ/ln δ: nine tenths of the step stay inside, and leave a twentieth of δ."""
_ASIDE, _SAME_FAMILY = tuple(Fraction(1, 10**k) for k in (14, 12, 10, 8, 6, 4)), 0.1
"""By which parts of J the search goes aside from constants that doubles do not distinguish from a separatrix, and by
which part of J a torus there may differ: on the other side of a separatrix J is another multiple."""


@dataclass(frozen=True)
class Goal:
    """What is asked of a torus.

    Attributes:
        solution: what is solved.
        values: symbol → exact number, of the parameters and of ignorable coordinates with their momenta.
        constants: name → exact number, of those that are known: the ignorable momenta.
        actions: of the shell momenta of the separated coordinates, in their order: never negative.
        directions: sign of the shell momentum of each, 1 of a libration.
        digits: asked.
        parts: what is integrated.
        exact: False where some input was a float.
    """

    solution: Solution
    values: Mapping[sp.Symbol, sp.Expr]
    constants: Mapping[str, sp.Expr]
    actions: Sequence[sp.Expr]
    directions: Sequence[int]
    digits: int
    parts: frozenset[str]
    exact: bool


@dataclass(frozen=True)
class Torus:
    """A torus that has the actions asked.

    Attributes:
        initial: its constants, and some place on it.
        located: separated coordinate → its motion.
        slopes: ∂J/∂κⱼ of each separated coordinate, J without its sign; shape (n, constants).
    """

    initial: Initial
    located: Mapping[str, Located]
    slopes: Sequence[Sequence[Mpf]]

    def rates(self, unknown: Sequence[int]) -> list[Mpf]:
        """Return ∂E/∂J of the separated coordinates, J without its sign, where E is the first constant.

        Args:
            unknown: positions of the separation constants among all.
        """
        context = self.slopes[0][0].context
        matrix = context.matrix([[row[j] for j in unknown] for row in self.slopes])
        first = context.matrix([int(k == 0) for k in range(len(unknown))])
        return list(context.lu_solve(matrix.T, first))


@dataclass(frozen=True)
class _Trial:
    """A torus for some constants, its residuals in J and the matrix ∂J/∂α.

    ``torus`` is None where p² < 0 along some coordinate: its J is then continued below zero.
    """

    torus: Torus | None
    tops: list[Mpf]
    residuals: list[Mpf]
    slopes: list[list[Mpf]]


def polished(goal: Goal, curves: Sequence[RadicandCurve], candidate: Candidate) -> Torus | None:
    """Return the torus next to a candidate that has the actions to the digits asked; None where there is none.

    Args:
        goal: what is asked.
        curves: p² of the separated coordinates.
        candidate: where Newton's method begins.
    """
    bits = bits_for(goal.digits, 128) + _SPARE
    context = multiprecision(bits)
    names = list(goal.solution.constants)
    κ = [context.mpf(float(x)) for x in candidate.constants]
    for j, name in enumerate(names):
        if name in goal.constants:
            # known constants are exact, whatever the search in doubles had of them
            κ[j] = to_bits(goal.constants[name])(bits)
    unknown = [j for j, name in enumerate(names) if name not in goal.constants]
    goals = [to_bits(x)(bits) for x in goal.actions]
    scale = sum(goals) or context.mpf(1)
    least = context.mpf(2) ** -bits_for(goal.digits, 16)
    # a J of 0 is a double zero of p²: as good as the constants can make it
    allowed = [least * J if J else scale * context.mpf(2) ** (64 - bits) for J in goals]
    tops = [context.mpf(c.top) for c in candidate.cycles]
    kinds = [c.kind for c in candidate.cycles]
    trial = _tried(goal, curves, κ, tops, kinds, goals, bits)
    if trial is None:
        trial, κ = _aside(goal, curves, candidate, (κ, unknown, tops), (kinds, goals, bits))
    for _ in range(_NEWTON_STEPS):
        if trial is None:
            break
        if _relative(trial, allowed) <= 1 and trial.torus is not None:
            return trial.torus
        matrix = context.matrix([[row[j] for j in unknown] for row in trial.slopes])
        try:
            step = context.lu_solve(matrix, context.matrix(trial.residuals))
        except ZeroDivisionError:
            break
        trial, κ = _damped(goal, curves, (κ, unknown, step), trial, (kinds, goals, allowed, bits))
    return None


def _aside(
    goal: Goal, curves: Sequence[RadicandCurve], candidate: Candidate, about: tuple[list[Mpf], list[int], list[Mpf]],
    wanted: tuple[Sequence[str], list[Mpf], int],
) -> tuple[_Trial | None, list[Mpf]]:  # fmt: skip
    """Return a torus next to constants of a separatrix: one with all actions a little smaller or larger."""
    (κ, unknown, tops), (kinds, goals, bits) = about, wanted
    context = multiprecision(bits)
    matrix = context.matrix([[float(c.slopes[j]) for j in unknown] for c in candidate.cycles])
    try:
        step = context.lu_solve(matrix, context.matrix(goals))
    except (ZeroDivisionError, ValueError):
        return None, κ
    for part in _ASIDE:
        for fraction in (-part, part):
            moved = _moved(κ, unknown, step, fraction)
            trial = _tried(goal, curves, moved, tops, kinds, goals, bits)
            if trial is None:
                continue
            if all(abs(r) <= _SAME_FAMILY * J for r, J in zip(trial.residuals, goals, strict=True)):
                return trial, moved
    return None, κ


def _moved(κ: list[Mpf], unknown: Sequence[int], step: Sequence[Mpf], fraction: Fraction | int) -> list[Mpf]:
    """Return the constants after a fraction of a step."""
    moved = list(κ)
    for j, change in zip(unknown, step, strict=True):
        moved[j] = moved[j] + change * fraction.numerator / fraction.denominator
    return moved


def _damped(
    goal: Goal, curves: Sequence[RadicandCurve], move: tuple[list[Mpf], list[int], Sequence[Mpf]], before: _Trial,
    about: tuple[Sequence[str], list[Mpf], list[Mpf], int],
) -> tuple[_Trial | None, list[Mpf]]:  # fmt: skip
    """Return the torus after the longest fraction of a step that makes the residual less.

    The residual is the largest one, or the largest one over what its action allows. The second one alone refuses good
    steps towards a small action: after a step J is off by the square of *all* residuals before, and next to an action
    of 10⁻²⁴ of the others that is much more than it was.
    """
    (κ, unknown, step), (kinds, goals, allowed, bits) = move, about
    for fraction in _FRACTIONS:
        moved = _moved(κ, unknown, step, fraction)
        trial = _tried(goal, curves, moved, before.tops, kinds, goals, bits)
        if trial is None:
            continue
        falls = _largest(trial.residuals) < _FALLS * _largest(before.residuals)
        if falls or _relative(trial, allowed) < max(_FALLS * _relative(before, allowed), 1):
            return trial, moved
    return None, κ


def _largest(residuals: Sequence[Mpf]) -> Mpf:
    return max(abs(r) for r in residuals)


def _relative(trial: _Trial, allowed: Sequence[Mpf]) -> Mpf:
    """Return the largest residual over what its action allows."""
    return max(abs(r) / a for r, a in zip(trial.residuals, allowed, strict=True))


def _tried(
    goal: Goal, curves: Sequence[RadicandCurve], κ: list[Mpf], tops: list[Mpf], kinds: Sequence[str],
    goals: list[Mpf], bits: int,
) -> _Trial | None:  # fmt: skip
    """Evaluate J and ∂J/∂α; None where a coordinate is not bounded, or of another kind."""
    solution, context = goal.solution, multiprecision(bits)
    tops = [_top(curve, κ, top, bits) for curve, top in zip(curves, tops, strict=True)]
    jets = [curve.exactly(top, κ, bits) for curve, top in zip(curves, tops, strict=True)]
    values = dict(goal.values)
    constants = {name: number(x, source=name) for name, x in zip(solution.constants, κ, strict=True)}
    # exact where they are known: κ holds binary numbers next to them
    constants |= goal.constants
    for curve, top, jet, direction in zip(curves, tops, jets, goal.directions, strict=True):
        coordinate = solution.system.coordinate(curve.name)
        values[coordinate.symbol] = number(top, source=curve.name)
        # the maximum of p² is inside the well whatever J is; where p² < 0 there, J is continued below zero
        p = number(abs(jet[0]) ** 0.5, source=curve.name) * direction
        values[coordinate.momentum] = p - solution.shift[curve.name].subs(values)
    initial = Initial(values, constants, goal.exact)
    located: dict[str, Located] = {}
    residuals, slopes, whole = [], [], True
    for i, (curve, J, (squared, _, bend)) in enumerate(zip(curves, goals, jets, strict=True)):
        begin = replace(coordinate_start(solution, initial, curve.name), parts=goal.parts)
        # J → p²ₘₐₓ/√(−2 (p²)″) goes on through zero, so that Newton's method may come from p² < 0
        if not J or not squared > 0:
            if not bend < 0:
                return None
            root = (-bend / 2) ** 0.5
            residuals.append(J - squared / (2 * root))
            slopes.append([w / root for w in begin.radicand.weights(tops[i], bits)])
            whole = whole and not J
            if not J:
                located[curve.name] = at_rest(replace(begin, exact=None, forward=0), goal.digits)
            continue
        try:
            place = between_walls(checked(begin), curve.walls, goal.digits)
        except (NotConvergedError, ForbiddenMotionError):
            return None
        coordinate_motion = place.coordinate_motion
        if coordinate_motion.bounded is None or coordinate_motion.action is None or coordinate_motion.rests:
            return None
        # on the other side of a separatrix J is of another family, and no small residual would mean anything
        if coordinate_motion.rotates != (kinds[i] == "rotation"):
            return None
        located[curve.name] = place
        residuals.append(J - abs(coordinate_motion.action))
        slopes.append([context.convert(coordinate_motion.growth(j)) for j in range(len(κ))])
    return _Trial(Torus(initial, located, slopes) if whole else None, tops, residuals, slopes)


def _top(curve: RadicandCurve, κ: list[Mpf], top: Mpf, bits: int) -> Mpf:
    """Return the maximum of p² next to a place, by Newton's method on (p²)′.

    The place itself where p² has none there.
    """
    _, slope, bend = curve.exactly(top, κ, bits)
    # Newton's own step says how far the maximum is: four of them hold it, and not the next hill
    farthest = 4 * abs(slope / bend) if bend < 0 else 0 * top
    low, high = max(top - farthest, curve.lower), min(top + farthest, curve.upper)
    place = stationary(
        lambda q: curve.exactly(q, κ, bits), top, lambda bend, q: bend < 0 and low <= q <= high,
        lambda q: abs(q) * top.context.ldexp(1, 8 - bits), 12 + bits.bit_length(),
    )  # fmt: skip
    return top if place is None else place


def between_walls(start: CoordinateStart, walls: tuple[bool, bool], digits: int) -> Located:
    """Classify and integrate the motion of one coordinate that some ends of its domain throw back.

    Args:
        start: the coordinate, at a place inside its domain.
        walls: whether the lower and the upper end of the domain throw it back.
        digits: decimal digits asked.

    Returns:
        The motion; ends that it is thrown back by are of the kind ``wall``.

    Raises:
        NotConvergedError: a zero of p² could not be decided, or an integrand stays rough.
    """
    if not any(walls):
        return locate(start, digits)
    # with one cell from wall to wall the rule for kinks throws the momentum back at its ends
    whole = replace(start, cells=(Cell(start.lower, start.upper, start.radicand),), winding=None)
    lower, upper = (_thrown_back(kinks.reached(whole, side, digits), walls[side > 0]) for side in (-1, 1))
    if "wall" not in {lower.end.kind, upper.end.kind} or not {lower.end.kind, upper.end.kind} <= {"turning", "wall"}:
        return locate(start, digits)
    return Located(kinks.libration(whole, lower, upper, start.forward, digits), lower.end, upper.end)


def _thrown_back(reached: kinks.Reached, wall: bool) -> kinks.Reached:
    end = reached.end
    return reached._replace(end=End("wall", end.place)) if wall and end.kind == "boundary" else reached
