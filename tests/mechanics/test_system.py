"""The door: what makes a system, and what is refused and how."""

from __future__ import annotations

import pickle

import mpmath
import pytest
import sympy as sp

from hjsolve.errors import ExpressionError, InvalidInputError, InvalidSystemError, MissingValueError
from hjsolve.mechanics.system import Domain, System, mass_matrix, parameter, require_values, with_values
from tests.support.plain_systems import PLANE, kepler, oscillator, positive


def test_symbols_carry_what_the_domain_and_the_declaration_prove():
    system = System(
        {"r": "a < r", "u": "u < -a", "theta": "0 < theta < pi", "phi": "angle", "x": "-a < x < a", "z": "b < z"},
        "dot(r)**2 + dot(u)**2 + dot(theta)**2 + dot(phi)**2 + dot(x)**2 + dot(z)**2",
        parameters={"a": parameter("a", 2, assume="positive"), "b": 3},
    )
    signs = {c.name: (c.symbol.is_positive, c.symbol.is_negative) for c in system.coordinates}
    assert {name for name, sign in signs.items() if sign[0]} == {"r", "theta"}
    assert {name for name, sign in signs.items() if sign[1]} == {"u"}
    assert all(s.is_real for c in system.coordinates for s in (c.symbol, c.velocity, c.momentum))
    assert [str(s) for c in system.coordinates[:1] for s in (c.symbol, c.velocity, c.momentum)] == [
        "r",
        "dot(r)",
        "p_r",
    ]
    assert system.symbols["a"].is_positive
    assert system.symbols["b"].is_positive is None


@pytest.mark.parametrize(
    ("text", "lower", "upper"),
    [
        ("0 < x", 0, None),
        ("x > 0", 0, None),
        ("x < 3.5", None, sp.Rational(7, 2)),
        ("-1/2<x<pi/3", sp.Rational(-1, 2), sp.pi / 3),
        ("sqrt(2) > x > -1", -1, sp.sqrt(2)),
    ],
)
def test_an_inequality_is_an_open_interval(text, lower, upper):
    domain = oscillator(text).coordinate("x").domain
    assert (domain.kind, domain.lower, domain.upper) == ("interval", lower, upper)
    assert oscillator(domain.written("x")).coordinate("x").domain == domain


def test_a_line_and_an_angle_have_no_ends():
    assert oscillator("line").coordinate("x").domain == Domain("line")
    assert oscillator(" angle ").coordinate("x").domain == Domain("angle")


DOMAINS = {
    "anlge": 'did you mean "angle"?',
    "": "is not a domain",
    "0 < y": "does not bound x",
    "0 < 1 < x": "does not bound x",
    "x": "is not a domain",
    "0 < x > 1": "is not a domain",
    "x <": "is not a domain",
    "0 <= x": "domains are open",
    "0 ≤ x": "domains are open",
    "0 <= x < 2*pi": 'write "angle" for a full turn',
    "0 < x < inf": "leave out an infinite end",
    "-oo < x < 1": "leave out an infinite end",
    "1 < x < 0": "is empty",
    "a < x < b": "is empty with the values given",
    "sqrt(-a) < x": "not a finite real number with the values given",
    "0 < x < x": "does not bound x",
}


@pytest.mark.parametrize("text", DOMAINS)
def test_an_unknown_domain_is_refused(text):
    with pytest.raises(InvalidSystemError) as caught:
        oscillator(text, parameters={"a": 2, "b": 1})
    assert str(caught.value).startswith("domain of x: ")
    assert DOMAINS[text] in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"), [("0 < x < q", "'q' is not declared"), ("1/2 a < x", "write /2*a or /(2*a)")]
)
def test_a_bound_that_is_no_formula_is_refused_at_its_place(text, message):
    with pytest.raises(ExpressionError, match="domain of x, column") as caught:
        oscillator(text, parameters={"a": 1})
    assert message in str(caught.value)


NAMES = {
    "lambda": "write lam",
    "class": "write class_",
    "1x": "ASCII letter",
    "x y": "ASCII letter",
    "ж": "ASCII letter",
    "": "ASCII letter",
    "_x": "ASCII letter",
    "x" * 41: "at most 40",
    "sin": "taken",
    "pi": "taken",
    "dot": "taken",
    "alpha_2": "constants of the solution",
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("role", ["coordinate", "parameter"])
def test_a_name_that_cannot_be_used_is_refused(name, role):
    coordinates, parameters = {"x": "line"}, {}
    (coordinates if role == "coordinate" else parameters)[name] = "line" if role == "coordinate" else 1
    with pytest.raises(InvalidSystemError) as caught:
        System(coordinates, "dot(x)**2", parameters=parameters)
    assert str(caught.value).startswith(role)
    assert NAMES[name] in str(caught.value)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ({"x": 1}, "x is both a coordinate and a parameter"),
        ({"p_x": 1}, "p_x is the name of the momentum of x"),
        ({"t": 1}, "t is the time"),
        ({3: 1}, "a name must be a text"),
        (["m"], "expected a mapping"),
        ({"m": parameter("k")}, "m is given the parameter k"),
    ],
)
def test_clashing_names_are_refused(names, message):
    with pytest.raises(InvalidSystemError, match=message):
        oscillator(parameters=names)


def test_a_momentum_name_is_no_coordinate():
    with pytest.raises(InvalidSystemError, match="p_x is the name of the momentum of x"):
        System({"x": "line", "p_x": "line"}, "dot(x)**2 + dot(p_x)**2")


PARTS = {
    "potential: 'q' is not declared": {"potential": sp.Symbol("q")},
    "potential, column 2: 'q' is not declared": {"potential": "-q*r"},
    "kinetic, column 17: 'z' is not a coordinate": {"kinetic": "dot(r)**2 + dot(z)"},
    "T must be a polynomial of second degree": {"kinetic": PLANE + " + dot(r)**4"},
    "m*sqrt(1 - dot(r)**2) is not quadratic": {"kinetic": PLANE + " + m*sqrt(1 - dot(r)**2)"},
    "is not quadratic in the velocities": {"kinetic": PLANE + " + 1/dot(r)"},
    "dot(theta) does not occur in T": {"kinetic": "m/2*dot(r)**2"},
    "potential: V depends on dot(theta)": {"potential": "dot(theta)"},
    "belongs into kinetic": {"potential": "r*dot(theta)"},
    "signature: 'wrong' is unknown": {"signature": "wrong"},
    "coordinates: at least one is needed": {"coordinates": {}},
    "coordinates: expected a mapping": {"coordinates": ["r", "theta"]},
    "parameters: expected a mapping": {"parameters": "m"},
    "domain of r: expected a text": {"coordinates": {"r": None, "theta": "angle"}},
    "kinetic: expected a formula": {"kinetic": None},
    "potential: expected a formula": {"potential": [1]},
    "kinetic: the text is empty": {"kinetic": " "},
    "parameter m: expected one finite real number, got bool": {"parameters": {"m": True, "k": 1}},
    "parameter m: expected one finite real number, got float nan": {"parameters": {"m": float("nan"), "k": 1}},
    "parameter m, column 3: a value is a number alone, without a unit": {"parameters": {"m": "2 kg", "k": 1}},
}


@pytest.mark.parametrize("message", PARTS)
def test_parts_that_make_no_system_are_refused(message):
    with pytest.raises(InvalidInputError) as caught:
        kepler(**PARTS[message])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


INDEFINITE = [
    ({"r": "0 < r", "theta": "angle"}, "m/2*(dot(r)**2 - r**2*dot(theta)**2)", {"m": 1}, "dot(theta)**2/2, -m*r**2,"),
    ({"x": "line"}, "m/2*dot(x)**2", {"m": -1}, "dot(x)**2/2, m, is -1 at m = -1"),
    ({"x": "line"}, "m/2*dot(x)**2", {"m": 0}, "dot(x)**2/2, m, is 0 at m = 0"),
    ({"x": "line"}, "x*dot(x)**2/2", {}, "dot(x)**2/2, x, is -"),
    ({"x": "-1 < x < 1"}, "(1 - 2*x)*dot(x)**2/2", {}, "1 - 2*x, is -"),
    ({"x": "line", "y": "line"}, "(dot(x) + dot(y))**2", {}, "the leading minor of dot(x), dot(y) is 0"),
    ({"x": "line", "y": "line"}, "dot(x)**2 + dot(y)**2 + 3*dot(x)*dot(y)", {}, "minor of dot(x), dot(y) is -5"),
    ({"x": "line", "y": "line"}, "dot(x)*dot(y)", {}, "the coefficient of dot(x)**2/2, 0, is 0"),
    ({"x": "line"}, "-m*dot(x)**2", {"m": parameter("m", assume="positive")}, "-2*m, is -"),
    ({"x": "0 < x"}, "sin(x)*dot(x)**2", {}, "is -"),
]


@pytest.mark.parametrize(("coordinates", "kinetic", "parameters", "message"), INDEFINITE)
def test_a_kinetic_energy_that_is_not_positive_definite_is_refused(coordinates, kinetic, parameters, message):
    with pytest.raises(InvalidSystemError, match="T must be positive definite") as caught:
        System(coordinates, kinetic, parameters=parameters)
    assert message in str(caught.value)


def test_the_point_where_the_kinetic_energy_is_negative_lies_in_the_domain():
    with pytest.raises(InvalidSystemError) as caught:
        System({"x": "2 < x < 3", "y": "line"}, "dot(x)**2 + (5/2 - x)*dot(y)**2")
    x = mpmath.mpf(str(caught.value).split("x = ")[1].split(";")[0].split(",")[0])
    assert 2.5 < x < 3


def test_a_kinetic_energy_that_is_not_real_in_the_domain_is_refused():
    with pytest.raises(InvalidSystemError, match=r"T is not real at x = .*; narrow the domain"):
        oscillator("-2 < x < 2", "dot(x)**2/sqrt(1 - x**2)")
    oscillator("-1 < x < 1", "dot(x)**2/sqrt(1 - x**2)")


POSITIVE = [
    ({"x": "line"}, "m*dot(x)**2/2", {"m": None}),
    ({"x": "line"}, "-m*dot(x)**2/2", {"m": None}),
    ({"x": "line"}, "(a - b)*dot(x)**2/2", {"a": None, "b": None}),
    ({"x": "b < x < c"}, "(x - b)*(c - x)*(a - b)*(a - c)*dot(x)**2", dict.fromkeys("abc")),
    ({"x": "-pi/2 < x < pi/2"}, "cos(x)*dot(x)**2", {}),
    ({"x": "line"}, "(1 - tanh(x**2)**2)*dot(x)**2", {}),
    ({"x": "line"}, "exp(x**3)*dot(x)**2", {}),
    ({"x": "line", "y": "angle"}, "dot(x)**2 + x**2*dot(y)**2", {}),
    ({"x": "line", "y": "line"}, "a*(dot(x) - sin(y)*dot(y))**2 + b*cos(y)**2*dot(y)**2", {"a": "1e30", "b": "1e-30"}),
]


@pytest.mark.parametrize(("coordinates", "kinetic", "parameters"), POSITIVE)
def test_a_positive_kinetic_energy_is_accepted(coordinates, kinetic, parameters):
    assert System(coordinates, kinetic, parameters=parameters).signature == "definite"


def test_an_indefinite_kinetic_energy_must_not_be_degenerate():
    System({"x": "line", "y": "line"}, "dot(x)**2 - dot(y)**2", signature="indefinite")
    with pytest.raises(InvalidSystemError, match="T is degenerate"):
        System({"x": "line", "y": "line"}, "(dot(x) + dot(y))**2", signature="indefinite")


def test_a_polynomial_that_is_quadratic_once_expanded_is_accepted():
    assert mass_matrix(oscillator(kinetic="(dot(x)**2 + 1)**2/2 - dot(x)**4/2"))[0] == 2


def test_sympy_expressions_make_the_same_system_as_text():
    r, speed, turn = sp.symbols("r dot(r) dot(theta)")
    m, k = sp.symbols("m k", positive=True)
    assert kepler(kinetic=m / 2 * (speed**2 + r**2 * turn**2), potential=-k / r) == kepler()


def test_systems_are_equal_by_value_and_hashable():
    assert kepler() == kepler()
    assert hash(kepler()) == hash(kepler())
    for change in ({"potential": "-2*k/r"}, {"parameters": {"m": 1, "k": 3}}, {"title": "Kepler"}):
        assert kepler(**change) != kepler()
    assert pickle.loads(pickle.dumps(kepler())) == kepler()


def test_a_system_cannot_be_changed():
    with pytest.raises(AttributeError):
        kepler().potential = sp.S.Zero


def test_an_unknown_coordinate_is_refused_with_the_nearest_name():
    assert kepler().coordinate("r").name == "r"
    with pytest.raises(InvalidSystemError, match=r"'teta' is not a coordinate of the system; did you mean theta\?"):
        kepler().coordinate("teta")


def test_values_are_exact():
    system = kepler(parameters={"m": "0.1", "k": 0.1})
    assert [str(value) for value in system.defaults.values()] == ["1/10", "3602879701896397/36028797018963968"]


@pytest.mark.parametrize(
    ("assume", "good", "bad"),
    [
        ("positive", "1e-300", 0),
        ("negative", -1, 0),
        ("nonnegative", 0, "-1e-300"),
        ("nonzero", "-pi", "sin(pi)"),
        ("positive", "sqrt(2) - 1", "1 - sqrt(2)"),
    ],
)
def test_a_value_must_agree_with_its_assumption(assume, good, bad):
    assert parameter("k", good, assume=assume).assume == assume
    with pytest.raises(InvalidSystemError, match=f"parameter k = .*: it must be {assume}"):
        parameter("k", bad, assume=assume)


def test_an_unknown_assumption_is_refused():
    with pytest.raises(InvalidSystemError, match="write one of real, positive, negative, nonnegative, nonzero"):
        parameter("k", assume="k > 0")


def test_other_values_make_another_system_and_leave_the_first():
    system = kepler()
    other = with_values(system, {"k": "1/3"})
    assert (other.defaults[other.symbols["k"]], system.defaults[system.symbols["k"]]) == (sp.Rational(1, 3), 2)
    assert other == kepler(parameters={"m": 1, "k": "1/3"})
    assert with_values(system, {}) == system
    assert with_values(system, {"k": None}).defaults == {system.symbols["m"]: 1}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kk": 1}, "'kk' is not a parameter of the system; did you mean k?"),
        ({"m": -1}, "parameter m = -1: it must be positive"),
        ({"a": -1}, "parameter a = -1: it must be positive"),
        ({"b": -1}, "it must be positive"),
        ({"m": "x"}, "'x' is not declared"),
    ],
)
def test_other_values_are_checked_like_the_first(values, message):
    system = oscillator("-a < x < a", "m/2*dot(x)**2", parameters={"m": 1, "k": 1, "a": 1, **positive("b")})
    with pytest.raises(InvalidInputError) as caught:
        with_values(system, values)
    assert message in str(caught.value)


def test_missing_values_are_listed_all_at_once():
    system = kepler(parameters={"m": None, "k": None}, potential="-k/r")
    with pytest.raises(MissingValueError, match=r'no value for m, k; give parameters=\{"m": …, "k": …\}'):
        require_values(system)
    assert require_values(with_values(system, {"k": 2, "m": 1}))[system.symbols["k"]] == 2
    with pytest.raises(MissingValueError, match="no value for m;"):
        require_values(with_values(system, {"k": 2}))
