"""From a question to an answer: one pure function on the public verbs, with every error reported in one line."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import sympy as sp

from hjsolve import catalog
from hjsolve.errors import HJSolveError, InvalidInputError, NotConvergedError, NotSeparableError, required
from hjsolve.explorer.question import LONGEST, PageAnswer, PageQuestion, Portrait
from hjsolve.explorer.whole_system import lines_of, unfinished
from hjsolve.formulas.checked_arithmetic import FUNCTIONS
from hjsolve.formulas.read import number
from hjsolve.mechanics.system import System, momenta, velocities
from hjsolve.mechanics.typed_texts import typed_coordinates, typed_parameters
from hjsolve.motion.motion import Motion
from hjsolve.reports.document import Block, Figures, Paragraph, Section, Text
from hjsolve.reports.drawings import orbit_paths, svg
from hjsolve.reports.drawings.effective_potential import effective_potential_of
from hjsolve.reports.drawings.motion_figures import effective_potential, phase_frame, phase_portrait
from hjsolve.reports.formats.html import block_html
from hjsolve.reports.sections import obstruction, system_and_verdict
from hjsolve.reports.sections.chart import chart_section
from hjsolve.reports.sections.motion import numbers_section
from hjsolve.reports.sections.refused_motion import section_of_refused_motion
from hjsolve.reports.sections.solution import forms_section, solution_sections
from hjsolve.reports.write import report
from hjsolve.separation import Obstruction, Separation, Undecided, separate
from hjsolve.solution.quadratures import Solution, solve

_DRAGGED = 4
"""Digits of a place that was dragged to: as fine as a mouse is."""
_SEARCH = 10.0
"""Seconds for coordinates that separate: a part of those that a question may take."""
_CARRIED = 12
"""Digits of velocities that follow from it."""


def answer_question(question: PageQuestion) -> PageAnswer:
    """Answer a question as far as possible; what is wrong is reported in ``problem``, never raised."""
    try:
        system = typed_system(question)
    except HJSolveError as error:
        return _not_read(question, error)
    names = tuple(c.name for c in system.coordinates)
    question = replace(  # a start that was typed for other coordinates is none of these
        question,
        q={name: question.q.get(name, "") for name in names},
        velocity={name: question.velocity.get(name, "") for name in names},
    )
    try:
        if question.drag is not None:
            question = _dragged(question, system)
        answer = _answered(question, system)
    except HJSolveError as error:
        return PageAnswer(coordinates=names, problem=_line(error))
    return replace(answer, coordinates=names, q=question.q, velocity=question.velocity)


def _not_read(question: PageQuestion, error: HJSolveError) -> PageAnswer:
    """Return what a system that is not complete lacks as a whole, or the fault of one box."""
    try:
        missing = unfinished(question)
    except HJSolveError as fault:
        return PageAnswer(problem=_line(fault))
    whole = f"{'; '.join(missing)}."
    if missing and not question.submitted:
        return PageAnswer(unfinished=f"Not complete yet: {whole}")
    return PageAnswer(
        problem=_line(error) + (f"\nThe whole system: {whole.replace(' so far', '')}" if len(missing) > 1 else "")
    )


def typed_system(question: PageQuestion) -> System:
    """Read the system.

    Raises:
        InvalidInputError: a field is too long, or cannot be read; so do its kinds for formulas and systems.
    """
    for field in ("coordinates", "kinetic", "potential", "parameters", "title"):
        if len(getattr(question, field)) > LONGEST:
            raise InvalidInputError(f"{field}: at most {LONGEST} letters; this has {len(getattr(question, field))}")
    coordinates = typed_coordinates(lines_of(question.coordinates), "coordinate")
    parameters = typed_parameters(lines_of(question.parameters), "parameter")
    return System(
        coordinates,
        question.kinetic,
        question.potential.strip() or "0",
        parameters,
        signature=question.signature,
        relativity=question.relativity,
        functions=question.functions,
        place=_place(question, {*coordinates, *parameters}),
        title=question.title,
    )


def _place(question: PageQuestion, names: set[str]) -> Mapping[str, str]:
    """Return the entry's place, as long as it speaks of what the system has."""
    spoken_of = {name for text in question.place.values() for name in re.findall(r"[^\W\d]\w*", text)}
    return question.place if spoken_of <= names | FUNCTIONS.keys() | {"pi"} else {}


def velocities_of(question: PageQuestion, p: Mapping[str, object]) -> PageQuestion:
    """Write the velocities that go with momenta.

    Args:
        question: with a place.
        p: momenta, name → number.

    Returns:
        The question with its velocities.
    """
    system = typed_system(question)
    places = {c.symbol: number(question.q[c.name], source=c.name) for c in system.coordinates}
    given = {c.momentum: number(p[c.name], source=c.name) for c in system.coordinates}
    return replace(question, velocity=_rates(system, places, given))


def _line(error: HJSolveError) -> str:
    return " ".join(str(error).split())


# ------------------------------------------------------------------------------------------- the initial point
def _dragged(question: PageQuestion, system: System) -> PageQuestion:
    """Return the start with q and p of one coordinate changed and the other momenta kept."""
    drag = required(question.drag)
    places = {c.symbol: number(question.q[c.name], source=c.name) for c in system.coordinates}
    speeds = {c.velocity: number(question.velocity[c.name], source=c.name) for c in system.coordinates}
    values = _parameter_values(system)
    before = momenta(system)
    p = {c.momentum: before[c.name].subs(values).subs({**places, **speeds}) for c in system.coordinates}
    moved = system.coordinate(drag.name)
    places[moved.symbol] = sp.Rational(f"{drag.q:.{_DRAGGED}g}")
    p[moved.momentum] = sp.Rational(f"{drag.p:.{_DRAGGED}g}")
    q = {**question.q, drag.name: f"{drag.q:.{_DRAGGED}g}"}
    return replace(question, q=q, velocity=_rates(system, places, p), drag=None)


def _rates(system: System, places: Mapping[sp.Symbol, sp.Expr], p: Mapping[sp.Symbol, sp.Expr]) -> dict[str, str]:
    values = _parameter_values(system)
    return {name: _short(rate.subs(values).subs({**places, **p})) for name, rate in velocities(system).items()}


def _short(value: sp.Expr) -> str:
    if value.is_Integer:
        return str(value)
    return f"{float(sp.N(value, 30)):.{_CARRIED}g}"


def _parameter_values(system: System) -> dict[sp.Symbol, sp.Expr]:
    missing = [p.name for p in system.parameters if p.value is None]
    if missing:
        raise InvalidInputError(f'parameter {missing[0]}: it has no value; write "{missing[0]} = 1"')
    return {p.symbol: p.value for p in system.parameters}


# ------------------------------------------------------------------------------------------- what is told
def _answered(question: PageQuestion, system: System) -> PageAnswer:
    verdict = separate(system)
    solution, search = _solved(question, system, verdict)
    if question.wanted == "scene":
        return PageAnswer(file=scene_text(question, system))
    if question.wanted == "report":
        return PageAnswer(file=_report(solution if solution is not None else verdict, question))
    if solution is None and not isinstance(verdict, Separation):
        return _refused(question, verdict, search)
    solution = required(solution)
    lead = block_html(Paragraph(system_and_verdict.answer(solution.separation)))
    chart = chart_section(solution.chart) if solution.chart is not None else None
    details = _sections([chart, forms_section(solution.separation)])
    answer = PageAnswer("yes", lead, details, _sections(solution_sections(solution)))
    if not any(text.strip() for text in question.q.values()):
        return answer
    try:
        motion = solution.motion(q=question.q, velocity=question.velocity)
        return _moving(answer, motion, draggable=solution.chart is None)
    except HJSolveError as error:
        return replace(answer, problem=_line(error))


def _solved(
    question: PageQuestion, system: System, verdict: Separation | Obstruction | Undecided
) -> tuple[Solution | None, str]:
    """Return the solution, or None and what the search for other coordinates answered, where there was one."""
    if isinstance(verdict, Separation):
        return solve(verdict), ""
    if not question.find:
        return None, ""
    try:
        return solve(system, coordinates="find", budget=_SEARCH), ""
    except NotSeparableError as error:
        reason = _line(error)
        return None, f"Other coordinates: none found. {reason[:1].upper()}{reason[1:]}"


def _refused(question: PageQuestion, verdict: Obstruction | Undecided, search: str) -> PageAnswer:
    """Return the refusal, what the search for other coordinates answered, and the motion, integrated numerically."""
    lead = block_html(Paragraph(system_and_verdict.answer(verdict)))
    if search:
        lead += "\n" + block_html(Paragraph((search,)))
    answer = PageAnswer(
        "open" if isinstance(verdict, Undecided) else "no", lead, _sections([obstruction.refusal_section(verdict)])
    )
    if not any(text.strip() for text in question.q.values()):
        return answer
    try:
        moving = section_of_refused_motion(verdict.system, _start(question), returns=False)
    except HJSolveError as error:
        return replace(answer, problem=_line(error))
    words = "The motion is not drawn here: a drawing needs two coordinates that are not ignorable."
    return replace(answer, drawings=block_html(Paragraph((words,))) if moving is None else _sections([moving]))


def _start(question: PageQuestion) -> dict[str, dict[str, str]]:
    return {"q": dict(question.q), "velocity": dict(question.velocity)}


def _moving(answer: PageAnswer, motion: Motion, *, draggable: bool) -> PageAnswer:
    motion = motion.as_solved
    planes = tuple(_portrait(motion, name, draggable=draggable) for name in motion.solution.coordinates)
    answer = replace(answer, numbers=_sections([numbers_section(motion)]), portraits=planes)
    try:
        trace = orbit_paths.trace(motion)
        wells = [effective_potential_of(motion, name) for name in motion.solution.coordinates]
        several = len(wells) > 1
        curves = [effective_potential(well, f"potential-{k}", several=several) for k, well in enumerate(wells)]
        drawn = [orbit_paths.orbit(motion, trace, "orbit"), orbit_paths.history(motion, trace, "time")]
    except NotConvergedError as error:
        return replace(answer, problem=_line(error))
    return replace(answer, drawings=block_html(Figures((*curves, *(figure for figure in drawn if figure is not None)))))


def _portrait(motion: Motion, name: str, *, draggable: bool) -> Portrait:
    well = effective_potential_of(motion, name)
    frame, drawn = phase_frame(well), phase_portrait(well, f"phase-{name}").svg
    state = motion.at(0.0)
    q, p = float(state.q[name]), float(state.p[name])
    mark = svg.disc(frame, q, p, "dot", 7.0 if draggable else 4.2)
    box = (frame.left, frame.width - frame.right, frame.top, frame.height - frame.bottom)
    return Portrait(name, drawn.replace("</svg>", f"{mark}</svg>"), (frame.width, frame.height), frame.x, frame.y, box)


# ------------------------------------------------------------------------------------------- files
def _report(subject: Solution | Obstruction | Undecided | Separation, question: PageQuestion) -> str:
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "report.html"
        initial = _start(question) if isinstance(subject, Solution) and any(question.q.values()) else None
        report(subject, target, initial=initial)
        return target.read_text(encoding="utf-8")


def scene_text(question: PageQuestion, system: System) -> str:
    """Write the scene of a question as TOML.

    Returns:
        A text that ``Scene.load`` reads, and ``hjsolve report`` and ``hjsolve explore`` too.
    """
    lines = [f"title = {_toml(question.title or 'A system of my own')}"]
    lines.append('want = ["constants", "kinds", "turning_points", "actions", "periods", "frequencies"]')
    if question.find:
        lines.append('# its coordinates were found: solve(system, coordinates="find")')
    if any(question.q.values()):
        lines.append(f"initial = {_toml(_start(question))}")
    table = {key: value for key, value in catalog.table_of(system).items() if value not in ("", [], {})}
    lines += ["", "[system]", *(f"{key} = {_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items() if part is not None) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


# ------------------------------------------------------------------------------------------- HTML
def _sections(sections: Iterable[Section | None]) -> str:
    found = [section for section in sections if section is not None]
    titled: list[Block] = []
    for section in found:
        text: Text = (section.title,)
        titled += [*([Paragraph(text)] if len(found) > 1 else []), *section.blocks]
    return "\n".join(map(block_html, titled))
