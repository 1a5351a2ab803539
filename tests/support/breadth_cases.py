"""Systems in disguise, with magnetic terms, with ignorable blocks, on surfaces: separable ones and refused neighbours."""

from __future__ import annotations

from hjsolve.mechanics.system import System
from tests.support.separation_cases import PLANE, PLANE_POLAR, POLAR_COORDINATES, SPHERICAL, SPHERICAL_COORDINATES, make

FREE = "(dot(x)**2 + dot(y)**2)/2"
QUARTER = {"x": "0 < x", "y": "0 < y"}
CYLINDER = {"r": "0 < r", "theta": "angle", "z": "line"}
CYLINDRICAL = "m/2*(dot(r)**2 + r**2*dot(theta)**2 + dot(z)**2)"

DISGUISED = {
    "log of a product": make(QUARTER, FREE, "k*log(x*y)", "k"),
    "log of an exponential": make(PLANE, FREE, "k*log(exp(x + y))", "k"),
    "exponentials that cancel": make(PLANE, FREE, "k*(exp(x + y) - exp(x)*exp(y)) + k*cosh(x)", "k"),
    "sine of a sum that cancels": make(PLANE, FREE, "k*(sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y)) + cos(x)", "k"),
    "cosines of sum and difference": make(PLANE, FREE, "k*cos(x - y)*cos(x + y)", "k"),
    "hyperbolic sum and difference": make(PLANE, FREE, "k*cosh(x - y)*cosh(x + y)", "k"),
    "multiple angles": make(PLANE, FREE, "k*(sin(3*x)/sin(x) + cos(4*y)/cos(2*y))", "k"),
    "half and double angles": make(
        {"x": "0 < x < pi/2", "y": "0 < y < pi/2"}, FREE, "k*tan(x/2)*tan(x) + (1 - cos(2*y))/sin(2*y)", "k"
    ),
    "tangent of a sum": make(
        {"x": "0 < x < 1/2", "y": "0 < y < 1/2"}, FREE, "k*tan(x + y)*(1 - tan(x)*tan(y))", "k"
    ),
    "nested radical": make(QUARTER, FREE, "k*sqrt(x + y + 2*sqrt(x*y))", "k"),
    "nested radical, conjugate": make(QUARTER, FREE, "k*sqrt(x + y + 2*sqrt(x*y))*(sqrt(x) - sqrt(y))", "k"),
    "nested numbers and a square": make(QUARTER, FREE, "k*sqrt(3 + 2*sqrt(2))*x + sqrt(x**2 + 2*x*y + y**2)", "k"),
    "roots of quotients": make(QUARTER, FREE, "k*sqrt(x*y)*sqrt(y/x) + sqrt(x**3)/sqrt(x)", "k"),
    "distance in parabolic coordinates": make(
        {"u": "line", "v": "line"}, "(u**2 + v**2)/2*(dot(u)**2 + dot(v)**2)", "-k/sqrt(((u**2 - v**2)/2)**2 + u**2*v**2)",
        "k",
    ),
    "symbolic powers": make(QUARTER, FREE, "k*(x*y)**a/y**a + h*(x**b)**2", "k a b h"),
    "power law": make(POLAR_COORDINATES, PLANE_POLAR, "k*r**n", "m k n"),
    "arcs that add up": make({"x": "0 < x < 1", "y": "0 < y < 1"}, FREE, "k*(asin(x) + acos(x))*y + atan(y)", "k"),
    "arcs of a quotient": make(QUARTER, FREE, "k*(atan(y/x) + atan(x/y))*x", "k"),
    "r = exp(s)": make(
        {"s": "line", "theta": "angle"}, "m/2*exp(2*s)*(dot(s)**2 + dot(theta)**2)",
        "-k*exp(-s) + b*cos(theta)*exp(-2*s)", "m k b",
    ),
    "r = s**3": make(
        {"s": "0 < s", "theta": "0 < theta < pi", "phi": "angle"},
        "m/2*(9*s**4*dot(s)**2 + s**6*dot(theta)**2 + s**6*sin(theta)**2*dot(phi)**2)", "-k/s**3 + b*cos(theta)/s**6", "m k b",
    ),
    "theta = 2 atan(t)": make(
        {"r": "0 < r", "t": "line"}, "m/2*(dot(r)**2 + 4*r**2*dot(t)**2/(1 + t**2)**2)",
        "-k/r + b*(1 - t**2)/((1 + t**2)*r**2)", "m k b",
    ),
    "theta = acos(t)": make(
        {"r": "0 < r", "t": "-1 < t < 1", "phi": "angle"},
        "m/2*(dot(r)**2 + r**2*dot(t)**2/(1 - t**2) + r**2*(1 - t**2)*dot(phi)**2)", "-k/r + b*t/r**2", "m k b",
    ),
    "x = sinh(s), y = t**3": make(
        {"s": "line", "t": "0 < t"}, "cosh(s)**2*dot(s)**2/2 + 9*t**4*dot(t)**2/2", "k*sinh(s)**2 + t**9", "k"
    ),
    "elliptic, squares of xi and eta": make(
        {"s": "1 < s", "t": "0 < t < 1"}, "m*a**2/8*(s - t)*(dot(s)**2/(s*(s - 1)) + dot(t)**2/(t*(1 - t)))",
        "-k/(a*(sqrt(s) + sqrt(t)))", "a m k",
    ),
}  # fmt: skip

MAGNETIC = {
    "Penning trap": make(CYLINDER, f"{CYLINDRICAL} + e*B/2*r**2*dot(theta)", "m*w**2*(2*z**2 - r**2)/4", "m e B w"),
    "monopole and Kepler (MICZ)": make(
        SPHERICAL_COORDINATES, f"{SPHERICAL} - g*cos(theta)*dot(phi)", "-k/r + g**2/(2*m*r**2)", "m k g"
    ),
    "monopole and a dipole": make(
        SPHERICAL_COORDINATES, f"{SPHERICAL} - g*cos(theta)*dot(phi)", "-k/r + b*cos(theta)/r**2", "m k g b"
    ),
    "Kepler in a turning frame": make(
        POLAR_COORDINATES, f"{PLANE_POLAR} + m*w*r**2*dot(theta) + m*w**2*r**2/2", "-k/r", "m k w"
    ),
}


def black_hole(radial: str, polar: str = "1", charge: str = "0") -> System:
    """Carter's form of the metric in Boyer–Lindquist coordinates: Kerr, Kerr–Newman, Kerr–de Sitter."""
    Σ = "(r**2 + a**2*cos(theta)**2)"
    kinetic = (
        f"-({radial})/(2*{Σ})*(dot(t) - a*sin(theta)**2*dot(phi))**2 + {Σ}/(2*({radial}))*dot(r)**2"
        f"+ {Σ}/(2*({polar}))*dot(theta)**2 + ({polar})*sin(theta)**2/(2*{Σ})*((r**2 + a**2)*dot(phi) - a*dot(t))**2"
        f"- {charge}*r/{Σ}*(dot(t) - a*sin(theta)**2*dot(phi))"
    )
    coordinates = {"t": "line", "r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}
    parameters = {"M": "1", "a": "1/2", "Q": "1/4", "l": "1/10", "e": "1"}
    return System(coordinates, kinetic, "0", parameters, signature="indefinite")


IGNORABLE = {
    "Kerr–Newman, charged particle": black_hole("r**2 - 2*M*r + a**2 + Q**2", charge="e*Q"),
    "Kerr–de Sitter": black_hole("(r**2 + a**2)*(1 - l*r**2/3) - 2*M*r", "1 + l*a**2*cos(theta)**2/3"),
    "top, Euler's angles": make(
        {"phi": "angle", "theta": "0 < theta < pi", "psi": "angle"},
        "A/2*(dot(theta)**2 + sin(theta)**2*dot(phi)**2) + C/2*(dot(psi) + dot(phi)*cos(theta))**2",
        "m*g*l*cos(theta)",
        "A C m g l",
    ),
    "torus": make(
        {"u": "angle", "v": "angle"}, "(R + r*cos(u))**2*dot(v)**2/2 + r**2*dot(u)**2/2", "g*r*sin(u)", "R r g"
    ),
}

SEPARABLE = {**DISGUISED, **MAGNETIC, **IGNORABLE}

REFUSED = {
    "sine of a sum, one term short": make(PLANE, FREE, "k*(sin(x + y) - sin(x)*cos(y)) + cos(x)", "k"),
    "log of a sum": make(QUARTER, FREE, "k*log(x + y)", "k"),
    "nested radical that does not denest": make(QUARTER, FREE, "k*sqrt(x + y + 3*sqrt(x*y))", "k"),
    "power of a product": make(QUARTER, FREE, "k*(x*y)**a", "k a"),
    "dipole field": make(SPHERICAL_COORDINATES, f"{SPHERICAL} + g*sin(theta)**2/r*dot(phi)", "0", "m g"),
    "uniform field, spherical": make(
        SPHERICAL_COORDINATES, f"{SPHERICAL} + B*r**2*sin(theta)**2*dot(phi)/2", "-k/r", "m k B"
    ),
    "uniform field, Cartesian": make(
        PLANE, "m/2*(dot(x)**2 + dot(y)**2) + B/2*(x*dot(y) - y*dot(x))", "k*x**2 + h*y**2", "m B k h"
    ),
    "asymmetric top": make(
        {"phi": "angle", "theta": "0 < theta < pi", "psi": "angle"},
        "A/2*(dot(phi)*sin(theta)*sin(psi) + dot(theta)*cos(psi))**2"
        "+ B/2*(dot(phi)*sin(theta)*cos(psi) - dot(theta)*sin(psi))**2 + C/2*(dot(psi) + dot(phi)*cos(theta))**2",
        "0",
        "A B C",
    ),
    "Kerr with another rotation of the sphere": black_hole("r**2 - 2*M*r + a**2*(1 + sin(theta)**2/10)"),
}
