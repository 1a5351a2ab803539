"""The transition matrix of a motion, ∂(q, p)(t)/∂(q, p)(t₀), with a bound on the error of every entry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.estimate_array import EstimateArray
from hjsolve.arithmetic.floats import EPS, bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Numbers, Reals
from hjsolve.arithmetic.running_error import SECOND_ORDER
from hjsolve.errors import NotConvergedError
from hjsolve.motion.charted.charted_motion import ChartedMotion
from hjsolve.motion.derivatives.bounded import Bounded, converted, stacked
from hjsolve.motion.derivatives.canonical import ConstantsToState, StateByConstants, symplectic_inverse
from hjsolve.motion.derivatives.in_users_coordinates import UsersCoordinates, users_coordinates
from hjsolve.motion.derivatives.preparation import MORE, prepared
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.motion.phases import phases_at
from hjsolve.motion.positions import positions_at
from hjsolve.motion.quantities import FLOAT_DIGITS
from hjsolve.motion.times import read_times

_TRIES = 4
"""How often digits are added where the phases, or the matrix, have fewer than are asked."""


def transition_matrix(motion: Motion, t: object) -> EstimateArray:
    """Return ∂(q, p)(t)/∂(q, p)(t₀); see ``Motion.transition_matrix``."""
    shape, floats, exact = read_times(t)
    found = matrices(motion, floats, exact, parameters=False)[0]
    return without_collisions(motion, t, rounded(found, motion.digits, shape))


def matrices(
    motion: Motion, floats: Reals | None, exact: Sequence[Callable[[int], Mpf]], *, parameters: bool
) -> tuple[Bounded, Bounded, list[StateByConstants | None]]:
    """Return ∂(q, p)(t)/∂(q, p)(t₀), the same by the parameters at fixed (q, p)(t₀), and D(t), at m times.

    Args:
        motion: told in its separated coordinates.
        floats: t as doubles, shape (m,), where all times are finite doubles; else None.
        exact: rules that give each t in any number of binary digits.
        parameters: whether these are varied too.

    Returns:
        Matrices of shape (m, 2n, 2n) and (m, 2n, parameters); nan where the motion has ended. The frames are those
        D(t), None where every coordinate is ignorable or the motion has ended.

    Raises:
        NotConvergedError: they did not converge to the digits asked.
    """
    more, users = MORE, users_coordinates(motion, parameters=parameters)
    for _ in range(_TRIES):
        map_ = prepared(motion.as_solved, parameters, more)
        if map_ is None:
            return *_all_ignorable(motion, floats, exact, parameters=parameters), []
        found = _matrices(map_, users, floats, exact)
        # digits that D(t) D(t₀)⁻¹ lost, by its own bounds, are asked of the motion, and four to spare
        lacking = _lacking(found[0], motion.digits)
        if lacking <= 0:
            return found
        more += lacking + 4
    raise NotConvergedError("the transition matrix did not converge to the digits asked")


def _lacking(found: Bounded, digits: int) -> int:
    """Digits that the greatest entries of a matrix lack."""
    worst = 0.0
    for size, error in zip(found.size, found.error, strict=True):
        if np.all(np.isfinite(size)):
            worst = max(worst, float(np.max(error, initial=0.0)) / max(float(np.max(size, initial=0.0)), 1e-300))
    # over the greatest entry: an entry that is small by cancellation has the error of the others
    limit = 10.0 ** -(digits + 2)
    return int(np.ceil(np.log10(worst / limit))) if worst > limit else 0


@lru_cache(maxsize=16)
def first_frame(map_: ConstantsToState) -> StateByConstants:
    """Return D(t₀)."""
    return map_.first_frame()


def start_in_users_coordinates(map_: ConstantsToState, users: UsersCoordinates | None) -> tuple[Bounded, Bounded]:
    """Return ∂(B, x, a, y)/∂(q, p)(t₀), and the same by the parameters at fixed (q, p)(t₀).

    Args:
        users: the user's coordinates; None where they are those separated.
    """
    first = first_frame(map_)
    # D is symplectic: −𝕁 Dᵀ 𝕁 is its inverse, and costs no digits as elimination would
    inverse, moved = symplectic_inverse(first.state), first.by_parameters
    if users is not None:
        source = map_.source
        system = source.solution.system
        values: Any = [{}, {}]
        for c in system.coordinates:
            for group, symbol in zip(values, (c.symbol, c.momentum), strict=True):
                group[c.name] = np.array([to_bits(source.initial.values[symbol])(map_.context.prec)], dtype=object)
        ((C, shift),) = users.changes(source, values[0], values[1], map_.context)
        outer = symplectic_inverse(C)
        # (q, p)(t₀) stays: d(B, x, a, y) = −D⁻¹ ∂D/∂λ dλ, in the user's coordinates with what these add
        return inverse @ outer, -(inverse @ (moved + outer @ shift))
    return inverse, -(inverse @ moved)


def _matrices(
    map_: ConstantsToState, users: UsersCoordinates | None, floats: Reals | None, exact: Sequence[Callable[[int], Mpf]]
) -> tuple[Bounded, Bounded, list[StateByConstants | None]]:
    phases = phases_at(map_.source, floats, exact)
    start, by_start = start_in_users_coordinates(map_, users)
    # D is worked out only where the motion still goes on; the rest is nan
    going = np.flatnonzero(~phases.ended)
    χ, whole, errors = ([part[going] for part in group] for group in (phases.χ, phases.whole, phases.errors))
    found = map_.frames(χ, whole, errors)
    if users is not None and found:
        q, p, _ = positions_at(map_.source, phases)
        places, momenta = ({name: values[going] for name, values in group.items()} for group in (q, p))
        changes = users.changes(map_.source, places, momenta, map_.context)
        found = [
            StateByConstants(C @ frame.state, C @ frame.by_parameters + shift)
            for frame, (C, shift) in zip(found, changes, strict=True)
        ]
    kept = iter(found)
    frames = [None if over else next(kept) for over in phases.ended]
    n2, m = len(start.value), len(map_.variables.parameters)
    main, by = [], []
    for frame in frames:
        main.append(_nothing((n2, n2), map_) if frame is None else frame.state @ start)
        # parameters act at t directly, and through the constants that (q, p)(t₀) has for them
        by.append(_nothing((n2, m), map_) if frame is None else frame.by_parameters + frame.state @ by_start)
    if not frames:
        return _nothing((0, n2, n2), map_), _nothing((0, n2, m), map_), []
    return stacked(main), stacked(by), frames


def _nothing(shape: tuple[int, ...], map_: ConstantsToState) -> Bounded:
    return Bounded(np.full(shape, map_.context.nan, dtype=object), np.full(shape, np.nan))


def _all_ignorable(
    motion: Motion, floats: Reals | None, exact: Sequence[Callable[[int], Mpf]], *, parameters: bool
) -> tuple[Bounded, Bounded]:
    """Evenly growing q: q(t) = q₀ + (t − t₀) ∂H/∂p."""
    system, source = motion.solution.system, motion.separated
    H = motion.solution.separation.shell.potential
    bits = bits_for(motion.digits + MORE, 128)
    context = multiprecision(bits)
    momenta = [c.momentum for c in system.coordinates]
    symbols = [p.symbol for p in system.parameters] if parameters else []

    def slopes(by: Sequence[sp.Symbol]) -> Numbers:
        table = [[to_bits(sp.diff(H, p, b).subs(source.initial.values))(bits) for b in by] for p in momenta]
        return np.array(table, dtype=object).reshape(len(momenta), len(by))

    n = len(momenta)
    rules = exact if floats is None else [exactly(float(x)) for x in floats]
    times = [context.convert(rule(bits)) - to_bits(source.t0)(bits) for rule in rules]
    main = np.full((len(times), 2 * n, 2 * n), context.mpf(0), dtype=object)
    by = np.full((len(times), 2 * n, len(symbols)), context.mpf(0), dtype=object)
    main[:, range(2 * n), range(2 * n)] = context.mpf(1)
    bend, turned = slopes(momenta), slopes(symbols)
    for k, t in enumerate(times):
        # ∂q/∂p₀ = t ∂²H/∂p², and p does not change
        main[k, :n, n:], by[k, :n, :] = t * bend, t * turned
    return Bounded.exact(main), Bounded.exact(by)


def exactly(x: float) -> Callable[[int], Mpf]:
    """Return the rule of a double: its value in any number of bits."""
    return lambda bits: multiprecision(bits).mpf(x)


def without_collisions(motion: Motion, t: object, found: EstimateArray) -> EstimateArray:
    """Return matrices with nan for times beyond a collision with a focus.

    Args:
        motion: any.
        t: the times.
        found: one matrix a time.
    """
    if not isinstance(motion, ChartedMotion) or motion.ends == (None, None):
        return found
    over = np.asarray(motion.at(t).status) != "ok"
    return EstimateArray(*(np.where(over[..., None, None], np.nan, part) for part in (found.value, found.error)))


def rounded(found: Bounded, digits: int, shape: tuple[int, ...] | None) -> EstimateArray:
    """Round numbers to the digits asked, in the shape of the times.

    Args:
        found: the first axis is that of the times.
        digits: decimal digits to give them to.
        shape: of the times.
    """
    rest = found.value.shape[1:]
    full = (*(shape or ()), *rest)
    if digits <= FLOAT_DIGITS:
        value = found.value.astype(float)
        # bounds are of first order in the errors of phases and constants
        error = SECOND_ORDER * found.error + EPS * np.abs(value) / 2
        return EstimateArray(value.reshape(full), error.reshape(full))
    context = multiprecision(bits_for(digits, 16))
    value = converted(found.value, context)
    unit = float(multiprecision(64).mpf(10) ** -digits)
    return EstimateArray(value.reshape(full), (SECOND_ORDER * found.error + unit * found.size).reshape(full))
