"""Jacobi's theorem: (q, p) → (α, β) is canonical over the whole catalog (Greenwood (6-76)–(6-79), (6-215))."""

import pytest
import sympy as sp

from hjsolve.mechanics.brackets import bracket, conjugate_pairs
from hjsolve.mechanics.system import System, parameter
from hjsolve.solution.laws import check
from hjsolve.solution.quadratures import Solution, solve
from tests.support import entries
from tests.support.entries import solved

NAMES = entries.separable_with_effects()


@pytest.mark.entries
@pytest.mark.parametrize("name", NAMES)
def test_constants_are_in_involution_and_conjugate_to_the_betas(name: str) -> None:
    checks = check(solved(name))
    assert [c.name for c in checks] == ["hamilton-jacobi", "momenta", "involution", "canonical"]
    assert [c.verdict for c in checks] == ["proved"] * 4


@pytest.mark.entries
@pytest.mark.parametrize("name", NAMES)
def test_one_constant_for_every_degree_of_freedom(name: str) -> None:
    solution = solved(name)
    count = len(solution.system.coordinates)
    # where every coordinate is ignorable the energy is a function of the momenta and comes as one constant more
    assert len(solution.constants) == count + (not solution.coordinates)
    assert len(solution.orbit_equations) + (solution.time_law is not None) == count
    assert next(iter(solution.constants.values())).symbol == solution.separation.shell.energy


def forged(solution: Solution, **changes: object) -> dict[str, str]:
    return {c.name: c.verdict for c in check(Solution(**{**vars(solution), **changes}))}


def test_a_constant_that_is_no_integral_is_seen() -> None:
    solution = solved("kepler-parabolic")
    constants = dict(solution.constants)
    wrong = constants["alpha_2"]
    u = solution.system.coordinate("u").symbol
    constants["alpha_2"] = type(wrong)(wrong.name, wrong.symbol, wrong.expression + u, wrong.meaning)
    assert forged(solution, constants=constants)["involution"] == "failed"


def test_a_factor_two_in_an_orbit_equation_is_seen() -> None:
    solution = solved("kepler-spherical")
    for name, equation in solution.orbit_equations.items():
        terms = [sp.Integral(2 * t.function, *t.limits) if isinstance(t, sp.Integral) else t for t in equation.rhs.args]
        if isinstance(equation.rhs, sp.Integral):
            terms = [sp.Integral(2 * equation.rhs.function, *equation.rhs.limits)]
        wrong = {**solution.orbit_equations, name: sp.Eq(equation.lhs, sp.Add(*terms), evaluate=False)}
        assert forged(solution, orbit_equations=wrong)["canonical"] == "failed", name


def test_a_wrong_sign_in_the_time_law_is_seen() -> None:
    solution = solved("pendulum")
    integral = solution.time_law.rhs
    wrong = sp.Eq(solution.time_law.lhs, sp.Integral(-integral.function, *integral.limits), evaluate=False)
    assert forged(solution, time_law=wrong)["canonical"] == "failed"


def test_a_forgotten_gauge_shift_is_seen() -> None:
    """Rotating frames and magnetic fields bring terms linear in p; an ignored A breaks the equation."""
    solution = solved("projectile")
    wrong = {name: sp.Symbol("y", real=True) ** 0 for name in solution.shift}
    assert forged(solution, shift=wrong)["hamilton-jacobi"] == "failed"


def test_the_bracket_has_greenwoods_sign() -> None:
    solution = solved("harmonic-oscillator")
    x = solution.system.coordinate("x")
    assert bracket(x.symbol, x.momentum, conjugate_pairs(solution.system.coordinates)) == 1


COUPLED = {
    "rod whose end slides (P1-5)": System(
        coordinates={"x": "line", "theta": "angle"},
        kinetic="m/2*dot(x)**2 + m*l**2/6*dot(theta)**2 - m*l/2*dot(x)*dot(theta)*sin(theta)",
        potential="m*g*l/2*sin(theta)",
        parameters={"m": 1, "l": 1, "g": "9.81"},
    ),
    "pendulum on a sliding block (Ex 2-12)": System(
        coordinates={"x": "line", "theta": "angle"},
        kinetic="3*m/2*dot(x)**2 + m*l*dot(x)*dot(theta)*cos(theta) + m*l**2/2*dot(theta)**2",
        potential="-m*g*l*cos(theta)",
        parameters={"m": 1, "l": 1, "g": "9.81"},
    ),
    "block on a sliding wedge (Ex 2-3)": System(
        coordinates={"x1": "line", "x2": "line"},
        kinetic="M/2*dot(x1)**2 + m/2*(dot(x1)**2 + dot(x2)**2 - sqrt(2)*dot(x1)*dot(x2))",
        potential="-m*g*x2/sqrt(2)",
        parameters={
            "M": parameter("M", 2, assume="positive"), "m": parameter("m", 1, assume="positive"), "g": "9.81",
        },
    ),
    "bead on a wire turning about a point of itself (P1-4)": System(
        coordinates={"theta": "angle"},
        kinetic="m*r**2*(w*(dot(theta) + w)*(1 - cos(theta)) + dot(theta)**2/2)",
        parameters={"m": 1, "r": 1, "w": 1},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", COUPLED)
def test_the_laws_hold_where_elimination_leaves_linear_terms(name: str) -> None:
    """A(q; c) depends on the ignorable momentum, so −∂χ/∂c enters the orbit equation (Greenwood (3-113), (5-83))."""
    solution = solve(COUPLED[name])
    assert any(a != 0 for a in solution.shift.values())
    assert [c.verdict for c in check(solution)] == ["proved"] * 4
    for c in solution.system.coordinates:
        assert sp.simplify(sp.diff(solution.characteristic_function, c.symbol) - solution.momenta[c.name]) == 0
