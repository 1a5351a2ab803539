"""Greenwood chapter 2: Lagrange's equations, Routh's function, Liouville's systems, small oscillations."""

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

from tests.support.book import (  # fmt: skip
    RESULTS,
    H_of,
    Mechanics,
    Result,
    differs,
    exact,
    formula,
    mechanics,
    motion,
    off,
    on_shell,
    result,
    start,
)
from tests.support.pfaff import curvature, one_form

S = sp.Symbol


@result("C22", "(2-218), P5-7")
def spherical_pendulum_time():
    """t - t0 = integral of m*l^2/sqrt(f), f = 2*(m*l^2*(E + m*g*l*cos theta) - p_phi^2/(2*sin^2 theta))."""
    return spherical_pendulum_quadrature(lambda θ, L: 1)


@result("C22", "(2-221), P5-7")
def spherical_pendulum_azimuth():
    """phi - phi0 = integral of p_phi/(sin^2 theta*sqrt(f))."""
    return spherical_pendulum_quadrature(lambda θ, L: L / mp.sin(θ) ** 2)


def spherical_pendulum_quadrature(rate):
    run = motion("spherical-pendulum")
    values = {p.name: mp.mpf(sp.N(p.value, 30)) for p in run.solution.system.parameters}
    M, A = values["m"] * values["l"] ** 2, values["m"] * values["g"] * values["l"]
    E, L = (mp.mpf(run.constants[n].value) for n in ("E", "p_phi"))
    low, high = (float(x.value) for x in run.turning_points["theta"])
    a, b = low + (high - low) * 0.3, low + (high - low) * 0.6
    root = lambda θ: mp.sqrt(2 * M * (E + A * mp.cos(θ)) - L**2 / mp.sin(θ) ** 2)  # noqa: E731
    expected = mp.quad(lambda θ: rate(θ, L) * (M if rate(θ, L) == 1 else 1) / root(θ), [a, b])
    first, second = _upward(run, a), _upward(run, b)
    if second < first:
        second += float(run.periods["theta"].value)
    if rate(mp.mpf(1), L) == 1:
        return off(second - first, expected)
    states = run.at(np.array([first, second]))
    return off(float(np.diff(states.unwrapped("phi"))[0]), expected)


def _upward(run, place):
    """The first time after t0 at which theta passes a place while it grows."""
    times = [float(run.time_at("theta", place, k).value) for k in range(3)]
    return min(x for x in times if float(run.at(x).p["theta"]) > 0)


@result("C22", "(2-222), (2-225)")
def spherical_pendulum_liouville():
    """2*c_phi = -2*c_theta = p_phi^2 with the book's f, R, v."""
    p, q = (
        formula("p_theta**2*sin(theta)**2/2 + m**2*g*l**3*sin(theta)**2*cos(theta) - h*m*l**2*sin(theta)**2"),
        S("p_phi"),
    )
    h = formula("(p_theta**2 + p_phi**2/sin(theta)**2)/(2*m*l**2) + m*g*l*cos(theta)")
    return exact(2 * p.xreplace({S("h"): h}) + q**2)


@result("C23a", "Ex 2-2, (2-65)")
def double_pendulum_matrix():
    """m = m*l^2*[[2, cos(phi - theta)], [cos(phi - theta), 1]]."""
    c, scale = sp.cos(S("phi") - S("theta")), S("m") * S("l") ** 2
    return exact(mechanics("double-pendulum").mass - scale * sp.Matrix([[2, c], [c, 1]]))


@result("C23a", "(2-63), (2-64)")
def double_pendulum_equations():
    """The two equations of motion."""
    own, scale = mechanics("double-pendulum"), S("m") * S("l") ** 2
    θ = own.of("2*theta_dd + phi_dd*cos(phi - theta) - phi_d**2*sin(phi - theta) + 2*g/l*sin(theta)")
    φ = own.of("phi_dd + theta_dd*cos(phi - theta) + theta_d**2*sin(phi - theta) + g/l*sin(phi)")
    return exact(own.equation("theta") - scale * θ, own.equation("phi") - scale * φ)


FREQUENCIES = {
    ("C23b", "(2-66)", "double-pendulum-small"): {"u1": "sqrt(2 - sqrt(2))", "u2": "sqrt(2 + sqrt(2))"},
    ("C43b", "P2-13(b)", "tube-pendulum-small"): {"u1": "sqrt(1/2)", "u2": "sqrt(2)"},
    ("C44", "P2-14", "springs-planar"): {"x": "sqrt(1/2)", "y": "sqrt(3/2)"},
    ("C45", "P2-15", "particles-on-elastic-rod"): {"u3": "sqrt(6)"},
    ("C32", "Ex 2-12", "pendulum-on-block-small"): {"theta": "sqrt(3/2)"},
}  # fmt: skip
for (row, place, entry), expected in FREQUENCIES.items():

    @result(row, place + ", frequencies")
    def frequencies(entry=entry, expected=expected):
        """The frequencies of the normal modes."""
        found = motion(entry).frequencies
        return max(off(found[n].value, sp.sympify(text, rational=True).evalf(30)) for n, text in expected.items())


@result("C24", "Ex 2-3")
def block_on_wedge():
    """x1'' = m2*g/(2m1 + m2), x2'' = sqrt(2)*(m1 + m2)*g/(2m1 + m2)."""
    state = motion("block-on-wedge").at(2)
    return max(
        off(state.q["x1"], mp.mpf("0.1") + mp.mpf(2) / 5), off(state.q["x2"], mp.mpf("0.2") + 2 * mp.sqrt(2) * 3 / 5)
    )


@result("C24", "Ex 2-3, constraint force")
def wedge_constraint_force():
    """C3 = sqrt(2)*m1*m2*g/(2m1 + m2) is the force on the wedge, m1*x1'' = C3/sqrt(2)."""
    m1, m2, g = (S(n) for n in ("m1", "m2", "g"))
    own = mechanics("block-on-wedge")
    a = sp.solve([own.equation("x1"), own.equation("x2")], [S("x1_dd"), S("x2_dd")])
    return exact(
        a[S("x1_dd")] - m2 * g / (2 * m1 + m2),
        a[S("x2_dd")] - sp.sqrt(2) * (m1 + m2) * g / (2 * m1 + m2),
        m1 * a[S("x1_dd")] * sp.sqrt(2) - sp.sqrt(2) * m1 * m2 * g / (2 * m1 + m2),
    )


@result("C25a", "Ex 2-4")
def whirling_tube_equation():
    """m*r^2*theta'' - m*r^2*w^2*sin*cos - m*g*r*sin = 0."""
    own = mechanics("whirling-tube")
    return exact(
        own.equation("theta") - own.of("m*r**2*theta_dd - m*r**2*w**2*sin(theta)*cos(theta) - m*g*r*sin(theta)")
    )


@result("C25a", "Ex 2-9, equilibria")
def whirling_tube_equilibria():
    """For w^2 > g/r the stable place is acos(-g/(r*w^2)), and 0 and pi are maxima; else pi is the minimum."""
    own = mechanics("whirling-tube")
    V = (own.V - own.T.subs(S("theta_d"), 0)).subs(dict.fromkeys(map(S, "mrg"), 1))
    for w2, place, sign in (
        (2, sp.acos(-sp.Rational(1, 2)), 1),
        (2, sp.pi, -1),
        (2, 0, -1),
        (sp.Rational(1, 2), sp.pi, 1),
    ):
        at = {S("theta"): place, S("w"): sp.sqrt(w2)}
        assert V.diff(S("theta")).subs(at).simplify() == 0
        assert sp.sign(V.diff(S("theta"), 2).subs(at)) == sign
    assert start("whirling-tube", {"theta": "2*pi/3"}, {"theta": 0}, w="sqrt(2)").kinds == {"theta": "equilibrium"}
    return 0


@result("C25a", "Ex 2-9, h")
def whirling_tube_jacobi():
    """h = T2 + V' with V' = V - T0."""
    own = mechanics("whirling-tube")
    return exact(own.jacobi - own.of("m*r**2/2*theta_d**2 + m*g*r*cos(theta) - m*r**2*w**2/2*sin(theta)**2"))


@result("C25b", "(2-171)-(2-179)")
def whirling_tube_in_space():
    """With phi = w*t, T + V is not constant: it differs from h by m*r^2*w^2*sin^2(theta)."""
    own = mechanics("whirling-tube")
    total = own.of("m*r**2/2*(theta_d**2 + w**2*sin(theta)**2) + m*g*r*cos(theta)")
    exact(total - own.jacobi - own.of("m*r**2*w**2*sin(theta)**2"))
    return differs(own.rate(total).subs(S("theta_dd"), sp.solve(own.equation("theta"), S("theta_dd"))[0]))


@result("C26a", "(2-92), (2-93)")
def moving_anchor_equations():
    """The equations of the sprung particle in fixed polar coordinates."""
    own = Mechanics(
        "m/2*(dot(r)**2 + r**2*dot(theta)**2) + m*a**2*w**2/2"
        " + m*a*w*(dot(r)*sin(theta - w*t) + r*dot(theta)*cos(theta - w*t))",
        "k/2*(r - r0)**2",
        ("r", "theta"),
    )
    return exact(
        own.equation("r") - own.of("m*r_dd - m*r*theta_d**2 - m*a*w**2*cos(theta - w*t) + k*(r - r0)"),
        own.equation("theta") - own.of("m*r**2*theta_dd + 2*m*r*r_d*theta_d + m*a*w**2*r*sin(theta - w*t)"),
    )


@result("C27", "Ex 2-6")
def knife_edges():
    """x = (v0/w)(cos wt - 1), y = (v0/w) sin wt, lambda = -2m*v0*w, C = lambda*(cos wt, sin wt)."""
    w, v, time = S("omega"), S("v0"), S("t")
    free = Mechanics("m*(dot(x)**2 + dot(y)**2) + m*l**2*omega**2/4", "0", ("x", "y"))
    path = {"x": v / w * (sp.cos(w * time) - 1), "y": v / w * sp.sin(w * time)}
    λ = -2 * S("m") * v * w
    x, y, c = on_shell(
        [free.equation("x"), free.equation("y"), formula("dot(x)*cos(omega*t) + dot(y)*sin(omega*t)")], path
    )
    return exact(x - λ * sp.cos(w * time), y - λ * sp.sin(w * time), c)


@result("C27", "Ex 2-10")
def knife_edges_jacobi():
    """h = m*(x'^2 + y'^2) - m*l^2*w^2/4 is constant, though the constraint is not integrable."""
    free = Mechanics("m*(dot(x)**2 + dot(y)**2) + m*l**2*omega**2/4", "0", ("x", "y"))
    differs(sp.Add(*curvature([one_form("dot(x)*cos(omega*t) + dot(y)*sin(omega*t)", ("x", "y"))], ("x", "y"))))
    return exact(free.jacobi - free.of("m*(x_d**2 + y_d**2) - m*l**2*omega**2/4"))


@result("C29", "Ex 2-8, Ex 6-5")
def moving_frame_hamiltonian():
    """H = p^2/2m - v0*p + k*q^2/2 (6-166), and h = T2 - T0 + V."""
    return exact(
        H_of("spring-in-moving-frame") - formula("p_x**2/(2*m) - v0*p_x + k*x**2/2"),
        mechanics("spring-in-moving-frame").jacobi - formula("m/2*x_d**2 - m*v0**2/2 + k*x**2/2"),
    )


@result("C29", "Ex 2-8, motion")
def moving_frame_motion():
    """x oscillates with sqrt(k/m) about 0 in the frame."""
    w, time = mp.sqrt(3), mp.mpf(5)
    return off(
        motion("spring-in-moving-frame").at(5).q["x"],
        mp.mpf("0.4") * mp.cos(w * time) + mp.mpf("0.7") / w * mp.sin(w * time),
    )


@result("C30", "(5-133)-(5-137), (2-203)", 1e-11)
def liouville_times():
    """The integrals of dq_i/sqrt(phi_i) agree (= tau), and the sum of f_i*dq_i/sqrt(phi_i) is t."""
    run = motion("liouville-three")
    end, time = run.at("0.1"), 0.1
    parts = {"q1": ("q1**2", "1", "q1**4"), "q2": ("q2**2", "2", "q2**2"), "q3": ("1", "1", "q3**2/2")}
    begin, E = run.at(0), mp.mpf(run.constants["E"].value)
    τ, total = [], mp.zero
    for n, (f, R, v) in parts.items():
        f, v = (sp.lambdify(S(n), formula(text), "mpmath") for text in (f, v))
        R, a, b, p = mp.mpf(R), mp.mpf(float(begin.q[n])), mp.mpf(float(end.q[n])), mp.mpf(float(begin.p[n]))
        α = R * p**2 / 2 + v(a) - E * f(a)
        root = lambda x, f=f, v=v, R=R, α=α: mp.sqrt(2 * R * (E * f(x) - v(x) + α))  # noqa: E731
        sign = mp.sign(p)
        τ.append(mp.quad(lambda x, root=root, sign=sign: sign / root(x), [a, b]))
        total += mp.quad(lambda x, root=root, f=f, sign=sign: sign * f(x) / root(x), [a, b])
    return max(off(τ[0], τ[1]), off(τ[2], τ[1]), off(total, time))


@result("C31", "(2-254), (2-262), (2-266)")
def small_oscillations():
    """AᵀmA and AᵀkA are diagonal, and w_k^2 = K_kk/M_kk are the roots of |k - w^2*m| = 0 (2-239)."""
    m, k, c, w2 = (S(n) for n in ("m", "k", "c", "w2"))
    A, M, K = sp.Matrix([[1, 1], [1, -1]]), sp.diag(m, m), sp.Matrix([[k + c, -c], [-c, k + c]])
    M2, K2 = A.T * M * A, A.T * K * A
    roots = (K - w2 * M).det()
    return exact(M2[0, 1], K2[0, 1], *(roots.subs(w2, K2[i, i] / M2[i, i]) for i in (0, 1)))


@result("C31", "(2-272)-(2-275)")
def small_oscillations_start():
    """The amplitudes from the initial conditions: x_i = sum of A_ik*(C_k cos w_k*t + D_k sin w_k*t)."""
    state, time = motion("small-oscillations").at(3), mp.mpf(3)
    w = [mp.sqrt(1), mp.sqrt(2)]
    u = [
        mp.mpf("0.3") * mp.cos(w[0] * time) + mp.mpf("0.1") / w[0] * mp.sin(w[0] * time),
        mp.mpf("0.2") * mp.cos(w[1] * time) + mp.mpf("0.4") / w[1] * mp.sin(w[1] * time),
    ]
    return max(off(state.q["u1"], u[0]), off(state.q["u2"], u[1]))


@result("C32", "Ex 2-12, motion")
def pendulum_on_block():
    """x = t + (l/30)(1 - cos w2*t), theta = cos(w2*t)/10."""
    state, time, w = motion("pendulum-on-block-small").at(4), mp.mpf(4), mp.sqrt(mp.mpf(3) / 2)
    return max(off(state.q["x"], time + (1 - mp.cos(w * time)) / 30), off(state.q["theta"], mp.cos(w * time) / 10))


@result("C32", "Ex 2-12, modes")
def pendulum_on_block_modes():
    """A = [[1, 1], [0, -3/l]]: M = m*diag(3, 6), K = m*g*l*diag(0, 9/l^2)."""
    own, l = mechanics("pendulum-on-block-small"), S("l")
    A, q = sp.Matrix([[1, 1], [0, -3 / l]]), [S("x"), S("theta")]
    return exact(
        A.T * own.mass * A - S("m") * sp.diag(3, 6),
        A.T * sp.hessian(own.V, q) * A - S("m") * S("g") * l * sp.diag(0, 9 / l**2),
    )


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
