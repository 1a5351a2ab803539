"""The tables of a live report give what ``Solution.motion`` gives, within the bound they state."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import hjsolve
from hjsolve import System
from hjsolve.command_line.main import main
from hjsolve.motion.motion import Motion
from hjsolve.reports.live.neighbours import neighbours_of
from hjsolve.reports.live.tables import LiveTables, live_tables

TYPED = {
    "two rotations": (
        System(
            coordinates={"x": "angle", "y": "angle"}, kinetic="(dot(x)**2 + 2*dot(y)**2)/2",
            potential="cos(x) + sin(y)/2 + cos(2*y)/5 + sin(x)/7",
        ),
        {"q": {"x": 1, "y": "0.3"}, "velocity": {"x": "2.2", "y": "-1.5"}},
    ),
    "rotation and libration": (
        System(
            coordinates={"x": "angle", "y": "line"}, kinetic="(dot(x)**2 + dot(y)**2)/2",
            potential="sin(x)/3 + y**2 + y**3/5",
        ),
        {"q": {"x": 1, "y": "0.3"}, "velocity": {"x": "-2.2", "y": "0.4"}},
    ),
    "in cylinder coordinates": (
        System(
            coordinates={"r": "0 < r", "phi": "angle", "z": "line"},
            kinetic="(dot(r)**2 + r**2*dot(phi)**2 + dot(z)**2)/2", potential="log(r) + z**2 + z**4/3 + r**2/5",
        ),
        {"q": {"r": 1, "phi": 0, "z": "0.4"}, "velocity": {"r": "0.3", "phi": "1.1", "z": "0.2"}},
    ),
    "coupled oscillators": (
        System(
            coordinates={"x": "line", "y": "line"}, kinetic="(dot(x)**2 + dot(y)**2)/2",
            potential="(3*x**2 + 2*y**2 + 2*x*y)/2",
        ),
        {"q": {"x": 1, "y": "0.3"}, "velocity": {"x": 0, "y": "0.5"}},
    ),
}  # fmt: skip


def motion_of(name: str) -> Motion:
    if name in TYPED:
        system, start = TYPED[name]
        return hjsolve.solve(system, coordinates="find").motion(**start)
    return hjsolve.solve(name).motion(**hjsolve.catalog.describe(name).motions["default"].arguments)


@cache
def tables_of(name: str, asked: tuple[tuple[str, tuple[float, float] | None], ...] = ()) -> LiveTables:
    return live_tables(motion_of(name), dict(asked))


def away_from_turns(page, span: float) -> float:
    """The time up to ``span`` at which no momentum is small."""
    times = np.linspace(0, span, 50)
    momenta = [np.abs(v) / np.abs(v).max() for n, v in page.state(times).items() if n.startswith("p_")]
    return float(times[np.argmax(np.min(momenta, axis=0))])


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "asked"), [
    *((name, {}) for name in TYPED), ("kepler-planar", {}), ("spherical-pendulum", {}),
    ("pendulum", {"g": (5.0, 15.0), "l": None}), ("kepler-planar", {"k": None}),
])  # fmt: skip
def test_tables_are_within_their_bound_of_motions_of_the_engine(name: str, asked) -> None:
    """At random settings of the sliders; the engine starts where the page does, which may be off itself."""
    base = motion_of(name).as_solved
    tables = tables_of(name, tuple(asked.items()))
    assert set(asked) <= {s.name for s in tables.sliders}
    solution, rng = replace(base.solution, chart=None), np.random.default_rng(77)
    parameters = {p.name: base.initial.values[p.symbol] for p in solution.system.parameters}
    for _ in range(2):
        values = {s.name: float(rng.uniform(s.low, s.high)) for s in tables.sliders}
        page = tables.motion(list(values.values()))
        span = 4 * np.pi / np.abs(page.rates).min()
        times = np.linspace(0, 0.9 * span, 23)
        shown = page.state(away_from_turns(page, 0.1 * span) + times)
        other = solution.motion(
            q={c.name: shown[c.name][0] if c.name in solution.coordinates else 0 for c in solution.system.coordinates},
            constants={n: values.get(n, base.initial.constants[n]) for n in solution.constants},
            signs={n: int(np.sign(shown[f"p_{n}"][0])) for n in solution.coordinates},
            parameters={n: values.get(n, v) for n, v in parameters.items()},
        )
        assert {n: other.kinds[n] for n in solution.coordinates} == {n: base.kinds[n] for n in solution.coordinates}
        state = other.at(times)
        for n, column in shown.items():
            if n.removeprefix("p_") in solution.coordinates and n.startswith("p_"):
                assert np.abs(column - np.asarray(state.p[n[2:]], float)).max() <= 2 * tables.bounds[n]
            else:
                gained = np.asarray(state.unwrapped(n), float)
                assert np.abs(column - column[0] - (gained - gained[0])).max() <= 2 * tables.bounds[n]
        for n, rate in zip(solution.coordinates, page.rates, strict=True):
            turn = 2 * np.pi / abs(rate)
            assert abs(abs(other.periods[n].value) - turn) <= 1e-3 * turn


@pytest.mark.nightly_cases("spherical-pendulum", "two-centres-plane")
@pytest.mark.parametrize("name", ["two-centres-plane", "spherical-pendulum", "double-well"])
def test_no_box_reaches_across_a_separatrix(name: str) -> None:
    """Random motions in the whole box, kinds by the exact search that has nothing to do with these tables."""
    base, rng = motion_of(name), np.random.default_rng(5)
    tables = tables_of(name)
    names, solution = [s.name for s in tables.sliders], base.solution
    for _ in range(9):
        values = [float(rng.choice([s.low, s.high, rng.uniform(s.low, s.high)])) for s in tables.sliders]
        start = {n: float(v[0]) for n, v in tables.motion(values).state(np.array([0.123])).items()}
        other = solution.motion(
            q={c.name: start[c.name] if c.name in solution.coordinates else 0 for c in solution.system.coordinates},
            constants=dict(base.initial.constants) | dict(zip(names, values)),
            signs={n: int(np.sign(start[f"p_{n}"])) for n in solution.coordinates}, want=["turning_points"],
        )  # fmt: skip
        assert dict(other.kinds) == dict(base.kinds)


def test_a_range_that_reaches_too_far_ends_before_the_separatrix() -> None:
    """A pendulum at rest at 90° in the middle: with E asked up to 3 it would rotate beyond E = m g l."""
    base = motion_of("pendulum")
    values = {s.name: v for s, v in base.initial.values.items()}
    energy = float(base.constants["E"].value)
    top = float(values["m"] * values["g"] * values["l"])
    (slider,) = live_tables(base, {"E": (energy - 0.5 * top, 5 * top)}).sliders
    assert energy < slider.high < top


@pytest.mark.parametrize(("name", "values", "word"), [
    ("pendulum", {"E": 0.3}, "ok"), ("pendulum", {"E": 40}, "another kind"), ("pendulum", {"E": -40}, "forbidden"),
    ("kepler-planar", {"E": 0.1}, "unbounded"), ("double-well", {"E": 0.05}, "another kind"),
])  # fmt: skip
def test_each_neighbour_says_what_it_is(name: str, values, word: str) -> None:
    """Statuses of the ensemble, and kinds: a pendulum that turns over, two wells that become one."""
    motion = motion_of(name).as_solved
    subject = neighbours_of(motion, list(values))
    assert subject.series(np.array([list(values.values())], dtype=float))[1].tolist() == [word]


def test_turning_points_are_those_of_the_ensemble_in_the_well_of_the_motion() -> None:
    """Nearly circular Kepler orbits: the well at l = 1.5 does not touch that at l = 1."""
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, p={"r": "0.01", "theta": 1})
    subject = neighbours_of(motion.as_solved, ["p_theta", "E"])
    settings = np.array([[1.5, -0.2222], [0.7, -1.0]])
    columns, words = subject.series(settings)
    assert words.tolist() == ["ok", "ok"]
    for k, (l, E) in enumerate(settings):
        e = np.sqrt(1 + 2 * E * l * l)
        for end, sign in (("a", 1), ("b", -1)):
            np.testing.assert_allclose(columns[0, end][k, 0], l * l / (1 + sign * e), rtol=1e-9)


@pytest.mark.parametrize(("name", "asked", "words"), [
    ("pendulum", {"E": (-40.0, 40.0)}, ("forbidden", "another kind")),
    ("kepler-planar", {"E": (-5.0, 5.0)}, ("forbidden", None)),
])  # fmt: skip
def test_a_slider_says_why_it_ends(name: str, asked, words) -> None:
    (slider,) = (s for s in live_tables(motion_of(name), asked).sliders if s.name == "E")
    for why, word in zip(slider.why, words, strict=True):
        assert why
        assert word is None or word in why


@pytest.mark.parametrize(("asked", "told"), [
    ({"mass": None}, "no constant or parameter mass"), ({"g": (1.0, 1.0)}, "has to contain"),
    ({"g": (100.0, 200.0)}, "has to contain"),
])  # fmt: skip
def test_sliders_that_cannot_be_had_are_refused(asked, told: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=told):
        live_tables(motion_of("pendulum"), asked)


@pytest.mark.nightly
def test_a_live_page_is_one_small_file_that_asks_for_nothing(tmp_path) -> None:
    page = hjsolve.report("kepler-planar", tmp_path / "live.html", live=True)
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 1_500_000
    assert "default-src 'none'" in text
    assert not re.findall(r"""(?:src|href)=["'](?!#)""", text)
    data = json.loads(re.search(r'id="live-data">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert [s["name"] for s in data["sliders"]] == ["p_theta", "E"]
    assert len(data["coordinates"]) == 1
    static = hjsolve.report("kepler-planar", tmp_path / "static.html").read_text(encoding="utf-8")
    assert 'id="live"' not in static
    assert text.count("<h2 ") == static.count("<h2 ") + 1


@pytest.mark.nightly
def test_the_command_writes_it_with_the_sliders_asked_for(tmp_path) -> None:
    told = ["report", "pendulum", "--brief", "-o", str(tmp_path / "live.html")]
    assert main([*told, "--live", "--slider", "g=5:15", "--slider", "l"]) == 0
    text = (tmp_path / "live.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="live-data">(.*?)</script>', text, re.DOTALL)[1])  # type: ignore[index]
    assert {s["name"] for s in data["sliders"]} == {"E", "g", "l"}


@pytest.mark.parametrize("told", [["--slider", "g"], ["--live", "--slider", "g=5"], ["--live", "--slider", "g=a:b"]])
def test_sliders_that_cannot_be_read_are_refused(told: list[str], tmp_path, capsys) -> None:
    assert main(["report", "pendulum", "-o", str(tmp_path / "live.html"), *told]) == 2
    assert "--slider" in capsys.readouterr().err


@pytest.mark.nightly_cases("henon-heiles-a.html")
@pytest.mark.parametrize(("subject", "path"), [
    ("particle-on-circle", "a.html"), ("projectile", "a.html"), ("henon-heiles", "a.html"), ("kepler-planar", "a.md"),
    ("skate", "a.html"),
])  # fmt: skip
def test_what_cannot_be_live_is_refused_and_nothing_written(subject: str, path: str, tmp_path) -> None:
    with pytest.raises(hjsolve.InvalidInputError):
        hjsolve.report(subject, tmp_path / path, live=True)
    assert not (tmp_path / path).exists()
