"""∫ R(x) dx/√P(x), deg P = 3 or 4, all roots real, in Legendre's integrals; and x as a function of ∫ dx/√P.

The four branch points, ∞ among them for a cubic, lie on a circle. From a root a the motion goes towards the next, b;
beyond it lie c and d. Then s = (x − a)(b − d)/((x − d)(b − a)) runs from 0 at a to 1 at b, 1/m at c and ∞ at d, and

    ∫ dx/√P = (1/Ω) F(φ|m),   s = sin² φ = sn²(Ω ∫dx/√P | m),   4Ω² = |A (c − a)(b − d)|,

m = (c − d)(b − a)/((c − a)(b − d)), 0 < m < 1; factors with ∞ are left out. Powers of x and 1/(x − r) become powers of
s or of 1/(1 − n s).

Byrd and Friedman, Handbook of elliptic integrals (1971), 251–258 (the map), 310 (powers of sn²), 336 (third kind).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache, partial

import sympy as sp

from hjsolve.closed_form.branch_points import NamedRoots
from hjsolve.closed_form.no_form import NoFormError
from hjsolve.closed_form.signs import Signs
from hjsolve.errors import required
from hjsolve.functions import JacobiAM, JacobiCN, JacobiSN
from hjsolve.functions.elliptic import PartialFractions

FAR = sp.zoo
"""The branch point at infinity of a cubic."""


@dataclass(frozen=True)
class LegendreMap:
    """The map of a piece of the x-axis to 0 ≤ s ≤ 1.

    Attributes:
        a: the root at which s = 0.
        b: where s = 1; ``FAR`` for ∞.
        c: where s = 1/m.
        d: where s = ∞.
        direction: 1 where x > a on the piece, else −1.
        Ω: the factor of the argument.
        k: the modulus in forms, by a name.
        rate: Ω in forms, by a name.
    """

    a: sp.Expr
    b: sp.Expr
    c: sp.Expr
    d: sp.Expr
    direction: int
    Ω: sp.Expr
    k: sp.Expr = field(default_factory=partial(sp.Dummy, "k", positive=True))
    rate: sp.Expr = field(default_factory=partial(sp.Dummy, "rate", positive=True))

    @property
    def m(self) -> sp.Expr:
        """The parameter of the elliptic integrals."""
        return _ratio((self.c, self.d), (self.b, self.a), (self.c, self.a), (self.b, self.d))

    def s(self, x: sp.Expr) -> sp.Expr:
        """sin² φ at x.

        Args:
            x: the variable.
        """
        return _ratio((x, self.a), (self.b, self.d), (x, self.d), (self.b, self.a))

    def pole(self, r: sp.Expr) -> sp.Expr:
        """n, with s = 1/n at x = r.

        Args:
            r: a place, or ``FAR``.
        """
        return _ratio((self.d, r), (self.b, self.a), (self.a, r), (self.b, self.d))


@lru_cache(maxsize=256)
def _ratio(*pairs: tuple[sp.Expr, sp.Expr]) -> sp.Expr:
    """(p₁)(p₂)/((p₃)(p₄)) of differences, those with ∞ left out, which come in twos."""
    value = sp.S.One
    for k, (p, q) in enumerate(pairs):
        if p is FAR or q is FAR:
            continue
        # the first two pairs are numerator, the others denominator
        value = value * (p - q) if k < 2 else value / (p - q)
    # (p − ∞)/(r − ∞) → 1, (p − ∞)/(∞ − r) → −1: infinite differences leave their sign
    far = [(-1 if q is FAR else 1) for p, q in pairs if FAR in (p, q)]
    return sp.factor(sp.cancel(value * sp.Mul(*far)))


def legendre_map(roots: NamedRoots, signs: Signs) -> LegendreMap:
    """Return the map that belongs to the piece of the x-axis a motion is on.

    Args:
        roots: all real.
        signs: of the sample.

    Raises:
        NoFormError: P has complex roots.
    """
    if roots.pairs:
        raise NoFormError("P has complex roots in this regime")
    # a cubic's fourth branch point is ∞, which follows the greatest root and precedes the smallest
    circle = [*roots.real] if len(roots.real) == 4 else [*roots.real, FAR]
    low, high = roots.interval
    # between the upper two roots of a cubic s grows downwards, from x₃ to x₂: then d = ∞ and x is linear in sn²
    upwards = low is not None and not (len(roots.real) == 3 and (low, high) == (1, 2))  # so that ∞ is where s is ∞
    start = required(low if upwards else high)
    direction = 1 if upwards else -1
    # around the circle in the direction of the motion, so that m = (c − d)(b − a)/((c − a)(b − d)) is in (0, 1)
    a, b, c, d = (circle[(start + direction * k) % 4] for k in range(4))
    # 4Ω² = |A (c − a)(b − d)|; of a cubic the difference with ∞ is left out
    size = roots.leading
    for p, q in ((c, a), (b, d)):
        if FAR not in (p, q):
            size = size * (p - q)
    size = sp.factor(size)
    size = size if signs.number(size) > 0 else -size
    return LegendreMap(a, b, c, d, direction, sp.sqrt(sp.factor_terms(size)) / 2)


class LegendreIntegrals:
    """∫ sᵏ dφ/Δ and ∫ dφ/((1 − ns)ᵏ Δ), from 0 to φ, or to π/2.

    Args:
        k: the modulus, as it is written in the functions.
        m: the parameter k², as it is written in coefficients.
        amplitude: φ, sin φ and cos φ; None for π/2.
    """

    def __init__(self, k: sp.Expr, m: sp.Expr, amplitude: tuple[sp.Expr, sp.Expr, sp.Expr] | None):
        self.m, self.named = m, k**2
        if amplitude is None:
            self.φ, self.s, self.edge = None, None, sp.S.Zero
            self.F, self.E = sp.elliptic_k(self.named), sp.elliptic_e(self.named)
            return
        self.φ, sine, cosine = amplitude
        self.s = sine**2
        self.edge = sine * cosine * sp.sqrt(1 - self.named * self.s)
        self.F, self.E = sp.elliptic_f(self.φ, self.named), sp.elliptic_e(self.φ, self.named)

    @classmethod
    def along(cls, u: sp.Expr, k: sp.Expr, m: sp.Expr) -> LegendreIntegrals:
        """Return the integrals up to φ = am u: smooth functions of u for all u.

        Args:
            u: the argument, ∫ dφ/Δ.
            k: the modulus, as it is written in the functions.
            m: the parameter k², as it is written in coefficients.
        """
        own = cls(k, m, (JacobiAM(u, k**2), JacobiSN(u, k**2), JacobiCN(u, k**2)))
        own.F = u
        return own

    def power(self, k: int) -> sp.Expr:
        """Return ∫ sᵏ dφ/Δ; Byrd and Friedman 310.

        Args:
            k: the exponent, 0 or 1.
        """
        # Δ² = 1 − m s, so that m s/Δ = 1/Δ − Δ
        return (self.F - self.E) / self.m if k else self.F

    def third(self, n: sp.Expr, k: int) -> sp.Expr:
        """Return ∫ dφ/((1 − ns)ᵏ Δ); Byrd and Friedman 336.

        Args:
            n: the characteristic, neither 0, 1 nor m.
            k: the order of the pole, 0, 1 or 2.
        """
        m = self.m
        if k == 0:
            return self.F
        if k == 1:
            return sp.elliptic_pi(*((n,) if self.φ is None else (n, self.φ)), self.named)
        edge = sp.S.Zero if self.s is None else n**2 * self.edge / (1 - n * self.s)
        # Byrd and Friedman 336.02, solved for Π₂: d(sn cn dn/(1 − n sn²)) holds Π₂, Π₁, F and E
        total = edge + (n**2 - 2 * n * m - 2 * n + 3 * m) * self.third(n, 1)
        return (total - m * (self.F - n * self.power(1))) / (2 * (1 - n) * (m - n))


def elliptic_integral(
    R: PartialFractions, change: LegendreMap, x: sp.Expr | None, own: LegendreIntegrals | None = None
) -> sp.Expr:  # fmt: skip
    """∫ R dx/√P, increasing x: from a to x, or to a from x where the motion is below a; complete where x is None.

    Args:
        R: in partial fractions.
        change: the map.
        x: the upper end; None for b.
        own: the integrals of dφ/Δ, up to another amplitude than that of x.

    Raises:
        NoFormError: a pole that these integrals do not reach.
    """
    amplitude = None
    if x is not None:
        s = change.s(x)
        # F and Π take φ; sin φ and cos φ are kept apart, since sin(asin √s) would not be simplified under a root
        amplitude = (sp.asin(sp.sqrt(s)), sp.sqrt(s), sp.sqrt(1 - s))
    own = own or LegendreIntegrals(change.k, change.m, amplitude)
    value = over_s(R, change, own) / change.rate
    return value if x is None else change.direction * value


def without_square(R: PartialFractions, change: LegendreMap, P: sp.Poly) -> tuple[PartialFractions, sp.Expr]:
    """R dx/√P of a quartic with 1/(x − d) in place of x², and a with d(a √P) the rest: a pole less of order two in s.

    x² dx/√P = d(√P/(x − d))/A + ½ ((a + b + c + d) x − d (a + b + c − d) + (d − a)(d − b)(d − c)/(x − d)) dx/√P
    """
    weights = dict(R.powers)
    if change.b is FAR or change.d is FAR or P.degree() != 4 or 2 not in weights:
        return R, sp.S.Zero
    x, w, (a, b, c, d) = P.gen, weights.pop(2), (change.a, change.b, change.c, change.d)
    # Vieta: the sum of all four roots, without their radicals
    total = sp.cancel(-P.coeff_monomial(x**3) / P.LC())
    weights[1] = sp.factor(weights.get(1, sp.S.Zero) + w * total / 2)
    weights[0] = weights.get(0, sp.S.Zero) - w * d * (total - 2 * d) / 2
    pole = (d, 1, w * (d - a) * (d - b) * (d - c) / 2)
    powers = tuple((k, weight) for k, weight in sorted(weights.items()) if weight != 0)
    return PartialFractions(powers, (*R.poles, pole), R.complex_poles), w / P.LC() / (x - d)


def over_s(R: PartialFractions, change: LegendreMap, own: LegendreIntegrals) -> sp.Expr:
    """∫ R dφ/Δ.

    Args:
        R: in partial fractions, its poles simple, and none a root of P but d.
        change: the map to s.
        own: the integrals.

    Raises:
        NoFormError: a pole that these integrals do not reach.
    """
    if R.complex_poles:
        raise NoFormError("the integrand has poles at complex places")
    total = sp.S.Zero
    for k, weight in R.powers:
        if k == 0:
            total += weight * own.F
        # x = a + (b − a) s: a power of x is one of s, and only the first is left by the reduction
        elif change.d is FAR:
            total += weight * (change.a * own.F + (change.b - change.a) * own.power(1))
        # of a cubic beyond its greatest root: x dx/√x³ grows without bound, as W of an escape does over a whole cycle
        elif change.b is FAR:
            raise NoFormError("the integral is infinite at the end of the motion")
        else:
            # x = d + (a − d)/(1 − νs), with 1/ν the s of x = ∞
            total += weight * _fraction((change.d, change.a - change.d), change.pole(FAR), k, own)
    for r, k, weight in R.poles:
        if k > 1:
            raise NoFormError("a multiple pole at a place with radicals")
        if r == change.d:
            # 1/(x − d) = (1 − νs)/(a − d) has no pole in s: the two F and E are all that is needed
            total += weight / (change.a - change.d) * (own.F - change.pole(FAR) * own.power(1))
            continue
        # 1/(x − r) = 1/(d − r) + β/(1 − ns): its values at s = ∞ (x = d) and s = 0 (x = a) give both terms
        constant = sp.S.Zero if change.d is FAR else 1 / (change.d - r)
        # in factors as it is: of r with a radical, cancel would multiply (a − r)(d − r) out
        rest = 1 / (change.a - r) if change.d is FAR else (change.d - change.a) * constant / (change.a - r)
        total += weight * _fraction((constant, rest), change.pole(r), k, own)
    return total


def _fraction(line: tuple[sp.Expr, sp.Expr], n: sp.Expr, k: int, own: LegendreIntegrals) -> sp.Expr:
    """∫ (α + β/(1 − ns))ᵏ dφ/Δ."""
    α, β = line
    return sp.Add(*(sp.binomial(k, j) * α ** (k - j) * β**j * own.third(n, j) for j in range(k + 1)))
