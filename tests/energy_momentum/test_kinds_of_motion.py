"""Kinds read off a map are those of motions started one by one, and the isolation of roots is that of exact algebra."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.energy_momentum.isolation import isolated_roots

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "energy_momentum.py"


def benchmark():
    spec = importlib.util.spec_from_file_location("energy_momentum_benchmark", BENCHMARK)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


FEW = ["kepler-planar", "spherical-pendulum", "stark", "two-centres-plane", "henon-heiles-kdv", "torus-geodesics"]


@pytest.mark.nightly_cases("stark", "two-centres-plane")
@pytest.mark.rotating(2)
@pytest.mark.parametrize("name", FEW)
def test_random_points_have_the_kinds_of_motions_started_there(name: str) -> None:
    (found,) = benchmark().differing(name, 12, np.random.default_rng(20261122))
    wrong, moved, refused, _, _ = found
    assert wrong == ""
    assert moved >= 1
    assert moved + refused == 12


@pytest.mark.nightly
@pytest.mark.timeout(3000)
def test_ten_thousand_random_points_have_the_kinds_of_motions() -> None:
    assert benchmark().main(10_000, 3) == 0


@pytest.mark.parametrize(("E", "kinds"), [
    ("-0.3", ("libration",)), ("0", ("escape",)), ("0.1", ("escape",)), ("-0.5", ("equilibrium",)), ("-0.51", ()),
])  # fmt: skip
def test_kepler_on_and_beside_its_critical_curves(E: str, kinds: tuple[str, ...]) -> None:
    """With p_theta = 1: the circle at E = −1/2, the edge of escape at E = 0."""
    found = hjsolve.energy_momentum_map(hjsolve.solve("kepler-planar"))
    assert found.kinds_at(1.0, float(E))["r"] == kinds


def test_a_field_that_pulls_has_a_well_beside_an_escape() -> None:
    found = hjsolve.energy_momentum_map(hjsolve.solve("stark"), x="alpha_2")
    assert set(found.kinds_at(*found.point)["v"]) == {"libration", "escape"}


@pytest.mark.nightly
def test_a_coordinate_without_a_polynomial_is_decided_by_the_exact_search() -> None:
    solution = hjsolve.solve("kuzmin-kutuzov")
    entry = hjsolve.catalog.describe("kuzmin-kutuzov")
    motion = solution.motion(**entry.motions["default"].arguments, want=["constants", "turning_points"])
    found = hjsolve.energy_momentum_map(motion, x="p_phi")
    assert found.coordinates[0].polynomial is None
    places = {name: float(sp.N(motion.initial.values[solution.system.coordinate(name).symbol])) for name in ("u", "w")}
    assert found.kinds_at(*found.point, q=places) == dict(motion.kinds)


def test_roots_of_random_polynomials_are_counted_as_by_exact_algebra() -> None:
    """Random integer coefficients, in Bernstein's form on (0, 1); sympy counts by Sturm's theorem."""
    rng, t, degree = np.random.default_rng(5), sp.Symbol("t"), 7
    rows = rng.integers(-9, 10, (60, degree + 1))
    rows[:, [0, -1]] = np.where(rows[:, [0, -1]] == 0, 1, rows[:, [0, -1]])
    found = isolated_roots(rows.astype(float), np.full(rows.shape, 1e-13))
    assert found.doubtful.sum() <= 1
    for i in np.flatnonzero(~found.doubtful):
        exact = sum(int(c) * sp.binomial(degree, k) * t**k * (1 - t) ** (degree - k) for k, c in enumerate(rows[i]))
        polynomial = sp.Poly(sp.expand(exact), t)
        assert found.count[i] == polynomial.count_roots(0, 1)
        mine = found.owner == i
        assert all(
            polynomial.count_roots(sp.Rational(a), sp.Rational(b)) == 1
            for a, b in zip(found.low[mine], found.high[mine])
        )


def test_a_double_root_is_called_doubtful() -> None:
    t = np.array([[0.25, -0.25, 0.25]])  # (t − 1/2)²
    assert isolated_roots(t, np.full(t.shape, 1e-15)).doubtful.all()


@pytest.mark.parametrize("call", [
    lambda s: hjsolve.energy_momentum_map(s, x="p_theta", y="p_theta"),
    lambda s: hjsolve.energy_momentum_map(s, x="nothing"),
    lambda s: hjsolve.energy_momentum_map(s, window={"p_theta": (1, 0), "E": (0, 1)}),
    lambda s: hjsolve.energy_momentum_map("kepler-planar"),
    lambda s: hjsolve.energy_momentum_map(hjsolve.solve("pendulum")),
    lambda s: hjsolve.energy_momentum_map(s).kinds_at(float("nan"), 0.0),
    lambda s: hjsolve.energy_momentum_map(s).kinds_at([1, 2], [1, 2, 3]),
    lambda s: hjsolve.energy_momentum_map(s).kinds_at(1, 0, q={}),
    lambda s: hjsolve.energy_momentum_map(s).monodromy(),
    lambda s: hjsolve.energy_momentum_map(s).monodromy((1.0, -0.5), 0.1),
])  # fmt: skip
def test_bad_input_gives_one_clear_error(call) -> None:
    with pytest.raises(hjsolve.InvalidInputError):
        call(hjsolve.solve("kepler-planar"))
