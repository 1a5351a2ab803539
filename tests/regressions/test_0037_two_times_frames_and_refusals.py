"""A report of a system with a coordinate t, of one in a declared frame, of one that is not given by T and V, of one that falls short.

Kerr's time law had one letter t for the path's parameter and for Boyer and Lindquist's time; framed entries told the
autonomous system only; a refused entry had no report; a number that fell short took the formulas with it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import sympy as sp

import hjsolve
from hjsolve import frames
from hjsolve.command_line.main import main
from hjsolve.mechanics.system import hamiltonian
from hjsolve.reports.content import document, gather
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.text import text_page
from hjsolve.reports.write import write_document
from tests.support import entries
from tests.support.reports import report_of

FRAMED = ["spring-moving-anchor", "spring-turning-anchor", "oscillator-drifting-gauge"]
OUTSIDE = hjsolve.catalog.ids("outside")
SUFFIXES = [".html", ".md", ".json", ".txt", ".tex"]


def _as_read(page: str) -> str:
    """A page with its typeset formulas as they are read aloud, and without the marks that keep a full stop beside one."""
    spoken = re.sub(r'<math[^>]*aria-label="([^"]*)".*?</math>', r"\1", page, flags=re.DOTALL)
    return re.sub(r"</?span[^>]*>", "", spoken)


# ------------------------------------------------------------------------------------------------ two times
@pytest.mark.nightly
def test_the_parameter_of_a_path_is_not_called_t_where_t_is_a_coordinate() -> None:
    solution = entries.solution("kerr")
    names = {s.name for s in solution.time_law.lhs.free_symbols}
    assert names == {"tau", "tau_0"}
    whole = report_of("kerr")
    shown = text_page(whole)
    assert "τ − τ₀ = " in shown
    assert "Initial data at τ = 0" in shown
    assert "from τ = 0 to τ = " in shown
    assert "t₀" not in shown
    assert not re.search(r"\bt =", shown)
    drawings = [
        f for s in whole.sections for b in s.blocks if hasattr(b, "items") for f in b.items if hasattr(f, "svg")
    ]
    history = next(f for f in drawings if "along the path" in f.title)
    assert set(history.data) == {"tau", "r", "theta"}
    assert "τ" in history.svg
    page = json.loads(json_text(whole))
    orbit = next(f for b in page["sections"]["motion"]["blocks"] if b["kind"] == "figures" for f in b["figures"]
                 if f["title"] == "Orbit")  # fmt: skip
    assert set(orbit["data"]) == {"x", "y", "z"}  # where the hole is; the coordinate t is not drawn as a time


def test_every_name_for_the_parameter_may_be_taken() -> None:
    T = "(-dot(t)**2 + dot(tau)**2 + dot(s)**2)/2"
    system = hjsolve.System({"t": "line", "tau": "line", "s": "line"}, T, "s**2", signature="indefinite")
    law = hjsolve.solve(system).time_law
    assert {s.name for s in law.lhs.free_symbols} == {"sigma", "sigma_0"}
    free = hjsolve.System({"t": "line", "x": "line"}, "(dot(x)**2 - dot(t)**2)/2", signature="indefinite")
    equation = hjsolve.solve(free).orbit_equations["p_t"]
    assert {s.name for s in equation.rhs.free_symbols} == {"t", "p_t", "tau"}


def test_the_ordinary_time_keeps_its_letter() -> None:
    assert {s.name for s in entries.solution("pendulum").time_law.lhs.free_symbols} == {"t", "t_0"}
    assert "The coordinates against time" in json_text(report_of("pendulum"))


@pytest.mark.parametrize("name", ["kerr", "schwarzschild"])
def test_geodesics_of_the_catalog_are_told_in_proper_time(name: str) -> None:
    assert entries.motion(name).initial.constants["E"] == sp.Rational(-1, 2)


# ------------------------------------------------------------------------------------------------ frames
@pytest.mark.parametrize("name", FRAMED)
def test_the_principal_function_in_the_original_coordinates_solves_the_equation(name: str) -> None:
    """∂S/∂t + H(q, ∂S/∂q, t) = 0, the derivatives of S by hand from W's integrands; 30 digits at a place."""
    frame = frames.load(name)
    solution = frame.solve()
    S = frame.principal_function(solution)
    H = hamiltonian(frame.original)
    slopes = {c.momentum: sp.diff(S, c.symbol) for c in frame.original.coordinates}
    residual = sp.diff(S, frame.time) + H.xreplace(slopes)
    point = {s: sp.Rational(1, 3 + i) for i, s in enumerate(sorted(residual.free_symbols, key=str))}
    point |= {p.symbol: p.value for p in frame.system.parameters}
    point |= {
        c.symbol: c.symbol.assumptions0 and sp.Integer(3 + i) for i, (n, c) in enumerate(solution.constants.items())
    }
    assert abs(sp.N(residual.subs(point), 30)) < 1e-25


@pytest.mark.parametrize("name", FRAMED)
@pytest.mark.parametrize("command", ["check", "solve"])
def test_commands_tell_the_system_as_it_is_posed(name: str, command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, name]) == 0
    out = capsys.readouterr().out
    assert "The system as posed, and its frame" in out
    assert "contains the time" in out
    assert ("S = " in out) == (command == "solve")


def test_reports_tell_the_frame_too() -> None:
    keys = [section.key for section in report_of("spring-moving-anchor").sections]
    assert keys.index("frame") == keys.index("system") + 1
    assert "frame" not in [section.key for section in report_of("pendulum").sections]


# ------------------------------------------------------------------------------------------------ no T and V
@pytest.mark.parametrize("name", OUTSIDE)
def test_an_entry_that_is_no_t_and_v_has_a_report(name: str, tmp_path: Path) -> None:
    target = tmp_path / "refused.md"
    assert main(["report", name, "-o", str(target)]) == 1
    page = target.read_text(encoding="utf-8")
    entry = hjsolve.catalog.describe(name)
    assert re.split(r" (?==)|[(]", entry.title)[0][:12] in page
    assert "*" not in page.splitlines()[0]
    assert "**Refused**" in page
    assert "## Why it is refused" in page
    assert "## Literature" in page


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_it_has_one_in_every_format(suffix: str, tmp_path: Path) -> None:
    page = hjsolve.report("skate", tmp_path / f"skate{suffix}").read_text(encoding="utf-8")
    assert "nonholonomic" in page
    assert "Greenwood" in page


# ------------------------------------------------------------------------------------------------ what falls short
SHORT = ["--coordinate", "x: 0 < x", "-T", "dot(x)**2/2", "-V", "-k*(x+2)/(a**2*(x+1))", "--parameter", "k=1",
         "--parameter", "a=1", "--q", "x=1", "--velocity", "x=1"]  # fmt: skip


@pytest.mark.rotating(2)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_formulas_are_written_when_a_number_falls_short(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from hjsolve.errors import NotConvergedError
    from hjsolve.solution.quadratures import Solution

    def fails(self: Solution, **initial: object) -> None:
        raise NotConvergedError("p² could not be decided near q = 12")

    monkeypatch.setattr(Solution, "motion", fails)
    target = tmp_path / f"short{suffix}"
    assert main(["report", *SHORT, "-o", str(target)]) == 3
    page = _as_read(target.read_text(encoding="utf-8"))
    assert "Time law" in page
    assert "What fell short" in page
    assert "could not be decided near q = 12" in page
    assert "No initial data were given" not in page
    error = capsys.readouterr().err
    assert "could not be decided near q = 12" in error
    assert str(target) in error


def test_drawings_that_fall_short_leave_the_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hjsolve.errors import NotConvergedError
    from hjsolve.reports.drawings import orbit_paths

    def fails(motion: object) -> None:
        raise NotConvergedError("no state at t = 3")

    monkeypatch.setattr(orbit_paths, "trace", fails)
    with pytest.raises(NotConvergedError, match=r"no state at t = 3.*everything else was written"):
        hjsolve.report("pendulum", tmp_path / "short.txt")
    page = (tmp_path / "short.txt").read_text(encoding="utf-8")
    assert "Results with error bounds" in page
    assert "no state at t = 3" in page


# ------------------------------------------------------------------------------------------------ literature
@pytest.mark.nightly_cases(".html")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_labels_are_resolved_in_every_format(suffix: str, tmp_path: Path) -> None:
    page = write_document(report_of("henon-heiles"), tmp_path / f"page{suffix}").read_text(encoding="utf-8")
    assert "Classical Dynamics" in page
    assert "The labels at the formulas are its equation numbers" in page
    assert "Astronomical Journal" in page
    assert "Hénon" in page or r"\'" in page


def test_every_cited_work_is_found_and_readable() -> None:
    from hjsolve.catalog.bibliography import cited, sources

    for name in hjsolve.catalog.ids():
        entry = entries.described(name)
        assert len(cited(entry.cite)) == len({reference.split()[0] for reference in entry.cite})
    for source in sources().values():
        assert not re.search(r"[{}\\]|--", source.written + source.name), source.written
        assert re.findall(r"[a-z]{3}", source.fields["title"])[-1] in source.written


def test_a_system_of_ones_own_cites_the_book_of_its_labels_only() -> None:
    own = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4")
    shown = text_page(document(gather(own)))
    assert shown.count("Greenwood 1977") == 1
    assert "Landau" not in shown
