"""From whatever a user names to the scene that is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import sympy as sp

from hjsolve import catalog
from hjsolve.arguments import refuse_unused
from hjsolve.errors import InvalidInputError, MissingValueError, required
from hjsolve.formulas.read import number
from hjsolve.mechanics.subjects import system_of
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.scenes import Scene, is_scene
from hjsolve.scenes.question import InitialGroups, Times
from hjsolve.scenes.run import first_arguments
from hjsolve.solution.quadratures import Solution, solve

Subject: TypeAlias = Scene | Motion | System | Solution | Mapping[str, object] | str | Path
_WANT = ("turning_points", "actions", "frequencies", "periods", "trajectory")
_COUNT, _CYCLES = 101, 10


def scene_of(subject: Subject, motion: str = "default") -> tuple[Scene, Solution | None]:
    """Find the scene.

    Args:
        subject: a scene, its table or its file; a catalog id or an entry's file; a motion; a system or its solution,
            with the motion of the catalog entry that it is.
        motion: which motion of the entry.

    Returns:
        The scene, and the solution of its system (None where it is to be integrated).

    Raises:
        InvalidInputError: the subject is none of these, or there is nothing to measure.
        NotSeparableError: the system does not separate.
    """
    own = isinstance(subject, (Motion, Mapping, Scene)) or (isinstance(subject, str | Path) and is_scene(subject))
    refuse_unused({"motion": own and motion != "default"}, "a motion or a scene is given, not a catalog entry")
    if isinstance(subject, Motion):
        if subject.as_solved is not subject:
            raise InvalidInputError("cost: a motion in coordinates that were found is not measured; give motion.within")
        return _usual(_scene_of_motion(subject), subject.solution), subject.solution
    if isinstance(subject, Mapping) or (isinstance(subject, str | Path) and is_scene(subject)):
        subject = Scene.load(subject)
    if isinstance(subject, Scene):
        return subject, _solution(subject)
    if isinstance(subject, Solution):
        subject = subject.system
    if not isinstance(subject, str | Path | System):
        raise InvalidInputError(
            f"cost: a Scene, a Motion, a System, a catalog id or a TOML file is needed, not {type(subject).__name__}"
        )
    system = system_of(subject, "cost")
    if isinstance(subject, System) and catalog.entry_of(system) is None:
        raise MissingValueError(
            "cost: nothing says where this system starts; give a motion, hjsolve.cost(hjsolve.solve(system).motion(…))"
        )
    named = system if isinstance(subject, System) else str(subject)
    scene = Scene.load({"system": named, **({} if motion == "default" else {"motion": motion})})
    solution = _solution(scene)
    return (scene if solution is None else _usual(scene, solution)), solution


def _solution(scene: Scene) -> Solution | None:
    if scene.initial is None:
        raise MissingValueError(f"{scene.source}: initial: missing, and the system has no default motion")
    if scene.method == "integrate":
        return None
    if scene.forces:
        scene.run()  # raises the refusal with its verdict
    return solve(scene.system)


def _scene_of_motion(motion: Motion) -> Scene:
    given = motion.given
    start = InitialGroups(given["q"], given.get("velocity"), given.get("p"), motion.t0)
    system = motion.solution.system
    table = catalog.read(system.id)[0] if catalog.entry_of(system) is not None else {}
    return Scene(
        source="motion", title=system.title, summary="", table=table, effects=(), system=system, forces={},
        parameters=given.get("parameters") or {}, initial=start, want=(), times=None, digits=15, events=(), orbit=None,
        method="quadratures",
    )  # fmt: skip


def _usual(scene: Scene, solution: Solution) -> Scene:
    """Return the scene with what is usually wanted: cycles and a hundred times over ten of them."""
    start, motion = required(scene.initial), solution.motion(**first_arguments(scene))
    stop = start.t + number(f"{_span(motion):.2g}", source="times.stop")
    return replace(
        scene, title=scene.title or scene.system.title, want=_WANT, times=Times(start=start.t, stop=stop, count=_COUNT)
    )


def _span(motion: Motion) -> float:
    """Ten of the longest cycles, or as long as an unbounded motion takes to go a few times its own size."""
    begin = float(sp.N(motion.t0, 20))
    ends = [float(e.value) - begin for e in motion.boundary_times.values() if float(e.value) > begin]
    if ends:
        return 0.9 * min(ends)
    running = [name for name, kind in motion.kinds.items() if kind in ("escape", "asymptotic", "boundary")]
    cycles = [float(motion.periods[n].value) for n in motion.solution.coordinates if n in motion.periods]
    cycles = cycles or [float(e.value) for e in motion.periods.values()]
    if cycles and not running:
        return _CYCLES * max(cycles)
    state = motion.at(motion.t0)
    scales = []
    for name in running or [c.name for c in motion.solution.system.coordinates]:
        q, v = abs(float(state.q[name])), abs(float(state.velocity[name]))
        scales.append(max(q, 0.3) / v if v > 1e-3 * max(q, 0.3) else 1.0)
    return 4 * max(scales)
