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


class Nutation:
    """A tilted axis of height z: ż² = 2h(z − z₁)(z₂ − z)(z₃ − z), ψ̇ = (b + cz)/(1 − z²), φ̇ = cr + ψ̇z, from z₁ or z₂.

    The symmetric top (I_t = 1, r = I_t/I_a) and, with c = 0, the spherical pendulum: z = z₁ + (z₂ − z₁) sn²
    (Whittaker §71), ψ and φ by incomplete Π (DLMF 19.2(ii)).

    Args:
        h: mgl. b, c: momenta of precession and spin. start: the height z₁ or z₂ at t = 0, where ż = 0.
    """

    def __init__(self, h: mpf, b: mpf, c: mpf, start: mpf, ratio: int | mpf = 1):
        self.b, self.c, self.ratio = b, c, ratio
        # 2(E − hz)(1 − z²) − (b + cz)² without its root at the start: E = h·start + (b + c·start)²/(2(1 − start²))
        excess = (b + c * start) ** 2 / (1 - start**2)
        # cubic 2h z³ − (2E + c²) z² − (2h + 2bc) z + 2E − b², E′ = 2E
        e = 2 * h * start + excess
        p, q = 2 * h * start - e - c * c, (2 * h * start - e - c * c) * start - 2 * h - 2 * b * c
        root = mp.sqrt(p * p - 8 * h * q)
        large = (-p + (root if p < 0 else -root)) / (4 * h)
        others = sorted([large, q / (2 * h) / large])
        self.from_top = start > others[0]
        self.low, self.high, self.far = sorted([start, *others])
        self.rate = mp.sqrt(h * (self.far - self.low) / 2)
        self.m = (self.high - self.low) / (self.far - self.low)

    @property
    def period(self) -> mpf:
        return 2 * mp.ellipk(self.m) / self.rate

    def _poles(self, turns: mpf, amplitude: mpf) -> tuple[mpf, mpf]:
        """∫ dt/(1 − z) and ∫ dt/(1 + z) from the lowest height, ``turns`` whole periods and an amplitude."""
        width, result = self.high - self.low, []
        for end, n in ((1 - self.low, width / (1 - self.low)), (1 + self.low, -width / (1 + self.low))):
            part = mp.ellippi(n, amplitude, self.m) + (2 * turns * mp.ellippi(n, self.m) if turns else 0)
            result.append(part / (end * self.rate))
        return result[0], result[1]

    def _place(self, t: mpf) -> tuple[mpf, mpf]:
        turns = mp.nint(t / self.period)
        u = (t - turns * self.period) * self.rate
        sn, cn = mp.ellipfun("sn", u, m=self.m), mp.ellipfun("cn", u, m=self.m)
        return turns, mp.atan2(sn, cn)

    def at(self, t: mpf) -> tuple[mpf, mpf, mpf]:
        """z, ψ − ψ(0), φ − φ(0)."""
        later = self.period / 2 if self.from_top else mpf(0)
        turns, amplitude = self._place(t + later)
        up, down = (
            x - y
            for x, y in zip(self._poles(turns, amplitude), self._poles(mpf(0), mp.pi / 2 if self.from_top else mpf(0)))
        )
        b, c = self.b, self.c
        z = self.low + (self.high - self.low) * mp.sin(amplitude) ** 2
        ψ = ((b + c) * up + (b - c) * down) / 2
        return z, ψ, c * self.ratio * t + ((b + c) * up - (b - c) * down) / 2 - c * t

    def mean(self) -> tuple[mpf, mpf]:
        """Mean rates of ψ and φ."""
        up, down = self._poles(mpf(1), mpf(0))
        b, c, T = self.b, self.c, self.period
        return ((b + c) * up + (b - c) * down) / (2 * T), c * self.ratio - c + ((b + c) * up - (b - c) * down) / (2 * T)

    def action(self) -> mpf:
        """(1/2π) ∮ p dθ = (1/π) ∫ ż²/(1 − z²) dt from the lowest height to the highest, over the amplitude."""
        width = self.high - self.low
        h = 2 * self.rate**2 / (self.far - self.low)

        def power(α: mpf) -> mpf:
            s, k = mp.sin(α) ** 2, mp.cos(α) ** 2
            above, below = 1 - self.low - width * s, 1 + self.low + width * s
            square = 2 * h * width**2 * s * k * (self.far - self.low - width * s)
            return square / (above * below * self.rate * mp.sqrt(1 - self.m * s))

        near = [mp.sqrt(x / width) for x in (1 - self.high, 1 + self.low) if x < width]
        cuts = sorted({x for n in near for x in (n, 30 * n, mp.pi / 2 - n, mp.pi / 2 - 30 * n) if 0 < x < mp.pi / 2})
        return mp.quad(power, [0, *cuts, mp.pi / 2]) / mp.pi
