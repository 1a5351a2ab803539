"""What a refusal says next to its witness: the distance from separable, the blocks, the one energy."""

import pytest
import sympy as sp

from hjsolve.mechanics.system import System
from hjsolve.separation import Obstruction, Separation, separate
from hjsolve.separation.obstruction.blocks import components
from tests.support.separation_cases import CARTESIAN, PLANE, REFUSED, SPACE, SPHERICAL, SPHERICAL_COORDINATES, make

FREE_PLANE = "(dot(x)**2 + dot(y)**2)/2"


def refused(system):
    verdict = separate(system)
    assert isinstance(verdict, Obstruction)
    return verdict


@pytest.mark.parametrize("name", ["bispherical", "toroidal"])
def test_bispherical_and_toroidal_coordinates_separate_at_zero_energy_only(name):
    verdict = refused(REFUSED[name][0])
    assert verdict.conformal is True
    assert verdict.conformal_energy == 0
    assert "one energy E = 0" in verdict.advice
    assert "Laplace" in verdict.advice
    assert verdict.distance > 0.05


@pytest.mark.parametrize("factor", ["exp(x*y)", "(1 + x**2*y**2)", "(2 + sin(x)*cos(y))"])
def test_a_conformal_factor_on_a_separable_shell_leaves_one_energy(factor):
    """F·(½p² + V − E₀) = 0 has the solutions of ½p² + V − E₀ = 0: V' = F⁻¹(V − E₀) + E₁ separates at E₁ only."""
    potential = f"(x**2 + y**4 - h)/({factor}) + 7*k"
    verdict = refused(make(PLANE, f"{factor}*{FREE_PLANE}", potential, "k h"))
    assert verdict.conformal is True
    assert sp.expand(verdict.conformal_energy - 7 * verdict.system.symbols["k"]) == 0
    assert "nothing moves" not in verdict.advice


@pytest.mark.parametrize(
    "potential", ["(x**2 + y**4 + x*y)/exp(x*y)", "(x**2 + y**4)/exp(x*y) + x", "x"], ids=["mixed", "tilted", "plain"]
)
def test_a_conformal_metric_with_another_potential_has_no_such_energy(potential):
    verdict = refused(make(PLANE, f"exp(x*y)*{FREE_PLANE}", potential))
    assert verdict.conformal is False
    assert verdict.conformal_energy is None


@pytest.mark.parametrize("name", [name for name, (_, _, part) in REFUSED.items() if part == "potential"])
def test_where_the_metric_separates_no_single_energy_can_help(name):
    """λ_ij = 0 there, so that S_ij(V) = 0 would be needed at every energy."""
    assert refused(REFUSED[name][0]).conformal is False


BLOCKS = {
    "a sum": (make(SPACE, CARTESIAN, "x*y + z**4 + x**4", "m"), {("x", "y"), ("z",)}),
    "a cone": (
        make(SPHERICAL_COORDINATES, SPHERICAL, "-k/r + h*sin(theta)**3*cos(phi)/r**2", "m k h"),
        {("r",), ("theta", "phi")},
    ),
    "a block with its own metric": (
        make(
            {**SPACE, "w": "line"},
            "(1 + x**2 + z**2)/2*(dot(x)**2 + dot(y)**2 + dot(z)**2*(1 + x**2*z**2)) + dot(w)**2/2",
            "w**2 + y**4/(1 + x**2 + z**2)",
        ),
        {("x", "z"), ("y",), ("w",)},
    ),
    "everything mixed": (
        make(SPHERICAL_COORDINATES, SPHERICAL, "r*sin(theta)*cos(phi) + r**2*cos(phi)", "m"),
        {("r", "theta", "phi")},
    ),
    "two pairs": (
        make(
            {"x": "line", "y": "line", "z": "line", "w": "line"},
            "(dot(x)**2 + dot(y)**2 + dot(z)**2 + dot(w)**2)/2",
            "x*z + sin(y + w)",
        ),
        {("x", "z"), ("y", "w")},
    ),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_the_finest_blocks_are_found(name):
    system, expected = BLOCKS[name]
    verdict = refused(system)
    assert set(verdict.blocks) == expected
    assert ("The rest does separate" in verdict.advice) == (len(expected) > 1)


def test_pairs_that_pass_make_no_blocks_unless_the_block_hamiltonians_are_found():
    """x and y fail; z passes with both, but g^xx/g^yy depends on z, so that no H_A(x, y) exists."""
    kinetic = "dot(x)**2/2 + (2 + sin(z))*dot(y)**2/2 + dot(z)**2/2"
    verdict = refused(make(SPACE, kinetic, "x*y"))
    assert set(verdict.blocks) == {("x", "y", "z")}


def test_blocks_hold_the_motion_of_a_sum_of_two_systems():
    """The same two planes alone: each is refused, or separates, as it stands in the sum."""
    fast, slow = "x*z", "y**2 + w**4"
    coordinates = dict.fromkeys("xyzw", "line")
    kinetic = "(dot(x)**2 + dot(y)**2 + dot(z)**2 + dot(w)**2)/2"
    assert set(refused(make(coordinates, kinetic, f"{fast} + {slow}")).blocks) == {("x", "z"), ("y",), ("w",)}
    assert isinstance(separate(make({"y": "line", "w": "line"}, "(dot(y)**2 + dot(w)**2)/2", slow)), Separation)


def test_components_of_a_graph():
    assert components(5, [(0, 3), (3, 4)]) == ((0, 3, 4), (1,), (2,))
    assert components(3, []) == ((0,), (1,), (2,))


@pytest.mark.parametrize("part", ["metric", "potential"])
def test_distance_goes_to_zero_with_the_disturbance(part):
    found = []
    for size in ("1/10**3", "1/10**6", "1/10**9"):
        term = f"{size}*x*y"
        kinetic = f"((2 + sin(x) + y**2) + {term})*dot(x)**2/2 + (2 + sin(x) + y**2)*dot(y)**2/2"
        V = "x/(2 + sin(x) + y**2)"
        system = (
            make(PLANE, kinetic, V) if part == "metric" else make(PLANE, kinetic.replace(term, "0"), f"{V} + {term}")
        )
        verdict = refused(system)
        assert verdict.part == part
        found.append(verdict.distance)
    assert found[0] / found[1] == pytest.approx(1e3, rel=0.05)
    assert found[1] / found[2] == pytest.approx(1e3, rel=0.05)


def test_distance_is_independent_of_units():
    """m and k scale T and V; how far the potential is from separable does not change."""
    kinetic, V = "m/2*(dot(x)**2 + dot(y)**2)", "k*(x**2 + x**2*y)"
    first = refused(make(PLANE, kinetic, V, "m k")).distance
    second = refused(make(PLANE, kinetic, V.replace("k*", "1000*k*"), "m k")).distance
    assert first == pytest.approx(second, rel=1e-12)


def test_distance_is_not_given_where_functions_are_undetermined():
    x, y = sp.symbols("x y", real=True)
    verdict = refused(System(PLANE, FREE_PLANE, sp.Function("f")(x) * sp.Function("g")(y)))
    assert verdict.distance is None
    assert set(verdict.blocks) == {("x", "y")}


def test_no_refusal_claims_that_a_system_is_not_integrable():
    for name, (system, _, _) in REFUSED.items():
        words = " ".join([refused(system).advice, *(step.explanation for step in refused(system).evidence)]).lower()
        assert "nonintegrable" not in words, name
        assert "not integrable" not in words, name
        assert "or be integrable without separating" in words, name
