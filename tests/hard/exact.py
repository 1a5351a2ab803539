"""Motions in closed form at 60 digits: elliptic functions, Kepler's equation in universal variables, hyperbolic functions.

Nothing here knows of hjsolve. Constants are one (m = k = g = l = 1) unless an argument says otherwise.
"""

from __future__ import annotations

from mpmath import mp, mpf

DIGITS = 60


def principal(angle: mpf) -> mpf:
    """The angle in (−π, π]."""
    return angle - 2 * mp.pi * mp.ceil((angle - mp.pi) / (2 * mp.pi))


def pendulum_period(k: mpf) -> mpf:
    """Period of θ″ = −sin θ pushed from the bottom with θ̇ = 2k (a full turn where k > 1)."""
    return 4 * mp.ellipk(k**2) if k < 1 else 2 * mp.ellipk(k**-2) / k


def pendulum(k: mpf, t: mpf) -> tuple[mpf, mpf]:
    """θ (unwrapped) and θ̇ of θ″ = −sin θ with θ(0) = 0, θ̇(0) = 2k (Whittaker §44; DLMF 22.19)."""
    if k == 1:
        return 2 * mp.atan(mp.sinh(t)), 2 / mp.cosh(t)
    turns = mp.nint(t / pendulum_period(k))
    u = t - turns * pendulum_period(k)
    if k < 1:
        sn, cn, dn = (mp.ellipfun(name, u, m=k**2) for name in ("sn", "cn", "dn"))
        return 2 * mp.atan2(k * sn, dn), 2 * k * cn
    sn, cn, dn = (mp.ellipfun(name, k * u, m=k**-2) for name in ("sn", "cn", "dn"))
    return 2 * mp.atan2(sn, cn) + 2 * mp.pi * turns, 2 * k * dn


def _stumpff(z: mpf) -> tuple[mpf, mpf]:
    """c₂(z) and c₃(z), by series near zero."""
    if abs(z) < mpf("0.1"):
        c2 = c3 = mpf(0)
        for n in range(28, -1, -1):
            c2 = (1 - z * c2) / ((2 * n + 1) * (2 * n + 2))
            c3 = (1 - z * c3) / ((2 * n + 2) * (2 * n + 3))
        return c2, c3
    if z > 0:
        s = mp.sqrt(z)
        return 2 * mp.sin(s / 2) ** 2 / z, (s - mp.sin(s)) / s**3
    s = mp.sqrt(-z)
    return 2 * mp.sinh(s / 2) ** 2 / -z, (mp.sinh(s) - s) / s**3


def kepler(e: mpf, t: mpf) -> tuple[mpf, mpf]:
    """r and θ (principal) of the Kepler problem started at the pericentre r = 1 (Battin, universal variables)."""
    α = 1 - e
    if α > 0:
        period = 2 * mp.pi / α ** mpf("1.5")
        t -= period * mp.nint(t / period)

    def time(s: mpf) -> mpf:
        c2, c3 = _stumpff(α * s * s)
        return s**3 * c3 + s * (1 - α * s * s * c3)

    def radius(s: mpf) -> mpf:
        c2, c3 = _stumpff(α * s * s)
        return s * s * c2 + 1 - α * s * s * c2

    low, high, sign = mpf(0), mpf(1), mp.sign(t)
    while time(high) < abs(t):
        low, high = high, 2 * high
    s = high
    for _ in range(400):
        f = time(s) - abs(t)
        low, high = (s, high) if f < 0 else (low, s)
        new = s - f / radius(s)
        if not low < new < high:
            new = (low + high) / 2
        if abs(new - s) < abs(s) * mpf(10) ** (20 - mp.dps):
            s = new
            break
        s = new
    s *= sign
    c2, c3 = _stumpff(α * s * s)
    x, y = 1 - s * s * c2, (t - s**3 * c3) * mp.sqrt(1 + e)
    return radius(s), mp.atan2(y, x)


def double_well(a: mpf, t: mpf) -> mpf:
    """x of x″ = x − x³ released at rest from x = a > 1 (DLMF 22.19(iii)); a² = 2 is the barrier's own energy."""
    if a * a == 2:
        return a / mp.cosh(t)
    if a * a < 2:
        m, rate = 2 - 2 / a**2, a / mp.sqrt(2)
        period, name = 2 * mp.ellipk(m) / rate, "dn"
    else:
        m, rate = a * a / (2 * (a * a - 1)), mp.sqrt(a * a - 1)
        period, name = 4 * mp.ellipk(m) / rate, "cn"
    return a * mp.ellipfun(name, rate * (t - period * mp.nint(t / period)), m=m)


def three_roots(a: mpf, b: mpf, c: mpf, t: mpf) -> mpf:
    """x of ẋ² = (x − a)(b − x)(c − x), x(0) = a < b < c: (Byrd & Friedman 234)."""
    rate, m = mp.sqrt(c - a) / 2, (b - a) / (c - a)
    period = 2 * mp.ellipk(m) / rate
    return a + (b - a) * mp.ellipfun("sn", rate * (t - period * mp.nint(t / period)), m=m) ** 2


def radial_fall_time(r: mpf) -> mpf:
    """Time in which a body released at rest at distance 1 falls to r under 1/r²: [acos √r + √(r(1−r))]/√2."""
    return (mp.acos(mp.sqrt(r)) + mp.sqrt(r * (1 - r))) / mp.sqrt(2)
