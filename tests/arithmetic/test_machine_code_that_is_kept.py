"""Machine code of kernels stays on disk between processes, where nobody else can write, and is checked before it runs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("numba")

RUN = """
import numpy as np
from numba.core import event
from hjsolve.arithmetic.machine.over_rows import run_rows
from hjsolve.arithmetic.machine.writer import InstructionWriter
writer = InstructionWriter()
x, y = writer.inputs(2)
code = writer.code([writer.add(writer.mul(x, y), writer.unary("sqrt", x))])
with event.install_recorder("numba:compile") as record:
    (made,) = run_rows(code, (), np.linspace(0.1, 2, 14).reshape(2, 7))
print(len(record.buffer), made.tobytes().hex())
"""


def one(folder: Path) -> tuple[int, str]:
    """How many functions a fresh process compiles, and its results."""
    environment = {**os.environ, "HJSOLVE_CACHE_DIR": str(folder)}
    done = subprocess.run([sys.executable, "-c", RUN], env=environment, capture_output=True, text=True, check=True)
    count, numbers = done.stdout.split()
    return int(count), numbers


@pytest.mark.nightly
def test_the_second_process_compiles_nothing_and_a_spoilt_file_is_made_anew(tmp_path: Path) -> None:
    first, numbers = one(tmp_path)
    assert first > 0
    assert one(tmp_path) == (0, numbers)
    files = sorted(path for path in tmp_path.rglob("*") if path.is_file())
    assert files
    for path in files:
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    again, same = one(tmp_path)
    assert again > 0
    assert same == numbers
    assert one(tmp_path) == (0, numbers)


@pytest.mark.nightly
@pytest.mark.skipif(not hasattr(os, "getuid"), reason="permissions of POSIX")
def test_a_folder_in_which_others_may_write_is_not_used(tmp_path: Path) -> None:
    _, numbers = one(tmp_path)
    for folder in [path for path in tmp_path.rglob("*") if path.is_dir()]:
        folder.chmod(0o777)
    count, same = one(tmp_path)
    assert count > 0
    assert same == numbers
