"""The live part of a page: its controls, its tables as JSON, its script, put at the head of the static report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from importlib import resources
from typing import Any

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.energy_momentum.energy_momentum_map import energy_momentum_map
from hjsolve.errors import HJSolveError
from hjsolve.lowering import lower
from hjsolve.mechanics.energy_shell import time_name
from hjsolve.motion.motion import Motion
from hjsolve.reports.drawings.cartesian_picture import embedding
from hjsolve.reports.drawings.energy_momentum_figure import map_grid, visible
from hjsolve.reports.drawings.svg import Array
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.live.tables import LiveTables, SliderRange, live_tables

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
_STYLE = """
.live{border:1px solid var(--rule);border-radius:6px;padding:.9rem 1.1rem;margin:1.2rem 0}
.live .boards{display:grid;grid-template-columns:repeat(auto-fit,minmax(15rem,1fr));gap:.8rem}
.live canvas{width:100%;aspect-ratio:6/5;display:block;touch-action:pan-y}
.live h2{margin:0 0 .6rem;padding:0;border:0}
.live figure{margin:0}.live label{display:grid;grid-template-columns:4rem 1fr 6rem;gap:.6rem;align-items:center}
.live .buttons{display:flex;gap:.6rem;flex-wrap:wrap;align-items:center;margin:.5rem 0}
.live table{margin-top:.6rem}.live td{text-align:right;font-variant-numeric:tabular-nums}
@media print{.live{display:none}}
"""
_POINTS, _TWO = 400, 2
_TORUS = "Torus of the two angle variables with the moving point; arrow keys turn it"
_CHOOSE = "A click on the map, or the arrow keys on it, choose the constants; the tables end at the dashed lines."
_MAP = "Map of all motions over the two constants, with the critical curves and the range of the sliders"


def live_page(static: str, motion: Motion) -> str:
    """Put the live part into a report.

    Args:
        static: the report as HTML.
        motion: the one it begins with.

    Returns:
        The page: one file that asks nothing of the net, and prints as the static report.

    Raises:
        InvalidInputError: the motion is of a kind that has no live report.
        NotConvergedError: its tables stay too coarse.
    """
    tables = live_tables(motion)
    head = f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}"/>\n<style>{_STYLE}</style>\n</head>'
    script = resources.files("hjsolve.reports.live").joinpath("live.js").read_text(encoding="utf-8")
    data = _data(motion, tables)
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    block = (
        f'{_controls(tables, motion, data)}<script type="application/json" id="live-data">{text}</script>\n'
        f"<script>//<![CDATA[\n{script}//]]></script>\n"
    )
    return static.replace("</head>", head, 1).replace("<main>", f"<main>\n{block}", 1)


def _controls(tables: LiveTables, motion: Motion, data: Mapping[str, Any]) -> str:
    sliders = "".join(_slider(k, s) for k, s in enumerate(tables.sliders))
    q = escape(_label(tables.coordinate))
    boards = "".join(
        f'<figure><canvas id="live-{key}" role="img" tabindex="0" aria-label="{label}"></canvas></figure>'
        for key, label in (
            ("well", f"Effective potential of {q} with the moving point"),
            ("phase", f"Phase plane of {q} with the moving point"),
            ("orbit", "Orbit with the moving point; where it is in space, arrow keys turn it"),
            *((("torus", _TORUS),) if data["torus"] else ()),
            *((("map", f"{_MAP}; a click or the arrow keys choose them"),) if data["map"] else ()),
        )
    )
    speeds = "".join(f'<option value="{v}"{" selected" if v == 1 else ""}>{v} ×</option>' for v in (0.25, 0.5, 1, 2, 4))
    worst = "; ".join(f"{escape(_label(n))} by {v:.1e}" for n, v in tables.bounds.items())
    return f"""<section id="live" class="live" aria-labelledby="live-h" hidden="hidden">
<h2 id="live-h">The motion, live</h2>
{sliders}
<div class="buttons"><button id="live-play" type="button" aria-pressed="false">Play</button>
<button id="live-start" type="button">From the start</button>
<label style="display:inline"><span>Speed</span> <select id="live-speed">{speeds}</select></label>
<span id="live-time"></span></div>
<div class="boards">{boards}</div>
<table aria-live="polite"><caption>Numbers of this motion</caption><tbody id="live-numbers"></tbody></table>
<p class="note">Computed beforehand and interpolated between: during the first two periods the page differs from
<code>Solution.motion</code> in {worst} at most: twice the largest difference found at test points of the range.
It starts at the lower turning point of {q}. {_drag(motion)} {_CHOOSE if data["map"] else ""}</p>
</section>
"""  # noqa: S608 - a select of HTML


def _drag(motion: Motion) -> str:
    shape = embedding(motion.solution.system).shape
    return "Drag the orbit, or use the arrow keys on it, to turn it." if shape in {"space", "sphere"} else ""


def _slider(k: int, s: SliderRange) -> str:
    begin = round(1000 * (s.value - s.low) / (s.high - s.low))
    return (
        f'<label><span>{escape(_label(s.name))}</span><input id="live-slider-{k}" type="range" min="0" max="1000" '
        f'step="1" value="{begin}"/><output id="live-value-{k}"></output></label>\n'
    )


def _label(name: str) -> str:
    return plain(name_box(name))


def _data(motion: Motion, tables: LiveTables) -> dict[str, Any]:
    system, names = motion.solution.system, tables.angles
    where = embedding(system)
    kept = [n for n in where.names if n == tables.coordinate or n in names]
    known = where.kind if len(kept) == len(where.names) else ""
    axes = [_label(a) for a in where.axes[:2]] if known or len(where.names) > 1 else [_label(tables.coordinate), ""]
    if not known and len(kept) < 2:
        axes = [_label(tables.coordinate), _label(f"p_{tables.coordinate}")]
    groups = ("a", "b", "t", *names, "root")
    return {
        "coordinate": tables.coordinate, "label": _label(tables.coordinate), "angles": list(names),
        "labels": {n: _label(n) for n in names}, "momentum": _label(f"p_{tables.coordinate}"),
        "level": _label(tables.sliders[-1].name), "clock": _label(time_name(system)),
        "sliders": [
            {"name": s.name, "label": _label(s.name), "low": s.low, "high": s.high, "value": s.value}
            for s in tables.sliders
        ],
        "size": max(2, *(n for c in tables.columns.values() for n in c.shape)),
        "columns": {g: _group(g, tables.columns) for g in groups},
        "well": _well(motion, tables), "bounds": dict(tables.bounds),
        "where": {"kind": known, "names": kept or [tables.coordinate], "up": where.up},
        "axes": axes, "equal": known != "" and where.shape != "coordinates",
        "ball": known in {"colatitude", "elevation"}, "centred": known in {"polar", "spherical", "parabolic"},
        "torus": next((n for n in names if system.coordinate(n).domain.kind == "angle"), None),
        "map": _map(motion, tables),
    }  # fmt: skip


def _map(motion: Motion, tables: LiveTables) -> dict[str, Any] | None:
    """The plane of the two constants: its window and its critical curves; None with one slider."""
    if len(tables.sliders) != _TWO:
        return None
    try:
        found = energy_momentum_map(motion, x=tables.sliders[0].name, y=tables.sliders[1].name)
    except HJSolveError:
        return None
    grid = map_grid(found)
    curves = []
    for curve in found.curves:
        points = zip(*visible(found, grid, curve), strict=True)
        curves.append([[_short(x), _short(y)] if np.isfinite(x + y) else None for x, y in points])
    return {"window": [list(map(float, side)) for side in found.window], "curves": curves}


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def _group(name: str, columns: Mapping[str, Array]) -> list[list[list[float]]]:
    """The tables of one series in order, an empty one for each that is zero."""
    if name in columns:
        return [_rounded(columns[name])]
    ranks = [int(key.partition(".")[2]) for key in columns if key.partition(".")[0] == name]
    return [_rounded(columns[f"{name}.{k}"]) if k in ranks else [[0.0]] for k in range(max(ranks) + 1)]


def _rounded(table: Array) -> list[list[float]]:
    return [[float(f"{v:.11g}") for v in row] for row in table]


def _well(motion: Motion, tables: LiveTables) -> dict[str, Any]:
    """P² on a grid of places, one array for each power of the constants: the effective potential of every setting."""
    solution = motion.solution
    symbols = [solution.constants[s.name].symbol for s in tables.sliders]
    values = {p.symbol: motion.initial.values[p.symbol] for p in solution.system.parameters}
    values |= {c.symbol: motion.initial.constants[n] for n, c in solution.constants.items() if c.symbol not in symbols}
    q = solution.system.coordinate(tables.coordinate).symbol
    terms = sp.Poly(sp.expand(solution.momentum_squared[tables.coordinate].subs(values)), *symbols).terms()
    low, high = (float(tables.columns[n][0, 0]) for n in ("a", "b"))
    reach = [float(np.abs(tables.columns[n]).sum() - abs(tables.columns[n][0, 0])) for n in ("a", "b")]
    half = (high - low) / 2
    begin, end = low - reach[0] - 0.5 * half, high + reach[1] + 0.5 * half
    domain = solution.system.coordinate(tables.coordinate).domain
    bounds = [None if e is None else float(e.subs(values)) for e in (domain.lower, domain.upper)]
    begin = begin if bounds[0] is None else max(begin, bounds[0] + 1e-3 * half)
    end = end if bounds[1] is None else min(end, bounds[1] - 1e-3 * half)
    places = np.linspace(begin, end, _POINTS)
    with np.errstate(all="ignore"):
        arrays = lower([c for _, c in terms], [q]).run(Float64(), [places])
    powers = [m if len(m) == 2 else (0, *m) for m, _ in terms]
    return {
        "q": [float(f"{v:.7g}") for v in places],
        "terms": [
            {"i": int(i), "j": int(j), "values": [float(f"{v:.8g}") for v in np.broadcast_to(a, places.shape)]}
            for (i, j), a in zip(powers, arrays, strict=True)
        ],
    }  # fmt: skip
