"""∫ (Kx + L)/((x − p)² + q²) dx/√P for deg P ≤ 2, real: poles z = p ± iq beside the real axis.

With N = 2P(z) + P′(z)(x − z), s² = −P(z) and the discriminant D of P it is N² + 4s²P = D (x − z)², and

    ∫ dx/((x − z) √P) = (1/s) arctan(N/(2s√P)) = (θ − iλ)/s,   ρ e^{iθ} = (N − 2is√P)/((x − z)√D), λ = ln ρ

(Gradshteyn and Ryzhik (2007), 2.266, at a complex place). √P ↦ −√P turns ρ e^{iθ} into its inverse, so sum and
difference of both are rational but for √P: with c = x − p + iq, −P(z) = U + iV, M = √(U² + V²), s = σ + iτ,

    cot θ = −Re(Nc)/(2√P Re(sc)),   sinh 2λ = 4√P Im(s N*)/(D ((x − p)² + q²)),

where D > 0; where D < 0, √|D| takes the place of √D, and tan θ = Im(Nc)/(2√P Im(sc)). The residue at z is
(K − iG)/2, G = (Kp + L)/q, which leaves ((Kσ − Gτ) θ − (Kτ + Gσ) λ)/M. Re(sc) does
not vanish where P > 0. Of a constant P it is a logarithm and an arc tangent.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from hjsolve.closed_form.signs import Signs


@dataclass(frozen=True)
class PairOfComplexPoles:
    """One such integral.

    Attributes:
        polynomial: A, B, C of P.
        pole: p and q > 0.
        numerator: K and L.
        root: σ and τ.
        discriminant: D; zero where P is a constant.
        falling: whether D < 0.
    """

    polynomial: tuple[sp.Expr, sp.Expr, sp.Expr]
    pole: tuple[sp.Expr, sp.Expr]
    numerator: tuple[sp.Expr, sp.Expr]
    root: tuple[sp.Expr, sp.Expr]
    discriminant: sp.Expr
    falling: bool

    kind = "complex poles"
    place = None

    @property
    def leading(self) -> sp.Expr:
        """It is a logarithm over √ of this: P(z) = −s², of the pole above the axis."""
        σ, τ = self.root
        return -((σ + sp.I * τ) ** 2)

    @property
    def ratio(self) -> sp.Expr:
        """Return the square of the ratio of the factors of its two logarithms, of the poles z and z*."""
        (p, q), (K, L), (σ, τ) = self.pole, self.numerator, self.root
        residue = (K * q - sp.I * (K * p + L)) * (σ - sp.I * τ)
        return residue**2 / ((K * q + sp.I * (K * p + L)) * (σ + sp.I * τ)) ** 2

    def integrand(self, x: sp.Symbol) -> sp.Expr:
        """Return the rational factor of the integrand.

        Args:
            x: the variable.
        """
        (p, q), (K, L) = self.pole, self.numerator
        return (K * x + L) / ((x - p) ** 2 + q**2)

    @property
    def weights(self) -> tuple[sp.Expr, sp.Expr]:
        """(Kσ − Gτ)/M and (Kτ + Gσ)/M."""
        (p, q), (K, L), (σ, τ) = self.pole, self.numerator, self.root
        G = sp.factor((K * p + L) / q)
        size = σ**2 + τ**2
        return sp.factor((K * σ - G * τ) / size), sp.factor((K * τ + G * σ) / size)

    def written(self, x: sp.Expr) -> sp.Expr:
        """Return the integral as a function of x.

        Args:
            x: the variable of the curve, or what stands for it.
        """
        (A, B, C), (p, q), (σ, τ), u = self.polynomial, self.pole, self.root, sp.Dummy("u", real=True)
        P = A * u**2 + B * u + C
        # N = 2P(z) + P′(z)(x − z) is the polar of z on the conic y² = P: its real and imaginary part follow
        re, im = sp.expand(A * (p**2 - q**2) + B * p + C), sp.expand(2 * A * p * q + B * q)  # P(z)
        slope_re, slope_im = 2 * A * p + B, 2 * A * q  # P′(z)
        n1 = sp.expand(2 * re + slope_re * (u - p) + slope_im * q)
        n2 = sp.expand(2 * im + slope_im * (u - p) - slope_re * q)
        around = (u - p) ** 2 + q**2
        # of a constant P: ½K ln((x − p)² + q²) + G arctan((x − p)/q)
        if self.discriminant == 0:
            (K, L), root = self.numerator, sp.sqrt(sp.factor_terms(C))
            angle = sp.factor((K * p + L) / q) * sp.atan((u - p) / q)
            return ((K * sp.log(around) / 2 + angle) / root).subs(u, x)
        size = -self.discriminant if self.falling else self.discriminant
        first, second = self.weights
        root = sp.sqrt(sp.factor_terms(P))
        total = sp.S.Zero
        if first != 0 and self.falling:
            across, along = sp.factor(n1 * q + n2 * (u - p)), 2 * sp.factor(σ * q + τ * (u - p))
            share = sp.cancel(across / P)
            # by atan2, as N changes its quadrant along the motion, where an arctan would jump by π
            total += first * (
                # √P > 0 is divided out: P itself overflows where sinh² u does
                sp.atan2(across, root * along) if share.has(u) else sp.atan2(share * root, along)
            )
        elif first != 0:
            ratio = sp.factor(sp.cancel((n1 * (u - p) - n2 * q) / (-2 * (σ * (u - p) - τ * q))))
            total += first * sp.atan2(root, ratio)
        if second != 0:
            # sinh 2λ and not ln ρ: next to λ = 0 a logarithm of a number next to 1 would lose its digits
            level = sp.factor(4 * (τ * n1 - σ * n2) / (size * around))
            total -= second * sp.asinh(root * level) / 2
        return total.subs(u, x)

    def complete(self) -> sp.Expr | None:
        """Return the integral from root to root, −π/s for 1/(x − z); None where P does not have two roots."""
        return None if self.falling or self.polynomial[0] == 0 else -sp.pi * self.weights[0]


def pair_of_complex_poles(
    P: sp.Poly, parts: tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr], signs: Signs
) -> PairOfComplexPoles:
    """Return the integral past a pair of poles.

    Args:
        P: of degree 0, 1 or 2, squarefree.
        parts: p, q, K, L.
        signs: decides between the real forms, and keeps what it decided.
    """
    p, q, K, L = parts
    C, B, A = (P.coeff_monomial(P.gen**k) for k in range(3))
    D = sp.factor(sp.expand(B**2 - 4 * A * C))
    U = sp.factor(-sp.expand(A * (p**2 - q**2) + B * p + C))
    V = sp.factor(-sp.expand(2 * A * p * q + B * q))
    if V == 0:  # s is real or imaginary
        root = (sp.sqrt(U), sp.S.Zero) if signs.sign(U) > 0 else (sp.S.Zero, sp.sqrt(sp.factor_terms(-U)))
    else:
        M = sp.sqrt(sp.factor(sp.expand(U**2 + V**2)))
        # s = √(U + iV): τ = √((M − U)/2), and σ = V/2τ, which has the sign of V
        h = sp.sqrt(sp.factor_terms((M - U) / 2))
        root = (V / (2 * h), h)
    return PairOfComplexPoles((A, B, C), (p, q), (K, L), root, D, signs.sign(D) < 0)
