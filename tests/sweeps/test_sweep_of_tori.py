"""Sweeps over actions and angles: each orbit gives the state on its torus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hjsolve

dataset = pytest.importorskip("pyarrow.dataset", reason="needs the extra cluster")

GRID: dict[str, Any] = {
    "system": "kepler-planar",
    "sweep": {
        "chunk": 4,
        "actions": {"r": ["0.1", "0.2", "1e-6"], "theta": ["0.9", "-1.1"]},
        "angles": {"r": ["0.3"]},
    },
}


def rows(out: Path) -> dict[str, Any]:
    table = dataset.dataset(out).to_table()
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def with_sweep(**changed: Any) -> dict[str, Any]:
    return {**GRID, "sweep": {key: v for key, v in {**GRID["sweep"], **changed}.items() if v is not None}}


def test_a_grid_of_actions_gives_the_states_of_kepler(tmp_path: Path) -> None:
    found = rows(hjsolve.sweep(GRID, tmp_path / "out").path)
    J, L = (x.ravel() for x in np.meshgrid([0.1, 0.2, 1e-6], [0.9, -1.1], indexing="ij"))
    assert found["actions.r"].tolist() == J.tolist()
    assert found["actions.theta"].tolist() == L.tolist()
    assert found["angles.r"].tolist() == [0.3] * 6
    assert found["angles.theta"].tolist() == [0.0] * 6
    assert found["status"].tolist() == ["ok"] * 6
    a, e = (J + abs(L)) ** 2, np.sqrt(J * (J + 2 * abs(L))) / (J + abs(L))  # Kepler's equation, θ_r = ξ − e sin ξ
    ξ = np.full(6, 0.3)
    for _ in range(60):
        ξ = 0.3 + e * np.sin(ξ)
    assert np.allclose(found["q.r"], a * (1 - e * np.cos(ξ)), rtol=1e-12, atol=0)
    assert (abs(found["q.r"] - a * (1 - e * np.cos(ξ))) <= found["error.q.r"] + 4e-16 * a).all()
    assert found["p.theta"].tolist() == L.tolist()


@pytest.mark.nightly
def test_a_table_of_actions_is_the_same_in_one_part_or_several(tmp_path: Path) -> None:
    columns = {"radial": [0.1, 0.3, np.nan], "actions.theta": [1.0, 0.5, 1.0], "angles.theta": [0.1, 2.0, 0.0]}
    np.savez(tmp_path / "tori.npz", **columns)
    scene = {
        "system": "kepler-planar", "want": ["state"],
        "sweep": {"table": str(tmp_path / "tori.npz"), "columns": {"actions.r": "radial"}, "chunk": 2},
    }  # fmt: skip
    done = hjsolve.sweep(scene, tmp_path / "out")
    assert (done.parts, done.statuses) == (2, {"ok": 2, "not_finite": 1, "recomputed": 0})
    batch = hjsolve.ensemble(
        "kepler-planar", actions={"r": columns["radial"], "theta": columns["actions.theta"]},
        angles={"theta": columns["angles.theta"]},
    )  # fmt: skip
    for name in ("q.r", "p.r", "q.theta"):
        group, coordinate = name.split(".")
        mine, theirs = rows(done.path)[name][:2], getattr(batch, group)[coordinate][:2]
        assert (abs(mine - theirs) <= 2 * batch.error[group][coordinate][:2]).all()
    assert hjsolve.sweep(scene, tmp_path / "out").kept == 2


def test_rotations_are_chosen_by_kinds(tmp_path: Path) -> None:
    scene = {"system": "pendulum", "sweep": {"actions": {"theta": "6"}}}
    assert hjsolve.sweep(scene, tmp_path / "out").statuses["ambiguous"] == 1
    scene["sweep"] = {"actions": {"theta": "6"}, "kinds": {"theta": "libration"}}
    assert hjsolve.sweep(scene, tmp_path / "out2").statuses["ok"] == 1


def test_a_well_is_chosen_by_a_place_in_it(tmp_path: Path) -> None:
    system = {
        "coordinates": [{"name": "x", "domain": "line"}],
        "kinetic": "dot(x)**2/2", "potential": "x**4/4 - x**2/2 + x/20",
    }  # fmt: skip
    scene = {"system": system, "sweep": {"actions": {"x": ["0.05", "0.1"]}}}
    assert hjsolve.sweep(scene, tmp_path / "out").statuses["ambiguous"] == 2
    scene["sweep"] = {"actions": {"x": ["0.05", "0.1"]}, "wells": {"x": "1"}}
    done = hjsolve.sweep(scene, tmp_path / "out2")
    assert done.statuses["ok"] == 2
    assert (rows(done.path)["q.x"] > 0).all()


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (with_sweep(q={"r": "1"}), "give q and p or velocity, or actions and angles, not both"),
        (with_sweep(actions={"r": "1"}), r"sweep.actions.theta: missing; every coordinate needs one"),
        (with_sweep(actions=None, angles={"r": "1"}), r"sweep.actions.r: missing"),
        (with_sweep(actions={"r": "1", "z": "1"}), 'sweep.actions: no coordinate "z"'),
        ({**GRID, "initial": {"q": {"r": "1"}}}, "initial: a sweep over actions has no places; leave it out"),
        ({**GRID, "want": ["actions"]}, 'want: "actions" is not for a sweep over actions, which has state'),
        ({**GRID, "coordinates": "find", "system": "kepler-spatial-cartesian"}, "actions|no "),
        (with_sweep(kinds={"r": "spin"}), r"kinds\[r\]: a separated coordinate"),
        (with_sweep(wells={"z": "1"}), "wells: z: known are r, theta"),
        ({"system": "kepler-planar", "sweep": {"q": {"r": "1"}, "kinds": {"r": "libration"}}}, "belongs to actions"),
    ],
)
def test_what_does_not_fit_is_refused_at_the_door(scene: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(hjsolve.HJSolveError, match=message):
        hjsolve.sweep(scene, tmp_path / "out")


def test_a_table_says_whether_it_holds_states_or_tori(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **{"actions.r": [0.1], "actions.theta": [1.0]})
    np.savez(tmp_path / "b.npz", **{"q.r": [1.0], "q.theta": [1.0], "p.r": [0.1], "p.theta": [1.0]})
    np.savez(tmp_path / "c.npz", **{"actions.r": [0.1], "actions.theta": [1.0], "q.r": [1.0]})
    for name, want, message in (
        ("a", None, r'write want = \["state"\]'), ("b", ["state"], "is for a sweep over actions"),
        ("c", ["state"], "give states or tori"),
    ):  # fmt: skip
        scene = {"system": "kepler-planar", "sweep": {"table": str(tmp_path / f"{name}.npz")}}
        with pytest.raises(hjsolve.InvalidInputError, match=message):
            hjsolve.sweep(scene | ({"want": want} if want else {}), tmp_path / f"out-{name}")
