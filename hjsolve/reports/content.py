"""From a system, a verdict, a solution or a motion to the document that tells about it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import sympy as sp

from hjsolve import catalog
from hjsolve.arguments import refuse_unused
from hjsolve.catalog import moving_frames
from hjsolve.errors import (
    ForbiddenMotionError,
    ForbiddenPlaceError,
    InvalidInputError,
    NotConvergedError,
    NotSeparableError,
    of_kind,
)
from hjsolve.extended.explicit_time import QuadraticMotion, SolutionInTime, solve_in_time
from hjsolve.extended.gyroscopic import linear_modes_of
from hjsolve.extended.moving_frame import Frame
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Code, Document, Inline, Note, Section, Text
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.formulas.abbreviations import abbreviating
from hjsolve.reports.sections import motion as numerical
from hjsolve.reports.sections import obstruction, system_and_verdict
from hjsolve.reports.sections import solution as quadratures
from hjsolve.reports.sections.chart import chart_section
from hjsolve.reports.sections.closed_forms import closed_form_report
from hjsolve.reports.sections.energy_momentum import energy_momentum_section
from hjsolve.reports.sections.equations import equations_section
from hjsolve.reports.sections.laws import laws_section
from hjsolve.reports.sections.linear_modes import linear_modes_section
from hjsolve.reports.sections.literature import literature_section
from hjsolve.reports.sections.moving_frame import frame_section
from hjsolve.reports.sections.prose import heading
from hjsolve.reports.sections.quadratic import quadratic_section
from hjsolve.reports.sections.refused_motion import other_coordinates, section_of_refused_motion
from hjsolve.reports.sections.wavefronts import wavefront_section
from hjsolve.separation import DEFAULT_BUDGET, Obstruction, Separation, Undecided, separate
from hjsolve.solution.quadratures import Solution, solve

T = TypeVar("T")

Subject: TypeAlias = System | Separation | Obstruction | Undecided | Solution | Motion | str | Path


@dataclass(frozen=True)
class Material:
    """Everything a report can tell, as far as it exists.

    Attributes:
        verdict: of the system.
        solution: None where the system does not separate.
        motion: None where no initial data are known.
        entry: the catalog's entry or None.
        summary: about the initial data.
        frame: of an entry whose system as posed contains the time; None for every other.
        initial: of a motion of a system that is not solved; None where none is known.
        failure: why no motion could be started; empty where it could, or none was asked.
        refused: what is wrong with the initial data; None where they give a motion.
        quadratic: whether T or V holds the time, and S is of second degree.
        driven: the motion of such a system; None where no initial data are known.
        clock: part → seconds.
    """

    verdict: Separation | Obstruction | Undecided
    solution: Solution | None = None
    motion: Motion | None = None
    entry: catalog.Entry | None = None
    summary: str = ""
    frame: Frame | None = None
    initial: Mapping[str, object] | None = None
    failure: str = ""
    refused: ForbiddenMotionError | ForbiddenPlaceError | None = None
    quadratic: bool = False
    driven: QuadraticMotion | None = None
    clock: Mapping[str, float] = field(default_factory=dict)


def gather(
    subject: Subject,
    *,
    initial: Mapping[str, object] | None = None,
    motion: str = "default",
    digits: int = 15,
    budget: float = DEFAULT_BUDGET,
    decision: AbstractContextManager[None] | None = None,
) -> Material:
    """Bring a subject as far as its data allow: decide, solve, start a motion.

    Args:
        subject: a system, verdict, solution or motion; a catalog id, or the path of a TOML entry.
        initial: keyword arguments for ``solution.motion``; without them those of the catalog entry.
        motion: which motion of the catalog entry.
        budget: seconds for the decision, as of ``separate``.
        decision: what the decision is done within, such as a limit on its time.

    Returns:
        What there is to tell.

    Raises:
        InvalidInputError: the subject is none of these, or the entry has no such motion.
    """
    clock: dict[str, float] = {}
    if isinstance(subject, Motion):
        changed = {"initial": initial is not None, "motion": motion != "default", "digits": digits != 15}
        refuse_unused(changed, "the motion given has its own")
        return Material(
            subject.solution.separation, subject.solution, subject.as_solved, catalog.entry_of(subject.solution.system),
            clock=clock,
        )  # fmt: skip
    named = subject if isinstance(subject, str | Path) else None
    with decision or nullcontext():
        entry = None
        if isinstance(subject, str | Path):
            entry = catalog.describe(subject)
            if entry.system is None:
                raise NotSeparableError(str(entry.refusal), entry.refusal)
            subject = entry.system
        found = _in_time(subject, budget)
        if found is not None and found.solution is None:
            data, _ = initial_of(None, initial, motion)
            driven = of_kind(found.motion(**data, digits=digits), QuadraticMotion) if data else None
            return Material(_decided(subject, clock, budget)[0], quadratic=True, driven=driven, clock=clock)
        verdict, solution = _decided(subject if found is None else found.solution, clock, budget)
        entry = entry or catalog.entry_of(verdict.system)
        if isinstance(verdict, Separation) and solution is None:
            solution = _timed(clock, "solution by quadratures", lambda: solve(verdict))
    frame = moving_frames.of(named if named is not None else entry.id) if entry is not None else None
    if found is not None:
        frame, initial = found.frame, None
        entry = None
    if solution is None:
        return Material(verdict, entry=entry, frame=frame, initial=initial_of(entry, initial, motion)[0], clock=clock)
    data, summary = initial_of(entry, initial, motion)
    started, failure, refused = None, "", None
    if data:
        try:
            started = _timed(
                clock, "turning points, integrals, time law", lambda: solution.motion(**data, digits=digits).as_solved
            )
        except NotConvergedError as error:
            failure = failure_sentence(error)
        except (ForbiddenMotionError, ForbiddenPlaceError) as error:
            refused = error
    return Material(verdict, solution, started, entry, summary, frame, failure=failure, refused=refused, clock=clock)


def failure_sentence(error: NotConvergedError) -> str:
    """Return the failure in a sentence, with what was reached.

    Args:
        error: of a motion that could not be computed.
    """
    reached = f" (reached: {error.estimate})" if error.estimate is not None else ""
    return f"{' '.join(str(error).split())}{reached}"


def _in_time(subject: object, budget: float) -> SolutionInTime | None:
    """Return the solution of a system whose T or V holds the time; None of any other system.

    Raises:
        NotSeparableError: no frame was found, and H is not of second degree.
    """
    return solve_in_time(subject, budget) if isinstance(subject, System) and subject.time is not None else None


def _decided(
    subject: object, clock: dict[str, float], budget: float
) -> tuple[Separation | Obstruction | Undecided, Solution | None]:
    match subject:
        case System():
            return _timed(clock, "reduction and test", lambda: separate(subject, budget=budget)), None
        case Separation() | Obstruction() | Undecided():
            return subject, None
        case Solution():
            return subject.separation, subject
    raise InvalidInputError(
        "report: a System, a verdict, a Solution, a Motion, a catalog id or a TOML file is needed, "
        f"not {type(subject).__name__}"
    )


def initial_of(
    entry: catalog.Entry | None, given: Mapping[str, object] | None, name: str
) -> tuple[Mapping[str, Any] | None, str]:
    """Give the initial data to use, and what the catalog says about them: those given, else the entry's.

    Args:
        entry: of the catalog; None for a system of the user's own.
        given: keywords of ``Solution.motion``.
        name: of one of the entry's motions.

    Raises:
        InvalidInputError: the entry has no such motion.
    """
    if given is not None:
        refuse_unused({"motion": name != "default"}, "the initial data given are those of another motion")
        return given, ""
    if entry is None or not entry.motions:
        refuse_unused({"motion": name != "default"}, "the system is not a catalog entry with motions")
        return None, ""
    if name not in entry.motions:
        raise InvalidInputError(f'motion: {entry.id} has no motion "{name}"; it has {", ".join(entry.motions)}')
    chosen = entry.motions[name]
    return chosen.arguments, chosen.summary


def _timed(clock: dict[str, float], part: str, work: Callable[[], T]) -> T:
    begin = time.perf_counter()
    result = work()
    clock[part] = time.perf_counter() - begin
    return result


# ------------------------------------------------------------------------------------------------ the document
_ANSWERS = {Separation: "yes", Obstruction: "no", Undecided: "open"}


def document(material: Material, *, brief: bool = False) -> Document:
    """Write the document.

    Args:
        material: what there is to tell.
        brief: whether closed forms, the map of all motions and surfaces of section are left out.

    Returns:
        The document, the same for every format.
    """
    squares = material.solution.momentum_squared if material.solution is not None else {}
    letters = system_and_verdict.letters_of(material.verdict.system, squares)
    with abbreviating(letters):
        return _document(material, letters, brief=brief)


def _document(material: Material, letters: Mapping[sp.Expr, sp.Symbol], *, brief: bool) -> Document:
    verdict, entry = material.verdict, material.entry
    system, clock = verdict.system, dict(material.clock)
    chart = material.solution.chart if material.solution is not None else None
    sections: list[Section | None] = [
        chart_section(chart, material.motion) if chart is not None else None,
        system_and_verdict.system_section(
            system, entry.meanings if entry else {}, entry.summary if entry else "", letters
        ),
        frame_section(material.frame, material.solution) if material.frame is not None else None,
        equations_section(system),
        system_and_verdict.reduction_section(verdict),
        system_and_verdict.evidence_section(verdict),
    ]
    if material.quadratic:
        sections.append(_timed(clock, "coefficients of S", lambda: quadratic_section(system, material.driven)))
    elif isinstance(verdict, Separation):
        sections.append(quadratures.forms_section(verdict))
    else:
        sections += _of_refusal(material, verdict, clock, brief=brief)
    if material.solution is not None:
        solved = material.solution
        sections += quadratures.solution_sections(solved)
        forms_of = material.motion if material.motion is not None else solved
        if not brief:
            sections += _timed(clock, "closed forms, derived and verified", lambda: closed_form_report(forms_of))
        sections.append(_timed(clock, "laws the solution must obey", lambda: laws_section(solved)))
    trace, failures = None, [material.failure] if material.failure else []
    if material.motion is not None:
        given = material.motion
        trace = _add_numbers(given, material.summary, sections, failures, clock)
        if not brief:
            sections.append(_timed(clock, "wavefronts", lambda: wavefront_section(given)))
            sections.append(_timed(clock, "map of all motions", lambda: energy_momentum_section(given)))
    elif material.refused is not None:
        sections.append(_refused_motion(material.refused))
    elif material.solution is not None and not failures:
        sections.append(_no_numbers(system))
    if failures:
        sections.append(_fell_short(failures))
    sections += [literature_section(sections, entry)]
    sections.append(numerical.how_section(clock, material.motion, trace, brief=brief))
    title = heading(system.title, system.symbols) if system.title else "A mechanical system"
    shown = tuple(s for s in sections if s is not None)
    return Document(title, system.id, _lead(material), shown, _ANSWERS[type(verdict)], "; ".join(failures))


def _of_refusal(
    material: Material, verdict: Obstruction | Undecided, clock: dict[str, float], *, brief: bool
) -> list[Section | None]:
    """Why it does not separate, and what can be said of the motions all the same."""
    system = verdict.system
    modes = _timed(clock, "linear modes", lambda: linear_modes_of(system))
    sections: list[Section | None] = [obstruction.refusal_section(verdict)]
    if modes is not None:
        sections.append(linear_modes_section(modes, material.initial))
    sections.append(_timed(clock, "other coordinates", lambda: other_coordinates(system)))
    if (start := material.initial) is not None and not brief and modes is None:
        sections.append(_timed(clock, "surface of section", lambda: section_of_refused_motion(system, start)))
    return sections


def _add_numbers(
    motion: Motion, summary: str, sections: list[Section | None], failures: list[str], clock: dict[str, float]
) -> orbit_paths.Trace | None:
    """Add the drawings and the results of the motion, as far as they can be computed; the rest is reported."""
    trace = None
    try:
        trace = drawn = _timed(clock, "where it is at the times drawn", lambda: orbit_paths.trace(motion))
        sections.append(_timed(clock, "drawings", lambda: numerical.motion_section(motion, drawn, summary)))
    except NotConvergedError as error:
        failures.append(failure_sentence(error))
    try:
        sections.append(numerical.numbers_section(motion))
    except NotConvergedError as error:
        failures.append(failure_sentence(error))
    return trace


def _refused_motion(error: Exception) -> Section:
    text = f"The initial data give no motion, so there are no numbers and no drawings. {_sentence(error)}"
    return Section("unsettled", "What is wrong with the motion", (Note((text,)),))


def _sentence(error: Exception) -> str:
    words = " ".join(str(error).split())
    return f"{words[:1].upper()}{words[1:]}" + ("" if words.endswith((".", "!", "?")) else ".")


def _fell_short(failures: list[str]) -> Section:
    text = "Some results of this motion did not reach the requested digits and are omitted. The reason: "
    return Section("unsettled", "What fell short", tuple(Note((text, failure, ".")) for failure in failures))


def _lead(material: Material) -> Text:
    sentence = system_and_verdict.answer(material.verdict)
    motion = material.motion
    if motion is None or not motion.periods:
        return sentence
    names = [n for n in motion.solution.coordinates if n in motion.periods]
    if not names:
        return sentence
    from hjsolve.reports.sections.prose import listed
    from hjsolve.reports.sections.rounded_numbers import quantity

    periods = [motion.periods[name] for name in names]
    pieces: list[Inline] = [" The motion shown is periodic in ", *listed(names), ", with period "]
    if len(names) > 1 and all(period.agrees(periods[0]) for period in periods):
        pieces[-1] = ", with the same period "
        names = names[:1]
    for i, name in enumerate(names):
        pieces += [" and " if i == len(names) - 1 else ", "] if i else []
        pieces.append(quantity(motion.periods[name]))
    return (*sentence, *pieces, ".")


def _no_numbers(system: System) -> Section:
    q = ", ".join(f'"{c.name}": …' for c in system.coordinates)
    text: Text = (
        "No initial data were given, so there are no numbers and no drawings. Start a motion with ",
        Code(f"solution.motion(q={{{q}}}, velocity={{{q}}})"),
        " and report that, or give ",
        Code("--q"),
        " and ",
        Code("--velocity"),
        " on the command line.",
    )
    return Section("numbers", "Numbers", (Note(text),))
