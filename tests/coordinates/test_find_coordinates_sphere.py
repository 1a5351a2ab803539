"""Webs on the sphere, against potentials from papers, the pulled back metric, and equations of motion in x, y, z."""

from random import Random

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import hjsolve
from hjsolve.coordinates.find import find_coordinates
from hjsolve.errors import InvalidSystemError

X, Y, Z = "(sin(theta)*cos(phi))", "(sin(theta)*sin(phi))", "cos(theta)"
ANGLES = {"theta": "0 < theta < pi", "phi": "angle"}
ROUND = "(dot(theta)**2 + sin(theta)**2*dot(phi)**2)/2"
NEUMANN = f"({X}**2 + 2*{Y}**2 + 4*{Z}**2)/2"


def on_sphere(V, parameters=None):
    return hjsolve.System(ANGLES, ROUND, V, parameters or {})


def random_rotation(source):
    """A rational rotation by Cayley's formula."""
    a, b, c = (sp.Rational(source.randint(-5, 5), source.randint(1, 4)) for _ in range(3))
    skew = sp.Matrix([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    return (sp.eye(3) - skew).inv() * (sp.eye(3) + skew)


def seen_from(rotation):
    """The three coordinates of a point along turned axes, in θ and φ."""
    return [f"({a}*{X} + ({b})*{Y} + ({c})*{Z})" for a, b, c in rotation.tolist()]


def assert_same_system(web, system):
    """T and V of the web are those of the system, drawn back by the transformation: at points, to 25 digits."""
    new, old = web.system, system
    u = [new.symbols[name] for name in web.coordinates]
    rates = [new.symbols[f"dot({name})"] if f"dot({name})" in new.symbols else new.coordinate(name).velocity
             for name in web.coordinates]  # fmt: skip
    moved = {old.coordinate(name).symbol: e for name, e in web.transformation.items()}
    speeds = {
        old.coordinate(name).velocity: sum(sp.diff(e, s) * r for s, r in zip(u, rates, strict=True))
        for name, e in web.transformation.items()
    }
    source = Random(5)
    compared = 0
    for _ in range(8):
        at = {s: sp.Rational(source.randint(5, 140), 100) for s in u}
        at |= {r: sp.Rational(source.randint(-99, 99), 50) for r in rates}
        for ours, theirs in ((new.potential, old.potential), (new.kinetic, old.kinetic)):
            carried = theirs.subs({**moved, **speeds}, simultaneous=True)
            expected, found = carried.subs(at).evalf(30), ours.subs(at).evalf(30)
            assert abs(found - expected) <= sp.Float("1e-25") * (1 + abs(expected))
            compared += 1
    assert compared == 16


@pytest.mark.nightly_cases(
    "((sin(theta)*cos(phi))**2 + 2*(sin(theta)*sin(phi))**2 + 4*cos(theta)**2)/2-kinds0-2",
    "(sin(theta)*cos(phi)) + 2*cos(theta)-kinds4-2", "0-kinds5-6",
    "1/(2*(sin(theta)*cos(phi))**2) + 1/(3*(sin(theta)*sin(phi))**2) + 1/cos(theta)**2-kinds3-3",
    "potential1-kinds1-2", "tan(theta)**2/2-kinds2-4",
)  # fmt: skip
@pytest.mark.parametrize(
    ("potential", "kinds", "integrals"),
    [
        (NEUMANN, {"conical": 1}, 2),  # C. Neumann, J. reine angew. Math. 56 (1859)
        (f"{NEUMANN} + 1/(4*{X}**2) + 1/(3*{Y}**2)", {"conical": 1}, 2),  # Rosochatius
        ("tan(theta)**2/2", {"conical": 1, "spherical": 2}, 4),  # Higgs, J. Phys. A 12 (1979) 309
        (f"1/(2*{X}**2) + 1/(3*{Y}**2) + 1/{Z}**2", {"conical": 1, "spherical": 3}, 3),  # Smorodinsky–Winternitz
        (f"{X} + 2*{Z}", {"spherical": 1}, 2),  # a homogeneous field
        ("0", {"conical": 1, "spherical": 1}, 6),
        (f"{X}**3 + {Y}*{Z}**2 + {X}*{Y}", {}, 1),
    ],
)
def test_potentials_from_papers(potential, kinds, integrals):
    system = on_sphere(potential)
    found = find_coordinates(system)
    assert {k: [w.kind for w in found.webs].count(k) for k in found.kinds} == kinds
    assert (found.kernel_dimension, found.complete) == (integrals, True)
    assert all(web.certified for web in found.webs)
    for web in found.webs:
        assert_same_system(web, system)


@pytest.mark.nightly
def test_coulomb_has_its_pole_and_a_family():
    found = find_coordinates(on_sphere("-cos(theta)/sin(theta)"))  # Schrödinger 1940; four integrals, energy included
    assert found.kernel_dimension == 4
    spherical = next(web for web in found.webs if web.kind == "spherical")
    assert spherical.certified
    assert spherical.axes[2] == (0, 0, 1)
    assert next(web for web in found.webs if web.kind == "conical").freedom == 2


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(2))
def test_axes_turned_at_random_are_found(seed):
    source = Random(seed)
    rotation = random_rotation(source)
    a, b, c = seen_from(rotation)
    web = find_coordinates(on_sphere(f"{a}**2 + 3*{b}**2 + 7*{c}**2 + {seed}*{a}**4")).webs
    if seed:  # a fourth power alone does not belong to the web
        assert web == ()
        web = find_coordinates(on_sphere(f"{a}**2 + 3*{b}**2 + 7*{c}**2 + {seed}/{a}**2")).webs
    (web,) = web
    assert web.kind == "conical"
    assert web.certified
    rows = [tuple(row) for row in rotation.tolist()]
    assert all(any(axis in (row, tuple(-x for x in row)) for row in rows) for axis in web.axes)


@pytest.mark.nightly_cases(

    "coordinates2-18*(dot(x)**2 + dot(y)**2)/(1 + (x - 1)**2 + y**2)**2-((x - 1)**2 + 3*y**2)/(1 + (x - 1)**2 + y**2)**2",
)  # fmt: skip
@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential"),
    [
        ({"b": "-pi/2 < b < pi/2", "l": "angle"}, "(dot(b)**2 + cos(b)**2*dot(l)**2)/2", "sin(b)**2 + cos(b)**2*cos(l)**2/3"),
        ({"q": "line", "l": "angle"}, "(dot(q)**2 + dot(l)**2)/cosh(q)**2/2", "tanh(q)**2 + cos(l)**2/cosh(q)**2/3"),
        ({"x": "line", "y": "line"}, "18*(dot(x)**2 + dot(y)**2)/(1 + (x - 1)**2 + y**2)**2",
         "((x - 1)**2 + 3*y**2)/(1 + (x - 1)**2 + y**2)**2"),
        ({"r": "0 < r < 1", "l": "angle"}, "(dot(r)**2/(1 - r**2) + r**2*dot(l)**2)/2", "r**2*(cos(l)**2 + 3*sin(l)**2)"),
        ({"l": "angle", "b": "0 < b < pi"}, "m*R**2*(dot(b)**2 + sin(b)**2*dot(l)**2)/2", "m*R*cos(b)**2 + 3*m*R*sin(b)**2*cos(l)**2"),
    ],
)  # fmt: skip
def test_any_coordinates_of_the_sphere(coordinates, kinetic, potential):
    parameters = {name: None for name in ("m", "R") if name in kinetic}
    found = find_coordinates(hjsolve.System(coordinates, kinetic, potential, parameters))
    assert found.kinds == ("conical",)
    assert found.webs[0].certified


@pytest.mark.nightly
def test_a_motion_of_neumann_is_that_of_the_equations_in_space():
    """ẍ = −∇V + (x·∇V − |ẋ|²) x, integrated; the motion goes through all octants."""
    (web,) = find_coordinates(on_sphere(NEUMANN)).webs
    start = {"chi": "0.3", "psi": "0.7"}, {"chi": "1.9", "psi": "-1.3"}
    state = hjsolve.solve(web.system).motion(q=start[0], velocity=start[1]).at(np.linspace(0, 20, 41))
    u = [web.system.symbols[name] for name in web.coordinates]
    place = sp.Matrix([web.system.place[axis] for axis in "xyz"])
    at = dict(zip(u, (sp.Rational(start[0][name]) for name in web.coordinates), strict=True))
    rates = sp.Matrix([sp.Rational(start[1][name]) for name in web.coordinates])
    x0 = np.array(place.subs(at).evalf(20).tolist(), dtype=float).ravel()
    v0 = np.array((place.jacobian(u).subs(at) * rates).evalf(20).tolist(), dtype=float).ravel()
    stiffness = np.array([1.0, 2.0, 4.0])

    def rate(_, s):
        x, v = s[:3], s[3:]
        force = stiffness * x
        return np.concatenate([v, -force + (x @ force - v @ v) * x])

    twin = solve_ivp(rate, (0, 20), np.concatenate([x0, v0]), method="DOP853", rtol=1e-13, atol=1e-15,
                     t_eval=np.linspace(0, 20, 41)).y[:3]  # fmt: skip
    ours = np.array([state.place[axis] for axis in "xyz"])
    assert np.max(np.abs(ours - twin)) < 2e-10
    assert max(np.max(state.error.place[axis]) for axis in "xyz") < 1e-11
    assert len({tuple(octant) for octant in (twin.T > 0).tolist()}) >= 4


@pytest.mark.nightly
def test_special_values_of_the_parameters():
    found = find_coordinates(on_sphere(f"a*{X}**2 + b*{Y}**2 + c*{Z}**2", {"a": 1, "b": 2, "c": 4}))
    a = sp.Symbol("a", real=True)
    assert found.special[0].kernel_dimension == 6
    assert {name: str(e) for name, e in found.special[0].conditions.items()} == {"b": str(a), "c": str(a)}


@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential", "says"),
    [
        ({"x": "line", "y": "0 < y"}, "(dot(x)**2 + dot(y)**2)/y**2/2", "x**2/y", "hyperbolic plane"),
        ({"theta": "angle", "phi": "angle"}, ROUND, X, "not in coordinates that are read"),
        (ANGLES, "((cos(theta)**2 + 2*sin(theta)**2)*dot(theta)**2 + sin(theta)**2*dot(phi)**2)/2", X, "is an angle"),
    ],
)
def test_what_is_no_sphere_is_refused(coordinates, kinetic, potential, says):
    with pytest.raises(InvalidSystemError, match=says):
        find_coordinates(hjsolve.System(coordinates, kinetic, potential))
