"""Constraints as input: the holonomic and integrable ones eliminated, the others proved not to be (C16, C72 and more)."""

from __future__ import annotations

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import parameter

L2, L3 = {"x": "line", "y": "line"}, {"x": "line", "y": "line", "z": "line"}
T2, T3 = "m/2*(dot(x)**2 + dot(y)**2)", "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
SKATE = {"x": "line", "y": "line", "theta": "angle"}
DISK = {"x": "line", "y": "line", "phi": "angle", "alpha": "angle"}
POSITIVE = {"l": parameter("l", 2, assume="positive"), "r": parameter("r", 1, assume="positive"), "m": 1, "g": 1}
PLANETARY = {"theta": "angle", "psi": "angle", "phi": "angle"}
SQUARES = {name: f"({' + '.join(f'dot({q})**2' for q in q_s)})/2" for name, q_s in
           (("skate", SKATE), ("disk", DISK), ("planetary", PLANETARY))}  # fmt: skip

INTEGRABLE = [
    ("P1-1, a circle", L2, T2, ["x**2 + y**2 = l**2"], ["theta"]),
    ("a circle off the origin", L2, T2, ["(x - 1)**2 + (y + 3)**2 = l**2"], ["theta"]),
    ("a circle whose radius has no sign", L2, T2, ["x**2 + y**2 = g**2"], ["theta"]),
    ("an ellipse", L2, T2, ["x**2/l**2 + 3*(y - 1)**2 = m**2"], ["u"]),
    ("a spheroid about x", L3, T3, ["x**2 + 2*x + (y**2 + z**2)/r**2 = 8*l"], ["u", "phi"]),
    ("P2-9, a parabola", L2, T2, ["y = 3*x**2"], ["x"]),
    ("Ex 2-11, a sphere", L3, T3, ["x**2 + y**2 + z**2 = l**2"], ["theta", "phi"]),
    ("a line", L2, T2, ["2*x + 3*y = 5"], ["x"]),
    ("a paraboloid", L3, T3, ["z = x**2 + y**2"], ["x", "y"]),
    ("two planes", L3, T3, ["x + y + z = 1", "x - y = 2"], None),
    ("P2-10 without its drift", L2, T2, ["2*dot(x) + 3*dot(y) = 0"], ["x"]),
    ("P4-8 (C72)", L3, T3, ["dot(x) - dot(y) + dot(z) = 0"], ["x", "y"]),
    ("P1-7 (C16)", PLANETARY, SQUARES["planetary"], ["dot(phi) = l/r*dot(theta) + (l + r)/r*dot(psi)"], ["theta", "psi"]),
    ("an exact form", L3, T3, ["2*x*dot(x) + dot(y) = 0"], None),
    ("an integrating factor", L3, T3, ["y*dot(z) - y*x*dot(x) = 0"], ["x", "y"]),
    ("a skate held at an angle", SKATE, SQUARES["skate"],
     ["dot(x)*cos(theta) + dot(y)*sin(theta) = 0", "theta = pi/3"], None),
]  # fmt: skip


@pytest.mark.parametrize(("name", "domains", "kinetic", "constraints", "left"), INTEGRABLE, ids=lambda x: str(x)[:24])
def test_an_integrable_constraint_is_eliminated(
    name: str, domains: dict[str, str], kinetic: str, constraints: list[str], left: list[str] | None
) -> None:
    """The constraints hold identically along the map back, and T is that of the old velocities."""
    free = hjsolve.System(domains, kinetic, 0, POSITIVE)
    system = hjsolve.System(domains, kinetic, 0, POSITIVE, constraints=constraints)
    if left is not None:
        assert [c.name for c in system.coordinates] == left
    t = sp.Symbol("t")
    moving = {c.symbol: sp.Function(c.name)(t) for c in system.coordinates}
    back = {name: system.symbols[name] for name in domains if name in system.symbols} | dict(system.eliminated)
    place = {name: f.subs(moving) for name, f in back.items()}
    values = {c: sp.Rational(i + 3, 4) for i, c in enumerate(sorted(system.symbols.values(), key=str))}
    speeds = {sp.diff(q, t): sp.Rational(5 - 2 * i, 9) for i, q in enumerate(moving.values())}

    def number(expression: sp.Expr) -> sp.Float:
        at = expression.subs(speeds).subs({q: values[s] for s, q in moving.items()})
        return sp.N(at.subs({sp.Symbol(s.name, real=True): v for s, v in values.items()}).subs(values), 40)

    names = {sp.Symbol(n): f for n, f in place.items()}
    for text in constraints:
        sides = [side.replace("dot(", "d(") for side in (*text.split("="), "0")[:2]]
        rates = {f"d({n})": f"(rate_{n})" for n in domains}
        for old, new in rates.items():
            sides = [side.replace(old, new) for side in sides]
        letters = {n: sp.Symbol(n) for n in (*domains, *POSITIVE)}
        difference = sp.sympify(sides[0], locals=letters) - sp.sympify(sides[1], locals=letters)
        put = {sp.Symbol(f"rate_{n}"): sp.diff(f, t) for n, f in place.items()}
        constants = {sp.Symbol(n): system.symbols[n] for n in POSITIVE}
        assert abs(number(difference.subs(put).subs(names).subs(constants))) < 1e-30
    old = {free.coordinate(n).velocity: sp.diff(f, t) for n, f in place.items()}
    old |= {free.symbols[n]: f for n, f in place.items()}
    new = {c.velocity: sp.diff(moving[c.symbol], t) for c in system.coordinates} | moving
    expected, found = number(free.kinetic.subs(old)), number(system.kinetic.subs(new))
    assert abs(found / expected - 1) < 1e-30


NONHOLONOMIC = [
    ("(1-17), a skate", SKATE, SQUARES["skate"], ["dot(x)*cos(theta) + dot(y)*sin(theta) = 0"]),
    ("Ex 1-2, a rolling disk", DISK, SQUARES["disk"],
     ["dot(x) - r*sin(alpha)*dot(phi) = 0", "dot(y) - r*cos(alpha)*dot(phi) = 0"]),
    ("P2-3, a rod with a knife edge", SKATE, SQUARES["skate"],
     ["sin(theta)*dot(x) - cos(theta)*dot(y) + l/2*dot(theta) = 0"]),
    ("Heisenberg", L3, T3, ["dot(z) - x*dot(y) = 0"]),
    ("a billionth from integrable", L3, T3, ["dot(z) - y*dot(x) - (x + 0.000000001*z)*dot(y) = 0"]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "domains", "kinetic", "constraints"), NONHOLONOMIC, ids=lambda x: str(x)[:24])
def test_a_nonholonomic_constraint_is_refused_with_a_witness(
    name: str, domains: dict[str, str], kinetic: str, constraints: list[str]
) -> None:
    with pytest.raises(hjsolve.InvalidSystemError, match=r"not integrable.*is not zero.*\(5-22\)-\(5-25\)"):
        hjsolve.System(domains, kinetic, 0, POSITIVE, constraints=constraints)


@pytest.mark.parametrize(("constraint", "message"), [
    ("dot(x)**2 = 1", "linear"),
    ("x*y = 1", "not solved"),
    ("x = y = 0", "one equation"),
    ("x**2 + y**2 = -1", "not solved"),
    ("x = q", "q"),
    (3, "one equation"),
])  # fmt: skip
def test_a_constraint_that_cannot_be_used(constraint: object, message: str) -> None:
    with pytest.raises(hjsolve.HJSolveError, match=message):
        hjsolve.System(L2, T2, 0, POSITIVE, constraints=[constraint])


def test_the_particle_of_problem_4_8() -> None:
    """C72: ẍ₁ = g/3, ẍ₂ = −g/3, ẍ₃ = −2g/3, from rest."""
    system = hjsolve.System(L3, T3, "m*g*z", {"m": 1, "g": "9.81"}, constraints=["dot(x) - dot(y) + dot(z) = 0"])
    solution = hjsolve.solve(system, coordinates="find")
    state = solution.motion(q={"x": 0, "y": 0}, velocity={"x": 0, "y": 0}, parameters={"c_1": 0}).at("0.5")
    x, y = float(state.q["x"]), float(state.q["y"])
    assert x == pytest.approx(9.81 / 3 / 8, rel=1e-13, abs=0)
    assert y == pytest.approx(-9.81 / 3 / 8, rel=1e-13, abs=0)
    values = {s: {"x": x, "y": y, "c_1": 0}[s.name] for s in dict(system.eliminated)["z"].free_symbols}
    assert float(dict(system.eliminated)["z"].subs(values)) == pytest.approx(-2 * 9.81 / 3 / 8, rel=1e-12, abs=0)
    assert system.place["z"] == dict(system.eliminated)["z"]


def test_a_domain_that_the_solution_may_leave() -> None:
    with pytest.raises(hjsolve.InvalidSystemError, match="stay in its domain"):
        hjsolve.System({"x": "line", "y": "0 < y"}, T2, 0, POSITIVE, constraints=["y = x"])


def test_a_bead_on_an_ellipse_has_the_period_of_its_quadrature() -> None:
    """T = m (a² sin² u + b² cos² u) u̇²/2, V = m g b sin u; the period is ∮ du/u̇."""
    wire = hjsolve.System(
        L2, T2, "m*g*y", {"m": 2, "g": "3/2", "a": 2, "b": 1}, constraints=["x**2/a**2 + y**2/b**2 = 1"]
    )
    motion = hjsolve.solve(wire).motion(q={"u": "-pi/2"}, velocity={"u": "4/5"})
    with mpmath.workdps(30):
        E = mpmath.mpf("0.64") * 2 - mpmath.mpf("1.5")
        top = mpmath.asin(E * 2 / 3) + mpmath.pi / 2  # from the lowest place; u = −π/2 + top sin a

        def rate(a: mpmath.mpf) -> mpmath.mpf:
            height = mpmath.cos(top * mpmath.sin(a))
            return top * mpmath.cos(a) * mpmath.sqrt((1 + 3 * height**2) / (2 * (E + mpmath.mpf("1.5") * height)))

        period = 4 * mpmath.quad(rate, [0, mpmath.pi / 2 - mpmath.mpf(10) ** -12])
    assert abs(motion.periods["u"].value / float(period) - 1) < 1e-10
