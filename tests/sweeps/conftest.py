"""A small sweep, and a way to run one slowly in a process of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import hjsolve

SCENE = """
system = "kepler-planar"
want = ["actions", "frequencies"]
[sweep]
chunk = 2
[sweep.q]
r = {start = "0.9", stop = "1.6", count = 4}
theta = "0"
[sweep.p]
r = "0.1"
theta = ["0.9", "1.1", "1.9"]
"""
SLOW = """
import sys, time
from hjsolve.sweeps import conduct
quick = conduct.columns_of
def slow(*arguments):
    time.sleep(0.1)
    return quick(*arguments)
conduct.columns_of = slow
conduct.sweep(sys.argv[1], sys.argv[2], *[], **({"scheduler": sys.argv[3]} if len(sys.argv) > 3 else {}))
"""


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output of a run of SCENE that nothing disturbed."""
    pytest.importorskip("pyarrow", reason="needs the extra cluster")
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "orbits.toml").write_text(SCENE, encoding="utf-8")
    return hjsolve.sweep(folder / "orbits.toml", folder / "out").path


@pytest.fixture
def finished(undisturbed: Path, tmp_path: Path) -> Path:
    """A copy of it that may be spoilt."""
    return Path(shutil.copytree(undisturbed, tmp_path / "finished"))


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "orbits.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def start(*arguments: str) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    return subprocess.Popen([sys.executable, *arguments], env=environment, stderr=subprocess.PIPE)


def start_slowly(scene: Path, out: Path, *scheduler: str) -> subprocess.Popen[bytes]:
    """Run a sweep that takes 0.1 s more for every part."""
    return start("-c", SLOW, str(scene), str(out), *scheduler)


def wait_until(true: Callable[[], bool], process: subprocess.Popen[bytes] | None = None, seconds: float = 60.0) -> None:
    """Wait for a fact; while a process is at work for it, which must not end before."""
    for _ in range(int(seconds / 0.01)):
        if true():
            return
        if process is not None and process.poll() is not None:
            assert true(), f"the process ended: {process.communicate()[1].decode()}"
        time.sleep(0.01)
    raise AssertionError("it did not happen in time")


def parts(out: Path) -> dict[str, bytes]:
    """The data: every part by its name."""
    return {path.name: path.read_bytes() for path in sorted(out.glob("part-*"))}
