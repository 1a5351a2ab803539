"""The tables of a live report give what ``Solution.motion`` gives, within the bound they state."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.reports.live.tables import evaluated, live_tables, state_from

MOTION = {
    "kepler-planar": (["0.7", "-0.2"], 1.37), "spherical-pendulum": (["1.5", "-1.2"], 0.6), "pendulum": (["0.37"], 0.9),
}  # fmt: skip


@pytest.mark.parametrize("name", MOTION)
def test_tables_are_within_their_bound_of_motions_of_the_engine(name: str) -> None:
    solution, entry = hjsolve.solve(name), hjsolve.catalog.describe(name)
    tables = live_tables(solution.motion(**entry.motions["default"].arguments))
    values, t = MOTION[name]
    q = tables.coordinate
    series = evaluated(tables.columns, tables.sliders, [float(v) for v in values])
    constants = {**{n: 0 for n in solution.constants}, **dict(zip((s.name for s in tables.sliders), values))}
    middle = (series["a"] + series["b"]) / 2
    other = solution.motion(
        q={c.name: 0 for c in solution.system.coordinates} | {q: middle}, constants=constants, signs={q: 1}
    )
    low, high = (float(end.value) for end in other.turning_points[q])
    assert abs(series["a"] - low) <= tables.bounds[q]
    assert abs(series["b"] - high) <= tables.bounds[q]
    begin = float(other.time_at(q, low + 1e-9 * (high - low), passage=-1).value)  # next to the lower turning point
    begin += float(other.periods[q].value) if begin + t < 0 else 0.0
    at_start = state_from(series, tables.angles, q, np.array([0.0, t]))
    state = other.at([begin, begin + t])
    assert abs(at_start[q][1] - state.q[q][1]) <= tables.bounds[q] + 1e-4 * (high - low)
    T = 2 * np.pi * series["t.0"]
    assert abs(T - float(other.periods[q].value)) <= 1e-4 * T
    for angle in tables.angles:
        gain = 2 * np.pi * series[f"{angle}.0"]
        exact = 2 * np.pi * float(other.frequencies[angle].value) / float(other.frequencies[q].value)
        assert abs(gain - exact) <= tables.bounds[angle]


def test_a_live_page_is_one_small_file_that_asks_for_nothing(tmp_path) -> None:
    page = hjsolve.report("kepler-planar", tmp_path / "live.html", live=True)
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 1_500_000
    assert "default-src 'none'" in text
    assert not re.findall(r"""(?:src|href)=["'](?!#)""", text)
    data = json.loads(re.search(r'id="live-data">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert [s["name"] for s in data["sliders"]] == ["p_theta", "E"]
    static = hjsolve.report("kepler-planar", tmp_path / "static.html").read_text(encoding="utf-8")
    assert 'id="live"' not in static
    assert text.count("<h2 ") == static.count("<h2 ") + 1


def test_the_command_writes_it(tmp_path) -> None:
    assert main(["report", "pendulum", "--live", "-o", str(tmp_path / "live.html")]) == 0
    assert "live-data" in (tmp_path / "live.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("subject", "path"), [
    ("kepler-spherical", "a.html"), ("projectile", "a.html"), ("henon-heiles", "a.html"), ("kepler-planar", "a.md"),
    ("skate", "a.html"),
])  # fmt: skip
def test_what_cannot_be_live_is_refused_and_nothing_written(subject: str, path: str, tmp_path) -> None:
    with pytest.raises(hjsolve.InvalidInputError):
        hjsolve.report(subject, tmp_path / path, live=True)
    assert not (tmp_path / path).exists()
