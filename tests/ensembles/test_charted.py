"""Ensembles in the user's coordinates, against single motions of many digits, which read x and v exactly."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError, MissingValueError

WANT = ("actions", "frequencies", "angles", "constants")
R3 = "sqrt(x**2 + y**2 + z**2)"
SYSTEMS = {
    "elliptic": "-1/sqrt((x-1)**2 + (y-2)**2) - 3/sqrt((x-3)**2 + (y+1)**2)",
    "polar": "-1/sqrt(x**2 + y**2)",
    "parabolic": "-1/sqrt(x**2 + y**2) + x/50 + y/100",
    "cartesian": "x**4 + 6*x**2*y**2 + y**4 + (x**2 + y**2)/2",
    "normal modes": "x**2 + y**2 - x*y + x/5",
    "prolate spheroidal": "-1/sqrt(x**2 + (y-1)**2 + (z-2)**2) - 2/sqrt((x-2)**2 + y**2 + (z+1)**2)",
    "ellipsoidal": "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2",
    "rotational parabolic": f"-1/{R3} + x/100 + y/50 + z/50",
    "conical": f"(x**2 + y**2 + z**2)**2 + (x**2 + 2*y**2 + 4*z**2)/{R3}**4",
}
QUICK = ("elliptic", "polar", "parabolic", "cartesian", "normal modes")


def system_of(kind: str) -> hjsolve.System:
    names = "xyz" if "z" in SYSTEMS[kind] else "xy"
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    return hjsolve.System(dict.fromkeys(names, "line"), kinetic, SYSTEMS[kind])


def starts(kind: str, count: int, seed: int = 1) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    dice, names = np.random.default_rng(seed), "xyz" if "z" in SYSTEMS[kind] else "xy"
    q = {name: dice.uniform(-1, 1, count) for name in names}
    return q, {name: dice.uniform(-0.5, 0.5, count) for name in names}


def one(group: dict[str, np.ndarray], k: int) -> dict[str, float]:
    return {name: float(values[k]) for name, values in group.items()}


@pytest.mark.parametrize(
    "kind", [*QUICK, *(pytest.param(k, marks=pytest.mark.nightly) for k in SYSTEMS if k not in QUICK)]
)
def test_numbers_are_those_of_single_motions_within_their_errors(kind: str) -> None:
    solution = hjsolve.solve(system_of(kind), coordinates="find")
    assert solution.chart.kind == kind
    q, v = starts(kind, 12)
    batch = hjsolve.ensemble(solution, q=q, velocity=v, want=WANT, fallback=False)
    compared = 0
    for k in np.flatnonzero(batch.codes == 0)[:3]:
        motion = solution.motion(q=one(q, k), velocity=one(v, k), digits=25)
        for quantity in WANT:
            if quantity == "angles" and "rotation" in motion.kinds.values():
                continue  # the angle of a rotation counts from a place of the engine's own
            exact = motion.angles(motion.t0) if quantity == "angles" else getattr(motion, quantity)
            for name, values in getattr(batch, quantity).items():
                true = getattr(exact[name], "value", exact[name])
                off = abs(float(true - values[k]))
                off = min(off, abs(off - 2 * np.pi)) if quantity == "angles" else off
                assert off <= batch.error[quantity][name][k] < 1e-8, (quantity, name, k)
                compared += 1
    assert compared >= 10


def test_as_many_orbits_are_had_in_doubles_as_of_the_separated_system_itself() -> None:
    solution = hjsolve.solve(system_of("cartesian"), coordinates="find")
    q, v = starts("cartesian", 2000)
    batch = hjsolve.ensemble(solution, q=q, velocity=v, want=WANT, fallback=False)
    assert np.count_nonzero(batch.codes == 0) > 1980
    assert set(batch.actions) == set(solution.chart.coordinates)


def test_momenta_are_taken_as_well_as_velocities() -> None:
    V = "x**4 + 6*x**2*y**2 + y**4 + (x**2 + y**2)/2"
    system = hjsolve.System({"x": "line", "y": "line"}, "3*(dot(x)**2 + dot(y)**2)/2", V)
    q, v = starts("cartesian", 50)
    p = {name: 3 * values for name, values in v.items()}
    one_way = hjsolve.ensemble(system, q=q, velocity=v, coordinates="find", want="actions", fallback=False)
    other = hjsolve.ensemble(system, q=q, p=p, coordinates="find", want="actions", fallback=False)
    for name in one_way.actions:
        error = one_way.error["actions"][name] + other.error["actions"][name]
        size = np.abs(one_way.actions[name])
        assert np.all(np.abs(one_way.actions[name] - other.actions[name]) <= error + 1e-15 * size)


def test_parameters_move_the_foci() -> None:
    V = "-1/sqrt((x-a)**2 + y**2) - 2/sqrt((x+a)**2 + y**2)"
    system = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", V, parameters={"a": 1})
    batch = hjsolve.ensemble(
        system, q={"x": 0.3, "y": 0.5}, velocity={"x": 0.1, "y": 0.2}, coordinates="find", parameters={"a": "1.5"},
        want="actions",
    )  # fmt: skip
    motion = hjsolve.solve(system, coordinates="find").motion(
        q={"x": 0.3, "y": 0.5}, velocity={"x": 0.1, "y": 0.2}, parameters={"a": "1.5"}, digits=20
    )
    for name, action in batch.actions.items():
        assert abs(float(motion.actions[name].value - action)) <= batch.error["actions"][name]


def test_what_became_of_every_orbit_is_told_and_none_stops_the_others() -> None:
    """A focus, an axis passed without angular momentum, escape, NaN; and a start at rest."""
    system = system_of("polar")
    q = {"x": [0.0, 1.0, 0.3, np.nan, 1.0, 0.6], "y": [0.0, 0.0, 0.4, 0.0, 0.5, 0.8]}
    v = {"x": [0.1, 0.0, 3.0, 0.0, 0.0, 0.0], "y": [0.0, 1.2, 3.0, 0.0, 0.0, 0.1]}
    batch = hjsolve.ensemble(system, q=q, velocity=v, coordinates="find", want=["actions", "frequencies"])
    assert batch.status.tolist() == [
        "outside_domain", "ok", "unbounded", "not_finite", "reaches_boundary", "ok"
    ]  # fmt: skip
    assert np.isfinite(batch.actions["r"][[1, 5]]).all()


def test_starts_at_rest_are_had_without_the_engine_of_single_motions() -> None:
    """At v = 0 every coordinate is at a turning point, where its momentum alone tells too little."""
    solution = hjsolve.solve(system_of("cartesian"), coordinates="find")
    q, v = starts("cartesian", 40)
    rest = dict.fromkeys(v, 0.0)
    batch = hjsolve.ensemble(solution, q=q, velocity=rest, want=["actions", "constants"], fallback=False)
    assert np.count_nonzero(batch.codes == 0) >= 36
    for k in np.flatnonzero(batch.codes == 0)[:5]:
        motion = solution.motion(q=one(q, k), velocity=rest, digits=25)
        for name, action in batch.actions.items():
            assert abs(float(motion.actions[name].value - action[k])) <= batch.error["actions"][name][k] < 1e-9


def test_the_result_has_the_shape_of_the_input_and_depends_on_no_company() -> None:
    solution = hjsolve.solve(system_of("parabolic"), coordinates="find")
    q, v = starts("parabolic", 24)
    whole = hjsolve.ensemble(solution, q={k: x.reshape(4, 6) for k, x in q.items()},
                             velocity={k: x.reshape(4, 6) for k, x in v.items()}, want="actions", fallback=False)  # fmt: skip
    assert whole.shape == (4, 6)
    alone = hjsolve.ensemble(solution, q=one(q, 9), velocity=one(v, 9), want="actions", fallback=False)
    for name in whole.actions:
        assert whole.actions[name][1, 3] == alone.actions[name] or np.isnan(alone.actions[name])


def test_the_names_of_the_separated_coordinates_are_refused() -> None:
    with pytest.raises(InvalidInputError, match='no coordinate "mu"'):
        hjsolve.ensemble(system_of("elliptic"), q={"mu": 1, "nu": 0}, velocity={"x": 0, "y": 0}, coordinates="find")
    with pytest.raises(MissingValueError, match="no values for y"):
        hjsolve.ensemble(system_of("elliptic"), q={"x": 1}, velocity={"x": 0, "y": 0}, coordinates="find")


def test_blocks_of_dask_give_what_one_array_gives() -> None:
    da = pytest.importorskip("dask.array")
    solution = hjsolve.solve(system_of("cartesian"), coordinates="find")
    q, v = starts("cartesian", 30)
    lazy = hjsolve.ensemble(
        solution, q={k: da.from_array(x, chunks=10) for k, x in q.items()}, velocity=v, want="actions", fallback=False
    ).compute(scheduler="threads")
    plain = hjsolve.ensemble(solution, q=q, velocity=v, want="actions", fallback=False)
    for name in plain.actions:
        np.testing.assert_array_equal(lazy.actions[name], plain.actions[name])


COLUMNS = {
    "q": {"R": [1.0, 0.8], "z": [0.1, -0.4]},
    "velocity": {"vR": [0.1, -0.2], "vT": [0.7, -0.5], "vz": [0.2, 0.05]},
}


@pytest.mark.slow
def test_columns_of_stars_are_those_of_the_same_stars_at_any_azimuth() -> None:
    V = "-3/sqrt(x**2 + y**2 + z**2 + 5 + 2*sqrt(4 + x**2 + y**2 + 4*z**2))"  # Kuzmin and Kutuzov's galaxy
    kinetic = "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"
    solution = hjsolve.solve(hjsolve.System(dict.fromkeys("xyz", "line"), kinetic, V), coordinates="find")
    batch = hjsolve.ensemble(solution, **COLUMNS, want="actions", fallback=False)
    R, z, vR, vT, vz = (np.array(group[n]) for group in COLUMNS.values() for n in group)
    c, s = np.cos(0.7), np.sin(0.7)
    turned = hjsolve.ensemble(
        solution, q={"x": R * c, "y": R * s, "z": z},
        velocity={"x": vR * c - vT * s, "y": vR * s + vT * c, "z": vz}, want="actions", fallback=False,
    )  # fmt: skip
    assert batch.status.tolist() == turned.status.tolist() == ["ok", "ok"]
    assert np.all(np.abs(batch.actions["phi"] - R * vT) <= batch.error["actions"]["phi"] + 1e-16)
    for name in ("mu", "nu", "phi"):
        off = np.abs(batch.actions[name] - turned.actions[name])
        assert np.all(off <= batch.error["actions"][name] + turned.error["actions"][name] + 1e-15), name


@pytest.mark.parametrize(
    ("potential", "change", "says"),
    [
        ("x**2 + y**2 + z**4", {"q": {"R": 1.0, "z": 0.0, "phi": 0.3}}, "no others"),
        ("x**2 + 2*y**2 + z**4", {}, "symmetric about z"),
        ("x**2 + y**2", {}, "in x, y and z; this one is in x, y"),
    ],
)
def test_columns_of_stars_are_refused_where_they_do_not_say_all(potential: str, change: dict, says: str) -> None:
    names = "xyz" if "z" in potential else "xy"
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    system = hjsolve.System(dict.fromkeys(names, "line"), kinetic, potential)
    with pytest.raises(InvalidInputError, match=says):
        hjsolve.ensemble(system, **{**COLUMNS, **change}, coordinates="find")
