"""Bouncing motions in closed form, to the digits of the mpmath context that is active."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mpmath import mp

Truth = Callable[[Any], dict[str, dict[str, Any]]]


def wall(coordinate: str, value: str, **more: Any) -> dict[str, Any]:
    """A table of ``events``."""
    return {"kind": "wall", "at": {"coordinate": coordinate, "value": value}, **more}


def reduced(x: Any, width: Any) -> tuple[Any, int]:
    """A straight way folded into [0, width], and the direction it has there."""
    rest = x - 2 * width * mp.floor(x / (2 * width))
    return (rest, 1) if rest < width else (2 * width - rest, -1)


def ball(t: Any) -> dict[str, dict[str, Any]]:
    """V = 9.81 z, z = 5/4, v = 3/10, floor at 0."""
    g, v0, z0 = mp.mpf("9.81"), mp.mpf("0.3"), mp.mpf("1.25")
    up = mp.sqrt(v0**2 + 2 * g * z0)
    first, each = (v0 + up) / g, 2 * up / g
    if t < first:
        return {"q": {"z": z0 + v0 * t - g * t * t / 2}, "p": {"z": v0 - g * t}}
    s = t - first - each * mp.floor((t - first) / each)
    return {"q": {"z": up * s - g * s * s / 2}, "p": {"z": up - g * s}}


BALL: dict[str, Any] = {
    "system": {"coordinates": [{"name": "z", "domain": "line"}], "kinetic": "dot(z)**2/2", "potential": "9.81*z"},
    "initial": {"q": {"z": "1.25"}, "velocity": {"z": "0.3"}}, "events": [wall("z", "0")],
}  # fmt: skip


def box(t: Any) -> dict[str, dict[str, Any]]:
    """A free particle between x = 0, 2 and y = 0, 1."""
    (x, sx), (y, sy) = reduced(mp.mpf("0.2") + mp.mpf("0.7") * t, 2), reduced(mp.mpf("0.1") + mp.mpf("0.45") * t, 1)
    return {"q": {"x": x, "y": y}, "p": {"x": sx * mp.mpf("0.7"), "y": sy * mp.mpf("0.45")}}


BOX: dict[str, Any] = {
    "system": {"coordinates": [{"name": "x", "domain": "line"}, {"name": "y", "domain": "line"}],
               "kinetic": "dot(x)**2/2 + dot(y)**2/2"},
    "initial": {"q": {"x": "0.2", "y": "0.1"}, "velocity": {"x": "0.7", "y": "0.45"}},
    "events": [wall("x", "0"), wall("x", "2"), wall("y", "0"), wall("y", "1")],
}  # fmt: skip


def quartic(t: Any) -> dict[str, dict[str, Any]]:
    """V = x⁴/4 from x = 0 with v = 1, wall at 4/5: x = A cn(A t − K, 1/√2), A⁴ = 2, run again from wall to wall."""
    half = mp.mpf(1) / 2
    A, K = mp.mpf(2) ** (half / 2), mp.ellipk(half)
    u = mp.asin(mp.sqrt(1 - (mp.mpf("0.8") / A) ** 2))  # cn = 4/5 A at the anomaly F(u)
    hit = (K - mp.ellipf(u, half)) / A
    mirrored = (K + mp.ellipf(u, half)) / A
    each = 4 * K / A - (mirrored - hit)
    τ = t if t < hit else mirrored + (t - hit) - each * mp.floor((t - hit) / each)
    sn, cn, dn = (mp.ellipfun(name, A * τ - K, m=half) for name in ("sn", "cn", "dn"))
    return {"q": {"x": A * cn}, "p": {"x": -A * A * sn * dn}}


QUARTIC: dict[str, Any] = {
    "system": {"coordinates": [{"name": "x", "domain": "line"}], "kinetic": "dot(x)**2/2", "potential": "x**4/4"},
    "initial": {"q": {"x": "0"}, "velocity": {"x": "1"}}, "events": [wall("x", "0.8")],
}  # fmt: skip


class Ellipse:
    """Planar Kepler from r = 1, θ = 3/10, p_r = 1/5, L = 11/10, by Kepler's equation."""

    def __init__(self) -> None:
        self.L, pr = mp.mpf("1.1"), mp.mpf("0.2")
        E = (pr**2 + self.L**2) / 2 - 1
        self.a, self.e = -1 / (2 * E), mp.sqrt(1 + 2 * E * self.L**2)
        u = mp.atan2(pr / mp.sqrt(self.a), 1 - 1 / self.a)
        self.n, self.M = self.a ** mp.mpf("-1.5"), u - self.e * mp.sin(u)
        self.ω = mp.mpf("0.3") - self.anomaly(u)

    def anomaly(self, u: Any) -> Any:
        """The true one."""
        return 2 * mp.atan2(mp.sqrt(1 + self.e) * mp.sin(u / 2), mp.sqrt(1 - self.e) * mp.cos(u / 2))

    def free(self, t: Any) -> tuple[Any, Any, Any]:
        """r, unwrapped θ, dr/dt without walls."""
        turns = mp.nint((self.M + self.n * t) / (2 * mp.pi))
        M = self.M + self.n * t - 2 * mp.pi * turns
        u = mp.findroot(lambda x: x - self.e * mp.sin(x) - M, M + self.e * mp.sin(M))
        r = self.a * (1 - self.e * mp.cos(u))
        return r, self.anomaly(u) + 2 * mp.pi * turns + self.ω, mp.sqrt(self.a) * self.e * mp.sin(u) / r

    def inside(self, radius: Any, t: Any) -> tuple[Any, Any, Any]:
        """The same with a circular wall."""
        u = mp.acos((1 - radius / self.a) / self.e)
        hit, mirrored = ((s * (u - self.e * mp.sin(u)) - self.M) / self.n for s in (1, -1))
        if t < hit:
            return self.free(t)
        times = mp.floor((t - hit) / (hit - mirrored)) + 1
        r, θ, speed = self.free(t - times * (hit - mirrored))
        return r, θ + times * 2 * self.anomaly(u), speed


def circle(t: Any) -> dict[str, dict[str, Any]]:
    """A wall at r = 6/5."""
    ellipse = Ellipse()
    r, θ, speed = ellipse.inside(mp.mpf("1.2"), t)
    return {"q": {"r": r, "theta": θ}, "p": {"r": speed, "theta": ellipse.L}}


def rays(t: Any) -> dict[str, dict[str, Any]]:
    """Walls at θ = −1/2 and θ = 1 alone."""
    ellipse = Ellipse()
    r, θ, speed = ellipse.free(t)
    θ, sign = reduced(θ + mp.mpf("0.5"), mp.mpf("1.5"))
    return {"q": {"r": r, "theta": θ - mp.mpf("0.5")}, "p": {"r": speed, "theta": sign * ellipse.L}}


def sector(t: Any) -> dict[str, dict[str, Any]]:
    """Walls at r = 6/5, θ = −1/2 and θ = 1: H is even in both momenta, so θ is that of the circle, folded."""
    there = circle(t)
    θ, sign = reduced(there["q"]["theta"] + mp.mpf("0.5"), mp.mpf("1.5"))
    return {
        "q": {"r": there["q"]["r"], "theta": θ - mp.mpf("0.5")},
        "p": {"r": there["p"]["r"], "theta": sign * mp.mpf("1.1")},
    }


KEPLER: dict[str, Any] = {
    "system": "kepler-planar", "initial": {"q": {"r": "1", "theta": "0.3"}, "velocity": {"r": "0.2", "theta": "1.1"}},
}  # fmt: skip
CIRCLE = {**KEPLER, "events": [wall("r", "1.2")]}
SECTOR = {**KEPLER, "events": [wall("r", "1.2"), wall("theta", "1"), wall("theta", "-0.5")]}


def violations(run: Any, truth: Truth) -> tuple[Any, int]:
    """The largest true error over all times, and how many numbers are off by more than their claim."""
    worst, count, t = mp.zero, 0, run.trajectory
    for k, time in enumerate(t.t):
        for part, values in truth(mp.mpf(float(time)) if isinstance(time, float) else mp.mpf(time)).items():
            for name, value in values.items():
                got = mp.mpf(getattr(t, part)[name][k])
                if part == "q" and name in t.turns:
                    got += 2 * mp.pi * int(t.turns[name][k])
                worst = max(worst, abs(got - value))
                count += abs(got - value) > getattr(t.error, part)[name][k]
    return worst, count
