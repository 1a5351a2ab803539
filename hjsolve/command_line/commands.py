"""What each command does: build the system, ask the library, print or write. Heavy imports wait in the functions.

Every command takes ``options``, the parsed arguments, and returns the exit status.
"""

from __future__ import annotations

import sys
from argparse import Namespace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from hjsolve.arguments import refuse_unused
from hjsolve.command_line import arguments_read
from hjsolve.command_line.theorem_commands import own_coordinates
from hjsolve.command_line.time_allowed import within
from hjsolve.errors import InternalError, InvalidInputError, MissingExtraError, NotSeparableError, required

if TYPE_CHECKING:
    from hjsolve.coordinates.small_oscillations import NormalModes
    from hjsolve.costs.subject import Subject
    from hjsolve.extended.linear_hamiltonian import LinearHamiltonian
    from hjsolve.mechanics.system import System
    from hjsolve.reports.document import Section, Text
    from hjsolve.solution.quadratures import Solution

ANSWER, REFUSED, BAD_INPUT, UNSETTLED, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit statuses; see ``hjsolve.command_line.main``."""


def check_command(options: Namespace) -> int:
    """Decide and print the evidence."""
    with within(options.budget):
        return _check(options)


def _check(options: Namespace) -> int:
    from hjsolve.reports.formats.text import wrapped
    from hjsolve.reports.sections import obstruction, system_and_verdict
    from hjsolve.reports.sections import solution as quadratures
    from hjsolve.reports.sections.equations import equations_section
    from hjsolve.separation import Separation, separate

    if (problem := arguments_read.given_hamiltonian(options)) is not None:
        return _print_hamiltonian(problem, solved=False)
    try:
        system = arguments_read.system(options)
    except NotSeparableError as outside:  # a catalog entry that is not given by T and V: its reason is the answer
        print(wrapped((str(outside),)))
        return REFUSED
    if system.time is not None:
        return _in_time(system, options.budget, solved=False)
    verdict = separate(system, budget=options.budget)
    evidence = system_and_verdict.evidence_section(verdict, lead=False)
    sections: list[Section | None] = [
        arguments_read.frame(options),
        equations_section(system),
        system_and_verdict.reduction_section(verdict),
        evidence,
    ]
    sections.append(
        quadratures.forms_section(verdict) if isinstance(verdict, Separation) else obstruction.refusal_section(verdict)
    )
    if not isinstance(verdict, Separation):
        sections += _linear_modes(system)
    _print(system, sections, system_and_verdict.answer(verdict))
    return _status(verdict)


def _linear_modes(system: System) -> list[Section | None]:
    """Return the modes of a linear system with gyroscopic terms; empty for any other."""
    from hjsolve.extended.gyroscopic import linear_modes_of
    from hjsolve.reports.sections.linear_modes import linear_modes_section

    modes = linear_modes_of(system)
    return [] if modes is None else [linear_modes_section(modes)]


def solve_command(options: Namespace) -> int:
    """Solve by quadratures and print the formulas."""
    from hjsolve.reports.sections import obstruction, system_and_verdict
    from hjsolve.reports.sections import solution as quadratures
    from hjsolve.reports.sections.chart import chart_section
    from hjsolve.reports.sections.equations import equations_section
    from hjsolve.reports.sections.laws import laws_section
    from hjsolve.separation import Separation, separate
    from hjsolve.solution.quadratures import solve

    with within(options.budget):
        problem = arguments_read.given_hamiltonian(options)
        system = arguments_read.system(options) if problem is None else None
        if system is not None and system.time is not None:
            return _in_time(system, options.budget, find=options.find)
        solved = solve(system, "find", budget=options.budget) if options.find and system is not None else None
        verdict = separate(system, budget=options.budget) if solved is None and system is not None else None
        if isinstance(verdict, Separation):
            solved = solve(verdict)
    if problem is not None:
        return _print_hamiltonian(problem, solved=True)
    if solved is not None:
        _print(
            solved.system,
            [
                *(() if solved.chart is None else (chart_section(solved.chart),)),
                equations_section(solved.system),
                *(_closed(solved) if options.closed else ()),
                arguments_read.frame(options, solved),
                *quadratures.solution_sections(solved),
                laws_section(solved),
            ],
        )
        return ANSWER
    if verdict is None or isinstance(verdict, Separation):
        raise InternalError("a verdict that is not a separation is needed here; please report it")
    evidence = [
        system_and_verdict.evidence_section(verdict, lead=False),
        obstruction.refusal_section(verdict),
    ]
    modes = _linear_modes(required(system))  # a linear canonical map solves it, where no coordinates separate it
    _print(required(system), [*modes, *evidence], system_and_verdict.answer(verdict))
    return ANSWER if modes else _status(verdict)


def _in_time(system: System, budget: float, *, find: bool = False, solved: bool = True) -> int:
    """Print the solution of a system whose T or V holds the time, or what was tried."""
    from hjsolve.extended.explicit_time import solve_in_time
    from hjsolve.reports.formats.text import wrapped
    from hjsolve.reports.sections import solution as quadratures
    from hjsolve.reports.sections.moving_frame import frame_section
    from hjsolve.reports.sections.quadratic import quadratic_section
    from hjsolve.solution.quadratures import AS_GIVEN, FIND

    try:
        found = solve_in_time(system, budget, FIND if find else AS_GIVEN)
    except NotSeparableError as error:
        _print(system, [])
        print(f"\n{wrapped((str(error) + '.',))}")
        return REFUSED
    if found.frame is None or found.solution is None:
        _print(system, [quadratic_section(system)], ("H is of second degree in q and p, so S is in q.",))
        return ANSWER
    sections: list[Section | None] = [frame_section(found.frame, found.solution if solved else None)]
    sections += quadratures.solution_sections(found.solution) if solved else []
    _print(system, sections, ("It holds the time; in a frame that was found it does not, and there it separates.",))
    return ANSWER


def _closed(solved: Solution) -> list[Section]:
    """Return the closed forms, regime by regime."""
    from hjsolve.closed_form.closed_forms import closed_forms
    from hjsolve.reports.sections.closed_forms import closed_form_sections

    return closed_form_sections(closed_forms(solved))


def coordinates_command(options: Namespace) -> int:
    """Find the coordinates in which a system separates, and print them."""
    from hjsolve.reports.sections import coordinates as webs

    system = arguments_read.system(options)
    if options.place or options.new:
        from hjsolve.reports.sections.system_and_verdict import answer
        from hjsolve.separation import separate

        changed, section = own_coordinates(options, system)
        verdict = separate(changed)
        _print(changed, [section], answer(verdict))
        print(f"\nTo go on with it:\n{webs.command(changed)}")
        return _status(verdict)
    modes = _modes(system)
    if modes is not None and len(system.coordinates) not in {2, 3}:
        _print(system, [webs.modes_section(modes)], webs.modes_answer(modes))
        return ANSWER
    from hjsolve.coordinates.find import find_coordinates

    found = find_coordinates(system)
    oscillations = webs.modes_section(modes) if modes else None
    _print(system, [*webs.found_sections(found), oscillations], webs.found_answer(found))
    for index, web in enumerate(found.webs, 1):
        print(f"\nTo go on with {index}, {web.kind}:\n{webs.command(web.system)}")
    settled = found.complete and all(web.certified for web in found.webs)
    return (ANSWER if found.webs or modes else REFUSED) if settled else UNSETTLED


def _modes(system: System) -> NormalModes | None:
    """Return the normal modes of a system whose T and V are quadratic forms; None of any other."""
    from hjsolve.coordinates.small_oscillations import normal_modes
    from hjsolve.errors import InvalidSystemError

    try:
        return normal_modes(system)
    except InvalidSystemError:
        return None


def report_command(options: Namespace) -> int:
    """Write a report to a file, or to the standard output where the file is "-"."""
    from hjsolve.reports.document.files import checked_path

    if options.format and options.output != "-":
        raise InvalidInputError(f"--format: applies to -o - only; the suffix of {options.output} decides the format")
    if options.output != "-":
        status, written = _reported(options, checked_path(options.output))
        print(f"wrote {written}")
        return status
    with TemporaryDirectory() as folder:
        target = Path(folder) / f"report.{options.format or 'txt'}"
        try:
            return _reported(options, target)[0]
        finally:  # a report whose motion is refused, or falls short, is printed before its error
            if target.exists():
                print(target.read_text(encoding="utf-8"), end="")


def _reported(options: Namespace, target: Path) -> tuple[int, Path]:
    """Write the report; the exit status and the file."""
    from hjsolve.display.progress import ProgressBar
    from hjsolve.reports.content import gather
    from hjsolve.reports.document.files import SUFFIXES, checked_path
    from hjsolve.reports.sections.outside import outside_document
    from hjsolve.reports.write import (
        checked_sheet,
        outside_entry,
        refuse_live,
        save,
        save_hamiltonian,
        save_scene,
        write_document,
    )

    checked_path(target, (".html",) if options.live else SUFFIXES)
    sheet = checked_sheet(options.title or "" if options.system is not None else "", options.paper, target)
    if (scene := arguments_read.scene(options)) is not None:
        refuse_live(options.live)
        with ProgressBar() as progress:
            return ANSWER, save_scene(scene, target, options.cost, progress, sheet=sheet)
    if not options.coordinate and (outside := outside_entry(arguments_read.located(options.system))) is not None:
        _refuse_with_outside(options)
        return REFUSED, write_document(outside_document(outside), target, sheet=sheet)
    initial = arguments_read.initial(options)
    if arguments_read.given_hamiltonian(options) is not None:
        _refuse_with_hamiltonian(options)
        initial = initial or arguments_read.own_motion(options)
        more: dict[str, Any] = {"initial": initial, "motion": options.motion, "digits": options.digits, "sheet": sheet}
        return ANSWER, save_hamiltonian(arguments_read.located(options.system), target, **more)
    subject: Any = options.system
    with within(options.budget):
        if options.coordinate or options.effect or options.system is None:
            subject = arguments_read.system(options)
        if initial is None and options.system is not None:
            initial = arguments_read.own_motion(options)
        if options.find:
            subject, initial = _found(options, initial)
    material = gather(
        arguments_read.located(subject), initial=initial, motion=options.motion, digits=options.digits,
        budget=options.budget, decision=within(options.budget),
    )  # fmt: skip
    with ProgressBar() as progress:
        sliders = arguments_read.sliders(options)
        more = {"live": options.live, "sliders": sliders, "brief": options.brief, "sheet": sheet}
        status = ANSWER if material.quadratic else _status(material.verdict)
        return status, save(material, target, options.cost, progress, **more)


def _refuse_with_outside(options: Namespace) -> None:
    """Refuse options that mean nothing for an entry that is not given by T and V."""
    from hjsolve.reports.write import refuse_live

    refuse_live(options.live)
    given = {"--q": options.q, "--velocity": options.velocity, "--momentum": options.momentum}
    given |= {"--find": options.find, "--cost": options.cost, "--brief": options.brief, "--slider": options.slider}
    given |= {"--motion": options.motion != "default", "--digits": options.digits != 15}
    refuse_unused({name: bool(value) for name, value in given.items()}, "the entry is not given by T and V")


def _refuse_with_hamiltonian(options: Namespace) -> None:
    """Refuse options that mean nothing for an H(q, p) that is linear in p."""
    from hjsolve.reports.write import refuse_live

    refuse_live(options.live)
    given = {"--cost": options.cost, "--brief": options.brief, "--slider": bool(options.slider)}
    refuse_unused(given, "H(q, p) is linear in p, and all of it is closed forms")


def _found(options: Namespace, initial: Any) -> tuple[Solution, Any]:
    """Return the solution in coordinates that are found, and the motion given or that of the catalog entry."""
    from hjsolve import catalog
    from hjsolve.reports.content import initial_of
    from hjsolve.solution.quadratures import solve

    system = arguments_read.system(options)
    data, _ = initial_of(catalog.entry_of(system), initial, options.motion)
    return solve(system, "find", budget=options.budget), data


def cost_command(options: Namespace) -> int:
    """Measure accuracy against time, and print the table."""
    from hjsolve.command_line.cost import measure_and_print as measured

    own = {"--title": bool(options.title), "--function": bool(options.function)}
    refuse_unused(own if options.system is not None else {}, "they belong to a system of your own")
    changed = options.effect or options.parameter or options.q or options.velocity or options.momentum
    if options.system is None or options.coordinate or changed:
        subject: Subject = arguments_read.motion_meant(options, 15)
    else:
        subject = arguments_read.located(options.system)
    measured(options, subject)
    return ANSWER


def motion_command(options: Namespace) -> int:
    """Compute a motion, and print its numbers or its states."""
    from hjsolve.command_line.motion_tables import print_motion, print_run

    if (scene := arguments_read.scene(options)) is not None:
        print_run(scene.run(), options)
    else:
        print_motion(arguments_read.any_motion_meant(options), options)
    return ANSWER


def two_point_command(options: Namespace) -> int:
    """Find the motions that join two places in a time, and print them."""
    from hjsolve.command_line.two_places import print_connections

    print_connections(options)
    return ANSWER


def explore_command(options: Namespace) -> int:
    """Serve the explorer until it is interrupted."""
    from hjsolve.explorer.serve import serve_explorer

    serve_explorer(
        arguments_read.located(options.system) if options.system is not None else None,
        port=options.port, show=not options.no_browser, seconds=options.seconds, megabytes=options.memory,
    )  # fmt: skip
    return ANSWER


def completion_command(options: Namespace) -> int:
    """Print the completion script of a shell."""
    from hjsolve.command_line.completion import completion_script

    print(completion_script(options.shell), end="")
    return ANSWER


def sweep_command(options: Namespace) -> int:
    """Compute the orbits that a scene declares into a folder, and print one line about what was written."""
    from hjsolve.display.first_lines import few_lines
    from hjsolve.sweeps.conduct import sweep

    out = options.output
    try:
        done = sweep(
            options.scene, out, threads=options.threads, scheduler=options.scheduler, chunk=options.chunk,
            shown=False if options.quiet else None, verify=options.verify,
        )  # fmt: skip
    except KeyboardInterrupt:
        print(f"hjsolve: interrupted; what is in {out} stays; rerun the same command to resume", file=sys.stderr)
        return INTERRUPTED
    if done.notes:
        print(f"hjsolve: {few_lines(done.notes)}", file=sys.stderr)
    counts = ", ".join(f"{number} {word}" for word, number in done.statuses.items())
    before = f", {done.kept} of them by an earlier run" if done.kept and not options.verify else ""
    verb = "verified" if options.verify else "wrote"
    print(f"{verb} {done.path}: {done.orbits} orbits in {done.parts} files{before}; {counts}")
    return ANSWER


def catalog_command(options: Namespace) -> int:
    """List the catalog, show an entry or check a file.

    Raises:
        InvalidInputError: options that do not go with the action, or no entry where one is needed.
    """
    from hjsolve import catalog as entries
    from hjsolve.command_line import catalog_listing

    if options.action == "list":
        if options.entry is not None:
            raise InvalidInputError(f"catalog list: takes no entry; write `hjsolve catalog show {options.entry}`")
        catalog_listing.entries(separable=options.separable, kind=options.kind, book=options.book)
        return ANSWER
    if options.action == "search":
        return _search(options)
    if options.separable or options.kind or options.book:
        raise InvalidInputError(f"catalog {options.action}: --separable, --kind and --book choose what is listed")
    if options.entry is None:
        raise InvalidInputError(
            f"catalog {options.action}: an entry is needed, e.g. `hjsolve catalog {options.action} kepler-planar`"
        )
    entry = entries.describe(arguments_read.located(options.entry))
    if options.action == "check":
        print(
            f"{options.entry}: a correct entry, {len(entry.motions)} motions, {len(entry.effects)} effects, "
            f"{len(entry.references)} reference values"
        )
    else:
        catalog_listing.entry(entry)
    return ANSWER


# -------------------------------------------------------------------------------- printing
def _search(options: Namespace) -> int:
    from hjsolve.command_line import catalog_listing

    if options.entry is None:
        raise InvalidInputError('catalog search: words are needed, e.g. `hjsolve catalog search "black hole"`')
    found = catalog_listing.search_catalog(
        options.entry, separable=options.separable, kind=options.kind, book=options.book
    )
    return ANSWER if found else REFUSED


def _status(verdict: object) -> int:
    return {"Separation": ANSWER, "Obstruction": REFUSED, "Undecided": UNSETTLED}[type(verdict).__name__]


def _print(system: System, sections: list[Section | None], answer: Text = ()) -> None:
    from hjsolve.reports.formats.text import section_text, wrapped
    from hjsolve.reports.formulas.from_sympy import box
    from hjsolve.reports.formulas.layout import Glyph, row
    from hjsolve.reports.formulas.names import name_box
    from hjsolve.reports.formulas.one_line_text import plain
    from hjsolve.reports.sections.prose import heading

    if system.title:
        title = heading(system.title, system.symbols)
        print(f"{title}  [{system.id}]" if system.id else title)
    equals = Glyph("=", "operator")
    for letter, energy in (("T", system.kinetic), ("V", system.potential)):
        print(f"    {plain(row(Glyph(letter), equals, box(energy)))}")
    for name, formula in system.eliminated:
        print(f"    {plain(row(name_box(name), equals, box(formula)))} by the constraints")
    if answer:
        print(f"\n{wrapped(answer)}")
    for section in sections:
        if section is not None:
            print(f"\n{section_text(section)}")


def _print_hamiltonian(problem: LinearHamiltonian, *, solved: bool) -> int:
    from hjsolve.reports.formats.text import section_text, wrapped
    from hjsolve.reports.formulas.from_sympy import box
    from hjsolve.reports.formulas.layout import Glyph, row
    from hjsolve.reports.formulas.one_line_text import plain
    from hjsolve.reports.sections import linear_hamiltonian

    print(f"{problem.title}  [{problem.id}]" if problem.id else problem.title)
    print(f"    {plain(row(Glyph('H'), Glyph('=', 'operator'), box(problem.hamiltonian)))}")
    print(f"\n{wrapped(linear_hamiltonian.hamiltonian_answer(problem))}")
    for section in linear_hamiltonian.hamiltonian_solution_sections(problem) if solved else ():
        print(f"\n{section_text(section)}")
    return ANSWER


def setup_command(_options: Namespace) -> int:
    """Compile the kernels of ensembles.

    Raises:
        MissingExtraError: numba is not installed.
    """
    from hjsolve.display.progress import ProgressBar
    from hjsolve.ensembles.kernels_on_disk import compile_kernels

    with ProgressBar() as progress:
        seconds = compile_kernels(progress)
    if seconds is None:
        raise MissingExtraError('kernels are compiled by numba: pip install "hjsolve[fast]"')
    print(f"The kernels of ensembles are ready ({seconds:.1f} s of the processor).")
    return ANSWER
