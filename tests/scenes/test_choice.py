"""The method a scene is run with: the cheapest for the digits asked, the best for the time allowed, and it says why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import hjsolve
from hjsolve.cli import main
from hjsolve.scenes import Scene, choice
from hjsolve.scenes.run import run

PERIODS: dict[str, Any] = {"system": "pendulum", "want": ["periods", "actions"]}
STATES: dict[str, Any] = {
    "system": "kepler-planar", "want": ["periods", "trajectory"], "times": {"start": 0, "stop": 20, "count": 5},
}  # fmt: skip


def chosen(table: dict[str, Any], **accuracy: Any) -> Any:
    return Scene.load({**table, **({"accuracy": accuracy} if accuracy else {})}).run()


@pytest.mark.parametrize("accuracy", [{}, {"digits": 6}, {"digits": 15}])
def test_double_precision_for_what_it_reaches(accuracy: dict[str, Any]) -> None:
    done = chosen(PERIODS, **accuracy)
    assert done.choice.method == "float64"
    assert isinstance(done.quantity("periods")["theta"].value, float)
    assert "double precision" in done.choice.why


@pytest.mark.parametrize("table", [PERIODS, STATES])
def test_multiple_precision_above(table: dict[str, Any]) -> None:
    done = chosen(table, digits=40)
    assert (done.choice.method, done.choice.digits) == ("mpmath", 40)
    estimate = next(iter(done.quantity("periods").values()))
    assert estimate.error <= abs(estimate.value) * 10.0**-40 * (1 + 1e-9)
    assert done.choice.tried[-1][:2] == ("mpmath", 40)


def test_states_come_from_mpmath_however_many_digits() -> None:
    assert chosen(STATES, digits=70).choice.method == "mpmath"


@pytest.mark.certified
@pytest.mark.parametrize("cheap", ["mpmath", "certified"])
def test_far_above_the_one_that_took_less_is_chosen(monkeypatch: pytest.MonkeyPatch, cheap: str) -> None:
    """Time is made to pass by hand, so that the choice does not depend on the machine."""
    clock = [0.0]

    def slow(scene: Scene, solution: Any) -> Any:
        method = "certified" if scene.certified else "mpmath"
        clock[0] += 1.0 if method == cheap else 60.0
        return run(scene, solution)

    monkeypatch.setattr(choice, "run", slow)
    monkeypatch.setattr(choice.time, "perf_counter", lambda: clock[0])
    done = chosen(PERIODS, digits=80)
    assert done.choice.method == cheap
    assert "60" not in done.choice.why or cheap in done.choice.why
    assert done.quantity("periods")["theta"].certified == (cheap == "certified")
    assert [t[:2] for t in done.choice.tried] == [("mpmath", 20), ("certified", 20), (cheap, 80)]


@pytest.mark.certified
@pytest.mark.parametrize("name", ["pendulum", "kepler-planar"])
def test_the_choice_is_what_the_table_of_costs_says(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """The clock goes by the table, so that only the judgement from 20 digits is tested, not the machine's mood."""
    scene = {**PERIODS, "system": name}
    table = hjsolve.cost(scene, digits=(20, 120), seconds=60, repeats=2, rivals=False)
    seconds = {(row.method, row.digits): row.seconds or 0.0 for row in table.rows}
    clock = [0.0]

    def by_the_table(scene: Scene, solution: Any) -> Any:
        clock[0] += seconds["certified" if scene.certified else "mpmath", scene.digits]
        return run(scene, solution)

    monkeypatch.setattr(choice, "run", by_the_table)
    monkeypatch.setattr(choice.time, "perf_counter", lambda: clock[0])
    method = chosen(scene, digits=120).choice.method
    assert seconds[method, 120] <= 2.5 * min(seconds["mpmath", 120], seconds["certified", 120])


def test_without_the_extra_mpmath_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hjsolve.numeric.ball.flint", None)
    done = chosen(PERIODS, digits=80)
    assert done.choice.method == "mpmath"
    assert "pip install" in done.choice.why


def test_more_seconds_give_more_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes by hand: a run takes a thousandth of a second a digit and method, whatever the machine does."""
    clock = [0.0]

    def timed(scene: Scene, solution: Any) -> Any:
        clock[0] += 0.001 * scene.digits * (3 if scene.certified else 1)
        return run(scene, solution)

    monkeypatch.setattr(choice, "run", timed)
    monkeypatch.setattr(choice.time, "perf_counter", lambda: clock[0])
    reached = []
    for seconds in ("0.001", "0.1", "0.3", "1"):
        clock[0] = 0.0
        done = chosen(PERIODS, seconds=seconds)
        reached.append(done.choice.digits)
        assert done.choice.tried[-1][:2] == (done.choice.method, done.choice.digits)
        assert seconds == "0.001" or clock[0] <= float(seconds)
        assert f"{float(seconds):.3g} s" in done.choice.why
    assert reached[0] == 15
    assert reached == sorted(set(reached))


def test_states_that_would_take_too_long_are_not_tried() -> None:
    done = chosen({**STATES, "times": {"start": 0, "stop": 20, "count": 3001}}, seconds=3)
    assert [tried[:2] for tried in done.choice.tried] == [("float64", 15)]
    assert done.choice.digits == 15  # 3 000 states with 20 digits would take far longer, and it is known beforehand
    assert "should take" in done.choice.why


def test_an_integrated_scene_gets_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("scipy")
    scene = {"system": "pendulum", "effects": ["drag"], "method": "integrate", "want": ["trajectory"], "times": [1]}
    assert chosen(scene, seconds=30).choice.digits >= 8
    assert chosen(scene, digits=6).choice.method == "integrate"


def test_the_report_says_what_was_chosen_and_why(tmp_path: Path) -> None:
    path = tmp_path / "scene.txt"
    hjsolve.report(Scene.load({**PERIODS, "accuracy": {"digits": 20}}), path, cost=False)
    text = " ".join(path.read_text(encoding="utf-8").split())
    assert "Chosen: multiple precision (mpmath), 20 digits, because up to 60 digits ball arithmetic does not pay" in text


def test_a_malformed_accuracy_is_one_line_and_status_2(tmp_path: Path, capsys: Any) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text('system = "pendulum"\nwant = ["periods"]\naccuracy = {digits = 20, seconds = 2}\n')
    assert main(["report", str(scene), "-o", str(tmp_path / "out.html")]) == 2
    message = capsys.readouterr().err.strip()
    assert "accuracy: give digits or seconds, one of the two" in message
    assert len(message.splitlines()) == 1
