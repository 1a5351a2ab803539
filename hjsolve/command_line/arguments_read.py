"""From the arguments of a command to what they mean: a system, a scene, initial data; heavy imports wait.

``options`` are the parsed arguments.
"""

from __future__ import annotations

import re
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from hjsolve.arguments import refuse_unused
from hjsolve.errors import InvalidInputError, NotSeparableError

if TYPE_CHECKING:
    from hjsolve.catalog import Entry
    from hjsolve.extended.linear_hamiltonian import (
        GeneralHamiltonian,
        HamiltonianInTime,
        LinearHamiltonian,
        SumOfHamiltonians,
    )
    from hjsolve.extended.moving_frame import Frame
    from hjsolve.mechanics.system import System
    from hjsolve.motion.motion import Motion
    from hjsolve.motion.state import AnyMotion
    from hjsolve.reports.document import Section
    from hjsolve.scenes import Scene
    from hjsolve.solution.quadratures import Solution


def given_hamiltonian(options: Namespace) -> LinearHamiltonian | None:
    """Return the H(q, p) of the entry, where it gives one that is linear in p.

    Raises:
        InvalidInputError: ``--effect`` next to an entry with H(q, p).
    """
    if options.hamiltonian is not None:
        from hjsolve.extended.linear_hamiltonian import LinearHamiltonian

        typed = _from_hamiltonian(options)
        return typed if isinstance(typed, LinearHamiltonian) else None
    if options.system is None or options.coordinate or options.kinetic or options.potential or _is_scene(options):
        return None
    from hjsolve import catalog as entries

    problem = entries.hamiltonian(located(options.system))
    if problem is not None and options.effect:
        raise InvalidInputError("--effect: an entry with H(q, p) has no effects; change its hamiltonian")
    if problem is not None:
        without_motion = options.command in ("check", "solve")
        given = {"--find": getattr(options, "find", False), "--closed": getattr(options, "closed", False)}
        given |= {"--title": without_motion and bool(options.title)}
        refuse_unused(given, "H(q, p) is linear in p, and all of it is closed forms")
        refuse_unused({"--parameter": without_motion and bool(options.parameter)}, "the letters stay in the formulas")
    return problem


def frame(options: Namespace, solved: Solution | None = None) -> Section | None:
    """Return the section about the frame that an entry declares; None where it declares none.

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
    """Return the system that is meant: an entry, a file, or one of the user's own.

    Raises:
        InvalidInputError: no system, two of them, or ``--function`` without a system of the user's own.
    """
    from hjsolve import catalog as entries

    own = bool(options.coordinate or options.kinetic or options.potential or options.hamiltonian)
    if own and options.system is not None:
        raise InvalidInputError(
            f"give the system {options.system} or one of your own with --coordinate and --kinetic, not both"
        )
    if own:
        return _own_system(options)
    if options.title and options.command != "report":
        raise InvalidInputError("--title: names a system of your own, or a report; an entry or a scene has its title")
    if options.constraint:
        raise InvalidInputError("--constraint belongs to a system of your own, with --coordinate and --kinetic")
    if options.function:
        raise InvalidInputError("--function belongs to a system of your own, with --coordinate and --kinetic")
    if options.system is None:
        raise InvalidInputError(
            "which system? give a catalog id, a .toml file, or --coordinate and --kinetic or --hamiltonian (see --help)"
        )
    if (question := scene(options)) is not None:
        if question.forces:
            from hjsolve.scenes.force_refusal import dissipative, force_words

            verdict = dissipative(question.system, question.forces)
            raise NotSeparableError(f"{options.system}: {force_words(verdict)}", verdict)
        return question.system
    from hjsolve.mechanics.system import with_values

    return with_values(entries.load(located(options.system), effects=options.effect), _given_values(options))


def _own_system(options: Namespace) -> System:
    from hjsolve.mechanics.system import System
    from hjsolve.mechanics.typed_texts import typed_coordinates, typed_parameters

    if options.hamiltonian is not None:
        found = _from_hamiltonian(options)
        if isinstance(found, System):
            return found
        raise InvalidInputError(
            "--hamiltonian: H is not quadratic in p; in Python hjsolve.from_hamiltonian(…).motion(…) gives its motions"
        )
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
    return System(
        typed_coordinates(options.coordinate, "--coordinate"),
        options.kinetic,
        options.potential if options.potential is not None else "0",
        typed_parameters(options.parameter, "--parameter"),
        functions=options.function,
        constraints=options.constraint,
        title=getattr(options, "title", None) or "",
    )


def _from_hamiltonian(
    options: Namespace,
) -> System | LinearHamiltonian | GeneralHamiltonian | HamiltonianInTime | SumOfHamiltonians:
    from hjsolve.extended.linear_hamiltonian import from_hamiltonian
    from hjsolve.mechanics.typed_texts import typed_coordinates, typed_parameters

    if options.kinetic or options.potential or options.system is not None:
        raise InvalidInputError("--hamiltonian takes the place of SYSTEM, --kinetic and --potential")
    refuse_unused(
        {
            "--effect": bool(options.effect),
            "--function": bool(options.function),
            "--constraint": bool(options.constraint),
        },
        "--hamiltonian gives the system",
    )
    if not options.coordinate:
        raise InvalidInputError('--hamiltonian needs --coordinate, e.g. --coordinate "x: line"')
    return from_hamiltonian(
        options.hamiltonian, typed_coordinates(options.coordinate, "--coordinate"),
        typed_parameters(options.parameter, "--parameter"), title=getattr(options, "title", None) or "",
    )  # fmt: skip


def scene(options: Namespace) -> Scene | None:
    """Return the scene that is meant, where the file given is one.

    Raises:
        InvalidInputError: options of a system or of a motion next to a scene, which says them itself.
    """
    if not _is_scene(options):
        return None
    from hjsolve.scenes import Scene

    own = ("coordinate", "kinetic", "potential", "parameter", "effect", "q", "velocity", "momentum", "slider", "brief")
    changed = (getattr(options, "motion", "default"), getattr(options, "digits", 15)) != ("default", 15)
    found = getattr(options, "find", False) and options.command in ("motion", "report")
    if any(getattr(options, name, None) for name in own) or changed or found:
        raise InvalidInputError(f"{options.system}: a scene says everything itself; leave the other options out")
    return Scene.load(options.system)


def _is_scene(options: Namespace) -> bool:
    if not str(options.system).endswith(".toml"):
        return False
    from hjsolve.scenes import is_scene

    return is_scene(options.system)


def initial(options: Namespace) -> dict[str, object] | None:
    """Return initial data from the command line; None where there are none.

    Returns:
        Keywords of ``Solution.motion``.

    Raises:
        InvalidInputError: ``--q`` is missing, or there is not exactly one of ``--velocity`` and ``--momentum``.
    """
    given = bool(options.q or options.velocity or options.momentum)
    named, own = options.motion != "default", options.system is None
    refuse_unused({"--motion": named and given}, "--q and --velocity (or --momentum) are those of another motion")
    refuse_unused({"--motion": named and own}, "a system of your own has no motions with names")
    if not given:
        return None
    from hjsolve.mechanics.typed_texts import typed_values

    if not options.q or bool(options.velocity) == bool(options.momentum):
        raise InvalidInputError("a motion needs --q and one of --velocity and --momentum, for every coordinate")
    data: dict[str, object] = {"q": typed_values(options.q, "--q")}
    if options.velocity:
        data["velocity"] = typed_values(options.velocity, "--velocity")
    else:
        data["p"] = typed_values(options.momentum, "--momentum")
    if options.system is not None and options.parameter:
        data["parameters"] = _given_values(options)
    return data


def own_motion(options: Namespace) -> dict[str, object] | None:
    """Return the entry's own motion where its parameters or effects are changed; None where it is taken as it is.

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


def motion_meant(options: Namespace, digits: int, *, find: bool = False) -> Motion:
    """Return the motion that is meant: of initial data given, else the entry's own.

    Args:
        options: the parsed arguments.
        digits: of the numbers.
        find: other coordinates, where those given do not separate.

    Raises:
        InvalidInputError: there are no initial data.
        NotSeparableError: the system does not separate.
    """
    from hjsolve.solution.quadratures import AS_GIVEN, FIND, solve

    meant, data = _meant(options)
    return solve(meant, FIND if find else AS_GIVEN).motion(**data, digits=digits)


def any_motion_meant(options: Namespace) -> AnyMotion:
    """Return the motion that is meant, as ``motion_meant``; of a linear system with gyroscopic terms by its modes.

    Of an entry with a frame it is the motion as posed, which knows the one in the frame too.

    Args:
        options: the parsed arguments.

    Raises:
        InvalidInputError, NotSeparableError: as ``motion_meant``.
    """
    from hjsolve.extended.gyroscopic import gyroscopic_modes, linear_modes_of
    from hjsolve.extended.moving_frame_motion import FramedMotion
    from hjsolve.separation import Undecided

    try:
        found = motion_meant(options, options.digits, find=options.find)
        frame = _declared_frame(options)
        return found if frame is None or found.solution.chart is not None else FramedMotion(frame, found)
    except NotSeparableError as error:
        meant, data = _meant(options)
        if isinstance(error.verdict, Undecided) or linear_modes_of(meant) is None or "t0" in data:
            raise
        given = {key: data[key] for key in ("q", "velocity", "p") if key in data}
        modes = gyroscopic_modes(meant, parameters=data.get("parameters", {}), digits=options.digits)
        return modes.motion(**given)


def _declared_frame(options: Namespace) -> Frame | None:
    """Return the frame that an entry declares, where no effect changes its system."""
    from hjsolve.catalog import moving_frames

    if options.system is None or options.effect or _is_scene(options):
        return None
    return moving_frames.of(located(options.system))


def _meant(options: Namespace) -> tuple[System, dict[str, Any]]:
    """Return the system, and the initial data given or those of its entry."""
    from hjsolve import catalog as entries

    data = initial(options) or (own_motion(options) if options.system is not None else None)
    meant = system(options)
    if data is None and (entry := entries.entry_of(meant)) is not None and entry.motions:
        data = dict(entry_motion(entry, options.motion))
    if data is None:
        raise InvalidInputError("which motion? give --q and --velocity (or --momentum) for every coordinate")
    return meant, data


def entry_motion(entry: Entry, name: str) -> Mapping[str, Any]:
    """Return initial data of a motion of an entry, as keywords of ``Solution.motion``.

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
    from hjsolve.mechanics.typed_texts import typed_values

    return typed_values(options.parameter, "--parameter")


T = TypeVar("T")
"""What the user gave."""


def located(target: T) -> T | Path:
    """Return a path for a file, the text itself for an id; a helpful word for other files.

    Args:
        target: what the user gave: a catalog id, a file name, or a value that is not text, which comes back as it is.

    Raises:
        InvalidInputError: a directory, or a file whose name does not end in .toml.
    """
    if not isinstance(target, str) or target.endswith(".toml"):
        return Path(target) if isinstance(target, str) else target
    if Path(target).exists() and not re.fullmatch(r"[a-z0-9-]+", target):
        if target.endswith(".py"):
            raise InvalidInputError(f"{target}: is a Python script; run it with `python {target}`")
        kind = "a directory" if Path(target).is_dir() else "a file, but its name does not end in .toml"
        raise InvalidInputError(f"{target}: is {kind}; give a catalog id or a .toml file")
    return target


def sliders(options: Namespace) -> dict[str, tuple[float, float] | None]:
    """Return the sliders asked of a live page: name → range, None for as far as possible.

    Raises:
        InvalidInputError: a range that cannot be read, or a page that is not live.
    """
    if options.slider and not options.live:
        raise InvalidInputError("--slider: only a live report has sliders; add --live")
    found: dict[str, tuple[float, float] | None] = {}
    for text in options.slider:
        name, given, span = text.partition("=")
        low, colon, high = span.partition(":")
        try:
            found[name] = (float(low), float(high)) if given else None
        except ValueError:
            colon = ""
        if given and not colon:
            raise InvalidInputError(f"--slider {text}: write a name, or a name and a range, such as g=5:15")
    return found
