"""Nothing endless and nothing hidden: a budget that holds, ten faults and how many more, no control characters."""

from __future__ import annotations

import json
import signal
import time

import pytest

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.command_line.time_allowed import within
from hjsolve.display.visible_text import visible
from hjsolve.errors import CatalogError, HJSolveError, InvalidInputError, InvalidSystemError, NotConvergedError
from hjsolve.mechanics.system import parameter

ENTRY = (
    'id = "own"\ntitle = "{title}"\ncoordinates = [{{name = "x", domain = "line"}}]\nkinetic = "dot(x)**2/2"\n{more}'
)


def own(folder, *, title="own", more="", name="own.toml"):
    path = folder / name
    path.write_text(ENTRY.format(title=title, more=more), encoding="utf-8")
    return path


def endless():
    for place in iter(int, 1):
        try:
            time.sleep(0.001 + place)
        except (Exception, HJSolveError):  # noqa: BLE001 - what must not hide that the time is up
            continue


def test_a_budget_ends_work_that_looks_at_no_clock_and_leaves_the_timer_as_it_was():
    before, (left, _) = signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)
    with pytest.raises(NotConvergedError, match=r"not decided in 0 s; give more time with --budget"), within(0):
        endless()
    assert 0 <= left - signal.getitimer(signal.ITIMER_REAL)[0] < 60  # that of the tests, or none
    assert signal.getsignal(signal.SIGALRM) is before
    with within(float("inf")):
        pass
    with pytest.raises(InvalidInputError, match="--budget: a number of seconds"), within(-1):
        pass


LONG = {
    "reciprocals": "+".join(f"1/(x+{k})" for k in range(1, 900)),
    "roots": "+".join(f"sqrt(x**2+{k})" for k in range(1, 500)),
    "factors": "*".join(f"sqrt(x**2+{k})" for k in range(1, 400)),
}


@pytest.mark.nightly
@pytest.mark.parametrize("name", LONG)
@pytest.mark.parametrize("command", ["check", "solve", "report"])
def test_a_long_formula_is_answered_or_not_decided_within_the_budget(tmp_path, name, command, capsys):
    path = own(tmp_path, more=f'potential = "{LONG[name]}"\n')
    report = tmp_path / "out.txt"
    output = ["-o", str(report), "--brief"] if command == "report" else []
    assert main([command, str(path), "--budget", "1", *output]) == 3
    seen = capsys.readouterr()
    verdict = report.read_text() if report.exists() else seen.out
    assert seen.err.startswith("hjsolve: not decided in 1 s") or "the time budget of the exact" in verdict


def test_a_budget_of_none_is_said_and_an_ordinary_system_needs_little(capsys):
    assert main(["check", "kepler-planar", "--budget", "30"]) == 0
    assert "Separates" in capsys.readouterr().out
    assert main(["check", "kepler-planar", "--budget", "-3"]) == 2
    assert main(["solve", "kepler-planar", "--budget", "nan"]) == 2


@pytest.mark.timeout(20)
@pytest.mark.parametrize("text", [".".join(["a"] * 200_000) + " = 1", "[" + ".".join(["ab"] * 100_000) + "]"])
def test_a_key_of_very_many_parts_is_refused_before_it_is_read(tmp_path, text):
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CatalogError, match="a key of 50 parts or more"):
        hjsolve.catalog.load(path)


@pytest.mark.timeout(30)
def test_of_very_many_faults_ten_are_told_and_how_many_more(tmp_path):
    keys = own(tmp_path, more="\n".join(f"u{k} = 1" for k in range(60_000)))
    with pytest.raises(CatalogError) as caught:
        hjsolve.catalog.load(keys)
    lines = str(caught.value).splitlines()
    assert len(lines) == 11
    assert lines[-1] == "and 59990 more"
    with pytest.raises(CatalogError) as caught:
        hjsolve.Scene.load({"system": "kepler-planar", "want": [f"w{k}" for k in range(50_000)]})
    assert str(caught.value).splitlines()[-1] == "and 49990 more"
    parameters = ", ".join(f'{{name = "a{k % 9000}"}}' for k in range(18_000))
    with pytest.raises(CatalogError, match="and 8990 more"):
        hjsolve.catalog.load(own(tmp_path, more=f"parameters = [{parameters}]\n"))


HIDDEN = ["\x1b[31m", "\x07", "\x00", "\x9b", "\u202e", "\u2066", "\u200f", "\u2028"]


@pytest.mark.parametrize("hidden", HIDDEN, ids=ascii)
def test_no_control_or_bidirectional_character_is_read_as_text(tmp_path, hidden, capsys):
    code = f"\\u{ord(hidden[0]):04x}"
    written = json.dumps(hidden)[1:-1] if ord(hidden[0]) < 256 else hidden
    written = written if hidden != "\x9b" else code
    for title, more in (
        (written, ""),
        ("t", f'summary = "a{written}"\n'),
        ("t", f'parameters = [{{name = "m", unit = "k{written}g"}}]\n'),
        ("t", f'place = {{x = "x", "y{written}" = "x"}}\n'),
        ("t", f'effects = {{drag = {{summary = "a{written}", force = {{x = "-dot(x)"}}}}}}\n'),
        ("t", f'"key{written}" = 1\n'),
    ):
        path = own(tmp_path, title=title, more=more)
        with pytest.raises(CatalogError) as caught:
            hjsolve.catalog.load(path)
        assert code in str(caught.value)
        assert main(["check", str(path)]) == 2
        told = capsys.readouterr()
        assert told.out + told.err == visible(told.out + told.err)
    for keywords in ({"title": hidden}, {"id": hidden}):
        with pytest.raises(InvalidSystemError, match="cannot be displayed"):
            hjsolve.System({"x": "line"}, "x'^2/2", **keywords)
    with pytest.raises(InvalidSystemError, match="cannot be displayed"):
        parameter("m", unit=hidden)


def test_what_is_printed_and_written_shows_hidden_characters_as_escapes(tmp_path, capsys):
    """The file's own name may hold any character."""
    path = own(tmp_path, more="unknown = 1\n", name="own\x1b[31m\u202e.toml")
    assert main(["check", str(path)]) == 2
    told = capsys.readouterr().err
    assert "own\\u001b[31m\\u202e.toml" in told
    assert told == visible(told)
    assert visible("a\tb\r\nc é φ 漢 \u200d") == "a\tb\r\nc é φ 漢 \u200d"
