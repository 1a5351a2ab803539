r"""Matrices in the user's coordinates where those separated are others: a change of coordinates is canonical too.

With (x, p) = f(u, p_u; λ) and C = ∂f/∂(u, p_u), a matrix M of (u, p_u) is C(t) M C(t₀)⁻¹ in (x, p), and with fixed
(x, p)(t₀) a parameter moves (u, p_u)(t₀) by −C⁻¹ ∂f/∂λ.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.number_types import Context, Numbers
from hjsolve.arithmetic.tape import Tape
from hjsolve.coordinates.chart import Chart
from hjsolve.coordinates.charts.curvilinear import CurvilinearMap
from hjsolve.coordinates.charts.outer_map import SphereMap
from hjsolve.errors import InvalidInputError
from hjsolve.motion.charted.charted_motion import ChartedMotion
from hjsolve.motion.charted.state_map import formulas_of
from hjsolve.motion.derivatives.bounded import Bounded
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.formulas_at_places import tape_of
from hjsolve.motion.motion import Motion
from hjsolve.motion.separated import SeparatedMotion
from hjsolve.motion.through_poles.continued_motion import ContinuedMotion

_STEP = 60
"""Inputs are moved by 2^−60 of themselves to see what their last digits do."""


@dataclass(frozen=True, eq=False)
class UsersCoordinates:
    """The user's coordinates, by those separated.

    Attributes:
        names: of the user's coordinates, in their order.
        chart: how they are tied together.
        parameters: whether these are varied.
    """

    names: tuple[str, ...]
    chart: Chart
    parameters: bool

    def changes(self, source: SeparatedMotion, q: dict[str, Numbers], p: dict[str, Numbers], context: Context):  # type: ignore[no-untyped-def]
        """Return C and ∂f/∂λ at m states, a list of pairs.

        Args:
            source: the motion in the separated coordinates, in more digits than are asked.
            q, p: separated coordinate → many digits, shape (m,).
        """
        tape, fixed = _slopes(self.chart, self.parameters)
        field, n = Multi(context.prec), len(self.names)
        numbers = [to_bits(source.initial.values[s])(context.prec) for s in fixed]
        # one-sided difference quotient of C: what the last digits asked of a state change in it
        lost = 10.0 ** (3 - source.digits) * 2.0**_STEP
        result = []
        for row in zip(*(group[name] for group in (q, p) for name in self.chart.coordinates), strict=True):
            here = [context.convert(x) for x in row]
            value = np.array(tape.run(field, [*here, *numbers]), dtype=object)
            moved = [x + context.ldexp(abs(x) or 1, -_STEP) for x in here]
            beside = np.array(tape.run(field, [*moved, *numbers]), dtype=object)
            error = lost * np.abs(beside - value).astype(float)
            table = Bounded(value.reshape(2 * n, -1), error.reshape(2 * n, -1))
            result.append((table[:, : 2 * n], table[:, 2 * n :]))
        return result


def users_coordinates(motion: Motion, *, parameters: bool) -> UsersCoordinates | None:
    """Return the user's coordinates of a motion; None where they are those separated.

    Args:
        motion: any.
        parameters: whether these are varied.

    Raises:
        InvalidInputError: matrices cannot be expressed in the user's coordinates.
    """
    if isinstance(motion.as_solved, ContinuedMotion):
        raise InvalidInputError(
            "derivatives: not of a motion through a pole of its coordinates, where the angle jumps; give the system in "
            'Cartesian coordinates whose separated ones have no pole there, or start it with p of the angle "1e-9"'
        )
    if not isinstance(motion, ChartedMotion):
        return None
    if isinstance(motion.chart.outer, SphereMap | CurvilinearMap):
        raise InvalidInputError(
            "derivatives: not available in curvilinear coordinates for which others were found; those of the separated "
            "ones are motion.as_solved.derivatives(…), or give the system in Cartesian coordinates"
        )
    return UsersCoordinates(tuple(q.name for q in motion.chart.original.coordinates), motion.chart, parameters)


@lru_cache(maxsize=32)
def _slopes_of(
    formulas: tuple[sp.Expr, ...], inputs: tuple[sp.Symbol, ...], parameters: tuple[sp.Symbol, ...],
    fixed: tuple[sp.Symbol, ...],
) -> Tape:  # fmt: skip
    rows = [[sp.diff(f, x) for x in (*inputs, *parameters)] for f in formulas]
    return tape_of(tuple(e for row in rows for e in row), (*inputs, *fixed))


def _slopes(chart: Chart, parameters: bool) -> tuple[Tape, tuple[sp.Symbol, ...]]:
    n = len(chart.original.coordinates)
    formulas = formulas_of(chart)
    points, momenta = formulas[:n], formulas[2 * n : 3 * n]
    fixed = tuple(s.symbol for s in chart.system.parameters)
    own = tuple(chart.system.coordinate(name).momentum for name in chart.coordinates)
    varied = fixed if parameters else ()
    return _slopes_of((*points, *momenta), (*chart.symbols, *own), varied, fixed), fixed
