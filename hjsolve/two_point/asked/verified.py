"""Every motion that leaves two_point was run to its end: at the time asked it is at q1."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import NotConvergedError
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.state import State
from hjsolve.two_point.asked.question import TwoPlaceQuestion

_CLAIMS, _ROUNDING = 4.0, 1e-13
"""How many claimed errors of the state, and which part of its size, the end point may be off in doubles."""


def started(question: TwoPlaceQuestion, p: Mapping[str, Mpf]) -> Motion:
    """Start a motion at q0 and make sure that it is at q1 after the time asked.

    Args:
        question: what is asked.
        p: coordinate → momentum at q0, to more digits than asked.

    Raises:
        NotConvergedError: it is somewhere else.
    """
    motion = question.solution.motion(
        q=dict(question.q0), p=dict(p), parameters=dict(question.given), digits=question.digits
    )
    miss, allowed = end_point(question, motion)
    for name, distance in miss.items():
        if not distance <= allowed[name]:
            raise NotConvergedError(
                f"the motion ends {distance:.1e} from q1 in {name}, more than its errors allow; give more digits"
            )
    return motion


def end_point(question: TwoPlaceQuestion, motion: Motion) -> tuple[dict[str, float], dict[str, float]]:
    """Return how far a motion is from q1 at its end, and how far its errors and roundings allow, by coordinate.

    Args:
        question: what is asked.
        motion: that starts at q0.
    """
    state = motion.at(question.time)
    miss, allowed = {}, {}
    unit = max(_ROUNDING * 1e-2, 10.0**-question.digits) if question.digits > 15 else _ROUNDING
    for c in question.system.coordinates:
        goal = question.q1[c.name]
        miss[c.name] = abs(difference(state, c.name, goal, angle=c.domain.kind == "angle", digits=question.digits))
        size = max(abs(float(goal)), abs(float(state.q[c.name])), 1.0 if c.domain.kind == "angle" else 0.0)
        size = max(size, abs(float(question.q0[c.name])))
        allowed[c.name] = _CLAIMS * float(state.error.q[c.name]) + unit * size
    return miss, allowed


def difference(state: State, name: str, goal: sp.Expr, *, angle: bool, digits: int) -> float:
    """Return where a coordinate is, minus where it should be; modulo a turn for an angle.

    Args:
        state: at the end.
        name: of the coordinate.
        goal: exact.
        angle: whether whole turns do not count.
        digits: of the motion.
    """
    bits = int(3.33 * max(digits, 16)) + 40
    context = multiprecision(bits)
    apart = context.convert(state.q[name]) - to_bits(goal)(bits)
    if angle:
        turn = 2 * context.pi
        apart = apart - turn * context.nint(apart / turn)
    return float(apart)
