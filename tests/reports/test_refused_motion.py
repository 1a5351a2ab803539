"""Reports of systems that do not separate: other coordinates, lines of equal potential, a surface of section."""

from __future__ import annotations

from pathlib import Path

import pytest

import hjsolve


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
@pytest.mark.parametrize("name", [pytest.param("asymmetric-body", marks=pytest.mark.nightly), "crossed-fields-symmetric-gauge", "p6-3-new-variables"])
def test_every_refused_entry_has_its_report(name: str, tmp_path: Path) -> None:
    assert "In which coordinates" in hjsolve.report(name, tmp_path / "r.md").read_text(encoding="utf-8")
