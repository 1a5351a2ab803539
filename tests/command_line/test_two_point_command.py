"""hjsolve two-point: CSV, JSON, statuses and messages."""

from __future__ import annotations

import csv
import io
import json
import math

import pytest

from hjsolve.command_line.main import main

PLACES = ["--from", "r=1", "theta=0", "--to", "r=2", "theta=pi/2", "--time", "30"]


def test_the_motions_of_a_kepler_problem_are_rows_and_completeness_is_said(capsys):
    assert main(["two-point", "kepler-planar", *PLACES, "--turns", "0:1"]) == 0
    out, err = capsys.readouterr()
    rows = list(csv.DictReader(io.StringIO(out)))
    assert [row["turns"] for row in rows] == ["0", "0", "1", "1", "1", "1"]
    assert float(rows[0]["p0.theta"]) == pytest.approx(0.6970730309377864, rel=1e-14, abs=0)
    assert "Complete" in err


def test_json_holds_the_same_numbers_with_errors(capsys):
    spring = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2/2"]
    assert main(["two-point", *spring, "--from", "x=1", "--to", "x=0", "--time", "1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["complete"]
    assert len(answer["motions"]) == 1
    S = answer["motions"][0]["S"]
    assert abs(S["value"] - 1 / math.tan(1) / 2) <= 1e-16
    assert 0 < S["error"] < 1e-15


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["two-point", "kepler-planar", "--from", "r=1", "theta=0"], "give both places"),
        (["two-point", "kepler-planar", *PLACES, "--turns", "some"], "--turns"),
        (["two-point", "kepler-planar", *PLACES[:-1], "-3"], "not positive"),
    ],
)
def test_bad_input_is_one_line(arguments, words, capsys):
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1
