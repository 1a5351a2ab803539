"""The sections of a report that hold numbers and drawings of one motion."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

import numpy as np
import sympy as sp

from hjsolve._version import __version__
from hjsolve.arithmetic.estimate import Estimate
from hjsolve.display.progress import duration
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.system import hamiltonian
from hjsolve.motion.formulas_at_places import tape_of, values_at
from hjsolve.motion.motion import Motion
from hjsolve.precision import mp
from hjsolve.reports.document import Block, Figure, Figures, Inline, Mathematics, Note, Paragraph, Section, Table, Text
from hjsolve.reports.drawings import orbit_paths
from hjsolve.reports.drawings.effective_potential import Array, effective_potential_of, exact_values_of
from hjsolve.reports.drawings.motion_figures import effective_potential, phase_portrait, potential_name
from hjsolve.reports.formulas.layout import Glyph, Script
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import spoken
from hjsolve.reports.sections.prose import typeset_prose
from hjsolve.reports.sections.rounded_numbers import HOW_NUMBERS_ARE_PRINTED, bound, quantity, terminating
from hjsolve.reports.sections.system_and_verdict import exactly, formula

DASH: Text = ("–",)
_SHORT, _CLEAR = 9, 1000
"""Digits of a decimal that a turning point may be; how much steeper than its error times its bend P² must be there."""


def motion_section(motion: Motion, trace: orbit_paths.Trace, summary: str) -> Section:
    """Say which motion is shown and draw it.

    Args:
        trace: where it is at the times shown.
        summary: what the catalog says about its initial data; may be empty.
    """
    description = (": ", *typeset_prose(summary, motion.solution.system)) if summary else ()
    blocks: list[Block] = [Paragraph(("One motion, as an example", *description, ".")), _initial(motion)]
    names = motion.solution.coordinates
    for i, name in enumerate(names):
        view = effective_potential_of(motion, name)
        plain = bool(sp.expand(view.formula - motion.solution.system.potential) == 0)
        several = len(names) > 1
        blocks.append(formula(potential_name(view, several=several, plain=plain), view.formula))
        blocks.append(
            Figures(
                (
                    effective_potential(view, f"potential-{i}", several=several, plain=plain),
                    phase_portrait(view, f"phase-{i}"),
                )
            )
        )
    orbit, history = orbit_paths.orbit(motion, trace, "orbit-figure"), orbit_paths.history(motion, trace, "history")
    drawings: tuple[Figure, ...] = tuple(figure for figure in (orbit, history) if figure is not None)
    return Section("motion", "A motion", (*blocks, Figures(drawings)))


def _initial(motion: Motion) -> Table:
    values = exact_values_of(motion)
    rows = tuple(
        (
            (Mathematics(name_box(c.name)),),
            exactly(values[c.symbol]),
            exactly(values[c.momentum]),
            (motion.kinds[c.name],),
        )
        for c in motion.solution.system.coordinates
    )
    header: tuple[Text, ...] = (("Coordinate",), ("Starts at",), ("with momentum",), ("Kind of motion",))
    return Table(header, rows, _at_the_start(motion))


def _at_the_start(motion: Motion) -> str:
    letter = spoken(time_name(motion.solution.system))
    return f"Initial data at {letter} = {motion.t0}, exact, and the kind of motion they lead to"


def _turning_points(motion: Motion) -> Table:
    rows = tuple(
        ((Mathematics(name_box(name)),), *(_end(motion, name, end) for end in ends))
        for name, ends in motion.turning_points.items()
    )
    return Table((("Coordinate",), ("Lower",), ("Upper",)), rows, "Turning points")


def _end(motion: Motion, name: str, end: Estimate | None) -> Text:
    """Return a turning point; exact where the motion starts there at rest, or is proved to be a short decimal."""
    if end is None:
        return DASH
    coordinate = motion.solution.system.coordinate(name)
    values = exact_values_of(motion)
    at_rest = (coordinate.momentum + motion.solution.shift[name]).xreplace(values) == 0
    here = values[coordinate.symbol]
    same = at_rest and abs(mp.mpf(sp.N(here, 40)) - mp.mpf(end.value)) <= mp.mpf(end.error)
    return _known(here if same else _short_root(motion, name, end), end)


def _short_root(motion: Motion, name: str, end: Estimate) -> sp.Rational | None:
    """Return a decimal of few digits within the error of a turning point, once it is a simple zero of P² exactly.

    Another zero within the error would need P²′ to vanish in between, so |P²′| ≤ |P²″| times the error.
    """
    nearby = sp.Rational(f"{float(end.value):.{_SHORT}g}") if math.isfinite(end.value) else None
    if nearby is None or abs(mp.mpf(sp.N(nearby, 40)) - mp.mpf(end.value)) > mp.mpf(end.error):
        return None
    q = motion.solution.system.coordinate(name).symbol
    values = {symbol: value for symbol, value in exact_values_of(motion).items() if symbol != q}
    square = motion.solution.momentum_squared[name].xreplace(values)
    if square.free_symbols != {q} or square.subs(q, nearby) != 0:
        return None
    slope, bend = (abs(complex(square.diff(q, k).subs(q, nearby).evalf(20))) for k in (1, 2))
    return nearby if slope > _CLEAR * float(end.error) * bend else None


def _known(exact: sp.Expr | None, estimate: Estimate) -> Text:
    """Return the exact decimal where a number has one, else the estimate."""
    ending = terminating(exact) if exact is not None else None
    return _number(estimate) if ending is None else (ending,)


def _number(estimate: Estimate | None) -> Text:
    return DASH if estimate is None else (quantity(estimate),)


# ------------------------------------------------------------------------------------------------ numbers
def numbers_section(motion: Motion) -> Section:
    """Give constants, actions, frequencies, periods and boundary times, each with its error."""
    values = [
        (Mathematics(name_box(p.name)), " = ", *exactly(motion.initial.values[p.symbol]), ", ")
        for p in motion.solution.system.parameters
    ]
    pieces: list[Inline] = [piece for group in values for piece in group][:-1]
    blocks: list[Block] = [Paragraph(("With ", *pieces, ". "))] if pieces else []
    exact = motion.initial.constants
    rows = tuple(((Mathematics(name_box(name)),), _known(exact.get(name), e)) for name, e in motion.constants.items())
    blocks.append(Table((("Constant",), ("Value",)), rows, "Constants of the motion"))
    if any(end is not None for ends in motion.turning_points.values() for end in ends):
        blocks.append(_turning_points(motion))
    cycles = [
        c.name
        for c in motion.solution.system.coordinates
        if c.name in {*motion.actions, *motion.frequencies, *motion.periods}
    ]
    if cycles:
        blocks.append(_cycles(motion, cycles))
    if "time" in motion.separated.parts and (means := motion.mean_velocities):
        rows = tuple(((Mathematics(name_box(name)),), _number(e)) for name, e in means.items())
        blocks.append(Table((("Coordinate",), ("Mean velocity",)), rows, "Mean velocities of ignorable coordinates"))
    if motion.boundary_times:
        times = tuple(((Mathematics(name_box(name)),), _number(e)) for name, e in motion.boundary_times.items())
        blocks.append(Table((("Coordinate",), ("Time",)), times, "Times at which an end of the domain is reached"))
    blocks.append(Note((HOW_NUMBERS_ARE_PRINTED,)))
    return Section("numbers", "Results with error bounds", tuple(blocks))


def _cycles(motion: Motion, names: list[str]) -> Table:
    letter = time_name(motion.solution.system)
    unit = "time" if letter == "t" else f"of {spoken(letter)}"
    quantities: tuple[tuple[str, Mapping[str, Estimate]], ...] = (
        ("J", motion.actions),
        ("Ω", motion.frequencies),
        ("T", motion.periods),
    )
    exact = motion.initial.constants  # the action of an ignorable coordinate is its momentum
    rows = tuple(
        (
            (Mathematics(name_box(name)),),
            DASH if name not in motion.actions else _known(exact.get(f"p_{name}"), motion.actions[name]),
            *(_number(table.get(name)) for _, table in quantities[1:]),
        )
        for name in names
    )
    heads = [
        (f"{word} ", Mathematics(Script(Glyph(letter), Glyph("i"))))
        for word, (letter, _) in zip(("Action", "Frequency"), quantities)
    ]
    header: tuple[Text, ...] = (("Coordinate",), *heads, ("Period",))  # no letter: T is the kinetic energy
    return Table(header, rows, f"Actions, frequencies (in radians per unit {unit}) and periods")


# ------------------------------------------------------------------------------------------------ how it was computed
def how_section(
    clock: Mapping[str, float], motion: Motion | None, trace: orbit_paths.Trace | None, *, brief: bool = False
) -> Section:
    """Say with what the report was computed and, unless ``SOURCE_DATE_EPOCH`` is set, how long each part took.

    Args:
        clock: part → seconds, in the order they ran.
        motion: a ``Motion``, or None where nothing numerical was done.
        trace: where it is at the times shown, or None.
        brief: whether closed forms and the map of all motions were left out.
    """
    blocks: list[Block] = []
    if motion is not None and trace is not None:
        blocks.append(_effort(motion))
        drift = energy_drift(motion, trace)
        if drift is not None:
            text = (
                "As a check that shares nothing with the quadratures, H(q(t), p(t)) was evaluated along the path "
                "drawn above; it differs from E by at most "
            )
            blocks.append(Paragraph((text, bound(drift), ".")))
    if brief:
        left_out = "Closed forms, wavefronts, the map of all motions and surfaces of section were left out: "
        blocks.append(Paragraph((left_out, "a brief report was asked.")))
    if "SOURCE_DATE_EPOCH" not in os.environ:  # what asks for reports that are the same byte for byte
        spent = tuple(((part,), (duration(time),)) for part, time in clock.items())
        blocks.append(Table((("Part",), ("Time",)), spent, "Time spent"))
    versions = tuple(((name,), (number,)) for name, number in _versions().items())
    blocks.append(Table((("Software",), ("Version",)), versions, "Versions"))
    return Section("how", "How this was computed", tuple(blocks))


def _effort(motion: Motion) -> Paragraph:
    digits, nodes = motion.digits, motion.nodes
    arithmetic = "double precision" if digits <= 15 else "multiple precision"
    several = "nodes" if nodes > 1 else "node"
    used = f", from {nodes} quadrature {several} at most per coordinate" if nodes else ""
    return Paragraph(
        (
            f"Results were requested to {digits} digits ({arithmetic}){used}. Initial data and constants of the motion "
            "are exact. The precision of the turning points was raised until all requested digits were right. No "
            "differential equation was integrated.",
        )
    )


def energy_drift(motion: Motion, trace: orbit_paths.Trace) -> float | None:
    """Evaluate H along the path that is drawn and compare it with E.

    Args:
        trace: where it is at the times shown.

    Returns:
        The largest difference; None where E is not a constant of the solution or the state is not finite.
    """
    system = motion.solution.system
    if "E" not in motion.constants:
        return None
    H = hamiltonian(system)
    symbols: list[sp.Symbol] = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    arrays: list[Array] = [np.asarray(trace.state.unwrapped(c.name), float) for c in system.coordinates]
    arrays += [np.asarray(trace.state.p[c.name], float) for c in system.coordinates]
    exact = exact_values_of(motion)
    rest = sorted(H.free_symbols - set(symbols), key=str)
    (values,) = values_at(tape_of((H,), (*symbols, *rest)), arrays, [exact[s] for s in rest])
    drift = np.abs(np.asarray(values, float) - float(motion.constants["E"].value))
    return float(np.nanmax(drift)) if np.isfinite(drift).any() else None


def _versions() -> dict[str, str]:
    found = {"hjsolve": __version__, "Python": platform.python_version()}
    for package in ("sympy", "mpmath", "numpy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return found
