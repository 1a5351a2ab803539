"""The report of a scene: what it asks, its arcs, the quantities it wants and nothing else, and its path in time."""

from __future__ import annotations

import numpy as np

from hjsolve.arithmetic.printed_digits import shortest
from hjsolve.errors import required
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.reports.document import (
    Block,
    Code,
    Document,
    Figure,
    Figures,
    Mathematics,
    Note,
    Number,
    Paragraph,
    Section,
    Table,
    Text,
)  # fmt: skip
from hjsolve.reports.drawings import svg
from hjsolve.reports.drawings.effective_potential import Array
from hjsolve.reports.formulas.layout import Glyph
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import spoken
from hjsolve.reports.sections import solution, system_and_verdict
from hjsolve.reports.sections.chart import chart_section
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.rounded_numbers import HOW_NUMBERS_ARE_PRINTED, bound, quantity
from hjsolve.reports.sections.system_and_verdict import formula
from hjsolve.scenes import Run

_METHODS = {
    "float64": "double precision", "mpmath": "multiple precision (mpmath)", "certified": "ball arithmetic (certified)",
    "integrate": "an integrator",
}  # fmt: skip
_MOST_ROWS, _IMPACT_DIGITS = 24, 10
_TITLES = {
    "constants": "Constants of the motion", "turning_points": "Turning points", "actions": "Actions",
    "periods": "Periods", "frequencies": "Frequencies, in radians per unit time",
    "mean_velocities": "Mean velocities of ignorable coordinates",
    "boundary_times": "Times at which an end of the domain is reached",
}  # fmt: skip


def scene_document(run: Run) -> Document:
    """Write the report of a scene that has been run."""
    scene = run.scene
    sections: list[Section | None] = [_asked(run), system_and_verdict.system_section(scene.system, {}, "")]
    if run.solution is not None:
        if run.solution.chart is not None:
            sections.append(chart_section(run.solution.chart))
        sections += [solution.forms_section(run.solution.separation), *solution.solution_sections(run.solution)]
        sections += _afterwards(run)
        sections += [_impacts(run), _numbers(run)]
        lead = system_and_verdict.answer(run.solution.separation)
        verdict = "yes"
    else:
        verdict = ""
        lead = ("This scene asks for numerical integration: no Hamilton-Jacobi solution covers its forces.",)
    if run.trajectory is not None:
        sections.append(_path(run))
    if run.drift:
        sections.append(_drift(run))
    sections.append(_effort(run))
    shown = tuple(s for s in sections if s is not None)
    return Document(scene.title or "A scene", scene.system.id, lead, shown, verdict)


def _asked(run: Run) -> Section:
    scene = run.scene
    blocks: list[Block] = []
    if scene.summary:
        blocks.append(Paragraph(typeset_prose(scene.summary, scene.system)))
    effects = ", ".join(scene.effects) or "none"
    blocks.append(Paragraph(("Effects switched on: ", Code(effects), ". Wanted: ", Code(", ".join(scene.want)), ".")))
    if scene.forces:
        rows = tuple(((Mathematics(name_box(n)),), (Code(str(force)),)) for n, force in scene.forces.items())
        blocks.append(Table((("Coordinate",), ("Force",)), rows, "Forces that no T and V contain"))
    if len(run.arcs) > 1:
        blocks.append(_arcs(run))
    return Section("scene", "The scene", tuple(blocks))


def _arcs(run: Run) -> Table:
    rows: list[tuple[Text, ...]] = []
    for k, arc in enumerate(run.arcs[:_MOST_ROWS]):
        ended: Text = ("–",) if arc.ends is None else (quantity(arc.ends),)
        what = "; ".join(str(event) for event in arc.events) or "the last arc"
        rows.append(((str(k),), (quantity(arc.begins),), ended, (what,)))
    caption = "Smooth arcs: Hamilton-Jacobi holds on each, the constants are computed anew at every event"
    return Table((("Arc",), ("From",), ("To",), ("Ends with",)), tuple(rows), caption + _cut(len(run.arcs)))


def _afterwards(run: Run) -> list[Section | None]:
    """Write down the systems after constraints that last, and their solutions."""
    lasting = run.lasting
    if lasting is None or lasting.solution is None:
        return []
    system, solved = lasting.scene.system, lasting.solution
    blocks: list[Block] = [
        Paragraph(("The constraint takes coordinates away. In those that are left the energies are",)),
        formula(Glyph("T"), system.kinetic), formula(Glyph("V"), system.potential),
        *(formula(name_box(name), f) for name, f in system.eliminated),
    ]  # fmt: skip
    if solved.chart is not None:
        blocks += chart_section(solved.chart).blocks
    blocks.append(Paragraph((*system_and_verdict.answer(solved.separation),)))
    for section in solution.solution_sections(solved):
        blocks += section.blocks
    return [Section("after-constraint", "The system after the constraint", tuple(blocks)), *_afterwards(lasting)]


def _impacts(run: Run) -> Section | None:
    """Write down what each impact did, and what is left of its budgets."""
    if not run.impacts:
        return None
    blocks: list[Block] = []
    for hit in run.impacts[:_MOST_ROWS]:
        columns = (hit.velocity_before, hit.velocity, hit.momentum_before, hit.momentum, hit.impulse)
        rows: list[tuple[Text, ...]] = []
        for n in hit.velocity:
            cells: list[Text] = [(Number(shortest(x[n], _IMPACT_DIGITS)),) for x in columns]
            rows.append(((Mathematics(name_box(n)),), *cells, (bound(float(abs(hit.residual[n]))),)))
        head: tuple[Text, ...] = (
            ("Coordinate",), ("Velocity before",), ("after",), ("Momentum before",), ("after",), ("Impulse",),
            ("Left over",),
        )  # fmt: skip
        blocks += [
            Paragraph((f"{hit.event}, at t = ", Number(shortest(hit.time, _IMPACT_DIGITS)), ":")),
            Table(head, tuple(rows), "Momentum, Δp = aᵀλ (3-42)"),
            Paragraph((
                "Kinetic energy before ", Number(shortest(hit.kinetic_before, _IMPACT_DIGITS)), ", after ",
                Number(shortest(hit.kinetic, _IMPACT_DIGITS)), ", lost ",
                Number(shortest(hit.energy_lost, _IMPACT_DIGITS)),
                "; of ΔT = ½ ∑Q̂ (q̇ + q̇′) is left over ", bound(float(abs(hit.residual["energy"]))), ".",
            )),
        ]  # fmt: skip
    return Section("impacts", "The impacts", tuple(blocks))


def _cut(count: int) -> str:
    return f" (the first {_MOST_ROWS} of {count})" if count > _MOST_ROWS else ""


def _numbers(run: Run) -> Section | None:
    blocks: list[Block] = []
    for name, title in _TITLES.items():
        if name in run.scene.want and (table := _quantity(run, name, title)) is not None:
            blocks.append(table)
    if "kinds" in run.scene.want:
        blocks.append(_kinds(run))
    if not blocks:
        return None
    blocks.append(Note((HOW_NUMBERS_ARE_PRINTED,)))
    return Section("numbers", "Results with error bounds", tuple(blocks))


def _quantity(run: Run, name: str, title: str) -> Table | None:
    """One row a key and arc; turning points have two columns."""
    rows: list[tuple[Text, ...]] = []
    for k, arc in enumerate(run.arcs[:_MOST_ROWS]):
        for key, value in arc.quantities[name].items():
            cells = value if isinstance(value, tuple) else (value,)
            shown = tuple(("–",) if cell is None else (quantity(cell),) for cell in cells)
            rows.append(((Mathematics(name_box(key)),), *([(str(k),)] if len(run.arcs) > 1 else []), *shown))
    if not rows:
        return None
    columns: list[Text] = [("Lower",), ("Upper",)] if name == "turning_points" else [("Value",)]
    head: tuple[Text, ...] = (("Of",), *([("Arc",)] if len(run.arcs) > 1 else []), *columns)
    return Table(head, tuple(rows), title + _cut(len(run.arcs)))


def _kinds(run: Run) -> Table:
    rows = tuple(
        ((Mathematics(name_box(name)),), (str(k),), (kind,))
        for k, arc in enumerate(run.arcs[:_MOST_ROWS])
        for name, kind in arc.quantities["kinds"].items()
    )
    return Table((("Coordinate",), ("Arc",), ("Kind of motion",)), rows, "Kinds of motion" + _cut(len(run.arcs)))


def _path(run: Run) -> Section:
    trajectory = required(run.trajectory)
    t = np.asarray(trajectory.t, float)
    series = {name: np.asarray(trajectory.unwrapped(name), float) for name in list(trajectory.q)[:4]}
    figure = _graphs(t, series, "path", "The coordinates against time", time_name(run.scene.system))
    rows: list[tuple[Text, ...]] = []
    for name in trajectory.q:
        worst = max((float(x) for x in trajectory.error.q[name] if np.isfinite(float(x))), default=0.0)
        rows.append(((Mathematics(name_box(name)),), (bound(worst),)))
    table = Table((("Coordinate",), ("Largest error bound",)), tuple(rows), f"Accuracy over {len(t)} times")
    return Section("path", "Where it is", (Figures((figure,)), table))


def _drift(run: Run) -> Section:
    text = (
        "These quantities would be constant without the forces that destroy separability. The figure shows their "
        "change since the start."
    )
    t = np.array([float(x) for x in required(run.scene.times).exact()])
    changes = {name: np.asarray(values, float) for name, values in run.drift.items()}
    figure = _graphs(t, changes, "drift", "Drift of the former constants", time_name(run.scene.system))
    rows = tuple(((Mathematics(name_box(n)),), (Number(f"{np.max(np.abs(v)):.2g}"),)) for n, v in changes.items())
    table = Table((("Former constant",), ("Largest change",)), rows, "Drift over the whole scene")
    return Section("drift", "What became of the constants", (Paragraph((text,)), Figures((figure,)), table))


def _graphs(t: Array, series: dict[str, Array], key: str, title: str, time: str) -> Figure:
    """Curves against the parameter of the motion, which has the name ``time``, one above the other."""
    whole = 110.0 * len(series) + 60.0
    band = (whole - 40.0 - 30.0 * len(series)) / len(series)
    below, inside = [], []
    for i, (name, values) in enumerate(series.items()):
        top, last = 28.0 + i * (band + 30.0), i == len(series) - 1
        finite = values[np.isfinite(values)]
        frame = svg.DrawingFrame(
            (float(t[0]), float(t[-1]) if t[-1] > t[0] else float(t[0]) + 1.0),
            svg.spread(finite if len(finite) else np.zeros(1), 0.1), height=whole, top=top, bottom=whole - top - band,
        )  # fmt: skip
        across = svg.label(name_box(time)) if last else ""
        below.append(svg.axes(frame, across, svg.label(name_box(name)), numbers=last))
        inside.append(svg.curve(frame, t, values, "motion"))
    letter = spoken(time)
    description = f"{', '.join(map(spoken, series))} against {letter} from {letter} = {t[0]:.6g} to {t[-1]:.6g}."
    board = svg.DrawingFrame((0.0, 1.0), (0.0, 1.0), height=whole)
    data = {time: [float(x) for x in t]} | {name: [float(x) for x in v] for name, v in series.items()}
    drawn = svg.assemble(board, key, title, description, below, inside)
    return Figure(drawn, title, description, (f"{title}.",), data)


def _effort(run: Run) -> Section:
    if run.solution is None:
        text = f"Integrated to {run.scene.digits} digits with {run.work.places} evaluations of the right-hand side."
    else:
        work = run.work
        text = (
            f"Computed to {run.scene.digits} digits. Evaluated for all arcs together: the squared momenta "
            f"{work.squares} times, their derivatives {work.kernels} times, places along the motion {work.places} "
            "times."
        )
    blocks: list[Block] = [Paragraph((text,))]
    if run.choice is not None:
        chosen = f"Chosen: {_METHODS[run.choice.method]}, {run.choice.digits} digits, because {run.choice.why}."
        blocks.insert(0, Paragraph((chosen,)))
    return Section("how", "How this was computed", tuple(blocks))
