"""Reports of systems that do not separate: other coordinates, lines of equal potential, a surface of section."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import hjsolve
from hjsolve import ForbiddenMotionError, ForbiddenPlaceError, report
from hjsolve.command_line.main import main


@pytest.mark.nightly
def test_a_refused_report_shows_how_the_system_moves(tmp_path: Path) -> None:
    page = hjsolve.report("henon-heiles", tmp_path / "h.html").read_text(encoding="utf-8")
    assert "No orthogonal coordinates" in page
    assert "Surface of section at x = 0" in page
    assert "no return does the energy differ" in page
    assert "Lines of equal potential" in page


def test_coordinates_that_are_found_are_named(tmp_path: Path) -> None:
    turned = hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="(dot(x)**2 + dot(y)**2)/2", potential="x**2 + x*y + y**2",
    )  # fmt: skip
    text = hjsolve.report(turned, tmp_path / "t.txt").read_text(encoding="utf-8")
    assert "orthogonal coordinate system" in text
    assert "How it moves" not in text  # no initial data


@pytest.mark.nightly_cases("p6-3-new-variables")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param("asymmetric-body", marks=pytest.mark.nightly),
        "crossed-fields-symmetric-gauge",
        "p6-3-new-variables",
    ],
)
def test_every_refused_entry_has_its_report(name: str, tmp_path: Path) -> None:
    assert "In which coordinates" in hjsolve.report(name, tmp_path / "r.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("start", "says"),
    [
        ({"q": {"r": -1, "theta": 0}, "velocity": {"r": 0, "theta": 1}}, "outside the domain"),
        ({"q": {"r": 1, "theta": 0}, "constants": {"E": -1, "p_theta": 1}, "signs": {"r": 1}}, "no real motion"),
    ],
)
def test_a_report_of_a_motion_that_is_refused_has_the_verdict_and_says_what_is_wrong(tmp_path, start, says):
    """No file was written, not even the verdict."""
    target = tmp_path / "refused.txt"
    with pytest.raises((ForbiddenMotionError, ForbiddenPlaceError), match=says):
        report("kepler-planar", target, initial=start, brief=True)
    text = target.read_text(encoding="utf-8")
    assert "Separates in" in text
    assert "What is wrong with the motion" in text
    assert re.search(says, " ".join(text.split()))


def test_the_command_writes_the_report_of_a_refused_motion_and_ends_as_before(tmp_path, capsys):
    target = tmp_path / "refused.md"
    start = ["--q", "r=-1", "theta=0", "--velocity", "r=0", "theta=1", "--brief"]
    assert main(["report", "kepler-planar", *start, "-o", str(target)]) == 2
    assert "outside the domain" in target.read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["report", "kepler-planar", *start, "-o", "-"]) == 2
    out, err = capsys.readouterr()
    assert "What is wrong with the motion" in out
    assert "outside the domain" in err
