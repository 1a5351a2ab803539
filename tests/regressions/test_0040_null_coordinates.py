"""T = q̇ẏ: pivots of the elimination of ignorable coordinates vanish, and a momentum may enter H to first degree."""

import random

import mpmath
import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.positive_definite import _is_regular
from hjsolve.solution.laws import check

LIGHT_CONE = {"u": "line", "v": "line", "x": "line"}
WAVE = "dot(u)*dot(v) + dot(x)**2/2 + ({})*dot(u)**2/2"


def system(coordinates, kinetic, potential="0"):
    return hjsolve.System(coordinates, kinetic, potential, {"m": 2}, signature="indefinite")


@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential", "null"),
    [
        ("xy", "dot(x)*dot(y)", "x**2", ("x",)),
        ("xy", "dot(x)*dot(y)", "0", ()),
        ("xy", "dot(x)*dot(y) + x**2*dot(x)**2", "exp(x)", ("x",)),
        ("uvx", WAVE.format("sin(u) + x**2"), "0", ("u",)),
        ("uvx", "dot(u)*dot(v)*x**2 + dot(x)**2/2", "u/x**2 + x", ("u",)),
        ("uvx", WAVE.format("u") + "+ x*dot(u)", "cos(x)", ("u",)),
        ("abcd", "dot(a)*dot(b) + dot(c)*dot(d)", "a + c**2", ("a", "c")),
        ("abc", "dot(a)*dot(b) + dot(b)*dot(c) + dot(c)*dot(a)", "c**2", ()),
    ],
)
def test_light_like_coordinates_separate_and_every_law_of_the_solution_is_proved(coordinates, kinetic, potential, null):
    verdict = hjsolve.separate(system(dict.fromkeys(coordinates, "line"), kinetic, potential))
    assert isinstance(verdict, hjsolve.Separation)
    assert verdict.shell.null == null
    assert {law.verdict for law in check(hjsolve.solve(verdict))} == {"proved"}


@pytest.mark.parametrize(
    ("coordinates", "kinetic", "potential"),
    [
        ("xy", "dot(x)*dot(y)", "x**2 + y**2"),
        ("uvx", WAVE.format("u*x**2"), "0"),
        ("uvx", WAVE.format("0") + "+ x*dot(v)", "u"),
        ("abcd", "dot(a)*dot(b) + (1 + a**2)*dot(c)*dot(d)", "c**2"),
    ],
)
def test_light_like_coordinates_that_do_not_separate_have_a_witness(coordinates, kinetic, potential):
    verdict = hjsolve.separate(system(dict.fromkeys(coordinates, "line"), kinetic, potential))
    assert isinstance(verdict, hjsolve.Obstruction)
    assert verdict.witness.excludes_zero


def test_the_momentum_of_a_null_coordinate_has_no_root():
    """H = p_x p_y + x² = E gives p_x = (E − x²)/p_y."""
    solution = hjsolve.solve(system({"x": "line", "y": "line"}, "dot(x)*dot(y)", "x**2"))
    E, x, p_y = (sp.Symbol(name, real=True) for name in ("E", "x", "p_y"))
    assert sp.expand(solution.momenta["x"] - (E - x**2) / p_y) == 0
    assert solution.time_law.rhs == sp.Integral(1 / p_y, (x, solution.lower_limits["x"], x))


def test_numbers_of_a_null_coordinate_are_refused_with_what_to_use_instead():
    solution = hjsolve.solve(system({"x": "line", "y": "line"}, "dot(x)*dot(y)", "x**2"))
    with pytest.raises(hjsolve.InvalidInputError, match=r"linear in the momentum of x.*use the formulas"):
        solution.motion(q={"x": 1, "y": 0}, p={"x": 1, "y": 1})
    with pytest.raises(hjsolve.InvalidInputError, match="linear in the momentum of x"):
        hjsolve.ensemble(solution, q={"x": 1, "y": 0}, p={"x": 1, "y": 1})


def test_a_singular_matrix_with_a_column_of_zeros_is_degenerate_not_an_error_of_mpmath():
    matrix = mpmath.matrix([[0, 0, 1], [0, 0, 2], [1, 2, 0]])
    assert not _is_regular(matrix)
    matrix[0, 1] = matrix[1, 0] = 1
    assert _is_regular(matrix)


@pytest.mark.parametrize("seed", range(30))
def test_random_indefinite_kinetic_energies_give_a_verdict_whose_laws_are_proved_or_one_clear_error(seed):
    source = random.Random(seed)
    names = "xyzw"[: source.choice((2, 3, 3, 4))]

    def factor():
        q = source.choice(names)
        return source.choice(("1", "1", "1", q, f"{q}**2", f"cos({q})", f"(1 + {q}**2)", f"exp({q})", "m"))

    pairs = [(a, b) for i, a in enumerate(names) for b in names[i:] if source.random() < (0.35 if a == b else 0.6)]
    kinetic = " + ".join(f"{source.choice((1, 2, -3))}*{factor()}*dot({a})*dot({b})" for a, b in pairs) or "0"
    potential = " + ".join(factor() for _ in range(source.choice((1, 1, 2))))
    try:
        verdict = hjsolve.separate(system(dict.fromkeys(names, "line"), kinetic, potential))
    except hjsolve.InvalidSystemError as error:
        assert "degenerate" in str(error) or "does not occur" in str(error)
        return
    if isinstance(verdict, hjsolve.Separation):
        assert {law.verdict for law in check(hjsolve.solve(verdict))} == {"proved"}
    elif isinstance(verdict, hjsolve.Obstruction):
        assert verdict.witness.excludes_zero
