"""Reduction to the energy shell: the same Hamiltonian in fewer coordinates, in a form one can read."""

from __future__ import annotations

import pytest
import sympy as sp

from hjsolve.algebra.poly import Budget, WorkLimitError
from hjsolve.mechanics.energy_shell import Irreducible, Shell, domain_bounds, reduce
from hjsolve.mechanics.system import System, hamiltonian, mass_matrix
from hjsolve.separation import region_of
from tests.support.separation_cases import CARTESIAN, PLANE, REFUSED, SEPARABLE, SPACE, make


def symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, positive=True)


def momentum(name: str) -> sp.Symbol:
    return sp.Symbol(f"p_{name}", real=True)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_the_shell_is_the_hamiltonian_with_completed_squares(name):
    """H(q, p) = ½ Σ g (p + A)² + V_eff identically, and ∂χ/∂q = A; by sympy at 40 digits."""
    system = SEPARABLE[name]
    shell = reduce(system)
    squares = [g * (c.momentum + a) ** 2 / 2 for g, c, a in zip(shell.inverse_metric, shell.coordinates, shell.shift)]
    residual = hamiltonian(system) - sp.Add(*squares) - shell.potential
    slopes = [shell.shift_potential.diff(c.symbol) - a for c, a in zip(shell.coordinates, shell.shift)]
    for _, point in zip(range(3), region_of(system).points(sp.Add(sp.Dummy() * residual, *slopes), seed=5)):
        assert abs(residual.evalf(40, subs=point)) < 1e-30
        assert all(abs(s.evalf(40, subs=point)) < 1e-30 for s in slopes)


@pytest.mark.parametrize("name", list(SEPARABLE))
def test_ignorable_coordinates_are_those_that_the_hamiltonian_does_not_hold(name):
    system = SEPARABLE[name]
    shell = reduce(system)
    held = hamiltonian(system).free_symbols
    assert [c.name for c in shell.ignorable] == [c.name for c in system.coordinates if c.symbol not in held]
    assert {*shell.coordinates, *shell.ignorable} == set(system.coordinates)
    remaining = sp.Add(*shell.inverse_metric, shell.potential, *shell.shift).free_symbols
    assert not remaining & {c.symbol for c in shell.ignorable}


def test_the_effective_potential_of_the_spherical_pendulum_reads_as_in_a_textbook():
    shell = reduce(SEPARABLE["spherical pendulum"])
    m, g, l = map(symbol, "mgl")
    theta = shell.coordinates[0].symbol
    expected = momentum("phi") ** 2 / (2 * m * l**2 * sp.sin(theta) ** 2) - m * g * l * sp.cos(theta)
    assert shell.potential == expected
    assert shell.inverse_metric == (1 / (m * l**2),)


def test_the_top_has_the_potential_of_greenwood_3_168():
    shell = reduce(SEPARABLE["top, C52"])
    theta = shell.coordinates[0].symbol
    I_a, I_t, m, g, l = map(symbol, ("I_a", "I_t", "m", "g", "l"))
    cone = (momentum("psi") + momentum("phi") * sp.sin(theta)) ** 2 / (2 * I_t * sp.cos(theta) ** 2)
    assert shell.potential == cone + momentum("phi") ** 2 / (2 * I_a) + m * g * l * sp.sin(theta)
    assert shell.inverse_metric == (1 / I_t,)
    assert not any(shell.shift)


def test_the_velocity_free_part_of_T_is_folded_into_the_potential():
    shell = reduce(SEPARABLE["whirling tube, C25a"])
    theta, (m, r, g, omega) = shell.coordinates[0].symbol, map(symbol, ("m", "r", "g", "omega"))
    assert shell.potential == m * g * r * sp.cos(theta) - m * r**2 * omega**2 * sp.sin(theta) ** 2 / 2
    assert any("V' = V - T0" in step.explanation for step in shell.steps)


def test_an_exact_linear_term_is_shifted_away_with_its_potential_in_closed_form():
    shell = reduce(SEPARABLE["bead on a turning wire, C13"])
    theta, (m, r, omega) = shell.coordinates[0].symbol, map(symbol, ("m", "r", "omega"))
    assert sp.expand(shell.shift_potential + m * r**2 * omega * (theta - sp.sin(theta))) == 0
    assert sp.expand(shell.potential + m * r**2 * omega**2 * (1 - sp.cos(theta))) == 0


def test_a_closed_form_in_two_coordinates_is_shifted_away():
    shell = reduce(SEPARABLE["oscillators in a moving frame"])
    x, y = (c.symbol for c in shell.coordinates)
    b, c = map(symbol, "bc")
    assert sp.expand(shell.shift_potential + b * x * y + c * sp.sin(x)) == 0


def test_a_potential_without_closed_form_stays_an_integral():
    system = System({"x": "line"}, "dot(x)**2/2 + dot(x)*exp(sin(x)*x**2)/cosh(x)", "x**2")
    shell = reduce(system)
    assert shell.shift_potential.has(sp.Integral)
    assert sp.simplify(shell.shift_potential.diff(shell.coordinates[0].symbol) - shell.shift[0]) == 0


def test_a_coordinate_that_only_seems_to_occur_is_ignorable():
    system = make(
        {"r": "0 < r", "phi": "angle"},
        "m/2*(dot(r)**2 + r**2*(cos(phi)**2 + sin(phi)**2)*dot(phi)**2)",
        "k*r**2*cos(2*phi) - k*r**2*(cos(phi)**2 - sin(phi)**2) - 1/r",
        "m k",
    )
    shell = reduce(system)
    assert [c.name for c in shell.ignorable] == ["phi"]
    assert not shell.potential.has(sp.cos)


def test_with_all_coordinates_ignorable_the_potential_is_the_whole_hamiltonian():
    shell = reduce(make(PLANE, "m/2*(dot(x)**2 + dot(y)**2 + dot(x)*dot(y))", "0", "m"))
    assert shell.coordinates == ()
    px, py, m = momentum("x"), momentum("y"), symbol("m")
    assert sp.expand(shell.potential - 2 * (px**2 - px * py + py**2) / (3 * m)) == 0


def test_a_field_through_the_plane_in_the_symmetric_gauge_is_gyroscopic():
    found = reduce(REFUSED["crossed fields, symmetric gauge, C55"][0])
    assert isinstance(found, Irreducible)
    assert (found.reason, found.pair) == ("gyroscopic", ("x", "y"))
    assert abs(found.residual) == symbol("e") * symbol("B")


def test_coordinates_coupled_in_T_have_no_shell():
    found = reduce(REFUSED["double pendulum, C23a"][0])
    assert isinstance(found, Irreducible)
    assert (found.reason, found.pair) == ("metric", ("theta", "phi"))
    theta, phi, m, l = (*(c.symbol for c in found.essential), symbol("m"), symbol("l"))
    assert sp.expand((found.residual - m * l**2 * sp.cos(phi - theta)).expand(trig=True)) == 0


def test_the_energy_takes_another_letter_when_the_user_has_taken_E():
    shell = reduce(make(SPACE, CARTESIAN, "E*x", "m E"))
    assert isinstance(shell, Shell)
    assert shell.energy.name not in {"E", "m", "x", "y", "z"}


def test_every_step_says_what_was_done():
    for system in SEPARABLE.values():
        for step in reduce(system).steps:
            assert step.title
            assert step.explanation.endswith(".")


def test_several_coupled_ignorable_coordinates_leave_half_c_inverse_mass_c():
    """The centrifugal potential is ½ cᵀ M⁻¹ c over the ignorable block (Greenwood (2-124)), by sympy's inverse."""
    kinetic = (
        "(dot(q)**2 + (dot(a) + q*dot(b))**2 + (dot(b) + q**2*dot(d))**2 + dot(d)**2 + (dot(a) + dot(d))**2"
        "+ dot(a)**2 + (dot(b) + dot(a))**2)/2"
    )
    system = System({"q": "line", "a": "line", "b": "line", "d": "line"}, kinetic, "q**4")
    shell = reduce(system)
    block = mass_matrix(system)[1:, 1:]
    c = sp.Matrix([coordinate.momentum for coordinate in shell.ignorable])
    assert len(c) == 3
    expected = (c.T * block.inv() * c)[0] / 2 + system.coordinates[0].symbol ** 4
    assert sp.cancel(shell.potential - expected) == 0


@pytest.mark.parametrize(
    ("domain", "ends"),
    [
        ("line", (None, None)),
        ("angle", (None, None)),
        ("2 < r", (2, None)),
        ("r < 3", (None, 3)),
        ("2 < r < 3", (2, 3)),
    ],
)
def test_bounds_of_every_kind_of_domain(domain, ends):
    system = System({"r": domain}, "dot(r)**2/2", "cos(r)")
    ((symbol_, bounds),) = domain_bounds(system.coordinates).items()
    assert symbol_ == system.coordinates[0].symbol
    assert bounds == ends


@pytest.mark.parametrize(
    ("domain", "potential"),
    [
        ("2 < r", "sqrt(r**2 - 4*r + 4) - (r - 2)"),
        ("r < 2", "sqrt(r**2 - 4*r + 4) + (r - 2)"),
        ("2 < r < 3", "sqrt(r**2 - 4*r + 4)*sqrt(r**2 - 6*r + 9) - (r - 2)*(3 - r)"),
        ("-3 < r < -2", "sqrt(r**2 + 6*r + 9)*sqrt(r**2 + 4*r + 4) + (r + 3)*(r + 2)"),
        ("line", "cos(r)**2 + sin(r)**2 - 1"),
        ("angle", "cos(r)**2 + sin(r)**2 - 1"),
    ],
)
def test_an_apparent_coordinate_is_put_to_a_place_inside_its_domain(domain, potential):
    """Outside it the roots change sign: the potential would be left with a number that is not 0."""
    shell = reduce(System({"r": domain, "x": "line"}, "(dot(r)**2 + dot(x)**2)/2", f"{potential} + x**4"))
    ends = "<" in domain
    assert [c.name for c in shell.ignorable] == ([] if ends else ["r"])  # the motion may come to an end
    x = shell.coordinates[-1].symbol
    assert sp.expand(shell.potential - (0 if ends else momentum("r") ** 2 / 2) - x**4) == 0


def test_a_coordinate_in_one_entry_of_the_mass_matrix_only_is_not_ignorable():
    shell = reduce(System(dict.fromkeys("xyz", "line"), "(dot(x)**2 + dot(y)**2*(1 + x**2) + dot(z)**2)/2", "0"))
    assert [c.name for c in shell.ignorable] == ["y", "z"]


def test_hidden_coordinates_are_found_where_no_random_point_has_a_value():
    """Without a filter every slope is brought to its normal form: the answer is the same."""
    system = SEPARABLE["Kepler, space"]
    expected = reduce(system).ignorable
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hjsolve.mechanics.energy_shell.at_random_points", lambda *_, **__: None)
        assert reduce(system).ignorable == expected != ()
        seeming = System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "sin(x)**2 + cos(x)**2 + y**2")
        assert [c.name for c in reduce(seeming).ignorable] == ["x"]


def test_a_budget_that_is_given_is_kept_to():
    with pytest.raises(WorkLimitError):
        reduce(SEPARABLE["Kepler, space"], Budget(terms=0))


def test_the_energy_is_a_real_symbol():
    assert reduce(SEPARABLE["spherical pendulum"]).energy.is_real


# ---------------------------------------------------------------------------------------------------- words and steps


def titled(shell, title):
    return [step for step in shell.steps if step.title == title]


def test_the_step_of_the_shell_shows_half_the_metric_times_squares_plus_the_potential():
    for name in ("spherical pendulum", "Kepler, space", "top, C52", "rod with a sliding end, C14"):
        shell = reduce(SEPARABLE[name])
        (step,) = titled(shell, "Energy shell")
        squares = (
            g * (sp.Symbol(f"P_{c.name}") if any(shell.shift) else c.momentum) ** 2 / 2
            for g, c in zip(shell.inverse_metric, shell.coordinates, strict=True)
        )
        assert step.formula.rhs == shell.energy
        assert sp.expand(step.formula.lhs - sp.Add(*squares) - shell.potential) == 0


def test_the_steps_name_what_was_done_and_nothing_else():
    pendulum = reduce(SEPARABLE["spherical pendulum"])
    assert [step.title for step in pendulum.steps] == ["Ignorable coordinates", "Energy shell"]
    assert "phi" in pendulum.steps[0].explanation
    assert "linear in the momenta left" not in pendulum.steps[0].explanation
    tube = reduce(SEPARABLE["whirling tube, C25a"])
    assert [step.title for step in tube.steps] == ["Velocity-free part of T", "Energy shell"]
    assert sp.expand(tube.steps[0].formula - tube.potential) == 0
    free = reduce(System(PLANE, "(dot(x)**2 + dot(y)**2)/2", "x**4 + y**4"))
    assert [step.title for step in free.steps] == ["Ignorable coordinates", "Energy shell"]
    assert "No coordinate is ignorable" in free.steps[0].explanation


def test_linear_terms_that_the_elimination_leaves_are_announced():
    """T couples x to the ignorable z, y to nothing: A = (c x, 0) comes from the elimination alone."""
    kinetic = "(dot(x)**2*(1 + x**2) + dot(y)**2 + dot(z)**2 + 2*x*dot(x)*dot(z))/2"
    shell = reduce(System(dict.fromkeys("xyz", "line"), kinetic, "x**4 + y**4"))
    assert [bool(a) for a in shell.shift] == [True, False]
    assert shell.steps[0].title == "Ignorable coordinates"
    assert shell.steps[0].explanation.endswith("and terms linear in the momenta left.")
    (shift,) = titled(shell, "Linear terms")
    assert "With one essential coordinate" not in shift.explanation


def test_linear_terms_that_the_user_wrote_are_not_announced_as_found():
    kinetic = "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2 + x*dot(x)"
    shell = reduce(System(dict.fromkeys("xyz", "line"), kinetic, "x**4 + y**4"))
    assert "linear in the momenta left" not in shell.steps[0].explanation
    assert titled(shell, "Linear terms")


def test_one_coordinate_left_has_linear_terms_that_are_a_gradient():
    shell = reduce(System({"x": "line"}, "dot(x)**2/2 + x**2*dot(x)", "x**4"))
    (shift,) = titled(shell, "Linear terms")
    assert shift.explanation.startswith("With one essential coordinate")
    two = reduce(System(PLANE, "(dot(x)**2 + dot(y)**2)/2 + x**2*dot(x) + y*dot(y)", "x**4 + y**4"))
    assert titled(two, "Linear terms")[0].explanation.startswith("H has terms")
