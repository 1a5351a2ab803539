"""What a sweep is, as digests: a run goes on only where scene and code are those it began with."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from hjsolve._version import __version__
from hjsolve.catalog import schema
from hjsolve.errors import required
from hjsolve.motion.velocity_frame import COORDINATE
from hjsolve.scenes import Scene
from hjsolve.solution.quadratures import FIND

PARTS = ("system", "effects", "parameters", "initial", "want", "sweep", "table")
"""What of a scene decides the result."""


def sweep_digest(scene: Scene, table: str, chunk: int) -> dict[str, str]:
    """Digests of everything in a scene that decides the numbers; its title and its remarks do not.

    Args:
        table: digest of the table of starts.
        chunk: orbits of one part.
    """
    sweep = required(scene.sweep)
    axes = [
        [a.group, a.name, [str(v) for v in a.listed], str(a.start), str(a.stop), a.count, a.spacing] for a in sweep.axes
    ]
    effects = scene.table.get("effects", {})
    content: dict[str, object] = {
        "system": {key: scene.table.get(key) for key in sorted(set(schema.SYSTEM) - {"id", "title"})},
        "effects": [[name, effects.get(name)] for name in scene.effects],
        "parameters": dict(scene.parameters),
        "initial": {group: dict(values) for group, values in scene.fixed.items() if values},
        "want": sorted(scene.want),
        "sweep": [
            chunk,
            axes,
            sorted(sweep.columns.items()),
            *([scene.coordinates] if scene.coordinates == FIND else ()),
            *([scene.velocity_frame] if scene.velocity_frame != COORDINATE else ()),
            *([list(sweep.keep)] if sweep.keep else ()),
            *([sorted(sweep.kinds.items())] if sweep.kinds else ()),
            *([sorted(sweep.wells.items())] if sweep.wells else ()),
        ],
        "table": table,
    }
    return {part: _digest(content[part]) for part in PARTS}


def _digest(content: object) -> str:
    text = json.dumps(content, sort_keys=True, default=_plain, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


@cache
def code() -> dict[str, str]:
    """Return the version and digest of hjsolve's sources, and the libraries that decide the last bits."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    found = {"hjsolve": f"{__version__}+{digest.hexdigest()[:12]}", "numpy": version("numpy")}
    if importlib.util.find_spec("numba") is not None:
        try:
            found["numba"] = version("numba")
        except PackageNotFoundError:
            found["numba"] = "?"
    return found
