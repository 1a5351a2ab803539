"""Systems whose verdict is known, as they stand in the literature; used by the laws of separation and by benchmarks.

Numbers C… are those of Greenwood, Classical Dynamics (1977), in the order of the book; (5-…) are its equations.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

from hjsolve.mechanics.system import System, parameter
from hjsolve.separation import Obstruction, Separation, Undecided, separate

PLANE_POLAR = "m/2*(dot(r)**2 + r**2*dot(theta)**2)"
SPHERICAL = "m/2*(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)"
CARTESIAN = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
POLAR_COORDINATES = {"r": "0 < r", "theta": "angle"}
SPHERICAL_COORDINATES = {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}
SPACE = {"x": "line", "y": "line", "z": "line"}
PLANE = {"x": "line", "y": "line"}


def make(coordinates: dict[str, str], kinetic: str, potential: str = "0", positive: str = "") -> System:
    """A system whose parameters, named in one string, are positive."""
    parameters = {name: parameter(name, 1 + k, assume="positive") for k, name in enumerate(positive.split())}
    return System(coordinates, kinetic, potential, parameters)


def ellipsoidal(names: Sequence[str], ends: Sequence[str], potential: bool = True) -> System:
    """Jacobi's ellipsoidal coordinates of Euclidean space, with the potential of power n that separates in them."""
    kinetic, terms, domains = [], [], {}
    for i, q in enumerate(names):
        others = "*".join(f"({q} - {o})" for o in names if o != q)
        roots = "*".join(f"({q} - {a})" for a in ends)
        kinetic.append(f"m/8*({others})/({roots})*dot({q})**2")
        terms.append(f"{q}**{len(names)}/({others})")
        domains[q] = f"{ends[i]} < {q} < {ends[i + 1]}" if i + 1 < len(ends) else f"{ends[i]} < {q}"
    V = f"k*({' + '.join(terms)})" if potential else "0"
    return make(domains, " + ".join(kinetic), V, " ".join([*ends, "m", "k"]))


def two_centres(potential: str) -> System:
    """Two fixed centres at (±a, 0) in elliptic coordinates of the plane."""
    kinetic = "m/2*a**2*(cosh(u)**2 - cos(v)**2)*(dot(u)**2 + dot(v)**2)"
    return make({"u": "0 < u", "v": "angle"}, kinetic, potential, "a m k1 k2")


# ------------------------------------------------------------ one essential coordinate

ONE_DIMENSIONAL = {
    "harmonic oscillator": make({"x": "line"}, "m/2*dot(x)**2", "k*x**2/2", "m k"),
    "pendulum": make({"theta": "angle"}, "m*l**2/2*dot(theta)**2", "-m*g*l*cos(theta)", "m g l"),
    "Kepler, plane": make(POLAR_COORDINATES, PLANE_POLAR, "-k/r", "m k"),
    "isotropic oscillator, polar": make(POLAR_COORDINATES, PLANE_POLAR, "k*r**2/2", "m k"),
    "spherical pendulum": make(
        {"theta": "0 < theta < pi", "phi": "angle"},
        "m*l**2/2*(dot(theta)**2 + sin(theta)**2*dot(phi)**2)",
        "-m*g*l*cos(theta)",
        "m g l",
    ),
    "top, C52": make(
        {"psi": "angle", "theta": "-pi/2 < theta < pi/2", "phi": "angle"},
        "I_a/2*(dot(phi) - dot(psi)*sin(theta))**2 + I_t/2*(dot(theta)**2 + dot(psi)**2*cos(theta)**2)",
        "m*g*l*sin(theta)",
        "I_a I_t m g l",
    ),
    "projectile": make(PLANE, "m/2*(dot(x)**2 + dot(y)**2)", "m*g*y", "m g"),
    "bead on a turning wire, C13": make(
        {"theta": "angle"}, "m*r**2*(omega*(dot(theta) + omega)*(1 - cos(theta)) + dot(theta)**2/2)", "0", "m r omega"
    ),
    "rod with a sliding end, C14": make(
        {"x": "line", "theta": "angle"},
        "m/2*dot(x)**2 + m*l**2/6*dot(theta)**2 - m*l/2*dot(x)*dot(theta)*sin(theta)",
        "m*g*l*sin(theta)/2",
        "m g l",
    ),
    "block on a wedge, C24": make(
        {"x1": "line", "x2": "line"},
        "m1/2*dot(x1)**2 + m2/2*(dot(x1)**2 + dot(x2)**2 - sqrt(2)*dot(x1)*dot(x2))",
        "-m2*g*x2/sqrt(2)",
        "m1 m2 g",
    ),
    "whirling tube, C25a": make(
        {"theta": "angle"}, "m*r**2/2*(dot(theta)**2 + omega**2*sin(theta)**2)", "m*g*r*cos(theta)", "m r g omega"
    ),
    "spring in a moving frame, C29": make({"x": "line"}, "m/2*(v0 + dot(x))**2", "k*x**2/2", "m k v0"),
    "spring in a turntable slot, C36": make(
        {"y": "line"}, "m/2*((dot(y) + Omega*R)**2 + Omega**2*y**2)", "k*y**2/2", "m k Omega R"
    ),
    "crossed fields, Landau gauge, C55": make(SPACE, f"{CARTESIAN} - e*B*y*dot(x)", "-e*E0*y", "m e B E0"),
    "radial and uniform field, C64": make(
        {"r": "0 < r", "theta": "angle", "z": "line"},
        "m/2*(dot(r)**2 + r**2*dot(theta)**2 + dot(z)**2) + e*B0/2*r**2*dot(theta)",
        "-E0*e*log(r)",
        "m e E0 B0",
    ),
}

# ------------------------------------------------------------ two and more essential coordinates

SEVERAL = {
    "Kepler, space": make(SPHERICAL_COORDINATES, SPHERICAL, "-k/r", "m k"),
    "P5-6": make({"q1": "line", "q2": "line"}, "(q1**2 + q2**2)*(dot(q1)**2 + dot(q2)**2)/2", "K/(q1**2 + q2**2)", "K"),
    "P5-8": make(
        SPHERICAL_COORDINATES,
        SPHERICAL,
        "-k/r + a*cos(theta)**2/(m*r**2) + b*cos(phi)/(m*r**2*sin(theta)**2)",
        "m k a b",
    ),
    "Kepler, parabolic": make(
        {"u": "line", "v": "line"}, "m/2*(u**2 + v**2)*(dot(u)**2 + dot(v)**2)", "-2*k/(u**2 + v**2)", "m k"
    ),
    "two centres": two_centres("-k1/(a*(cosh(u) + cos(v))) - k2/(a*(cosh(u) - cos(v)))"),
    "two centres with square roots": two_centres(
        "-k1/sqrt((a*cosh(u)*cos(v) + a)**2 + a**2*sinh(u)**2*sin(v)**2)"
        "- k2/sqrt((a*cosh(u)*cos(v) - a)**2 + a**2*sinh(u)**2*sin(v)**2)"
    ),
    "oscillators in a moving frame": make(
        PLANE, "m/2*(dot(x)**2 + dot(y)**2) + b*(y*dot(x) + x*dot(y)) + c*cos(x)*dot(x)", "k*x**2 + h*y**4", "m k h b c"
    ),
    "ellipsoidal, plane": ellipsoidal(["u", "v"], ["a", "b"]),
}

E3 = {
    "1 Cartesian": make(SPACE, CARTESIAN, "k*x**2 + b*y**4 + c*cos(z)", "m k b c"),
    "2 circular cylinder": make(
        {"r": "0 < r", "theta": "angle", "z": "line"},
        "m/2*(dot(r)**2 + r**2*dot(theta)**2 + dot(z)**2)",
        "-k/r + b*cos(theta)/r**2 + c*z**4",
        "m k b c",
    ),
    "3 elliptic cylinder": make(
        {"u": "0 < u", "v": "angle", "z": "line"},
        "m/2*(a**2*(cosh(u)**2 - cos(v)**2)*(dot(u)**2 + dot(v)**2) + dot(z)**2)",
        "k*(cosh(u) + cos(v)**3)/(cosh(u)**2 - cos(v)**2) + b*z**2",
        "a m k b",
    ),
    "4 parabolic cylinder": make(
        {"u": "line", "v": "0 < v", "z": "line"},
        "m/2*((u**2 + v**2)*(dot(u)**2 + dot(v)**2) + dot(z)**2)",
        "k*(u**3 + v**4)/(u**2 + v**2) + b*z**2",
        "m k b",
    ),
    "5 spherical": make(
        SPHERICAL_COORDINATES,
        SPHERICAL,
        "k*r**2 + b/(r*cos(theta))**2 + c/(r*sin(theta)*cos(phi))**2",
        "m k b c",
    ),
    "6 prolate": make(
        {"u": "0 < u", "v": "0 < v < pi", "phi": "angle"},
        "m*a**2/2*((sinh(u)**2 + sin(v)**2)*(dot(u)**2 + dot(v)**2) + sinh(u)**2*sin(v)**2*dot(phi)**2)",
        "(k*cosh(u) + b*cos(v)**3)/(sinh(u)**2 + sin(v)**2) + c*cos(phi)/(sinh(u)**2*sin(v)**2)",
        "a m k b c",
    ),
    "7 oblate": make(
        {"u": "0 < u", "v": "0 < v < pi", "phi": "angle"},
        "m*a**2/2*((cosh(u)**2 - sin(v)**2)*(dot(u)**2 + dot(v)**2) + cosh(u)**2*sin(v)**2*dot(phi)**2)",
        "(k*sinh(u) + b*cos(v)**3)/(cosh(u)**2 - sin(v)**2) + c*cos(phi)/(cosh(u)**2*sin(v)**2)",
        "a m k b c",
    ),
    "8 rotational parabolic": make(
        {"u": "0 < u", "v": "0 < v", "phi": "angle"},
        "m/2*((u**2 + v**2)*(dot(u)**2 + dot(v)**2) + u**2*v**2*dot(phi)**2)",
        "(k*u**3 + b*v**4)/(u**2 + v**2) + c*cos(phi)/(u**2*v**2)",
        "m k b c",
    ),
    "9 conical": make(
        {"r": "0 < r", "mu": "b < mu < c", "nu": "-b < nu < b"},
        "m/2*(dot(r)**2 + r**2*(mu**2 - nu**2)/((mu**2 - b**2)*(c**2 - mu**2))*dot(mu)**2"
        "+ r**2*(mu**2 - nu**2)/((b**2 - nu**2)*(c**2 - nu**2))*dot(nu)**2)",
        "k/r + (h1*mu**4 + h2*nu**6)/(r**2*(mu**2 - nu**2))",
        "b c m k h1 h2",
    ),
    "10 ellipsoidal": ellipsoidal(["u", "v", "w"], ["a", "b", "c"]),
    "11 paraboloidal": make(
        {"u": "c < u", "v": "b < v < c", "w": "w < b"},
        "m/2*((u - v)*(u - w)/((u - b)*(u - c))*dot(u)**2 + (v - u)*(v - w)/((v - b)*(v - c))*dot(v)**2"
        "+ (w - u)*(w - v)/((w - b)*(w - c))*dot(w)**2)",
        "k*u**4/((u - v)*(u - w)) + k*v**4/((v - u)*(v - w)) + k*w**4/((w - u)*(w - v))",
        "b c m k",
    ),
}

SEPARABLE = {**ONE_DIMENSIONAL, **SEVERAL, **E3}

# name → (system, pair, part)
REFUSED = {
    "double pendulum, C23a": (
        make(
            {"theta": "angle", "phi": "angle"},
            "m*l**2/2*(2*dot(theta)**2 + dot(phi)**2 + 2*dot(theta)*dot(phi)*cos(phi - theta))",
            "-m*g*l*(2*cos(theta) + cos(phi))",
            "m l g",
        ),
        ("theta", "phi"),
        "metric",
    ),
    "Hénon–Heiles": (
        make(PLANE, "(dot(x)**2 + dot(y)**2)/2", "(x**2 + y**2)/2 + x**2*y - y**3/3"),
        ("x", "y"),
        "potential",
    ),
    "P6-3, new variables, C84b": (
        make(
            {"Q1": "line", "Q2": "line"},
            "m/4*(dot(Q1)**2 + dot(Q2)**2)/sqrt(Q1**2 + Q2**2)",
            "k*sqrt(sqrt(Q1**2 + Q2**2) - Q2)",
            "m k",
        ),
        ("Q1", "Q2"),
        "metric",
    ),
    "anisotropic Kepler": (
        make(PLANE, "m1/2*dot(x)**2 + m2/2*dot(y)**2", "-k/sqrt(x**2 + y**2)", "m1 m2 k"),
        ("x", "y"),
        "potential",
    ),
    "Miyamoto–Nagai": (
        make(
            {"R": "0 < R", "phi": "angle", "z": "line"},
            "(dot(R)**2 + R**2*dot(phi)**2 + dot(z)**2)/2",
            "-M/sqrt(R**2 + (a + sqrt(z**2 + b**2))**2)",
            "M a b",
        ),
        ("R", "z"),
        "potential",
    ),
    "bispherical": (
        make(
            {"s": "line", "t": "0 < t < pi", "phi": "angle"},
            "a**2*(dot(s)**2 + dot(t)**2 + sin(t)**2*dot(phi)**2)/(2*(cosh(s) - cos(t))**2)",
            "0",
            "a",
        ),
        ("s", "t"),
        "metric",
    ),
    "toroidal": (
        make(
            {"s": "0 < s", "t": "angle", "phi": "angle"},
            "a**2*(dot(s)**2 + dot(t)**2 + sinh(s)**2*dot(phi)**2)/(2*(cosh(s) - cos(t))**2)",
            "0",
            "a",
        ),
        ("s", "t"),
        "metric",
    ),
    "crossed fields, symmetric gauge, C55": (
        make(SPACE, f"{CARTESIAN} + e*B/2*(x*dot(y) - y*dot(x))", "-e*E0*y", "m e B E0"),
        ("x", "y"),
        "gyroscopic",
    ),
    "coupled small oscillations, C23b": (
        make(PLANE, "m/2*(2*dot(x)**2 + dot(y)**2 + 2*dot(x)*dot(y))", "m*g/(2*l)*(2*x**2 + y**2)", "m g l"),
        ("x", "y"),
        "metric",
    ),
    "three particles on an elastic rod, C45": (
        make(
            {"y1": "line", "y2": "line", "y3": "line"},
            "m/2*(dot(y1)**2 + dot(y2)**2 + dot(y3)**2)",
            "k/2*(y1 - 2*y2 + y3)**2",
            "m k",
        ),
        ("y1", "y2"),
        "potential",
    ),
    "Stark in spherical coordinates": (
        make(SPHERICAL_COORDINATES, SPHERICAL, "-k/r + b*r*cos(theta)", "m k b"),
        ("r", "theta"),
        "potential",
    ),
    "ellipsoidal with one wrong exponent": (
        make(
            {"u": "a < u < b", "v": "b < v"},
            "m/8*((u - v)/((u - a)*(u - b))*dot(u)**2 + (v - u)/((v - a)*(v - b))*dot(v)**2)",
            "k*(u**2 - v**3)/(u - v) + h*u*v**2",
            "a b m k h",
        ),
        ("u", "v"),
        "potential",
    ),
}


@functools.cache
def decided(name: str) -> Separation | Obstruction | Undecided:
    """What ``separate`` says of one of these systems; made once a process."""
    return separate(SEPARABLE[name] if name in SEPARABLE else REFUSED[name][0])


def kerr() -> System:
    """Geodesics of Kerr in Boyer–Lindquist coordinates, mass 1."""
    Σ, Δ = "(r**2 + a**2*cos(theta)**2)", "(r**2 - 2*M*r + a**2)"
    kinetic = (
        f"-(1 - 2*M*r/{Σ})/2*dot(t)**2 - 2*M*a*r*sin(theta)**2/{Σ}*dot(t)*dot(phi) + {Σ}/(2*{Δ})*dot(r)**2"
        f"+ {Σ}/2*dot(theta)**2 + sin(theta)**2/2*(r**2 + a**2 + 2*M*a**2*r*sin(theta)**2/{Σ})*dot(phi)**2"
    )
    coordinates = {"t": "line", "r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}
    return System(coordinates, kinetic, "0", {"M": 1, "a": "1/2"}, signature="indefinite")
