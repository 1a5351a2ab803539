"""The equations that belong to every system: Hamilton's canonical equations, the Routhian, least action."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from hjsolve.coordinates.least_action import jacobi_metric
from hjsolve.errors import HJSolveError
from hjsolve.mechanics.system import System, kinetic_rest
from hjsolve.reports.document import Block, Code, Paragraph, Section
from hjsolve.reports.formulas.layout import Box, Fence, Glyph, Script, row, width
from hjsolve.reports.formulas.line_breaks import NARROW, narrowed
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.sections.constraint_forces import force_blocks
from hjsolve.reports.sections.system_and_verdict import EQUALS, equation, formula

_MOST_OPERATIONS = 150
"""Of one equation: a longer one fills a page, and is not read."""
_WIDEST = NARROW / 0.65
"""Letters of the longest line of the metric on a narrow screen; a longer one is written with T and V."""


def equations_section(system: System) -> Section:
    """Write down the canonical equations, the Routhian, the metric of the orbits, and the forces of constraints.

    Args:
        system: the system.
    """
    own = system.canonical_equations
    blocks: list[Block] = [Paragraph(("Hamilton's canonical equations, dq/dt = ∂H/∂p and dp/dt = −∂H/∂q:",))]
    if any(sp.count_ops(e.rhs) > _MOST_OPERATIONS for e in own.values()):
        reference = ("Hamilton's canonical equations are long; ", Code("system.canonical_equations"), " has them.")
        blocks = [Paragraph(reference)]
    else:
        names = {c.name for c in system.coordinates}
        tags = {name: "Greenwood (4-16)" if name in names else "Greenwood (4-17)" for name in own}
        blocks += [equation(e, tags[name]) for name, e in own.items()]
    blocks += _routhian(system)
    blocks += _least_action(system)
    blocks += force_blocks(system)
    return Section("equations", "Equations of motion", tuple(blocks))


def _routhian(system: System) -> list[Block]:
    held = system.kinetic.free_symbols | system.potential.free_symbols
    if system.relativity is not None or system.kinks or all(c.symbol in held for c in system.coordinates):
        return []
    try:
        R = system.routhian
    except HJSolveError:
        return []
    if sp.count_ops(R) > _MOST_OPERATIONS:
        return []
    words = "The Routhian, in which momenta stand for the velocities of the coordinates that T and V do not hold:"
    return [Paragraph((words,)), formula(Glyph("R"), R, "Greenwood (2-122)")]


def _least_action(system: System) -> list[Block]:
    """Give the metric whose geodesics are the orbits of one energy; nothing where there is none."""
    if system.time is not None or system.potential == 0:
        return []
    try:
        metric = jacobi_metric(system)
    except HJSolveError:
        return []
    if sp.count_ops(metric.kinetic) > _MOST_OPERATIONS:
        return []
    words = (
        "Principle of least action: the orbits of the energy h are geodesics, the paths of a particle with this "
        "kinetic energy and no potential:"
    )
    left = Script(Glyph("T"), sub=name_box("J"))
    shown = formula(left, metric.kinetic, "Greenwood (4-179)")
    if width(narrowed(shown.box)) > _WIDEST:
        h, minus = Glyph("h"), Glyph("−", "operator")
        V: Box = Glyph("V")
        T: Box = Glyph("T")
        if kinetic_rest(system) != 0:
            V, T = row(V, Glyph("+", "operator"), Script(T, Glyph("0", "number"))), Script(T, Glyph("2", "number"))
        shown = replace(shown, box=row(left, EQUALS, Glyph("2", "number"), Fence(row(h, minus, V)), T))
    return [Paragraph((words,)), shown]
