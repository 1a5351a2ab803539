"""Coordinates typed by the user: T and V at points against the old ones, and maps that are not regular."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import parameter

FLAT = hjsolve.System(
    {"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2) + b*(x*dot(y) - y*dot(x)) + x**2", "-k/sqrt(x**2 + y**2)",
    {"m": 1, "k": 1, "b": 1, "c": parameter("c", 1, assume="positive")},
)  # fmt: skip
SPACE = hjsolve.System(
    {"x": "line", "y": "line", "z": "line"}, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)", "k*z - x*y", {"m": 1, "k": 1}
)
SPHERICAL = {"x": "r*sin(theta)*cos(phi)", "y": "r*sin(theta)*sin(phi)", "z": "r*cos(theta)"}
REGULAR = [
    (FLAT, {"x": "r*cos(phi)", "y": "r*sin(phi)"}, {"r": "0 < r", "phi": "angle"}),
    (FLAT, {"x": "(u**2 - v**2)/2", "y": "u*v"}, {"u": "0 < u", "v": "line"}),
    (FLAT, {"x": "c*cosh(mu)*cos(nu)", "y": "c*sinh(mu)*sin(nu)"}, {"mu": "0 < mu", "nu": "0 < nu < pi"}),
    (FLAT, {"x": "u + 2*v", "y": "u - v"}, {"u": "line", "v": "line"}),
    (SPACE, SPHERICAL, {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"}),
]


@pytest.mark.parametrize(("system", "place", "domains"), REGULAR)
def test_t_and_v_are_those_of_the_old_coordinates(
    system: hjsolve.System, place: dict[str, str], domains: dict[str, str]
) -> None:
    """L at a point and a velocity: the chain rule in numbers, of the texts themselves, against the new formulas."""
    new = hjsolve.change_coordinates(system, place, coordinates=domains)
    values = {name: sp.Rational(3 + 2 * i, 7) for i, name in enumerate(sorted(new.symbols))}
    speeds = {name: sp.Rational(5 - 3 * i, 11) for i, name in enumerate(domains)}
    t = sp.Symbol("t")
    moved = {
        n: sp.sympify(f).subs({sp.Symbol(q): values[q] + speeds[q] * t for q in domains}) for n, f in place.items()
    }
    at = {sp.Symbol(n): v for n, v in values.items()}
    numbers = {system.symbols[n]: f.subs(at).subs(t, 0) for n, f in moved.items()}
    numbers |= {system.coordinate(n).velocity: sp.diff(f, t).subs(t, 0).subs(at) for n, f in moved.items()}
    numbers |= {p.symbol: values[p.name] for p in system.parameters}
    own = {new.symbols[n]: v for n, v in values.items()} | {new.coordinate(n).velocity: v for n, v in speeds.items()}
    for old, transformed in ((system.kinetic, new.kinetic), (system.potential, new.potential)):
        expected, found = sp.N(old.subs(numbers), 40), sp.N(transformed.subs(own), 40)
        assert abs(found / expected - 1) < 1e-30


def test_the_new_system_separates_as_the_typed_one() -> None:
    """Spherical coordinates of a central field, against the catalog's own entry in them."""
    flat = hjsolve.System(
        {"x": "line", "y": "line", "z": "line"}, "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)",
        "-k/sqrt(x**2 + y**2 + z**2)", {"m": 1, "k": 1},
    )  # fmt: skip
    new = hjsolve.change_coordinates(flat, SPHERICAL, coordinates=REGULAR[-1][2])
    assert isinstance(hjsolve.separate(new), hjsolve.Separation)
    assert str(sp.expand(new.kinetic)) == str(sp.expand(hjsolve.catalog.load("kepler-spherical").kinetic))
    assert new.place["z"] == new.symbols["r"] * sp.cos(new.symbols["theta"])


REFUSED = [
    ({"x": "(u**2 - v**2)/2", "y": "u*v"}, {"u": "line", "v": "line"}, "not proved"),
    ({"x": "r*cos(phi)", "y": "r*sin(phi)"}, {"r": "line", "phi": "angle"}, "changes its sign"),
    ({"x": "u", "y": "2*u"}, {"u": "line", "v": "line"}, "dependent"),
    ({"x": "u"}, {"u": "line", "v": "line"}, "each of x, y"),
    ({"x": "u", "y": "u"}, {"u": "line"}, "2 new ones"),
    ({"x": "u", "y": "w"}, {"u": "line", "v": "line"}, "w"),
]


@pytest.mark.parametrize(("place", "domains", "message"), REFUSED)
def test_a_change_that_is_refused(place: dict[str, str], domains: dict[str, str], message: str) -> None:
    with pytest.raises(hjsolve.HJSolveError, match=message):
        hjsolve.change_coordinates(FLAT, place, coordinates=domains)


def test_an_old_domain_must_be_kept() -> None:
    half = hjsolve.System({"r": "0 < r", "z": "line"}, "dot(r)**2 + dot(z)**2", "r*z")
    with pytest.raises(hjsolve.InvalidSystemError, match="domain of r"):
        hjsolve.change_coordinates(half, {"r": "u + v", "z": "u - v"}, coordinates={"u": "0 < u", "v": "line"})
    new = hjsolve.change_coordinates(half, {"r": "u + v", "z": "u - v"}, coordinates={"u": "0 < u", "v": "0 < v"})
    assert sp.expand(new.potential) == new.symbols["u"] ** 2 - new.symbols["v"] ** 2
