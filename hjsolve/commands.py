"""What each command does: build the system, ask the library, print or write. Heavy imports wait in the functions."""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hjsolve.errors import InvalidInputError, NotSeparableError

if TYPE_CHECKING:
    from hjsolve.coordinates import NormalModes
    from hjsolve.hamiltonians import LinearHamiltonian
    from hjsolve.reports.document import Section, Text
    from hjsolve.scenes import Scene
    from hjsolve.solution import Solution
    from hjsolve.system import System

ANSWER, REFUSED, BAD_INPUT, UNSETTLED, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit statuses; see ``hjsolve.cli``."""

_NAME = re.compile(r"\s*(\w+)\s*")


def check(options: Namespace) -> int:
    """Decide and print the evidence.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve.reports import quadratures, symbolic
    from hjsolve.reports.text import wrapped
    from hjsolve.separation import Separation, separate

    if (problem := _hamiltonian(options)) is not None:
        return _print_hamiltonian(problem, solved=False)
    try:
        system = _system(options)
    except NotSeparableError as outside:  # a catalog entry that is no T and V: its reason is the answer
        print(wrapped((str(outside),)))
        return REFUSED
    verdict = separate(system)
    evidence = symbolic.evidence_section(verdict, lead=False)
    sections: list[Section | None] = [_frame(options), symbolic.reduction_section(verdict), evidence]
    sections.append(
        quadratures.forms_section(verdict) if isinstance(verdict, Separation) else symbolic.refusal_section(verdict)
    )
    _print(system, sections, symbolic.answer(verdict))
    return _status(verdict)


def solve(options: Namespace) -> int:
    """Solve by quadratures and print the formulas.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve import solution
    from hjsolve.reports import quadratures, symbolic
    from hjsolve.separation import Separation, separate

    if (problem := _hamiltonian(options)) is not None:
        return _print_hamiltonian(problem, solved=True)
    system = _system(options)
    verdict = separate(system)
    if isinstance(verdict, Separation):
        solved = solution.solve(verdict)
        _print(system, [_frame(options, solved), *quadratures.solution_sections(solved)])
    else:
        evidence = [symbolic.evidence_section(verdict, lead=False), symbolic.refusal_section(verdict)]
        _print(system, evidence, symbolic.answer(verdict))
    return _status(verdict)


def coordinates(options: Namespace) -> int:
    """Find the coordinates in which a system separates, and print them.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve.reports import webs

    system = _system(options)
    modes = _modes(system)
    if modes is not None and len(system.coordinates) not in {2, 3}:
        _print(system, [webs.modes_section(modes)], webs.modes_answer(modes))
        return ANSWER
    from hjsolve.coordinates import find_coordinates

    found = find_coordinates(system)
    oscillations = webs.modes_section(modes) if modes else None
    _print(system, [*webs.found_sections(found), oscillations], webs.found_answer(found))
    for index, web in enumerate(found.webs, 1):
        print(f"\nTo go on with {index}, {web.kind}:\n{webs.command(web.system)}")
    settled = found.complete and all(web.certified for web in found.webs)
    return (ANSWER if found.webs or modes else REFUSED) if settled else UNSETTLED


def _modes(system: System) -> NormalModes | None:
    """The normal modes of a system whose T and V are quadratic forms; None of any other."""
    from hjsolve.coordinates import normal_modes
    from hjsolve.errors import InvalidSystemError

    try:
        return normal_modes(system)
    except InvalidSystemError:
        return None


def report(options: Namespace) -> int:
    """Write a report to a file.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve.reports.files import checked_path

    target = checked_path(options.output)
    from hjsolve.cost_command import progress_bar
    from hjsolve.reports.content import gather
    from hjsolve.reports.outside import outside_document
    from hjsolve.reports.write import outside_entry, save, save_hamiltonian, save_scene, write_document

    if (scene := _scene(options)) is not None:
        print(f"wrote {save_scene(scene, target, options.cost, progress_bar())}")
        return ANSWER
    if not options.coordinate and (outside := outside_entry(_located(options.system))) is not None:
        print(f"wrote {write_document(outside_document(outside), target)}")
        return REFUSED
    initial = _initial(options)
    if _hamiltonian(options) is not None:
        initial = initial or _own_motion(options)
        told = {"initial": initial, "motion": options.motion, "digits": options.digits}
        print(f"wrote {save_hamiltonian(_located(options.system), target, **told)}")
        return ANSWER
    subject: Any = options.system
    if options.coordinate or options.effect or options.system is None:
        subject = _system(options)
    if initial is None and options.system is not None:
        initial = _own_motion(options)
    material = gather(_located(subject), initial=initial, motion=options.motion, digits=options.digits)
    print(f"wrote {save(material, target, options.cost, progress_bar())}")
    return _status(material.verdict)


def cost(options: Namespace) -> int:
    """Measure accuracy against time, and print the table.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve.cost_command import cost as measured

    measured(options, _located(options.subject))
    return ANSWER


def sweep(options: Namespace) -> int:
    """Compute the orbits that a scene declares into a folder.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve.sweeps.command import run

    return run(options)


def catalog(options: Namespace) -> int:
    """List the catalog, show an entry or check a file.

    Args:
        options: the parsed arguments.

    Returns:
        The exit status.
    """
    from hjsolve import catalog as entries
    from hjsolve import listing

    if options.action == "list":
        if options.entry is not None:
            raise InvalidInputError(f"catalog list: takes no entry; write `hjsolve catalog show {options.entry}`")
        listing.entries(separable=options.separable, kind=options.kind, book=options.book)
        return ANSWER
    if options.separable or options.kind or options.book:
        raise InvalidInputError(f"catalog {options.action}: --separable, --kind and --book choose what is listed")
    if options.entry is None:
        raise InvalidInputError(
            f"catalog {options.action}: an entry is needed, e.g. `hjsolve catalog {options.action} kepler-planar`"
        )
    entry = entries.describe(_located(options.entry))
    if options.action == "check":
        print(
            f"{options.entry}: a correct entry, {len(entry.motions)} motions, {len(entry.effects)} effects, "
            f"{len(entry.references)} reference values"
        )
    else:
        listing.entry(entry)
    return ANSWER


# -------------------------------------------------------------------------------- the system that is meant
def _hamiltonian(options: Namespace) -> LinearHamiltonian | None:
    """The H(q, p) of the entry, where it gives one that is linear in p."""
    if options.system is None or options.coordinate or options.kinetic or options.potential:
        return None
    from hjsolve import catalog as entries

    problem = entries.hamiltonian(_located(options.system))
    if problem is not None and options.effect:
        raise InvalidInputError("--effect: an entry with H(q, p) has no effects; change its hamiltonian")
    return problem


def _frame(options: Namespace, solved: Solution | None = None) -> Section | None:
    """The section about the frame that an entry declares; None where it declares none."""
    if options.system is None or options.coordinate:
        return None
    from hjsolve import frames
    from hjsolve.reports.framed import frame_section

    frame = frames.of(_located(options.system))
    return None if frame is None else frame_section(frame, solved)


def _system(options: Namespace) -> System:
    from hjsolve import catalog as entries

    own = bool(options.coordinate or options.kinetic or options.potential)
    if own and options.system is not None:
        raise InvalidInputError(
            f"give the system {options.system} or one of your own with --coordinate and --kinetic, not both"
        )
    if own:
        return _own_system(options)
    if options.system is None:
        raise InvalidInputError(
            "which system? give a catalog id, a .toml file, or --coordinate and --kinetic (see --help)"
        )
    return entries.load(_located(options.system), effects=options.effect)


def _own_system(options: Namespace) -> System:
    from hjsolve.system import System

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
        coordinates[name.strip()] = domain.strip()
    return System(
        coordinates,
        options.kinetic,
        options.potential if options.potential is not None else "0",
        _parameters(options.parameter),
    )


def _parameters(texts: list[str]) -> dict[str, str | None]:
    found: dict[str, str | None] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not _NAME.fullmatch(name) or (equals and not value.strip()):
            raise InvalidInputError(f'--parameter "{text}": write a name, or a name and a value, e.g. m or m=1')
        _once(found, name.strip(), "--parameter")
        found[name.strip()] = value.strip() if equals else None
    return found


def _values(texts: list[str], option: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not _NAME.fullmatch(name) or not value.strip():
            raise InvalidInputError(f'{option} "{text}": write a name, an equals sign and a value, e.g. {option} r=1')
        _once(found, name.strip(), option)
        found[name.strip()] = value.strip()
    return found


def _once(found: dict[str, Any], name: str, option: str) -> None:
    if name in found:
        raise InvalidInputError(f'{option}: "{name}" is given twice')


def _scene(options: Namespace) -> Scene | None:
    """The scene that is meant, where the file given is one."""
    from hjsolve.scenes import Scene, is_scene

    if options.system is None or not is_scene(options.system):
        return None
    given = (options.coordinate, options.kinetic, options.potential, options.parameter, options.effect, options.q)
    if any(given) or options.velocity or options.momentum:
        raise InvalidInputError(f"{options.system}: a scene says everything itself; leave the other options out")
    return Scene.load(options.system)


def _initial(options: Namespace) -> dict[str, Any] | None:
    """Initial data from the command line; None where there are none."""
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


def _own_motion(options: Namespace) -> dict[str, Any] | None:
    """The entry's own motion where its parameters or effects are changed; None where it is taken as it is."""
    if not options.parameter and not options.effect:
        return None
    from hjsolve import catalog as entries

    entry = entries.describe(_located(options.system))
    if options.motion not in entry.motions:
        raise InvalidInputError(
            f'motion: {entry.id} has no motion "{options.motion}"; it has {", ".join(entry.motions) or "none"}'
        )
    data: dict[str, Any] = dict(entry.motions[options.motion].arguments)
    return {**data, "parameters": {**data.get("parameters", {}), **_given_values(options)}}


def _given_values(options: Namespace) -> dict[str, str]:
    return _values(options.parameter, "--parameter")


def _located(target: Any) -> Any:
    """A path for a file, the text itself for an id; a helpful word for other files."""
    if not isinstance(target, str) or target.endswith(".toml"):
        return Path(target) if isinstance(target, str) else target
    if Path(target).exists() and not re.fullmatch(r"[a-z0-9-]+", target):
        kind = "a directory" if Path(target).is_dir() else "a file, but its name does not end in .toml"
        raise InvalidInputError(f"{target}: is {kind}; give a catalog id or a .toml file")
    return target


# -------------------------------------------------------------------------------- printing
def _status(verdict: Any) -> int:
    return {"Separation": ANSWER, "Obstruction": REFUSED, "Undecided": UNSETTLED}[type(verdict).__name__]


def _print(system: System, sections: list[Section | None], answer: Text = ()) -> None:
    from hjsolve.reports.boxes import Glyph, row
    from hjsolve.reports.notation import box
    from hjsolve.reports.plain import plain
    from hjsolve.reports.prose import heading
    from hjsolve.reports.text import section_text, wrapped

    if system.title:
        title = heading(system.title, system.symbols)
        print(f"{title}  [{system.id}]" if system.id else title)
    equals = Glyph("=", "operator")
    for letter, energy in (("T", system.kinetic), ("V", system.potential)):
        print(f"    {plain(row(Glyph(letter), equals, box(energy)))}")
    if answer:
        print(f"\n{wrapped(answer)}")
    for section in sections:
        if section is not None:
            print(f"\n{section_text(section)}")


def _print_hamiltonian(problem: LinearHamiltonian, *, solved: bool) -> int:
    from hjsolve.reports import hamiltonians
    from hjsolve.reports.boxes import Glyph, row
    from hjsolve.reports.notation import box
    from hjsolve.reports.plain import plain
    from hjsolve.reports.text import section_text, wrapped

    print(f"{problem.title}  [{problem.id}]" if problem.id else problem.title)
    print(f"    {plain(row(Glyph('H'), Glyph('=', 'operator'), box(problem.hamiltonian)))}")
    print(f"\n{wrapped(hamiltonians.answer(problem))}")
    for section in hamiltonians.solution_sections(problem) if solved else ():
        print(f"\n{section_text(section)}")
    return ANSWER
