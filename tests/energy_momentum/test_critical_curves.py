"""Critical curves and monodromy against closed forms and the literature."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve


def curves(found: hjsolve.EnergyMomentumMap, kind: str, coordinate: str):
    return [c for c in found.curves if c.kind == kind and c.coordinate == coordinate]


def test_circular_orbits_of_kepler() -> None:
    """2E p² = −m k², and the edge of escape E = 0."""
    found = hjsolve.energy_momentum_map(hjsolve.solve("kepler-planar"))
    circles = curves(found, "relative equilibrium", "r")
    assert circles
    for curve in circles:
        assert np.allclose(2 * curve.y * curve.x**2, -1.0, rtol=1e-12, atol=0)
        assert np.allclose(curve.q, curve.x**2, rtol=1e-9, atol=0)
    (edge,) = curves(found, "edge of escape", "r")
    assert edge.equation == found.solution.constants["E"].symbol
    E, p = (found.solution.constants[n].symbol for n in ("E", "p_theta"))
    assert sp.rem(found.equation("r"), 2 * E * p**2 + 1, E) == 0


def test_conical_pendulum() -> None:
    """p² = m² g l³ sin⁴θ/cosθ, E = −m g l cosθ + p²/(2 m l² sin²θ), with m = l = 1 and g = 9.81."""
    found = hjsolve.energy_momentum_map(hjsolve.solve("spherical-pendulum"))
    cones = curves(found, "relative equilibrium", "theta")
    assert len(cones) == 2
    for curve in cones:
        inner = np.abs(curve.x) > 1e-3
        x, y, θ = curve.x[inner], curve.y[inner], curve.q[inner]
        assert np.allclose(x**2, 9.81 * np.sin(θ) ** 4 / np.cos(θ), rtol=1e-7, atol=0)
        assert np.allclose(y, -9.81 * np.cos(θ) + x**2 / (2 * np.sin(θ) ** 2), rtol=1e-7, atol=1e-7)


def test_last_stable_orbits_of_schwarzschild() -> None:
    """Circular orbits with M = 1: E_t² = (r − 2)²/(r (r − 3)), L² = r²/(r − 3), stable beyond r = 6."""
    solution = hjsolve.solve("schwarzschild")
    window = {"alpha_2": (5.5, 9.0), "p_t": (-1.0, -0.93)}
    found = hjsolve.energy_momentum_map(
        solution, x="alpha_2", y="p_t", constants={"E": "-1/2", "p_phi": "1"}, window=window
    )
    for kind, side in (("relative equilibrium", 1), ("separatrix", -1)):
        circles = [c for c in curves(found, kind, "r") if len(c.x) > 5]
        assert circles
        for curve in circles:
            r, good = curve.q, (curve.q > 3.2) & (curve.q < 60) & (np.abs(curve.q - 6) > 1e-2)
            assert (side * (r[good] - 6) > 0).all()
            assert np.allclose(2 * curve.x[good], (r**2 / (r - 3))[good], rtol=1e-9, atol=0)
            assert np.allclose(curve.y[good] ** 2, ((r - 2) ** 2 / (r * (r - 3)))[good], rtol=1e-9, atol=0)


def test_the_lines_of_two_centres() -> None:
    """In the plane, |α₂| = (k₁ ∓ k₂) a m …: the motions along the line of the centres, at η = 0 and η = π."""
    found = hjsolve.energy_momentum_map(hjsolve.solve("two-centres-plane"))
    levels = {round(float(c.x[0]), 9) for c in found.curves if c.coordinate == "eta" and np.ptp(c.x) == 0}
    assert levels == {-0.5, 0.5}


@pytest.mark.parametrize("name", ["spherical-pendulum", "lagrange-top"])
def test_monodromy_round_the_isolated_critical_value(name: str) -> None:
    """Duistermaat, Comm. Pure Appl. Math. 33 (1980) 687; for the top Cushman and Knörrer (1985): one turn."""
    found = hjsolve.energy_momentum_map(hjsolve.solve(name), x="p_phi")
    (value,) = found.isolated
    turned = found.monodromy()
    assert turned.matrix in (((1, 0), (1, 1)), ((1, 0), (-1, 1)))
    assert not turned.trivial
    assert abs(turned.winding["phi"]) == 1
    if name == "spherical-pendulum":
        assert (value.x, value.y) == (0.0, 9.81)


def test_monodromy_of_kepler_is_trivial() -> None:
    found = hjsolve.energy_momentum_map(hjsolve.solve("kepler-planar"))
    assert found.isolated == ()
    assert found.monodromy((1.2, -0.2), 0.05).trivial


@pytest.mark.parametrize(("potential", "top"), [("cos(theta)", 0.0), ("-cos(theta)", np.pi)])
def test_the_isolated_value_is_found_at_either_pole(potential: str, top: float) -> None:
    """The pendulum at rest on top has E = 1, wherever its angle is counted from."""
    system = hjsolve.System(
        {"theta": "0 < theta < pi", "phi": "angle"}, "(dot(theta)**2 + sin(theta)**2*dot(phi)**2)/2", potential
    )
    window = {"p_phi": (-2, 2), "E": (-1.2, 2)}
    (value,) = hjsolve.energy_momentum_map(hjsolve.solve(system), x="p_phi", y="E", window=window).isolated
    assert (value.x, value.y, value.place) == pytest.approx((0, 1, top), abs=1e-12)


def test_a_circle_beside_the_isolated_value_has_trivial_monodromy() -> None:
    found = hjsolve.energy_momentum_map(hjsolve.solve("spherical-pendulum"))
    assert found.monodromy((1.0, 5.0), 0.05).trivial


def test_actions_are_those_of_kepler() -> None:
    """J_r = −|L| + k √(m/(−2E))."""
    found = hjsolve.energy_momentum_map(hjsolve.solve("kepler-planar"))
    x, y = np.array([1.0, 0.5, -1.2]), np.array([-0.3, -0.4, -0.1])
    J = found.actions_at(x, y)["r"]
    exact = 1 / np.sqrt(-2 * y) - np.abs(x)
    assert np.allclose(J.value, exact, rtol=1e-12, atol=0)
    assert np.isnan(found.actions_at(1.0, 0.1)["r"].value)


def test_the_map_is_drawn_and_stands_in_the_report(tmp_path) -> None:
    pytest.importorskip("matplotlib")
    solution = hjsolve.solve("kepler-planar")
    ax = hjsolve.energy_momentum_map(solution).plot()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["r librates", "r escapes"]
    page = hjsolve.report("kepler-planar", tmp_path / "kepler.html").read_text(encoding="utf-8")
    assert 'id="energy-momentum"' in page
    assert "Map of the kinds of motion" in page


@pytest.mark.nightly_cases("neumann-alpha-E + alpha_2 + 1", "neumann-beta-3*E + alpha_2")
@pytest.mark.parametrize(("name", "coordinate", "equation"), [
    ("neumann", "beta", "3*E + alpha_2"), ("neumann", "alpha", "E + alpha_2 + 1"), ("garnier", "eta", "E + alpha_2"),
])  # fmt: skip
def test_curves_at_places_known_to_thirty_digits_only_have_exact_equations(name, coordinate, equation) -> None:
    """At tan(θ/2) = √2 − 1 and the like; that P² and ∂P²/∂q vanish on them at q = ±π/2 is seen in the separated P²."""
    solution = hjsolve.solve(name)
    motion = solution.motion(**hjsolve.catalog.describe(name).motions["default"].arguments)
    found = hjsolve.energy_momentum_map(motion)
    curves = [c for c in found.curves if c.coordinate == coordinate and str(c.equation) == equation]
    assert curves
    q = solution.system.coordinate(coordinate).symbol
    values = {p.symbol: motion.initial.values[p.symbol] for p in solution.system.parameters}
    F = solution.momentum_squared[coordinate].subs(values)
    for constants in ({"E": 2, "alpha_2": 0}, {"E": -1, "alpha_2": 3}):
        point = {solution.constants[n].symbol: v for n, v in constants.items()}
        level = curves[0].equation.subs(point)
        for place in (sp.pi / 2, -sp.pi / 2):
            assert sp.simplify(sp.diff(F, q).subs(q, place).subs(point)) == 0
            assert (sp.simplify(F.subs(q, place).subs(point)) == 0) == (level == 0)
