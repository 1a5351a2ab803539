"""What the script of a live page reads: tables, formulas as tapes, names and labels, as JSON."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.tape import Tape
from hjsolve.energy_momentum.energy_momentum_map import energy_momentum_map
from hjsolve.errors import HJSolveError
from hjsolve.lowering import lower
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.mechanics.system import System
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.cartesian_picture import Embedding, embedding, usual_place
from hjsolve.reports.drawings.effective_potential import effective_potential_of
from hjsolve.reports.drawings.energy_momentum_figure import kinds_by_letter, map_grid, visible
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.live.neighbours import WAVES, LiveCoordinate, Neighbours
from hjsolve.reports.live.tables import LiveTables

_TWO, _SEEN = 2, 1 / 300
Json = dict[str, Any]


def live_data(tables: LiveTables) -> Json:
    """Return everything that the script reads."""
    subject = tables.neighbours
    motion = subject.motion
    system, values = motion.solution.system, motion.initial.values
    return {
        "sliders": [
            {"name": s.name, "label": label(s.name), "low": s.low, "high": s.high, "value": s.value}
            for s in tables.sliders
        ],
        "degrees": tables.degrees.tolist(), "size": max(2, int(tables.degrees.max()) + 1), "waves": WAVES,
        "columns": tables.table.shape[1], "table": b64encode(tables.table.astype("<f8").tobytes()).decode("ascii"),
        "base": [float(v) for v in subject.base], "moved": [subject.names.index(s.name) for s in tables.sliders],
        "coordinates": [_coordinate(tables, k, own) for k, own in enumerate(subject.coordinates)],
        "ignorable": [
            {"name": name, "label": label(name), "begin": float(sp.N(values[system.coordinate(name).symbol]))}
            for name in subject.ignorable
        ],
        "wells": [_well(subject, own) for own in subject.coordinates], "where": _where(subject),
        "torus": _torus(subject), "map": _map(tables), "clock": label(time_name(system)), "bounds": dict(tables.bounds),
    }  # fmt: skip


def label(name: str) -> str:
    """Return a name as the report prints it in a line of text.

    Args:
        name: of a coordinate, constant or parameter.
    """
    return plain(name_box(name))


def _coordinate(tables: LiveTables, k: int, own: LiveCoordinate) -> Json:
    parts = {
        group: {"begin": begin, "ranks": tables.kept[i, group].tolist()}
        for (i, group), (begin, _) in tables.layout.items()
        if i == k
    }
    named = {"name": own.name, "label": label(own.name), "momentum": label(f"p_{own.name}")}
    return {**named, "direction": own.direction, "phase": own.phase, "parts": parts}


def _tape(tape: Tape) -> Json:
    return {
        "operations": [[o.code, *o.operands, *o.payload] for o in tape.operations],
        "outputs": list(tape.outputs),
    }  # fmt: skip


def _symbols(motion: Motion) -> list[sp.Symbol]:
    solution = motion.solution
    return [*(c.symbol for c in solution.constants.values()), *(p.symbol for p in solution.system.parameters)]


def _well(subject: Neighbours, own: LiveCoordinate) -> Json:
    """P² and its derivative by the constant that plays the part of the energy: the effective potential."""
    motion = subject.motion
    solution = motion.solution
    seen, coordinate = effective_potential_of(motion, own.name), solution.system.coordinate(own.name)
    F, level = solution.momentum_squared[own.name], seen.level_name
    A = sp.diff(F, solution.constants[level].symbol) if level else sp.S.One
    ends = [float(e) if np.isfinite(e) else None for e in seen.domain] if not own.direction else [None, None]
    if coordinate.domain.kind == "angle":
        ends = [None, None]
    sign = "−" if seen.sign < 0 else ""
    return {
        "tape": _tape(lower([F, A], [coordinate.symbol, *_symbols(motion)])), "sign": seen.sign, "domain": ends,
        "level": subject.names.index(level) if level else None,
        "title": f"V_eff; red: {sign}{label(level)}" if level else "−P²/2",
    }  # fmt: skip


def _where(subject: Neighbours) -> Json:
    """Return the place of the moving point as a tape over the coordinates, and how it is drawn."""
    motion = subject.motion
    solution, system = motion.solution, motion.solution.system
    where, formulas = _drawn(motion)
    names = [c.name for c in system.coordinates]
    shown: Json = {
        "names": names, "axes": [label(a) for a in where.axes[:2]], "solid": where.shape in ("space", "sphere"),
        "equal": where.shape in ("plane", "space", "sphere"), "ball": where.shape == "sphere",
        "centred": where.kind in ("polar", "spherical", "parabolic"), "tape": None,
    }  # fmt: skip
    if formulas:
        tape = lower(formulas, [*(c.symbol for c in system.coordinates), *_symbols(motion)])
        shown["tape"] = _tape(tape)
    if where.shape == "space":
        shown["axes"] = ["", f"{', '.join(label(a) for a in where.axes)}: drag to turn"]
    if where.shape == "sphere":
        shown["axes"] = ["", ""]
    if where.shape == "line":
        shown["axes"] = [label(time_name(solution.system)), label(names[0])]
    return shown


def _drawn(motion: Motion) -> tuple[Embedding, list[sp.Expr]]:
    """Return where the motion is seen, and the formulas of it in the separated and ignorable coordinates."""
    solution = motion.solution
    chart = solution.chart
    system: System = solution.system if chart is None else chart.original
    where = embedding(system)
    if where.shape == "line":
        return where, []
    formulas = list(usual_place(where, system))
    if chart is not None:
        own = {system.coordinate(name).symbol: e for name, e in chart.transformation.items()}
        formulas = [f.xreplace(own) for f in formulas]
    known = {*(c.symbol for c in solution.system.coordinates), *_symbols(motion)}
    values = motion.initial.values
    formulas = [f.xreplace({s: values[s] for s in f.free_symbols - known if s in values}) for f in formulas]
    if any(f.free_symbols - known for f in formulas):
        symbols = [c.symbol for c in solution.system.coordinates][:_TWO]
        names = tuple(map(str, symbols))
        return Embedding("coordinates", "", names, names), list(symbols)
    return where, formulas


def _torus(subject: Neighbours) -> Json | None:
    """Which two angle variables the torus has: of two separated coordinates, or of one and an ignorable angle."""
    names = [c.name for c in subject.coordinates]
    if len(names) >= _TWO:
        return {"ignorable": False, "second": 1, "labels": [label(n) for n in names[:2]]}
    system = subject.motion.solution.system
    angles = [k for k, name in enumerate(subject.ignorable) if system.coordinate(name).domain.kind == "angle"]
    if not angles:
        return None
    drawn = embedding(system).names
    k = next((k for k in angles if subject.ignorable[k] in drawn), angles[0])
    return {"ignorable": True, "second": k, "labels": [label(names[0]), label(subject.ignorable[k])]}


_END = "end of the domain"


def _map(tables: LiveTables) -> Json | None:
    """Return the map of the static report, where both of its constants have sliders.

    Its window and its critical curves.
    """
    named = [s.name for s in tables.sliders]
    try:
        found = energy_momentum_map(tables.neighbours.motion)
        if found.x not in named or found.y not in named:
            return None
        grid = map_grid(found)
        drawn = {tuple(_thinned(*visible(found, grid, c), found.window)): c.kind == _END for c in found.curves}
    except HJSolveError:
        return None
    others = [s for s in tables.sliders if s.name not in (found.x, found.y)]
    return {
        "window": [list(map(float, side)) for side in found.window],
        "curves": [curve for curve, end in drawn.items() if len(curve) > 1 and not end],
        "ends": [curve for curve, end in drawn.items() if len(curve) > 1 and end],
        "sliders": [named.index(found.x), named.index(found.y)],
        "letters": [[_short(x), _short(y), chr(65 + k)] for k, (x, y) in enumerate(grid.letters)] if grid else [],
        "kinds": kinds_by_letter(grid) if grid else [],
        "others": ", ".join(f"{label(s.name)} = {s.value:.4g}" for s in others),
    }  # fmt: skip


def _thinned(x: Array, y: Array, window: Sequence[tuple[float, float]]) -> list[tuple[float, float] | None]:
    """Return the points of a curve that are farther from the one before than can be seen; None where it is broken."""
    u, v = ((w - low) / (high - low) for w, (low, high) in zip((x, y), window, strict=True))
    near = (np.abs(u - 0.5) < 1) & (np.abs(v - 0.5) < 1)  # false of nan
    found: list[tuple[float, float] | None] = []
    last = -1
    for k in range(len(x)):
        if not near[k]:
            if found and found[-1] is not None:
                found.append(None)
        elif not found or found[-1] is None or _away(u, v, last, k) or k + 1 == len(x) or not near[k + 1]:
            found.append((_short(x[k]), _short(y[k])))
            last = k
    return found


def _away(u: Array, v: Array, one: int, other: int) -> bool:
    return abs(u[one] - u[other]) + abs(v[one] - v[other]) > _SEEN


def _short(value: float) -> float:
    return float(f"{value:.6g}")
