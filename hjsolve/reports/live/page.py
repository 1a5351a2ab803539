"""The live part of a page: its controls, its tables as JSON, its script, put at the head of the static report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from importlib import resources

from hjsolve.motion.motion import Motion
from hjsolve.reports.live.data import Json, label, live_data
from hjsolve.reports.live.neighbours import LONG_SERIES, OTHER_KIND, SAME
from hjsolve.reports.live.ranges import INACCURATE, SliderRange
from hjsolve.reports.live.tables import LiveTables, live_tables

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
_STYLE = """
.live{border:1px solid var(--rule);border-radius:6px;padding:.9rem 1.1rem;margin:1.2rem 0}
.live .boards{display:grid;grid-template-columns:repeat(auto-fit,minmax(15rem,1fr));gap:.8rem}
.live canvas{width:100%;aspect-ratio:6/5;display:block;touch-action:pan-y}
.live h2{margin:0 0 .6rem;padding:0;border:0}
.live figure{margin:0}.live label{display:grid;grid-template-columns:4rem 1fr 6rem;gap:.6rem;align-items:center}
.live sub{font-size:.72em;line-height:0}.live input[type=range]{accent-color:var(--blue);height:1.6rem}
.live button,.live select{font:.92rem var(--sans);padding:.4rem .9rem;min-height:2.3rem;border:1px solid var(--rule);
border-radius:5px;background:var(--wash);color:var(--ink);cursor:pointer}
.live button:hover{border-color:var(--ink)}
.live :is(button,input,select,canvas):focus-visible{outline:2px solid var(--blue);
outline-offset:2px}
@media (max-width:40rem){.live{padding:.8rem .7rem}.live label{grid-template-columns:2.6rem 1fr 5rem}
.live input[type=range]{height:2.75rem}.live button,.live select{min-height:2.75rem}}
.live .buttons{display:flex;gap:.6rem;flex-wrap:wrap;align-items:center;margin:.5rem 0}
.live table{margin-top:.6rem}.live td{text-align:right;font-variant-numeric:tabular-nums}
.live summary{cursor:pointer;min-height:2rem}
.live-ends td:nth-child(odd){text-align:left}
@media print{.live{display:none}}
"""
_TORUS = "Torus of two angle variables with the moving point; arrow keys turn it"
_CHOOSE = "A click on the map, or the arrow keys on it, choose the constants; the tables end at the dashed lines."
_MAP = "Map of all motions over two constants, with the critical curves and the range of the sliders"


def live_page(static: str, motion: Motion, asked: Mapping[str, tuple[float, float] | None] | None = None) -> str:
    """Put the live part into a report.

    Args:
        static: the report as HTML.
        motion: the one it begins with.
        asked: constants and parameters that are to have a slider, each with its range or None.

    Returns:
        The page: one file that asks nothing of the net, and prints as the static report.

    Raises:
        InvalidInputError: the motion is of a kind that has no live report, or a slider is not possible.
        NotConvergedError: its tables stay too coarse.
    """
    tables = live_tables(motion, asked)
    head = f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}"/>\n<style>{_STYLE}</style>\n</head>'
    folder = resources.files("hjsolve.reports.live")
    script = "".join(folder.joinpath(name).read_text(encoding="utf-8") for name in ("numbers.js", "live.js"))
    data = live_data(tables)
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    block = (
        f'{_controls(tables, data)}<script type="application/json" id="live-data">{text}</script>\n'
        f"<script>//<![CDATA[\n{script}//]]></script>\n"
    )
    return static.replace("</head>", head, 1).replace("<main>", f"<main>\n{block}", 1)


def _controls(tables: LiveTables, data: Json) -> str:
    sliders = "".join(_slider(k, s) for k, s in enumerate(data["sliders"]))
    named = [(str(k), escape(own["label"])) for k, own in enumerate(data["coordinates"])]
    boards = "".join(
        f'<figure><canvas id="live-{key}" role="img" tabindex="0" aria-label="{told}"></canvas></figure>'
        for key, told in (
            *(board for k, q in named for board in _of_coordinate(k, q)),
            ("orbit", "Orbit with the moving point; where it is in space, arrow keys turn it"),
            *((("torus", _TORUS),) if data["torus"] else ()),
            *((("map", f"{_MAP}; a click or the arrow keys choose them"),) if data["map"] else ()),
        )
    )
    speeds = "".join(f'<option value="{v}"{" selected" if v == 1 else ""}>{v} ×</option>' for v in (0.25, 0.5, 1, 2, 4))
    worst = ", ".join(f"{_power_of_ten(v)} in {_low(label(n))}" for n, v in tables.bounds.items())
    periods = "two periods" if len(named) == 1 else "two of the longest periods"
    turn = "Drag the orbit, or use the arrow keys on it, to turn it." if data["where"]["solid"] else ""
    return f"""<section id="live" class="live" aria-labelledby="live-h" hidden="hidden">
<h2 id="live-h">The motion, live</h2>
{sliders}
<div class="buttons"><button id="live-play" type="button" aria-pressed="false">Play</button>
<button id="live-start" type="button">From the start</button>
<label style="display:inline"><span>Speed</span> <select id="live-speed">{speeds}</select></label>
<button id="live-share" type="button">Copy link</button>
<span id="live-time"></span><span id="live-shared" role="status"></span></div>
<div class="boards">{boards}</div>
<table aria-live="polite"><caption>Values of this motion</caption><tbody id="live-numbers"></tbody></table>
<p class="note">{turn} {_of_map(data["map"])}</p>
<p class="note">The page interpolates tables that were computed beforehand. Over the first {periods} its error is at
most {worst} (twice the largest difference from <code>Solution.motion</code> at test points). Later the error grows in
proportion to the time. {_narrowed(tables)}</p>
<details><summary>Where the sliders end, and why</summary><div class="scroll"><table class="live-ends">
<thead><tr><th scope="col">Slider</th><th scope="col">From</th><th scope="col">Motions below it</th>
<th scope="col">To</th><th scope="col">Motions above it</th></tr></thead>
<tbody>{"".join(_end_row(s) for s in tables.sliders)}</tbody></table></div>
<p class="note">Counts are orbits of the ensemble in the smallest range that was refused, other sliders included.</p>
</details>
</section>
"""  # noqa: S608 - a select of HTML


def _power_of_ten(value: float) -> str:
    """Return a bound as HTML, 8.6×10⁻⁶ with a true superscript."""
    digits, power = f"{value:.1e}".split("e")
    return f"{digits}×10<sup>{int(power)}</sup>".replace("-", "−")


def _low(name: str) -> str:
    """Return a name as HTML: in italics, its index set low."""
    letter, _, index = escape(name).partition("_")
    return f"<i>{letter}</i>" + (f"<sub>{index}</sub>" if index else "")


def _of_coordinate(k: str, q: str) -> tuple[tuple[str, str], ...]:
    told = f"of {q} with the moving point"
    return (f"well-{k}", f"Effective potential {told}"), (f"phase-{k}", f"Phase plane {told}")


def _of_map(drawn: Json | None) -> str:
    """Return how the map is used and what its letters mean."""
    return escape(
        f"{_CHOOSE} On it, {'; '.join(drawn['kinds'])}." if drawn and drawn["kinds"] else _CHOOSE if drawn else ""
    )


_WHY = {
    SAME: "same kind", OTHER_KIND: "another kind", LONG_SERIES: "close to a separatrix: series too long",
    INACCURATE: "tables inaccurate", "forbidden": "no motion (forbidden)", "asymptotic": "on a separatrix (asymptotic)",
    "reaches_boundary": "an end of the domain is reached",
}  # fmt: skip


def _end_row(s: SliderRange) -> str:
    """Return a row of the table of ranges: each end, and what the neighbours beyond it are."""
    cells = []
    for end, why in zip((s.low, s.high), s.why, strict=True):
        words = (
            f"{_WHY.get(word, word.replace('_', ' '))}{f': {many}' if many > 1 else ''}" for word, many in why.items()
        )
        cells += [f"{end:.5g}".replace("-", "−"), escape("; ".join(words)) or "not searched farther"]
    return f'<tr><th scope="row">{_low(label(s.name))}</th>{"".join(f"<td>{c}</td>" for c in cells)}</tr>\n'


def _narrowed(tables: LiveTables) -> str:
    """Return, for each range that was narrowed, the one requested, the one covered, and why."""
    return " ".join(
        f"The requested range of {_low(label(s.name))} is {s.asked[0]:.6g} to {s.asked[1]:.6g}; the tables cover "
        f"{s.low:.6g} to {s.high:.6g}, because of the motions beyond it that are listed below."
        for s in tables.sliders
        if s.asked is not None and (s.low > s.asked[0] or s.high < s.asked[1])
    )


def _slider(k: int, s: Json) -> str:
    begin = round(1000 * (s["value"] - s["low"]) / (s["high"] - s["low"]))
    return (
        f'<label><span>{_low(s["label"])}</span><input id="live-slider-{k}" type="range" min="0" max="1000" '
        f'step="1" value="{begin}"/><output id="live-value-{k}"></output></label>\n'
    )
