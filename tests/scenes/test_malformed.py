"""Thirty ways to get a scene wrong: one line each, that names the file and the key; nothing is computed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from hjsolve.command_line.main import main
from hjsolve.errors import CatalogError
from hjsolve.scenes import Scene

GOOD = """
system = "kepler-planar"
initial = {q = {r = "1", theta = "0"}, velocity = {r = "0", theta = "1.2"}}
want = ["periods", "trajectory"]
times = {start = 0, stop = 10, count = 11}
[[events]]
kind = "impulse"
at = {t = "5"}
momentum = {theta = "0.1"}
"""
WALL = GOOD.replace('kind = "impulse"\nat = {t = "5"}\nmomentum = {theta = "0.1"}',
                    'kind = "wall"\nat = {coordinate = "r", value = "1.5"}')  # fmt: skip
FAULTS: dict[str, tuple[str, str]] = {
    "not TOML": (GOOD + "\nwant = [", "is not TOML"),
    "no system": (GOOD.replace('system = "kepler-planar"', ""), "system: missing"),
    "system of a wrong type": (GOOD.replace('"kepler-planar"', "3"), "system: must be a catalog id"),
    "unknown system": (GOOD.replace("kepler-planar", "kepler-plane"), 'no catalog entry "kepler-plane"; did you mean'),
    "missing file": (GOOD.replace("kepler-planar", "mine.toml"), "mine.toml: there is no such file"),
    "unknown key": (GOOD.replace("want", "wants"), 'wants: unknown key; did you mean "want"?'),
    "unknown effect": ('effects = ["precesion"]' + GOOD, 'no effect "precesion"; did you mean "precession"?'),
    "effects not a list": ('effects = "precession"' + GOOD, "effects: must be a list of texts"),
    "unknown parameter": ('parameters = {b = "0.02"}' + GOOD, 'parameters: no parameter "b"'),
    "parameter no number": ('parameters = {k = "one"}' + GOOD, "parameters.k"),
    "unknown coordinate": (GOOD.replace('q = {r = "1", theta', 'q = {r = "1", phi'), 'initial.q: no coordinate "phi"'),
    "coordinate missing": (GOOD.replace('q = {r = "1", theta = "0"}', 'q = {r = "1"}'), "initial.q.theta: missing"),
    "coordinate no number": (GOOD.replace('{r = "1"', '{r = "one"'), "initial.q.r"),
    "velocity and p": (GOOD.replace("velocity =", 'p = {r = "0", theta = "1"}, velocity ='), "give velocity or p"),
    "neither velocity nor p": (GOOD.replace(', velocity = {r = "0", theta = "1.2"}', ""), "give velocity or p"),
    "motion and initial": ('motion = "hyperbolic"' + GOOD, "motion: the scene has initial data of its own"),
    "unknown motion": ('system = "pendulum"\nmotion = "hyperbola"', 'motion: no motion "hyperbola"'),
    "unknown quantity": (GOOD.replace('"periods"', '"period"'), 'want: "period" is not known; did you mean "periods"?'),
    "no times": (GOOD.replace("times = {start = 0, stop = 10, count = 11}", ""), "times: missing"),
    "times a text": (GOOD.replace("{start = 0, stop = 10, count = 11}", '"0..10"'), "times: must be a list"),
    "one time only": (GOOD.replace("count = 11", "count = 1"), "times.count: must be a whole number from 2"),
    "times backwards": (GOOD.replace("stop = 10", "stop = -10"), "times: stop must be later than start"),
    "times before the start": (GOOD.replace("start = 0", "start = -1"), "with events the motion runs forward only"),
    "digits no number": ("accuracy = {digits = 2.5}" + GOOD, "accuracy.digits: must be a whole number from 1"),
    "accuracy empty": ("accuracy = {}" + GOOD, "accuracy: give digits or seconds, one of the two"),
    "digits and seconds": ("accuracy = {digits = 20, seconds = 2}" + GOOD, "accuracy: give digits or seconds"),
    "seconds not positive": ('accuracy = {seconds = "-2"}' + GOOD, "accuracy.seconds: must be more than 0"),
    "seconds no number": ('accuracy = {seconds = "soon"}' + GOOD, "accuracy.seconds"),
    "seconds a list": ("accuracy = {seconds = [1]}" + GOOD, "accuracy.seconds: must be a number"),
    "accuracy a number": ("accuracy = 20" + GOOD, "accuracy: must be a table"),
    "accuracy of an unknown kind": ("accuracy = {digit = 20}" + GOOD, 'did you mean "digits"?'),
    "too many digits": ("accuracy = {digits = 100000}" + GOOD, "accuracy.digits: must be a whole number"),
    "event of unknown kind": (GOOD.replace("impulse", "impuls"), 'events[1].kind: "impuls" is not known'),
    "event nowhere": (GOOD.replace('at = {t = "5"}', "at = {}"), "events[1].at: give a time t, or a coordinate"),
    "event at a time and a place": (
        GOOD.replace('t = "5"', 't = "5", coordinate = "r", value = "1"'), "events[1].at: give"),
    "event at a coordinate without value": (GOOD.replace('t = "5"', 'coordinate = "r"'), "coordinate and value belong"),
    "event at an unknown coordinate": (GOOD.replace('t = "5"', 'coordinate = "x", value = "1"'), 'no coordinate "x"'),
    "event outside the domain": (
        GOOD.replace('t = "5"', 'coordinate = "r", value = "-1"'), "not inside the domain of r"),
    "event before the start": (GOOD.replace('t = "5"', 't = "-5"'), "events[1].at.t: -5 lies before the start"),
    "passage below zero": (GOOD.replace('t = "5"', 'coordinate = "r", value = "1.5", passage = -1'), "at.passage"),
    "passage beyond counting": (
        GOOD.replace('t = "5"', 'coordinate = "r", value = "1.5", passage = 99999999999999999999'), "100000 at most"),
    "an integer of thousands of digits": (GOOD.replace("stop = 10", f"stop = {'9' * 5000}"), "thousands of digits"),
    "a number of thousands of digits": (GOOD.replace("stop = 10", f'stop = "{"9" * 5000}"'), "at most 1000 are accepted"),
    "infinite times": (GOOD.replace("stop = 10", "stop = inf"), "times.stop: expected one finite real number"),
    "a date": (GOOD.replace("stop = 10", "stop = 2020-01-01"), "times.stop: must be a number"),
    "a tower of powers": (GOOD.replace('t = "5"', 't = "9**9**9"'), "beyond 1e±1000"),
    "lists nested beyond reason": (GOOD + "\nx = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
    "too many times": (GOOD.replace("count = 11", "count = 10000001"), "from 2 to 10000000"),
    "a name that cannot be printed": (GOOD.replace("kepler-planar", "kepler\\u0007planar"), 'entry "kepler\\x07planar"'),
    "impulse without a jump": (GOOD.replace('momentum = {theta = "0.1"}', ""), "an impulse gives momentum or velocity"),
    "impulse on an unknown coordinate": (GOOD.replace("momentum = {theta", "momentum = {phi"), 'no coordinate "phi"'),
    "impulse no number": (GOOD.replace('momentum = {theta = "0.1"}', 'momentum = {theta = "hard"}'), "momentum.theta"),
    "wall with a jump": (WALL + 'momentum = {r = "1"}', "events[1].momentum: belongs to an impulse"),
    "wall at a time": (WALL.replace('coordinate = "r", value = "1.5"', 't = "1"'), "a wall stands at a coordinate"),
    "wall that gives energy": (WALL + 'restitution = "1.1"', "events[1].restitution: must be from 0"),
    "soft wall for an integrator": (
        'method = "integrate"\n' + WALL.replace('"periods", ', "") + 'restitution = "1/2"',
        "events[1].restitution: bounces that accumulate need quadratures"),
    "wall of negative restitution": (WALL + 'restitution = "-1/2"', "events[1].restitution: must be from 0"),
    "oblique wall": (WALL + 'surface = "r*cos(theta) = 1"', "events[1].surface: only walls at a coordinate surface"),
    "unknown method": ('method = "euler"' + GOOD, 'method: "euler" is not known'),
    "periods of an integrated scene": ('method = "integrate"' + GOOD, 'want: "periods" needs quadratures'),
    "too many digits for an integrator": (
        'method = "integrate"\naccuracy = {digits = 15}\nwant = ["trajectory"]\nsystem = "pendulum"\ntimes = [1]',
        "accuracy.digits: an integrator in doubles reaches 12"),
    "orbit not wanted": ('orbit = {of = "theta", along = "r"}' + GOOD, "orbit: described but not wanted"),
    "orbit of an unknown coordinate": (
        'orbit = {of = "phi", along = "r"}' + GOOD.replace('"periods"', '"orbit"'), 'orbit: no coordinate "phi"'),
    "inline system without T": (
        '[system]\ncoordinates = [{name = "x", domain = "line"}]', "system.kinetic: missing"),
    "inline system with a faulty formula": (
        '[system]\ncoordinates = [{name = "x", domain = "line"}]\nkinetic = "dot(x)**"', "kinetic"),
    "inline system with an unknown key": (
        '[system]\ncoordinates = [{name = "x", domain = "line"}]\nkinetic = "dot(x)**2"\nmass = 1',
        "system.mass: unknown key"),
}  # fmt: skip


def test_there_are_more_than_thirty_kinds() -> None:
    assert len(FAULTS) >= 30


def test_the_good_scenes_are_good(tmp_path: Path) -> None:
    for text in (GOOD, WALL):
        file = tmp_path / "scene.toml"
        file.write_text(text, encoding="utf-8")
        assert Scene.load(file).events


@pytest.mark.parametrize("kind", FAULTS)
def test_the_command_line_ends_with_status_2_and_writes_nothing(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, target = tmp_path / "scene.toml", tmp_path / "out.html"
    file.write_text(FAULTS[kind][0], encoding="utf-8")
    assert main(["report", str(file), "-o", str(target)]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith("hjsolve: ")
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_is_one_line_that_names_file_and_key(kind: str, tmp_path: Path) -> None:
    text, expected = FAULTS[kind]
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(CatalogError) as fault:
        Scene.load(file)
    lines = str(fault.value).splitlines()
    assert any(expected in line for line in lines), lines
    assert all(line.startswith(f"{file}: ") for line in lines), lines
    assert all(len(line) < 400 + len(str(file)) for line in lines)
    assert list(tmp_path.iterdir()) == [file]


def test_a_scene_that_is_not_there_or_not_text_is_named(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match=r"nothing\.toml: there is no such file"):
        Scene.load(tmp_path / "nothing.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(CatalogError, match=r"binary\.toml: is not UTF-8"):
        Scene.load(tmp_path / "binary.toml")


def test_a_scene_whose_system_has_no_motion_says_what_is_missing() -> None:
    inline: dict[str, Any] = {"coordinates": [{"name": "x", "domain": "line"}], "kinetic": "dot(x)**2/2"}
    with pytest.raises(ValueError, match="initial: missing"):
        Scene.load({"system": inline}).run()
