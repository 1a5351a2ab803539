"""Scenes in the user's coordinates, solved in others that are found."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

import hjsolve
from hjsolve.errors import CatalogError

V = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 2/sqrt((x - 3)**2 + (y + 1)**2)"
TABLE = {
    "coordinates": "find",
    "system": {
        "coordinates": [{"name": "x", "domain": "line"}, {"name": "y", "domain": "line"}],
        "kinetic": "(dot(x)**2 + dot(y)**2)/2",
        "potential": V,
    },
    "want": ["kinds", "actions", "trajectory"],
    "times": [0, 1, "2.5", 4],
    "initial": {"q": {"x": "0.3", "y": "0.4"}, "velocity": {"x": 0, "y": "0.1"}},
}
THRUST = {"kind": "impulse", "at": {"t": "2"}, "velocity": {"x": "0.05"}}


def test_the_trajectory_is_in_x_and_y_and_the_actions_are_those_of_the_coordinates_found() -> None:
    run = hjsolve.Scene.load(TABLE).run()
    motion = hjsolve.solve(hjsolve.Scene.load(TABLE).system, coordinates="find").motion(**TABLE["initial"])
    assert set(run.quantity("actions")) == {"mu", "nu"}
    for k, t in enumerate(TABLE["times"]):
        state = motion.at(t)
        for name in "xy":
            assert (
                abs(run.trajectory.q[name][k] - state.q[name]) <= run.trajectory.error.q[name][k] + state.error.q[name]
            )


def test_an_impulse_begins_a_new_motion_at_the_state_it_leaves() -> None:
    """Against two motions of 30 digits, the second begun by hand where the first is at the time of the impulse."""
    run = hjsolve.Scene.load({**TABLE, "events": [THRUST]}).run()
    solution = run.solution
    before = solution.motion(**TABLE["initial"], digits=30).at(2)
    kicked = {"x": before.velocity["x"] + before.velocity["x"].context.mpf("0.05"), "y": before.velocity["y"]}
    after = solution.motion(q=before.q, velocity=kicked, t0=2, digits=30)
    for k, t in ((2, "2.5"), (3, 4)):
        state = after.at(t)
        for name in "xy":
            assert abs(float(state.q[name] - run.trajectory.q[name][k])) <= run.trajectory.error.q[name][k] < 1e-11
            off = abs(float(state.velocity[name] - run.trajectory.velocity[name][k]))
            assert off <= run.trajectory.error.velocity[name][k] < 1e-11
    assert run.quantity("actions", arc=0)["mu"].value != run.quantity("actions", arc=1)["mu"].value


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"events": [{"kind": "wall", "at": {"coordinate": "x", "value": 1}}]}, "only impulses at given times"),
        ({"events": [{**THRUST, "at": {"coordinate": "x", "value": 1}}]}, "only impulses at given times"),
        ({"method": "integrate", "want": ["trajectory"]}, "needs no others than the given ones"),
        ({"coordinates": "elliptic"}, "find"),
    ],
)
def test_what_is_not_done_is_refused_with_what_to_write(change: dict, says: str) -> None:
    with pytest.raises(CatalogError, match=says):
        hjsolve.Scene.load({**TABLE, **change})


def test_a_report_of_the_scene_tells_the_coordinates_found(tmp_path) -> None:
    target = tmp_path / "scene.txt"
    table = {key: value for key, value in TABLE.items() if key != "times"}
    hjsolve.report(hjsolve.Scene.load({**table, "want": ["kinds"]}), target)
    assert "Coordinates found: elliptic" in target.read_text(encoding="utf-8")


def test_a_sweep_of_starts_in_x_and_y_has_the_columns_of_the_coordinates_found(tmp_path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    table = {key: value for key, value in TABLE.items() if key not in ("times", "initial")}
    axis = {"start": "0.2", "stop": "0.4", "count": 5}
    table |= {
        "want": ["actions"],
        "initial": {"q": {"y": "0.4"}, "velocity": {"x": "0.1", "y": "0.1"}},
        "sweep": {"q": {"x": axis}},
    }
    hjsolve.sweep(table, tmp_path / "out")
    rows = pq.read_table(tmp_path / "out").to_pandas().sort_values("q.x")
    batch = hjsolve.ensemble(
        hjsolve.Scene.load(TABLE).system, q={"x": rows["q.x"].to_numpy(), "y": 0.4}, velocity={"x": 0.1, "y": 0.1},
        coordinates="find", want="actions",
    )  # fmt: skip
    assert list(rows["actions.mu"]) == list(batch.actions["mu"])


@pytest.mark.nightly
def test_the_command_line_prints_x_and_y() -> None:
    arguments = [
        "motion", "--find", "--coordinate", "x: line", "--coordinate", "y: line", "--kinetic",
        TABLE["system"]["kinetic"], "--potential", V, "--q", "x=0.3", "--q", "y=0.4", "--velocity", "x=0",
        "--velocity", "y=0.1", "--times", "0:2:3", "--json",
    ]  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "hjsolve", *arguments], capture_output=True, text=True, check=True, env=dict(os.environ)
    )
    told = json.loads(done.stdout)
    assert set(told["kinds"]) == {"mu", "nu"}
    assert '"q.x"' in done.stdout or "x" in str(told)
