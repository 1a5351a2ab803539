"""With its output closed (>&-) a command was told to have a fault of its own; a refusal with errors closed went to stdout."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.rotating_file(2)


@pytest.mark.skipif(os.name != "posix", reason="closes streams as a shell does")
@pytest.mark.parametrize(
    ("closed", "arguments", "status"),
    [(1, ["check", "pendulum"], 0), (1, ["motion", "kepler-planar"], 0), (2, ["check", "no such system"], 2)],
)
def test_a_closed_stream_is_no_fault(closed: int, arguments: list[str], status: int) -> None:
    run = subprocess.run(
        ["sh", "-c", f'exec "$@" {closed}>&-', "sh", sys.executable, "-m", "hjsolve", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == status
    assert run.stdout == run.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["check", "pendulum"]])
def test_what_a_full_device_does_not_take_is_said(arguments: list[str]) -> None:
    """``--help > /dev/full`` ended with status 0."""
    run = subprocess.run(
        ["sh", "-c", 'exec "$@" >/dev/full', "sh", sys.executable, "-m", "hjsolve", *arguments],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 2
    assert run.stderr == "hjsolve: output: No space left on device\n"
