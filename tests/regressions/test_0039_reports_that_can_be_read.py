"""Reports that can be read: exact numbers shown exactly, verdicts with a sign, wide formulas on lines, cost when asked."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.costs import Cost, Row
from hjsolve.reports.content import document, gather
from hjsolve.reports.formats.html import html_page
from hjsolve.reports.formats.json_format import json_text
from hjsolve.reports.formats.latex_document import tex
from hjsolve.reports.formats.markdown import markdown_page
from hjsolve.reports.formats.text import line, text_page
from hjsolve.reports.formulas.from_sympy import box, compact
from hjsolve.reports.formulas.layout import Glyph, Grid, width
from hjsolve.reports.formulas.layout import RowBox as BoxRow
from hjsolve.reports.formulas.line_breaks import LINE, broken, display
from hjsolve.reports.formulas.one_line_text import plain
from hjsolve.reports.sections.cost import cost_section
from hjsolve.reports.sections.rounded_numbers import terminating
from hjsolve.reports.sections.solution import solution_sections
from hjsolve.reports.sections.system_and_verdict import exactly
from tests.support import entries
from tests.support.reports import report_of


# ------------------------------------------------------------------------------------------------ numbers
@pytest.mark.parametrize(
    ("value", "shown"),
    [(sp.Rational(-7, 25), "−0.28"), (sp.Rational(981, 100), "9.81"), (sp.Rational(1, 2), "½"), (sp.Integer(1), "1"),
     (sp.Rational(1, 13), "1/13 ≈ 0.0769231"), (sp.sqrt(2), "√2 ≈ 1.41421"), (sp.Integer(0), "0"),
     (324 * sp.sin(sp.Rational(13, 10)) ** 4 / 5, "(324/5) sin⁴(13/10) ≈ 55.8582")],
)  # fmt: skip
def test_exact_numbers_are_written_as_they_are_read(value: sp.Expr, shown: str) -> None:
    assert line(exactly(value)) == shown


@pytest.mark.parametrize("value", [sp.Rational(1, 3), sp.sqrt(2), sp.Rational(1, 2**40), sp.pi])
def test_what_does_not_end_soon_is_no_exact_decimal(value: sp.Expr) -> None:
    assert terminating(value) is None


def test_numbers_that_are_known_exactly_carry_no_error() -> None:
    page = json.loads(json_text(report_of("kepler-planar")))["sections"]["numbers"]["blocks"]
    tables = {block["caption"]: block["rows"] for block in page if block["kind"] == "table"}
    energy = tables["Constants of the motion"][0][1]
    assert (energy["value"], energy["error"]) == ("-0.28", "0")
    lower, upper = tables["Turning points"][0][1:]
    assert (lower["value"], lower["error"]) == ("1", "0")
    assert upper["error"] != "0"
    action = next(rows for caption, rows in tables.items() if caption.startswith("Actions"))[1][1]
    assert (action["value"], action["error"]) == ("1.2", "0")


def test_only_the_turning_point_of_the_start_is_exact() -> None:
    motion = hjsolve.solve("harmonic-oscillator").motion(q={"x": "1/2"}, velocity={"x": "1/10"})
    page = json.loads(json_text(document(gather(motion))))["sections"]["numbers"]["blocks"]
    table = next(block for block in page if block.get("caption") == "Turning points")
    assert all(end["error"] != "0" for end in table["rows"][0][1:])


# ------------------------------------------------------------------------------------------------ the verdict
@pytest.mark.parametrize(("name", "verdict", "sign"), [("pendulum", "yes", "✓ "), ("henon-heiles", "no", "✗ ")])
def test_a_verdict_is_told_by_a_sign_and_a_colour(name: str, verdict: str, sign: str) -> None:
    whole = report_of(name)
    assert (whole.verdict, whole.sign) == (verdict, sign)
    page = html_page(whole)
    assert f'class="answer {verdict}"' in page
    colours = {
        word: re.search(rf"\.answer\.{word}{{--verdict:var\(--(\w+)\)", page)[1] for word in ("yes", "no", "open")
    }
    assert len(set(colours.values())) == 3
    assert f"> {sign}**" in markdown_page(whole)
    assert f"\n\n{sign}" in text_page(whole)
    assert json.loads(json_text(whole))["verdict"] == verdict
    assert replace(whole, verdict="open").sign == "? "


# ------------------------------------------------------------------------------------------------ wide formulas
def letters(shown: object) -> str:
    return re.sub(r"\s", "", plain(shown))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name", ["kerr", "kuzmin-kutuzov", "vinti", "two-centres-space", "lagrange-top", "charge-in-monopole-field"]
)
def test_broken_formulas_keep_every_sign_and_term(name: str) -> None:
    solution = entries.solution(name)
    expressions = [solution.system.kinetic, *solution.momentum_squared.values(), solution.separation.shell.potential]
    expressions += [step.formula for step in solution.separation.shell.steps if step.formula is not None]
    for expression in expressions:
        whole, shown = box(expression), display(expression)
        assert letters(shown) == letters(whole)
        if isinstance(shown, Grid) and not shown.left:
            longest = max(width(BoxRow(cells)) for cells in shown.rows)
            assert longest < width(whole)


def test_a_formula_is_broken_before_its_signs_only() -> None:
    terms = [sp.Symbol(f"a{i}") * sp.sqrt(sp.Symbol(f"b{i}") + sp.Symbol("c")) for i in range(1, 30)]
    shown = broken(box(sp.Eq(sp.Symbol("W"), sp.Add(*terms))))
    assert isinstance(shown, Grid)
    for left, right in shown.rows[1:]:
        assert left == Glyph("", "text")
        assert right.items[1].text in {"+", "−"}
    assert all(sum(map(width, cells)) <= LINE * 1.05 for cells in shown.rows)


def test_long_roots_are_written_by_their_momenta_and_stay_under_the_integral() -> None:
    sections = {s.key: s for s in solution_sections(entries.solution("kerr"))}
    law = plain(next(b for b in sections["time-law"].blocks if hasattr(b, "box")).box)
    assert "∫[r₀, r] r²/(pᵣ(r) (2 M r − a² − r²)) dr" in law
    assert "integrands here and below" in line(sections["characteristic-function"].blocks[0].text)
    short = {s.key: s for s in solution_sections(entries.solution("kepler-planar"))}
    assert "√(" in plain(next(b for b in short["time-law"].blocks if hasattr(b, "box")).box)


def test_the_shorter_form_is_the_same_function() -> None:
    motion = entries.motion("kerr")
    for square in motion.solution.momentum_squared.values():
        assert sp.simplify(compact(square) - square) == 0


@pytest.mark.nightly
def test_the_meaning_of_a_constant_stands_before_its_long_formula() -> None:
    shown = text_page(document(gather("kerr", initial=None)))
    head = next(row for row in shown.splitlines() if "In terms of q and p" in row)
    assert head.index("Meaning") < head.index("In terms of q and p")
    assert max(map(len, shown.splitlines())) < 300


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["kerr", "kuzmin-kutuzov"])
def test_tex_has_one_environment_for_each_broken_formula(name: str) -> None:
    page = tex(report_of(name))
    assert page.count(r"\begin{aligned}") == page.count(r"\end{aligned}") > 2
    assert page.count("{") - page.count(r"\{") == page.count("}") - page.count(r"\}")


# ------------------------------------------------------------------------------------------------ cost
@pytest.mark.nightly
def test_the_cost_of_accuracy_is_measured_only_when_it_is_asked_for(tmp_path: Path) -> None:
    target = tmp_path / "o.md"
    for options, there in (([], False), (["--no-cost"], False), (["--cost"], True)):
        assert main(["report", "harmonic-oscillator", "-o", str(target), *options]) == 0
        assert ("What accuracy costs" in target.read_text(encoding="utf-8")) == there
    assert "accuracy costs" not in hjsolve.report("pendulum", target).read_text(encoding="utf-8")


def table(reference: str, *rows: Row) -> Cost:
    return Cost("A table", "", ("periods",), 0, 0, rows, reference, 1e-30, 3.0, 2.5)


def test_what_was_measured_against_nothing_is_not_called_true() -> None:
    row = Row("float64", 15, claimed=1e-15, seconds=1e-3, note="no reference: the true error is not known")
    section = cost_section(table("", row))
    words = " ".join(line(b.text) for b in section.blocks if hasattr(b, "text"))
    assert "no true errors are known" in words
    assert "against nothing" not in words
    assert not any(hasattr(b, "items") for b in section.blocks), "no figure of crosses"
    assert "No reference could be computed" in table("", row).text


def test_what_did_not_fit_is_told_so() -> None:
    row = Row("mpmath", 30, status="too slow", note="would take about 41 ms, more than its fraction of what was left")
    shown = table("Taylor series", row).text
    assert "did not fit the budget · would take about 41 ms" in shown
    assert "too slow" not in shown
