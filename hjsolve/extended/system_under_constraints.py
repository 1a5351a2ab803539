"""Constraints that last after an impact: the system in the coordinates that they leave, and its state there.

A constraint a(q)·q̇ = v that appears at t₁ and stays is integrated and eliminated (``coordinates.constraints``), so that
q = f(Q, t), q̇ = ∂f/∂Q Q̇ + ∂f/∂t. T and V with f put in are those of the system that goes on, and its momenta are
P = (∂f/∂Q)ᵀ p: the constraint forces do no work in Q. New angles follow from their cosine and sine, which f holds to
first degree, and the constants of integration from the place at t₁.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

import sympy as sp

from hjsolve.errors import InvalidSystemError
from hjsolve.extended.change_of_frame import ChangeOfFrame
from hjsolve.mechanics.system import System, velocities
from hjsolve.motion.initial_data import clean

_TIME = sp.Symbol("t", real=True)
Numbers = Mapping[sp.Symbol, sp.Expr]


class Short(Protocol):
    """How numbers are written, and when one is zero."""

    def __call__(self, x: sp.Expr) -> sp.Expr:
        """Return a number in its shortest form."""

    def without(self, x: sp.Expr, terms: Iterable[sp.Expr]) -> sp.Expr:
        """Return the number; 0 where it is a rounding error of the terms that it is the sum of."""


class Exact:
    """Exact numbers."""

    def __call__(self, x: sp.Expr) -> sp.Expr:
        """Return a number expanded; 0 where it is zero."""
        return clean(x)

    def without(self, x: sp.Expr, _terms: Iterable[sp.Expr]) -> sp.Expr:
        """Return the same: nothing is rounded."""
        return clean(x)


def constrained(system: System, texts: Iterable[str]) -> ChangeOfFrame:
    """Return the change to the coordinates that constraints leave; its system may hold the time.

    Args:
        system: before.
        texts: the constraints, as ``System`` takes them.

    Raises:
        InvalidSystemError: one is not integrable, or was not solved for a coordinate.
    """
    left = System(
        {c.name: c.domain.written(c.name) for c in system.coordinates}, system.kinetic, system.potential,
        {p.name: p for p in system.parameters}, signature=system.signature, title=system.title,
        place=system.place or None, functions=system.functions, units=dict(system.declared_units),
        constraints=tuple(texts),
    )  # fmt: skip
    gone, time = dict(left.eliminated), left.time or _TIME
    place = {c.name: gone.get(c.name, left.symbols.get(c.name, c.symbol)) for c in system.coordinates}
    return ChangeOfFrame(left, system, {n: f.subs(_TIME, time) for n, f in place.items()}, sp.S.Zero, time)


def through(change: ChangeOfFrame, frame: ChangeOfFrame) -> ChangeOfFrame:
    """Return one change in place of two, one after the other.

    Args:
        change: the first, without a gauge.
        frame: of the system that the first one leads to.
    """
    inner = {c.symbol: frame.place[c.name] for c in change.system.coordinates} | {change.time: frame.time}
    place = {name: f.xreplace(inner) for name, f in change.place.items()}
    return ChangeOfFrame(frame.system, change.original, place, frame.gauge, frame.time)


def place_in(change: ChangeOfFrame, at: Numbers, short: Short) -> dict[sp.Symbol, sp.Expr]:
    """Return coordinates and parameters of the system that is left, where the old coordinates are known.

    Args:
        change: of ``constrained``, or one that went through a frame.
        at: old coordinates, parameters and the time, as numbers.
        short: how numbers are written.

    Raises:
        InvalidSystemError: the place does not satisfy the constraints, or was not written in the new coordinates.
    """
    bound_values = {s: at[change.original.symbols[s.name]] for s in change.system.symbols.values()
            if s.name in change.original.symbols} | {change.time: at[change.time]}  # fmt: skip
    unknown = {s for s in change.system.symbols.values() if s not in bound_values}
    equations = [change.place[c.name] - at[c.symbol] for c in change.original.coordinates]
    while unknown:
        left = [e.xreplace(bound_values) for e in equations]
        found = next((f for s in sorted(unknown, key=str) if (f := _one(s, left, unknown, short)) is not None), None)
        if found is None:
            raise InvalidSystemError("next_arc: the place was not written in the coordinates that are left")
        bound_values[found[0]] = found[1]
        unknown.discard(found[0])
    for c in change.original.coordinates:
        f = change.place[c.name].xreplace(bound_values)
        sizes = [f, at[c.symbol], *(bound_values[q.symbol] for q in change.system.coordinates)]
        if short.without(f - at[c.symbol], sizes) != 0:
            raise InvalidSystemError("next_arc: the place does not satisfy the constraints")
    return bound_values


def _one(
    unknown: sp.Symbol, equations: list[sp.Expr], others: set[sp.Symbol], short: Short
) -> tuple[sp.Symbol, sp.Expr] | None:
    """Return an unknown from equations that hold no other one: linear in it, or in its cosine and sine."""
    C, S = sp.Dummy("C"), sp.Dummy("S")
    circle = {sp.cos(unknown): C, sp.sin(unknown): S}
    own = [e.xreplace(circle) for e in equations if e.free_symbols & others == {unknown}]
    values: dict[sp.Symbol, sp.Expr] = {}
    for letter in (unknown, C, S):
        for e in own:
            slope = sp.diff(e, letter)
            if e.free_symbols & {unknown, C, S} == {letter} and not slope.has(letter) and short(slope) != 0:
                values[letter] = short(-e.subs(letter, 0) / slope)
    if unknown in values:
        return unknown, values[unknown]
    if C in values and S in values:
        return unknown, short(sp.atan2(values[S], values[C]))
    return (unknown, short(sp.acos(values[C]))) if C in values else None


def momenta_in(change: ChangeOfFrame, at: Numbers, short: Short) -> dict[str, sp.Expr]:
    """Return P = (∂f/∂Q)ᵀ p − ∂Λ/∂Q.

    Args:
        change: with both systems.
        at: old momenta, new coordinates, parameters and the time, as numbers.
        short: how numbers are written.
    """
    old = [(at[c.momentum], change.place[c.name]) for c in change.original.coordinates]
    found: dict[str, sp.Expr] = {}
    for Q in change.system.coordinates:
        terms = [p * sp.diff(f, Q.symbol).xreplace(dict(at)) for p, f in old]
        terms.append(-sp.diff(change.gauge, Q.symbol).xreplace(dict(at)))
        found[Q.name] = short.without(sp.Add(*terms), terms)
    return found


def initial_data_in(change: ChangeOfFrame, at: Numbers, short: Short) -> dict[str, dict[str, sp.Expr]]:
    """Return ``q``, ``velocity`` and ``parameters`` for ``Solution.motion`` in the coordinates that are left.

    Args:
        change: of ``constrained``.
        at: old coordinates and momenta, parameters and the time, as numbers.
        short: how numbers are written.

    Raises:
        InvalidSystemError: as of ``place_in``.
    """
    left = change.system
    told = place_in(change, at, short) | {c.momentum: at[c.momentum] for c in change.original.coordinates}
    P = momenta_in(change, told, short)
    told |= {c.momentum: P[c.name] for c in left.coordinates}
    return {
        "q": {c.name: told[c.symbol] for c in left.coordinates},
        "velocity": {name: short(f.xreplace(told)) for name, f in velocities(left).items()},
        "parameters": {p.name: told[p.symbol] for p in left.parameters if p.symbol != left.time},
    }
