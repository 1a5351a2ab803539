"""Bound geodesics of Kerr's space-time (G = c = M = 1) at many digits, two ways; nothing here knows of hjsolve.

Frequencies are per unit of Mino's time λ, dτ = (r² + a² cos²θ) dλ (Mino, Phys. Rev. D 67 (2003) 084027); divided by the mean
of r² + a² cos²θ they are per unit of proper time, divided by Γ = ⟨dt/dλ⟩ per unit of the time of a far observer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mpmath import mp, mpf


@dataclass(frozen=True)
class Orbit:
    """Spin, energy, axial angular momentum, Carter's constant, squared mass, and the roots of R(r), largest first."""

    a: mpf
    E: mpf
    L: mpf
    Q: mpf
    mass: mpf
    roots: tuple[mpf, mpf, mpf, mpf]

    @property
    def horizon(self) -> Callable[[mpf], mpf]:
        return lambda r: r * r - 2 * r + self.a**2

    def momentum(self, r: mpf) -> mpf:
        """p_r = √R/Δ."""
        a, E, L = self.a, self.E, self.L
        R = (E * (r * r + a * a) - a * L) ** 2 - self.horizon(r) * (self.mass * r * r + (L - a * E) ** 2 + self.Q)
        return mp.sqrt(R) / self.horizon(r)

    @property
    def polar(self) -> tuple[mpf, mpf]:
        """The squares z₋² < z₊² of cos θ at which Θ vanishes, from β z⁴ − (Q + L² + β) z² + Q = 0, β = a²(μ² − E²)."""
        β = self.a**2 * (self.mass - self.E**2)
        half = (self.Q + self.L**2 + β) / 2
        large = half + mp.sqrt(half**2 - β * self.Q)
        return self.Q / large, large / β


def from_turning_points(a: mpf, p: mpf, e: mpf, x: mpf) -> Orbit:
    """The orbit of unit mass with r = p/(1 ∓ e) and cos²θ = 1 − x² at its ends, x > 0 with the spin; 0 < a < 1.

    W. Schmidt, Class. Quantum Grav. 19 (2002) 2743, eqs. (B5)-(B18).
    """
    z2, r1, r2 = 1 - x * x, p / (1 - e), p / (1 + e)

    def delta(r: mpf) -> mpf:
        return r * r - 2 * r + a * a

    def d(r: mpf) -> mpf:
        return (r * r + a * a * z2) * delta(r)

    def f(r: mpf) -> mpf:
        return r**4 + a * a * (r * (r + 2) + z2 * delta(r))

    def g(r: mpf) -> mpf:
        return 2 * a * r

    def h(r: mpf) -> mpf:
        return r * (r - 2) + z2 / (1 - z2) * delta(r)

    def det(u: Callable[[mpf], mpf], v: Callable[[mpf], mpf]) -> mpf:
        return u(r1) * v(r2) - u(r2) * v(r1)

    κ, ε, ρ, η, σ = det(d, h), det(d, g), det(f, h), det(f, g), det(g, h)
    side = mp.sign(x)
    square = (κ * ρ + 2 * ε * σ - side * 2 * mp.sqrt(σ * (σ * ε**2 + ρ * ε * κ - η * κ**2))) / (ρ**2 + 4 * η * σ)
    E = mp.sqrt(square)
    L = (-g(r1) * E + side * mp.sqrt(g(r1) ** 2 * square + (f(r1) * square - d(r1)) * h(r1))) / h(r1)
    Q = z2 * (a * a * (1 - square) + L * L / (1 - z2))
    total, product = 2 / (1 - square) - r1 - r2, a * a * Q / ((1 - square) * r1 * r2)
    r3 = (total + mp.sqrt(total**2 - 4 * product)) / 2
    return Orbit(a, E, L, Q, mpf(1), (r1, r2, r3, product / r3))


def from_start(a: mpf, r: mpf, θ: mpf, p_t: mpf, p_r: mpf, p_θ: mpf, p_φ: mpf) -> Orbit:
    """The orbit through a place with given momenta; the roots of R by mpmath's polynomial solver."""
    E, L, s, Δ = -p_t, p_φ, mp.sin(θ), r * r - 2 * r + a * a
    mass = ((E * (r * r + a * a) - a * L) ** 2 / Δ - Δ * p_r**2 - p_θ**2 - (a * E * s - L / s) ** 2) / (
        r * r + a * a * mp.cos(θ) ** 2
    )
    Q = p_θ**2 + mp.cos(θ) ** 2 * (a * a * (mass - E * E) + L * L / s**2)
    K = Q + (L - a * E) ** 2
    quartic = [E * E - mass, 2 * mass, 2 * E * (a * a * E - a * L) - mass * a * a - K, 2 * K,
               (a * a * E - a * L) ** 2 - a * a * K]  # fmt: skip
    roots = sorted((mp.re(z) for z in mp.polyroots(quartic, maxsteps=500, extraprec=400)), reverse=True)
    return Orbit(a, E, L, Q, mass, tuple(roots))


def by_quadrature(orbit: Orbit) -> dict[str, mpf]:
    """Mino frequencies r, theta, phi, the growth t of Boyer and Lindquist's time and tau of proper time, by quadrature.

    r = r₂ + (r₁ − r₂) s, s = 1/(1 + e^−u): the trapezoidal rule in u over the whole line, nodes doubled until all digits stand.
    """
    a, E, L = orbit.a, orbit.E, orbit.L

    def radial(r: mpf) -> list[mpf]:
        wheel = (E * (r * r + a * a) - a * L) / orbit.horizon(r)
        return [mpf(1), a * wheel, (r * r + a * a) * wheel, r * r]

    def polar(z: mpf) -> list[mpf]:
        return [mpf(1), L / (1 - z), a * a * E * (1 - z), a * a * z]

    half, *over_r = _over_r(orbit, radial)
    quarter, *over_θ = _over_θ(orbit, polar)
    (φr, tr, τr), (φθ, tθ, τθ) = ([x / half for x in over_r], [x / quarter for x in over_θ])
    return {
        "r": mp.pi / half,
        "theta": mp.pi / 2 / quarter,
        "phi": φr - a * E + φθ,
        "t": tr + a * L - tθ,
        "tau": τr + τθ,
    }


def _over_r(orbit: Orbit, f: Callable[[mpf], list[mpf]]) -> list[mpf]:
    """∫ f dr/√R from r₂ to r₁."""
    r1, r2, r3, r4 = orbit.roots
    scale, gap, width = orbit.mass - orbit.E**2, r2 - r3, r1 - r2

    def values(u: mpf) -> list[mpf]:
        s, rest = 1 / (1 + mp.exp(-u)), 1 / (1 + mp.exp(u))
        r = r2 + width * s
        weight = mp.sqrt(s * rest) / mp.sqrt(scale * (gap + width * s) * (r - r4))
        return [weight * x for x in f(r)]

    reach = mpf(5 * mp.dps)
    return _until_they_stand(lambda n: [values(reach * (2 * k - n) / n) for k in range(n + 1)], 2 * reach, 8 * mp.dps)


def _over_θ(orbit: Orbit, f: Callable[[mpf], list[mpf]]) -> list[mpf]:
    """∫ f dθ/√Θ over a quarter of the swing: cos θ = z₋ sin χ, even and periodic in χ."""
    low, high = orbit.polar
    β = orbit.a**2 * (orbit.mass - orbit.E**2)

    def values(χ: mpf) -> list[mpf]:
        z = low * mp.sin(χ) ** 2
        return [x / mp.sqrt(β * (high - z)) for x in f(z)]

    return _until_they_stand(lambda n: [values(mp.pi / 2 * (k + mpf(1) / 2) / n) for k in range(n)], mp.pi / 2, 8)


def _until_they_stand(rows: Callable[[int], list[list[mpf]]], length: mpf, n: int) -> list[mpf]:
    """Equal steps over an interval, their number doubled until all digits stand."""
    before: list[mpf] | None = None
    while True:
        total = [length / n * mp.fsum(column) for column in zip(*rows(n), strict=True)]
        if before is not None and all(
            abs(x - y) <= abs(x) * mpf(10) ** (5 - mp.dps) for x, y in zip(total, before, strict=True)
        ):
            return total
        n, before = 2 * n, total


def in_closed_form(orbit: Orbit) -> dict[str, mpf]:
    """Mino frequencies r, theta, phi by complete elliptic integrals.

    R. Fujita and W. Hikida, Class. Quantum Grav. 26 (2009) 135002, eqs. (20)-(22), for unit mass.
    """
    a, E, L, (r1, r2, r3, r4) = orbit.a, orbit.E, orbit.L, orbit.roots
    low, high = orbit.polar
    kr, kθ = (r1 - r2) * (r3 - r4) / ((r1 - r3) * (r2 - r4)), low / high
    root = mp.sqrt((1 - E * E) * (r1 - r3) * (r2 - r4))
    Υr = mp.pi * root / (2 * mp.ellipk(kr))
    Υθ = mp.pi * mp.sqrt(a * a * (1 - E * E) * high) / (2 * mp.ellipk(kθ))
    inner, outer = 1 - mp.sqrt(1 - a * a), 1 + mp.sqrt(1 - a * a)
    hr = (r1 - r2) / (r1 - r3)

    def part(edge: mpf) -> mpf:
        h = hr * (r3 - edge) / (r2 - edge)
        Π = mp.ellippi(h, kr) / mp.ellipk(kr)
        return (2 * E * edge - a * L) / (r3 - edge) * (1 - (r2 - r3) / (r2 - edge) * Π)

    polar = L * mp.ellippi(low, kθ) / mp.ellipk(kθ)
    return {"r": Υr, "theta": Υθ, "phi": polar + a / (outer - inner) * (part(outer) - part(inner))}
