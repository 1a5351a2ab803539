"""A function whose derivative vanishes is constant only where it does not jump (x − atan(tan x) is a staircase)."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.energy_shell import reduce


def reduced(potential: str, *, domain: str = "line", mass: str = "1") -> tuple[str, ...]:
    kinetic = f"dot(x)**2/2 + ({mass})*dot(y)**2/2"
    shell = reduce(hjsolve.System({"x": domain, "y": "line"}, kinetic, potential))
    return tuple(c.name for c in shell.ignorable)


@pytest.mark.parametrize(
    "potential",
    [
        "x - atan(tan(x)) + y**2/2",
        "atan(x) + atan(y) - atan((x + y)/(1 - x*y)) + y**2/2",
        "atan(x) + atan(1/x) + y**2/2",
        "log(tan(x)**2)/2 + log(cot(x)**2)/2 + x - atan(tan(x)) + y**2/2",
    ],
)
def test_a_coordinate_over_which_the_potential_jumps_is_not_ignorable(potential: str) -> None:
    assert reduced(potential) == ()


def test_a_coordinate_over_which_the_mass_jumps_is_not_ignorable() -> None:
    assert reduced("y**2/2", mass="6 + atan(x) + atan(1/x)") == ()


@pytest.mark.parametrize(
    ("potential", "domain"),
    [
        ("cos(x)**2 + sin(x)**2 + y**2/2", "line"),
        ("asin(tanh(x)) - atan(sinh(x)) + y**2/2", "line"),
        ("log(exp(x)*2) - x + y**2/2", "line"),
        ("cos(x + y)**2 + sin(x + y)**2 + y**2/2", "angle"),
    ],
)
def test_a_coordinate_over_which_the_potential_is_one_constant_is_ignorable(potential: str, domain: str) -> None:
    assert reduced(potential, domain=domain) == ("x",)


def test_between_two_jumps_the_function_is_written_as_its_constant() -> None:
    kinetic = "dot(x)**2/2 + (6 + atan(x) + atan(1/x))*dot(y)**2/2"
    shell = reduce(hjsolve.System({"x": "0 < x", "y": "line"}, kinetic, "y**2/2 - x + atan(x) + atan(1/x) + x"))
    assert shell.potential.equals(shell.coordinates[1].symbol ** 2 / 2 + sp.pi / 2)
    assert shell.inverse_metric[1].equals(1 / (6 + sp.pi / 2))


def test_a_staircase_is_never_taken_for_a_level_potential() -> None:
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x - atan(tan(x))")
    solution = hjsolve.solve(system)
    assert solution.coordinates == ("x",)
    with pytest.raises(hjsolve.HJSolveError):  # V(2) = π; the jumps are at odd multiples of π/2
        solution.motion(q={"x": 2}, velocity={"x": 1})
