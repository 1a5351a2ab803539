"""The systems of the problems of Greenwood chapter 2."""

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
    levi_civita,
    mechanics,
    motion,
    off,
    plain,
    result,
    solution,
)
from tests.support.pfaff import curvature, one_form

S = sp.Symbol


@result("C33", "P2-1")
def inverted_pendulum():
    """m*l^2*theta'' + m*l*A*w^2*sin(wt)*sin(theta) - m*g*l*sin(theta) = 0; (theta, t) does not separate."""
    own = Mechanics(
        "m/2*(l**2*dot(theta)**2 - 2*l*A*omega*cos(omega*t)*dot(theta)*sin(theta) + A**2*omega**2*cos(omega*t)**2)",
        "m*g*(A*sin(omega*t) + l*cos(theta))",
        ("theta",),
    )
    H = formula("p_t + (p_theta + m*l*A*omega*cos(omega*t)*sin(theta))**2/(2*m*l**2) + m*g*l*cos(theta)")
    differs(levi_civita(H, ("theta", "p_theta"), ("t", "p_t")))
    return exact(
        own.equation("theta") - own.of("m*l**2*theta_dd + m*l*A*omega**2*sin(omega*t)*sin(theta) - m*g*l*sin(theta)")
    )


@result("C34", "P2-2")
def eccentric_disk():
    """m*(r^2 + l^2 - 2rl*cos)theta'' + m*r*l*theta'^2*sin - m*g*r*sin(alpha) + m*g*l*sin(theta + alpha) = 0."""
    own = mechanics("eccentric-disk")
    return exact(
        own.equation("theta")
        - own.of(
            "m*(r**2 + l**2 - 2*r*l*cos(theta))*theta_dd + m*r*l*theta_d**2*sin(theta)"
            " - m*g*r*sin(alpha) + m*g*l*sin(theta + alpha)"
        )
    )


@result("C35", "P2-3")
def rod_with_edge():
    """Not integrable; m*x'' = lambda*sin, m*y'' = -lambda*cos, m*l^2*theta''/12 = lambda*l/2."""
    names = ("x", "y", "theta")
    form = one_form("sin(theta)*dot(x) - cos(theta)*dot(y) + l/2*dot(theta)", names)
    differs(sp.Add(*curvature([form], names)))
    free = Mechanics("m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2", "0", names)
    book = ("m*x_dd - lam*sin(theta)", "m*y_dd + lam*cos(theta)", "m*l**2/12*theta_dd - lam*l/2")
    return exact(
        *(free.equation(n) - S("lam") * a - formula(text) for n, a, text in zip(names, form, book, strict=False))
    )


@result("C36", "P2-5")
def turntable_slot():
    """m*y'' - m*Omega^2*y + k*y = 0."""
    own = mechanics("turntable-slot")
    return exact(own.equation("y") - own.of("m*y_dd - m*Omega**2*y + k*y"))


@result("C36", "P2-5, motion")
def turntable_motion():
    """y oscillates with sqrt(k/m - Omega^2), and runs off like a hyperbolic cosine where k < m*Omega^2."""
    time, rate = mp.mpf(3), mp.sqrt(mp.mpf(1) / 2)
    out = mp.mpf("0.4") * mp.cosh(rate * time) - mp.mpf("0.2") / rate * mp.sinh(rate * time)
    libration = mp.mpf("0.4") * mp.cos(time) + mp.mpf("0.3") * mp.sin(time)
    return max(
        off(motion("turntable-slot", "thrown-out").at(3).q["y"], out),
        off(motion("turntable-slot").at(3).q["y"], libration),
    )


@result("C37", "P2-6")
def one_degree_of_freedom():
    """m*q'' + m'*q'^2/2 + V' = 0, and p = sqrt(2m(q)*(h - V))."""
    own = mechanics("one-degree-of-freedom")
    mass, q = own.of("m*(1 + b*q**2)"), S("q")
    p2 = plain(solution("one-degree-of-freedom").momentum_squared["q"])
    return exact(
        own.equation("q") - (mass * S("q_dd") + mass.diff(q) * S("q_d") ** 2 / 2 + own.V.diff(q)),
        p2 - 2 * mass * (S("E") - own.V),
    )


for row, entry in (("C38a", "helix-fixed"), ("C38b", "helix-turning")):

    @result(row, "P2-8")
    def helix_time(entry=entry):
        """The time of fall through the height H is sqrt(2H/g)/sin(alpha)."""
        height, α = mp.mpf("0.7"), mp.mpf("0.3")
        place = sp.Rational(1, 5) + sp.Float("0.7", 40) / sp.sin(sp.Float("0.3", 40))
        return off(motion(entry).time_at("s", str(sp.N(place, 35))).value, mp.sqrt(2 * height) / mp.sin(α))


@result("C39", "P2-9")
def parabola_force():
    """The greatest force of constraint is m*g*(1 + 12*y0), at the bottom; the turning points are -+sqrt(y0/3)."""
    run, g, y0 = motion("parabola"), mp.mpf("9.81"), mp.mpf(3) / 4
    v = mp.mpf(float(run.at(float(run.time_at("x", 0).value)).velocity["x"]))
    ends = run.turning_points["x"]
    return max(
        off(float(g + 6 * v**2), g * (1 + 12 * y0)),
        off(ends[1].value, mp.sqrt(y0 / 3)),
        off(ends[0].value, -mp.sqrt(y0 / 3)),
    )


@result("C39", "P2-9, equations")
def parabola_equations():
    """m*x'' = 6x*lambda, m*y'' + m*g = -lambda, with y = 3x^2."""
    own = mechanics("parabola")
    ydd = own.rate(own.rate(own.of("3*x**2")))
    λ = -(S("m") * ydd + S("m") * S("g"))
    return exact(S("m") * S("x_dd") - 6 * S("x") * λ - own.equation("x"))


@result("C40", "P2-10")
def moving_plane():
    """The plane moves at (-10, -15, -20)/29, and m*r'' + k*r is along its normal (2, 3, 4)."""
    entry = entries.described("oscillator-on-moving-plane")
    assert entry.stated is not None
    own = mechanics("oscillator-on-moving-plane")
    place = [own.of(entry.stated.map[n]) for n in "xyz"]
    exact(*(x.diff(S("t")) + sp.Rational(v, 29) for x, v in zip(place, (10, 15, 20), strict=True)))
    accelerations = sp.solve([own.equation("u"), own.equation("v")], [S("u_dd"), S("v_dd")])
    force = [S("m") * own.rate(own.rate(x)).xreplace(accelerations) + S("k") * x for x in place]
    return exact(3 * force[0] - 2 * force[1], 4 * force[0] - 2 * force[2])


@result("C41", "P2-11")
def rod_pendulum():
    """m*l^2*theta''/3 - 3*beta^2*cos/(m*l^2*sin^3) - m*g*l*sin/2 = 0."""
    own = mechanics("rod-spherical-pendulum")
    rate = sp.solve(own.momentum("phi") - S("beta"), S("phi_d"))[0]
    book = own.of("m*l**2/3*theta_dd - 3*beta**2*cos(theta)/(m*l**2*sin(theta)**3) - m*g*l/2*sin(theta)")
    return exact(own.equation("theta").xreplace({S("phi_d"): rate}) - book)


@result("C42", "P2-12")
def cone():
    """m*r'' - beta^2/(m*r^3*sin^2 alpha) + m*g*cos(alpha) = 0, m*r^2*phi'*sin^2(alpha) = beta."""
    own = mechanics("cone")
    rate = sp.solve(own.momentum("phi") - S("beta"), S("phi_d"))[0]
    book = own.of("m*r_dd - beta**2/(m*r**3*sin(alpha)**2) + m*g*cos(alpha)")
    return exact(
        own.equation("r").xreplace({S("phi_d"): rate}) - book,
        own.momentum("phi") - own.of("m*r**2*phi_d*sin(alpha)**2"),
    )


@result("C43a", "P2-13(a)")
def tube_pendulum():
    """phi'' + theta''*(1 + cos phi) + theta'^2*sin(phi) + (g/r)*sin(theta + phi) = 0."""
    own = mechanics("tube-pendulum")
    book = own.of("phi_dd + theta_dd*(1 + cos(phi)) + theta_d**2*sin(phi) + g/r*sin(theta + phi)")
    return exact(own.equation("phi") - S("m") * S("r") ** 2 * book)


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
