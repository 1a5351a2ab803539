"""Each separation constant that is said to be a known integral is that integral: exactly, from Cartesian momenta.

The known integral is written in Cartesian coordinates and carried over by the transposed Jacobian, by sympy alone. The
difference from the constant must vanish identically or, where the potential continues it, be free of momenta.
"""

from __future__ import annotations

import random
import re

import pytest
import sympy as sp

from hjsolve.algebra.reader import Reader
from hjsolve.mechanics.system import System, hamiltonian
from hjsolve.separation import Separation, separate
from hjsolve.separation.constants.known_integrals import curvature
from tests.support.separation_cases import E3, ONE_DIMENSIONAL, SEVERAL, SPHERICAL_COORDINATES, kerr, make, two_centres

CONTINUED = "continued by a function of the coordinates"
a, b, c, m, k = sp.symbols("a b c m k", positive=True)


def symbols(system: System):
    return [q.symbol for q in system.coordinates], [q.momentum for q in system.coordinates]


def exact(expressions, q, p, seed: int):
    """Exact values at a random rational point of tan(q/2) and exp(q), twice: with two sets of momenta."""
    generator = random.Random(seed)

    def number():
        return sp.Rational(generator.randint(1, 9**6), 9**5)

    point = {}
    for s in q:
        t, e = number(), number() + 1
        point |= {
            sp.cos(s): (1 - t**2) / (1 + t**2), sp.sin(s): 2 * t / (1 + t**2), sp.tan(s): 2 * t / (1 - t**2),
            sp.cot(s): (1 - t**2) / (2 * t), sp.cosh(s): (e + 1 / e) / 2, sp.sinh(s): (e - 1 / e) / 2,
        }  # fmt: skip
    others = set().union(*(x.free_symbols for x in expressions)) - set(p)
    point |= {s: number() for s in sorted(others, key=str)}
    for _ in range(2):
        here = point | {s: number() for s in p}
        yield [x.xreplace(here) for x in expressions]


def momenta(place, q, p) -> sp.Matrix:
    """Cartesian momenta from p = Jᵀ p_xyz, by Cramer's rule."""
    transposed = sp.Matrix(place).jacobian(q).T
    determinant = transposed.det()
    columns = []
    for i in range(len(q)):
        exchanged = transposed.copy()
        exchanged[:, i] = sp.Matrix(p)
        columns.append(exchanged.det() / determinant)
    return sp.Matrix(columns)


def angular(place, P) -> sp.Matrix:
    x, y, z = (*place, 0)[:3]
    px, py, pz = (*P, 0)[:3]
    return sp.Matrix([y * pz - z * py, z * px - x * pz, x * py - y * px])


def known(place, q, p, axis: int, distance=None, charge=0) -> dict[str, sp.Expr]:
    """Known integrals by the names the constants use: foci at ±distance on the axis, a centre of force at the origin."""
    P = momenta(place, q, p)
    L = angular(place, P)
    found = {"L": sp.sqrt((L.T * L)[0]), "L_z": L[2], "p_y": P[1], "p_x": P[0]}
    three = [*P, 0][:3]
    r = sp.sqrt(sum(x**2 for x in place))
    found["A"] = sp.Matrix(three).cross(L)[axis] - charge * place[axis] / r
    if distance is not None:
        first, second = ([x + s * distance * int(i == axis) for i, x in enumerate(place)] for s in (1, -1))
        about = [angular(place, P) for place in (first, second)]
        lines = len(place) == 3 and axis == 0  # a cylinder along z: about the focal lines
        found["L_1*L_2"] = about[0][2] * about[1][2] if lines else (about[0].T * about[1])[0]
    return found


def formula(meaning: str) -> str:
    """The formula in "separation constant shared by …: formula, words" """
    text = meaning.split(": ", 1)[1]
    return re.split(r"(?: continued by|, )", text)[0]


def compared(verdict: Separation, name: str, values: dict[str, sp.Expr]) -> sp.Expr:
    """α minus the formula of its meaning."""
    constant = verdict.constants[name]
    expression = sp.sympify(formula(constant.meaning), locals={name: sp.Symbol(name) for name in "EQ"})
    both = sp.Symbol("both")
    expression = expression.subs(sp.Symbol("L_1") * sp.Symbol("L_2"), both)
    plain = {s.name: s for s in verdict.system.symbols.values()}
    plain["E"] = hamiltonian(verdict.system)
    (*_, z), (*_, p_z) = symbols(verdict.system)
    plain["E_u_v"] = hamiltonian(verdict.system) - p_z**2 / (2 * m) - b * z**2  # where z with b z² splits off
    plain["both"] = values.get("L_1*L_2", sp.nan)
    return constant.expression - expression.subs({sp.Symbol(n): v for n, v in {**plain, **values}.items()})


u, v = sp.symbols("u v", real=True)


def prolate(system):
    (u, v, φ), _ = symbols(system)
    ρ = a * sp.sinh(u) * sp.sin(v)
    return [ρ * sp.cos(φ), ρ * sp.sin(φ), a * sp.cosh(u) * sp.cos(v)]


def oblate(system):
    (u, v, φ), _ = symbols(system)
    ρ = a * sp.cosh(u) * sp.sin(v)
    return [ρ * sp.cos(φ), ρ * sp.sin(φ), a * sp.sinh(u) * sp.cos(v)]


def spherical(system):
    (r, θ, φ), _ = symbols(system)
    return [r * sp.sin(θ) * sp.cos(φ), r * sp.sin(θ) * sp.sin(φ), r * sp.cos(θ)]


def latitude(system):
    (r, θ, φ), _ = symbols(system)
    return [r * sp.cos(θ) * sp.cos(φ), r * sp.cos(θ) * sp.sin(φ), r * sp.sin(θ)]


def elliptic(system):
    (u, v), _ = symbols(system)
    return [a * sp.cosh(u) * sp.cos(v), a * sp.sinh(u) * sp.sin(v)]


def parabolic(system):
    (u, v), _ = symbols(system)
    return [(u**2 - v**2) / 2, u * v]


def rotational(system):
    (u, v, φ), _ = symbols(system)
    return [u * v * sp.cos(φ), u * v * sp.sin(φ), (u**2 - v**2) / 2]


def algebraic(system):
    (ξ, η, *φ), _ = symbols(system)
    across = a * sp.sqrt((ξ**2 - 1) * (1 - η**2))
    return [across * sp.cos(φ[0]), across * sp.sin(φ[0]), a * ξ * η] if φ else [a * ξ * η, across]


def squared(system):
    (ξ, η, *φ), _ = symbols(system)
    across = sp.sqrt(ξ * η)
    return [across * sp.cos(φ[0]), across * sp.sin(φ[0]), (ξ - η) / 2] if φ else [(ξ - η) / 2, across]


def in_z(plane):
    """The cylinder over a plane chart."""

    def place(system):
        (u, v, z), _ = symbols(system)
        return [*(x.subs({sp.Symbol("u", real=True): u, sp.Symbol("v", real=True): v}) for x in plane), z]

    return place


ELLIPTIC_PLANE = [a * sp.cosh(u) * sp.cos(v), a * sp.sinh(u) * sp.sin(v)]
PARABOLIC_PLANE = [(u**2 - v**2) / 2, u * v]
ALGEBRAIC = "m*a**2/2*(xi**2 - eta**2)*(dot(xi)**2/(xi**2 - 1) + dot(eta)**2/(1 - eta**2))"
SQUARED = "m/8*(xi + eta)*(dot(xi)**2/xi + dot(eta)**2/eta)"
PROLATE = "m*a**2/2*((sinh(u)**2 + sin(v)**2)*(dot(u)**2 + dot(v)**2) + sinh(u)**2*sin(v)**2*dot(phi)**2)"
PROLATE_COORDINATES = {"u": "0 < u", "v": "0 < v < pi", "phi": "angle"}
TWO = "-(k1*(cosh(u) - cos(v)) + k2*(cosh(u) + cos(v)))/(a*(cosh(u)**2 - cos(v)**2))"
ROTATIONAL = "m/2*((u**2 + v**2)*(dot(u)**2 + dot(v)**2) + u**2*v**2*dot(phi)**2)"
LATITUDE = "m/2*(dot(r)**2 + r**2*dot(theta)**2 + r**2*cos(theta)**2*dot(phi)**2)"

# name → system, place in space, index of the axis, focal distance, m k of a centre, {constant: (what is said, continued)}
CASES = {
    "Kepler, spherical": (SEVERAL["Kepler, space"], spherical, 2, None, 0,
                          {"alpha_2": ("L the total angular momentum", False)}),
    "Kepler, latitude": (make({"r": "0 < r", "theta": "-pi/2 < theta < pi/2", "phi": "angle"}, LATITUDE, "-k/r", "m k"),
                         latitude, 2, None, 0, {"alpha_2": ("L the total angular momentum", False)}),
    "general spherical": (SEVERAL["P5-8"], spherical, 2, None, 0,
                          {"alpha_2": ("L the total", True), "alpha_3": ("L_z the angular momentum about", True)}),
    "Kepler, parabolic": (SEVERAL["Kepler, parabolic"], parabolic, 0, None, m * k,
                          {"alpha_2": ("Runge-Lenz vector along the axis with the coordinate (u**2 - v**2)/2", False)}),
    "Kepler, rotational parabolic": (
        make({"u": "0 < u", "v": "0 < v", "phi": "angle"}, ROTATIONAL, "-2*k/(u**2 + v**2)", "m k"), rotational, 2, None,
        m * k, {"alpha_2": ("Runge-Lenz", False)}),
    "Stark, rotational parabolic": (
        make({"u": "0 < u", "v": "0 < v", "phi": "angle"}, ROTATIONAL, "-2*k/(u**2 + v**2) + c*(u**2 - v**2)/2", "m k c"),
        rotational, 2, None, 0, {"alpha_2": ("A the component of p x L", True)}),
    "two centres, plane": (two_centres(TWO.replace("k1", "k2").replace("k2", "k1", 1)), elliptic, 0, a, 0,
                           {"alpha_2": ("problem of two centres", True)}),
    "two centres, space": (make(PROLATE_COORDINATES, PROLATE, TWO, "a m k1 k2"), prolate, 2, a, 0,
                           {"alpha_2": ("problem of two centres", True)}),
    "free motion, prolate": (make(PROLATE_COORDINATES, PROLATE, "0", "a m"), prolate, 2, a, 0,
                             {"alpha_2": ("problem of two centres", False)}),
    "prolate": (E3["6 prolate"], prolate, 2, a, 0, {"alpha_2": ("foci", True), "alpha_3": ("L_z", True)}),
    "oblate": (E3["7 oblate"], oblate, 2, None, 0, {"alpha_2": ("focal circle", True), "alpha_3": ("L_z", True)}),
    "elliptic cylinder": (E3["3 elliptic cylinder"], in_z(ELLIPTIC_PLANE), 0, a, 0,
                          {"alpha_2": ("angular momenta about the focal lines", True)}),
    "two centres, plane, x = a xi eta": (
        make({"xi": "1 < xi", "eta": "-1 < eta < 1"}, ALGEBRAIC, "-(k1*xi + k2*eta)/(a*(xi**2 - eta**2))", "a m k1 k2"),
        algebraic, 0, a, 0, {"alpha_2": ("problem of two centres", True)}),
    "two centres, space, z = a xi eta": (
        make({"xi": "1 < xi", "eta": "-1 < eta < 1", "phi": "angle"},
             f"{ALGEBRAIC} + m*a**2/2*(xi**2 - 1)*(1 - eta**2)*dot(phi)**2", "-(k1*xi + k2*eta)/(a*(xi**2 - eta**2))",
             "a m k1 k2"),
        algebraic, 2, a, 0, {"alpha_2": ("problem of two centres", True)}),
    "Kepler, x = (xi - eta)/2": (
        make({"xi": "0 < xi", "eta": "0 < eta"}, SQUARED, "-2*k/(xi + eta)", "m k"), squared, 0, None, m * k,
        {"alpha_2": ("Runge-Lenz vector along the axis with the coordinate (xi - eta)/2", False)}),
    "Stark, z = (xi - eta)/2": (
        make({"xi": "0 < xi", "eta": "0 < eta", "phi": "angle"}, f"{SQUARED} + m/2*xi*eta*dot(phi)**2",
             "-2*k/(xi + eta) + c*(xi - eta)/2", "m k c"),
        squared, 2, None, 0, {"alpha_2": ("A the component of p x L", True)}),
    "parabolic cylinder": (E3["4 parabolic cylinder"], in_z(PARABOLIC_PLANE), 0, None, 0, {"alpha_2": ("p_y", True)}),
}  # fmt: skip


def vanishes(value: sp.Expr) -> bool:
    """Exactly, where the value is rational; to 60 digits where roots of rational numbers are left."""
    if value.is_Rational:
        return value == 0
    assert value.is_number
    return bool(abs(value.evalf(30, maxn=90)) < sp.Rational(1, 10**60))


@pytest.mark.rotating(8)
@pytest.mark.parametrize("name", CASES)
def test_the_constant_is_the_integral_it_is_said_to_be(name):
    system, place, axis, distance, charge, expected = CASES[name]
    verdict = separate(system)
    assert isinstance(verdict, Separation)
    q, p = symbols(system)
    values = known(place(system), q, p, axis, distance, charge)
    for constant, (words, continued) in expected.items():
        meaning = verdict.constants[constant].meaning
        assert words in meaning
        assert (CONTINUED in meaning) == continued
        difference = compared(verdict, constant, values)
        for seed in range(2):
            first, second = (value for (value,) in exact([difference], q, p, seed))
            assert vanishes(first - second)
            assert vanishes(first) != continued


def test_the_foci_carry_the_whole_constant_of_two_centres():
    """Λ = L₁·L₂ + 2am (k₁ cos θ₁ − k₂ cos θ₂), θ at the foci from the axis (Coulson, Joseph 1967, Int. J. Quantum Chem. 1, 337)."""
    system, place, axis, _, _, _ = CASES["two centres, plane"]
    verdict = separate(system)
    q, p = symbols(system)
    x, y = place(system)
    values = known([x, y], q, p, axis, a)
    k1, k2 = sp.symbols("k1 k2", positive=True)
    u, v = q
    attracted = [(x + s * a) / (a * (sp.cosh(u) + s * sp.cos(v))) for s in (1, -1)]
    assert verdict.constants["alpha_2"].meaning.split(": ", 1)[1].startswith("L_1*L_2/2 continued")
    left = 2 * verdict.constants["alpha_2"].expression - values["L_1*L_2"]
    strengths = sp.symbols("s_1 s_2")
    residual = left - 2 * a * m * (strengths[0] * attracted[0] + strengths[1] * attracted[1])
    potentials = {
        s: sp.limit(system.potential.subs({u: 0}) * a * (1 + s * sp.cos(v)), v, 0 if s < 0 else sp.pi) for s in (1, -1)
    }
    swap = {strengths[0]: -potentials[1], strengths[1]: potentials[-1]}
    assert set(potentials.values()) == {-k1, -k2}
    for seed in range(2):
        first, second = (value for (value,) in exact([residual.subs(swap)], q, p, seed))
        assert first == second == 0


def test_conical_coordinates_carry_the_total_angular_momentum():
    """L² = r²p² − (r·p)² = 2m r² T − r² p_r², in any coordinates with r."""
    system = E3["9 conical"]
    verdict = separate(system)
    assert "-L**2/2 continued" in verdict.constants["alpha_2"].meaning
    q, p = symbols(system)
    free = hamiltonian(system) - system.potential
    squared_momentum = 2 * m * q[0] ** 2 * free - q[0] ** 2 * p[0] ** 2
    for seed in range(2):
        difference = verdict.constants["alpha_2"].expression + squared_momentum / 2
        first, second = (value for (value,) in exact([difference], q, p, seed))
        assert first == second != 0


x, y = sp.symbols("x y", positive=True)


@pytest.mark.parametrize(
    ("h", "expected"),
    [
        ((sp.S.One, sp.sin(x) ** 2), 1),
        ((sp.S.One, x**2), 0),
        ((sp.S.One, sp.sinh(x) ** 2), -1),
        ((1 / y**2, 1 / y**2), -1),
        ((4 / (1 + x**2 + y**2) ** 2, 4 / (1 + x**2 + y**2) ** 2), 1),
        (((2 + sp.cos(y)) ** 2, sp.S.One), sp.cos(y) / (2 + sp.cos(y))),
    ],
    ids=["sphere", "plane", "hyperbolic", "half-plane", "stereographic", "torus"],
)
def test_gauss_curvature_of_known_surfaces(h, expected):
    reader = Reader(h)
    found = reader.write(curvature(reader, (x, y), [reader.element(e) for e in h]))
    assert sp.simplify(found - expected) == 0


def test_a_cone_over_a_surface_that_is_no_unit_sphere_has_no_angular_momentum():
    kinetic = "m/2*(dot(r)**2 + r**2*(dot(u)**2 + sinh(u)**2*dot(v)**2))"
    system = make({"r": "0 < r", "u": "0 < u", "v": "angle"}, kinetic, "-k/r + c*cos(v)/(r*sinh(u))**2", "m k c")
    meanings = [c.meaning for c in separate(system).constants.values()]
    assert not any("angular momentum" in text and "L the" in text for text in meanings)


def test_a_part_that_moves_by_itself_is_named_with_its_energy():
    verdict = separate(E3["1 Cartesian"])
    assert verdict.constants["alpha_2"].meaning.endswith("E_y*m, E_y the energy of the motion in y")
    (x, y, z), (px, py, pz) = symbols(verdict.system)
    b = sp.Symbol("b", positive=True)
    assert sp.expand(verdict.constants["alpha_2"].expression - m * (py**2 / (2 * m) + b * y**4)) == 0


def test_an_energy_is_recognised_through_a_gauge():
    verdict = separate(SEVERAL["oscillators in a moving frame"])
    assert verdict.constants["alpha_2"].meaning.endswith("E_y*m, E_y the energy of the motion in y")
    (x, y), (px, py) = symbols(verdict.system)
    h, b = sp.symbols("h b", positive=True)
    speed = (py - b * x) / m
    assert sp.expand(verdict.constants["alpha_2"].expression - m * (m * speed**2 / 2 + h * y**4)) == 0


def test_the_ignorable_angle_of_the_spherical_pendulum_is_an_angular_momentum():
    verdict = separate(ONE_DIMENSIONAL["spherical pendulum"])
    assert verdict.constants["p_phi"].meaning.startswith("angular momentum that belongs to phi")
    l = sp.Symbol("l", positive=True)
    (θ, φ), p = symbols(verdict.system)
    place = [l * sp.sin(θ) * sp.cos(φ), l * sp.sin(θ) * sp.sin(φ), -l * sp.cos(θ)]
    velocity = [sum(sp.diff(s, q) * v for q, v in zip((θ, φ), sp.symbols("w1 w2"))) for s in place]
    L_z = m * (place[0] * velocity[1] - place[1] * velocity[0])
    w = [hamiltonian(verdict.system).diff(momentum) for momentum in p]
    assert sp.simplify(L_z.subs(dict(zip(sp.symbols("w1 w2"), w))) - p[1]) == 0


def test_the_constant_of_kerr_is_carters():
    """Q = p_θ² + cos²θ (a²(μ² − E²) + L_z²/sin²θ) with μ² = −2H, E = −p_t, L_z = p_φ (Carter 1968)."""
    verdict = separate(kerr())
    meaning = verdict.constants["alpha_2"].meaning
    assert "Q Carter's constant" in meaning
    _, θ = (c.symbol for c in verdict.shell.coordinates)
    q, p = symbols(verdict.system)
    p_t, _, p_θ, p_φ = p
    spin, H = verdict.system.symbols["a"], hamiltonian(verdict.system)
    Q = p_θ**2 + sp.cos(θ) ** 2 * (spin**2 * (-2 * H - p_t**2) + p_φ**2 / sp.sin(θ) ** 2)
    difference = compared(verdict, "alpha_2", {"Q": Q, "p_t": p_t, "p_phi": p_φ})
    assert difference.has(sp.cos(θ))
    for seed in range(2):
        assert all(value == 0 for (value,) in exact([difference], q, p, seed))


def test_a_name_is_not_given_to_a_neighbour():
    """One wrong number in the metric, and the constant is not an angular momentum any more."""
    kinetic = "m/2*(dot(r)**2 + 2*r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)"
    verdict = separate(make(SPHERICAL_COORDINATES, kinetic, "-k/r", "m k"))
    assert isinstance(verdict, Separation)
    assert verdict.constants["alpha_2"].meaning == "separation constant shared by r, theta"
