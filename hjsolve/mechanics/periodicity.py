"""Are T and V functions of an angle? Decided by the exact zero test of f(a + 2π) − f(a).

A coordinate declared ``angle`` is counted modulo 2π: its motion is taken modulo one turn, and actions are integrals
over one turn. That is wrong where T or V tells one turn from the next, as cos(a/2) or a do.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.algebra.reader import Reader
from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.point_values import CONTEXT, NoValueError, evaluate
from hjsolve.formulas.tokens import printable
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter
from hjsolve.mechanics.positive_definite import sample_points

_SECONDS = 2.0
_ROUNDING = CONTEXT.mpf(10) ** -50


def check_periodic(
    parts: Iterable[tuple[str, sp.Expr]], coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]
) -> None:
    """Refuse an angle that T or V is not a function of.

    What holds for all values of the parameters, or for their default values, is accepted: cos(n a) with n = 2, or with
    n declared integer. An undetermined function of an angle counts as periodic.

    Args:
        parts: (kinetic or potential, its expression).
        parameters: with their default values.

    Raises:
        InvalidSystemError: with the angle, the difference after a turn, and what to write instead.
    """
    defaults = {p.symbol: p.value for p in parameters if p.value is not None}
    for source, f in parts:
        for c in coordinates:
            if c.domain.kind != "angle" or is_periodic(f, c.symbol):
                continue
            at = f.xreplace(defaults) if f.free_symbols & defaults.keys() else f
            if at != f and is_periodic(at, c.symbol):
                continue
            if (difference := _witness(f, c.symbol, coordinates, parameters)) is not None:
                raise InvalidSystemError(_message(source, f, c, difference, parameters))


@lru_cache(maxsize=512)
def is_periodic(f: sp.Expr, angle: sp.Symbol) -> bool:
    """Return whether f(a + 2π) = f(a) is proved.

    Args:
        f: a formula.
        angle: a, the symbol of the coordinate.
    """
    if angle not in f.free_symbols:
        return True
    unknowns = {g: sp.Dummy(real=True) for g in f.atoms(AppliedUndef, sp.Derivative, sp.Subs)}
    f = f.xreplace(unknowns)
    turned = f.xreplace({angle: angle + 2 * sp.pi})
    if turned == f:
        return True
    try:
        reader = Reader([f, turned], budget=Budget.processor_seconds(_SECONDS))
        return (reader.element(turned) - reader.element(f)).is_zero
    except (WorkLimitError, ZeroDivisionError):
        return False


def _witness(
    f: sp.Expr, angle: sp.Symbol, coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]
) -> tuple[sp.Expr, object] | None:
    """Return a place where f is another number after a turn, and by how much; None where none was found."""
    turned = f.xreplace({angle: angle + 2 * sp.pi})
    velocities = {s: CONTEXT.mpf(k + 2) / 3 for k, s in enumerate(c.velocity for c in coordinates)}
    for point in sample_points(coordinates, parameters):
        try:
            before, after = (evaluate(x, {**point, **velocities}) for x in (f, turned))
        except NoValueError:
            continue
        if abs(after - before) > _ROUNDING * (1 + abs(before) + abs(after)):
            return point[angle], after - before
    return None


def _message(
    source: str, f: sp.Expr, c: Coordinate, difference: tuple[sp.Expr, object], parameters: Sequence[Parameter]
) -> str:
    place, change = (CONTEXT.nstr(x, 4) for x in difference)
    letter = {"kinetic": "T", "potential": "V"}.get(source, "it")
    free = [p for p in parameters if p.symbol in f.free_symbols and p.assume != "integer"]
    whole = (p.name for p in free if is_periodic(f.xreplace({p.symbol: sp.Dummy(integer=True)}), c.symbol))
    name = next(whole, None)
    hint = f', or declare {name} integer, parameter("{name}", assume="integer")' if name else ""
    return (
        f"{source}: {printable(str(f))[:60]} is not 2*pi-periodic in {c.name}, which is declared an angle: {letter} "
        f'changes by {change} after a turn from {c.name} = {place}; write the domain "line", or an interval such as '
        f'"-pi < {c.name} < pi"{hint}'
    )
