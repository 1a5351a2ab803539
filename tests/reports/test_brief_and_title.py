"""Brief reports and titles of one's own."""

from __future__ import annotations

from pathlib import Path

import pytest

import hjsolve
from hjsolve.command_line.main import main

HEAVY = ('id="closed-forms"', 'id="energy-momentum"')


def test_a_brief_report_leaves_out_what_takes_longest_and_says_so(tmp_path: Path) -> None:
    whole = hjsolve.report("kepler-planar", tmp_path / "whole.html").read_text(encoding="utf-8")
    brief = hjsolve.report("kepler-planar", tmp_path / "brief.html", brief=True).read_text(encoding="utf-8")
    assert all(part in whole and part not in brief for part in HEAVY)
    assert "a brief report was asked" in brief
    assert "a brief report was asked" not in whole
    assert 'id="numbers"' in brief


@pytest.mark.parametrize("subject", ["kepler-planar", "henon-heiles", "oscillator-tan"])
def test_a_title_stands_in_place_of_the_systems_own(subject: str, tmp_path: Path) -> None:
    page = hjsolve.report(subject, tmp_path / "t.html", brief=True, title="Exercise 3 <b>").read_text(encoding="utf-8")
    assert page.count("Exercise 3 &lt;b&gt;") == 2  # the tab and the heading
    assert hjsolve.catalog.describe(subject).title not in page


@pytest.mark.parametrize("title", ["two\nlines", "x" * 201, 3])
def test_a_title_that_cannot_be_one_is_refused(title: object, tmp_path: Path) -> None:
    with pytest.raises(hjsolve.HJSolveError, match="title"):
        hjsolve.report("kepler-planar", tmp_path / "t.html", title=title)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_the_command_line_has_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "t.md"
    assert main(["report", "kepler-planar", "-o", str(target), "--brief", "--title", "Sheet 4"]) == 0
    assert target.read_text(encoding="utf-8").startswith("# Sheet 4")
