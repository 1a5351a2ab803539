"""Orbits that run away are proved to, many at once: statuses and numbers are those of the engine of single motions."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.sign_at_infinity import sign_beyond, sign_beyond_for_all
from hjsolve.ensembles.engine import passes
from hjsolve.ensembles.engine.status import Status
from hjsolve.ensembles.fallback import single_orbit
from hjsolve.lowering import lower
from tests.support.entries import described, solution

pytestmark = pytest.mark.rotating_file(6)

WANT = {"actions", "constants", "turning_points"}
ESCAPING = [
    "kepler-planar", "isochrone", "kuzmin-kutuzov", "stark", "henon-heiles-separable", "helix-fixed", "morse",
    "liouville-three", "vinti", "projectile", "charge-in-monopole-field",
]  # fmt: skip


def scattered(name: str, count: int, seed: int) -> dict[str, Any]:
    """Starts about that of an entry, with speeds of all sizes."""
    given = next(iter(described(name).motions.values())).arguments
    kind = "velocity" if "velocity" in given else "p"
    rng = np.random.default_rng(seed)
    q = {k: float(sp.sympify(v)) for k, v in given["q"].items()}
    rates = {k: float(sp.sympify(v)) for k, v in given[kind].items()}
    return {
        "q": {k: v + 0.3 * rng.normal(size=count) * (abs(v) or 0.3) for k, v in q.items()},
        kind: {k: (v or 0.2) * rng.normal(size=count) * np.exp(1.5 * rng.normal(size=count)) for k, v in rates.items()},
    }


@pytest.mark.nightly_cases("kuzmin-kutuzov", "vinti")
@pytest.mark.parametrize("name", ESCAPING)
def test_what_is_proved_is_what_the_engine_of_single_motions_finds(name: str) -> None:
    starts = scattered(name, 30, 1)
    batch = hjsolve.ensemble(solution(name), want=WANT, threads=1, fallback=False, **starts)
    proved = np.flatnonzero(batch.codes == Status.UNBOUNDED)
    assert len(proved) > 2
    assert not batch.recomputed.any()
    for k in proved[:5]:
        one = {kind: {n: float(x[k]) for n, x in group.items()} for kind, group in starts.items()}
        status, row = single_orbit(solution(name), batch.layout, one, {}, endless=True)
        assert status is Status.UNBOUNDED
        for column in batch.layout.values():
            value, error = batch.columns[column][k], batch.columns[f"error.{column}"][k]
            if column in row:
                assert abs(value - row[column]) <= error + row[f"error.{column}"]
                assert error <= 1e-10 * (abs(value) + 1)
            else:
                assert np.isnan(value)


def test_nearly_all_escapes_are_proved_and_none_of_a_bound_orbit() -> None:
    rng = np.random.default_rng(5)
    count = 400
    r, theta = rng.uniform(0.5, 2, count), rng.uniform(0.2, 1.5, count)
    energy = rng.choice([-1, 1], count) * 10 ** rng.uniform(-13, 0, count)
    speed = np.sqrt(np.maximum(2 * energy + 2 / r - (theta / r) ** 2, 0)) * rng.choice([-1, 1], count)
    batch = hjsolve.ensemble(
        solution("kepler-planar"), q={"r": r, "theta": 0}, p={"r": speed, "theta": theta}, want=WANT, threads=1,
        fallback=False,
    )  # fmt: skip
    exact = [
        Fraction(p) ** 2 / 2 + Fraction(h) ** 2 / (2 * Fraction(x) ** 2) - 1 / Fraction(x)
        for p, h, x in zip(speed.tolist(), theta.tolist(), r.tolist(), strict=True)
    ]
    for E, code, claimed, error in zip(
        exact, batch.codes, batch.constants["E"], batch.error["constants"]["E"], strict=True
    ):
        assert code != (Status.OK if E >= 0 else Status.UNBOUNDED)
        if code in {Status.OK, Status.UNBOUNDED}:
            assert abs(Fraction(float(claimed)) - E) <= Fraction(float(error))
    away = np.array([E > 1e-12 for E in exact])
    assert np.mean(batch.codes[away] == Status.UNBOUNDED) > 0.97


@pytest.mark.parametrize("width", ["1/100", "1/3000", "1/100000"])
def test_a_narrow_barrier_on_the_way_is_not_overlooked(width: str) -> None:
    barrier = hjsolve.System(
        {"x": "line"}, "dot(x)**2/2", f"-exp(-x**2) + 5*exp(-((x - 23/3)/({width}))**2) + 5/cosh(x + 6)**2"
    )
    speeds = np.linspace(1.5, 3, 20)
    batch = hjsolve.ensemble(barrier, q={"x": 0.0}, p={"x": speeds}, want=WANT, fallback=False)
    assert not (batch.codes == Status.UNBOUNDED).any()


def test_a_start_beyond_a_barrier_has_the_turning_point_beyond_it() -> None:
    hill = hjsolve.System({"x": "line"}, "dot(x)**2/2", "2*exp(-x**2)")
    x, p = np.array([-3.0, 3.0, 3.0, -3.0, 0.5]), np.array([1.0, -1.0, 1.0, -1.0, 3.0])
    batch = hjsolve.ensemble(hill, q={"x": x}, p={"x": p}, want=WANT, fallback=False)
    assert (batch.codes == Status.UNBOUNDED).all()
    energy = p**2 / 2 + 2 * np.exp(-(x**2))
    lower_end, upper_end = batch.turning_points["x"]
    turn = np.sqrt(np.log(2 / energy[:4]))
    np.testing.assert_allclose(upper_end[[0, 3]], -turn[[0, 3]], rtol=1e-14, atol=0)
    np.testing.assert_allclose(lower_end[[1, 2]], turn[[1, 2]], rtol=1e-14, atol=0)
    assert np.isnan(lower_end[[0, 3, 4]]).all()
    assert np.isnan(upper_end[[1, 2, 4]]).all()


def test_an_end_of_a_domain_is_no_escape() -> None:
    wall = hjsolve.System({"x": "0 < x < 10"}, "dot(x)**2/2", "1/x")
    batch = hjsolve.ensemble(wall, q={"x": [1.0, 2.0]}, p={"x": [3.0, -0.1]}, want=WANT, fallback=False)
    assert not (batch.codes == Status.UNBOUNDED).any()


def test_without_the_proof_nothing_is_called_unbounded(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(one: Any, _model: object, offsets: np.ndarray) -> Any:
        return np.zeros(len(one.q), dtype=bool), np.full_like(offsets, np.nan)

    monkeypatch.setattr(passes, "escaping", nothing)
    starts = scattered("projectile", 10, 1)
    batch = hjsolve.ensemble(solution("projectile"), want=WANT, fallback=False, **starts)
    assert (batch.codes == Status.NOT_CONVERGED).all()


# ------------------------------------------------------------------------------------------------ signs for a box
def test_the_sign_for_a_box_is_that_of_each_of_its_corners() -> None:
    x, a, b, c = sp.symbols("x a b c")
    rng = np.random.default_rng(8)
    convert = Multi(256).convert
    known = 0
    for k in range(60):
        formula = [a + b / x - c / x**2, a * sp.sqrt(1 + x**2) + b * x + c, (a * x**2 + b * x + c) / (x**2 + 3),
                   a * sp.exp(-x) + b / x + c / sp.sqrt(x)][k % 4]  # fmt: skip
        low = rng.normal(size=3) * 10 ** rng.uniform(-3, 3, size=3)
        high = low + np.abs(rng.normal(size=3)) * np.abs(low) * rng.choice([0.1, 1, 10])
        tape = lower([formula], [x, a, b, c])
        ranges = [(convert(one), convert(other)) for one, other in zip(low, high, strict=True)]
        sign = sign_beyond_for_all(tape, ranges, 1, 2.0**24)
        known += sign != 0
        for corner in range(8):
            at = [pair[(corner >> j) & 1] for j, pair in enumerate(ranges)]
            single = sign_beyond(tape, at, 1, 2.0**24)
            assert not sign or single in {0, sign}
            value = tape.run(Multi(256), [convert(2.0**24), *at])[0]
            assert not sign or sign * value > 0
    assert known > 20


def test_stars_in_cartesian_coordinates_that_run_away_are_proved_to_in_the_batch() -> None:
    # each went to a single motion, 0.2 s: a hundredth of a table of stars took longer than the rest
    space = hjsolve.System(
        {"x": "line", "y": "line", "z": "line"}, "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", "-1/sqrt(1 + x**2 + y**2 + z**2)"
    )  # fmt: skip
    rng = np.random.default_rng(3)
    q, velocity = (dict(zip("xyz", scale * rng.normal(size=(3, 60)), strict=True)) for scale in (6.0, 0.5))
    known = {"q": q, "velocity": velocity, "coordinates": "find", "shown": False, "want": ["constants", "actions"]}
    batch = hjsolve.ensemble(space, fallback=False, **known)
    energy = sum(v * v for v in velocity.values()) / 2 - 1 / np.sqrt(1 + sum(x * x for x in q.values()))
    assert set(batch.status) == {"ok", "unbounded"}
    assert ((batch.status == "unbounded") == (energy >= 0)).all()
    runaway = np.flatnonzero(energy >= 0)[:3]
    solution = hjsolve.solve(space, "find")
    for i in runaway:
        start = {"q": {k: float(x[i]) for k, x in q.items()}, "velocity": {k: float(v[i]) for k, v in velocity.items()}}
        motion = solution.motion(**start, digits=25)
        for name, action in motion.actions.items():
            off = abs(float(batch.actions[name][i]) - float(action.value))
            assert off <= batch.error["actions"][name][i] + 1e-16 * abs(float(action.value)), name


def test_actions_next_to_an_escape_from_far_out():
    """E and α₂ cancel to 1e-7 of themselves: their rounding moved J by 1e-10, and no claim counted it.

    J by a quadrature of 50 digits between the roots of p².
    """
    q = {"u": [-0.6438002192110047, -0.5779546385342301], "v": [-133.68728028569004, -47.73514718451622]}
    p = {"u": [0.008053983491553505, 0.002103371671492781], "v": [0.0005727049344845503, 0.002675810723290351]}
    want = {"actions", "frequencies", "turning_points"}
    batch = hjsolve.ensemble("henon-heiles-separable", q=q, p=p, parameters={"c": 1}, want=want, fallback=False)
    right = [0.092285408406135449933, 0.084393558333330603840]
    off = np.abs(batch.columns["actions.u"] - right)
    assert (batch.columns["status"] == Status.UNBOUNDED).all()
    assert (off <= batch.columns["error.actions.u"]).all()
    assert (batch.columns["error.actions.u"] < 1e-15).all()


def test_actions_next_to_an_escape_by_chords():
    """Turning points in doubles move J of a cone by 5e-14: without kernels a bound left that out, or took its half.

    J by a quadrature of 40 digits in χ, cos θ = m − h cos χ.
    """
    q = {"r": [0.07648261295911948], "theta": [1.0641092094265658], "phi": [2.6776325192274255]}
    p = {"r": [0.17426062992990962], "theta": [1.8328028690011584], "phi": [0.001051615480108558]}
    parameters = {"m": 1.820294032006757, "g": 0.9988576838536654}
    want = {"actions", "frequencies"}
    batch = hjsolve.ensemble("charge-in-monopole-field", q=q, p=p, parameters=parameters, want=want, fallback=False)
    off = np.abs(batch.columns["actions.theta"] - 1.169372759787573958615677)
    assert (off <= batch.columns["error.actions.theta"]).all()
    assert (batch.columns["error.actions.theta"] < 1e-14).all()
