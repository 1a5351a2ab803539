"""Accuracy against time: claims hold, counts repeat, failures are marked, and every subject leads to the same table."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.costs import Cost, Row
from hjsolve.errors import CatalogError, InvalidInputError, NotSeparableError

pytestmark = pytest.mark.rotating_file(10)

pytest.importorskip("scipy")
OWN = ("float64", "mpmath", "certified", "closed form", "integrate")
CASES = [
    ("harmonic-oscillator", "stiff"), ("pendulum", "rotation"), ("kepler-planar", "default"),
    ("kepler-planar", "hyperbolic"), ("projectile", "default"),
]  # fmt: skip


@pytest.fixture(scope="module", params=CASES, ids=["-".join(case) for case in CASES])
def table(request: pytest.FixtureRequest) -> Cost:
    name, motion = request.param
    want = ["turning_points", "actions", "frequencies", "periods", "trajectory"]
    scene: dict[str, Any] = {"system": name, "want": want, "times": {"start": 0, "stop": 8, "count": 9}}
    scene |= {} if motion == "default" else {"motion": motion}
    return hjsolve.cost(scene, digits=(20, 30), seconds=200, repeats=1, rivals=False)


@pytest.mark.rotating(2)
def test_true_errors_lie_within_the_claims(table: Cost) -> None:
    own = [row for row in table.rows if row.method in OWN and row.answered]
    assert {"float64", "mpmath"} <= {row.method for row in own}
    for row in own:
        assert row.held, row
        assert row.error is not None
        assert row.claimed is not None
        assert row.error <= row.claimed, row
        assert row.status in ("ok", "extrapolated")


@pytest.mark.nightly_cases("kepler-planar-hyperbolic")
def test_each_method_reaches_the_digits_asked(table: Cost) -> None:
    for row in table.rows:
        if row.method in OWN and row.answered:
            assert row.error is not None
            assert row.digits is not None
            assert row.error <= 10.0 ** (2 - row.digits), row


def test_the_reference_is_another_backend(table: Cost) -> None:
    assert "Taylor series" in table.reference
    assert table.floor <= 1e-35


def test_more_digits_take_more_evaluations(table: Cost) -> None:
    counts = [row.count for row in table.of("mpmath") if row.count]
    assert counts == sorted(counts)


SCENE = {
    "system": "kepler-planar", "want": ["periods", "trajectory"], "times": {"start": 0, "stop": 20, "count": 15},
}  # fmt: skip


@pytest.fixture(scope="module")
def scene_table() -> Cost:
    return hjsolve.cost(SCENE, digits=(20,), seconds=200, repeats=2)


def test_an_integrator_gains_digits_with_its_tolerance(scene_table: Cost) -> None:
    rows = scene_table.of("DOP853")
    assert len(rows) >= 4
    assert all(row.claimed is None and row.held is None and row.covers == "states" for row in rows)
    assert rows[0].error > 1e-5  # type: ignore[operator]
    assert rows[-1].error < 1e-9  # type: ignore[operator]


def test_repeats_are_counted_and_timed(scene_table: Cost) -> None:
    assert all(row.repeats >= 1 and row.seconds and row.seconds > 0 for row in scene_table.rows if row.answered)


def test_the_text_has_a_line_for_every_row(scene_table: Cost) -> None:
    lines = str(scene_table).splitlines()
    assert sum(line.startswith(scene_table.methods) for line in lines) == len(scene_table.rows)
    assert "Taylor series" in str(scene_table)


@pytest.mark.nightly
def test_a_scene_its_table_and_a_motion_are_the_same_subject(scene_table: Cost) -> None:
    scene = hjsolve.Scene.load(SCENE)
    again = hjsolve.cost(scene, digits=(20,), seconds=200, repeats=1)
    assert [(r.method, r.error) for r in again.rows] == [(r.method, r.error) for r in scene_table.rows]
    assert [r.count for r in again.rows] == [r.count for r in scene_table.rows]  # counts repeat, times do not
    assert all(r.count for r in again.rows if r.answered)
    motion = hjsolve.solve(scene.system).motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    table = hjsolve.cost(motion, digits=(20,), seconds=200, repeats=1, rivals=False)
    assert "closed form" in table.methods  # the catalog's entry was recognised
    assert all(row.held for row in table.rows)


def test_a_catalog_id_alone_brings_its_own_question() -> None:
    table = hjsolve.cost("harmonic-oscillator", digits=(20,), seconds=200, repeats=1, rivals=False)
    assert table.methods == ("float64", "mpmath", "certified", "closed form")
    assert table.times == 101
    assert table.checked == 4
    assert {"actions", "periods", "trajectory"} <= set(table.want)
    assert all(row.held for row in table.rows)


def test_a_missing_extra_is_marked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "heyoka", None)
    table = hjsolve.cost(SCENE, digits=(20,), seconds=200, repeats=1)
    (row,) = table.of("heyoka")
    assert row.status == "missing"
    assert "pip install heyoka" in row.note
    assert not row.answered


def test_events_are_refused_by_what_cannot_take_them() -> None:
    event = {"kind": "impulse", "at": {"t": "5"}, "momentum": {"theta": "0.1"}}
    table = hjsolve.cost({**SCENE, "events": [event]}, digits=(20,), seconds=200, repeats=1)
    (proof,) = table.of("certified")
    assert proof.status == "not applicable"
    assert "event" in proof.note
    assert all(row.held for row in (*table.of("float64"), *table.of("mpmath")))
    assert table.of("DOP853")[-1].error < 1e-9  # type: ignore[operator]


@pytest.mark.nightly
def test_what_does_not_fit_is_marked_and_not_dropped() -> None:
    scene = {**SCENE, "system": "kepler-spherical", "times": {"start": 0, "stop": 20, "count": 2001}}
    table = hjsolve.cost(scene, digits=(20, 100), seconds=3, repeats=1)
    assert [row.digits for row in table.of("mpmath")] == [20, 100]
    late = [row for row in table.of("mpmath") if row.status != "ok"]
    assert late
    assert all(row.status in ("extrapolated", "too slow") and row.note for row in late)


@pytest.mark.nightly
def test_an_integrator_that_stops_at_once_is_marked() -> None:
    """DOP853's first step is already too small here, and it has no states to show."""
    table = hjsolve.cost("constant-proper-acceleration", digits=(20,), seconds=200, repeats=1)
    assert all(row.held for row in table.of("float64"))
    stopped = [row for row in table.of("DOP853") if not row.answered]
    assert stopped
    assert all(row.note for row in stopped)


def test_an_integrated_scene_is_measured_too() -> None:
    scene = {
        "system": "pendulum", "effects": ["drag"], "method": "integrate", "want": ["trajectory"],
        "initial": {"q": {"theta": "2"}, "velocity": {"theta": "0"}}, "times": [1, 2],
    }  # fmt: skip
    table = hjsolve.cost(scene, seconds=200, repeats=1)
    assert all(row.held for row in table.of("integrate"))
    assert table.of("DOP853")[-1].error < 1e-11  # type: ignore[operator]


def test_rows_are_chosen_by_accuracy_and_by_what_they_cover(scene_table: Cost) -> None:
    best = scene_table.cheapest(12)
    assert best is not None
    assert best.method in ("float64", "mpmath")
    rest = [r for r in scene_table.rows if r.covers == "all" and r.answered and r.error <= 1e-12]  # type: ignore[operator]
    assert best.seconds == min(r.seconds or math.inf for r in rest)
    assert scene_table.cheapest(60) is None
    approximate = Row("DOP853", 4, error=1e-4, seconds=1e-9, covers="states")
    more = replace(scene_table, rows=(*scene_table.rows, approximate))
    assert more.cheapest(4) == scene_table.cheapest(4)
    assert more.cheapest(4, "states") is approximate


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"subject": 3}, "a Scene, a Motion, a System, a catalog id"), ({"subject": "no-such-system"}, "no catalog entry"),
        ({"subject": "pendulum", "digits": (7,)}, "digits"), ({"subject": "pendulum", "seconds": 0}, "> 0 is needed"),
        ({"subject": "pendulum", "repeats": 0}, "> 0 is needed"), ({"subject": "pendulum", "motion": "upwards"}, "upwards"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_line(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises((InvalidInputError, CatalogError), match=words):
        hjsolve.cost(**arguments)


def test_what_does_not_separate_has_no_cost() -> None:
    with pytest.raises(NotSeparableError):
        hjsolve.cost("henon-heiles")


@pytest.mark.nightly
def test_the_command_prints_the_table_and_writes_figure_and_rows(tmp_path: Path, capsys: Any) -> None:
    figure, rows = tmp_path / "cost.svg", tmp_path / "cost.json"
    arguments = ["cost", "harmonic-oscillator", "--digits", "20", "--seconds", "8", "--no-rivals"]
    assert main([*arguments, "-o", str(rows)]) == 0
    printed = capsys.readouterr().out
    assert "certified" in printed
    assert "claimed error" in printed
    table = json.loads(rows.read_text(encoding="utf-8"))
    assert {row["method"] for row in table["rows"]} == {"float64", "mpmath", "certified", "closed form"}
    assert all(row["error"] <= row["claimed"] for row in table["rows"])
    assert main([*arguments, "-o", str(figure)]) == 0
    assert figure.read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no-such-system"], "no catalog entry"), (["pendulum", "--digits", "many"], "20,30,50"),
        (["pendulum", "--digits", "5"], "whole numbers from 16"), (["pendulum", "--seconds", "-1"], "> 0 is needed"),
        (["pendulum", "-o", "cost.docx"], "suffix"),
    ],
)  # fmt: skip
def test_the_command_refuses_in_one_line(arguments: list[str], words: str, capsys: Any) -> None:
    assert main(["cost", *arguments]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert len(message.strip().splitlines()) == 1


@pytest.mark.nightly
def test_a_report_has_the_section_where_it_is_asked_for(tmp_path: Path) -> None:
    with_it, without, scene = (tmp_path / name for name in ("with.html", "without.html", "scene.md"))
    hjsolve.report("harmonic-oscillator", with_it, cost=2)
    page = with_it.read_text(encoding="utf-8")
    assert 'id="cost"' in page
    assert "float64" in page
    assert page.index('id="cost"') < page.index('id="how"')
    assert main(["report", "harmonic-oscillator", "-o", str(without), "--no-cost"]) == 0
    assert 'id="cost"' not in without.read_text(encoding="utf-8")
    assert main(["report", "harmonic-oscillator", "-o", str(without)]) == 0
    assert 'id="cost"' not in without.read_text(encoding="utf-8")
    hjsolve.report(hjsolve.Scene.load({"system": "pendulum", "want": ["periods"]}), scene, cost=2)
    assert "What accuracy costs" in scene.read_text(encoding="utf-8")


@pytest.mark.nightly
def test_a_report_of_what_has_no_motion_has_no_such_section(tmp_path: Path) -> None:
    path = tmp_path / "refused.txt"
    hjsolve.report("henon-heiles", path)
    assert "What accuracy costs" not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("wish", [0, -1, 11])
def test_the_section_takes_at_most_ten_seconds(wish: float, tmp_path: Path) -> None:
    with pytest.raises(InvalidInputError, match="seconds up to 10"):
        hjsolve.report("pendulum", tmp_path / "p.html", cost=wish)
