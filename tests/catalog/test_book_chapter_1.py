"""Greenwood chapter 1: every result that a computer can check."""

import pytest
import sympy as sp

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
    on_shell,
    p_of,
    result,
    start,
)
from tests.support.pfaff import curvature, one_form, reachable

S = sp.Symbol


def geometry(kinetic: str, positions: dict[str, str], names: tuple[str, ...]) -> sp.Expr:
    """T of Cartesian velocities, x(q, t) put in."""
    frame = Mechanics("0", "0", names)
    rates = {S(f"{x}_d"): frame.rate(formula(text, names)) for x, text in positions.items()}
    return formula(kinetic, tuple(positions)).xreplace(rates)


def jacobian(new: tuple[str, ...], old: tuple[str, ...]) -> sp.Expr:
    return sp.Matrix([formula(x, old) for x in new]).jacobian([S(q) for q in old]).det()


@result("C01", "Ex 1-1")
def circle_jacobian():
    """d(x1, x2)/d(q1, q2) = -q2, singular at the centre."""
    return exact(jacobian(("q2*cos(q1)", "q2*sin(q1)"), ("q1", "q2")) + S("q2"))


@result("C02", "Fig. 1-2")
def dumbbell_jacobian():
    """d(x1, y1, x2, y2)/d(x, y, theta, l) = -l up to the orientation of the list."""
    new = ("x - l*cos(theta)/2", "y - l*sin(theta)/2", "x + l*cos(theta)/2", "y + l*sin(theta)/2")
    return exact(jacobian(new, ("x", "y", "theta", "l")) ** 2 - S("l") ** 2)


@result("C02", "P1-3")
def dumbbell_inverse():
    """theta = atan((y2 - y1)/(x2 - x1)), and T = m*v^2 + m*l^2*theta'^2/4 from the two particles."""
    x = {"x1": "x - l*cos(theta)/2", "y1": "y - l*sin(theta)/2", "x2": "x + l*cos(theta)/2", "y2": "y + l*sin(theta)/2"}
    own = geometry("m/2*(dot(x1)**2 + dot(y1)**2 + dot(x2)**2 + dot(y2)**2)", x, ("x", "y", "theta"))
    slope = (formula(x["y2"]) - formula(x["y1"])) / (formula(x["x2"]) - formula(x["x1"]))
    return exact(own - mechanics("dumbbell-in-plane").T, slope - sp.tan(S("theta")))


@result("C03", "(1-17), (1-20)")
def skate_is_nonholonomic():
    """The constraint x'*cos(theta) + y'*sin(theta) = 0 is not integrable."""
    names = ("x", "y", "theta")
    return max(map(differs, [sp.Add(*curvature([one_form("dot(x)*cos(theta) + dot(y)*sin(theta)", names)], names))]))


@result("C03", "P4-11")
def skate_motion():
    """x = (v0/w0)(cos w0*t - 1), y = (v0/w0) sin w0*t, theta = w0*t solve the equations with a multiplier."""
    w, v, time = S("w0"), S("v0"), S("t")
    path = {"x": v / w * (sp.cos(w * time) - 1), "y": v / w * sp.sin(w * time), "theta": w * time}
    free = Mechanics("m/2*(dot(x)**2 + dot(y)**2) + I/2*dot(theta)**2", "0", ("x", "y", "theta"))
    x, y, θ = on_shell([free.equation(n) for n in free.names], path)
    λ = -S("m") * v * w
    constraint = on_shell([formula("dot(x)*cos(theta) + dot(y)*sin(theta)", free.names)], path)[0]
    return exact(x - λ * sp.cos(w * time), y - λ * sp.sin(w * time), θ, constraint)


@result("C04", "Ex 1-2, (1-22), (1-23)")
def rolling_disk():
    """Two constraints that are not integrable: 4 coordinates, 2 freedoms, the whole space accessible."""
    names = ("x", "y", "phi", "alpha")
    texts = ("dot(x) - r*sin(alpha)*dot(phi)", "dot(y) - r*cos(alpha)*dot(phi)")
    forms = [one_form(text, names) for text in texts]
    assert reachable(forms, names) == 4
    assert len(names) - sp.Matrix(forms)[:, :-1].rank() == 2
    assert any(x != 0 for x in curvature(forms, names))
    return 0


@result("C06", "Fig. 1-5")
def ladder_equilibrium():
    """Equilibrium under F2 = -m*g*cot(theta)."""
    own = mechanics("ladder")
    return exact(own.V.diff(S("theta")).subs(S("F2"), -S("m") * S("g") * sp.cot(S("theta"))))


@result("C06", "Fig. 1-5, motion")
def ladder_rests():
    """Let go at 45 degrees with F2 = -m*g it stays."""
    held = start("ladder", {"theta": "pi/4"}, {"theta": 0}, F2=-1)
    assert held.kinds == {"theta": "equilibrium"}
    return off(held.at(7).q["theta"], sp.pi.evalf(30) / 4)


@result("C07", "Fig. 1-6")
def cube_in_corner():
    """R1 = R2 = m*g/sqrt(2), and the virtual work of an allowed displacement is -(R1*dx1 + R2*dx2) <= 0."""
    V = formula("m*g/sqrt(2)*(x1 + x2)")
    return exact(*(V.diff(S(x)) - S("m") * S("g") / sp.sqrt(2) for x in ("x1", "x2")))


VARYING = Mechanics(
    "m/2*(omega**2*b**2*sin(omega*t)**2 + (a + b*cos(omega*t))**2*(dot(theta)**2 + sin(theta)**2*dot(phi)**2))",
    "m*g*(a + b*cos(omega*t))*cos(theta)",
    ("theta", "phi"),
)


@result("C08", "Ex 1-3, (1-69)")
def varying_length_equations():
    """r*theta'' + 2r'*theta' - r*phi'^2*sin*cos = g*sin(theta), and the equation of phi."""
    r, rd = formula("a + b*cos(omega*t)"), formula("-b*omega*sin(omega*t)")
    θ = VARYING.of("r*theta_dd + 2*rd*theta_d - r*phi_d**2*sin(theta)*cos(theta) - g*sin(theta)")
    φ = VARYING.of("(r*phi_dd + 2*rd*phi_d)*sin(theta) + 2*r*theta_d*phi_d*cos(theta)")
    put = {S("r"): r, S("rd"): rd}
    scale = S("m") * r
    return exact(
        VARYING.equation("theta") - scale * θ.xreplace(put),
        VARYING.equation("phi") - scale * sp.sin(S("theta")) * φ.xreplace(put),
    )


@result("C08", "(theta, t) of Ex 1-3")
def varying_length_is_not_separable():
    """Levi-Civita's condition fails for the pair (theta, t)."""
    H = formula(
        "p_t + (p_theta**2 + p_phi**2/sin(theta)**2)/(2*m*(a + b*cos(omega*t))**2)"
        " + m*g*(a + b*cos(omega*t))*cos(theta)"
    )
    return differs(levi_civita(H, ("theta", "p_theta"), ("t", "p_t")))


@result("C09", "Ex 1-5, (1-141)")
def jointed_rods_momenta():
    """p = (3m*q1', 2m*q2', 3/2*m*q3')."""
    own, m = p_of("rods-jointed-forced"), S("m")
    return exact(own["q1"] - 3 * m * S("q1_d"), own["q2"] - 2 * m * S("q2_d"), own["q3"] - 3 * m * S("q3_d") / 2)


@result("C09", "Ex 1-4, (1-76)")
def jointed_rods_map():
    """x = (q1 + q2 + q3/2, q1 - q3, q1 - q2 + q3/2) has the Jacobian -3 and gives T of (1-141)."""
    x = {"x1": "q1 + q2 + q3/2", "x2": "q1 - q3", "x3": "q1 - q2 + q3/2"}
    own = geometry("m/2*(dot(x1)**2 + dot(x2)**2 + dot(x3)**2)", x, ("q1", "q2", "q3"))
    return exact(own - mechanics("rods-jointed-forced").T, jacobian(tuple(x.values()), ("q1", "q2", "q3")) + 3)


@result("C09", "(1-78)")
def jointed_rods_motion():
    """Each coordinate accelerates with Q_i/m_i: Q1 = F, Q2 = 3F/4 - M/l, Q3 = F/8 + 3M/(2l)."""
    state, F, M, time = motion("rods-jointed-forced").at(2.5), 1.0, 0.5, 2.5
    rates = {"q1": F / 3, "q2": (0.75 * F - M) / 2, "q3": (F / 8 + 1.5 * M) / 1.5}
    begin = {"q1": 0.1, "q2": -0.2, "q3": 0.3}
    return max(off(state.q[n], begin[n] + rates[n] * time**2 / 2) for n in rates)


@result("C10", "Sec. 1-4")
def free_particle_momenta():
    """p_r = m*r', p_theta = m*r^2*theta', p_phi = m*r^2*phi'*sin(theta)^2."""
    own = p_of("free-particle-spherical")
    book = {"r": "m*r_d", "theta": "m*r**2*theta_d", "phi": "m*r**2*sin(theta)**2*phi_d"}
    return exact(*(own[n] - formula(text) for n, text in book.items()))


@result("C10", "Sec. 1-4, motion")
def free_particle_distance():
    """In spherical coordinates r^2 = (r0 + r0'*t)^2 + (v_perp*t)^2: a straight line."""
    state, time = motion("free-particle-spherical").at(3), 3
    across = sp.Rational(3, 10) ** 2 + (sp.Rational(4, 10) * sp.sin(sp.Rational(12, 10))) ** 2
    return off(state.q["r"], sp.sqrt((1 + sp.Rational(2, 10) * time) ** 2 + across * time**2).evalf(30))


@result("C11", "P1-1")
def driven_pendulum():
    """x = A*sin(w*t) + l*sin(theta), y = -l*cos(theta) lie on the moving circle and give T."""
    x = {"x": "A*sin(omega*t) + l*sin(theta)", "y": "-l*cos(theta)"}
    own = geometry("m/2*(dot(x)**2 + dot(y)**2)", x, ("theta",))
    book = formula(
        "m/2*(l**2*theta_d**2 + 2*A*omega*l*theta_d*cos(omega*t)*cos(theta) + A**2*omega**2*cos(omega*t)**2)"
    )
    circle = (formula(x["x"]) - formula("A*sin(omega*t)")) ** 2 + formula(x["y"]) ** 2 - S("l") ** 2
    return exact(own - book, circle)


@result("C11", "P1-1, (theta, t)")
def driven_pendulum_is_not_separable():
    """Levi-Civita's condition fails for (theta, t)."""
    H = formula(
        "p_t + (p_theta - m*A*omega*l*cos(omega*t)*cos(theta))**2/(2*m*l**2) - m*A**2*omega**2*cos(omega*t)**2/2"
        " - m*g*l*cos(theta)"
    )
    return differs(levi_civita(H, ("theta", "p_theta"), ("t", "p_t")))


@result("C12", "P1-2")
def rod_generalized_forces():
    """x1 = z - l*theta/2, x2 = z + l*theta/2: Q_z = F1 + F2, Q_theta = l*(F2 - F1)/2."""
    work = formula("F1*(z - l*theta/2) + F2*(z + l*theta/2)")
    return exact(mechanics("rod-end-forces").V + work)


@result("C13", "P1-4")
def turning_wire_energy():
    """T of the bead from its place in the plane, and p_theta = m*r^2*(w*(1 - cos theta) + theta')."""
    x = {"x": "r*cos(w*t) - r*cos(w*t + theta)", "y": "r*sin(w*t) - r*sin(w*t + theta)"}
    own = mechanics("bead-on-turning-wire")
    book = formula("m*r**2*(w*(1 - cos(theta)) + theta_d)")
    return exact(
        geometry("m/2*(dot(x)**2 + dot(y)**2)", x, ("theta",)) - own.T, p_of("bead-on-turning-wire")["theta"] - book
    )


@result("C13", "P1-4, equation")
def turning_wire_equation():
    """theta'' = w^2*sin(theta): the linear term of T has no effect."""
    own = mechanics("bead-on-turning-wire")
    return exact(own.equation("theta") - formula("m*r**2*(theta_dd - w**2*sin(theta))"))


@result("C14", "P1-5")
def sliding_rod():
    """T of the rod with coefficients 1/6 and 1/2, and p_theta = m*l^2*theta'/3 - m*l*x'*sin(theta)/2."""
    s = S("s")
    x = {"X": "x + s*l*cos(theta)", "Y": "s*l*sin(theta)"}
    T = sp.integrate(sp.expand(geometry("m/2*(dot(X)**2 + dot(Y)**2)", x, ("x", "theta"))), (s, 0, 1))
    own = mechanics("rod-with-sliding-end")
    return exact(T - own.T, p_of("rod-with-sliding-end")["theta"] - formula("m*l**2*theta_d/3 - m*l*x_d*sin(theta)/2"))


@result("C14", "P1-5, motion")
def sliding_rod_centre():
    """x + l*cos(theta)/2 grows evenly at the rate beta/m."""
    run = motion("rod-with-sliding-end")
    state, begin, time = run.at(4.5), run.at(0), 4.5
    centre = [float(s.q["x"]) + sp.cos(sp.Float(float(s.q["theta"]), 30)) / 2 for s in (begin, state)]
    return off(float(centre[1]), centre[0] + float(run.constants["p_x"].value) * time)


@result("C15", "P1-6")
def disk_on_rod():
    """T = 3/4*m*q'^2 - 3/2*m*r*w*q' + m*w^2*q^2/2 + 3/4*m*r^2*w^2 from rolling, and q'' = 2/3*w^2*q."""
    x = {"x": "q*cos(w*t) - r*sin(w*t)", "y": "q*sin(w*t) + r*cos(w*t)"}
    spin = formula("m*r**2/4*(w - q_d/r)**2")
    own = mechanics("disk-on-turning-rod")
    return exact(
        geometry("m/2*(dot(x)**2 + dot(y)**2)", x, ("q",)) + spin - own.T,
        own.equation("q") - formula("3*m/2*(q_dd - 2*w**2*q/3)"),
    )


@result("C15", "P1-6, motion")
def disk_on_rod_motion():
    """q = q0*cosh(kt) + (v0/k)*sinh(kt), k = w*sqrt(2/3)."""
    k, time = sp.sqrt(sp.Rational(2, 3)), sp.Rational(7, 2)
    return off(
        motion("disk-on-turning-rod").at("3.5").q["q"], (sp.cosh(k * time) - sp.sinh(k * time) / (2 * k)).evalf(30)
    )


@result("C16", "P1-7")
def planetary_momenta():
    """p_theta = 11/6*m*l^2*theta' + m*l*(l + r)*psi'/2, p_psi = (I0 + m*(l + r)^2/2)*psi' + m*l*(l + r)*theta'/2."""
    own = p_of("planetary-disk")
    return exact(
        own["theta"] - formula("11*m*l**2*theta_d/6 + m*l*(l + r)*psi_d/2"),
        own["psi"] - formula("(I0 + m*(l + r)**2/2)*psi_d + m*l*(l + r)*theta_d/2"),
    )


CURVES = {
    "C17": ("pendulum", {"l": "r"}, "r*sin(theta)", "-r*cos(theta)", "y*x_dd - x*y_dd - g*x"),
    "C18": ("elliptic-trammel", {}, "l*cos(theta)", "l*sin(theta)", "2*y*x_dd - x*y_dd - g*x"),
}


def on_a_curve(row: str) -> int:
    entry, rename, x, y, book = CURVES[row]
    own, frame = mechanics(entry), Mechanics("0", "0", ("theta",))
    place = {"x": formula(x), "y": formula(y)}
    values = {S(n): f for n, f in place.items()}
    values |= {S(f"{n}_dd"): frame.rate(frame.rate(f)) for n, f in place.items()}
    other = formula(book).xreplace(values)
    mine = own.equation("theta").xreplace({S(a): S(b) for a, b in rename.items()})
    ratio = sp.simplify(other.diff(S("theta_dd")) / mine.diff(S("theta_dd")))
    return exact(other - ratio * mine)


@result("C17", "P1-9")
def pendulum_on_a_circle():
    """y*x'' - x*y'' - g*x = 0 on x^2 + y^2 = r^2 is the pendulum's equation."""
    return on_a_curve("C17")


@result("C17", "P1-9, separatrix")
def pendulum_separatrix():
    """At E = m*g*r the pendulum needs an infinite time to the top."""
    assert start("pendulum", {"theta": 0}, {"theta": 2}, m=1, g=1, l=1).kinds == {"theta": "asymptotic"}
    assert start("pendulum", {"theta": 0}, {"theta": "1.99"}, m=1, g=1, l=1).kinds == {"theta": "libration"}
    assert start("pendulum", {"theta": 0}, {"theta": "2.01"}, m=1, g=1, l=1).kinds == {"theta": "rotation"}
    return 0


@result("C18", "P1-10")
def trammel():
    """2y*x'' - x*y'' - g*x = 0 with x^2 + y^2 = l^2."""
    return on_a_curve("C18")


@result("C19", "P1-11")
def flywheel():
    """m*x'' - m*(x0 + x)*theta'^2 + k*x = 0 and (I + m*(x0 + x)^2)*theta' = const."""
    own = mechanics("flywheel-with-slider")
    return exact(
        own.equation("x") - own.of("m*x_dd - m*(x0 + x)*theta_d**2 + k*x"),
        own.momentum("theta") - own.of("(I + m*(x0 + x)**2)*theta_d"),
    )


@result("C20", "P1-12")
def bowl_equilibrium():
    """Equilibrium at tan(theta) = 1/2, theta = 26.57 degrees."""
    own = mechanics("dumbbell-in-bowl")
    angle = sp.atan(sp.Rational(1, 2))
    assert abs(sp.N(angle * 180 / sp.pi) - 26.57) < 0.005
    return exact(own.V.diff(S("theta")).subs(S("theta"), angle))


@result("C21", "P1-13")
def a_frame_equilibrium():
    """Stable equilibrium at cos(theta) = sqrt(27/32), theta = 23.28 degrees."""
    own, angle = mechanics("a-frame"), sp.acos(sp.sqrt(sp.Rational(27, 32)))
    assert abs(sp.N(angle * 180 / sp.pi) - 23.28) < 0.006
    assert sp.N(own.V.diff(S("theta"), 2).subs({S("theta"): angle, **dict.fromkeys(map(S, "mgl"), 1)})) > 0
    return exact(own.V.diff(S("theta")).subs(S("theta"), angle))


@result("C21", "P1-13, end of the coordinate")
def a_frame_end():
    """The inertia grows like sqrt(3)/(32*(pi/6 - theta)) at the end pi/6 (m = l = 1)."""
    mass = mechanics("a-frame").mass[0].subs(dict.fromkeys(map(S, "mgl"), 1))
    return exact(sp.limit(mass * (sp.pi / 6 - S("theta")), S("theta"), sp.pi / 6, "-") - sp.sqrt(3) / 32)


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
