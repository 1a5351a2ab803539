"""Formulas: what is accepted means what Python means, what is refused says where and what to write."""

from __future__ import annotations

import re
from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.errors import ExpressionError
from hjsolve.formulas.read import admit, parse

x, y, r, m, k, g, theta = sp.symbols("x y r m k g theta", real=True)
NAMES = {symbol.name: symbol for symbol in (x, y, r, m, k, g, theta)}
VELOCITIES = {name: sp.Symbol(f"dot({name})", real=True) for name in ("x", "r", "theta")}


def read(text: str) -> sp.Expr:
    return parse(text, NAMES, velocities=VELOCITIES, source="potential")


def refusal(text: str) -> str:
    with pytest.raises(ExpressionError) as caught:
        read(text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m/2*(dot(r)**2 + r**2*dot(theta)**2)", m / 2 * (VELOCITIES["r"] ** 2 + r**2 * VELOCITIES["theta"] ** 2)),
        ("-k/r", -k / r),
        ("-x**2", -(x**2)),
        ("(-x)**2", x**2),
        ("2**-x", 2**-x),
        ("x**2**3", x**8),
        ("x/y/2*k", x * k / (2 * y)),
        ("x - y - k", x - y - k),
        ("--x", x),
        ("+x*-y", -x * y),
        ("0.1*x", x / 10),
        ("1.5e-3*x + .5 + 2.", 3 * x / 2000 + sp.Rational(5, 2)),
        ("pi*x", sp.pi * x),
        ("sin(x)**2 + cos(x)*tan(x)", sp.sin(x) ** 2 + sp.cos(x) * sp.tan(x)),
        ("cot(x) + sec(x) + csc(x)", sp.cos(x) / sp.sin(x) + 1 / sp.cos(x) + 1 / sp.sin(x)),
        ("coth(x) + sech(x) + csch(x)", sp.cosh(x) / sp.sinh(x) + 1 / sp.cosh(x) + 1 / sp.sinh(x)),
        ("exp(-x**2)*log(1 + x**2)", sp.exp(-(x**2)) * sp.log(1 + x**2)),
        ("sqrt(x**2 + y**2)", sp.sqrt(x**2 + y**2)),
        ("cbrt(-8) + cbrt(27)", sp.Integer(1)),
        ("asinh(x) + atan(y/x) + acosh(2)", sp.asinh(x) + sp.atan(y / x) + sp.acosh(2)),
        ("\n m*g \n * x \t", m * g * x),
        ("m/2*r^2 - x^-2", m * r**2 / 2 - x**-2),
        ("x^2^3", x**8),
        ("m r'^2/2 + r′*x’", m * VELOCITIES["r"] ** 2 / 2 + VELOCITIES["r"] * VELOCITIES["x"]),
        ("θ'^2 + thetadot + x_dot", VELOCITIES["theta"] ** 2 + VELOCITIES["theta"] + VELOCITIES["x"]),
        ("2 m g", 2 * m * g),
        ("2x - 2 pi r", 2 * x - 2 * sp.pi * r),
        ("2(x + y)(x - y)", sp.Mul(2, x + y, x - y)),
        ("m x^2 y/2", m * x**2 * y / 2),
        ("x/2*m g", m * g * x / 2),
        ("sin(x) cos(y) y", sp.sin(x) * sp.cos(y) * y),
        ("-2 m g -x", -2 * m * g - x),
        ("(x**2)**(1/3) + abs(x)**(4/3)", sp.Abs(x) ** sp.Rational(2, 3) + sp.Abs(x) ** sp.Rational(4, 3)),
        ("abs(x)**2", x**2),
    ],
)
def test_a_formula_means_what_it_says(text, expected):
    assert read(text) == expected


def test_a_sign_stays_in_front_of_a_product():
    assert str(read("-(m + k)*g*x")) == "-g*x*(k + m)"


@given(st.lists(st.tuples(st.integers(0, 99), st.sampled_from(["+", "-", "*", "/", "**-", "*(", ")-"])), max_size=12))
def test_precedence_and_values_are_those_of_python(pieces):
    text = ""
    for value, operator in pieces:
        text += str(value) if operator != "**-" else "3"
        text += "**-2*" if operator == "**-" else operator
    text += "7"
    text = "(" * max(0, text.count(")") - text.count("(")) + text + ")" * max(0, text.count("(") - text.count(")"))
    try:
        expected = eval(re.sub(r"[0-9]+", r"Fraction(\g<0>)", text), {"Fraction": Fraction})
    except (ZeroDivisionError, SyntaxError, TypeError):
        with pytest.raises(ExpressionError):
            read(text)
        return
    assert read(text) == sp.Rational(expected.numerator, expected.denominator)


HINTS = {
    "1/2 m": (5, "may be read in two ways; write /2*m or /(2*m)"),
    "x/y k": (5, "may be read in two ways; write /y*k or /(y*k)"),
    "x^2y": (4, "may be read in two ways; write **2*y or **(2*y)"),
    "x^k y": (5, "may be read in two ways; write **k*y or **(k*y)"),
    "x 2": (3, "write x*2"),
    "m g (1 - cos(x))": (3, "g is not a function; write g*(...)"),
    "x'(y)": (3, "an operator is missing"),
    "k'": (2, "'k' is not a coordinate; velocities are x', r', theta'"),
    "x''": (3, "accelerations do not occur"),
    "(x + y)'": (8, "a prime stands behind the name of a coordinate"),
    "r`": (2, "write dot(r)"),
    "dr**2": (1, "write dot(r)"),
    "atan2(y)": (1, "atan2(y, x)"),
    "atan2(y, x, r)": (11, "comma"),
    "atan2(0, 0)": (1, "has no value"),
    "cos(25*atan2(y, x))": (1, "beyond 24"),
    "(x**2)**(3/2)": (7, "absolute value"),
    "(x**2)**(1/3)*(x**2)**(1/6)": (1, "absolute value"),
    "sin x": (1, "write sin(x)"),
    "sin**2(x)": (1, "write sin(x)**2"),
    "sinx": (1, "write sin(x)"),
    "mgx": (1, "write m*g*x"),
    "dot(k)": (5, "not a coordinate"),
    "dot(r**2)": (1, "dot(q)"),
    "dot": (1, "write dot(q)"),
    "thet": (1, "did you mean theta?"),
    "Sin(x)": (1, "did you mean sin?"),
    "arctan(x)": (1, "write atan"),
    "ln(x)": (1, "write log"),
    "abs(x)": (1, "no derivative at zero"),
    "sqrt(x**2)": (1, "absolute value"),
    "k*t": (3, "explicit time"),
    "e**x": (1, "exp(x)"),
    "i*x": (1, "no imaginary unit"),
    "x = 2": (3, "no equals sign"),
    "x <= 2": (3, "domain"),
    "|x|": (1, "write abs(x)"),
    "x,5": (2, "decimal comma"),
    "sin(x, y)": (6, "one argument"),
    "sin()": (1, "needs an argument"),
    "r(x)": (1, "write r*(...)"),
    "[x]": (1, "round brackets"),
    "\\theta": (1, "backslash"),
    "θθ**2": (1, "'thetatheta' is not declared"),
    "λ": (1, "'lam' is not declared"),
    "Ω": (1, "'Omega' is not declared"),
    "ж": (1, "ASCII letters"),
    "x²": (2, "write **2"),
    "½*x": (1, "write 1/2"),
    "x−y": (2, "ASCII minus"),
    "x·y": (2, "write *"),
    "√x": (1, "write sqrt"),
    "ẋ**2": (1, "write dot(x)"),
    "r̈": (2, "write dot(r)"),
    "x₁": (2, "x1"),
    "x +": (4, "ends too early"),
    "(x": (1, "never closed"),
    "x)": (2, "never opened"),
    "x + * y": (5, "is missing"),
    "()": (2, "is missing"),
    "1 2": (3, "two numbers"),
    "x//y": (3, "is missing"),
    "x.y": (2, "write *"),
    "\x00": (1, "plain ASCII"),
}


@pytest.mark.parametrize("text", HINTS)
def test_an_error_names_the_input_the_place_and_what_to_write(text):
    column, hint = HINTS[text]
    with pytest.raises(ExpressionError) as caught:
        read(text)
    message = str(caught.value)
    assert message.startswith(f"potential, column {column}: ")
    assert hint in message
    assert "\n" not in message
    assert (caught.value.source, caught.value.position) == ("potential", column - 1)


def test_the_place_in_a_text_of_several_lines_is_a_line_and_a_column():
    assert "write x*y" in refusal("x\ny")
    assert refusal("x +\n  y²").startswith("potential, line 2, column 4: ")


def test_an_undeclared_name_lists_what_is_declared():
    assert "declared are g, k, m, r, theta, x, y" in refusal("q_17")


def test_a_declared_name_wins_over_a_hint():
    names = {name: sp.Symbol(name) for name in ("E", "I", "e", "i", "ln")}
    assert parse("E*I*e*i*ln", names, source="V") == sp.Mul(*names.values())


def test_a_velocity_is_refused_where_none_may_stand():
    with pytest.raises(ExpressionError, match="domain of r, column 5: a velocity cannot stand here"):
        parse("2 + dot(r)", NAMES, source="domain of r")


NOT_REAL_OR_NOT_FINITE = ["1/0", "x/0", "x/(y - y)", "0**-1", "0**x", "log(0)", "log(-2)", "log(-x**2)", "sqrt(-1)"]
NOT_REAL_OR_NOT_FINITE += [
    "(-8)**(1/3)",
    "(-2)**x",
    "asin(2)",
    "acosh(0)",
    "atanh(1)",
    "tan(pi/2)",
    "cot(0)",
    "csc(pi)",
]
NOT_REAL_OR_NOT_FINITE += ["sqrt(-x**2)", "1/((1 + sqrt(2))**2 - 3 - 2*sqrt(2))", "1/(sqrt(2)*sqrt(3) - sqrt(6))"]


@pytest.mark.parametrize("text", NOT_REAL_OR_NOT_FINITE)
def test_what_is_not_real_or_not_finite_is_refused(text):
    assert re.search("real|finite|zero", refusal(text))


HOSTILE = {
    "9**9**9": "beyond",
    "2**(10**6)": "beyond",
    "1e999999999": "beyond",
    "1e-99999999999999999999": "beyond",
    "1" * 5000: "digits",
    "(" * 100_000: "characters",
    "(" * 4000 + "x" + ")" * 4000: "nest",
    "x**" * 2000 + "x": "nest",
    "sin(" * 1000 + "x" + ")" * 1000: "nest",
    "x" * 1_000_000: "characters",
    "x+" * 500_000 + "x": "characters",
    "(x+y)**100000": "exponents",
    "((x*y)**100)**100": "exponents",
    "((x+y)**100)**100": "terms",
    "(x+y+r+k)**60": "terms",
    "*".join(["(x+y+1)**10"] * 30): "terms",
    "exp(10**6*log(x))": "exponents",
    "exp((x+10**19)*log(3))": "exponents",
    "3**(x+10**19)": "exponents",
    "sqrt(3)**(10**19)": "exponents",
    "(1e-300*x)**100": "beyond",
    "exp(exp(exp(100)))": "large",
    "coth(cosh(1e3))": "large",
    "asin(cos(1e300))": "large",
    "sin(atan((1e-300)**2))": "100 digits",
    "sqrt(10**200+1)": "100 digits",
    "2**1e-300": "12 decimals",
    "sinh(acosh(r**50))": "inside a function",
    "sin(cos(tan(exp(x))))": "nest",
    "log(x)**50": "exponents",
    "__import__('os').system('true')": "",
    "(lambda: 1)()": "",
    "x.__class__": "",
}


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:24])
@pytest.mark.timeout(30)
def test_a_hostile_text_ends_in_one_error(text):
    """Without the limits on what is read each of these runs for minutes or for ever."""
    message = refusal(text)
    assert HOSTILE[text] in message
    assert len(message) < 250


@pytest.mark.timeout(30)
def test_a_long_formula_is_read():
    assert read("+".join(f"{i}*x**2*sin(y)**{i % 7}" for i in range(400))).subs(y, 0).coeff(x, 2) == sum(
        range(0, 400, 7)
    )


@pytest.mark.nightly
@given(st.text(max_size=60))
def test_arbitrary_text_is_a_formula_or_an_expression_error(text):
    try:
        assert isinstance(read(text), sp.Expr)
    except ExpressionError as error:
        assert "\n" not in str(error)


PIECES = [
    "x",
    "r",
    "m",
    "dot(x)",
    "pi",
    "0",
    "1",
    "2",
    "-3",
    "0.5",
    "1e300",
    "99",
    "sin",
    "log",
    "sqrt",
    "acosh",
    "tan",
]
PIECES += list("()()()+-*/^,. '") + ["**"]


@pytest.mark.timeout(120)
@given(st.lists(st.sampled_from(PIECES), max_size=25))
def test_scrambled_formulas_are_formulas_or_expression_errors(pieces):
    try:
        expression = read("".join(pieces))
        assert not expression.has(sp.nan, sp.oo, sp.zoo, sp.I)
    except ExpressionError as error:
        assert "\n" not in str(error)


def test_reading_leaves_the_precision_of_mpmath_alone():
    before = mpmath.mp.prec
    read("sqrt(2)*sin(1)")
    assert mpmath.mp.prec == before


def test_sympy_expressions_are_taken_over_by_the_names_of_their_symbols():
    given = sp.Symbol("m", positive=True) / 2 * sp.Symbol("dot(r)") ** 2 + 0.5 * sp.cot(sp.Symbol("theta"))
    expected = m / 2 * VELOCITIES["r"] ** 2 + sp.cos(theta) / sp.sin(theta) / 2
    assert admit(given, NAMES, velocities=VELOCITIES, source="kinetic") == expected


t = sp.Symbol("t")
FOREIGN = [
    (sp.Symbol("q_17"), "'q_17' is not declared"),
    (sp.Function("r")(t).diff(t, 2), "accelerations do not occur"),
    (sp.Function("m")(t), "m is not a coordinate here, so it does not depend on t; write m"),
    (sp.Function("m")(t).diff(t), "m is not a coordinate here"),
    (sp.Function("q")(t), "'q' is not declared"),
    (sp.Function("r")(x), "Derivative(q(t), t), with nothing else in it"),
    (sp.Derivative(sp.cos(sp.Function("r")(t)), t), "Derivative(q(t), t), with nothing else in it"),
    (sp.Abs(x), "absolute values are not accepted"),
    (sp.Piecewise((x, x > 0), (0, True)), "Piecewise is not accepted"),
    (sp.Integral(x, x), "Integral is not accepted"),
    (sp.I * x, "not accepted"),
    (sp.sqrt(-(sp.Symbol("r") ** 2) - sp.Symbol("r") ** 2), "not real"),
    (sp.sqrt(sp.Symbol("r") ** 2), "absolute values"),
    (sp.Symbol("dot(k)"), "not declared"),
    (sp.Add(*(sp.Symbol("x") ** i * sp.Symbol("y") ** -i for i in range(3000))), "20000 nodes"),
]


@pytest.mark.parametrize(("expression", "message"), FOREIGN, ids=lambda value: str(type(value).__name__))
def test_a_sympy_expression_with_anything_else_is_refused(expression, message):
    with pytest.raises(ExpressionError, match=re.escape(message)) as caught:
        admit(expression, NAMES, velocities=VELOCITIES, source="kinetic")
    assert str(caught.value).startswith("kinetic: ")
    assert len(str(caught.value)) < 300


def test_what_is_not_a_text_is_refused():
    with pytest.raises(ExpressionError, match="V: expected a text, got int"):
        parse(3, NAMES, source="V")


def test_the_velocities_of_sympy_are_read_as_dynamicsymbols_makes_them():
    from sympy.physics.mechanics import dynamicsymbols

    angle, distance = dynamicsymbols("theta r")
    time = dynamicsymbols._t
    lagrangian = m / 2 * (distance.diff(time) ** 2 + distance**2 * angle.diff(time) ** 2) - m * g * sp.cos(angle)
    expected = m / 2 * (VELOCITIES["r"] ** 2 + r**2 * VELOCITIES["theta"] ** 2) - m * g * sp.cos(theta)
    assert admit(lagrangian, NAMES, velocities=VELOCITIES, source="kinetic") == expected
    assert admit(sp.Symbol("thetadot") + sp.Symbol("θ"), NAMES, velocities=VELOCITIES, source="kinetic") == (
        VELOCITIES["theta"] + theta
    )


def test_a_name_that_spells_a_velocity_is_the_name_where_it_is_declared():
    assert parse("rdot", {**NAMES, "rdot": k}, velocities=VELOCITIES, source="V") == k


POINTS = [(1.0, 0.5), (-1.0, 0.5), (-1.0, -0.5), (1.0, -0.5), (0.25, -3.0), (-2.0, 1e-3), (0.0, 1.0), (0.0, -2.0)]


@pytest.mark.parametrize(("a", "b"), POINTS)
def test_atan2_is_the_angle_of_the_point_on_all_sides(a, b):
    from math import atan2, cos, isclose, sin, tan

    angle = atan2(b, a)
    for text, value in (
        ("atan2(y, x)", angle),
        ("cos(3*atan2(y, x)) + 2", cos(3 * angle) + 2),
        ("sin(2*atan2(y, x) + k)", sin(2 * angle + 0.7)),
        ("cos(atan2(y, x)/2)", cos(angle / 2)),
        ("tan(atan2(y, 3 + x))", tan(atan2(b, 3 + a))),
    ):
        got = float(read(text).evalf(30, subs={x: sp.Rational(a), y: sp.Rational(b), k: sp.Rational("0.7")}))
        assert isclose(got, value, rel_tol=1e-12)
    assert isclose(float(read(f"atan2({b}, {a})")), angle, rel_tol=1e-14)


def test_multiples_of_the_angle_of_a_point_are_algebraic():
    assert read("cos(2*atan2(y, x))").equals((x**2 - y**2) / (x**2 + y**2))
    assert not read("cos(24*atan2(y, x)) + sin(atan2(y, x))").atoms(sp.atan, sp.cos, sp.sin)
    assert admit(sp.cos(2 * sp.atan2(y, x)), NAMES, source="V").equals((x**2 - y**2) / (x**2 + y**2))
