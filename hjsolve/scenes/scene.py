"""A scene file: one system, the effects switched on, numbers, events, and the quantities wanted.

Loading checks everything that can be checked without computing, and names file and key of every fault. What the scene
does not call for is not read into the system: an effect that is off leaves no symbol behind.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import sympy as sp

from hjsolve import arguments, catalog
from hjsolve.catalog import toml_file
from hjsolve.catalog.effects import forces, with_effects
from hjsolve.catalog.schema import nearest
from hjsolve.catalog.toml_file import Toml
from hjsolve.display.first_lines import few_lines
from hjsolve.errors import CatalogError, InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System
from hjsolve.motion.velocity_frame import COORDINATE, ORTHONORMAL, factors_of, rates_of
from hjsolve.motion.wanted import OF_MANY_ORBITS
from hjsolve.scenes.events import read_event
from hjsolve.scenes.initial_grid import STATE, Varied, disagreements, read_sweep
from hjsolve.scenes.question import (
    INTEGRATED_DIGITS,
    MOST_INTEGRATED_DIGITS,
    InitialGroups,
    OrbitAsked,
    Question,
    Times,
)
from hjsolve.scenes.tables import scene_faults

if TYPE_CHECKING:
    from hjsolve.scenes.run import Run

_SWEEP_DIGITS = 15
_LONGEST_RUN = 86_400
_FAR_ROUND = 1_000_000
LEAST = sp.Rational(1, 10**100)
"""The smallest number that a scene with events is computed with; its inverse is the greatest."""


@dataclass(frozen=True, eq=False, repr=False)
class Scene(Question):
    """A question that can be read from a file and run.

    Its attributes are those of ``Question``, where each is explained: source, title, summary, table, effects, system,
    forces, parameters, initial, want, times, digits, events, orbit, method, coordinates, velocity_frame,
    certified, seconds, sweep.

    Example:
        >>> Scene.load("precessing-ellipse.toml").run().trajectory.q["r"]  # doctest: +SKIP
        array([1.        , 1.00...])
    """

    @staticmethod
    def load(scene: str | Path | System | Toml) -> Scene:
        """Read a scene.

        Args:
            scene: the path of a TOML file, or its table, whose ``system`` may be a ``System``; docs/scenes.md says what
                it may hold. A ``System`` or the id of a catalog entry alone is the scene of its default motion.

        Returns:
            The scene, checked.

        Raises:
            CatalogError: one line for every fault: the file, the key, what is wrong and what to write instead.

        Example:
            >>> scene = Scene.load({"system": "pendulum", "want": ["periods"]})
            >>> round(scene.run().quantity("periods")["theta"].value, 12)
            2.367841947576
        """
        table, source, folder = _opened(scene)
        problems = list(scene_faults(table))
        if problems:
            raise CatalogError(few_lines(f"{source}: {problem}" for problem in problems))
        try:
            return _built(table, source, folder)
        except InvalidInputError as error:
            text = " ".join(str(error).split())
            raise CatalogError(text if text.startswith(source) else f"{source}: {text}") from error

    def run(self) -> Run:
        """Compute what the scene wants, and nothing else, with the method its accuracy calls for (``Run.choice``).

        Raises:
            NotSeparableError: the system does not separate, or a force acts on it, and the method is ``quadratures``;
                the error carries the verdict.
            InvalidInputError: initial data that cannot be used.
            NotConvergedError: a number did not converge to the digits asked.
        """
        from hjsolve.scenes.choice import run_chosen

        return run_chosen(self)


def _opened(scene: str | Path | System | Toml) -> tuple[Toml, str, Path]:
    if isinstance(scene, System) or (isinstance(scene, str) and not scene.endswith(".toml") and scene in catalog.ids()):
        scene = {"system": scene}
    if isinstance(scene, Mapping):
        system = scene.get("system")
        return {**scene, "system": name_or_table(system)} if isinstance(system, System) else scene, "scene", Path()
    needed = "the path of a TOML file or its table, a System or a catalog id is needed"
    arguments.refuse_other(scene, (str, Path), "scene", needed)
    path, source = Path(scene), str(scene)
    return toml_file.exact_table(path, source), source, path.parent


def name_or_table(system: System) -> str | Toml:
    """Return what the key ``system`` says for a system.

    The id of its entry, which knows motions and effects, or its table.

    Args:
        system: the one the scene is about.
    """
    return system.id if catalog.entry_of(system) is not None else catalog.table_of(system)


def _built(table: Toml, source: str, folder: Path) -> Scene:
    entry, origin = _entry(table["system"], source, folder)
    names = tuple(dict.fromkeys(table.get("effects", ())))
    changed = with_effects(entry, names, f"{source}: effects")
    system = catalog.from_table(changed, source=origin)
    forced = forces(entry, names, system, source=source)
    integrated = table.get("method") == "integrate"
    sweep = read_sweep(table.get("sweep"), folder)
    usual = ("constants",) if integrated else ("constants", "periods", "actions")
    usual = (STATE,) if sweep is not None and sweep.over_tori else usual
    wanted = tuple(dict.fromkeys(table.get("want", usual)))
    result = Scene(
        source=source, title=table.get("title", changed.get("title", "")), summary=table.get("summary", ""),
        table=entry, effects=names, system=system, forces=forced, parameters=_parameters(table, entry, source),
        initial=_initial(table, entry, source, system), want=wanted, times=_times(table.get("times")),
        digits=table.get("accuracy", {}).get("digits", INTEGRATED_DIGITS if integrated else 15),
        events=tuple(read_event(e, system, f"events[{k}]") for k, e in enumerate(table.get("events", ()), start=1)),
        orbit=_orbit(table), method="integrate" if integrated else "quadratures",
        seconds=_seconds(table.get("accuracy", {}), source),
        sweep=sweep, coordinates=table.get("coordinates", "as given"),
        velocity_frame=table.get("velocity_frame", COORDINATE),
    )  # fmt: skip
    problems = list(_disagreements(result))
    if problems:
        raise CatalogError(few_lines(f"{source}: {problem}" for problem in problems))
    return result


def _entry(system: str | Toml, source: str, folder: Path) -> tuple[Toml, str]:
    """Return the table of the system, from the catalog, a file next to the scene, or the scene itself."""
    if isinstance(system, Mapping):
        return system, f"{source}: system"
    if system.endswith(".toml"):
        beside = folder / system
        return catalog.read(beside if beside.exists() or Path(system).is_absolute() else Path(system))
    return catalog.read(system)


def _motion_table(table: Toml, entry: Toml, source: str) -> Toml:
    """Return the motion of the entry that the scene starts from; empty where it has its own or there is none."""
    if "motion" not in table:
        return {} if "initial" in table else entry.get("initial", {})
    if "initial" in table:
        raise CatalogError(f"{source}: motion: the scene has initial data of its own; give one of the two")
    known = {"default": entry["initial"]} if "initial" in entry else {}
    known |= entry.get("motions", {})
    if table["motion"] not in known:
        raise CatalogError(f'{source}: motion: no motion "{table["motion"]}"{nearest(table["motion"], known)}')
    chosen: Toml = known[table["motion"]]
    return chosen


def _parameters(table: Toml, entry: Toml, source: str) -> dict[str, object]:
    own = _motion_table(table, entry, source).get("parameters", {})
    return {**own, **table.get("parameters", {})}


def _initial(table: Toml, entry: Toml, source: str, system: System) -> InitialGroups | None:
    """Return initial data; velocities along unit vectors become rates here, those of a sweep when it computes them."""
    data = table.get("initial") or _motion_table(table, entry, source)
    if "velocity_frame" in table and not {"initial", "sweep"} & table.keys():
        raise CatalogError(
            f"{source}: velocity_frame: it says what the velocities in initial or sweep mean; this scene has neither"
        )
    if not data:
        return None
    velocity = data.get("velocity")
    if table.get("velocity_frame") == ORTHONORMAL and "initial" in table and "sweep" not in table:
        factors = factors_of(system, ORTHONORMAL, velocity)
        velocity = rates_of(system, data["q"], velocity or {}, factors or ())
    return InitialGroups(data["q"], velocity, data.get("p"), number(data.get("t", 0), source=f"{source}: initial.t"))


def _times(given: Toml | list[object] | None) -> Times | None:
    if given is None:
        return None
    if isinstance(given, list):
        return Times(listed=tuple(number(t, source=f"times[{k}]") for k, t in enumerate(given, start=1)))
    start, stop = (number(given[key], source=f"times.{key}") for key in ("start", "stop"))
    return Times(start=start, stop=stop, count=given["count"])


def _seconds(accuracy: Toml, source: str) -> float | None:
    if "seconds" not in accuracy:
        return None
    value = float(number(accuracy["seconds"], source=f"{source}: accuracy.seconds"))
    if not 0 < value <= _LONGEST_RUN:
        raise CatalogError(f"{source}: accuracy.seconds: must be more than 0 and at most {_LONGEST_RUN}, not {value:g}")
    return value


def _orbit(table: Toml) -> OrbitAsked | None:
    if "orbit" not in table:
        return None
    asked = table["orbit"]
    for place, value in enumerate(asked.get("values", ()), start=1):
        number(value, source=f"orbit.values[{place}]")
    return OrbitAsked(asked["of"], asked["along"], tuple(asked.get("values", ())))


def _disagreements(scene: Scene) -> Iterator[str]:
    """Yield what the keys say against each other or against the system."""
    names, known = [c.name for c in scene.system.coordinates], [p.name for p in scene.system.parameters]
    for name, value in scene.parameters.items():
        if name not in known:
            yield f'parameters: no parameter "{name}"{nearest(name, known)}'
        number(value, source=f"parameters.{name}")
    if scene.initial is not None:
        yield from _initial_faults(scene.initial, names, partial=scene.sweep is not None)
    if scene.sweep is not None:
        yield from _sweep_faults(scene, scene.sweep, names)
    elif {"trajectory", "angles"} & set(scene.want) and scene.times is None:
        yield "times: missing; trajectory and angles are wanted, say when: {start = 0, stop = 10, count = 101}"
    if any(event.kind == "wall" for event in scene.events) and scene.times is None:
        yield "times: missing; a wall is met again and again, say until when"
    yield from _unused(scene)
    if scene.orbit is not None:
        for word in (scene.orbit.of, scene.orbit.along):
            if word not in names and scene.coordinates == "as given":
                yield f'orbit: no coordinate "{word}"{nearest(word, names)}'
        if "orbit" not in scene.want:
            yield 'orbit: described but not wanted; add "orbit" to want'
    if scene.method == "integrate":
        yield from _integrated_faults(scene)
    if scene.coordinates == "find":
        yield from _found_faults(scene)
    if scene.events:
        yield from _out_of_proportion(scene)
    yield from _time_order(scene)


def _unused(scene: Scene) -> Iterator[str]:
    """Keys that nothing wanted asks for."""
    timed = {"trajectory", "angles"} & set(scene.want) or scene.events or scene.method == "integrate"
    if scene.times is not None and not timed:
        yield "times: nothing wanted depends on them; leave them out, or add trajectory or angles to want"


def _out_of_proportion(scene: Scene) -> Iterator[str]:
    """Numbers whose powers no double holds: what happens at an event is decided in many digits, but not in any size."""
    given: dict[str, object] = {}
    if scene.initial is not None:
        for key, group in (("q", scene.initial.q), ("velocity", scene.initial.velocity), ("p", scene.initial.p)):
            given |= {f"initial.{key}.{name}": value for name, value in (group or {}).items()}
    if scene.times is not None:
        given |= {"times": scene.times.last}
    for place, event in enumerate(scene.events, start=1):
        jumps = {**(event.momentum or {}), **(event.velocity or {})}
        given |= {f"events[{place}].{name}": value for name, value in jumps.items()}
        numbers = {"at.t": event.time, "at.value": event.value, "restitution": event.restitution}
        given |= {f"events[{place}].{key}": value for key, value in numbers.items() if value is not None}
    for key, value in given.items():
        size = abs(number(value, source=key))
        if size != 0 and not LEAST <= size <= 1 / LEAST:
            yield f"{key}: with events numbers from 1e-100 to 1e100 are computed with; choose units nearer to 1"
    angles = {c.name for c in scene.system.coordinates if c.domain.kind == "angle"}
    turned = {f"initial.q.{name}": given.get(f"initial.q.{name}", 0) for name in angles} | {
        f"events[{k}].at.value": e.value for k, e in enumerate(scene.events, start=1) if e.coordinate in angles
    }
    for key, value in turned.items():
        if abs(number(value, source=key)) > _FAR_ROUND:
            yield f"{key}: an angle beyond {_FAR_ROUND}; give the same place within a turn or a few"


def _integrated_faults(scene: Scene) -> Iterator[str]:
    for word in scene.want:
        if word not in ("trajectory", "constants"):
            yield f'want: "{word}" needs quadratures; an integrated scene has trajectory and constants (drift)'
    if scene.digits > MOST_INTEGRATED_DIGITS:
        most = MOST_INTEGRATED_DIGITS
        yield f"accuracy.digits: an integrator in doubles reaches {most} at best, not {scene.digits}; ask for less"
    if scene.times is None:
        yield "times: missing; say from when to when the scene is integrated"
    for place, event in enumerate(scene.events, start=1):
        if event.kind == "wall" and not event.elastic:
            cure = "bounces that accumulate need quadratures; an integrated wall is elastic"
            yield f"events[{place}].restitution: {cure}"
        if event.lasts or event.surface is not None:
            cure = "leave method out, or give the impact a time or a coordinate and no lasts"
            yield f"events[{place}]: an impact at a surface, or one that lasts, needs quadratures; {cure}"


def _found_faults(scene: Scene) -> Iterator[str]:
    """Yield what is not done in coordinates that are found: there the times at which x has a value are not known."""
    cure = 'give the impulse a time, at = {t = "…"}, or leave coordinates out and write method = "integrate"'
    for place, event in enumerate(scene.events, start=1):
        if event.time is None:
            yield f"events[{place}]: with coordinates that are found, only impulses at given times are computed; {cure}"
    if scene.method == "integrate":
        yield 'coordinates: an integrator needs no others than the given ones; leave coordinates = "find" out'


def _sweep_faults(scene: Scene, sweep: Varied, names: list[str]) -> Iterator[str]:
    yield from disagreements(sweep, names, scene.fixed)
    known: tuple[str, ...] = (STATE,) if sweep.over_tori else OF_MANY_ORBITS
    known = (*known, STATE) if sweep.table is not None else known
    over = " over actions" if sweep.over_tori else ""
    for word in scene.want:
        if word not in known:
            yield f'want: "{word}" is not for a sweep{over}, which has {", ".join(known)}'
    if scene.digits > _SWEEP_DIGITS:
        yield f"accuracy.digits: a sweep is computed in doubles, {_SWEEP_DIGITS} digits at most, not {scene.digits}"
    if scene.seconds is not None or scene.certified:
        yield "accuracy: a sweep has neither a time nor proofs; leave seconds and certified out"
    if scene.forces:
        yield f"effects: a sweep is computed by quadratures, which the force in {', '.join(scene.forces)} forbids"


def _initial_faults(initial: InitialGroups, names: list[str], *, partial: bool) -> Iterator[str]:
    if (initial.velocity is None) == (initial.p is None) and not (partial and initial.p is None):
        yield "initial: give velocity or p, one of the two"
    for key, given in (("q", initial.q), ("velocity", initial.velocity), ("p", initial.p)):
        if given is None:
            continue
        for name in given:
            if name not in names:
                yield f'initial.{key}: no coordinate "{name}"{nearest(name, names)}'
        left = [] if partial else [name for name in names if name not in given]
        yield from (f"initial.{key}.{name}: missing; every coordinate needs one" for name in left)
        for name, value in given.items():
            number(value, source=f"initial.{key}.{name}")


def _time_order(scene: Scene) -> Iterator[str]:
    t0 = scene.initial.t if scene.initial is not None else sp.S.Zero
    for place, event in enumerate(scene.events, start=1):
        if event.time is not None and (event.time - t0).is_negative:
            yield f"events[{place}].at.t: {event.time} lies before the start at t = {t0}"
    if scene.times is None:
        return
    if scene.times.listed == () and not (scene.times.stop - scene.times.start).is_positive:
        yield "times: stop must be later than start"
    early = (scene.times.first - t0).is_negative
    if early and (scene.events or scene.method == "integrate"):
        yield f"times: {scene.times.first} lies before the start at t = {t0}; with events the motion runs forward only"
