"""The scenes a teacher would show: each one runs, gives what it wants and nothing else, and says what it shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hjsolve.scenes import Scene

FOLDER = Path(__file__).resolve().parents[2] / "scenes"
SCENES = sorted(FOLDER.glob("*.toml"))


def test_there_are_at_least_ten() -> None:
    assert len(SCENES) >= 10


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_scene_runs_and_gives_what_it_wants(path: Path) -> None:
    scene = Scene.load(path)
    assert scene.summary.endswith(".")
    run = scene.run()
    assert (run.trajectory is not None) == ("trajectory" in scene.want)
    wanted = set(scene.want) - {"trajectory"}
    if scene.method == "integrate":
        assert bool(run.drift) == ("constants" in wanted)
    for arc in run.arcs:
        assert set(arc.quantities) == wanted
    if run.trajectory is not None:
        assert len(run.trajectory.t) == scene.times.count
        for name, values in run.trajectory.q.items():
            assert np.all(np.isfinite(values))
            assert np.all(run.trajectory.error.q[name] < (1e-7 if scene.method == "integrate" else 1e-12))
        assert set(run.trajectory.status) == {"ok"}


def test_the_planet_precesses_by_the_closed_form() -> None:
    """With −b/r² the angle between two pericentres is 2π/√(1 − 2 m b/L²)."""
    run = Scene.load(FOLDER / "precessing-ellipse.toml").run()
    for arc, momentum in zip(range(2), (1.2, 1.3), strict=True):
        periods = run.quantity("periods", arc=arc)
        turn = 2 * np.pi * periods["r"].value / periods["theta"].value
        assert abs(turn - 2 * np.pi / np.sqrt(1 - 0.04 / momentum**2)) < 1e-13


def test_the_satellite_is_lifted_to_almost_twice_the_radius() -> None:
    run = Scene.load(FOLDER / "satellite-raised.toml").run()
    assert [arc.quantities["kinds"]["r"] for arc in run.arcs] == ["equilibrium", "libration", "libration"]
    low, high = run.quantity("turning_points", arc=1)["r"]
    assert abs(low.value - 1) < 1e-14
    assert abs(high.value - 2) < 1e-14
    low, high = run.quantity("turning_points", arc=2)["r"]
    assert low.value > 1.7
