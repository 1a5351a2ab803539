"""Progress: drawn when it is told, or not before some seconds; an ensemble counts each orbit once."""

from __future__ import annotations

import io
import sys
import time

import numpy as np
import pytest

import hjsolve
from hjsolve.display.progress import ProgressBar, Tally
from hjsolve.ensembles import orbits


def test_what_is_done_soon_draws_no_bar_and_what_takes_longer_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rich.console", None)
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    stream = io.StringIO()
    with ProgressBar(shown=True, stream=stream, after=2.0) as progress:
        tally = Tally(10, 0, progress)
        now[0] = 101.9
        tally.add(3)
        assert stream.getvalue() == ""
        now[0] = 102.0
        tally.add(2)
        assert stream.getvalue() == "\r\x1b[2K[############............] 5 of 10 orbits (50 %)"


@pytest.mark.parametrize("threads", [1, 2])
def test_an_ensemble_counts_every_orbit_once_whoever_computes_it(
    threads: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rich.console", None)
    monkeypatch.setattr(orbits, "_QUIET", 0.0)
    monkeypatch.setattr("hjsolve.ensembles.compute._FEWEST", 64)
    monkeypatch.setattr("hjsolve.display.progress._OFTEN", 0.0)
    r = np.linspace(0.9, 1.6, 400)
    r[::50], r[7] = np.nan, -1.0
    momenta = {"r": 0.1, "theta": np.where(np.arange(400) == 30, 1e-5, 1.1)}
    given = {"q": {"r": r, "theta": 0}, "p": momenta, "want": "actions", "threads": threads}
    batch = hjsolve.ensemble("kepler-planar", **given, shown=True)
    lines = capsys.readouterr().err.split("\r\x1b[2K")
    counts = [int(line.split("] ")[1].split(" of ")[0]) for line in lines if "]" in line]
    assert counts == sorted(counts)
    assert counts[0] == 0
    assert counts[-1] == 400
    assert batch.summary()["not_finite"] == 8
    assert hjsolve.ensemble("kepler-planar", **given).columns["actions.r"].tobytes() == batch.actions["r"].tobytes()
    assert capsys.readouterr().err == ""


def test_an_ensemble_that_is_quick_shows_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    hjsolve.ensemble("kepler-planar", q={"r": 1.0, "theta": 0}, p={"r": 0.1, "theta": 1.1}, want="actions", shown=True)
    assert capsys.readouterr().err == ""
    with pytest.raises(hjsolve.InvalidInputError, match="shown: True, False or None"):
        hjsolve.ensemble("kepler-planar", q={"r": 1.0, "theta": 0}, p={"r": 0, "theta": 1}, shown="yes")  # type: ignore[arg-type]
