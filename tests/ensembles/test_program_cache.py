"""Compiled programs stay on disk between processes, where nobody else can write."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hjsolve.catalog import load
from hjsolve.ensembles import engine, orbits
from hjsolve.ensembles.engine import program_cache, programs
from hjsolve.solution.quadratures import solve

TEXT = "def start(q):\n    return (q, )\n"
RUN = """
import sys
import numpy as np
from numba.core import event
import hjsolve
with event.install_recorder("numba:compile") as record:
    x = np.linspace(0.1, 2, 7)
    made = hjsolve.ensemble("harmonic-oscillator", q={"x": x}, p={"x": 0.3}, want="actions", compiled=True, threads=1)
print(len(record.buffer), made.actions["x"].tobytes().hex())
"""


def one(folder: Path) -> tuple[int, str]:
    """How many functions a fresh process compiles, and its results."""
    environment = {**os.environ, "HJSOLVE_CACHE_DIR": str(folder)}
    done = subprocess.run([sys.executable, "-c", RUN], env=environment, capture_output=True, text=True, check=True)
    count, numbers = done.stdout.split()
    return int(count), numbers


@pytest.mark.nightly
def test_the_second_process_compiles_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HJSOLVE_CACHE_DIR", str(tmp_path))
    solution, want = solve(load("harmonic-oscillator")), frozenset({"actions"})
    assert not engine.ready(solution, want)
    compiled, numbers = one(tmp_path)
    assert compiled > 10
    assert engine.ready(solution, want)
    assert one(tmp_path) == (0, numbers)
    assert not engine.ready(solution, frozenset({"frequencies"}))
    assert not engine.ready(solution, want, {"k": 3})


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("HJSOLVE_CACHE_DIR", str(tmp_path / "own"))
    return tmp_path / "own"


def test_the_file_holds_the_text_and_is_mended(folder: Path) -> None:
    path = program_cache.path_for(TEXT)
    assert path is not None
    assert path.is_relative_to(folder)
    assert path.read_text() == TEXT
    path.write_text("import somebody\n")
    assert not program_cache.is_cached(TEXT, ())
    assert program_cache.path_for(TEXT) == path
    assert path.read_text() == TEXT
    assert [p.name for p in path.parent.iterdir() if p.suffix == ".tmp"] == []
    assert program_cache.path_for(TEXT + "\n") != path


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders have no modes here")
@pytest.mark.parametrize("inner", ["", "__pycache__"])
def test_a_folder_where_others_may_write_is_not_used(folder: Path, inner: str) -> None:
    path = program_cache.path_for(TEXT)
    assert path is not None
    (path.parent / inner).chmod(0o777)
    assert program_cache.path_for(TEXT) is None
    assert not program_cache.is_cached(TEXT, ())


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only the administrator gives folders away")
def test_a_folder_of_somebody_else_is_not_used(folder: Path) -> None:
    path = program_cache.path_for(TEXT)
    assert path is not None
    os.chown(path.parent, 12345, -1)
    assert program_cache.path_for(TEXT) is None


def test_nothing_is_kept_where_nothing_can_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    for name, place in (
        ("HJSOLVE_CACHE_DIR", "0"),
        ("HJSOLVE_CACHE_DIR", str(tmp_path / "file")),
        ("NUMBA_CACHE_DIR", str(tmp_path)),
    ):
        monkeypatch.setenv(name, place)
        assert program_cache.path_for(TEXT) is None
        assert not program_cache.is_cached(TEXT, ())
        monkeypatch.delenv("HJSOLVE_CACHE_DIR", raising=False)


def test_what_cannot_be_read_is_compiled_in_memory(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numba")
    text, kept = "def successor(q):\n    return q + 1\n", []
    made = programs._functions

    def broken(text: str, names: tuple[str, ...], path: Path | None, *, loops: bool) -> dict[str, programs.Function]:
        kept.append(path is not None)
        if path is not None:
            raise EOFError(path)
        return made(text, names, path, loops=loops)

    monkeypatch.setattr(programs, "_functions", broken)
    assert programs._module(text, ("successor",), False)["successor"](2) == 3
    assert kept == [True, False]


def test_kept_programs_serve_smaller_ensembles(monkeypatch: pytest.MonkeyPatch) -> None:
    solution = solve(load("harmonic-oscillator"))
    task = orbits.task_for(solution, ("actions",), {}, "p", compiled=False)
    choice = {}
    for there in (False, True):
        monkeypatch.setattr(engine, "ready", lambda *_, there=there: there)
        choice[there] = [orbits._worth_compiling(count, task, solution) for count in (19_999, 20_000, 99_999, 100_000)]
    assert choice == {False: [False, False, False, True], True: [False, True, True, True]}
