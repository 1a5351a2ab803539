"""Greenwood chapter 4: variational principles, least action and geodesics, Hamilton's equations."""

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

from tests.support import entries
from tests.support.book import (  # fmt: skip
    RESULTS,
    Mechanics,
    Result,
    differs,
    exact,
    formula,
    mechanics,
    motion,
    off,
    on_shell,
    p_of,
    result,
    start,
)
from tests.support.pfaff import curvature, one_form

S = sp.Symbol


@result("C28", "Ex 4-5, (4-195), (4-196), (5-122)")
def kepler_orbit():
    """r = (C^2/(mu*m^2))/(1 + e*cos(theta)), e = sqrt(1 + 2hC^2/(mu^2*m^3))."""
    run = motion("kepler-planar")
    E, C = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_theta"))
    e = mp.sqrt(1 + 2 * E * C**2)
    places = np.array([1.1, 1.7, 2.4])
    found = run.orbit("theta", along="r", values=places)
    return max(off(C**2 / (1 + e * mp.cos(mp.mpf(float(θ)))), r) for θ, r in zip(found, places, strict=True))


@result("C28", "(5-119), (5-120)")
def kepler_quadratures():
    """t - t0 = integral of dr/sqrt(2E + 2mu/r - L^2/r^2), theta - theta0 = integral of L*dr/(r*sqrt(2E*r^2 +
    2mu*r - L^2))."""
    run = motion("kepler-planar")
    E, L = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_theta"))
    a, b = mp.mpf("1.3"), mp.mpf("2.1")
    t1, t2 = (float(run.time_at("r", float(x)).value) for x in (a, b))
    angle = run.orbit("theta", along="r", values=np.array([1.3, 2.1]))
    return max(
        off(t2 - t1, mp.quad(lambda r: 1 / mp.sqrt(2 * E + 2 / r - L**2 / r**2), [a, b])),
        off(float(angle[1] - angle[0]), mp.quad(lambda r: L / (r * mp.sqrt(2 * E * r**2 + 2 * r - L**2)), [a, b])),
    )


@result("C28", "Ex 2-7, (2-133)")
def kepler_routhian():
    """R = r'^2/2 - beta^2/(2r^2) + mu/r."""
    own = Mechanics("(dot(r)**2 + r**2*dot(theta)**2)/2", "-mu/r", ("r", "theta"))
    rate = sp.solve(own.momentum("theta") - S("beta"), S("theta_d"))[0]
    R = (own.L - S("beta") * S("theta_d")).xreplace({S("theta_d"): rate})
    return exact(R - own.of("r_d**2/2 - beta**2/(2*r**2) + mu/r"))


@result("C65", "Ex 4-2")
def brachistochrone():
    """The cycloid x = a*(1 - cos s), y = a*(s - sin s), a = 1/(4g*c^2)."""
    run = motion("brachistochrone")
    E, p = (mp.mpf(float(run.constants[n].value)) for n in ("E", "p_y"))
    a = E / (2 * p**2)
    times = np.array([0.4, 1.1, 2.2])
    state = run.at(times)
    worst = mp.zero
    for x, y in zip(state.q["x"], state.q["y"], strict=True):
        s = mp.acos(1 - mp.mpf(float(x)) / a)
        worst = max(worst, off(float(y) - 0.3, a * (mp.pi - (s - mp.sin(s)))))
    return worst


@result("C65", "Ex 4-2, end of the metric")
def brachistochrone_end():
    """The level x = 0, where the metric is singular, is reached at the finite time pi*sqrt(a/g)*sqrt(2E)."""
    run = motion("brachistochrone")
    assert run.kinds == {"x": "boundary", "y": "ignorable"}
    return off(run.boundary_times["x"].value, mp.pi)


@result("C66", "Ex 4-3")
def great_circle():
    """cos(phi - phi0) = (c/sqrt(1 - c^2))*cot(theta): a plane through the centre."""
    run = motion("sphere-geodesics")
    worst = mp.zero
    points = []
    for time in ("0.3", "1.9", "4.4"):
        state = run.at(time)
        θ, φ = (mp.mpf(float(state.q[n])) for n in ("theta", "phi"))
        points.append((mp.sin(θ) * mp.cos(φ), mp.sin(θ) * mp.sin(φ), mp.cos(θ)))
    θ, φ, θd, φd = (mp.mpf(x) for x in ("1.2", "0.3", "0.5", "0.7"))
    r = [mp.sin(θ) * mp.cos(φ), mp.sin(θ) * mp.sin(φ), mp.cos(θ)]
    v = [
        mp.cos(θ) * mp.cos(φ) * θd - mp.sin(θ) * mp.sin(φ) * φd,
        mp.cos(θ) * mp.sin(φ) * θd + mp.sin(θ) * mp.cos(φ) * φd,
        -mp.sin(θ) * θd,
    ]
    n = [r[1] * v[2] - r[2] * v[1], r[2] * v[0] - r[0] * v[2], r[0] * v[1] - r[1] * v[0]]
    for point in points:
        worst = max(worst, abs(mp.fdot(n, point)) / mp.norm(n))
    return worst


@result("C66", "Ex 4-3, conjugate points")
def great_circle_closes():
    """Every geodesic closes after the length 2*pi*r: the periods of theta and phi agree."""
    run = motion("sphere-geodesics")
    speed = mp.sqrt(mp.mpf("0.25") + (mp.sin(mp.mpf("1.2")) * mp.mpf("0.7")) ** 2)
    return max(off(run.periods[n].value, 2 * mp.pi / speed) for n in ("theta", "phi"))


@result("C67", "Ex 4-4, (5-100)")
def oscillator_motion():
    """x = x0*cos w(t - t0) + (v0/w)*sin w(t - t0)."""
    run = start("harmonic-oscillator", {"x": "0.3"}, {"x": "0.7"}, m=2, k=5)
    w, time = mp.sqrt(mp.mpf(5) / 2), mp.mpf(7)
    return off(run.at(7).q["x"], mp.mpf("0.3") * mp.cos(w * time) + mp.mpf("0.7") / w * mp.sin(w * time))


@result("C68", "P4-2, (4-98)")
def drag():
    """y' = p/m, p' = -m*g -+ c*p^2/m^2 from Hamilton's equations with Q'."""
    own = Mechanics("m/2*dot(y)**2", "m*g*y", ("y",))
    force = formula(entries.described("vertical-motion-with-drag").refusal.formulas[0].partition(": ")[2])
    table = []
    for sign in (1, -1):
        y_d = sign * S("u")  # u > 0
        newton = own.equation("y") - force.subs(S("y_d"), y_d).subs(sp.Abs(S("u")), S("u"))
        table.append(newton.subs(S("y_dd"), -S("g") - sign * S("c") * S("u") ** 2 / S("m")))
    return exact(*(x.subs(sp.Abs(S("u")), S("u")) for x in table))


@result("C69", "P4-3")
def tube_turns():
    """phi' = p_phi/(I + m*r^2*sin^2); for I = m*r^2 the greatest rate is sqrt(g/r)/(sqrt(6) - 2) = 2.22474."""
    run = motion("tube-turning-freely")
    ends = [mp.mpf(float(x.value)) for x in run.turning_points["theta"]]
    p = mp.mpf(float(run.constants["p_phi"].value))
    own = p_of("tube-turning-freely")["phi"] - formula("(I + m*r**2*sin(theta)**2)*phi_d")
    exact(own)
    greatest = max(p / (1 + mp.sin(θ) ** 2) for θ in ends)
    assert abs(greatest - mp.mpf("2.22474")) < 1e-5
    at = run.at(float(run.periods["theta"].value) / 2)
    return max(off(float(greatest), 1 / (mp.sqrt(6) - 2)), off(at.velocity["phi"], 1 / (mp.sqrt(6) - 2)))


@result("C70", "P4-4")
def turning_direction():
    """p_x = m*v0*cos(t^2), p_y = m*v0*sin(t^2), lambda = -2m*v0*t; not integrable."""
    text, names, time, v = "sin(t**2)*dot(x) - cos(t**2)*dot(y)", ("x", "y"), S("t"), S("v0")
    differs(sp.Add(*curvature([one_form(text, names)], names)))
    speed = {S("x_d"): v * sp.cos(time**2), S("y_d"): v * sp.sin(time**2)}
    λ = -2 * S("m") * v * time
    rates = [S("m") * x.diff(time) for x in speed.values()]
    return exact(formula(text).xreplace(speed), rates[0] - λ * sp.sin(time**2), rates[1] + λ * sp.cos(time**2))


@result("C71", "P4-7")
def fall_action():
    """I = m*((v0^2/2 - g*y0)t1 - v0*g*t1^2 + g^2*t1^3/3); at constant velocity 3/8: larger by g^2*t1^3/24."""
    time, t1 = S("t"), S("t1")
    own = mechanics("vertical-fall")
    path = formula("y0 + v0*t - g*t**2/2")
    even = S("y0") + (path.subs(time, t1) - S("y0")) / t1 * time
    action = [sp.integrate(sp.expand(on_shell([own.L], {"y": y})[0]), (time, 0, t1)) for y in (path, even)]
    return exact(
        action[0] - formula("m*((v0**2/2 - g*y0)*t1 - v0*g*t1**2 + g**2*t1**3/3)"),
        action[1] - action[0] - formula("m*g**2*t1**3/24"),
    )


@result("C71", "P4-7, motion")
def fall_motion():
    """y = y0 + v0*t - g*t^2/2."""
    return off(motion("vertical-fall").at(2).q["y"], mp.mpf("1.5") + mp.mpf("6.4") - mp.mpf("19.62"))


@result("C72", "P4-8")
def falling_on_a_plane():
    """x1'' = g/3, x2'' = -g/3, x3'' = -2g/3."""
    own, stated = mechanics("gravity-on-inclined-plane"), entries.described("gravity-on-inclined-plane").stated
    motion_of = sp.solve([own.equation(n) for n in own.names], [S("u_dd"), S("s_dd")])
    found = [own.rate(own.rate(own.of(stated.map[n]))).xreplace(motion_of) for n in ("x1", "x2", "x3")]
    return exact(*(a - S("g") * sp.Rational(k, 3) for a, k in zip(found, (1, -1, -2), strict=True)))


@result("C73", "P4-14, P5-4")
def projectile():
    """x = x0'*t, y = y0'*t - g*t^2/2, and y = x*tan - g*x^2/(2*v0^2*cos^2)."""
    run = start("projectile", {"x": 0, "y": 0}, {"x": "1.5", "y": "2.5"}, m=1, g="9.81")
    state, time, g = run.at("1.25"), mp.mpf("1.25"), mp.mpf("9.81")
    x, y = mp.mpf("1.5") * time, mp.mpf("2.5") * time - g * time**2 / 2
    parabola = x * mp.mpf("2.5") / mp.mpf("1.5") - g * x**2 / (2 * mp.mpf("1.5") ** 2)
    return max(off(state.q["x"], x), off(state.q["y"], y), off(state.q["y"], parabola))


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
