"""Turning points, periods, actions and frequencies of the catalog in closed form (elliptic integrals, mpmath).

Conventions: J = (1/2π)∮p dq, Ω = ∂H/∂J, period 2π/|Ω|. Nothing here divides by a momentum that vanishes: every
integral is an elementary function or a complete elliptic integral in Legendre's form with parameter m = k².
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mpmath import mp, mpf

Numbers = Mapping[str, mpf]
Values = dict[str, tuple[mpf, str]]


def _cycle(name: str, frequency: mpf, action: mpf, how: str) -> Values:
    """Period, action and frequency of one coordinate."""
    return {
        f"period.{name}": (2 * mp.pi / abs(frequency), how),
        f"action.{name}": (action, how),
        f"frequency.{name}": (frequency, how),
    }


def _turns(name: str, lower: mpf, upper: mpf, how: str) -> Values:
    return {f"turning_point.{name}.lower": (lower, how), f"turning_point.{name}.upper": (upper, how)}


def harmonic_oscillator(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = p²/2m + kx²/2."""
    m, k = par["m"], par["k"]
    E, ω = p["x"] ** 2 / (2 * m) + k * q["x"] ** 2 / 2, mp.sqrt(k / m)
    a = mp.sqrt(2 * E / k)
    return _cycle("x", ω, E / ω, "omega = sqrt(k/m), J = E/omega") | _turns("x", -a, a, "+-sqrt(2*E/k)")


@dataclass(frozen=True)
class PendulumLike:
    """H = p²/(2M) − A cos q, M and A positive; E relative to that potential."""

    inertia: mpf
    depth: mpf
    energy: mpf

    @property
    def librates(self) -> bool:
        """Whether the motion stays below the top."""
        return self.energy < self.depth

    @property
    def amplitude(self) -> mpf:
        """The turning angle of a libration."""
        return mp.acos(-self.energy / self.depth)

    def frequency_and_action(self) -> tuple[mpf, mpf]:
        """|Ω| and |J| by complete elliptic integrals (Whittaker §44)."""
        ω0, M = mp.sqrt(self.depth / self.inertia), self.inertia
        m = (self.energy + self.depth) / (2 * self.depth)
        if self.librates:
            K, Ell = mp.ellipk(m), mp.ellipe(m)
            return mp.pi * ω0 / (2 * K), 8 * M * ω0 * (Ell - (1 - m) * K) / mp.pi
        k = mp.sqrt(1 / m)
        return mp.pi * ω0 / (k * mp.ellipk(1 / m)), 4 * M * ω0 * mp.ellipe(1 / m) / (mp.pi * k)


def pendulum(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = p²/(2ml²) − mgl cos θ."""
    M, A = par["m"] * par["l"] ** 2, par["m"] * par["g"] * par["l"]
    motion = PendulumLike(M, A, p["theta"] ** 2 / (2 * M) - A * mp.cos(q["theta"]))
    Ω, J = motion.frequency_and_action()
    if motion.librates:
        how = "complete elliptic integrals K(k), E(k), k = sin(amplitude/2)"
        turns = _turns("theta", -motion.amplitude, motion.amplitude, "arccos(-E/(m*g*l))")
        return _cycle("theta", Ω, J, how) | turns
    sign = mp.sign(p["theta"])
    return _cycle("theta", sign * Ω, sign * J, "complete elliptic integrals K(k), E(k), k^2 = 2*m*g*l/(E + m*g*l)")


def _kepler_radial(m: mpf, k: mpf, E: mpf, L: mpf) -> Values:
    """Radial data of H = p_r²/2m + L²/(2mr²) − k/r."""
    a, e = k / (2 * abs(E)), mp.sqrt(1 + 2 * E * L**2 / (m * k**2))
    if E > 0:
        return {"turning_point.r.lower": (a * (e - 1), "a*(e - 1), a = k/(2*E), e = sqrt(1 + 2*E*L^2/(m*k^2))")}
    Ω = mp.sqrt(8 * abs(E) ** 3 / (m * k**2))
    how = "Kepler: Omega = sqrt(-8*E^3/(m*k^2)), J = k*sqrt(-m/(2*E)) - L"
    values = _cycle("r", Ω, k * mp.sqrt(m / (2 * abs(E))) - L, how)
    return values | _turns("r", a * (1 - e), a * (1 + e), "a*(1 -+ e), a = -k/(2*E), e = sqrt(1 + 2*E*L^2/(m*k^2))")


def kepler_planar(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_r² + p_θ²/r²)/2m − k/r."""
    m, k, L = par["m"], par["k"], p["theta"]
    E = (p["r"] ** 2 + L**2 / q["r"] ** 2) / (2 * m) - k / q["r"]
    values = _kepler_radial(m, k, E, abs(L))
    if E < 0:
        Ω = values["frequency.r"][0]
        values |= _cycle("theta", mp.sign(L) * Ω, L, "degenerate: Omega_theta = sign(p_theta)*Omega_r, J = p_theta")
    return values


def kepler_spherical(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_r² + p_θ²/r² + p_φ²/(r² sin²θ))/2m − k/r."""
    m, k, p_phi = par["m"], par["k"], p["phi"]
    L = mp.sqrt(p["theta"] ** 2 + p_phi**2 / mp.sin(q["theta"]) ** 2)
    E = (p["r"] ** 2 + L**2 / q["r"] ** 2) / (2 * m) - k / q["r"]
    values = _kepler_radial(m, k, E, L)
    Ω, tilt = values["frequency.r"][0], mp.asin(abs(p_phi) / L)
    values |= _cycle("theta", Ω, L - abs(p_phi), "degenerate: Omega_theta = Omega_r, J = L - |p_phi|")
    values |= _turns("theta", tilt, mp.pi - tilt, "sin(theta) = |p_phi|/L")
    return values | _cycle("phi", mp.sign(p_phi) * Ω, p_phi, "degenerate: Omega_phi = sign(p_phi)*Omega_r, J = p_phi")


def isotropic_oscillator(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_r² + p_θ²/r²)/2m + kr²/2."""
    m, k, L = par["m"], par["k"], p["theta"]
    E, ω = (p["r"] ** 2 + L**2 / q["r"] ** 2) / (2 * m) + k * q["r"] ** 2 / 2, mp.sqrt(k / m)
    root = mp.sqrt(E**2 - ω**2 * L**2)
    values = _cycle("r", 2 * ω, (E / ω - abs(L)) / 2, "Omega_r = 2*sqrt(k/m), J = (E/omega - |L|)/2")
    values |= _turns("r", mp.sqrt((E - root) / k), mp.sqrt((E + root) / k), "r^2 = (E -+ sqrt(E^2 - omega^2*L^2))/k")
    return values | _cycle("theta", mp.sign(L) * ω, L, "Omega_theta = sign(p_theta)*sqrt(k/m), J = p_theta")


class CosineCubic:
    """∫ f(z) dz/√P over the libration z₁ ≤ z ≤ z₂ in (−1, 1) of a cubic P, f one of 1, z, 1/(1−z), 1/(1+z).

    With z = z₂ − (z₂−z₁) sin²x and z₃ the third root below z₁ the integrals are Legendre's K, E and Π. A cubic whose
    third root lies above z₂ is reflected, z → −z.
    """

    def __init__(self, coefficients: list[mpf]):
        lead = coefficients[0]
        self.reflected = lead > 0
        if self.reflected:
            coefficients = [-coefficients[0], coefficients[1], -coefficients[2], coefficients[3]]
        roots = sorted(mp.re(z) for z in mp.polyroots(coefficients, maxsteps=200, extraprec=200))
        self.z3, self.z1, self.z2 = roots
        self.factor = 2 / mp.sqrt(abs(lead) * (self.z2 - self.z3))
        self.m = (self.z2 - self.z1) / (self.z2 - self.z3)

    def turning(self) -> tuple[mpf, mpf]:
        """z₁, z₂ in the caller's z."""
        return (-self.z2, -self.z1) if self.reflected else (self.z1, self.z2)

    def one(self) -> mpf:
        """∫dz/√P."""
        return self.factor * mp.ellipk(self.m)

    def linear(self) -> mpf:
        """∫z dz/√P."""
        K, Ell = mp.ellipk(self.m), mp.ellipe(self.m)
        mean = self.factor * (self.z2 * K - (self.z2 - self.z1) * (K - Ell) / self.m)
        return -mean if self.reflected else mean

    def pole(self, sign: int) -> mpf:
        """∫dz/((1 − sign·z)√P)."""
        sign = -sign if self.reflected else sign
        end = 1 - sign * self.z2
        return self.factor * mp.ellippi(-sign * (self.z2 - self.z1) / end, self.m) / end


def spherical_pendulum(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_θ² + p_φ²/sin²θ)/(2ml²) − mgl cos θ; z = cos θ (Whittaker §55)."""
    M, A, L = par["m"] * par["l"] ** 2, par["m"] * par["g"] * par["l"], p["phi"]
    E = (p["theta"] ** 2 + L**2 / mp.sin(q["theta"]) ** 2) / (2 * M) - A * mp.cos(q["theta"])
    cubic = CosineCubic([-2 * A / M, -2 * E / M, 2 * A / M, 2 * E / M - (L / M) ** 2])
    period, poles = 2 * cubic.one(), cubic.pole(1) + cubic.pole(-1)
    J = (2 * E * cubic.one() + 2 * A * cubic.linear() - L**2 * poles / (2 * M)) / mp.pi
    lower, upper = cubic.turning()
    how = "z = cos(theta): complete elliptic integrals K, E, Pi of the cubic dz/dt^2"
    values = _cycle("theta", 2 * mp.pi / period, J, how)
    values |= _turns("theta", mp.acos(upper), mp.acos(lower), "arccos of the roots of a cubic (polynomial root finder)")
    return values | _cycle("phi", L * poles / (M * period), L, how)


def lagrange_top(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """The symmetric top, θ the elevation; u = sin θ (Whittaker §71)."""
    I_a, I_t, A, a, b = par["I_a"], par["I_t"], par["m"] * par["g"] * par["l"], p["psi"], p["phi"]
    θ = q["theta"]
    energy = p["theta"] ** 2 / (2 * I_t) + (a + b * mp.sin(θ)) ** 2 / (2 * I_t * mp.cos(θ) ** 2) + A * mp.sin(θ)
    slope, height = 2 * A / I_t, 2 * energy / I_t
    cubic = CosineCubic([slope, -height - (b / I_t) ** 2, -slope - 2 * a * b / I_t**2, height - (a / I_t) ** 2])
    period, up, down = 2 * cubic.one(), cubic.pole(1), cubic.pole(-1)
    J = ((2 * energy + b**2 / I_t) * cubic.one() - 2 * A * cubic.linear()) / mp.pi
    J -= ((a + b) ** 2 * up + (a - b) ** 2 * down) / (2 * I_t * mp.pi)
    precession = ((a + b) * up + (a - b) * down) / I_t
    spin = period * b / I_a - period * b / I_t + ((a + b) * up - (a - b) * down) / I_t
    how = "u = sin(theta): complete elliptic integrals K, E, Pi of the cubic du/dt^2"
    lower, upper = cubic.turning()
    values = _cycle("theta", 2 * mp.pi / period, J, how)
    values |= _turns("theta", mp.asin(lower), mp.asin(upper), "arcsin of the roots of a cubic (polynomial root finder)")
    return values | _cycle("psi", precession / period, a, how) | _cycle("phi", spin / period, b, how)


def projectile(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_x² + p_y²)/2m + mgy."""
    top = q["y"] + p["y"] ** 2 / (2 * par["m"] ** 2 * par["g"])
    return {"turning_point.y.upper": (top, "y0 + v_y0^2/(2*g)")}


def liouville_p5_6(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p₁² + p₂² + 2K)/(2(q₁² + q₂²)); only q₂ turns (Greenwood P5-6)."""
    E = (p["q1"] ** 2 + p["q2"] ** 2 + 2 * par["K"]) / (2 * (q["q1"] ** 2 + q["q2"] ** 2))
    b = mp.sqrt(q["q2"] ** 2 - p["q2"] ** 2 / (2 * E))
    return {"turning_point.q2.lower": (b, "b = sqrt((2*alpha_1 + K)/(2*E)) = sqrt(q2^2 - p_q2^2/(2*E))")}


def kepler_parabolic(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """H = (p_u² + p_v² − 4mk)/(2m(u² + v²)); two oscillators in the Liouville time."""
    m, k, u, v = par["m"], par["k"], q["u"], q["v"]
    E = (p["u"] ** 2 + p["v"] ** 2 - 4 * m * k) / (2 * m * (u**2 + v**2))
    fractions = {name: p[name] ** 2 / (2 * m) - E * q[name] ** 2 for name in ("u", "v")}
    Ω = 4 * m * k**2 * (2 * abs(E) / m) ** mp.mpf("1.5") / (2 * k) ** 3
    values: Values = {}
    for name, fraction in fractions.items():
        end = mp.sqrt(fraction / -E)
        how = "oscillators in tau: J = a*sqrt(-m/(2*E)), H = -2*m*k^2/(J_u + J_v)^2"
        values |= _cycle(name, Ω, fraction * mp.sqrt(m / (-2 * E)), how) | _turns(name, -end, end, "+-sqrt(-a/E)")
    return values


def spherical_staeckel(par: Numbers, q: Numbers, p: Numbers) -> Values:
    """Greenwood P5-8 with v₁ = −mk/r, v₂ = mb cos θ, v₃ = mc(1 − cos φ)."""
    m, k, b, c = (par[name] for name in ("m", "k", "b", "c"))
    β = p["phi"] ** 2 / 2 + m * c * (1 - mp.cos(q["phi"]))
    α = p["theta"] ** 2 / 2 + m * b * mp.cos(q["theta"]) + β / mp.sin(q["theta"]) ** 2
    E = (p["r"] ** 2 / 2 + α / q["r"] ** 2) / m - k / q["r"]
    values = _kepler_radial(m, k, E, mp.sqrt(2 * α))
    cubic = CosineCubic([2 * m * b, -2 * α, -2 * m * b, 2 * (α - β)])
    poles = cubic.pole(1) + cubic.pole(-1)
    J_theta = (2 * α * cubic.one() - 2 * m * b * cubic.linear() - β * poles) / mp.pi
    azimuth = PendulumLike(mp.one, m * c, β - m * c)
    Ω_phi, J_phi = azimuth.frequency_and_action()
    sign = mp.one if azimuth.librates else mp.sign(p["phi"])
    Ω_theta = values["frequency.r"][0] / mp.sqrt(2 * α) * mp.pi / cubic.one()
    how = "z = cos(theta): complete elliptic integrals; Omega by implicit differentiation of J_r + sqrt(2*alpha_theta)"
    lower, upper = cubic.turning()
    values |= _cycle("theta", Ω_theta, J_theta, how)
    values |= _turns("theta", mp.acos(upper), mp.acos(lower), "arccos of the roots of a cubic (polynomial root finder)")
    ratio = poles / (2 * mp.pi) * Ω_phi
    values |= _cycle("phi", sign * Ω_theta * ratio, sign * J_phi, how + "; phi moves like a pendulum")
    if azimuth.librates:
        end = azimuth.amplitude
        values |= _turns("phi", -end, end, "arccos(1 - alpha_phi/(m*c))")
    return values


FORMS: dict[str, Callable[[Numbers, Numbers, Numbers], Values]] = {
    "harmonic-oscillator": harmonic_oscillator,
    "pendulum": pendulum,
    "kepler-planar": kepler_planar,
    "kepler-spherical": kepler_spherical,
    "spherical-pendulum": spherical_pendulum,
    "lagrange-top": lagrange_top,
    "projectile": projectile,
    "isotropic-oscillator-polar": isotropic_oscillator,
    "liouville-p5-6": liouville_p5_6,
    "kepler-parabolic": kepler_parabolic,
    "spherical-staeckel": spherical_staeckel,
}
