"""Imports point one way, and no module escapes the contract."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_import_contracts_hold() -> None:
    code = "import sys; from importlinter.cli import lint_imports_command; sys.argv = ['lint-imports']; lint_imports_command()"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stdout[-3000:] + run.stderr[-2000:]
    assert "0 broken" in run.stdout


def test_every_module_has_a_layer() -> None:
    configuration = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = " ".join(configuration["tool"]["importlinter"]["contracts"][0]["layers"])
    for sign in "|:()":
        layers = layers.replace(sign, " ")
    named = {name.removeprefix("hjsolve.") for name in layers.split()}
    modules = {path.stem for path in (ROOT / "hjsolve").glob("*.py")} | {
        path.parent.name for path in (ROOT / "hjsolve").glob("*/__init__.py")
    }
    assert modules - {"__init__"} <= named, (
        f"name a layer for {sorted(modules - named - {'__init__'})} in pyproject.toml"
    )


def test_the_symbolic_half_is_named_whole_in_its_contract() -> None:
    """Whatever lies below the numeric half must be under the contract that forbids numpy."""
    configuration = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    order, symbolic, _ = configuration["tool"]["importlinter"]["contracts"]
    place = next(i for i, layer in enumerate(order["layers"]) if "hjsolve.numeric" in layer)
    below = " ".join(order["layers"][place + 1 :]).replace("|", " ").replace(":", " ").split()
    assert set(below) - {"hjsolve._version"} <= set(symbolic["source_modules"])
