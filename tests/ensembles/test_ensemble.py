"""Many orbits at once: right numbers with honest errors, one status an orbit, one clear error at the door."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles import compute, fallback
from hjsolve.errors import InvalidInputError, MissingValueError, NotConvergedError

GOOD: dict[str, Any] = {"q": {"r": [1.0, 2.0], "theta": 0.5}, "p": {"r": [0.1, 0.0], "theta": [1.1, 1.2]}}


def kepler(q: dict[str, Any], p: dict[str, Any], **options: Any) -> hjsolve.Batch:
    return hjsolve.ensemble("kepler-planar", q=q, p=p, **options)


def random_kepler(count: int, seed: int = 1) -> tuple[dict[str, Any], dict[str, Any]]:
    """Bound orbits, anticlockwise and clockwise, of eccentricities 0.05 … 0.95."""
    generator = np.random.default_rng(seed)
    e, a = generator.uniform(0.05, 0.95, count), generator.uniform(0.5, 2.0, count)
    anomaly = generator.uniform(-3.0, 3.0, count)
    L = np.sqrt(a * (1 - e**2)) * np.where(generator.random(count) < 0.5, 1, -1)
    r = L**2 / (1 + e * np.cos(anomaly))
    return {"r": r, "theta": generator.uniform(-3, 3, count)}, {"r": e * np.sin(anomaly) / np.abs(L), "theta": L}


def closed_form(r: float, theta: float, p_r: float, p_theta: float) -> dict[str, Any]:
    """Kepler's orbit, m = k = 1, to 40 digits: Greenwood Ex 5-2; angles from the mean anomaly."""
    with mpmath.workdps(60):
        r, p_r, L = mpmath.mpf(r), mpmath.mpf(p_r), mpmath.mpf(p_theta)
        E = p_r**2 / 2 + L**2 / (2 * r**2) - 1 / r
        a, e = -1 / (2 * E), mpmath.sqrt(1 + 2 * E * L**2)
        Ω = (-2 * E) ** mpmath.mpf("1.5")
        u = mpmath.atan2(r * p_r / mpmath.sqrt(a), 1 - r / a)
        mean = u - e * mpmath.sin(u)
        true = 2 * mpmath.atan2(mpmath.sqrt(1 + e) * mpmath.sin(u / 2), mpmath.sqrt(1 - e) * mpmath.cos(u / 2))
        turned = theta - mpmath.sign(L) * (true - mean)
        return {
            "constants.E": E, "constants.p_theta": L, "actions.r": 1 / mpmath.sqrt(-2 * E) - abs(L),
            "actions.theta": L, "frequencies.r": Ω, "frequencies.theta": Ω * mpmath.sign(L),
            "periods.r": 2 * mpmath.pi / Ω, "periods.theta": 2 * mpmath.pi / Ω,
            "turning_points.r.lower": a * (1 - e), "turning_points.r.upper": a * (1 + e),
            "angles.r": mean, "angles.theta": turned,
        }  # fmt: skip


def distance(column: str, value: float, true: Any) -> Any:
    with mpmath.workdps(60):
        far = mpmath.mpf(value) - true
        return (
            abs(far - 2 * mpmath.pi * mpmath.nint(far / (2 * mpmath.pi))) if column.startswith("angles") else abs(far)
        )


NARROW = {
    "constants": 3e-14, "actions": 2e-13, "turning_points": 1e-13, "frequencies": 1e-11, "periods": 3e-11, "angles": 5e-11,
}  # fmt: skip
"""How narrow claims are: some ten to a hundred times the true errors, which grow by n from J to its slopes."""


# ------------------------------------------------------------------------------------------------ numbers
def test_numbers_of_kepler_are_those_of_the_closed_form_and_errors_hold() -> None:
    q, p = random_kepler(24)
    batch = kepler(q, p)
    assert (batch.status == "ok").all()
    for k in range(24):
        for column, true in closed_form(q["r"][k], q["theta"][k], p["r"][k], p["theta"][k]).items():
            far, claimed = distance(column, batch.columns[column][k], true), batch.columns[f"error.{column}"][k]
            assert far <= claimed, (k, column, far, claimed)
            assert far <= 1e-12 * max(1.0, abs(float(true))), (k, column, far)
            assert claimed <= NARROW[column.split(".")[0]] * max(1.0, abs(float(true))), (k, column, claimed)


def test_velocities_count_as_exact_though_their_momenta_are_rounded() -> None:
    """Near-circular: the action J_r moves by a thousand times its own rounding with the last bit of p_θ."""
    r, speed = 1.1, 0.8668435987
    near = [speed * (1 + k * 1e-9) for k in range(4)]
    batch = hjsolve.ensemble(
        "kepler-planar", q={"r": r, "theta": 0}, velocity={"r": 1e-7, "theta": near}, want="actions"
    )
    for k, rate in enumerate(near):
        with mpmath.workdps(60):
            L = mpmath.mpf(r) ** 2 * mpmath.mpf(rate)
            E = mpmath.mpf(1e-7) ** 2 / 2 + (L / r) ** 2 / 2 - 1 / mpmath.mpf(r)
            true = 1 / mpmath.sqrt(-2 * E) - L
        assert abs(mpmath.mpf(batch.actions["r"][k]) - true) <= batch.error["actions"]["r"][k] < 1e-12
        assert abs(mpmath.mpf(batch.actions["theta"][k]) - L) <= batch.error["actions"]["theta"][k] < 1e-15


def test_an_orbit_does_not_depend_on_its_company() -> None:
    q, p = random_kepler(6)
    whole = kepler(q, p, threads=1)
    for k in range(6):
        alone = kepler({n: x[k] for n, x in q.items()}, {n: x[k] for n, x in p.items()})
        assert alone.shape == ()
        for name, column in whole.columns.items():
            assert np.array_equal(alone.columns[name], column[k], equal_nan=True), name


@pytest.mark.parametrize(("chunk", "threads"), [(1, 1), (3, 2), (5, 3), (100, 2)])
def test_chunks_and_threads_do_not_change_a_bit(chunk: int, threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    q, p = random_kepler(12, seed=2)
    usual = kepler(q, p, threads=1)
    monkeypatch.setattr(compute, "CHUNK", chunk)
    other = kepler(q, p, threads=threads)
    assert other.columns.keys() == usual.columns.keys()
    assert all(other.columns[name].tobytes() == column.tobytes() for name, column in usual.columns.items())


# ------------------------------------------------------------------------------------------------ statuses
def test_a_bad_orbit_gets_a_status_and_the_others_their_numbers() -> None:
    r = [1.0, np.nan, 1.0, -1.0, 1.0, 1.0, 0.0, np.inf]
    p_r = [0.1, 0.1, np.inf, 0.1, 2.0, 0.1, 0.1, 0.1]
    L = [1.1, 1.1, 1.1, 1.1, 1.1, 0.0, 1.1, 1.1]
    batch = kepler({"r": r, "theta": 0.0}, {"r": p_r, "theta": L})
    assert batch.status.tolist() == [
        "ok", "not_finite", "not_finite", "outside_domain", "unbounded", "reaches_boundary", "outside_domain", "not_finite",
    ]  # fmt: skip
    assert np.isfinite(batch.actions["r"]).tolist() == [True] + 7 * [False]
    assert batch.actions["r"][0] == kepler({"r": 1.0, "theta": 0.0}, {"r": 0.1, "theta": 1.1}).actions["r"]
    assert batch.constants["E"][4] == pytest.approx(2 + 1.21 / 2 - 1, rel=1e-15)
    assert batch.summary() | {"recomputed": 0} == {
        "ok": 1, "unbounded": 1, "reaches_boundary": 1, "outside_domain": 2, "not_finite": 3, "recomputed": 0,
    }  # fmt: skip


def test_a_separatrix_is_asymptotic_and_a_double_domain_end_is_outside() -> None:
    """H = p²/2 − cos θ with p = 2 cos(θ/2) is the pendulum's separatrix; at θ = 0 exactly p = 2 in doubles."""
    pendulum = hjsolve.System({"x": "angle"}, "dot(x)**2/2", "-cos(x)")
    batch = hjsolve.ensemble(pendulum, q={"x": 0.0}, p={"x": [1.0, 2.0, 3.0]}, want={"actions", "frequencies"})
    assert batch.status.tolist() == ["ok", "asymptotic", "ok"]
    box = hjsolve.System({"x": "-1/3 < x < 1"}, "dot(x)**2/2", "x**2/2")
    third = -1 / 3  # the double lies above −1/3, inside
    assert Fraction(third) > Fraction(-1, 3)
    edge = hjsolve.ensemble(box, q={"x": [third, np.nextafter(third, -1), 1.0]}, p={"x": 0.01}, want="constants")
    assert edge.status.tolist() == ["reaches_boundary", "outside_domain", "outside_domain"]


def test_statuses_tell_what_they_mean() -> None:
    assert {status.word for status in hjsolve.Status} == {
        "ok", "unbounded", "asymptotic", "reaches_boundary", "forbidden", "outside_domain", "not_finite", "not_converged",
        "ambiguous",
    }  # fmt: skip
    assert all(status.meaning for status in hjsolve.Status)
    batch = kepler(**GOOD, want="constants")
    assert [hjsolve.Status(code) for code in batch.codes] == [hjsolve.Status.OK] * 2


def test_without_fallback_no_orbit_is_computed_singly() -> None:
    q, p = random_kepler(5)
    batch = kepler(q, p, fallback=False)
    assert not batch.recomputed.any()
    assert np.isnan(batch.actions["r"][batch.status != "ok"]).all()


# ------------------------------------------------------------------------------------------------ shapes, types, want
@pytest.mark.nightly
def test_an_orbit_whose_angles_are_lost_stops_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    """Found among 5 000 nearly unbound orbits: the error of one orbit's phases came out of the whole ensemble."""

    def lost(_motion: object) -> None:
        raise NotConvergedError("the phases could not be followed")

    monkeypatch.setattr(fallback, "_angles", lost)
    given = {"q": {"theta": [0.5, np.pi]}, "p": {"theta": [0.0, 1e-9]}}
    batch = hjsolve.ensemble("pendulum", **given, want={"actions", "angles"})
    assert batch.status.tolist() == ["ok", "not_converged"]


def test_any_shape_is_kept_and_scalars_spread() -> None:
    r = np.array([[1.0, 1.2, 1.4], [1.6, 1.8, 2.0]])
    batch = kepler({"r": r, "theta": 0}, {"r": np.zeros((2, 1)), "theta": "1.1"}, want={"actions", "turning_points"})
    assert batch.actions["r"].shape == batch.status.shape == batch.error["turning_points"]["r"][0].shape == (2, 3)
    flat = kepler({"r": r.ravel(), "theta": 0}, {"r": 0, "theta": "1.1"}, want="actions")
    assert np.array_equal(batch.actions["r"].ravel(), flat.actions["r"])
    assert kepler({"r": [], "theta": 0}, {"r": 0, "theta": 1}).actions["r"].shape == (0,)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, np.longdouble, np.int8, np.int64, np.uint16])
def test_every_real_type_becomes_float64(dtype: type) -> None:
    batch = kepler(
        {"r": np.array([1, 2], dtype), "theta": dtype(0)}, {"r": dtype(0), "theta": dtype(1)}, want="constants"
    )
    assert batch.constants["E"].dtype == np.float64
    assert batch.constants["E"].tolist() == [-0.5, -0.375]


def test_only_what_is_wanted_is_there() -> None:
    batch = kepler(**GOOD, want=["actions"])
    assert set(batch.columns) == {
        "status", "recomputed", "actions.r", "actions.theta", "error.actions.r", "error.actions.theta",
    }  # fmt: skip
    assert set(batch.error) == {"actions"}
    with pytest.raises(InvalidInputError, match=r'"frequencies" was not computed; add it to want'):
        _ = batch.frequencies


def test_system_solution_and_name_give_the_same() -> None:
    system = hjsolve.catalog.load("kepler-planar")
    by = [hjsolve.ensemble(x, **GOOD, want="actions") for x in (system, hjsolve.solve(system), "kepler-planar")]
    assert all(np.array_equal(b.actions["r"], by[0].actions["r"]) for b in by)
    heavy = hjsolve.ensemble(system, **GOOD, parameters={"k": "3"}, want="actions")
    assert (heavy.actions["r"] > by[0].actions["r"]).all()


# ------------------------------------------------------------------------------------------------ the door
@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"q": {"r": 1.0}}, MissingValueError, "q: no values for theta"),
        ({"q": {"radius": 1.0, "theta": 0}}, InvalidInputError, 'q: no coordinate "radius"'),
        ({"q": [1.0, 0.0]}, InvalidInputError, "q: must map coordinates to arrays"),
        ({"q": {"r": [1.0, 2.0, 3.0], "theta": [0.0, 1.0]}}, InvalidInputError, r"q\[r\] \(3,\), q\[theta\] \(2,\)"),
        ({"q": {"r": [1j, 1], "theta": 0}}, InvalidInputError, r"q\[r\]: must hold real numbers, not complex128"),
        ({"q": {"r": 1j, "theta": 0}}, InvalidInputError, r"q\[r\]"),
        ({"q": {"r": [True], "theta": 0}}, InvalidInputError, r"q\[r\]: must hold real numbers, not bool"),
        ({"q": {"r": ["1", "2"], "theta": 0}}, InvalidInputError, r"q\[r\]: must hold real numbers"),
        ({"q": {"r": [[1], [1, 2]], "theta": 0}}, InvalidInputError, "rows have different lengths"),
        ({"q": {"r": np.ma.array([1.0], mask=[True]), "theta": 0}}, InvalidInputError, "masked"),
        ({"velocity": {"r": 0, "theta": 1}}, InvalidInputError, "either p=.* or velocity="),
        ({"p": None}, InvalidInputError, "either p=.* or velocity="),
        ({"want": "action"}, InvalidInputError, 'want: "action" .* did you mean "actions"'),
        ({"want": {"trajectory"}}, InvalidInputError, 'want: "trajectory"'),
        ({"want": ()}, InvalidInputError, "want: is empty"),
        ({"parameters": {"k": [1, 2]}}, InvalidInputError, r"parameters\[k\]: one number for all orbits"),
        ({"parameters": {"g": 1}}, InvalidInputError, "'g' is not a parameter"),
        ({"threads": 0}, InvalidInputError, "threads: a whole number"),
    ],
)
def test_one_clear_error_at_the_door(change: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message) as caught:
        hjsolve.ensemble("kepler-planar", **{**GOOD, **change})
    assert "\n" not in str(caught.value)


def test_what_is_no_system_and_what_does_not_separate_are_refused() -> None:
    with pytest.raises(InvalidInputError, match="a System is needed"):
        hjsolve.ensemble(3.0, **GOOD)  # type: ignore[arg-type]
    with pytest.raises(hjsolve.NotSeparableError):
        hjsolve.ensemble("henon-heiles", q={"x": 0, "y": 0}, p={"x": 1, "y": 1})


# ------------------------------------------------------------------------------------------------ solved once
def test_equal_systems_share_one_solution_and_refusals_are_not_remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    from hjsolve.solution import quadratures

    calls = []
    separate = quadratures.separate
    monkeypatch.setattr(
        quadratures, "separate", lambda system, **kwargs: (calls.append(system), separate(system, **kwargs))[1]
    )

    def oscillator(name: str) -> hjsolve.System:
        return hjsolve.System({name: "line"}, f"dot({name})**2/2", f"11*{name}**2/2", title="solved once")

    assert hjsolve.solve(oscillator("x")) is hjsolve.solve(oscillator("x"))
    assert hjsolve.solve(oscillator("y")) is not hjsolve.solve(oscillator("x"))
    assert len(calls) == 2
    for _ in range(2):
        with pytest.raises(hjsolve.NotSeparableError):
            hjsolve.solve(hjsolve.catalog.load("henon-heiles"))
    assert len(calls) == 4


def test_orbits_that_fall_into_the_centre_are_told_without_integrals_of_the_time(monkeypatch):
    """What is below −L²/2 r² at the centre draws them in; 0.7 s an orbit went into a time law that nobody asks for."""

    def refused(coordinate_motions):
        raise AssertionError(f"times of {len(coordinate_motions)} coordinates")

    monkeypatch.setattr("hjsolve.motion.separated.plan", refused)
    system = hjsolve.System({"r": "0 < r", "theta": "angle"}, "(dot(r)**2 + r**2*dot(theta)**2)/2", "-1/r - 1/(5*r**2)")
    found = hjsolve.ensemble(system, q={"r": np.array([1.0, 1.2, 0.7]), "theta": 0.3}, p={"r": 0.2, "theta": 0.1})
    assert found.status.tolist() == ["reaches_boundary"] * 3
