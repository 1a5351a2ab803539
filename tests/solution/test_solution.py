"""What a solution prints: Greenwood's own formulas, sign by sign."""

import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.errors import NotSeparableError
from hjsolve.mechanics.system import System
from hjsolve.separation import separate
from hjsolve.solution.quadratures import Solution, solve


@pytest.fixture(scope="module")
def kepler() -> Solution:
    return solve(catalog.load("kepler-planar"))


def test_kepler_reads_as_in_the_book(kepler: Solution) -> None:
    """(5-115), (5-118), (5-119): W = p_θ θ + ∫√(2mE + 2mk/r − p_θ²/r²) dr, t − t₀ = ∫ m dr/√(…)."""
    r, θ, m, k = (kepler.system.symbols[n] for n in ("r", "theta", "m", "k"))
    E, L = (kepler.constants[n].symbol for n in ("E", "p_theta"))
    r0 = kepler.lower_limits["r"]
    root = sp.sqrt(sp.expand(2 * m * E + 2 * m * k / r - L**2 / r**2))
    assert kepler.characteristic_function == L * θ + sp.Integral(root, (r, r0, r))
    assert kepler.time_law is not None
    assert kepler.time_law.rhs == sp.Integral(m / root, (r, r0, r))
    assert str(kepler.time_law.lhs) == "t - t_0"
    equation = kepler.orbit_equations["p_theta"]
    assert equation.lhs == -sp.Symbol("beta_theta", real=True)
    assert equation.rhs == θ + sp.Integral(-L / (r**2 * root), (r, r0, r))


def test_the_energy_comes_first_and_has_its_name(kepler: Solution) -> None:
    assert list(kepler.constants) == ["E", "p_theta"]
    assert "energy" in kepler.constants["E"].meaning


def test_the_separation_constant_of_a_central_field_is_recognised() -> None:
    kepler, dipole = (solve(catalog.load("kepler-spherical", effects=e)) for e in ((), ("dipole",)))
    assert kepler.constants["alpha_2"].meaning == "half the square of the total angular momentum"
    assert "angular momentum, plus d*m*cos(theta)" in dipole.constants["alpha_2"].meaning


def test_a_lower_limit_does_not_depend_on_the_constants(kepler: Solution) -> None:
    """Greenwood after (5-94): an absolute constant or a simple zero; the symbol stands for the first kind."""
    constants = {c.symbol for c in kepler.constants.values()}
    assert not set(kepler.lower_limits.values()) & constants
    assert all(not limit.diff(c) for limit in kepler.lower_limits.values() for c in constants)


def test_the_verdict_of_separate_can_be_solved_without_a_second_test(kepler: Solution) -> None:
    verdict = separate(kepler.system)
    assert solve(verdict).separation is verdict
    assert solve(verdict).characteristic_function == kepler.characteristic_function


def test_names_the_user_has_taken_are_left_to_him() -> None:
    parameters = {"E": 1, "t_0": 1}
    system = System(coordinates={"t": "line"}, kinetic="dot(t)**2/2", potential="E*t_0*t**2", parameters=parameters)
    solution = solve(system)
    assert solution.time_law is not None
    names = {s.name for s in solution.time_law.lhs.free_symbols}
    assert not names & set(system.symbols)
    assert next(iter(solution.constants)) != "E"
    assert solution.lower_limits["t"].name not in system.symbols


def test_a_linear_term_is_shifted_away_and_comes_back_in_the_momentum() -> None:
    """Spring in a moving frame (Ex 2-8, Ex 6-5): T₁ = m v ẋ is exact; p = √(…) + m v, W gains m v x."""
    system = System(
        coordinates={"x": "line"},
        kinetic="m/2*(dot(x) + v)**2",
        potential="k/2*x**2",
        parameters={"m": 1, "k": 1, "v": 2},
    )
    solution = solve(system)
    m, v, x = (system.symbols[n] for n in ("m", "v", "x"))
    assert sp.expand(solution.shift["x"] + m * v) == 0
    assert sp.expand(solution.momenta["x"] - sp.sqrt(solution.momentum_squared["x"]) - m * v) == 0
    rest = [term for term in solution.characteristic_function.args if not isinstance(term, sp.Integral)]
    assert sp.expand(sp.Add(*rest).diff(x) - m * v) == 0


def test_a_system_of_ignorable_coordinates_carries_the_time_in_its_orbit_equations() -> None:
    system = System(coordinates={"x": "line", "y": "line"}, kinetic="m/2*dot(x)**2 + m*dot(y)**2", parameters={"m": 1})
    solution = solve(system)
    p_x, t = system.coordinate("x").momentum, sp.Symbol("t", real=True)
    assert solution.time_law is None
    assert sp.expand(solution.orbit_equations["p_x"].rhs - (system.symbols["x"] - p_x * t / system.symbols["m"])) == 0


def test_a_refusal_carries_the_verdict() -> None:
    with pytest.raises(NotSeparableError, match="x and y") as caught:
        solve(catalog.load("henon-heiles"))
    assert caught.value.verdict.pair == ("x", "y")


def test_a_solution_is_frozen(kepler: Solution) -> None:
    with pytest.raises(AttributeError):
        kepler.coordinates = ()  # type: ignore[misc]


@pytest.mark.parametrize(
    ("potential", "expected"),
    [
        ("D*(1 - exp(-a*x))**2", "D*(1 - exp(-a*x))**2"),
        ("D*(1 - exp(a*x))**2", "D*(1 - exp(a*x))**2"),
        ("D*x**2*(2 - exp(-x))**4", "D*x**2*(2 - exp(-x))**4"),
    ],
)
def test_exponentials_are_printed_as_in_a_textbook(potential, expected):
    """Morse's D(1 − e^(−ax))², not D(e^(ax) − 1)²e^(−2ax): the square of the momentum, as it is shown."""
    system = System({"x": "line"}, "m/2*dot(x)**2", potential, {"m": 1, "D": 1, "a": 1})
    square = solve(system).momenta["x"] ** 2
    E, m = (next(s for s in square.free_symbols if s.name == name) for name in "Em")
    written = System({"x": "line"}, "m/2*dot(x)**2", expected, {"m": 1, "D": 1, "a": 1}).potential
    shown = (square - 2 * m * E) / (-2 * m)
    assert sp.simplify(shown - written) == 0
    exponentials = square.atoms(sp.exp)
    assert sp.count_ops(square) <= sp.count_ops(2 * m * E - 2 * m * written)
    assert exponentials == written.atoms(sp.exp)
