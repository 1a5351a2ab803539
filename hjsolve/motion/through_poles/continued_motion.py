"""A motion computed in coordinates continued through poles, expressed in the given ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import EPS, bits_for, multiprecision
from hjsolve.arithmetic.number_types import AtTimes, Elementwise, Reals, Truth
from hjsolve.errors import ForbiddenPlaceError, InvalidInputError, NotConvergedError, NotSeparableError
from hjsolve.motion import quantities
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.initial_data import Initial, clean, domain_ends, with_numbers
from hjsolve.motion.motion import Motion
from hjsolve.motion.placing import with_place
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.starting import started
from hjsolve.motion.state import Errors, State
from hjsolve.motion.through_poles.continuation import Continuation, Reflection, continued_coordinates
from hjsolve.motion.through_umbilics.starting import goes_on_at_umbilics
from hjsolve.motion.transformed_motion import TransformedMotion
from hjsolve.solution.quadratures import Solution, solve

_NOISE_BITS = 2000
"""A constant that is so small and a fraction of so many digits is the rounding of 0 (``charted.initial_map``)."""


@dataclass(frozen=True, eq=False, repr=False)
class ContinuedMotion(TransformedMotion):
    """A motion that passes poles of its coordinates: p_φ = 0, and nothing but the coordinates ends there.

    Kinds, turning points, actions and frequencies are those of the continued coordinates: r < 0 is the place −r with
    φ + π, θ beyond its end the place before it with φ + π. States are expressed in the given coordinates.

    Attributes:
        given_solution: of the system as given.
        given_initial: initial data and constants as given.
        continued: how the coordinates run on.
    """

    given_solution: Solution = field(kw_only=True, repr=False)
    given_initial: Initial = field(kw_only=True, repr=False)
    continued: Continuation = field(kw_only=True, repr=False)

    @property
    def solution(self) -> Solution:
        """The solution of the system as given."""
        return self.given_solution

    @property
    def initial(self) -> Initial:
        """The exact initial data and constants, as given."""
        return self.given_initial

    def at(self, t: object) -> State:
        """As ``Motion.at``; the state is in the given coordinates."""
        state = reduced(self.continued, self.initial, self.within.at(t), self.solution)
        return with_place(self.solution.system, self.initial.values, state)

    @property
    def dropped(self) -> tuple[str, ...]:
        """The angles whose momentum is zero and that the continued coordinates do without."""
        within = self.within
        more = within.dropped if isinstance(within, ContinuedMotion) else ()
        crossing = self.continued
        return more if crossing.carried else (crossing.angle, *more)

    def unfolded(self, t: object) -> State:
        """Return the state with coordinates that run on through the poles, and the dropped angles as they were at t₀.

        Places are smooth functions of these where x, y, z are smooth functions of the coordinates.

        Args:
            t: a time or an array of times.
        """
        within, crossing = self.within, self.continued
        state = within.unfolded(t) if isinstance(within, ContinuedMotion) else within.at(t)
        if crossing.carried:
            return state
        name = crossing.angle
        some = next(iter(state.p.values()))
        many = np.asarray(some).dtype == object
        begin = to_bits(self.initial.values[self.solution.system.coordinate(name).symbol])(256)
        angle, nothing = begin if many else float(begin), 0 * some

        def errors() -> Errors:
            own = state.error
            blank = 0 * np.asarray(next(iter(own.q.values())), dtype=float)
            return Errors(
                {**own.q, name: blank + _unit(state) * abs(float(begin))}, {**own.p, name: blank},
                {**own.velocity, name: blank},
            )  # fmt: skip

        return State(
            state.t, {**state.q, name: angle + nothing}, {**state.p, name: nothing},
            {**state.velocity, name: nothing}, {}, state.status, errors,
        )  # fmt: skip

    def _refuse_given(self, name: str) -> None:
        crossing = self.continued
        if name == crossing.angle:
            moves = "jumps" if crossing.carried else "is constant in this motion but for jumps"
            raise InvalidInputError(f"{name}: {moves} by pi at the poles; at(t).q[{name!r}] gives it")


def motion_through_poles(
    solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str], *, certified: bool = False
) -> Motion:
    """Start a motion from data that were read before; where it ends at a pole of the coordinates only, it goes on.

    Args:
        parts: what is integrated, from ``parts_of``.
        certified: as in ``start``.

    Raises:
        ForbiddenMotionError: no real motion has these constants.
        InvalidInputError: it starts at a pole that is more than one of the coordinates.
        NotConvergedError: a turning point or an integral did not converge to the digits asked.
    """
    angles = [
        c.name
        for c in solution.separation.shell.ignorable
        if initial.values[c.momentum] == 0 and c.domain.kind == "angle"
    ]
    at_end = _at_an_end(solution, initial)
    motion: Motion | None = None
    if not at_end:
        try:
            motion = started(solution, initial, t0, digits, parts, certified=certified)
        except NotConvergedError:
            if not angles:
                raise
    # most motions: nothing is solved anew for them
    if motion is not None and not _meets_a_pole(motion):
        return goes_on_at_umbilics(motion) or motion
    # p_φ = 0 makes the plane φ = const invariant: there the coordinate runs on through the pole as in that plane
    for name in angles:
        crossing = continued_coordinates(solution.system, name)
        on = (
            None
            if crossing is None
            else _continued(crossing, solution, initial, t0, digits, parts, certified=certified)
        )
        if on is not None:
            return on
    if at_end:
        raise ForbiddenPlaceError(
            f"q: the motion starts where {at_end} is at an end of its domain, and T or V is singular there; start it "
            "at a place a little before"
        )
    return motion or started(solution, initial, t0, digits, parts, certified=certified)


def _meets_a_pole(motion: Motion) -> bool:
    """Return True where a coordinate reaches an end of its domain, before or after the initial time."""
    coordinate_motions = [place.coordinate_motion for place in motion.separated.located.values()]
    return any(
        coordinate_motion.ends(side) in {"boundary", "fall"}
        for coordinate_motion in coordinate_motions
        for side in (1, -1)
    )


def _at_an_end(solution: Solution, initial: Initial) -> str:
    for c in solution.system.coordinates:
        if initial.values[c.symbol] in domain_ends(solution.system, c.name, initial.values):
            return c.name
    return ""


def _continued(
    crossing: Continuation, solution: Solution, initial: Initial, t0: sp.Expr, digits: int, parts: frozenset[str], *,
    certified: bool,
) -> ContinuedMotion | None:  # fmt: skip
    """Return the motion in the continued coordinates; None where it does not come from them."""
    try:
        other = solve(crossing.system)
        within = motion_through_poles(other, _carried(other, solution, initial), t0, digits, parts, certified=certified)
    except (NotSeparableError, NotConvergedError):
        return None
    kinds = {c.name: within.kinds.get(c.name, "ignorable") for c in solution.system.coordinates}
    bits = bits_for(max(digits, FLOAT_DIGITS), 128)
    constants = {
        n: quantities.rounded(to_bits(x)(bits), max(digits, FLOAT_DIGITS)) for n, x in initial.constants.items()
    }
    motion = ContinuedMotion.of(within, given_solution=solution, given_initial=initial, continued=crossing)
    return replace(motion, kinds=kinds, constants={**within.constants, **constants})


def _carried(other: Solution, solution: Solution, initial: Initial) -> Initial:
    """Return the initial data without the dropped angle, and the constants of the continued system."""
    values = {p.symbol: initial.values[p.symbol] for p in other.system.parameters}
    for c in other.system.coordinates:
        old = solution.system.coordinate(c.name)
        values |= {c.symbol: initial.values[old.symbol], c.momentum: initial.values[old.momentum]}
    constants = {name: _without_noise(clean(with_numbers(c.expression, values))) for name, c in other.constants.items()}
    if "E" in constants and "E" in initial.constants:
        # E as it was given: worked out anew from q and p it may be another formula of the same number
        constants["E"] = initial.constants["E"]
    return Initial(values, constants, initial.exact)


def _without_noise(value: sp.Expr) -> sp.Expr:
    # the last bits of a float make 10⁻³⁰ of a constant that should be 0: the pole would be missed
    if value.is_Rational and value.q.bit_length() > 2 * _NOISE_BITS and abs(value.p) << _NOISE_BITS < value.q:
        return sp.S.Zero
    return value


def reduced(crossing: Continuation, initial: Initial, state: State, solution: Solution) -> State:
    """Return a state in the given coordinates.

    Args:
        crossing: how the coordinates were continued.
        initial: data as given.
        state: in the continued coordinates.
        solution: of the system as given.
    """
    q, p, v, turns = dict(state.q), dict(state.p), dict(state.velocity), dict(state.turns)
    odd = np.zeros(np.shape(state.status), dtype=bool)
    for name, reflection in crossing.reflections.items():
        q[name], turned = _reflection(reflection, initial, q[name])
        p[name], v[name] = (
            np.where(turned, -x, x) if np.shape(turned) else (-x if turned else x) for x in (p[name], v[name])
        )
        # two reflections at once lead to the same meridian
        odd = odd ^ turned
        turns.pop(name, None)
    angle = solution.system.coordinate(crossing.angle)
    if crossing.carried:
        q[angle.name], over = _half_a_turn_on(q[angle.name], odd)
        turns[angle.name] = turns[angle.name] + over
    else:
        nothing = 0 * next(iter(p.values()))
        # beyond an odd number of poles the same place in space has φ + π
        q[angle.name] = _either_side(initial.values[angle.symbol], odd, nothing) + nothing
        p[angle.name] = v[angle.name] = nothing
    names = [c.name for c in solution.system.coordinates]

    def errors() -> Errors:
        return _errors(crossing, state, initial, names)

    def ordered(group: Mapping[str, AtTimes]) -> dict[str, AtTimes]:
        return {name: group[name] for name in names}

    return State(state.t, ordered(q), ordered(p), ordered(v), turns, state.status, errors)


def _either_side(begin: sp.Expr, odd: Elementwise, like: Elementwise) -> AtTimes:
    """Return an angle that stands still, and half a turn on where an odd number of poles was passed."""
    many = np.asarray(like).dtype == object
    π = multiprecision(256).pi if many else np.pi
    start = to_bits(begin)(256 if many else 64)
    low = start if many else float(start)
    high = _principal(low + π, π)
    low = _principal(low, π)
    side: Elementwise = np.where(odd, high, low) if np.shape(odd) else (high if odd else low)
    return side


def _half_a_turn_on(angle: Elementwise, odd: Elementwise) -> tuple[Elementwise, Elementwise]:
    """Angles in (−π, π] that go on by π where an odd number of poles was passed, and the whole turns that makes."""
    some = np.ravel(np.asarray(angle, dtype=object))[:1]
    context = next((x.context for x in some if hasattr(x, "context")), None)
    π = np.pi if context is None else +context.pi
    if not np.shape(angle):
        once = bool(odd and angle > 0)
        return (angle + (-π if once else π) if odd else angle), int(once)
    over = np.asarray(odd & (np.asarray(angle) > 0), dtype=bool)
    return angle + np.where(odd, np.where(over, -π, π), 0 * π), over.astype(np.int64)


def _principal(angle: Elementwise, π: Elementwise) -> Elementwise:
    return angle - 2 * π if angle > π else angle


def _reflection(reflection: Reflection, initial: Initial, s: Elementwise) -> tuple[Elementwise, Truth]:
    """Return the given coordinate, and where it was reached through an odd number of poles."""
    low, high = (None if end is None else _number(end, initial, s) for end in (reflection.lower, reflection.upper))
    if low is not None and high is not None:  # s is an angle in (−π, π]
        # the continued coordinate is an angle of which the domain is one half of a turn
        turn = 2 * (high - low)
        below, above = s < low, s > high
        inside = np.where(below, 2 * low - s, np.where(above, 2 * high - s, s))
        far = np.where(inside > high, inside - turn, np.where(inside < low, inside + turn, inside))
        turned = below | above
        return (far if np.shape(s) else far.item()), turned
    end: Elementwise = low if low is not None else high
    turned = s < end if low is not None else s > end
    return (np.where(turned, 2 * end - s, s) if np.shape(s) else (2 * end - s if turned else s)), turned


def _number(end: sp.Expr, initial: Initial, like: Elementwise) -> Elementwise:
    bits = next((x.context.prec for x in np.ravel(np.asarray(like, dtype=object)) if hasattr(x, "context")), 0)
    value = to_bits(end.subs(initial.values))(bits or 64)
    return value if bits else float(value)


def _unit(state: State) -> float:
    """Relative rounding of the values of a state."""
    some = np.ravel(np.asarray(next(iter(state.q.values()))))
    if some.dtype != object:
        return EPS
    return float(2.0 ** -max((x.context.prec for x in some if hasattr(x, "context")), default=53))


def _errors(crossing: Continuation, state: State, initial: Initial, names: list[str]) -> Errors:
    """Return those of the continued state; at a pole itself the side of the axis and the sign of momenta are open."""
    q, p, v = dict(state.error.q), dict(state.error.p), dict(state.error.velocity)
    unit = _unit(state)
    angle = 4 * unit * np.pi + 0 * np.asarray(next(iter(q.values())), dtype=float)
    for name, reflection in crossing.reflections.items():
        near = np.zeros(np.shape(state.status), dtype=bool)
        for end in (reflection.lower, reflection.upper):
            if end is not None:
                value = float(to_bits(end.subs(initial.values))(64))
                away = np.abs(np.asarray(state.q[name], dtype=float) - value)
                # within the error of a pole: both meridians are possible, and both signs of the momenta
                near = near | (np.minimum(away, np.abs(away - 2 * np.pi)) <= q[name])
        angle = np.where(near, np.pi, angle)
        for group, values in ((p, state.p), (v, state.velocity)):
            group[name] = group[name] + np.where(near, 2 * np.abs(np.asarray(values[name], dtype=float)), 0.0)
        q[name] = q[name] + 4 * unit * np.pi
    if crossing.carried:
        q[crossing.angle] = q[crossing.angle] + angle
    else:
        q[crossing.angle] = angle
        p[crossing.angle] = v[crossing.angle] = 0 * angle

    def ordered(group: Mapping[str, Reals]) -> dict[str, AtTimes]:
        return {n: group[n] if np.shape(group[n]) else float(group[n]) for n in names}

    return Errors(ordered(q), ordered(p), ordered(v))
