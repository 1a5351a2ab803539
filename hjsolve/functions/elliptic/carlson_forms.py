"""∫ R(x) dx/√P(x) from a real root e of P, in Carlson's R_F, R_D, R_J, R_C of positive arguments.

With σ = ±1 the side of e on which the interval lies, x′ = e + σ/z sends e to infinity and P to a cubic, and with

    v(ρ) = (x − ρ)/(e − ρ),   v(∞) = 1,   S² = σ (x − e),   q = σ P′(e) > 0

(v is 1 at e, positive on the interval, zero at its other end), the sum over the three other branch points r₁, r₂, r₃
(∞ among them where P is cubic) gives, exactly and up to both ends,

    ∫ dx/√P = (2S/√q) R_F(v(r₁), v(r₂), v(r₃)),
    ∫ dx/((x − ρ)√P) = [∫ dx/√P − σ/(e − ρ) · (2S³/(3√q)) R_J(v(r₁), v(r₂), v(r₃), v(ρ))]/(e − ρ),
    ∫ (x − e) dx/√P = σ (2S³/(3√q)) R_J(v(r₁), v(r₂), v(r₃), v(∞))

(Carlson, Math. Comp. 49 (1987) 595; DLMF 19.29). Higher powers follow from d[(x − ρ)ⁿ √P]. A complex pair is
brought to real arguments by Gauss' transformation (DLMF 19.22.18–19.22.20) with

    a² = (|v₁| + Re v₁)/2,   z₊² = (v₃ + |v₁| + |v₃ − v₁|)/2,   z₋² = a² v₃/z₊²,   p₊² = (p² + |v₁| + |p² − v₁|)/2.

Where the interval ends at infinity and the whole of it is meant, x = ∞: v(ρ) = σ/(e − ρ), v(∞) = 0 and S = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import sympy as sp

from hjsolve.functions.carlson import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.functions.complex_pole import CarlsonRCIm, CarlsonRCRe, CarlsonRJIm, CarlsonRJRe, Parts, divided, times
from hjsolve.functions.elliptic.between_two_roots import Side, kinds_between_two_roots
from hjsolve.functions.elliptic.branch_points import BranchPoints, Interval, PartialFractions
from hjsolve.functions.elliptic.moments import (
    INFINITY,
    IntegrationPath,
    Kinds,
    first_and_other_kinds,
    refuse,
    whole_path,
)


def complete(R: PartialFractions, P: BranchPoints, interval: Interval, side: Side | None = None) -> sp.Expr:
    """∫ R dx/√P over the whole interval.

    Args:
        R: the rational function.
        P: the branch points.
        interval: where.
        side: real pole ↦ the sign of x − ρ on the interval; None where poles and roots are numbers.

    Raises:
        NoForm: it diverges, or no form is known here; the text says why.
    """
    refuse(R, P, complex_poles=True)
    path = whole_path(P, interval)
    if not P.pairs or None in interval:
        return first_and_other_kinds(R, path, _kinds(path))

    def of_numbers(place: sp.Expr) -> int:
        return 1 if place < path.e else -1

    kinds = kinds_between_two_roots(path, side or of_numbers, partial(_complex_third, path))
    return first_and_other_kinds(R, path, kinds)


def incomplete(R: PartialFractions, P: BranchPoints, interval: Interval, x: sp.Expr, start: str) -> sp.Expr:
    """∫ R dx/√P from the lower root of the interval to x, or from x to the upper one.

    Args:
        R: the rational function.
        P: the branch points.
        x: the other end, within the interval.
        start: "lower" or "upper": the root at which the integral is zero.

    Raises:
        NoForm: no form is known here; the text says why.
    """
    refuse(R, P, complex_poles=True)
    path = IntegrationPath(P, interval, start, x, whole=False)
    return first_and_other_kinds(R, path, _kinds(path))


@dataclass(frozen=True)
class _Pair:
    """What a complex pair α ± iβ among the three other branch points is replaced by."""

    path: IntegrationPath

    @cached_property
    def pair(self) -> tuple[sp.Expr, sp.Expr]:
        return self.path.P.pairs[0]

    def distance(self, place: sp.Expr) -> sp.Expr:
        """|place − (α + iβ)|."""
        return self.path.P.distance(place)

    def κ(self, place: sp.Expr | None) -> sp.Expr:
        """|v(place) − v₁|/S²."""
        e = self.path.e
        if place is INFINITY:
            return 1 / self.distance(e)
        return self.distance(place) / (sp.sqrt((e - place) ** 2) * self.distance(e))

    @cached_property
    def size(self) -> sp.Expr:
        """|v₁|."""
        return (1 if self.path.x is None else self.distance(self.path.x)) / self.distance(self.path.e)

    @cached_property
    def a2(self) -> sp.Expr:
        (α, β), e, x = self.pair, self.path.e, self.path.x
        along = self.path.σ * (e - α) if x is None else (x - α) * (e - α) + β**2
        return (self.size + along / ((e - α) ** 2 + β**2)) / 2

    @cached_property
    def third(self) -> sp.Expr | None:
        """The real branch point next to e and the pair."""
        return self.path.others[0]

    def p2(self, place: sp.Expr | None) -> sp.Expr:
        return (self.path.v(place) + self.size + self.path.S**2 * self.κ(place)) / 2

    @cached_property
    def z2(self) -> tuple[sp.Expr, sp.Expr]:
        """z₊² and z₋²."""
        above = self.p2(self.third)
        return above, self.a2 * self.path.v(self.third) / above


def _first(path: IntegrationPath) -> sp.Expr:
    """∫ dx/√P."""
    if path.P.pairs:
        pair = _Pair(path)
        return 2 * path.S / sp.sqrt(path.q) * CarlsonRF(pair.a2, *pair.z2)
    return 2 * path.S / sp.sqrt(path.q) * CarlsonRF(*(path.v(r) for r in path.others))


def _third(path: IntegrationPath, place: sp.Expr | None) -> sp.Expr:
    """(2S³/(3√q)) R_J(v(r₁), v(r₂), v(r₃), v(place))."""
    if not path.P.pairs:
        return 2 * path.S**3 / (3 * sp.sqrt(path.q)) * CarlsonRJ(*(path.v(r) for r in path.others), path.v(place))
    pair = _Pair(path)
    moved = pair.p2(place)
    inner = 2 * (moved - pair.a2) * CarlsonRJ(pair.a2, *pair.z2, moved) + 3 * CarlsonRC(
        path.v(pair.third), path.v(place)
    )
    return (2 * path.S * inner / sp.sqrt(path.q) - 3 * _first(path)) / (3 * pair.κ(place))


def _complex_third(path: IntegrationPath, ρ: Parts) -> Parts:
    """Return the same of a complex place; with v(ρ) off the negative axis every argument is, see ``_third``.

    Of the two values of a root in κ either will do: p₊² p₋² = a² v(ρ), and neither is ever negative.
    """
    away = divided((sp.Integer(path.σ), sp.S.Zero), (path.e - ρ[0], -ρ[1]))
    v = away if path.x is None else (1 + (path.σ * (path.x - path.e)) * away[0], (path.σ * (path.x - path.e)) * away[1])
    scale = 2 * path.S**3 / (3 * sp.sqrt(path.q))
    if not path.P.pairs:
        first = [path.v(r) for r in path.others]
        return scale * CarlsonRJRe(*first, *v), scale * CarlsonRJIm(*first, *v)
    pair = _Pair(path)
    α, β = pair.pair
    distance = _root((ρ[0] - α) ** 2 - ρ[1] ** 2 + β**2, 2 * (ρ[0] - α) * ρ[1])
    κ = times(distance, (away[0] / pair.distance(path.e), away[1] / pair.distance(path.e)))
    moved = ((v[0] + pair.size + path.S**2 * κ[0]) / 2, (v[1] + path.S**2 * κ[1]) / 2)
    of_pair, third = (pair.a2, *pair.z2, *moved), path.v(pair.third)
    inner = times((moved[0] - pair.a2, moved[1]), (2 * CarlsonRJRe(*of_pair), 2 * CarlsonRJIm(*of_pair)))
    inner = (inner[0] + 3 * CarlsonRCRe(third, *v), inner[1] + 3 * CarlsonRCIm(third, *v))
    size = 2 * path.S / sp.sqrt(path.q)
    return divided((size * inner[0] - 3 * _first(path), size * inner[1]), (3 * κ[0], 3 * κ[1]))


def _root(re: sp.Expr, im: sp.Expr) -> Parts:
    """√(re + i im), the value with a positive real part where im ≠ 0."""
    size = sp.sqrt(re**2 + im**2)
    sign = sp.S.One if im == 0 else sp.sign(im)
    return sp.sqrt((size + re) / 2), sign * sp.sqrt((size - re) / 2)


def _at_other_end(path: IntegrationPath, r: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """√P/(x − r) and ∫ dx/((x − r)√P) where x may reach r, by Gauss' R_D; see ``moments.Kinds``.

    What is left over of both is σ√(L(x − e)(x − r)) (x + r − 2α)/(|x − r₁| + |r − r₁|).
    """
    pair, first, h = _Pair(path), _first(path), path.e - r
    α, _ = pair.pair
    part = CarlsonRD(pair.a2, pair.z2[1], pair.z2[0])
    regular = (4 * path.S * (pair.z2[0] - pair.a2) * part / sp.sqrt(path.q) - 3 * first) / (3 * pair.κ(r))
    inverse = (first - path.σ / h * regular) / h
    x = path.x
    root = sp.sqrt(path.P.leading * (x - path.e) * (x - r))
    return path.σ * root * (x + r - 2 * α) / (pair.distance(x) + pair.distance(r)), inverse


def _kinds(path: IntegrationPath) -> Kinds:
    return Kinds(_first(path), partial(_third, path), partial(_at_other_end, path), partial(_complex_third, path))
