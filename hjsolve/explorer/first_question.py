"""The question that a catalog entry or a scene is: what the page shows before anything is typed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from hjsolve import catalog
from hjsolve.errors import InvalidInputError
from hjsolve.explorer.answering import velocities_of
from hjsolve.explorer.question import PageQuestion
from hjsolve.mechanics.system import System
from hjsolve.scenes import Scene, is_scene


def question_about(subject: str | Path | None) -> PageQuestion:
    """Write the question that a catalog entry or a scene is.

    Args:
        subject: id of an entry, path of an entry or a scene; None for a system to begin with.

    Raises:
        InvalidInputError: there is no such entry, or it is not given by T and V.
    """
    if subject is None:
        return PageQuestion("x: line", "dot(x)**2/2", "x**4/4 - x**2/2", q={"x": "1.2"}, velocity={"x": "0"})
    if str(subject).endswith(".toml") and is_scene(subject):
        scene = Scene.load(subject)
        found = scene.initial
        start = {} if found is None else {"q": found.q, "velocity": found.velocity or {}, "p": found.p or {}}
        return _written(scene.system, start, scene.parameters, scene.title)
    table, source = catalog.read(subject)
    entry = catalog.describe(subject)
    if entry.system is None:
        raise InvalidInputError(f"explore {source}: {entry.refusal}")
    start = entry.motions["default"].arguments if "default" in entry.motions else {}
    written = _written(entry.system, start, {}, entry.system.title)
    as_typed = {key: table[key] for key in ("kinetic", "potential") if isinstance(table.get(key), str)}
    return replace(written, **as_typed)


def _written(
    system: System, start: Mapping[str, Mapping[str, object]], parameters: Mapping[str, object], title: str
) -> PageQuestion:
    values = {**{p.name: p.value for p in system.parameters}, **start.get("parameters", {}), **parameters}
    lines = [
        f"{p.name}{'' if values[p.name] is None else f' = {values[p.name]}'}"
        f"{'' if p.assume == 'real' else f' : {p.assume}'}"
        for p in system.parameters
    ]
    relativity = system.relativity
    question = PageQuestion(
        "\n".join(f"{c.name}: {c.domain.written(c.name)}" for c in system.coordinates),
        str(system.kinetic), str(system.potential), "\n".join(lines),
        {name: str(text) for name, text in start.get("q", {}).items()},
        {name: str(text) for name, text in start.get("velocity", {}).items()},
        signature=system.signature, functions=tuple(map(str, system.functions)), title=title,
        place={axis: str(there) for axis, there in system.places},
        relativity=None if relativity is None else {"mass": str(relativity.mass), "light": str(relativity.light)},
    )  # fmt: skip
    if question.q and not question.velocity:
        return velocities_of(question, start["p"])
    return question
