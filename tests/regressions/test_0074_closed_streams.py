"""With its output closed (>&-) a command was told to have a fault of its own; a refusal with errors closed went to stdout."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest


@pytest.mark.skipif(os.name != "posix", reason="closes streams as a shell does")
@pytest.mark.parametrize(
    ("closed", "arguments", "status"), [(1, ["check", "pendulum"], 0), (2, ["check", "no such system"], 2)]
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
