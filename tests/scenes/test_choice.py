"""The method a scene is run with: the cheapest for the digits asked, the best for the time allowed, and it says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.scenes import Scene, choice
from hjsolve.scenes.run import run_by_quadratures

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


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[Scene], float]], list[float]]:
    """Time that goes by hand, whatever the machine does: give the seconds a scene takes, get the clock."""

    def goes_by(seconds: Callable[[Scene], float]) -> list[float]:
        now = [0.0]

        def timed(scene: Scene, solution: Any = None) -> Any:
            done = run_by_quadratures(scene, solution)
            now[0] += seconds(scene)
            return done

        monkeypatch.setattr(choice, "run_by_quadratures", timed)
        monkeypatch.setattr(choice.time, "perf_counter", lambda: now[0])
        return now

    return goes_by


@pytest.mark.certified
@pytest.mark.parametrize("cheap", ["mpmath", "certified"])
def test_far_above_the_one_that_took_less_is_chosen(clock: Any, cheap: str) -> None:
    clock(lambda scene: 1.0 if scene.certified == (cheap == "certified") else 60.0)
    done = chosen(PERIODS, digits=80)
    assert done.choice.method == cheap
    assert "60" not in done.choice.why or cheap in done.choice.why
    assert done.quantity("periods")["theta"].certified == (cheap == "certified")
    assert [t[:2] for t in done.choice.tried] == [("mpmath", 20), ("certified", 20), (cheap, 80)]


@pytest.mark.certified
@pytest.mark.nightly
@pytest.mark.parametrize("name", ["pendulum", "kepler-planar"])
def test_the_choice_is_what_the_table_of_costs_says(clock: Any, name: str) -> None:
    """The clock goes by the table, so that only the judgement from 20 digits is tested, not the machine's mood."""
    scene = {**PERIODS, "system": name}
    table = hjsolve.cost(scene, digits=(20, 120), seconds=200, repeats=2, rivals=False)
    seconds = {(row.method, row.digits): row.seconds or 0.0 for row in table.rows}
    clock(lambda scene: seconds["certified" if scene.certified else "mpmath", scene.digits])
    method = chosen(scene, digits=120).choice.method
    assert seconds[method, 120] <= 2.5 * min(seconds["mpmath", 120], seconds["certified", 120])


def test_without_the_extra_mpmath_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hjsolve.arithmetic.ball.flint", None)
    done = chosen(PERIODS, digits=80)
    assert done.choice.method == "mpmath"
    assert "pip install" in done.choice.why


@pytest.mark.certified
def test_more_seconds_give_more_digits(clock: Any) -> None:
    reached = []
    for seconds in ("0.001", "0.1", "0.3", "1"):
        now = clock(lambda scene: 0.001 * scene.digits * (3 if scene.certified else 1))
        done = chosen(PERIODS, seconds=seconds)
        reached.append(done.choice.digits)
        assert done.choice.tried[-1][:2] == (done.choice.method, done.choice.digits)
        assert seconds == "0.001" or now[0] <= float(seconds)
        assert f"{float(seconds):.3g} s" in done.choice.why
    assert reached[0] == 15
    assert reached == sorted(set(reached))


def test_states_that_would_take_too_long_are_not_tried(clock: Any) -> None:
    """A state of 20 digits takes 10 ms here: 3 001 of them take half a minute, which is known from five."""
    now = clock(lambda scene: 0.1 if scene.digits <= 15 else 0.1 + 0.01 * len(scene.times.exact()))
    done = chosen({**STATES, "times": {"start": 0, "stop": 20, "count": 3001}}, seconds=3)
    assert [tried[:2] for tried in done.choice.tried] == [("float64", 15)]
    assert done.choice.digits == 15
    assert "should take" in done.choice.why
    assert now[0] < 1


def test_an_integrated_scene_gets_what_fits(clock: Any) -> None:
    pytest.importorskip("scipy")
    scene = {"system": "pendulum", "effects": ["drag"], "method": "integrate", "want": ["trajectory"], "times": [1]}
    clock(lambda scene: 0.01 * scene.digits)
    assert [chosen(scene, seconds=seconds).choice.digits for seconds in (0.06, 30)] == [4, 12]
    assert chosen(scene, digits=6).choice.method == "integrate"


def test_the_report_says_what_was_chosen_and_why(tmp_path: Path) -> None:
    path = tmp_path / "scene.txt"
    hjsolve.report(Scene.load({**PERIODS, "accuracy": {"digits": 20}}), path, cost=False)
    text = " ".join(path.read_text(encoding="utf-8").split())
    assert (
        "Chosen: multiple precision (mpmath), 20 digits, because up to 60 digits ball arithmetic does not pay" in text
    )


def test_a_malformed_accuracy_is_one_line_and_status_2(tmp_path: Path, capsys: Any) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text('system = "pendulum"\nwant = ["periods"]\naccuracy = {digits = 20, seconds = 2}\n')
    assert main(["report", str(scene), "-o", str(tmp_path / "out.html")]) == 2
    message = capsys.readouterr().err.strip()
    assert "accuracy: give digits or seconds, one of the two" in message
    assert len(message.splitlines()) == 1
