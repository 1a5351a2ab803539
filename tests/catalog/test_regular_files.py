"""F3: what a user names as a file is a regular one, read to a limit, and nothing waits for a pipe."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hjsolve import HJSolveError, catalog
from hjsolve.catalog.regular_files import bytes_of

pytestmark = pytest.mark.skipif(not Path("/dev/zero").exists(), reason="devices as Unix has them")


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom", "/dev/full"])
def test_a_link_to_a_device_is_no_entry(device: str, tmp_path: Path) -> None:
    (tmp_path / "X.toml").symlink_to(device)
    with pytest.raises(HJSolveError, match="is not a regular file"):
        catalog.load(tmp_path / "X.toml")


def test_a_pipe_that_nobody_writes_to_is_no_entry(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "X.toml")
    with pytest.raises(HJSolveError, match="is not a regular file"):
        catalog.load(tmp_path / "X.toml")


def test_a_sparse_file_of_gigabytes_is_read_to_the_limit(tmp_path: Path) -> None:
    with (tmp_path / "X.toml").open("wb") as file:
        file.truncate(3 << 30)
    with pytest.raises(HJSolveError, match="is longer than"):
        bytes_of(tmp_path / "X.toml", 1000)
    with pytest.raises(HJSolveError):
        catalog.load(tmp_path / "X.toml")
