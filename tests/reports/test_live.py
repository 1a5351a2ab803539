"""The tables of a live report give what ``Solution.motion`` gives, within the bound they state."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.reports.live.tables import evaluated_as_the_page_does, live_tables, state_from

MOTION = {
    "kepler-planar": (["0.7", "-0.2"], 1.37), "spherical-pendulum": (["1.5", "-1.2"], 0.6), "pendulum": (["0.37"], 0.9),
}  # fmt: skip


@pytest.mark.parametrize("name", MOTION)
def test_tables_are_within_their_bound_of_motions_of_the_engine(name: str) -> None:
    solution, entry = hjsolve.solve(name), hjsolve.catalog.describe(name)
    tables = live_tables(solution.motion(**entry.motions["default"].arguments))
    values, t = MOTION[name]
    q = tables.coordinate
    series = evaluated_as_the_page_does(tables.columns, tables.sliders, [float(v) for v in values])
    constants = dict.fromkeys(solution.constants, 0) | dict(zip((s.name for s in tables.sliders), values))
    middle = (series["a"] + series["b"]) / 2
    other = solution.motion(
        q={c.name: 0 for c in solution.system.coordinates} | {q: middle}, constants=constants, signs={q: 1}
    )
    low, high = (float(end.value) for end in other.turning_points[q])
    assert abs(series["a"] - low) <= tables.bounds[q]
    assert abs(series["b"] - high) <= tables.bounds[q]
    begin = passage_of(middle, series, tables)
    shown = state_from(series, tables.angles, q, begin + np.array([0.0, t, 2.3 * t]))
    state = other.at([0.0, t, 2.3 * t])
    for name, values in ((q, state.q[q]), (f"p_{q}", state.p[q])):  # the page and the place it is counted from
        assert np.abs(shown[name] - values).max() <= 2 * tables.bounds[name]
    for name in tables.angles:
        assert np.abs(shown[name] - shown[name][0] - state.unwrapped(name)).max() <= 2 * tables.bounds[name]


def passage_of(place: float, series, tables) -> float:
    """When the page's motion first comes to a place, by bisection."""
    low, high = 0.0, np.pi * series["t.0"]
    for _ in range(80):
        middle = (low + high) / 2
        before = state_from(series, tables.angles, tables.coordinate, np.array([middle]))[tables.coordinate][0] < place
        low, high = (middle, high) if before else (low, middle)
    return low


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
