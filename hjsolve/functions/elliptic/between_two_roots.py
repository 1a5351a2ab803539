"""∫ R(x) dx/√P(x) over the whole interval between the two real roots of a quartic that has one complex pair z.

Between the roots e and r the cn-map x = e + (r − e) |e − z| (1 − cn u)/(|e − z| (1 − cn u) + |r − z| (1 + cn u)) makes

    ∫ dx/√P = 2K/√(|L| |e − z| |r − z|),   k′² = (|e − z| |r − z| + Re (e − z)(r − z̄))/(2 |e − z| |r − z|),

K = R_F(0, k′², 1), L the leading coefficient. Of a pole ρ let σ = ±1 be the sign of x − ρ on the interval, e the root
that is the farther from it, and κ = |e − z|/|ρ − z|; then

    ∫ dx/((x − ρ)√P) = σπ/√(−P(ρ)) + 2σ/(|e − ρ| √(|L| |e − z| |r − z|)) [(1 − κ) K + ⅔ κ (p − k′²) R_J(0, k′², 1, p)],
    p = ½ (1 + (r − ρ)|e − z|/((e − ρ)|r − z|) + |r − e||ρ − z|/(|e − ρ||r − z|)).

The half turn, which is all that grows where the pole comes near, is apart from the rest, and P(ρ) may be known in the
constants of P. At r itself p = 1, R_J is R_D, and the half turn is taken by d[√P/(x − r)]. The pole at infinity is

    ∫ (x − e) dx/√P = (r − e)/√(…) [K + (|e − z|² − |r − z|²)/(12 |e − z| |r − z|) R_J(0, k′², 1, p∞)],
    p∞ = (|e − z| + |r − z|)²/(4 |e − z| |r − z|).

Byrd and Friedman, Handbook of elliptic integrals (1971), 259 (the map), 341, 361; Carlson (DLMF 19.22.20) for the pole.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.functions.carlson import CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.functions.complex_pole import Parts
from hjsolve.functions.elliptic.branch_points import BranchPoints, NoForm
from hjsolve.functions.elliptic.moments import INFINITY, IntegrationPath, Kinds

Side = Callable[[sp.Expr], int]
"""A pole ↦ the sign of x − ρ on the interval."""


def kinds_between_two_roots(path: IntegrationPath, side: Side, complex_third: Callable[[Parts], Parts]) -> Kinds:
    """Return the basic integrals over a whole interval.

    Args:
        path: over the whole interval, between the two real roots of a quartic with a complex pair.
        side: of the poles.
        complex_third: of a pole at a complex place.
    """
    own = _BetweenTwoRoots(path, side)
    return Kinds(own.first, own.third, own.at_other_end, complex_third, own.pole)


def complement_squared(P: BranchPoints, e: sp.Expr, r: sp.Expr) -> sp.Expr:
    """k′², 1 where the pair is infinitely far away.

    Args:
        P: the branch points.
        e: one of the real roots.
        r: the other.
    """
    (α, β), product = P.pairs[0], P.distance(e) * P.distance(r)
    return (product + (e - α) * (r - α) + β**2) / (2 * product)


@dataclass(frozen=True)
class _BetweenTwoRoots:
    path: IntegrationPath
    side: Side

    @property
    def P(self) -> BranchPoints:
        return self.path.P

    @property
    def other(self) -> sp.Expr:
        """The root r at which the path ends."""
        return self.path.x

    @cached_property
    def scale(self) -> sp.Expr:
        """1/√(|L| |e − z| |r − z|); L < 0, for P > 0 between the two."""
        return 1 / sp.sqrt(-self.P.leading * self.P.distance(self.path.e) * self.P.distance(self.other))

    @cached_property
    def k2(self) -> sp.Expr:
        """k′²."""
        if self.P.complement is not None:
            return self.P.complement**2
        return complement_squared(self.P, self.path.e, self.other)

    @cached_property
    def K(self) -> sp.Expr:
        return CarlsonRF(0, self.k2, 1)

    @cached_property
    def first(self) -> sp.Expr:
        """∫ dx/√P."""
        return 2 * self.scale * self.K

    def third(self, place: sp.Expr | None) -> sp.Expr:
        """Return the integral of ``moments.Kinds``; only of the pole at infinity, σ ∫ (x − e) dx/√P, here."""
        if place is not INFINITY:
            raise NoForm("a finite pole has an integral of its own")
        e, r = self.path.e, self.other
        near, far = self.P.distance(e), self.P.distance(r)
        bend = (near**2 - far**2) / (12 * near * far)
        at_infinity = CarlsonRJ(0, self.k2, 1, (near + far) ** 2 / (4 * near * far))
        return self.path.σ * (r - e) * self.scale * (self.K + bend * at_infinity)

    def at_other_end(self, r: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """Return what ``moments.Kinds`` asks for of the root at which the path ends."""
        κ = self.P.distance(self.path.e) / self.P.distance(r)
        rest = (1 - κ) * self.K + sp.Rational(2, 3) * κ * (1 - self.k2) * CarlsonRD(0, self.k2, 1)
        return sp.S.Zero, 2 * self.scale / (self.path.e - r) * rest

    def pole(self, place: sp.Expr) -> sp.Expr:
        """∫ dx/((x − ρ)√P), from the lower root to the upper.

        Args:
            place: ρ, real and outside the interval.
        """
        σ, ends = self.side(place), (self.path.e, self.other)
        lower, upper = ends if self.path.σ == 1 else ends[::-1]
        r, e = (lower, upper) if σ == 1 else (upper, lower)
        to_e, to_r, to_pole = (self.P.distance(there) for there in (e, r, place))
        κ, away = to_e / to_pole, σ * (e - place)
        p = (1 + (r - place) * to_e / ((e - place) * to_r) + (upper - lower) * to_pole / (away * to_r)) / 2
        rest = (1 - κ) * self.K + sp.Rational(2, 3) * κ * (p - self.k2) * CarlsonRJ(0, self.k2, 1, p)
        return σ * (sp.pi / sp.sqrt(-self.P.at_pole(place)) + 2 * self.scale / away * rest)
