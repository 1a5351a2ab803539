"""action_integral(): Hamilton's ∫ L dt along a path that need not be a motion (Greenwood §4-1, (4-2), P4-7).

With q = q(t) and q̇ = dq/dt put into L = T − V it is a function of the time alone. ẇ = L(t) is integrated by Taylor
series with a proved remainder, as the equations of a driven system are (``extended.quadratic_flow``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.shown import Shown
from hjsolve.errors import InvalidInputError
from hjsolve.extended.quadratic_flow import QuadraticFlow
from hjsolve.formulas.read import formula_of, number
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System
from hjsolve.motion.initial_data import parameter_values
from hjsolve.precision import one_at_a_time

_EXAMPLE = '{"x": "t**2"}'


@dataclass(frozen=True, repr=False)
class PathAction(Shown):
    """The action of a path.

    Attributes:
        path: coordinate → its formula in the time.
        lagrangian: L along the path, in the time and the parameters.
        between: the times.
        value: ∫ L dt with its error.
    """

    path: Mapping[str, sp.Expr]
    lagrangian: sp.Expr
    between: tuple[sp.Expr, sp.Expr]
    value: Estimate


@arguments.with_known_names('action_integral("harmonic-oscillator", {"q": "sin(t)"}, between=(0, 1))')
@one_at_a_time
def action_integral(
    system: System | str | Path, path: Mapping[str, object], *, between: object,
    parameters: Mapping[str, object] | None = None, digits: int = 15,
) -> PathAction:  # fmt: skip
    """Compute Hamilton's integral ∫ L dt along a path.

    Args:
        system: the system, or the id or file of a catalog entry.
        path: every coordinate → its formula in the time t and in parameters, as text or sympy expression; any smooth
            function, a motion or not.
        between: the first and the last time.
        parameters: values that differ from the defaults.
        digits: of the value, relative to the larger of it and 1.

    Returns:
        ``PathAction``: L along the path, and the integral with a proved error.

    Raises:
        InvalidInputError: a coordinate without a formula, or V with kinks, or a relativistic particle.
        MissingValueError: a parameter without a value.
        NotConvergedError: L is singular on the path.

    Example:
        >>> import hjsolve
        >>> fall = hjsolve.System({"y": "line"}, "m/2*dot(y)**2", "m*g*y", {"m": 1, "g": 10})
        >>> straight = hjsolve.action_integral(fall, {"y": "-5*t"}, between=(0, 1))
        >>> motion = hjsolve.action_integral(fall, {"y": "-5*t**2"}, between=(0, 1))
        >>> motion.value.value, straight.value.value  # the motion has the least
        (33.333333333333336, 37.5)

    References:
        Greenwood, Classical Dynamics (1977), (4-2), §4-1, P4-7.
    """
    system = system_of(system, "action_integral")
    if system.kinks or system.relativity is not None:
        raise InvalidInputError("action_integral: V without kinks and a particle that is not relativistic are needed")
    table = arguments.one_for_each(path, "path", [c.name for c in system.coordinates], _EXAMPLE)
    if not isinstance(between, (tuple, list)) or len(between) != 2:
        raise InvalidInputError(f"between: two times are needed, such as (0, 1), not {arguments.described(between)}")
    start, stop = (number(t, source="between") for t in between)
    time = system.time if system.time is not None else sp.Symbol(time_name(system), real=True)
    letters = {p.name: p.symbol for p in system.parameters} | {time.name: time}
    formulas = {name: formula_of(f, letters, source=f"path.{name}") for name, f in table.items()}
    put = {c.symbol: formulas[c.name] for c in system.coordinates}
    put |= {c.velocity: sp.diff(formulas[c.name], time) for c in system.coordinates}
    L = (system.kinetic - system.potential).xreplace(put)
    given = {**(parameters or {}), **({time.name: start} if system.time is not None else {})}
    values = {s: v for s, v in parameter_values(system, given).items() if s != time}
    wanted = arguments.digits(digits)
    flow = QuadraticFlow(sp.zeros(2, 2).as_immutable(), sp.ImmutableMatrix([L.xreplace(values), 0]), time)
    ((found,),), (error,), _ = flow.integrate([[sp.S.Zero, sp.S.Zero]], start, [stop], max(wanted, 15))
    value = float(found[0]) if wanted <= 15 else found[0]
    rounding = abs(found[0]) * (2.0**-53 if wanted <= 15 else found[0].context.mpf(10) ** -wanted)
    bound = float(error + rounding) * (1 + 2.0**-50)
    return PathAction(formulas, L, (start, stop), Estimate(value, bound))
