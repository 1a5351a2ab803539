"""`hjsolve motion` and its neighbours: tables on the standard output, scenes in place of systems, completion."""

from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
from pathlib import Path

import mpmath
import pytest

import hjsolve
from hjsolve.command_line.main import main

Capture = pytest.CaptureFixture[str]
SCENES = Path(__file__).resolve().parents[2] / "scenes"
QUARTIC = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**4/4", "--q", "x=1", "--velocity", "x=0"]


def table(capsys: Capture) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(capsys.readouterr().out)))


def kepler_radius(t: mpmath.mpf) -> mpmath.mpf:
    """r of the catalog's planar Kepler orbit from Kepler's equation: a = 25/14, e = 11/25, pericentre at t = 0."""
    with mpmath.workdps(50):
        a, e = mpmath.mpf(25) / 14, mpmath.mpf(11) / 25
        M = t / a ** mpmath.mpf("1.5")
        u = mpmath.findroot(lambda u: u - e * mpmath.sin(u) - M, M + e * mpmath.sin(M))
        return a * (1 - e * mpmath.cos(u))


def test_states_at_times_are_those_of_kepler_s_equation(capsys: Capture) -> None:
    assert main(["motion", "kepler-planar", "--times", "0:15:31"]) == 0
    rows = table(capsys)
    assert [row["t"] for row in rows][:3] == ["0.0", "0.5", "1.0"]
    assert len(rows) == 31
    for row in rows:
        with mpmath.workdps(50):
            off = abs(mpmath.mpf(float(row["q.r"])) - kepler_radius(mpmath.mpf(float(row["t"]))))
        assert off <= float(row["error.q.r"]) < 1e-13
        assert row["status"] == "ok"


def test_more_digits_come_as_text_and_at_exact_times(capsys: Capture) -> None:
    assert main(["motion", "kepler-planar", "--times", "0:1:4", "--digits", "30", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["t"] == ["0", "1/3", "2/3", "1"]
    for t, r, error in zip(found["t"], found["q.r"], found["error.q.r"]):
        with mpmath.workdps(50):
            number = mpmath.mpf(t.partition("/")[0]) / int(t.partition("/")[2] or 1)
            assert abs(mpmath.mpf(r) - kepler_radius(number)) <= error < 1e-26
    assert found["kinds"] == {"r": "libration", "theta": "ignorable"}


def test_without_times_there_are_the_numbers_of_the_motion(capsys: Capture) -> None:
    assert main(["motion", "kepler-planar"]) == 0
    rows = {(row["quantity"], row["name"]): row for row in table(capsys)}
    with mpmath.workdps(40):
        period = 2 * mpmath.pi * (mpmath.mpf(25) / 14) ** mpmath.mpf("1.5")
        found = rows["periods", "r"]
        assert abs(mpmath.mpf(float(found["value"])) - period) <= float(found["error"]) < 1e-13
    assert rows["kind", "theta"]["value"] == "ignorable"
    assert float(rows["turning_points", "r.lower"]["value"]) == 1.0


def test_a_system_of_one_s_own_and_listed_times(capsys: Capture) -> None:
    assert main(["motion", *QUARTIC, "--times", "0, 1/3, 2"]) == 0
    rows = table(capsys)
    assert [row["t"] for row in rows] == ["0", "1/3", "2"]
    assert all(abs(float(r["p.x"]) ** 2 / 2 + float(r["q.x"]) ** 4 / 4 - 0.25) < 1e-14 for r in rows)


def test_a_scene_gives_its_own_times(capsys: Capture) -> None:
    assert main(["motion", str(SCENES / "precessing-ellipse.toml")]) == 0
    rows = table(capsys)
    assert len(rows) == 2001
    assert float(rows[600]["p.theta"]) == pytest.approx(1.3)  # after the impulse of 1/10 at t = 50
    assert main(["motion", str(SCENES / "precessing-ellipse.toml"), "--times", "0:1:3"]) == 2
    assert "says its times itself" in capsys.readouterr().err


@pytest.mark.parametrize(("arguments", "status", "said"), [
    (["motion", "kepler-planar", "--times", "0:1"], 2, "write start:stop:count"),
    (["motion", "kepler-planar", "--times", "0:1:1"], 2, "count from 2"),
    (["motion", "kepler-planar", "--times", "0,x"], 2, "--times"),
    (["motion", "kepler-planar", "--times", "0:pi:3"], 2, "must be rational"),
    (["motion", "kepler-planar", "--motion", "sideways"], 2, 'no motion "sideways"'),
    (["motion", *QUARTIC[:6]], 2, "which motion?"),
    (["motion", "henon-heiles", "--q", "x=0", "--q", "y=0", "--velocity", "x=1", "--velocity", "y=0"], 1, "does not separate"),
    (["report", "kepler-planar", "-o", "a.html", "--format", "md"], 2, "applies to -o -"),
    (["motion", str(SCENES / "damped-pendulum.toml"), "--q", "theta=1"], 2, "says everything itself"),
])  # fmt: skip
def test_what_cannot_be_done_is_told_in_one_line(arguments: list[str], status: int, said: str, capsys: Capture) -> None:
    assert main(arguments) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


def test_check_and_solve_take_a_scene(capsys: Capture) -> None:
    scene = str(SCENES / "precessing-ellipse.toml")
    assert main(["check", scene]) == 0
    assert "V = −b/r² − k/r" in capsys.readouterr().out
    assert main(["solve", scene]) == 0
    assert "t − t₀ =" in capsys.readouterr().out
    assert main(["check", str(SCENES / "damped-pendulum.toml")]) == 1
    assert "dH/dt = -c*dot(theta)**2" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(("form", "begins"), [
    ("html", "<!DOCTYPE html>"), ("md", "# Plane pendulum"), ("json", "{"), ("tex", "\\documentclass"), ("txt", "Plane pendulum"),
])  # fmt: skip
def test_a_report_on_the_standard_output_has_the_format_asked(form: str, begins: str, capsys: Capture) -> None:
    assert main(["report", "pendulum", "-o", "-", "--format", form]) == 0
    assert capsys.readouterr().out.startswith(begins)


def test_cost_takes_a_system_of_one_s_own(capsys: Capture) -> None:
    assert main(["cost", *QUARTIC, "--seconds", "2", "--no-rivals", "--digits", "20"]) == 0
    out = capsys.readouterr().out
    assert "float64" in out
    assert "claim broken" not in out


@pytest.mark.parametrize(("words", "expected"), [
    ("motion kepler-pl", "kepler-planar"), ("mot", "motion"), ("motion --tim", "--times"), ("report --for", "--format"),
])  # fmt: skip
def test_bash_completes_commands_options_and_ids(words: str, expected: str, tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("shtab", reason="needs the extra completion")
    if (bash := shutil.which("bash")) is None:
        pytest.skip("there is no bash")
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "hjsolve.bash"
    script.write_text(capsys.readouterr().out, encoding="utf-8")
    typed = f"hjsolve {words}".split()
    code = f"source {script}; COMP_WORDS=({' '.join(typed)}); COMP_CWORD={len(typed) - 1}; _shtab_hjsolve; echo ${{COMPREPLY[@]}}"
    run = subprocess.run([bash, "-c", code], capture_output=True, text=True, timeout=30, check=True)
    assert expected in run.stdout.split()


@pytest.mark.parametrize("shell", ["zsh", "fish", "tcsh", "powershell"])
def test_other_shells_have_a_script_that_knows_the_catalog(shell: str, capsys: Capture) -> None:
    pytest.importorskip("shtab", reason="needs the extra completion")
    assert main(["completion", shell]) == 0
    assert "kepler-planar" in capsys.readouterr().out


@pytest.mark.parametrize("start", [
    ["--q", "r=1", "--q", "theta=1-1", "--velocity", "r=0", "--velocity", "theta=-6/5"],
    ["--q", "r=1", "theta=1-1", "--velocity", "r=0", "theta=-6/5"],
    ["--q", "r=1, theta=1-1", "--velocity", "r=0,theta=-6/5"],
])  # fmt: skip
def test_initial_values_are_repeated_listed_or_parted_by_commas(start: list[str], capsys: Capture) -> None:
    given = ["motion", "kepler-planar", *start, "--times", "1,2"]
    assert main(given) == 0
    motion = hjsolve.solve(hjsolve.catalog.load("kepler-planar")).motion(
        q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "-6/5"}
    )
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert [float(row["q.theta"]) for row in rows] == list(motion.at([1, 2]).q["theta"])


def test_a_value_that_belongs_to_no_option_is_not_taken(capsys: Capture) -> None:
    assert main(["motion", "kepler-planar", "--times", "0:1:2", "theta=1"]) == 2
    assert "theta=1" in capsys.readouterr().err
