"""How a coordinate goes round its cycle, and the Maslov index of each kind.

J = (n + μ/4) ħ (Keller, Ann. Phys. 4 (1958) 180, eq. (22)): a turning point adds 1 to μ, a hard wall, at which the wave
vanishes, adds 2, and a rotation has none. At a pole of the coordinates (the centre, the polar axis) the wave is regular
and p² has a turning point for every p_φ ≠ 0, which counts 1 as every other one; p_φ = m ħ itself stands for the angle.
This is the substitution l (l + 1) → (l + ½)² of Langer (Phys. Rev. 51 (1937) 669), which comes out by itself in terms
of actions: |L| = J_θ + |J_φ| = (l + ½) ħ. For m = 0 the actions are those of the limit p_φ → 0. There the motion
passes the pole, and the coordinates run on beyond it (``motion.through_poles``): a libration across one pole has twice
the action of the limit, and a rotation through both has the same.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp

from hjsolve.motion.initial_data import domain_ends, to_bits
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.solution.quadratures import Solution

LIBRATION, ROTATION = "libration", "rotation"


@dataclass(frozen=True)
class Poles:
    """The ends of a coordinate that runs on beyond them, in doubles; None where an end is not a pole."""

    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class Circuit:
    """One circuit of the cycle of a coordinate.

    Attributes:
        kind: libration or rotation, in the coordinates in which it is computed.
        limit_kind: the kind that the limit p_φ → 0 has.
        maslov: μ.
        direction: −1 of a rotation towards smaller values, else 1.
        multiple: the action in the coordinates in which it is computed over that of the limit.
        walls: which ends are walls.
        across: which poles are passed, lower and upper.
        poles: of the coordinate; None where it has none.
    """

    kind: str
    limit_kind: str
    maslov: int
    direction: int = 1
    multiple: int = 1
    walls: tuple[bool, bool] = (False, False)
    across: tuple[bool, bool] = (False, False)
    poles: Poles | None = None

    @property
    def first(self) -> int:
        """The least quantum number, but for its sign."""
        return 1 if self.limit_kind == ROTATION else 0

    def action(self, n: int, hbar: sp.Expr) -> sp.Expr:
        """Return J of a quantum number.

        Args:
            n: the number, not negative.
            hbar: ħ.
        """
        return self.direction * (n + sp.Rational(self.maslov, 4)) * hbar

    def fits(self, curve: RadicandCurve, low: float, high: float, rotates: bool, *, crude: bool = False) -> bool:
        """Return whether a motion of the coordinate follows this circuit.

        Args:
            curve: p² of the coordinate.
            low, high: its turning points, ends of the domain at walls.
            rotates: whether it goes round a turn.
            crude: whether turning points are known to the distance of samples only.
        """
        if rotates != (self.kind == ROTATION):
            return False
        if any(curve.walls):
            first, *_, last = curve.samples() if crude else (curve.lower, curve.upper)
            if (curve.walls[0] and low <= first, curve.walls[1] and high >= last) != self.walls:
                return False
        if self.poles is None or self.kind == ROTATION:
            return True
        turn = 2 * math.pi if None not in (self.poles.lower, self.poles.upper) else math.inf
        passed = tuple(
            pole is not None and _within(pole, low, high, turn) for pole in (self.poles.lower, self.poles.upper)
        )
        if passed != self.across:
            return False
        # a libration that passes no pole has an image beyond the pole, which is the same motion with φ + π
        return any(passed) or crude or self._given_side((low + high) / 2, turn)

    def _given_side(self, middle: float, turn: float) -> bool:
        low, high = self.poles.lower if self.poles else None, self.poles.upper if self.poles else None
        if low is not None and math.isfinite(turn):
            middle -= turn * math.floor((middle - low) / turn)
        return (low is None or middle > low) and (high is None or middle < high)


def _within(pole: float, low: float, high: float, turn: float) -> bool:
    shifts = (0.0,) if math.isinf(turn) else (-turn, 0.0, turn)
    return any(low < pole + shift < high for shift in shifts)


def circuits_of(
    solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr], poles: Poles | None
) -> tuple[Circuit, ...]:
    """Return the circuits that a separated coordinate may follow.

    Args:
        solution: in whose coordinates it is computed.
        values: symbol → exact number, of the parameters and of the momenta of ignorable coordinates.
        poles: beyond which it runs on; None where it has none.
    """
    angle = solution.system.coordinate(name).domain.kind == "angle"
    if poles is not None:
        low, high = poles.lower is not None, poles.upper is not None
        found = [Circuit(LIBRATION, LIBRATION, 2, poles=poles)]
        found += [Circuit(LIBRATION, LIBRATION, 2, multiple=2, across=(True, False), poles=poles)] if low else []
        found += [Circuit(LIBRATION, LIBRATION, 2, multiple=2, across=(False, True), poles=poles)] if high else []
        return (*found, *([Circuit(ROTATION, LIBRATION, 2, poles=poles)] if low and high else []))
    hard = walls_of(solution, name, values)
    patterns = [
        (a, b) for a in ((False, True) if hard[0] else (False,)) for b in ((False, True) if hard[1] else (False,))
    ]
    found = [Circuit(LIBRATION, LIBRATION, 2 + sum(pattern), walls=pattern) for pattern in patterns]
    return (*found, *((Circuit(ROTATION, ROTATION, 0, sign) for sign in (1, -1)) if angle else ()))


def walls_of(solution: Solution, name: str, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[bool, bool]:
    """Tell which ends of the domain of a coordinate are walls: p² is finite there."""
    q, F = solution.system.coordinate(name).symbol, solution.momentum_squared[name].subs(values)
    found = []
    for end in domain_ends(solution.system, name, values):
        there = None if end is None else F.subs(q, end)
        found.append(there is not None and not there.has(sp.zoo, sp.nan, sp.oo, -sp.oo))
    return found[0], found[1]


def poles_in_doubles(lower: sp.Expr | None, upper: sp.Expr | None, values: Mapping[sp.Symbol, sp.Expr]) -> Poles:
    """Return poles as doubles.

    Args:
        lower, upper: exact, None where an end is not one.
        values: symbol → exact number, of the parameters that they hold.
    """
    low, high = (None if end is None else float(to_bits(sp.sympify(end).subs(values))(64)) for end in (lower, upper))
    return Poles(low, high)
