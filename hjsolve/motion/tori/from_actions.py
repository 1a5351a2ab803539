"""A motion from its actions and angles: what ``Solution.motion(actions=…, angles=…)`` does.

Read what is given, find the tori that may have the actions (``search.py``), choose one, make its constants exact
(``polish.py``) and start the motion at the angles (``angles_given.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.floats import bits_for
from hjsolve.errors import InvalidInputError, MissingValueError, SeveralToriError
from hjsolve.formulas.read import number
from hjsolve.mechanics.kinks import refuse_kinks
from hjsolve.motion import quantities
from hjsolve.motion.initial_data import Initial, all_exact, parameter_values, sign, to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.separated import SeparatedMotion, turning_points
from hjsolve.motion.starting import motion_of, started
from hjsolve.motion.tori.angles_given import started_at
from hjsolve.motion.tori.polish import Goal, Torus, polished
from hjsolve.motion.tori.proved import proved_torus
from hjsolve.motion.tori.radicand_curve import RadicandCurve, curves_of
from hjsolve.motion.tori.search import ActionRange, Candidate, Meant, Wanted, action_ranges, candidates
from hjsolve.solution.quadratures import Solution
from hjsolve.time_law.torus import torus_equations

Values = Mapping[str, object]
_KINDS = ("libration", "rotation", "equilibrium")
_ALIKE = 1e-2
"""By what part of its width the ends of a libration may differ, and by what part J, from starts of one torus."""


@dataclass(frozen=True)
class AskedTorus:
    """Actions whose tori are asked for.

    Attributes:
        solution: what is solved.
        values: symbol → exact number, of the parameters and of ignorable coordinates with their momenta.
        constants: name → exact number, of those that are known: the ignorable momenta.
        actions: coordinate → J, exact.
        digits: asked.
        parts: what is integrated.
        exact: False where some input was a float.
        curves: p² of the separated coordinates.
    """

    solution: Solution
    values: Mapping[sp.Symbol, sp.Expr]
    constants: Mapping[str, sp.Expr]
    actions: Mapping[str, sp.Expr]
    digits: int
    parts: frozenset[str]
    exact: bool
    curves: tuple[RadicandCurve, ...]


def asked_torus(
    solution: Solution, values: Mapping[sp.Symbol, sp.Expr], actions: Mapping[str, sp.Expr], digits: int,
    parts: frozenset[str], *, exact: bool, walls: Mapping[str, tuple[bool, bool]] | None = None,
    action: float | None = None,
) -> AskedTorus:  # fmt: skip
    """Put together what the search for a torus needs.

    Args:
        solution: what is solved.
        values: parameter → exact number.
        actions: every coordinate that has one → J, exact.
        digits: asked.
        parts: what is integrated.
        exact: False where some input was a float.
        walls: separated coordinate → which ends of its domain throw it back (lower, upper); none where left out.
        action: the size of actions that matter, > 0; None where it is not known.
    """
    values, constants = dict(values), {}
    for c in solution.system.coordinates:
        if c.name not in solution.coordinates:
            # J of an ignorable angle is its momentum, and where it is does not matter to the torus
            values |= {c.symbol: sp.Integer(0), c.momentum: actions[c.name]}
            constants[c.momentum.name] = actions[c.name]
    curves = tuple(curves_of(solution, values, walls or {}, action)) if solution.coordinates else ()
    return AskedTorus(solution, values, constants, actions, digits, parts | {"action", "time"}, exact, curves)


def candidates_of(asked: AskedTorus, kinds: Values, meant: Meant | None = None) -> Iterator[Candidate]:
    """Yield the tori in doubles that may have the actions.

    Args:
        asked: the actions.
        kinds: separated coordinate → the kind that is meant; others are left out.
        meant: tells of the intervals in which the coordinates move whether they are meant; None for all.
    """
    return candidates(asked.solution, asked.values, asked.curves, wanted_of(asked), kinds, meant)


def tori_of(asked: AskedTorus, found: Iterable[Candidate]) -> list[tuple[Candidate, Torus]]:
    """Return the tori that have the actions to the digits asked, each once.

    Args:
        asked: the actions.
        found: where Newton's method begins.
    """
    tori: list[tuple[Candidate, Torus]] = []
    for candidate in found:
        # Newton's method in many digits would only find the same torus again
        if any(_leads_to(candidate, other, torus) for other, torus in tori):
            continue
        torus = polished(_goal(asked, candidate), asked.curves, candidate)
        if torus is not None and not any(_same(torus, other) for _, other in tori):
            tori.append((candidate, torus))
    return tori


def _leads_to(candidate: Candidate, other: Candidate, torus: Torus) -> bool:
    """Return whether Newton's method leads from a candidate to a torus that was found from another one.

    It does where the two have the same turning points, nearly, and J differs by little between their constants: within
    one family J(α) has an inverse.
    """
    κ = np.array([float(to_bits(x)(64)) for x in torus.initial.constants.values()])
    for a, b in zip(candidate.cycles, other.cycles, strict=True):
        alike = _ALIKE * (b.high - b.low)
        if a.kind != b.kind or abs(a.low - b.low) > alike or abs(a.high - b.high) > alike:
            return False
        if not abs(float(a.slopes @ (κ - candidate.constants))) <= _ALIKE * abs(a.action):
            return False
    return True


def motion_on_torus(
    solution: Solution, *, actions: Values, angles: Values | None, q: Values | None, kinds: Values | None,
    parameters: Values | None, t0: object, digits: int, parts: frozenset[str], certified: bool = False,
) -> Motion:  # fmt: skip
    """Start a motion from its actions and the angles at t₀.

    Args:
        solution: what is solved.
        actions: every separated coordinate and every ignorable angle → J.
        angles: the same names → θ at t₀ in radians; 0 where left out.
        q: coordinates → a place in the well that is meant.
        kinds: separated coordinates → the kind that is meant.
        parameters: name → number, where it differs from the default.
        t0: time of the angles.
        digits: relative digits wanted, at least 15.
        parts: what is integrated.
        certified: whether constants, turning points, frequencies and periods are proved.

    Raises:
        InvalidInputError: no torus has these actions, or several have; a name that is not known.
        MissingValueError: an action is missing.
        NotConvergedError: an integral did not converge to the digits asked.
    """
    refuse_kinks(solution.system.kinks, "actions=")
    names = names_of_actions(solution)
    J = _numbers(actions, names, "actions")
    if missing := [name for name in names if name not in J]:
        raise MissingValueError(f"actions: no value for {', '.join(missing)}; all of {', '.join(names)} are needed")
    θ = dict.fromkeys(names, sp.Integer(0)) | _numbers(angles or {}, names, "angles")
    values = parameter_values(solution.system, arguments.table(parameters, "parameters", '{"m": 1}'))
    asked = asked_torus(solution, values, J, digits, parts, exact=all_exact(actions, angles, parameters))
    exact_t0 = number(t0, source="t0")
    # all coordinates are ignorable: the angles are the coordinates themselves
    if not solution.coordinates:
        values = {**asked.values, **{c.symbol: θ[c.name] for c in solution.system.coordinates}}
        initial = Initial(values, asked.constants, asked.exact)
        return started(solution, initial, exact_t0, digits, parts, certified=certified)
    kinds = kinds_given(solution, kinds or {}, _KINDS)
    left = _left(solution, asked.curves, list(candidates_of(asked, kinds)), (q or {}, kinds))
    tori = tori_of(asked, left)
    if not tori:
        raise InvalidInputError(_no_torus(asked, kinds))
    # J does not tell wells of equal area, or motions inside and above a barrier, from one another
    if len(tori) > 1:
        words = "; ".join(sorted(_in_words(asked.curves, candidate) for candidate, _ in tori))
        raise SeveralToriError(f"actions: several tori have them; choose one by q={{…}} or kinds={{…}}: {words}")
    candidate, torus = tori[0]
    coordinate_motions = [
        stays for place in torus.located.values() if (stays := place.coordinate_motion.bounded) is not None
    ]
    equations = torus_equations(coordinate_motions, bits_for(digits, 128))
    motion = SeparatedMotion(
        solution, torus.initial, exact_t0, digits, asked.parts, torus.located, equations,
        turning_points(torus.located, digits), quantities.frequencies(solution, torus.initial, equations, digits),
    )  # fmt: skip
    result = motion_of(started_at(motion, θ))
    if not certified:
        return result
    proved = proved_torus(motion, _goal(asked, candidate), J, asked.curves, digits)
    return replace(
        result, constants=proved.constants, turning_points=proved.turning_points, actions=proved.actions,
        frequencies=proved.frequencies, periods=proved.periods,
    )  # fmt: skip


def start_on_torus(
    solution: Solution, given: Mapping[str, Any], t0: object, digits: int, parts: frozenset[str], *,
    certified: bool = False,
) -> Motion:  # fmt: skip
    """Start a motion from actions and angles, and keep what was given.

    Args:
        solution: what is solved.
        given: ``actions``, ``angles``, ``q``, ``kinds`` and ``parameters`` of ``motion_on_torus``.
        t0: time of the angles.
        digits: relative digits wanted.
        parts: what is integrated.
        certified: as of ``motion_on_torus``.

    Raises:
        InvalidInputError, MissingValueError, NotConvergedError: as of ``motion_on_torus``.
    """
    kept = {name: None if group is None else dict(group) for name, group in given.items()}
    motion = motion_on_torus(
        solution, **given, t0=t0, digits=max(digits, FLOAT_DIGITS), parts=parts, certified=certified
    )
    return replace(motion, given=kept, again=partial(_again, solution, kept, t0, parts))


def _again(
    solution: Solution, given: Mapping[str, object], t0: object, parts: frozenset[str], digits: int,
    change: Mapping[str, object],
) -> Motion:  # fmt: skip
    """Start a motion anew from what was given, with other digits or changed input."""
    return start_on_torus(solution, {**given, **change}, t0, digits, parts)


def names_of_actions(solution: Solution) -> list[str]:
    """Return the coordinates that have an action.

    Raises:
        InvalidInputError: some coordinate never comes back.
    """
    names = []
    for c in solution.system.coordinates:
        if c.name not in solution.coordinates and c.domain.kind != "angle":
            raise InvalidInputError(
                f"actions: {c.name} does not come back in any motion, so there are no tori; give q={{…}} and p={{…}}"
            )
        names.append(c.name)
    return names


def _numbers(given: Values, names: Sequence[str], what: str) -> dict[str, sp.Expr]:
    for name in arguments.table(given, what, f'{{"{names[0]}": 1}}'):
        if name not in names:
            raise InvalidInputError(f"{what}: {name!r} has none in this solution; known are {', '.join(names)}")
    return {name: number(value, source=f"{what}[{name}]") for name, value in given.items()}


def _shift(solution: Solution, values: Mapping[sp.Symbol, sp.Expr], name: str) -> sp.Expr:
    """Return what a rotation adds to J for the action of its shell momentum P = p + A: the mean of A over a turn."""
    A, q = solution.shift[name].subs(values), solution.system.coordinate(name).symbol
    # ∮ p dq = ∮ P dq − ∮ A dq; over a libration the last term is 0, as the way there and back cancel
    return sp.S.Zero if A == 0 else sp.integrate(A, (q, 0, 2 * sp.pi)) / (2 * sp.pi)


def wanted_of(asked: AskedTorus) -> Wanted:
    """Return the actions in doubles, as the search takes them."""
    solution, constants, J = asked.solution, asked.constants, asked.actions
    names = list(solution.constants)
    shifts = [float(_shift(solution, asked.values, name)) for name in solution.coordinates]
    return Wanted(
        np.array([float(to_bits(J[name])(64)) for name in solution.coordinates]), np.array(shifts),
        np.array([float(to_bits(constants[name])(64)) if name in constants else 0.0 for name in names]),
        np.array([j for j, name in enumerate(names) if name not in constants]),
    )  # fmt: skip


def _goal(asked: AskedTorus, chosen: Candidate) -> Goal:
    solution, actions, directions = asked.solution, [], []
    for name, cycle in zip(solution.coordinates, chosen.cycles, strict=True):
        own = asked.actions[name]
        # of the shell momentum P, in which p² is even
        own += _shift(solution, asked.values, name) if cycle.kind == "rotation" else 0
        directions.append(-1 if sign(own) < 0 else 1)
        actions.append(abs(own))
    return Goal(
        solution, asked.values, asked.constants, actions, directions, asked.digits, asked.parts, asked.exact
    )  # fmt: skip


def kinds_given(
    solution: Solution, kinds: object, known: tuple[str, ...] = ("libration", "rotation")
) -> dict[str, str]:
    """Return the kinds of motion that are asked for, by separated coordinate.

    Raises:
        InvalidInputError: no separated coordinate, or a kind that is not known.
    """
    table = arguments.table(kinds, "kinds", '{"theta": "libration"}')
    for name, kind in table.items():
        if name not in solution.coordinates or kind not in known:
            raise InvalidInputError(
                f"kinds[{name}]: a separated coordinate ({', '.join(solution.coordinates)}) and one of "
                f"{', '.join(known)} are needed"
            )
    return {name: str(kind) for name, kind in table.items()}


def _left(
    solution: Solution, curves: Sequence[RadicandCurve], found: Sequence[Candidate],
    hints: tuple[Values, Values],
) -> list[Candidate]:  # fmt: skip
    """Return the tori that the hints leave.

    Raises:
        InvalidInputError: none is left.
    """
    q, kinds = hints
    places = _numbers(q, [c.name for c in solution.system.coordinates], "q")
    wells = {name: float(to_bits(x)(64)) for name, x in places.items()}
    left = [c for c in found if _fits(curves, c, wells, kinds)]
    if found and not left:
        words = "; ".join(sorted(_in_words(curves, c) for c in found))
        raise InvalidInputError(f"q: no torus with these actions is there; there are: {words}")
    return left


def _fits(curves: Sequence[RadicandCurve], candidate: Candidate, wells: Mapping[str, float], kinds: Values) -> bool:
    for curve, cycle in zip(curves, candidate.cycles, strict=True):
        kind = kinds.get(curve.name)
        if kind is not None and (cycle.kind == "rotation") != (kind == "rotation"):
            return False
        if curve.name in wells and cycle.kind != "rotation":
            margin = 1e-9 * (abs(cycle.high) + abs(cycle.low))
            q = wells[curve.name]
            if curve.turn:
                # the hint may be given a turn or more from the samples
                q += curve.turn * np.ceil((cycle.low - margin - q) / curve.turn)
            if not cycle.low - margin <= q <= cycle.high + margin:
                return False
    return True


def _same(one: Torus, other: Torus) -> bool:
    """Return whether two tori are the same: equal constants, and wells that overlap."""
    for a, b in zip(one.initial.constants.values(), other.initial.constants.values(), strict=True):
        x, y = to_bits(a)(128), to_bits(b)(128)
        if abs(x - y) > 1e-10 * max(abs(x), abs(y)):
            return False
    for name, place in one.located.items():
        ends = [(p.lower.place, p.upper.place) for p in (place, other.located[name])]
        (low, high), (under, over) = ends
        # equal constants do not make one torus: two wells that mirror each other have them
        if low and high and under and over and (low(128) > over(128) or under(128) > high(128)):
            return False
    return True


def _in_words(curves: Sequence[RadicandCurve], candidate: Candidate) -> str:
    parts = []
    for curve, cycle in zip(curves, candidate.cycles, strict=True):
        extent = "" if cycle.kind == "rotation" else f" from {cycle.low:.6g} to {cycle.high:.6g}"
        parts.append(f"{curve.name} {'rotation' if cycle.kind == 'rotation' else 'libration'}{extent}")
    return ", ".join(parts)


def _no_torus(asked: AskedTorus, kinds: Mapping[str, str]) -> str:
    words = ", ".join(f"{name} {float(to_bits(x)(64)):.6g}" for name, x in asked.actions.items())
    ranges = action_ranges(asked.solution, asked.values, asked.curves, wanted_of(asked))
    if not ranges:
        return (
            f"actions: no bounded motion with {words} was found; librations need J >= 0, and a separatrix or the "
            "energy of escape may limit J"
        )
    name = asked.curves[0].name
    told = "; ".join(sorted({_range_in_words(name, one) for one in ranges}))
    J = float(to_bits(asked.actions[name])(64))
    meant = [one for one in ranges if kinds.get(name) in (None, one.kind)]
    if any(one.least <= (abs(J) if one.kind == "rotation" else J) <= one.most for one in meant):
        return (
            f"actions: the motion with {words} was not found, though there are about {told}: it may lie nearer to an "
            "escape or a separatrix than is looked. Give constants={…} or q={…} and p={…}"
        )
    return f"actions: no bounded motion with {words} was found; librations need J >= 0; there are about {told}"


def _range_in_words(name: str, one: ActionRange) -> str:
    J = f"abs(J_{name})" if one.kind == "rotation" else f"J_{name}"
    most = "on" if np.isinf(one.most) else f"to {one.most:.3g}"
    extent = "" if one.kind == "rotation" or np.isinf(one.most) else f" within {one.low:.3g} and {one.high:.3g}"
    return f"{one.kind}s with {J} from {one.least:.3g} {most}{extent}"
