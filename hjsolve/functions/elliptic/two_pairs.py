"""∫ R(x) dx/√P(x) where P has two complex pairs and no real root, from one place to another, in real Carlson functions.

P = L Q₁ Q₂, Qᵢ = (x − αᵢ)² + βᵢ²; integrals are from y to x, any two places with no pole between. With
ξᵢ = √Qᵢ(x), ηᵢ = √Qᵢ(y), d = x − y, and squares of the factor L in Q₁ (h = L),

    Z = ((ξ₁ + η₁)² − h d²)((ξ₂ + η₂)² − d²),   Z± = Z + d² D±,   D± = 2h(e² + β₁² + β₂² ± S),
    ∫ dx/√P = 4d R_F(Z, Z₋, Z₊),   e = α₁ − α₂,   S² = (e² + (β₁ + β₂)²)(e² + (β₁ − β₂)²)

(Carlson, Math. Comp. 59 (1992) 165, (2.36) multiplied by powers of d, so that nothing is infinite at x = y: odd in d
and without branches). The third kind is (2.39), with the pole at infinity as its limit. The second kind follows from
derivatives of the first by α₁ and β₁, which are ∫ (x − α₁) dx/(((x − α₁)² + β₁²)√P) and −β₁ ∫ dx/((…)√P), and from
d[(x − α₁) √(Q₂/Q₁)]; higher powers and poles from d[(x − ρ)ⁿ √P].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from hjsolve.functions.carlson import CarlsonRC, CarlsonRD, CarlsonRF, CarlsonRJ
from hjsolve.functions.elliptic.branch_points import BranchPoints, NoForm, PartialFractions
from hjsolve.functions.jacobi import JacobiCN, JacobiSN

_EDGE = -1
"""The number of [√P] among the parts of a moment; integrals have 0, 1, 2."""


def between(R: PartialFractions, P: BranchPoints, y: sp.Expr, x: sp.Expr) -> sp.Expr:
    """∫ R dx/√P from y to x.

    Args:
        R: the rational function; no pole between y and x.
        P: two complex pairs, the leading coefficient positive.
        y: where the integral begins.
        x: where it ends.

    Raises:
        NoForm: the integrand has complex poles.
    """
    if R.complex_poles:
        raise NoForm("the integrand has complex poles, and P no real root")
    path = _Between(P, y, x)
    return sp.Add(path.powers(R.powers), *(c * path.pole(r, m) for r, m, c in R.poles))


def around(R: PartialFractions, P: BranchPoints) -> sp.Expr:
    """∫ R dx/√P over the whole line, the limit of ``between``.

    Args:
        R: a constant.
        P: two complex pairs.

    Raises:
        NoForm: R is not a constant.
    """
    if R.poles or R.complex_poles or any(k for k, _ in R.powers):
        raise NoForm("the integral over the whole line is known here of the first kind only")
    D = _Between(P, sp.S.Zero, sp.S.One).D
    return sp.Add(*(c for _, c in R.powers)) * 4 * CarlsonRF(0, *D)


def inverse_between(P: BranchPoints, y: sp.Expr, u: sp.Expr, *, farther: int) -> sp.Expr:
    """X for which ∫ dx/√P from y is u.

    T = (x − λ₁)/(x − λ₂) with λ₁, λ₂ harmonic to both pairs makes P even: (T² + c₁²)(T² + c₂²), T = c sn/cn; with
    α₁ = α₂ it is x − α₁ (Byrd and Friedman, Handbook of elliptic integrals (1971), 267).

    Args:
        P: two complex pairs.
        y: where the integral begins.
        farther: which pair, 0 or 1, is the farther from the real axis in T, at the sample.
    """
    (α1, β1), (α2, β2) = P.pairs
    if α1 == α2:
        sizes, scale = (β1, β2), sp.sqrt(P.leading)
        begin = y - α1
    else:
        total = (α1**2 + β1**2 - α2**2 - β2**2) / (α1 - α2)
        gap = sp.sqrt(total**2 / 4 - total * α1 + α1**2 + β1**2)  # λ₁λ₂ = (λ₁ + λ₂)α₁ − α₁² − β₁²
        λ1, λ2 = total / 2 + gap, total / 2 - gap
        squares = [((λ - α) ** 2 + β**2) for α, β in P.pairs for λ in (λ1, λ2)]
        sizes = (sp.sqrt(squares[0] / squares[1]), sp.sqrt(squares[2] / squares[3]))
        scale = sp.sqrt(P.leading * squares[1] * squares[3]) / (2 * gap)
        begin = (y - λ1) / (y - λ2)
    far, near = sizes[farther], sizes[1 - farther]
    m = 1 - near**2 / far**2
    argument = scale * far * u + sp.elliptic_f(sp.atan(begin / near), m)
    s, c = near * JacobiSN(argument, m), JacobiCN(argument, m)
    return α1 + s / c if α1 == α2 else (λ1 * c - λ2 * s) / (c - s)


@dataclass(frozen=True)
class _Between:
    """The integrals from y to x."""

    P: BranchPoints
    y: sp.Expr
    x: sp.Expr

    @cached_property
    def d(self) -> sp.Expr:
        return self.x - self.y

    @cached_property
    def h(self) -> sp.Expr:
        return self.P.leading

    @cached_property
    def e(self) -> sp.Expr:
        return self.P.pairs[0][0] - self.P.pairs[1][0]

    def quadratic(self, k: int, place: sp.Expr) -> sp.Expr:
        """Q₁ with the factor h, or Q₂."""
        α, β = self.P.pairs[k]
        return ((place - α) ** 2 + β**2) * (self.h if k == 0 else 1)

    @cached_property
    def ξ(self) -> tuple[sp.Expr, sp.Expr]:
        return sp.sqrt(self.quadratic(0, self.x)), sp.sqrt(self.quadratic(1, self.x))

    @cached_property
    def η(self) -> tuple[sp.Expr, sp.Expr]:
        return sp.sqrt(self.quadratic(0, self.y)), sp.sqrt(self.quadratic(1, self.y))

    @cached_property
    def ζ2(self) -> tuple[sp.Expr, sp.Expr]:
        (ξ1, ξ2), (η1, η2) = self.ξ, self.η
        return (ξ1 + η1) ** 2 - self.h * self.d**2, (ξ2 + η2) ** 2 - self.d**2

    @cached_property
    def S(self) -> tuple[sp.Expr, sp.Expr]:
        """e² + (β₁ ± β₂)²."""
        (_, β1), (_, β2) = self.P.pairs
        return self.e**2 + (β1 + β2) ** 2, self.e**2 + (β1 - β2) ** 2

    @cached_property
    def D(self) -> tuple[sp.Expr, sp.Expr]:
        """D₋ and D₊."""
        u, v = map(sp.sqrt, self.S)
        return self.h * (u - v) ** 2, self.h * (u + v) ** 2

    @cached_property
    def Z(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        plain = self.ζ2[0] * self.ζ2[1]
        return plain, plain + self.d**2 * self.D[0], plain + self.d**2 * self.D[1]

    @cached_property
    def first(self) -> sp.Expr:
        """∫ dx/√P."""
        return 4 * self.d * CarlsonRF(*self.Z)

    @cached_property
    def linear(self) -> sp.Expr:
        """∫ x dx/√P: the limit of the third kind with the pole at infinity."""
        return 2 * self._H(sp.S.One, sp.S.Zero) + self.P.pairs[0][0] * self.first

    @cached_property
    def about_first(self) -> list[sp.Expr]:
        """∫ sᵏ dx/√P, k = 0, 1, 2, s = x − α₁."""
        (α1, β1), (_, β2) = self.P.pairs
        e, (u, v) = self.e, self.S
        g, root = e**2 + β2**2, sp.sqrt(u * v)
        one = self.linear - α1 * self.first
        by_e = [4 * self.h * e + side * 2 * self.h * e * (u + v) / root for side in (-1, 1)]
        by_β = [4 * self.h * β1 + side * 2 * self.h * ((β1 + β2) * v + (β1 - β2) * u) / root for side in (-1, 1)]
        both = [2 * e * a - (g - β1**2) / β1 * b for a, b in zip(by_e, by_β, strict=True)]
        (ξ1, ξ2), (η1, η2) = self.ξ, self.η
        slopes = [(-2 * e * (place - α1) - (g - β1**2)) * self.h / r for place, r in ((self.x, ξ1), (self.y, η1))]
        moved = 2 * (ξ1 + η1) * sp.Add(*slopes) * self.ζ2[1]
        Z, less, more = self.Z
        mixed = -2 * self.d * moved / sp.sqrt(Z * less * more)
        mixed -= 2 * self.d**3 / 3 * (both[0] * CarlsonRD(Z, more, less) + both[1] * CarlsonRD(Z, less, more))
        edge = (self.x - α1) * ξ2 / ξ1 - (self.y - α1) * η2 / η1
        return [self.first, one, edge - e * one - β1**2 * (self.first + mixed)]

    def _H(self, a5: sp.Expr, b5: sp.Expr) -> sp.Expr:
        """H of (2.22) for 1/(a₅ + b₅x), times 1: its powers of d are taken into the arguments."""
        (ξ1, ξ2), (η1, η2), d, h = self.ξ, self.η, self.d, self.h
        (α1, β1), (α2, β2) = self.P.pairs
        f1, g1, f2, g2 = h * (α1**2 + β1**2), -2 * h * α1, α2**2 + β2**2, -2 * α2
        α15, α25, β15, β25 = 2 * f1 * b5 - g1 * a5, 2 * f2 * b5 - g2 * a5, g1 * b5 - 2 * h * a5, g2 * b5 - 2 * a5
        γ1, γ2 = h * ((a5 + b5 * α1) ** 2 + (b5 * β1) ** 2), (a5 + b5 * α2) ** 2 + (b5 * β2) ** 2
        δ12, δ11 = 2 * h * (self.e**2 + β1**2 + β2**2), 4 * h**2 * β1**2
        Λ, ψ = δ11 * γ2 / γ1, (α15 * β25 - α25 * β15) / 2
        Z, ξ5, η5 = self.Z[0], a5 + b5 * self.x, a5 + b5 * self.y
        Ω, U = Z + d**2 * Λ, ξ1 * η2 + η1 * ξ2
        S = (Z + d**2 * δ12) / 2 - U**2
        θ1 = ξ1**2 + η1**2 - h * d**2
        X = ξ5 * η5 * θ1 / 2 * (ξ2 / ξ1 - η2 / η1) - ξ1 * ξ2 * η5**2 + η1 * η2 * ξ5**2
        μ = γ1 * ξ5 * η5 / (ξ1 * η1)
        T, V2 = μ * S + 2 * γ1 * γ2 * d**2, μ**2 * (S**2 + Λ * U**2 * d**2)
        value = -X * CarlsonRC(T**2, V2)
        if ψ != 0:
            b2 = Ω**2 * (S**2 / U**2 + Λ * d**2)
            a2 = b2 + Λ**2 * ψ**2 / (γ1 * γ2) * d**6
            value += δ11 * ψ / γ1**2 * d**3 * (CarlsonRJ(*self.Z, Ω) / 3 + CarlsonRC(a2, b2) / 2)
        return value

    def powers(self, wanted: Sequence[tuple[int, sp.Expr]]) -> sp.Expr:
        """Σ c ∫ xᵏ dx/√P: all from three integrals and one edge, each once.

        Args:
            wanted: (k, c), k from 0 on.
        """
        α1, total = self.P.pairs[0][0], dict[int, sp.Expr]()
        for k, c in wanted:
            for n in range(k + 1):
                weight = c * sp.binomial(k, n) * α1 ** (k - n)
                for j, part in self._reduced(n).items():
                    total[j] = total.get(j, sp.S.Zero) + weight * part
        if set(total) <= {0, 1}:  # no second kind
            one = total.get(1, sp.S.Zero)
            return (total.get(0, sp.S.Zero) - α1 * one) * self.first + one * self.linear
        integrals = [total.pop(j, sp.S.Zero) * integral for j, integral in enumerate(self.about_first)]
        return sp.Add(*integrals, *(part * self._edge(α1, _EDGE - j) for j, part in total.items()))

    def _reduced(self, n: int) -> dict[int, sp.Expr]:
        """∫ sⁿ dx/√P in those of n = 0, 1, 2, by their numbers, and in [sᵐ √P], by the number ``_EDGE`` − m."""
        if n < 3:
            return {n: sp.S.One}
        m, found = n - 3, dict[int, sp.Expr]()
        P = self.P.taylor(self.P.pairs[0][0])
        size = (m + 2) * P[4]
        found[_EDGE - m] = 1 / size
        for k in range(4):
            for j, part in self._reduced(m + k - 1).items() if m + k > 0 else ():
                found[j] = found.get(j, sp.S.Zero) - P[k] * (m + sp.Rational(k, 2)) / size * part
        return found

    def _edge(self, place: sp.Expr, n: int) -> sp.Expr:
        """(x − place)ⁿ √P from y to x."""
        ends = [(z - place) ** n * r1 * r2 for z, (r1, r2) in ((self.x, self.ξ), (self.y, self.η))]
        return ends[0] - ends[1]

    def pole(self, place: sp.Expr, m: int) -> sp.Expr:
        """∫ dx/((x − place)ᵐ √P).

        Args:
            place: of the pole.
            m: its order.
        """
        if m == 1:
            α1, β1 = self.P.pairs[0]
            ratio = (place - α1) / ((place - α1) ** 2 + β1**2)
            return -2 * self._H(-place, sp.S.One) - ratio * self.first
        P, n = self.P.taylor(place), m - 1
        lower = [P[k] * (sp.Rational(k, 2) - n) * self._about(place, k - n - 1) for k in range(1, 5)]
        return (sp.Add(*lower) - self._edge(place, -n)) / (n * P[0])

    def _about(self, place: sp.Expr, n: int) -> sp.Expr:
        """∫ (x − place)ⁿ dx/√P."""
        if n < 0:
            return self.pole(place, -n)
        return self.powers([(k, sp.binomial(n, k) * (-place) ** (n - k)) for k in range(n + 1)])
