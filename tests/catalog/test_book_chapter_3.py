"""Greenwood chapter 3: impulses, dissipation, the top, gyroscopic systems, charges."""

import pytest
import sympy as sp
from mpmath import mp

from tests.support.book import (  # fmt: skip
    RESULTS,
    H_of,
    Mechanics,
    Result,
    exact,
    formula,
    mechanics,
    motion,
    off,
    p_of,
    result,
    start,
)
from tests.support.pfaff import curvature, one_form

S = sp.Symbol


def after_impulse(mass: sp.Matrix, before: sp.Matrix, impulse: sp.Matrix) -> sp.Matrix:
    """q' + m^-1 Q (3-24)-(3-29)."""
    return before + mass.inv() * impulse


@result("C46", "(3-5), (3-12)")
def damped_energy():
    """dE/dt = -2F, and |lambda^2*m + lambda*c + k| = 0 for q = A*exp(lambda*t)."""
    own = Mechanics(
        "m11/2*dot(x)**2 + m12*dot(x)*dot(y) + m22/2*dot(y)**2", "k11/2*x**2 + k12*x*y + k22/2*y**2", ("x", "y")
    )
    F = own.of("c11/2*x_d**2 + c12*x_d*y_d + c22/2*y_d**2")
    motion_of = sp.solve([own.equation(n) + F.diff(S(f"{n}_d")) for n in "xy"], [S("x_dd"), S("y_dd")])
    λ, q, names = S("lam"), [S("x"), S("y")], ("x", "y")
    matrix = λ**2 * own.mass + λ * sp.hessian(F, [S("x_d"), S("y_d")]) + sp.hessian(own.V, q)
    put = {S(n + "_d"): λ * S(n) for n in names} | {S(n + "_dd"): λ**2 * S(n) for n in names}
    linear = sp.Matrix([(own.equation(n) + F.diff(S(f"{n}_d"))).xreplace(put) for n in names])
    return exact(own.rate(own.jacobi).xreplace(motion_of) + 2 * F, linear - matrix * sp.Matrix(q))


SQUARE = sp.diag(4, sp.Rational(2, 3)) * S("m")


@result("C47", "Ex 3-1")
def rhombus_impulse():
    """The corner starts with (5/8m)*F; T at the square is 2m*q1'^2 + m*q2'^2/3."""
    velocity = after_impulse(SQUARE, sp.zeros(2, 1), sp.Matrix([1, sp.Rational(1, 2)]) * S("F"))
    shape = (
        mechanics("rhombus")
        .T.subs({S("beta_d"): -S("q2_d") / (2 * S("l") * sp.sin(S("beta")))})
        .subs(S("beta"), sp.pi / 4)
    )
    return exact(
        velocity[0] + velocity[1] / 2 - sp.Rational(5, 8) * S("F") / S("m"),
        shape - S("m") * (2 * S("q1_d") ** 2 + S("q2_d") ** 2 / 3),
    )


@result("C47", "Ex 3-1, floor")
def rhombus_floor():
    """Inelastic: q1' = -3/5*v0, q2' = -6/5*v0, F = 8/5*m*v0, energy lost 4/5*m*v0^2."""
    v, m, F = S("v0"), S("m"), S("F")
    before = sp.Matrix([-v, 0])
    velocity = after_impulse(SQUARE, before, sp.Matrix([1, -sp.Rational(1, 2)]) * F)
    force = sp.solve(velocity[0] - velocity[1] / 2, F)[0]
    after = velocity.subs(F, force)
    lost = ((before.T * SQUARE * before)[0] - (after.T * SQUARE * after)[0]) / 2
    return exact(
        force - sp.Rational(8, 5) * m * v,
        after - sp.Matrix([-sp.Rational(3, 5), -sp.Rational(6, 5)]) * v,
        lost - sp.Rational(4, 5) * m * v**2,
    )


@result("C48", "Ex 3-2, P3-2")
def bar_struck():
    """Slide: (5/4, -1/4), theta' = -3/4, impulse 5/(2*sqrt(2)); stick: (3/4, -3/4), -3/4."""
    n, r, J = sp.Matrix([1, -1]) / sp.sqrt(2), sp.sqrt(2), S("J")
    particle, bar = sp.Matrix([0, 1]) + J * n, -1 + J * r / 10
    across = sp.Matrix([-1, 1]) / sp.sqrt(2)
    impulse = sp.solve(across.dot(particle) - r * bar, J)[0]
    stuck = sp.Rational(-9, 12)
    return exact(
        impulse - 5 / (2 * sp.sqrt(2)),
        particle.subs(J, impulse) - sp.Matrix([5, -1]) / 4,
        bar.subs(J, impulse) + sp.Rational(3, 4),
        stuck * r * across - sp.Matrix([3, -3]) / 4,
    )


@result("C48", "Ex 3-2, the slide")
def bar_slide():
    """Angular momentum -9 and the energy are kept while the particle slides outward."""
    run = motion("slider-on-pivoted-bar")
    state = run.at(3)
    r, rd, w = (mp.mpf(float(x)) for x in (state.q["r"], state.velocity["r"], state.velocity["theta"]))
    energy = (mp.mpf(25 + 1) / 16 + 10 * mp.mpf(9) / 16) / 2
    return max(off(float((10 + r**2) * w), -9), off(float((rd**2 + (10 + r**2) * w**2) / 2), energy))


@result("C49", "Ex 3-3")
def ellipsoid():
    """x' = b*wy, y' = -b*wx for the impulse response, and the rolling constraints are not integrable."""
    wx, wy = formula("1/(I_a + m*b**2)"), formula("1/(I_t + m*b**2)")
    names = ("x", "y", "psi", "theta", "phi")
    forms = [
        one_form(x, names)
        for x in (
            "dot(x) - b*(dot(theta)*sin(psi) - dot(phi)*sin(theta)*cos(psi))",
            "dot(y) + b*(dot(theta)*cos(psi) + dot(phi)*sin(theta)*sin(psi))",
        )
    ]
    assert any(c != 0 for c in curvature(forms, names))
    contact = [S("m") * S("b") * wy * S("b") + S("I_t") * wy - 1, S("m") * S("b") * wx * S("b") + S("I_a") * wx - 1]
    return exact(*contact)


@result("C50", "(3-68)")
def euler_rates():
    """wx = phi' - psi'*sin, wy = theta'*cos + psi'*cos*sin, wz: none is integrable by itself, and T is theirs."""
    rates = (
        "dot(phi) - dot(psi)*sin(theta)",
        "dot(theta)*cos(phi) + dot(psi)*cos(theta)*sin(phi)",
        "dot(psi)*cos(theta)*cos(phi) - dot(theta)*sin(phi)",
    )
    names = ("psi", "theta", "phi")
    for rate in rates:
        assert any(c != 0 for c in curvature([one_form(rate, names)], names))
    T = sp.Add(*(S(n) * formula(rate) ** 2 / 2 for n, rate in zip(("Ix", "Iy", "Iz"), rates, strict=True)))
    return exact(mechanics("asymmetric-body").T - T)


@result("C52", "P4-1")
def top_hamiltonian():
    """H of the top: p_theta^2/2I_t + (p_psi + p_phi*sin)^2/(2I_t*cos^2) + p_phi^2/2I_a + m*g*l*sin."""
    return exact(
        H_of("lagrange-top")
        - formula(
            "p_theta**2/(2*I_t) + (p_psi + p_phi*sin(theta))**2/(2*I_t*cos(theta)**2)"
            " + p_phi**2/(2*I_a) + m*g*l*sin(theta)"
        )
    )


@result("C52", "(3-169)")
def top_nutation_rate():
    """theta'^2 = 2h/I_t - ((p_psi + p_phi*sin)/(I_t*cos))^2 - 2m*g*l*sin/I_t, h without the spin energy."""
    run = motion("lagrange-top")
    a, b, E = (mp.mpf(float(run.constants[n].value)) for n in ("p_psi", "p_phi", "E"))
    state, worst = run.at("0.9"), mp.zero
    θ = mp.mpf(float(state.q["theta"]))
    rate = 2 * (E - b**2) - ((a + b * mp.sin(θ)) / mp.cos(θ)) ** 2 - 2 * mp.sin(θ)
    return max(worst, off(float(state.velocity["theta"]) ** 2, rate))


@result("C52", "(3-160), (3-171), nutation")
def top_steady():
    """Steady precession at theta0 = 0: small nutation with sqrt(p_psi^2 + p_phi^2)/I_t."""
    run = start(
        "lagrange-top",
        {"psi": 0, "theta": 0, "phi": 0},
        {"psi": "-1/2", "theta": 0, "phi": 4},
        I_a="1/2",
        I_t=1,
        m=1,
        g=1,
        l=1,
    )
    assert run.kinds["theta"] == "equilibrium"
    return off(run.frequencies["theta"].value, mp.sqrt(17) / 2)


@result("C52", "(3-144), steady precession")
def top_precession():
    """psi' = -(p_phi/(2I_t*sin))*(1 -+ sqrt(1 - 4I_t*m*g*l*sin/p_phi^2)) keeps the elevation, exactly."""
    own, θ, b = (
        formula("(p_psi + p_phi*sin(theta))**2/(2*I_t*cos(theta)**2) + m*g*l*sin(theta)"),
        S("theta"),
        S("p_phi"),
    )
    slope = own.diff(θ)
    residuals = []
    for sign in (1, -1):
        rate = -b / (2 * S("I_t") * sp.sin(θ)) * (1 + sign * sp.sqrt(1 - 4 * formula("I_t*m*g*l*sin(theta)") / b**2))
        residuals.append(slope.subs(S("p_psi"), S("I_t") * sp.cos(θ) ** 2 * rate - b * sp.sin(θ)))
    return exact(*residuals)


@result("C52", "P5-2")
def top_quadratures():
    """t - t0 = integral of I_t/sqrt(f); psi - psi0 = integral of (p_psi + p_phi*sin)/(cos^2*sqrt(f))."""
    run = motion("lagrange-top")
    a, b, E = (mp.mpf(float(run.constants[n].value)) for n in ("p_psi", "p_phi", "E"))
    f = lambda θ: 2 * (E - b**2) - ((a + b * mp.sin(θ)) / mp.cos(θ)) ** 2 - 2 * mp.sin(θ)  # noqa: E731
    t1, t2 = sorted(float(run.time_at("theta", x, 1).value) for x in (0.0, 0.1))
    first, second = run.at(t1), run.at(t2)
    ends = [float(first.q["theta"]), float(second.q["theta"])]
    sign = 1 if ends[1] > ends[0] else -1
    time = sign * mp.quad(lambda θ: 1 / mp.sqrt(f(θ)), ends)
    turn = sign * mp.quad(lambda θ: (a + b * mp.sin(θ)) / (mp.cos(θ) ** 2 * mp.sqrt(f(θ))), ends)
    return max(off(t2 - t1, time), off(float(second.unwrapped("psi")) - float(first.unwrapped("psi")), turn))


@result("C53", "(3-188), (4-138)")
def charge_momentum():
    """p = m*v + e*A, and H = (p - eA)^2/2m + e*phi = T + e*phi."""
    A = {"x": "-B*y/2", "y": "B*x/2", "z": "0"}
    own = p_of("crossed-fields-symmetric-gauge")
    H = sp.Add(*((S(f"p_{n}") - S("e") * formula(A[n])) ** 2 for n in "xyz")) / (2 * S("m")) - formula("e*F*y")
    return exact(
        *(own[n] - S("m") * S(f"{n}_d") - S("e") * formula(A[n]) for n in "xyz"),
        H - H_of("crossed-fields-symmetric-gauge"),
    )


@result("C55", "Ex 3-6")
def crossed_fields():
    """x = (E/B)t - (mE/eB^2)sin(eBt/m), y = (mE/eB^2)(1 - cos(eBt/m)): cusps 2*pi*mE/(eB^2) apart."""
    run, F, time = motion("crossed-fields", "cycloid"), mp.mpf(1) / 2, mp.mpf(4)
    state, cusp = run.at(4), run.at(str(mp.nstr(2 * mp.pi, 40)))
    return max(
        off(state.q["x"], F * (time - mp.sin(time))),
        off(state.q["y"], F * (1 - mp.cos(time))),
        off(cusp.q["x"], 2 * mp.pi * F),
    )


@result("C56", "P3-1")
def pinned_rods():
    """x' = (7/2, -1, 1/2)*F1/m, and T = F1*x1'/2."""
    own = mechanics("pinned-rods")
    velocity = after_impulse(own.mass, sp.zeros(3, 1), sp.Matrix([S("F1"), 0, 0]))
    book = sp.Matrix([sp.Rational(7, 2), -1, sp.Rational(1, 2)]) * S("F1") / S("m")
    energy = (velocity.T * own.mass * velocity)[0] / 2
    return exact(velocity - book, energy - S("F1") * velocity[0] / 2)


@result("C57", "P3-3")
def rod_hits_wall():
    """x' = 4/5*v0, y' = v0/5, theta' = 6v0/(5l), impulse sqrt(2)/5*m*v0."""
    v, m, l, C = (S(n) for n in ("v0", "m", "l", "C"))
    n = sp.Matrix([-1, 1]) / sp.sqrt(2)
    centre, spin = sp.Matrix([v, 0]) + C / m * n, C * (l / 2) * n[1] / (m * l**2 / 12)
    end = centre + spin * l / 2 * sp.Matrix([0, 1])
    impulse = sp.solve(end.dot(n), C)[0]
    return exact(
        impulse - sp.sqrt(2) / 5 * m * v,
        centre.subs(C, impulse) - sp.Matrix([4, 1]) * v / 5,
        spin.subs(C, impulse) - 6 * v / (5 * l),
    )


@result("C57", "P3-3, the slide")
def rod_along_wall():
    """After the impact (v0 = 1) the centre keeps its velocity 1/sqrt(2) along the wall, and the energy its
    value 2/5."""
    run = motion("rod-with-sliding-end", "along-the-wall")
    begin, state, time = run.at(0), run.at(2), mp.mpf(2)
    centre = [mp.mpf(float(s.q["x"])) + mp.cos(mp.mpf(float(s.q["theta"]))) / 2 for s in (begin, state)]
    energy = mp.mpf(17) / 50 + mp.mpf(36) / 25 / 24
    return max(off(float(centre[1]), centre[0] + time / mp.sqrt(2)), off(run.constants["E"].value, energy))


@result("C58", "P3-4, P3-5")
def wall_starts():
    """theta'(0+) = 3v0/(2*sqrt(2)*l), x' = 5/8*v0, y' = 3/8*v0, impulse 5/8*m*v0; p_theta = m*l^2*theta'/3 -
    m*v0*l*sin/2."""
    own, v, l = mechanics("rod-against-moving-wall"), S("v0"), S("l")
    p = p_of("rod-against-moving-wall")["theta"]
    angle = {S("theta"): sp.pi / 4}
    rate = sp.solve(own.momentum("theta").subs(angle), S("theta_d"))[0]
    x, y = v - l / 2 * rate * sp.sin(sp.pi / 4), l / 2 * rate * sp.cos(sp.pi / 4)
    return exact(
        p - formula("m*l**2*theta_d/3 - m*v0*l*sin(theta)/2"),
        rate - 3 * v / (2 * sp.sqrt(2) * l),
        x - sp.Rational(5, 8) * v,
        y - sp.Rational(3, 8) * v,
    )


@result("C59", "P3-6")
def body_fixed():
    """wz = m*y0*v0/(I + m*(x0^2 + y0^2)) with v = (m*y0^2, -m*x0*y0)*v0/(...), from the angular momentum about
    the point."""
    w, x0, y0, v0, m, I = (S(n) for n in ("w", "x0", "y0", "v0", "m", "I"))
    rate = sp.solve(I * w + m * (x0**2 + y0**2) * w - m * y0 * v0, w)[0]
    below = I + m * (x0**2 + y0**2)
    v = (rate * y0, -rate * x0)
    return exact(v[0] - m * y0**2 * v0 / below, v[1] + m * x0 * y0 * v0 / below)


@result("C60", "P3-8")
def pendulum_on_disk():
    """T1 as printed, and gamma12 = -2m*l^2*Omega*sin(q2 - q1) (2-40)."""
    own = mechanics("double-pendulum-on-disk")
    rest = {S("q1_d"): 0, S("q2_d"): 0}
    a = [own.T.diff(S(f"{n}_d")).subs(rest) for n in own.names]
    book = own.of("m*l**2*Omega*(2*q1_d*(1 + cos(q1)) + (q1_d + q2_d)*cos(q2 - q1) + q2_d*(1 + cos(q2)))")
    γ = a[0].diff(S("q2")) - a[1].diff(S("q1"))
    return exact(
        sp.Add(*(x * S(f"{n}_d") for x, n in zip(a, own.names, strict=True))) - book,
        γ - own.of("-2*m*l**2*Omega*sin(q2 - q1)"),
    )


@result("C60", "P3-8, geometry")
def pendulum_on_disk_geometry():
    """T is that of two particles on rods hinged at the distance l from the axis of the disk."""
    own = mechanics("double-pendulum-on-disk")
    x, y = own.of("l*(1 + cos(q1))"), own.of("l*sin(q1)")
    places = [(x, y), (x + own.of("l*cos(q2)"), y + own.of("l*sin(q2)"))]
    w = S("Omega")
    T = sp.Add(*(S("m") / 2 * ((own.rate(a) - w * b) ** 2 + (own.rate(b) + w * a) ** 2) for a, b in places))
    return exact(T - own.T)


@result("C61", "P3-9")
def top_in_turning_frame():
    """H' = H of the top - w0*p_psi."""
    return exact(H_of("lagrange-top-turning-frame") - H_of("lagrange-top") + S("w0") * S("p_psi"))


@result("C61", "P3-9, motion")
def top_in_turning_frame_motion():
    """Nutation is the same, and the precession slower by w0."""
    turning = motion("lagrange-top-turning-frame")
    q, v = {"psi": "0.2", "theta": "0.3", "phi": "0.1"}, {"psi": "0.4", "theta": "0.1", "phi": "5"}
    own = start("lagrange-top", q, v, I_a="1/2", I_t=1, m=1, g=1, l=1)
    return max(
        off(turning.frequencies["theta"].value, own.frequencies["theta"].value),
        off(turning.frequencies["psi"].value, mp.mpf(own.frequencies["psi"].value) - mp.mpf("0.3")),
    )


@result("C63", "P3-12")
def two_masses_damper():
    """(m*lam^2 + k)*(m*lam^2 + 2c*lam + 3k) = 0; with m = k = 1, c = 1: the mode x1 + x2 is not damped."""
    λ, m, c, k = (S(n) for n in ("lam", "m", "c", "k"))
    matrix = λ**2 * m * sp.eye(2) + λ * c * sp.Matrix([[1, -1], [-1, 1]]) + k * sp.Matrix([[2, -1], [-1, 2]])
    return exact(
        matrix.det() - (m * λ**2 + k) * (m * λ**2 + 2 * c * λ + 3 * k),
        matrix * sp.Matrix([1, 1]) - (m * λ**2 + k) * sp.Matrix([1, 1]),
    )


@result("C63", "P3-12, gamma = 1", 2e-4)
def two_masses_gyroscopic():
    """With gamma = 1 and units 1: lam = -0.07579 +- 0.8668i, -0.9242 +- 1.763i."""
    λ = S("lam")
    matrix = λ**2 * sp.eye(2) + λ * sp.Matrix([[1, 0], [-2, 1]]) + sp.Matrix([[2, -1], [-1, 2]])
    roots = [complex(r) for r in sp.Poly(matrix.det(), λ).nroots(n=20)]
    book = [complex(-0.07579, 0.8668), complex(-0.9242, 1.763)]
    return max(min(abs(r - b) for r in roots) / abs(b) for b in book)


@result("C64", "P3-13")
def charge_radial():
    """m*r'' - m*r*theta'^2 - E0*e/r - B0*e*r*theta' = 0, m*r^2*theta' + B0*e*r^2/2 = const, m*z' = const."""
    own = mechanics("charge-in-radial-field")
    return exact(
        own.equation("r") - own.of("m*r_dd - m*r*theta_d**2 - F*e/r - B*e*r*theta_d"),
        own.momentum("theta") - own.of("m*r**2*theta_d + B*e*r**2/2"),
        own.momentum("z") - own.of("m*z_d"),
    )


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
