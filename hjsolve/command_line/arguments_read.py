"""From the arguments of a command to what they mean: a system, a scene, initial data; heavy imports wait."""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hjsolve.arguments import ascii_name
from hjsolve.errors import InvalidInputError, NotSeparableError

if TYPE_CHECKING:
    from hjsolve.catalog import Entry
    from hjsolve.extended.linear_hamiltonian import LinearHamiltonian
    from hjsolve.mechanics.coordinates_and_parameters import Parameter
    from hjsolve.mechanics.system import System
    from hjsolve.motion.motion import Motion
    from hjsolve.reports.document import Section
    from hjsolve.scenes import Scene
    from hjsolve.solution.quadratures import Solution

_NAME = re.compile(r"\s*(\w+)\s*")


def given_hamiltonian(options: Namespace) -> LinearHamiltonian | None:
    """The H(q, p) of the entry, where it gives one that is linear in p.

    Args:
        options: the parsed arguments.

    Raises:
        InvalidInputError: ``--effect`` beside an entry with H(q, p).
    """
    if options.system is None or options.coordinate or options.kinetic or options.potential or _is_scene(options):
        return None
    from hjsolve import catalog as entries

    problem = entries.hamiltonian(located(options.system))
    if problem is not None and options.effect:
        raise InvalidInputError("--effect: an entry with H(q, p) has no effects; change its hamiltonian")
    return problem


def frame(options: Namespace, solved: Solution | None = None) -> Section | None:
    """The section about the frame that an entry declares; None where it declares none.

    Args:
        options: the parsed arguments.
        solved: solution of the autonomous system, where there is one.
    """
    if options.system is None or options.coordinate or _is_scene(options):
        return None
    from hjsolve.catalog import moving_frames
    from hjsolve.reports.sections.moving_frame import frame_section

    frame = moving_frames.of(located(options.system))
    return None if frame is None else frame_section(frame, solved)


def system(options: Namespace) -> System:
    """The system that is meant: an entry, a file, or one of the user's own.

    Args:
        options: the parsed arguments.

    Raises:
        InvalidInputError: no system, two of them, or ``--function`` without a system of the user's own.
    """
    from hjsolve import catalog as entries

    own = bool(options.coordinate or options.kinetic or options.potential)
    if own and options.system is not None:
        raise InvalidInputError(
            f"give the system {options.system} or one of your own with --coordinate and --kinetic, not both"
        )
    if own:
        return _own_system(options)
    if options.function:
        raise InvalidInputError("--function belongs to a system of your own, with --coordinate and --kinetic")
    if options.system is None:
        raise InvalidInputError(
            "which system? give a catalog id, a .toml file, or --coordinate and --kinetic (see --help)"
        )
    if (question := scene(options)) is not None:
        if question.forces:
            from hjsolve.scenes.force_refusal import dissipative, force_words

            verdict = dissipative(question.system, question.forces)
            raise NotSeparableError(f"{options.system}: {force_words(verdict)}", verdict)
        return question.system
    return entries.load(located(options.system), effects=options.effect)


def _own_system(options: Namespace) -> System:
    from hjsolve.mechanics.system import System

    if not options.coordinate or not options.kinetic:
        missing = "--coordinate" if not options.coordinate else "--kinetic"
        raise InvalidInputError(
            f"a system of your own needs {missing}, "
            'e.g. --coordinate "x: line" --kinetic "m/2*dot(x)**2" --parameter m=1'
        )
    if options.effect:
        raise InvalidInputError(
            "--effect belongs to a catalog entry; write the term into --kinetic or --potential instead"
        )
    coordinates: dict[str, str] = {}
    for text in options.coordinate:
        name, colon, domain = text.partition(":")
        if not colon or not name.strip() or not domain.strip():
            raise InvalidInputError(
                f'--coordinate "{text}": write a name, a colon and a domain, e.g. "x: line" or "r: 0 < r"'
            )
        _once(coordinates, name.strip(), "--coordinate")
        coordinates[ascii_name(name.strip())] = domain.strip()
    return System(
        coordinates,
        options.kinetic,
        options.potential if options.potential is not None else "0",
        _parameters(options.parameter),
        functions=options.function,
        title=getattr(options, "title", None) or "",
    )


def _parameters(texts: list[str]) -> dict[str, Parameter]:
    """Each ``NAME``, ``NAME=VALUE``, ``NAME:ASSUMPTION`` or ``NAME=VALUE:ASSUMPTION``."""
    from hjsolve.mechanics.system import parameter

    found: dict[str, Parameter] = {}
    for text in texts:
        declared, colon, assume = text.partition(":")
        name, equals, value = declared.partition("=")
        if not _NAME.fullmatch(name) or (equals and not value.strip()) or (colon and not assume.strip()):
            raise InvalidInputError(
                f'--parameter "{text}": write a name, a value and an assumption as wanted, e.g. m, m=1 or m=1:positive'
            )
        _once(found, name.strip(), "--parameter")
        plain = ascii_name(name.strip())
        found[plain] = parameter(plain, value.strip() if equals else None, assume=assume.strip() or "real")
    return found


def _values(texts: list[str], option: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not _NAME.fullmatch(name) or not value.strip():
            raise InvalidInputError(f'{option} "{text}": write a name, an equals sign and a value, e.g. {option} r=1')
        _once(found, name.strip(), option)
        found[ascii_name(name.strip())] = value.strip()
    return found


def _once(found: Mapping[str, object], name: str, option: str) -> None:
    if ascii_name(name) in found:
        raise InvalidInputError(f'{option}: "{name}" is given twice')


def scene(options: Namespace) -> Scene | None:
    """The scene that is meant, where the file given is one.

    Args:
        options: the parsed arguments.

    Raises:
        InvalidInputError: options of a system or of a motion beside a scene, which says them itself.
    """
    if not _is_scene(options):
        return None
    from hjsolve.scenes import Scene

    own = ("coordinate", "kinetic", "potential", "parameter", "effect", "q", "velocity", "momentum")
    if any(getattr(options, name, None) for name in own):
        raise InvalidInputError(f"{options.system}: a scene says everything itself; leave the other options out")
    return Scene.load(options.system)


def _is_scene(options: Namespace) -> bool:
    if not str(options.system).endswith(".toml"):
        return False
    from hjsolve.scenes import is_scene

    return is_scene(options.system)


def initial(options: Namespace) -> dict[str, Any] | None:
    """Initial data from the command line; None where there are none.

    Args:
        options: the parsed arguments.

    Returns:
        Keywords of ``Solution.motion``.

    Raises:
        InvalidInputError: ``--q`` is missing, or there is not exactly one of ``--velocity`` and ``--momentum``.
    """
    if not (options.q or options.velocity or options.momentum):
        return None
    if not options.q or bool(options.velocity) == bool(options.momentum):
        raise InvalidInputError("a motion needs --q and one of --velocity and --momentum, for every coordinate")
    data: dict[str, Any] = {"q": _values(options.q, "--q")}
    if options.velocity:
        data["velocity"] = _values(options.velocity, "--velocity")
    else:
        data["p"] = _values(options.momentum, "--momentum")
    if options.system is not None and options.parameter:
        data["parameters"] = _given_values(options)
    return data


def own_motion(options: Namespace) -> dict[str, Any] | None:
    """The entry's own motion where its parameters or effects are changed; None where it is taken as it is.

    Args:
        options: the parsed arguments.

    Returns:
        Keywords of ``Solution.motion``.

    Raises:
        InvalidInputError: the entry has no motion of the name given by ``--motion``.
    """
    if not options.parameter and not options.effect:
        return None
    from hjsolve import catalog as entries

    entry = entries.describe(located(options.system))
    data = dict(entry_motion(entry, options.motion))
    return {**data, "parameters": {**data.get("parameters", {}), **_given_values(options)}}


def motion_meant(options: Namespace, digits: int) -> Motion:
    """The motion that is meant: of initial data given, else the entry's own.

    Args:
        options: the parsed arguments.
        digits: of the numbers.

    Raises:
        InvalidInputError: there are no initial data.
        NotSeparableError: the system does not separate.
    """
    from hjsolve import catalog as entries
    from hjsolve.solution.quadratures import solve

    data = initial(options) or (own_motion(options) if options.system is not None else None)
    meant = system(options)
    if data is None and (entry := entries.entry_of(meant)) is not None and entry.motions:
        data = dict(entry_motion(entry, options.motion))
    if data is None:
        raise InvalidInputError("which motion? give --q and --velocity (or --momentum) for every coordinate")
    return solve(meant).motion(**data, digits=digits)


def entry_motion(entry: Entry, name: str) -> Mapping[str, Any]:
    """Initial data of a motion of an entry, as keywords of ``Solution.motion``.

    Args:
        entry: of the catalog.
        name: of the motion.

    Raises:
        InvalidInputError: the entry has no motion of that name.
    """
    if name not in entry.motions:
        known = ", ".join(entry.motions) or "none"
        raise InvalidInputError(f'motion: {entry.id} has no motion "{name}"; it has {known}')
    return entry.motions[name].arguments


def _given_values(options: Namespace) -> dict[str, str]:
    return _values(options.parameter, "--parameter")


def located(target: Any) -> Any:
    """A path for a file, the text itself for an id; a helpful word for other files.

    Args:
        target: what the user gave: a catalog id, a file name, or a value that is no text, which comes back as it is.

    Raises:
        InvalidInputError: a directory, or a file whose name does not end in .toml.
    """
    if not isinstance(target, str) or target.endswith(".toml"):
        return Path(target) if isinstance(target, str) else target
    if Path(target).exists() and not re.fullmatch(r"[a-z0-9-]+", target):
        kind = "a directory" if Path(target).is_dir() else "a file, but its name does not end in .toml"
        raise InvalidInputError(f"{target}: is {kind}; give a catalog id or a .toml file")
    return target
