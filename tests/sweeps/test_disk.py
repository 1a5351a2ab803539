"""A disk that takes no more, no folder or no locks: it is reported in a line, and nothing is left half."""

from __future__ import annotations

import errno
import sys
from pathlib import Path
from typing import Any

import pytest

import hjsolve

pytest.importorskip("pyarrow", reason="needs the extra cluster")

from tests.sweeps.conftest import parts, start

FULL = """
import resource, sys
import hjsolve
hjsolve.sweep(sys.argv[1], sys.argv[2] + "/first")
resource.setrlimit(resource.RLIMIT_FSIZE, (3000, resource.RLIM_INFINITY))
try:
    hjsolve.sweep(sys.argv[1], sys.argv[2] + "/second")
except hjsolve.InvalidInputError as error:
    print(error, file=sys.stderr, end="")
"""


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="no such limits")
def test_a_disk_that_takes_no_more_is_told_and_nothing_is_left_half(
    scene: Path, tmp_path: Path, undisturbed: Path
) -> None:
    """The system refuses bytes beyond 3000 a file: the manifest is shorter, a part longer."""
    process = start("-c", FULL, str(scene), str(tmp_path))
    words = process.communicate()[1].decode()
    assert process.returncode == 0
    assert (
        words
        == f"{tmp_path / 'second'}: cannot be written (File too large); the parts that are there stay, and the same call resumes with them"
    )
    assert {path.name for path in (tmp_path / "second").iterdir()} == {"_manifest.json", "_lock"}
    assert hjsolve.sweep(scene, tmp_path / "second").kept == 0
    assert parts(tmp_path / "second") == parts(undisturbed)


def test_a_journal_that_cannot_be_written_leaves_no_part_without_a_digest(
    scene: Path, tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hjsolve.sweeps.journal import Journal

    def full(_: Journal, noted: Any) -> None:
        raise OSError(errno.ENOSPC, "")

    with monkeypatch.context() as patched:
        patched.setattr(Journal, "note", full)
        with pytest.raises(hjsolve.InvalidInputError, match=r"cannot be written \(No space left on device\)"):
            hjsolve.sweep(scene, tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"_manifest.json", "_lock"}
    assert hjsolve.sweep(scene, tmp_path / "out").kept == 0
    assert parts(tmp_path / "out") == parts(undisturbed)


def test_a_place_where_no_folder_can_be_is_told(scene: Path) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=r"cannot be written \(Not a directory\)"):
        hjsolve.sweep(scene, scene / "out")


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="no such locks")
def test_a_disk_without_locks_is_refused(scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import fcntl

    def unlocked(*_: Any) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", unlocked)
    with pytest.raises(hjsolve.InvalidInputError, match="two runs could not be kept apart"):
        hjsolve.sweep(scene, tmp_path / "out")
