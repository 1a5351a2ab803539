"""Fifteen public calls with the lowest versions that ``pyproject.toml`` allows, on other Pythons, and with ``python -O``."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXTRAS = ("report", "certified", "fast", "integrate", "completion", "cluster", "units", "tables")


def smoke(python: str, folder: Path, *options: str) -> str:
    settings = {**os.environ, "HJSOLVE_CACHE_DIR": str(folder), "PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        [python, *options, "-m", "tests.support.smoke"], cwd=ROOT, env=settings, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr[-2000:]
    return run.stdout


def lowest() -> list[str]:
    """The lowest version of everything that the core and the extras need: ``name==version``."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    texts = [*project["dependencies"], *(text for extra in EXTRAS for text in project["optional-dependencies"][extra])]
    return sorted({re.sub(r">=([\d.]+)$", r"==\1", text) for text in texts})


def environment(python: str, packages: list[str], folder: Path) -> str:
    """A fresh environment with some packages; returns its Python."""
    subprocess.run([python, "-m", "venv", str(folder)], check=True)
    own = str(folder / "bin" / "python")
    subprocess.run([own, "-m", "pip", "install", "-q", "--only-binary", ":all:", *packages], check=True)
    return own


def test_every_bound_of_an_extra_is_that_of_the_tests() -> None:
    options = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    known = {text.partition(">=")[0]: text for extra in EXTRAS for text in options[extra]}
    assert [text for text in options["test"] if known.get(text.partition(">=")[0], text) != text] == []


@pytest.mark.nightly
@pytest.mark.parametrize("options", [(), ("-O",)], ids=["", "-O"])
def test_the_calls_work(options: tuple[str, ...], tmp_path: Path) -> None:
    assert smoke(sys.executable, tmp_path, *options).count(": ok") == 15


@pytest.mark.nightly
@pytest.mark.timeout(1800)
def test_the_lowest_versions_are_enough(tmp_path: Path) -> None:
    """F15, F16: python-flint 0.6 had no ``workprec``, 0.7 no ``arb_series.prec``; pint 0.24 to 0.24.3 fail
    with the flexparser of today: the bounds were below."""
    python = environment(sys.executable, lowest(), tmp_path / "environment")
    assert "skipped" not in smoke(python, tmp_path / "code")


@pytest.mark.nightly
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("version", ["3.12", "3.13", "3.14"])
def test_other_pythons(version: str, tmp_path: Path) -> None:
    python = shutil.which(f"python{version}")
    if python is None or subprocess.run([python, "-c", ""], capture_output=True, check=False).returncode:
        pytest.skip(f"Python {version} is not here, or a launcher that finds none")
    own = environment(
        python, ["sympy", "mpmath", "numpy", "python-flint", "numba", "rich", "matplotlib"], tmp_path / "it"
    )
    assert smoke(own, tmp_path / "code", "-O").count(": ok") >= 12
