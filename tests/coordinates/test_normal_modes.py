"""Normal modes: the book's systems by their exact frequencies and ratios, and what must hold for any of them."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve import InvalidSystemError, Separation, System, normal_modes
from hjsolve.coordinates.small_oscillations import NormalModes
from hjsolve.mechanics.system import mass_matrix

LINES2 = {"a": "line", "b": "line"}
ONE = {"m": 1, "l": 1, "g": 1}

# Greenwood, Classical Dynamics: system, ω², columns of the modal matrix, M_kk/M_11 where the book has them
BOOK = {
    "C23b double pendulum, small motion (2-66)": (
        System(LINES2, "m*l**2/2*(2*dot(a)**2 + dot(b)**2 + 2*dot(a)*dot(b))", "m*g*l/2*(2*a**2 + b**2)", ONE),
        ["g/l*(2 - sqrt(2))", "g/l*(2 + sqrt(2))"], [["1", "sqrt(2)"], ["1", "-sqrt(2)"]],
    ),
    "C32 pendulum on a sliding block (Ex 2-12)": (
        System({"x": "line", "th": "line"}, "3/2*m*dot(x)**2 + m*l*dot(x)*dot(th) + m*l**2*dot(th)**2/2", "m*g*l*th**2/2", ONE),
        ["0", "3*g/(2*l)"], [["1", "0"], ["1", "-3/l"]],
    ),
    "C43b tube pendulum (P2-13b)": (
        System({"th": "line", "ph": "line"}, "m*r**2/2*(6*dot(th)**2 + 4*dot(th)*dot(ph) + dot(ph)**2)",
               "m*g*r/2*(3*th**2 + 2*th*ph + ph**2)", {"m": 1, "r": 1, "g": 1}),
        ["g/(2*r)", "2*g/r"], [["1", "0"], ["1", "-3"]],
    ),
    "C45 three particles on an elastic rod (P2-15)": (
        System({"y1": "line", "y2": "line", "y3": "line"}, "m/2*(dot(y1)**2 + dot(y2)**2 + dot(y3)**2)",
               "k/2*(y1 - 2*y2 + y3)**2", {"m": 1, "k": 1}),
        ["0", "0", "6*k/m"], [["1", "1", "1"], ["1", "0", "-1"], ["1", "-2", "1"]],
    ),
}  # fmt: skip

TRIPLE = System(
    {"a": "line", "b": "line", "c": "line"},
    "m*l**2/2*(3*dot(a)**2 + 2*dot(b)**2 + dot(c)**2 + 4*dot(a)*dot(b) + 2*dot(a)*dot(c) + 2*dot(b)*dot(c))",
    "m*g*l/2*(3*a**2 + 2*b**2 + c**2)",
    ONE,
)


def expressions(system: System, texts: list[str]) -> list[sp.Expr]:
    return [sp.sympify(text, locals=system.symbols) for text in texts]


def same(a: sp.Expr, b: sp.Expr) -> bool:
    return bool(sp.simplify(a - b) == 0)


@pytest.mark.parametrize("name", BOOK)
def test_the_books_frequencies_and_amplitude_ratios(name: str) -> None:
    system, squares, columns = BOOK[name]
    result = normal_modes(system)
    for mode, expected in zip(result.modes, expressions(system, squares), strict=True):
        assert same(mode.frequency_squared, expected)
    for k, column in enumerate(columns):
        assert all(same(mine, its) for mine, its in zip(result.matrix.col(k), expressions(system, column), strict=True))
    assert result.exact
    assert result.remark == ""
    check(result)


def check(result: NormalModes) -> None:
    """AᵀmA and AᵀkA are diagonal, A⁻¹A = 1, T and V carry over, and the transformed system separates."""
    original, A = result.original, result.matrix
    n = len(original.coordinates)
    q = [c.symbol for c in original.coordinates]
    place = {s: result.equilibrium[s.name] for s in q}
    numbers = {p.symbol: sp.Rational(3 + 2 * i, 2) for i, p in enumerate(original.parameters)}
    m = mass_matrix(original).subs(place)
    k = sp.hessian(original.potential, q).subs(place)
    m, k, A, inverse = (sp.Matrix(M).evalf(60, subs=numbers) for M in (m, k, A, result.inverse))
    masses, stiffness, identity = A.T * m * A, A.T * k * A, inverse * A
    for i in range(n):
        for j in range(n):
            mode = result.modes[i]
            wanted = [mode.mass, mode.stiffness, sp.S.One] if i == j else [sp.S.Zero] * 3
            for found, value in zip((masses, stiffness, identity), wanted, strict=True):
                assert abs(found[i, j] - value.evalf(50, subs=numbers)) < sp.Float("1e-40")
    assert [c.name for c in result.system.coordinates] == [f"mode_{i + 1}" for i in range(n)]
    assert isinstance(result.verdict, Separation)
    new = {c.symbol: sp.Rational(2 + i, 5) for i, c in enumerate(result.system.coordinates)}
    if result.exact:
        old = {s: result.transformation[s.name].evalf(60, subs={**numbers, **new}) for s in q}
        found = result.system.potential.evalf(60, subs={**numbers, **new})
        assert abs(original.potential.evalf(60, subs={**numbers, **old}) - found) < sp.Float("1e-40")


def test_the_masses_and_stiffnesses_of_example_2_12() -> None:
    system, *_ = BOOK["C32 pendulum on a sliding block (Ex 2-12)"]
    result = normal_modes(system)
    m, g, length = (system.symbols[name] for name in ("m", "g", "l"))
    assert [mode.mass for mode in result.modes] == [3 * m, 6 * m]
    assert [mode.kind for mode in result.modes] == ["drift", "oscillation"]
    assert result.modes[0].stiffness == 0
    assert same(result.modes[1].stiffness, m * g * length * 9 / length**2)


@pytest.mark.nightly
def test_a_nonlinear_system_is_linearised_where_asked_and_says_so() -> None:
    pendulum = System(
        {"a": "angle", "b": "angle"},
        "m*l**2/2*(2*dot(a)**2 + dot(b)**2 + 2*dot(a)*dot(b)*cos(a - b))",
        "-m*g*l*(2*cos(a) + cos(b))",
        ONE,
    )
    hanging = normal_modes(pendulum, about={"a": 0, "b": 0})
    linear = normal_modes(BOOK["C23b double pendulum, small motion (2-66)"][0])
    assert [mode.frequency_squared for mode in hanging.modes] == [mode.frequency_squared for mode in linear.modes]
    assert hanging.remark == "linearised about a = 0, b = 0"
    assert not hanging.exact
    assert "linearised about" in hanging.system.title
    check(hanging)
    upright = normal_modes(pendulum, about={"a": sp.pi, "b": sp.pi})
    assert [mode.kind for mode in upright.modes] == ["unstable", "unstable"]
    assert {sp.expand(-mode.frequency_squared) for mode in upright.modes} == {
        sp.expand(mode.frequency_squared) for mode in hanging.modes
    }
    reduced = normal_modes(pendulum, about={"b": sp.pi})
    assert [mode.kind for mode in reduced.modes] == ["unstable", "oscillation"]


@pytest.mark.nightly
def test_three_frequencies_that_are_roots_of_a_cubic_are_exact() -> None:
    result = normal_modes(TRIPLE)
    # the triple pendulum: ω² l/g are the roots of s³ − 9 s² + 18 s − 6 (Laguerre L₃)
    s = sp.Symbol("s")
    numbers = {p.symbol: 1 for p in TRIPLE.parameters}
    roots = sp.Poly(s**3 - 9 * s**2 + 18 * s - 6, s).nroots(n=40)
    for mode, expected in zip(result.modes, roots, strict=True):
        assert abs(mode.frequency_squared.evalf(40, subs=numbers) - expected) < sp.Float("1e-35")
    check(result)


def test_repeated_roots_get_orthogonal_columns() -> None:
    ring = System(
        {"x": "line", "y": "line", "z": "line"},
        "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)",
        "k/2*((x - y)**2 + (y - z)**2 + (z - x)**2)",
        {"m": 1, "k": 1},
    )
    result = normal_modes(ring)
    m, k = ring.symbols["m"], ring.symbols["k"]
    assert [mode.frequency_squared for mode in result.modes] == [0, 3 * k / m, 3 * k / m]
    check(result)


def test_linear_terms_move_the_origin_and_push_only_drifting_modes() -> None:
    shifted = normal_modes(System(LINES2, "(dot(a)**2 + dot(b)**2)/2", "a**2 + a*b + b**2 + 3*a - b"))
    assert shifted.equilibrium == {"a": -sp.Rational(7, 3), "b": sp.Rational(5, 3)}
    check(shifted)
    pushed = normal_modes(System(LINES2, "(dot(a)**2 + dot(b)**2)/2", "(a - b)**2 + 3*a"))
    drift, spring = pushed.modes
    first, second = (c.symbol for c in pushed.system.coordinates)
    assert (drift.kind, spring.kind) == ("drift", "oscillation")
    assert sp.diff(pushed.system.potential, first) == 3
    assert sp.diff(pushed.system.potential, second).subs(second, 0) == 0
    check(pushed)


def test_modes_come_in_the_order_of_the_values_given() -> None:
    V = "(p*a**2 + q*b**2)/2"
    rising = normal_modes(System(LINES2, "(dot(a)**2 + dot(b)**2)/2", V, {"p": 1, "q": 4}))
    falling = normal_modes(System(LINES2, "(dot(a)**2 + dot(b)**2)/2", V, {"p": 4, "q": 1}))
    assert [str(mode.frequency_squared) for mode in rising.modes] == ["p", "q"]
    assert [str(mode.frequency_squared) for mode in falling.modes] == ["q", "p"]


@pytest.mark.parametrize(
    ("kinetic", "potential", "about", "says"),
    [
        ("(dot(a)**2 + dot(b)**2)/2", "cos(a) + b**2", None, "not a quadratic form"),
        ("(dot(a)**2 + dot(b)**2)/2", "cos(a) + b**2", {"a": 1}, "not an equilibrium"),
        ("(dot(a)**2 + dot(b)**2)/2", "cos(a) + b**2", {"c": 1}, "c is not a coordinate"),
        ("(dot(a)**2 + dot(b)**2)/2 + a*dot(b)", "a**2 + b**2", None, "gyroscopic"),
    ],
)
def test_what_has_no_normal_modes_is_refused_with_the_reason(
    kinetic: str, potential: str, about: dict[str, object] | None, says: str
) -> None:
    with pytest.raises(InvalidSystemError, match="normal_modes") as refusal:
        normal_modes(System(LINES2, kinetic, potential), about)
    assert says in str(refusal.value)


def test_a_symbolic_cubic_asks_for_numbers() -> None:
    chain = System(
        {"x": "line", "y": "line", "z": "line"},
        "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2",
        "(p*x**2 + q*y**2 + r*z**2)/2 + x*y + y*z",
        {"p": 1, "q": 2, "r": 3},
    )
    with pytest.raises(InvalidSystemError, match="give the parameters numbers"):
        normal_modes(chain)
