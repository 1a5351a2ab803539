"""The example scenes, run once a process."""

from __future__ import annotations

import functools
from pathlib import Path

from hjsolve.scenes import Run, Scene

FOLDER = Path(__file__).resolve().parents[2] / "scenes"


@functools.cache
def example(name: str) -> Run:
    """The run of scenes/NAME.toml."""
    return Scene.load(FOLDER / f"{name}.toml").run()
