"""Many orbits at once against references, the single-orbit engine at 30 digits, and laws."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles import engine as batch
from hjsolve.ensembles.engine import Status
from hjsolve.errors import InvalidInputError
from tests.support import kuzmin_kutuzov as galaxy

TIMED = frozenset({"actions", "frequencies", "periods", "angles", "turning_points", "constants"})


def apart(x: float, y: float) -> float:
    """Distance on the circle."""
    return abs((x - y + np.pi) % (2 * np.pi) - np.pi)


@pytest.mark.parametrize("family", range(5))
def test_kuzmin_kutuzov_orbits_meet_their_references(family: int) -> None:
    data = galaxy.load()
    chosen = data["family"] == family
    engine = batch.build(galaxy.solution(), frozenset({"actions", "frequencies"}))
    columns = engine.run(*galaxy.start(data["prolate"][chosen]))
    assert (columns.status == Status.OK).all()
    for k, (quantity, name) in enumerate(galaxy.COLUMNS):
        high, low, floor = (
            data[key][chosen, k] for key in ("reference_prolate_high", "reference_prolate_low", "floor_prolate")
        )
        error = np.abs((columns.group(quantity)[name] - high) - low)
        assert (error <= np.maximum(1e-12, 20 * floor) * np.abs(high)).all(), (quantity, name)
        assert (error <= columns.error[f"{quantity}.{name}"]).all(), (quantity, name)


STARTS = {
    "pendulum": ({"theta": (-2.5, 2.5)}, {"theta": (-0.9, 0.9)}),
    "kepler-planar": ({"r": (0.7, 1.5), "theta": (-3, 3)}, {"r": (-0.4, 0.4), "theta": (0.3, 0.9)}),
    "spherical-pendulum": ({"theta": (0.4, 2.7), "phi": (-3, 3)}, {"theta": (-0.8, 0.8), "phi": (-0.9, 0.9)}),
    "lagrange-top": (
        {"psi": (-3, 3), "theta": (-1.2, 1.2), "phi": (-3, 3)},
        {"psi": (0.2, 0.9), "theta": (-0.5, 0.5), "phi": (0.2, 0.9)},
    ),
    "double-well": ({"x": (-1.5, 1.5)}, {"x": (-0.9, 0.9)}),
    "spherical-staeckel": (
        {"r": (0.7, 1.5), "theta": (0.6, 2.5), "phi": (-1, 1)},
        {"r": (-0.4, 0.4), "theta": (-0.4, 0.4), "phi": (-0.4, 0.4)},
    ),
}


@pytest.mark.parametrize("name", STARTS)
def test_numbers_and_errors_agree_with_single_orbits_at_thirty_digits(name: str) -> None:
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    rng, count = np.random.default_rng(sum(map(ord, name))), 2
    q, p = ({c: rng.uniform(*span, count) for c, span in spans.items()} for spans in STARTS[name])
    columns = batch.build(solution, TIMED).run(q, p)
    assert (columns.status == Status.OK).any()
    for i in np.flatnonzero(columns.status == Status.OK):
        motion = solution.motion(
            q={c: float(v[i]) for c, v in q.items()}, p={c: float(v[i]) for c, v in p.items()}, digits=30,
            want={"actions", "frequencies", "periods", "angles", "turning_points"},
        )  # fmt: skip
        for quantity in ("actions", "frequencies", "periods"):
            expected = getattr(motion, quantity)
            assert set(expected) == set(columns.group(quantity))
            for c, estimate in expected.items():
                error = abs(mpmath.mpf(float(columns.group(quantity)[c][i])) - estimate.value)
                assert error <= columns.error[f"{quantity}.{c}"][i] <= 1e-10 * abs(estimate.value) + 1e-300, (
                    quantity,
                    c,
                )
        for c, (lower, upper) in motion.turning_points.items():
            for side, end in (("lower", lower), ("upper", upper)):
                error = abs(mpmath.mpf(float(columns.turning_points[f"{c}.{side}"][i])) - end.value)
                assert error <= columns.error[f"turning_points.{c}.{side}"][i], (c, side)
        if "rotation" in motion.kinds.values():
            continue
        for c, angle in motion.angles(0).items():
            assert apart(float(angle), columns.angles[c][i]) <= columns.error[f"angles.{c}"][i] + 4e-15, c


def test_angles_grow_with_the_frequencies() -> None:
    solution = galaxy.solution()
    engine = batch.build(solution, frozenset({"frequencies", "angles"}))
    data = galaxy.load()
    row = data["prolate"][5]
    q, p = ({c: float(v[0]) for c, v in part.items()} for part in galaxy.start(row[None]))
    motion = solution.motion(q=q, p=p)
    times = np.linspace(0, 40, 9)
    states = motion.at(times)
    names = list(q)
    columns = engine.run({c: states.q[c] for c in names}, {c: states.p[c] for c in names})
    for c in names:
        θ, Ω = columns.angles[c], columns.frequencies[c]
        grown = θ[0] + Ω[0] * times
        assert max(apart(a, b) for a, b in zip(θ, grown, strict=True)) < 1e-12


def test_a_rotation_winds_evenly_too() -> None:
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    motion = solution.motion(q={"theta": 0.3}, p={"theta": -2.9})
    times = np.linspace(0, 9, 7)
    states = motion.at(times)
    columns = batch.build(solution, frozenset({"frequencies", "angles"})).run(
        {"theta": states.q["theta"]}, {"theta": states.p["theta"]}
    )
    assert (columns.status == Status.OK).all()
    θ, Ω = columns.angles["theta"], columns.frequencies["theta"]
    assert max(apart(a, b) for a, b in zip(θ, θ[0] + Ω[0] * times, strict=True)) < 1e-12


def test_frequencies_are_the_slopes_of_the_energy_over_the_actions() -> None:
    """ΔE = Σ Ω ΔJ to third order between two near orbits (trapezoid)."""
    engine = batch.build(galaxy.solution(), frozenset({"constants", "actions", "frequencies"}))
    row = galaxy.load()["prolate"][7]
    pair = np.stack([row, row * (1 + 1e-4 * np.array([0.3, -0.2, 0.5, 0.4, -0.6]))])
    columns = engine.run(*galaxy.start(pair))
    ΔE = np.diff(columns.constants["E"])[0]
    sums = sum(np.mean(columns.frequencies[c]) * np.diff(columns.actions[c])[0] for c in ("u", "w", "phi"))
    assert abs(ΔE - sums) < 1e-7 * abs(ΔE)


def test_pendulum_towards_the_separatrix_is_right_or_left_alone() -> None:
    """T = 4 K(k); where the forbidden gap at θ = π is too narrow to be met, the orbit has no number, not a wrong one."""
    solution = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    θ = np.array([np.pi - 2.0**-k for k in (1, 2, 4, 10, 16, 20)])
    columns = batch.build(solution, frozenset({"actions", "periods"}), {"m": 1, "g": 1, "l": 1}).run(
        {"theta": θ}, {"theta": np.full(6, 2.0**-30)}
    )
    assert (columns.status[:3] == Status.OK).all()
    with mpmath.workdps(50):
        for i in np.flatnonzero(columns.status == Status.OK):
            k2 = mpmath.sin(mpmath.mpf(float(θ[i])) / 2) ** 2 + mpmath.mpf(2) ** -62
            period = 4 * mpmath.ellipk(k2)
            assert abs(columns.periods["theta"][i] - period) <= min(columns.error["periods.theta"][i], 1e-12 * period)


def test_statuses_name_what_is_not_bounded() -> None:
    kepler = batch.build(hjsolve.solve(hjsolve.catalog.load("kepler-planar")), frozenset({"actions"}))
    q = {"r": np.array([1.0, 1.0, -1.0, np.nan]), "theta": np.zeros(4)}
    p = {"r": np.array([0.1, 3.0, 0.1, 0.1]), "theta": np.ones(4)}
    columns = kepler.run(q, p)
    assert columns.status[0] == Status.OK
    assert columns.status[1] == Status.UNBOUNDED
    assert columns.status[2] != Status.OK
    assert columns.status[3] != Status.OK
    assert np.isnan(columns.actions["r"][1:]).all()
    well = batch.build(hjsolve.solve(hjsolve.catalog.load("double-well")), frozenset({"actions", "frequencies"}))
    rest = well.run({"x": np.array([0.0])}, {"x": np.array([0.0])})
    assert rest.status[0] != Status.OK


def test_a_narrow_barrier_is_not_jumped_over() -> None:
    """p_φ = 1e-9: the barrier at the axis is 1e-9 wide, and halves the region."""
    data = galaxy.load()
    row = data["prolate"][data["family"] == 0][:8].copy()
    row[:, 4] = 1e-9
    columns = batch.build(galaxy.solution(), frozenset({"actions", "turning_points"})).run(*galaxy.start(row))
    good = columns.status == Status.OK
    assert good.any()
    assert (columns.turning_points["u.lower"][good] > 0).all()
    assert (np.abs(columns.turning_points["w.upper"][good]) < np.pi / 2 + 1e-15).all()


def test_what_is_not_wanted_is_not_there() -> None:
    columns = batch.build(galaxy.solution(), frozenset({"actions"})).run(*galaxy.start(galaxy.load()["prolate"][:2]))
    assert not columns.frequencies
    assert set(columns.error) == {"actions.u", "actions.w", "actions.phi"}


def test_an_unknown_quantity_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="colour"):
        batch.build(galaxy.solution(), frozenset({"colour"}))
