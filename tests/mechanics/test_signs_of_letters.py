"""Signs that follow from T and from the domains: of which letters, of which not, and what later values may be."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve import InvalidInputError, System, parameter
from hjsolve.errors import InvalidSystemError
from hjsolve.mechanics.system import with_values


def assumed(system: System) -> dict[str, str]:
    return {p.name: p.assume for p in system.parameters}


@pytest.mark.parametrize(
    ("domain", "kinetic", "expected"),
    [
        ("line", "m*dot(x)**2/2", {"m": "positive"}),
        ("line", "m*l**2*dot(x)**2/2", {"m": "positive", "l": "real"}),
        ("line", "m*(1 + 4*a**2*x**2)*dot(x)**2/2", {"m": "positive", "a": "real"}),
        ("line", "m*cosh(x/a)**2*dot(x)**2/2", {"m": "positive", "a": "real"}),
        ("line", "dot(x)**2/(2*m**3)", {"m": "positive"}),
        ("line", "(m + n)*dot(x)**2/2", {"m": "real", "n": "real"}),
        ("line", "m*n*dot(x)**2/2", {"m": "real", "n": "real"}),
        ("0 < x < a", "m*a*dot(x)**2/2", {"m": "positive", "a": "positive"}),
        ("-pi/a < x < pi/a", "m*dot(x)**2/2", {"m": "positive", "a": "positive"}),
        ("a < x < b", "dot(x)**2/2", {"a": "real", "b": "real"}),
    ],
)
def test_signs_that_are_needed(domain, kinetic, expected):
    values = dict.fromkeys(expected, 1) | ({"b": 2} if "b" in expected else {})
    assert assumed(System({"x": domain}, kinetic, 0, values)) == expected


def test_a_factor_that_must_be_negative():
    system = System({"x": "-1 < x < 0"}, "k*x*dot(x)**2/2", 0, {"k": None})
    assert assumed(system) == {"k": "negative"}


def test_what_was_declared_stays_and_no_sign_is_needed_of_an_indefinite_metric():
    system = System({"x": "line"}, "m*dot(x)**2/2", 0, {"m": parameter("m", 1, assume="integer")})
    assert assumed(system) == {"m": "integer"}
    system = System({"t": "line", "x": "line"}, "-m*dot(t)**2 + dot(x)**2", 0, {"m": 1}, signature="indefinite")
    assert assumed(system) == {"m": "real"}


def test_a_value_of_the_other_sign_is_refused_with_the_coefficient():
    with pytest.raises(InvalidSystemError, match="T must be positive definite: the coefficient of dot"):
        System({"x": "line"}, "m*dot(x)**2/2", 0, {"m": -1})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"m": -1}, "m must be positive, not -1"),
        ({"n": -3}, r"T must be positive definite.*, n \+ r, is -2"),
        ({"a": -1}, "a must be positive"),
        ({"c": 2}, "c must be negative"),
        ({"d": 0}, "d must be nonzero"),
        ({"b": -9}, "is empty with the values given"),
    ],
)
def test_values_for_one_motion_are_checked_as_those_of_the_system(values, message):
    T = "m*dot(x)**2/2 + (n + r)*dot(y)**2/2 + dot(z)**2/2"
    signs = {"c": parameter("c", -1, assume="negative"), "d": parameter("d", 1, assume="nonzero")}
    domain = {"x": "-a < x < a", "y": "line", "z": "c < z < b"}
    system = System(domain, T, "x**2 + y**2 + d*z**2", {"m": 1, "n": 1, "r": 1, "a": 1, "b": 1, **signs})
    start = {"q": {"x": 0, "y": 0, "z": 0}, "p": {"x": "1/2", "y": 1, "z": "1/2"}}
    solution = hjsolve.solve(system)
    solution.motion(**start)
    with pytest.raises(InvalidInputError, match=message):
        solution.motion(**start, parameters=values)
    with pytest.raises(InvalidInputError):
        with_values(system, values)


def test_forms_hold_no_sign_of_a_mass():
    solution = hjsolve.solve(System({"x": "line"}, "m*dot(x)**2/2", "k*x**2/2", {"m": 2, "k": 3}))
    (form,) = (one for one in hjsolve.closed_forms(solution) if "x" in one.frequencies)
    k, m = (solution.system.symbols[name] for name in "km")
    assert m.is_positive
    assert not form.named()["time_law"].has(sp.sign, sp.Abs)
    assert sp.simplify(form.frequencies["x"] ** 2 - k / m) == 0
