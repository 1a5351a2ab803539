"""A task, that travels to other processes, and the tools that a process makes of it once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import sympy as sp

from hjsolve.arithmetic.error_free import split
from hjsolve.ensembles import engine as batch
from hjsolve.ensembles.axial_symmetry import AboutAxis, about_axis, solved_in_space
from hjsolve.ensembles.charted import ChartMap, chart_map
from hjsolve.ensembles.layout import Layout, layout_of
from hjsolve.lowering import lower
from hjsolve.mechanics.system import System, momenta
from hjsolve.motion.initial_data import domain_ends, sign, to_bits
from hjsolve.motion.velocity_frame import COORDINATE, factors_of
from hjsolve.precision import shared_libraries
from hjsolve.solution.quadratures import Solution, solve


@dataclass(frozen=True)
class EnsembleTask:
    """Plain values; equal tasks give equal columns, in whatever process.

    Attributes:
        system: what moves.
        want: quantities, in the order of the layout.
        parameters: (name, exact value) of every parameter.
        kind: ``p`` or ``velocity``, what comes with the places.
        fallback: whether orbits that the vectorised engine hands back go to the engine of single motions.
        found: the solution in coordinates that were found for the system; None where its own separate.
        frame: of the velocities (``motion.velocity_frame``).
    """

    system: System
    want: tuple[str, ...]
    parameters: tuple[tuple[str, sp.Expr], ...]
    kind: str
    fallback: bool = True
    found: Solution | None = field(default=None, compare=False)
    frame: str = COORDINATE


@dataclass(frozen=True)
class DomainEnd:
    """An end of a coordinate's domain, as a double that separates doubles inside from doubles outside.

    Attributes:
        name: the coordinate.
        side: 1 for a lower end, −1 for an upper one.
        value: the double nearest to the end.
        closed: whether this double itself lies inside.
    """

    name: str
    side: int
    value: float
    closed: bool


@dataclass(frozen=True, eq=False)
class TaskContext:
    """What a process makes of a task.

    Attributes:
        solution: of the system.
        layout: of the columns.
        engine: the vectorised one; None where V has kinks, and single motions serve.
        bounds: of the domains.
        momenta: from places and velocities.
        chart: the map to the separated coordinates; None where they are the user's.
        about: how stars in cylindrical coordinates are turned to where the map takes them as they are.
    """

    solution: Solution
    layout: Layout
    engine: batch.Engine | None
    bounds: tuple[DomainEnd, ...]
    momenta: batch.MomentumRule
    chart: ChartMap | None = None
    about: AboutAxis | None = None


def tools_of(task: EnsembleTask) -> TaskContext:
    """Return the tools of a task; made when a process first asks, and kept for the newest tasks.

    Args:
        task: what is to be computed of each orbit.
    """
    with shared_libraries:
        return _tools(task)


@lru_cache(maxsize=16)
def _tools(task: EnsembleTask) -> TaskContext:
    system, solution = task.system, task.found or solve(task.system)
    names = [name for name, _ in task.parameters]
    formulas = _momenta(task)
    about = about_axis(solution, task.frame)
    arguments = [c.symbol for c in system.coordinates] + [c.velocity for c in system.coordinates]
    engine = None if system.kinks else batch.build(solution, frozenset(task.want), parameters=dict(task.parameters))
    return TaskContext(
        solution=solution,
        layout=layout_of(solution, task.want),
        engine=engine,
        bounds=tuple(_bounds(task)),
        momenta=batch.MomentumRule(
            lower([formulas[c.name] for c in system.coordinates], [*arguments, *(system.symbols[n] for n in names)]),
            tuple(split(to_bits(value)(128)) for _, value in task.parameters),
        ),
        chart=None
        if engine is None
        else _chart(task, solution if about is None else solved_in_space(solution), engine),
        about=about,
    )


def _momenta(task: EnsembleTask) -> dict[str, sp.Expr]:
    """Return the momenta in places and velocities, in the frame that these are given in."""
    system, formulas = task.system, dict(momenta(task.system))
    factors = factors_of(system, task.frame, ()) if task.kind == "velocity" else None
    if factors is None:
        return formulas
    rates = {c.velocity: c.velocity / h for c, h in zip(system.coordinates, factors, strict=True)}
    return {name: p.xreplace(rates) for name, p in formulas.items()}


def _chart(task: EnsembleTask, solution: Solution, engine: batch.Engine) -> ChartMap | None:
    if solution.chart is None:
        return None
    values = {solution.system.symbols[name]: value for name, value in task.parameters}
    return chart_map(solution, engine.model, values, task.kind, task.frame)


def _bounds(task: EnsembleTask) -> list[DomainEnd]:
    values = {task.system.symbols[name]: value for name, value in task.parameters}
    found = []
    for c in task.system.coordinates:
        for end, side in zip(domain_ends(task.system, c.name, values), (1, -1), strict=True):
            if end is not None:
                number = float(to_bits(end)(128))
                found.append(DomainEnd(c.name, side, number, side * sign(end - sp.Rational(number)) < 0))
    return found
