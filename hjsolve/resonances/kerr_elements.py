"""Geodesics of Kerr's black hole by semi-latus rectum p, eccentricity e and x = cos(inclination).

The turning points are r = pM/(1 ∓ e) and sin²θ = x² (x < 0 against the rotation). With L = x ℓ Carter's equations at
both radii are

    f E² − 2 g E ℓ − h ℓ² − d = 0,   f = r⁴ + a² (r (r + 2) + z² Δ),   g = 2 a r x,   h = x² r (r − 2) + z² Δ,
    d = (r² + a² z²) Δ,   z² = 1 − x²,   Δ = r² − 2r + a²        (M = 1)

whose solution is that of Schmidt, Classical and Quantum Gravity 19 (2002) 2743, (B.1)-(B.20); ℓ in place of L keeps it
regular for polar orbits. Of a circle the second equation is the derivative of the first. The separatrix is where the
third root of the radial polynomial meets the pericentre (Stein and Warburton, Physical Review D 101 (2020) 064007).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from hjsolve import arguments
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.arithmetic.floats import bits_for, multiprecision
from hjsolve.arithmetic.number_types import Mpf, Reals
from hjsolve.arithmetic.root_finding import interpolated_root
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.motion.exact_numbers import to_bits
from hjsolve.motion.tori.radicand_curve import RadicandCurve
from hjsolve.resonances.families import Number
from hjsolve.solution.quadratures import Solution

ELEMENTS = ("p", "e", "x")
_FARTHEST, _STEP = 16.0, 0.97
"""Beyond every separatrix (11.66 for a = 1, e = 1 and x = −1), and the ratio of steps towards it."""
_GUARD = 64
"""Bits beyond those of the result, for what cancels."""


@dataclass(frozen=True)
class KerrConstants:
    """Constants of a geodesic of unit mass, M = 1.

    Attributes:
        energy: E.
        angular_momentum: L_z.
        carter: Q.
    """

    energy: Mpf
    angular_momentum: Mpf
    carter: Mpf


def kerr_constants(a: Mpf, p: Mpf, e: Mpf, x: Mpf, bits: int) -> KerrConstants:
    """Return E, L_z and Q.

    Args:
        a: spin, 0 ≤ a ≤ 1.
        p: semi-latus rectum in units of M.
        e: eccentricity, 0 ≤ e < 1.
        x: cosine of the inclination.

    Raises:
        InvalidInputError: no geodesic has these elements.
    """
    small = 0 if not e else max(0, -2 * e.context.mag(e))
    context = multiprecision(bits + _GUARD + small)
    a, p, e, x = (context.convert(value) for value in (a, p, e, x))
    first = _coefficients(a, x, p / (1 + e))
    second = _coefficients(a, x, p / (1 - e)) if e else _slopes(a, x, p)
    (f1, g1, h1, d1), (f2, g2, h2, d2) = first, second
    κ, ε, ρ, η, σ = d1 * h2 - h1 * d2, d1 * g2 - g1 * d2, f1 * h2 - h1 * f2, f1 * g2 - g1 * f2, g1 * h2 - h1 * g2
    inner = σ * (σ * ε**2 + ρ * ε * κ - η * κ**2)
    if inner < 0:
        raise InvalidInputError(_nothing(p, e, x))
    sign = 1 if x > 0 else -1
    square = (κ * ρ + 2 * ε * σ - 2 * sign * context.sqrt(inner)) / (ρ**2 + 4 * η * σ)
    if not square > 0:
        raise InvalidInputError(_nothing(p, e, x))
    E = context.sqrt(square)
    root = (g1 * E) ** 2 + (f1 * E**2 - d1) * h1
    if root < 0:
        raise InvalidInputError(_nothing(p, e, x))
    ℓ = (context.sqrt(root) - g1 * E) / h1
    return KerrConstants(E, x * ℓ, (1 - x**2) * (a**2 * (1 - E**2) + ℓ**2))


def _nothing(p: Mpf, e: Mpf, x: Mpf) -> str:
    told = f"p = {float(p):.9g}, e = {float(e):.9g}, x = {float(x):.9g}"
    return f"kerr: no geodesic has {told}; p must be beyond the separatrix"


def _coefficients(a: Mpf, x: Mpf, r: Mpf) -> tuple[Mpf, Mpf, Mpf, Mpf]:
    z2, Δ = 1 - x**2, r**2 - 2 * r + a**2
    return (
        r**4 + a**2 * (r * (r + 2) + z2 * Δ), 2 * a * r * x, x**2 * r * (r - 2) + z2 * Δ, (r**2 + a**2 * z2) * Δ,
    )  # fmt: skip


def _slopes(a: Mpf, x: Mpf, r: Mpf) -> tuple[Mpf, Mpf, Mpf, Mpf]:
    """Return the derivatives of the coefficients by r."""
    z2, Δ, slope = 1 - x**2, r**2 - 2 * r + a**2, 2 * (r - 1)
    return (
        4 * r**3 + a**2 * (2 * r + 2 + z2 * slope), 2 * a * x, 2 * x**2 * (r - 1) + z2 * slope,
        2 * r * Δ + (r**2 + a**2 * z2) * slope,
    )  # fmt: skip


def _room(found: KerrConstants, a: Mpf, p: Mpf, e: Mpf) -> Mpf:
    """Return r₂ − r₃, the pericentre less the next root of the radial polynomial."""
    free = 1 - found.energy**2
    r1, r2 = p / (1 - e), p / (1 + e)
    total, product = 2 / free - r1 - r2, a**2 * found.carter / (free * r1 * r2)
    inner = total**2 - 4 * product
    return r2 - (total + total.context.sqrt(inner if inner > 0 else 0 * inner)) / 2


def separatrix_in_bits(a: Mpf, e: Mpf, x: Mpf, bits: int) -> Mpf:
    """Return p of the separatrix.

    Args:
        a: spin.
        e: eccentricity.
        x: cosine of the inclination.
    """
    context = multiprecision(bits + _GUARD)
    a, e, x = (context.convert(value) for value in (a, e, x))
    if e == 0:  # the innermost stable circle: r₁, r₂ and r₃ meet, r₂ − r₃ still changes its sign
        e = context.mpf(0)
    high, step = context.mpf(_FARTHEST), context.mpf(_STEP)

    def room(p: Mpf) -> Mpf:
        return _room(kerr_constants(a, p, e, x, bits), a, p, e)

    above = room(high)
    while True:
        low = 1 + (high - 1) * step
        try:
            below = room(low)
        except InvalidInputError:
            step = (1 + step) / 2
            continue
        if below <= 0:
            break
        high, above = low, below
    least = context.mpf(2) ** (8 - bits)
    return interpolated_root(room, (low, high), (below, above), lambda _, left: abs(left) <= least)


@arguments.with_known_names("separatrix(0.9, 0.5, 0.8)")
def separatrix(a: object, e: object, x: object, *, digits: int = 15) -> Estimate:
    """Return the semi-latus rectum at which bound geodesics of Kerr's black hole end and plunge.

    Args:
        a: spin in units of M, 0 ≤ a < 1; a number or text as of ``motion``.
        e: eccentricity, 0 ≤ e < 1.
        x: cosine of the inclination, −1 ≤ x ≤ 1; negative against the rotation.
        digits: of the result; an ``mpf`` above 15.

    Returns:
        p in units of M, with its error: r₂ = p/(1 + e) is then a double root of the radial polynomial. 6 + 2e without
        spin; Stein and Warburton, Physical Review D 101 (2020) 064007.

    Raises:
        InvalidInputError: a number out of its range.

    Example:
        >>> separatrix(0, "1/2", 1).value
        7.0
    """
    exact = [number(value, source=name) for value, name in ((a, "a"), (e, "e"), (x, "x"))]
    spin, eccentricity, cosine = exact
    if not (0 <= spin < 1 and 0 <= eccentricity < 1 and -1 <= cosine <= 1):
        raise InvalidInputError("separatrix: 0 <= a < 1, 0 <= e < 1 and -1 <= x <= 1 are needed")
    bits = bits_for(max(digits, 15), 64)
    digits_in = bits + _GUARD
    found = separatrix_in_bits(
        to_bits(spin)(digits_in), to_bits(eccentricity)(digits_in), to_bits(cosine)(digits_in), bits
    )
    error = float(found) * 2.0 ** (16 - bits)
    if digits > 15:
        return Estimate(found, error + float(found) * 10.0**-digits)
    return Estimate(float(found), error + float(found) * 2.0**-53)


@dataclass(frozen=True)
class KerrFamily:
    """Geodesics of Kerr's black hole that differ in one of p, e and x; see ``MotionFamily``.

    Attributes:
        solution: of the entry ``kerr``.
        held: the two elements that are given.
        unknown: the other one.
        parameters: name → exact number.
        mass, spin: M and a.
    """

    solution: Solution
    held: Mapping[str, Number]
    unknown: str
    parameters: Mapping[str, sp.Expr]
    mass: sp.Expr
    spin: sp.Expr

    def constants(self, u: Mpf, bits: int) -> dict[str, Mpf]:
        """Return all constants of the motion.

        Args:
            u: value of the unknown.

        Raises:
            InvalidInputError: no geodesic has the elements, or p is not beyond the separatrix.
        """
        context = multiprecision(bits)
        known = {name: value(bits) for name, value in self.held.items()} | {self.unknown: context.convert(u)}
        M, a = to_bits(self.mass)(bits), to_bits(self.spin)(bits)
        elements = a / M, known["p"], known["e"], known["x"]
        found = kerr_constants(*elements, bits)
        if not _room(found, *elements[:3]) > 0:  # p/(1 + e) is then the lower end of no motion up to p/(1 − e)
            raise InvalidInputError(_nothing(*elements[1:]))
        E, L, Q = found.energy, found.angular_momentum * M, found.carter * M**2
        half = context.mpf(1) / 2
        return {"E": -half, "alpha_2": half * (Q + (a * E) ** 2 + L**2), "p_t": -E, "p_phi": L}

    def in_doubles(self, u: float) -> Reals:
        """Return the constants in their order, shape (k,); NaN where no geodesic has the elements.

        Args:
            u: value of the unknown.
        """
        try:
            found = self.constants(multiprecision(128).mpf(float(u)), 128)
        except InvalidInputError:
            return np.full(len(self.solution.constants), np.nan)
        return np.array([float(x) for x in found.values()])

    def grid(self, _curves: Sequence[RadicandCurve]) -> Reals:
        """Return values of the unknown, dense towards the separatrix, ascending."""
        if self.unknown == "e":
            return np.linspace(0.002, 0.998, 120)
        if self.unknown == "x":
            return np.linspace(-1, 1, 121)[1:-1]
        M, a = to_bits(self.mass)(128), to_bits(self.spin)(128)
        last = float(separatrix_in_bits(a / M, self.held["e"](128), self.held["x"](128), 128))
        return last + np.concatenate([10.0 ** np.linspace(-11, -1, 61), np.geomspace(0.12, 1e3, 90)])
