"""How a report is put in its place."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from hjsolve.reports.document.files import replace

pytestmark = pytest.mark.skipif(os.name != "posix", reason="links and rights as Unix has them")


def test_a_link_is_followed_and_stays_a_link(tmp_path: Path) -> None:
    """F13: the link became a file, and what it led to stayed old."""
    (tmp_path / "elsewhere").mkdir()
    real, link = tmp_path / "elsewhere" / "real.html", tmp_path / "link.html"
    real.write_text("old")
    link.symlink_to(real)
    replace(link, "new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["elsewhere", "link.html", "real.html"]


def test_rights_are_those_of_the_umask_or_of_the_file_before_and_the_umask_is_not_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """F13: the umask of the process was 0 for a moment, for all threads."""
    before = os.umask(0o027)
    try:
        monkeypatch.setattr(os, "umask", lambda _: pytest.fail("the umask was changed"))
        target = tmp_path / "a.txt"
        replace(target, "x")
        assert stat.S_IMODE(target.stat().st_mode) == 0o640
        target.chmod(0o600)
        replace(target, b"y")
        assert stat.S_IMODE(target.stat().st_mode) == 0o600
    finally:
        monkeypatch.undo()
        os.umask(before)


def test_what_cannot_be_written_leaves_everything_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "folder.txt").mkdir()
    with pytest.raises(OSError, match=r"folder\.txt"):
        replace(tmp_path / "folder.txt", "x")
    assert [p.name for p in tmp_path.iterdir()] == ["folder.txt"]
