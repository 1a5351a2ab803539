"""The scenes a teacher would show: each one runs, gives what it wants and nothing else, and says what it shows."""

from __future__ import annotations

import json
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from hjsolve.command_line.main import main
from hjsolve.reports.formats.html import html_page
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.latex_document import tex
from hjsolve.reports.formats.markdown import markdown_page
from hjsolve.reports.formats.text import text_page
from hjsolve.reports.sections.scene import scene_document
from tests.support.scene_files import FOLDER, example

SCENES = sorted(FOLDER.glob("*.toml"))


def test_there_are_at_least_ten() -> None:
    assert len(SCENES) >= 10


@pytest.mark.nightly_cases("ball-that-stays", "two-suns")
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_scene_runs_and_gives_what_it_wants(path: Path) -> None:
    run = example(path.stem)
    scene = run.scene
    assert scene.summary.endswith(".")
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
        assert set(run.trajectory.status) == ({"ok"} if run.rest is None else {"ok", "at_rest"})
    document = scene_document(run)
    told = html_page(document)
    assert scene.title in unescape(told)
    assert scene.title in markdown_page(document)
    assert scene.title in text_page(document)
    assert json.loads(json_text(document))["title"] == scene.title
    assert "\\section" in tex(document)
    assert told.count("<section") >= 3
    assert ("Where it is" in told) == (run.trajectory is not None)
    assert ("What became of the constants" in told) == bool(run.drift)


def test_the_command_line_writes_the_report_of_a_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "pendulum.md"
    assert main(["report", str(FOLDER / "pendulum-over-the-top.toml"), "-o", str(target), "--no-cost"]) == 0
    written = target.read_text(encoding="utf-8")
    assert "push back at t = 8" in written
    assert "rotation" in written
    assert capsys.readouterr().out == f"wrote {target}\n"


def test_a_scene_that_is_wrong_or_refused_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene, target = tmp_path / "scene.toml", tmp_path / "out.html"
    for content, status, words in (
        ('system = "pendulum"\nwant = ["period"]', 2, 'want: "period" is not known'),
        ('system = "pendulum"\neffects = ["drag"]\nwant = ["periods"]', 1, "dH/dt"),
        ('system = "kepler-planar"\neffects = ["uniform-field"]\nwant = ["periods"]', 1, "does not separate"),
    ):
        scene.write_text(content, encoding="utf-8")
        assert main(["report", str(scene), "-o", str(target), "--no-cost"]) == status
        assert words in capsys.readouterr().err
        assert not target.exists()
    assert main(["report", str(scene), "-o", str(target), "--parameter", "k=2"]) == 2
    assert "leave the other options out" in capsys.readouterr().err


def test_the_planet_precesses_by_the_closed_form() -> None:
    """With −b/r² the angle between two pericentres is 2π/√(1 − 2 m b/L²)."""
    run = example("precessing-ellipse")
    for arc, momentum in zip(range(2), (1.2, 1.3), strict=True):
        periods = run.quantity("periods", arc=arc)
        turn = 2 * np.pi * periods["r"].value / periods["theta"].value
        assert abs(turn - 2 * np.pi / np.sqrt(1 - 0.04 / momentum**2)) < 1e-13


def test_the_satellite_is_lifted_to_almost_twice_the_radius() -> None:
    run = example("satellite-raised")
    assert [arc.quantities["kinds"]["r"] for arc in run.arcs] == ["equilibrium", "libration", "libration"]
    low, high = run.quantity("turning_points", arc=1)["r"]
    assert abs(low.value - 1) < 1e-14
    assert abs(high.value - 2) < 1e-14
    low, high = run.quantity("turning_points", arc=2)["r"]
    assert low.value > 1.7
