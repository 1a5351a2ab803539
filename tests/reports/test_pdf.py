"""A report as PDF: printed by a browser, refused before anything is computed where there is none or it fails."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

import hjsolve
from hjsolve.reports.document import pdf


def test_a_pdf_is_printed(tmp_path: Path) -> None:
    try:
        pdf.browser(tmp_path / "a.pdf")
    except hjsolve.InvalidInputError:
        pytest.skip("no browser that prints")
    made = hjsolve.report("projectile", tmp_path / "throw.pdf", brief=True)
    content = made.read_bytes()
    assert content.startswith(b"%PDF-")
    assert b"/Type /Page" in content
    assert [p.name for p in tmp_path.iterdir()] == ["throw.pdf"]


def test_without_a_browser_it_is_refused_at_the_door(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr("hjsolve.reports.write.gather", lambda *a, **k: pytest.fail("something was computed"))
    with pytest.raises(hjsolve.InvalidInputError, match=r"none of them was found; write .*throw\.html and print it"):
        hjsolve.report("projectile", tmp_path / "throw.pdf")
    assert not list(tmp_path.iterdir())


def test_a_browser_that_fails_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(command: list[str], **rest: object) -> None:
        raise subprocess.CalledProcessError(1, command)

    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}")
    monkeypatch.setattr(subprocess, "run", fails)
    with pytest.raises(hjsolve.InvalidInputError, match="did not print the page"):
        pdf.printed("<p>W</p>", tmp_path / "throw.pdf")
