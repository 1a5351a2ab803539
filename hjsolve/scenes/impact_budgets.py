"""The budget of an impact in a scene: momentum of each coordinate and energy, with what has to vanish.

    p′ − p = aᵀλ (3-42),   T′ − T = ½ Σ Q̂ (q̇ + q̇′),  Q̂ = aᵀλ,   a q̇′ − v = −e (a q̇ − v)

λ is computed from the velocities before, and the velocities after from the momenta that are handed on to the next arc.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from hjsolve.arithmetic.floats import multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.display.shown import Shown
from hjsolve.extended.impacts import impulses
from hjsolve.mechanics.system import inverse_mass_matrix, linear_terms, mass_matrix
from hjsolve.motion.initial_data import to_bits
from hjsolve.motion.motion import Motion
from hjsolve.scenes.crossing import as_rational, bits_of
from hjsolve.scenes.events import Event


@dataclass(frozen=True, eq=False, repr=False)
class ImpactBudget(Shown):
    """What an impact of a scene does; numbers in the digits that states at events are carried in.

    Attributes:
        event: the impact.
        time: when.
        velocity_before, velocity: coordinate → q̇ just before and just after.
        momentum_before, momentum: coordinate → p.
        multipliers: λ, by constraint in order.
        impulse: coordinate → Q̂ = aᵀλ.
        kinetic_before, kinetic: ½ q̇ᵀMq̇.
        residual: what has to vanish: p′ − p − Q̂ by coordinate, ``energy``, and ``constraints``, the largest of
            a q̇′ − v + e (a q̇ − v).
    """

    event: Event
    time: Mpf
    velocity_before: Mapping[str, Mpf]
    velocity: Mapping[str, Mpf]
    momentum_before: Mapping[str, Mpf]
    momentum: Mapping[str, Mpf]
    multipliers: tuple[Mpf, ...]
    impulse: Mapping[str, Mpf]
    kinetic_before: Mpf
    kinetic: Mpf
    residual: Mapping[str, Mpf]

    @property
    def energy_lost(self) -> Mpf:
        """What the kinetic energy loses; negative where a constraint that moves gives energy (3-63)."""
        return self.kinetic_before - self.kinetic


def budgets(
    motion: Motion, time: sp.Expr, events: Sequence[Event], q: Mapping[str, sp.Expr | Mpf],
    p: Mapping[str, sp.Expr | Mpf], after: Mapping[str, sp.Expr],
) -> list[ImpactBudget]:  # fmt: skip
    """Return the budget of an impact; none where something else happens, or more than one thing at once.

    Args:
        motion: that led there.
        time: exact.
        events: that happen at the time.
        q, p: just before.
        after: momenta just after.
    """
    if len(events) != 1 or events[0].forms is None:
        return []
    system, forms, digits = motion.solution.system_as_given, events[0].forms, motion.digits
    bits = bits_of(digits)
    names = [c.name for c in system.coordinates]

    def exact(x: sp.Expr | Mpf) -> sp.Expr:
        return x if isinstance(x, sp.Expr) else as_rational(x, digits)

    at = {p.symbol: motion.initial.values[p.symbol] for p in system.parameters}
    at |= {c.symbol: exact(q[c.name]) for c in system.coordinates}
    numbers = multiprecision(bits)

    def value(x: sp.Expr) -> Mpf:
        return numbers.convert(to_bits(x.xreplace(at))(bits))

    def matrix(M: sp.Matrix) -> list[list[Mpf]]:
        return [[value(x) for x in M.row(i)] for i in range(M.rows)]

    rest = [value(x) for x in linear_terms(system)]
    inverse, mass = matrix(inverse_mass_matrix(system)), matrix(mass_matrix(system))
    before = [numbers.convert(to_bits(exact(p[n]))(bits)) for n in names]
    behind = [numbers.convert(to_bits(after[n])(bits)) for n in names]

    def dot(M: Sequence[Mpf], x: Sequence[Mpf]) -> Mpf:
        return numbers.fdot(zip(M, x, strict=True))

    moving = [dot(row, [x - a for x, a in zip(before, rest, strict=True)]) for row in inverse]
    moved = [dot(row, [x - a for x, a in zip(behind, rest, strict=True)]) for row in inverse]
    λ, pushed = impulses(system, forms, at | {c.momentum: exact(p[c.name]) for c in system.coordinates})
    Q = [numbers.convert(to_bits(x)(bits)) for x in pushed]
    T, more = (dot(v, [dot(row, v) for row in mass]) / 2 for v in (moving, moved))
    work = dot(Q, [a + b for a, b in zip(moving, moved, strict=True)]) / 2
    rows, speeds = matrix(sp.Matrix(forms.rows)), [value(v) for v in forms.speeds]
    held = [dot(a, moved) - v + to_bits(e)(bits) * (dot(a, moving) - v)
            for a, v, e in zip(rows, speeds, forms.restitution, strict=True)]  # fmt: skip
    residual = {n: b - a - x for n, a, b, x in zip(names, before, behind, Q, strict=True)}
    residual |= {"energy": more - T - work, "constraints": max(map(abs, held))}

    def named(values: Sequence[Mpf]) -> dict[str, Mpf]:
        return dict(zip(names, values, strict=True))

    return [ImpactBudget(
        events[0], numbers.convert(to_bits(time)(bits)), named(moving), named(moved), named(before), named(behind),
        tuple(numbers.convert(to_bits(x)(bits)) for x in λ), named(Q), T, more, residual,
    )]  # fmt: skip
