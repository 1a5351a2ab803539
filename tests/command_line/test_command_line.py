"""The command line: four exit statuses, one-line errors, never a traceback, nothing half-written."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hjsolve.command_line.main import main

Capture = pytest.CaptureFixture[str]
KEPLER = ["--coordinate", "r: 0 < r", "--coordinate", "theta: angle", "--kinetic", "m/2*(dot(r)**2 + r**2*dot(theta)**2)",
          "--potential", "-k/r", "--parameter", "m=1", "--parameter", "k=1"]  # fmt: skip
OSCILLATOR = [
    "--coordinate",
    "x: line",
    "-T",
    "m/2*dot(x)**2",
    "-V",
    "m*w**2/2*x**2",
    "--parameter",
    "m=1",
    "--parameter",
    "w=2",
]


def run(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "hjsolve", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **options)  # type: ignore[call-overload, no-any-return]


# ------------------------------------------------------------------------------------------------ answers
def test_check_prints_verdict_and_evidence_and_ends_with_0(capsys: Capture) -> None:
    assert main(["check", "kepler-planar"]) == 0
    out = capsys.readouterr().out
    assert "Separates in r and θ: a system of Liouville form. θ is ignorable." in out
    assert "Φ = [m, −1/r²; 0, 1]" in out
    assert "p_θ²/(2 m r²)" in out


def test_check_of_an_obstruction_ends_with_1_and_shows_the_witness(capsys: Capture) -> None:
    assert main(["check", "henon-heiles"]) == 1
    out = capsys.readouterr().out
    assert "Does not separate in x and y" in out
    assert "2 λ x" in out
    assert "1.333333333 and 1.333333334" in " ".join(out.split())


def test_a_system_of_ones_own_is_decided_like_the_catalog_s(capsys: Capture) -> None:
    assert main(["check", *KEPLER]) == 0
    own = capsys.readouterr().out
    assert main(["check", "kepler-planar"]) == 0
    assert own.strip() in capsys.readouterr().out


def test_solve_prints_w_and_the_time_law(capsys: Capture) -> None:
    assert main(["solve", *OSCILLATOR]) == 0
    out = capsys.readouterr().out
    assert re.search(r"W = ∫\[x₀, x\] √\(2 m E − m² w² x²\) dx", out)
    assert "t − t₀ = m ∫[x₀, x] 1/√(2 m E − m² w² x²) dx" in out


def test_solve_of_what_does_not_separate_ends_with_1(capsys: Capture) -> None:
    assert main(["solve", "henon-heiles"]) == 1
    assert "obstruction" in capsys.readouterr().out


def test_an_effect_can_break_separability(capsys: Capture) -> None:
    assert main(["check", "kepler-planar", "--effect", "precession"]) == 0
    assert main(["check", "kepler-planar", "--effect", "uniform-field"]) == 1
    assert "cos θ" in capsys.readouterr().out


@pytest.mark.nightly
def test_report_of_what_does_not_separate_is_written_all_the_same(tmp_path: Path) -> None:
    target = tmp_path / "henon.html"
    assert main(["report", "henon-heiles", "-o", str(target)]) == 1
    assert "Does not separate" in target.read_text(encoding="utf-8")


@pytest.mark.nightly
def test_report_with_other_initial_data_and_parameters(tmp_path: Path) -> None:
    target = tmp_path / "swing.txt"
    data = [
        "--q",
        "theta=0.5",
        "--velocity",
        "theta=0",
        "--parameter",
        "g=1.62",
        "--parameter",
        "l=2",
        "--digits",
        "30",
    ]
    assert main(["report", "pendulum", "-o", str(target), "--no-cost", *data]) == 0
    text = target.read_text(encoding="utf-8")
    assert "g = 1.62" in text
    assert re.search(r"7\.09\d{25,} ± ", text), "2π√(l/g)(1 + θ²/16 + …) to 30 digits"


def test_catalog_lists_shows_and_checks(capsys: Capture) -> None:
    assert main(["catalog"]) == 0
    listed = capsys.readouterr().out
    assert "kepler-planar" in listed
    assert "henon-heiles" in listed
    assert main(["catalog", "show", "kepler-planar"]) == 0
    assert "hyperbolic" in capsys.readouterr().out
    source = Path(__file__).resolve().parents[2] / "catalog" / "systems" / "kepler-planar.toml"
    assert main(["catalog", "check", str(source)]) == 0
    assert "a correct entry" in capsys.readouterr().out


@pytest.mark.parametrize("command", [[], ["check"], ["solve"], ["report"], ["catalog"]])
def test_help_has_examples_and_tells_the_exit_status(command: list[str], capsys: Capture) -> None:
    assert main([*command, "--help"]) == 0
    out = capsys.readouterr().out
    assert "examples:" in out
    assert "exit status:" in out
    assert max(map(len, out.splitlines())) <= 110


# ------------------------------------------------------------------------------------------------ bad input
BAD: dict[str, tuple[list[str], str]] = {
    "unknown command": (["chekc"], "'chekc' is not a command; did you mean `hjsolve check`?"),
    "a system for a command": (["kepler-planar"], "for a system write `hjsolve check kepler-planar`"),
    "a word for an action": (["catalog", "galaxy"], "to search write `hjsolve catalog search galaxy`"),
    "an option that is cut": (["check", "--coord", "x: line"], "`hjsolve check` does not take --coord; did you mean --coordinate?"),
    "an option of others": (["solve", "kepler-planar", "--q", "r=1"], "`hjsolve solve` does not take --q; it belongs to"),
    "a word too many": (["check", "pendulum", "more"], "does not take more; leave it out"),
    "unknown option": (["check", "kepler-planar", "--fast"], "--fast"),
    "no system": (["check"], "which system?"),
    "unknown id": (["check", "keplr-planar"], "kepler-planar"),
    "both systems": (["check", "pendulum", *OSCILLATOR], "not both"),
    "no kinetic": (["check", "--coordinate", "x: line"], "--kinetic"),
    "no coordinate": (["check", "-T", "dot(x)**2/2"], "--coordinate"),
    "bad coordinate": (["check", "--coordinate", "x", "-T", "dot(x)**2"], 'write a name, a colon and a domain'),
    "bad domain": (["check", "--coordinate", "x: somewhere", "-T", "dot(x)**2"], "somewhere"),
    "twice": (["check", "--coordinate", "x: line", "--coordinate", "x: line", "-T", "dot(x)**2"], "twice"),
    "bad formula": (["check", "--coordinate", "x: line", "-T", "dot(x)**"], "kinetic"),
    "undeclared": (["check", "--coordinate", "x: line", "-T", "q*dot(x)**2"], "'q' is not declared"),
    "code": (["check", "--coordinate", "x: line", "-T", "__import__('os').getcwd()"], "kinetic"),
    "tower": (["check", "--coordinate", "x: line", "-T", "dot(x)**2", "-V", "9**9**9"], "potential"),
    "bad parameter": (["check", *OSCILLATOR, "--parameter", "=3"], "--parameter"),
    "effect of own": (["check", *OSCILLATOR, "--effect", "drag"], "--effect"),
    "unknown effect": (["check", "pendulum", "--effect", "drago"], "drago"),
    "no output": (["report", "pendulum"], "add -o FILE, such as -o report.html"),
    "bad suffix": (["report", "pendulum", "-o", "pendulum.doc"], ".html"),
    "no suffix": (["report", "pendulum", "-o", "pendulum"], ".html"),
    "no such folder": (["report", "pendulum", "-o", "no/such/folder/p.html"], "does not exist"),
    "half a motion": (["report", "pendulum", "-o", "p.html", "--q", "theta=1"], "--velocity"),
    "bad value": (["report", "pendulum", "-o", "p.html", "--q", "theta", "--velocity", "theta=1"], "--q"),
    "value no number": (["report", "pendulum", "-o", "p.html", "--q", "theta=one", "--velocity", "theta=0"], "one"),
    "unknown motion": (["report", "pendulum", "-o", "p.html", "--motion", "wild"], "wild"),
    "digits": (["report", "pendulum", "-o", "p.html", "--digits", "-3"], "digits"),
    "digits no number": (["report", "pendulum", "-o", "p.html", "--digits", "many"], "--digits: a whole number is needed"),
    "show nothing": (["catalog", "show"], "an entry is needed"),
    "list something": (["catalog", "list", "pendulum"], "catalog show pendulum"),
    "missing file": (["check", "no-such-file.toml"], "there is no such file"),
    "half of an id": (["kepler"], "'kepler' is not a command; for a system write `hjsolve check kepler`"),
    "a formula for an id": (["solve", "r**2"], "--potential FORMULA"),
    "a script": (["check", "own.py"], "run it with `python own.py`"),
    "an option of others, not near": (["coordinates", "pendulum", "--find"], "it belongs to"),
    "a range with a dash": (["motion", "pendulum", "--times", "0-10"], "such as 0:10:101"),
    "an option without its value": (["motion", "pendulum", "--times"], "--times: its value is missing"),
    "degrees": (["motion", "pendulum", "--q", "theta=90deg", "--velocity", "theta=0"], "write 90*pi/180"),
    "no time to measure": (["cost", "pendulum", "--seconds", "0"], "seconds: a number > 0 is needed, not 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_line_and_status_2(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments, word = BAD[name]
    scripts = [Path(text) for text in arguments if text.endswith(".py")]
    for script in scripts:
        script.write_text("import hjsolve")
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("hjsolve: ")
    assert len(captured.err.strip().splitlines()) == 1
    assert word in captured.err
    assert [path.name for path in tmp_path.iterdir()] == [script.name for script in scripts], "nothing was written"


def make_folder(path: Path) -> None:
    path.mkdir()


FILES: dict[str, Callable[[Path], object]] = {
    "directory": make_folder,
    "binary": lambda path: path.write_bytes(b"\xff\xfe\x00\x01" * 50),
    "not toml": lambda path: path.write_text("id = = 3"),
    "empty": lambda path: path.write_text(""),
    "wrong id": lambda path: path.write_text('id = "other"\n'),
    "too long": lambda path: path.write_bytes(b"# " + b"x" * 2_000_000),
    "nested": lambda path: path.write_text("x = " + "[" * 5000),
}


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("command", [["check"], ["solve"], ["catalog", "check"]])
def test_a_bad_file_is_status_2(kind: str, command: list[str], tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "entry.toml"
    FILES[kind](path)
    assert main([*command, str(path)]) == 2
    error = capsys.readouterr().err
    assert "entry.toml" in error
    assert "Traceback" not in error


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")
def test_unreadable_file_and_unwritable_folder_are_status_2(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "entry.toml"
    path.write_text("")
    path.chmod(0)
    assert main(["check", str(path)]) == 2
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    assert main(["report", "pendulum", "-o", str(closed / "p.html")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_output_that_is_a_directory_is_status_2(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "p.html").mkdir()
    assert main(["report", "pendulum", "-o", str(tmp_path / "p.html")]) == 2
    assert "is a directory" in capsys.readouterr().err


# ------------------------------------------------------------------------------------------------ the process
def test_a_report_that_fails_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "p.html"
    target.write_text("old")
    assert main(["report", "pendulum", "-o", str(target), "--q", "theta=1", "--velocity", "theta=none"]) == 2
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["p.html"]


def test_an_existing_report_is_replaced_and_keeps_its_mode(tmp_path: Path) -> None:
    target = tmp_path / "p.json"
    target.write_text("old")
    target.chmod(0o640)
    assert main(["report", "pendulum", "-o", str(target), "--no-cost"]) == 0
    assert target.read_text().startswith("{")
    assert target.stat().st_mode & 0o777 == 0o640


def test_a_closed_pipe_is_no_error_message() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as pipe:
        process = subprocess.Popen(
            [sys.executable, "-m", "hjsolve", "check", "lagrange-top"], stdout=pipe, stderr=subprocess.PIPE, text=True
        )
        _, error = process.communicate(timeout=60)
    assert error == ""
    assert process.returncode == 141


def test_interrupt_is_one_line(tmp_path: Path) -> None:
    code = """
import signal, sys, time, hjsolve.command_line.commands as c
from hjsolve.command_line.main import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background inherits that it is ignored
c.check_command = lambda options: (print('ready', flush=True), time.sleep(30))
sys.exit(main(['check', 'x']))
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=30)
    assert process.returncode == 130
    assert error == "hjsolve: interrupted; nothing was written\n"


def test_a_terminal_without_unicode_still_gets_an_answer() -> None:
    done = run("check", "pendulum", env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0
    assert "\\u03b8" in done.stdout


def test_a_full_disk_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "hjsolve", "check", "pendulum"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("hjsolve: ")
    assert "Traceback" not in done.stderr


def test_a_fault_of_ours_is_one_line_and_asks_for_a_report(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    def broken(options: object) -> int:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("hjsolve.command_line.commands.check_command", broken)
    monkeypatch.delenv("HJSOLVE_TRACEBACK", raising=False)
    assert main(["check", "pendulum"]) == 3
    error = capsys.readouterr().err
    assert "a fault of hjsolve itself" in error
    assert len(error.strip().splitlines()) == 1
    monkeypatch.setenv("HJSOLVE_TRACEBACK", "1")
    assert main(["check", "pendulum"]) == 3
    assert "Traceback" in capsys.readouterr().err


def test_undecided_is_status_3(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    import sympy as sp

    import hjsolve
    from hjsolve.separation import Undecided

    def unsure(system: hjsolve.System, *, budget: float) -> Undecided:
        assert budget == 60
        return Undecided(
            system, None, ("x", "y"), "potential", sp.Symbol("x"), {"x": sp.Rational(1, 2)}, None, "try more digits", ()
        )

    monkeypatch.setattr("hjsolve.separation.separate", unsure)
    assert main(["check", "henon-heiles"]) == 3
    assert "Not decided" in capsys.readouterr().out


# ------------------------------------------------------------------------------------------------ H(q, p) in an entry
@pytest.mark.nightly_cases("henon-heiles-1")
@pytest.mark.parametrize(("system", "status"), [("pendulum", 0), ("henon-heiles", 1), ("skate", 1)])
def test_a_report_to_a_dash_is_the_text_file_on_the_standard_output(
    system: str, status: int, tmp_path: Path, capsys: Capture
) -> None:
    """Nothing but the report is printed, so that it can be piped; its last section has times, which differ."""
    assert main(["report", system, "-o", "-"]) == status
    printed = capsys.readouterr().out
    assert main(["report", system, "-o", str(tmp_path / "report.txt")]) == status
    written = (tmp_path / "report.txt").read_text(encoding="utf-8")
    assert len(printed) > 300
    assert printed.split("How this was computed")[0] == written.split("How this was computed")[0]


def test_an_entry_with_a_hamiltonian_is_checked_solved_and_reported(tmp_path: Path, capsys: Capture) -> None:
    name = "hamiltonian-q-plus-p"
    assert main(["check", name]) == 0
    assert "H is linear in its momentum" in capsys.readouterr().out
    assert main(["solve", name]) == 0
    out = capsys.readouterr().out
    assert "S = E q − ½ q² − E t" in out
    assert "t − β_E = q" in out
    for suffix in ("html", "md", "json", "txt", "tex"):
        target = tmp_path / f"h.{suffix}"
        assert main(["report", name, "-o", str(target)]) == 0
        assert "linear in its momentum" in target.read_text(encoding="utf-8")
    text = (tmp_path / "h.txt").read_text(encoding="utf-8")
    assert re.search(r"3/2 +2\.00000000000000\d+ ± \S+ +−0\.5000000000000\d+ ± ", text)
    own = ["report", name, "-o", str(tmp_path / "own.txt"), "--q", "q=1", "--momentum", "q=2"]
    assert main(own) == 0
    assert "3.000000000000000" in (tmp_path / "own.txt").read_text(encoding="utf-8")
    capsys.readouterr()
    assert main(["catalog", "show", name]) == 0
    assert "H = p_q + q" in capsys.readouterr().out
    assert main([*own[:6], "--velocity", "q=1"]) == 2
    assert main(["check", name, "--effect", "drag"]) == 2
    assert main(["report", name, "-o", str(tmp_path / "own.txt"), "--motion", "slow"]) == 2


# ------------------------------------------------------------------------------------------------ filters of the catalog
@pytest.mark.nightly
def test_the_catalog_is_filtered(capsys: Capture) -> None:
    def listed(*options: str) -> set[str]:
        assert main(["catalog", *options]) == 0
        return set(re.findall(r"^  ([a-z0-9-]+)  ", capsys.readouterr().out, re.MULTILINE))

    from hjsolve import catalog

    assert listed() == set(catalog.ids())
    for kind in ("separable", "extended", "refused", "outside"):
        assert listed("--kind", kind) == set(catalog.ids(kind))
    assert listed("--separable") == set(catalog.ids("separable")) | set(catalog.ids("extended"))
    assert listed("--book", "C28") == {"kepler-planar"}
    assert listed("--book", "C25b", "--separable") == {"whirling-tube"}
    for wrong in (
        ["--book", "C97"], ["--kind", "reduced"], ["--kind", "refused", "--separable"], ["show", "pendulum", "--book", "C17"],
    ):  # fmt: skip
        assert main(["catalog", *wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
