"""Reports on paper: A4 or Letter, with page numbers, and no fraction set small."""

import re
from pathlib import Path

import pytest

import hjsolve
from hjsolve.errors import InvalidInputError
from hjsolve.reports.formats.stylesheet import CSS
from hjsolve.reports.write import Sheet, checked_sheet

POINTS = {"A4": (595, 842), "Letter": (612, 792)}


@pytest.mark.parametrize(("paper", "suffix", "size"), [
    ("letter", ".pdf", "Letter"), (None, ".pdf", "A4"), ("a4", ".html", "A4"), (None, ".html", None),
])  # fmt: skip
def test_a_page_has_the_size_that_is_asked(paper, suffix, size):
    target = Path("report" + suffix)
    page = checked_sheet("", paper, target).on_paper(f"<style>{CSS}</style>", target)
    found = re.search(r"@page\{(?:size:(\w+);)?margin", page)
    assert found is not None
    assert found[1] == size


@pytest.mark.parametrize(("paper", "suffix"), [("A5", ".pdf"), (4, ".pdf"), ("A4", ".txt")])
def test_other_papers_are_refused_with_what_to_write(paper, suffix):
    with pytest.raises(InvalidInputError, match=r"paper: .*(A4|leave paper out)"):
        checked_sheet("", paper, Path("report" + suffix))


def test_the_style_sheet_numbers_pages_and_shrinks_no_fraction():
    printed = CSS[CSS.index("@media print") :]
    assert 'counter(page) " / " counter(pages)' in printed
    assert "mfrac>*{math-depth:inherit}" in printed
    sizes = [float(size) for size in re.findall(r"font(?:-size)?:([\d.]+)pt", printed)]
    assert min(sizes) >= 8


@pytest.mark.browser
@pytest.mark.nightly
@pytest.mark.parametrize("paper", list(POINTS))
def test_a_printed_report_is_on_that_paper(paper, tmp_path):
    path = hjsolve.report("pendulum", tmp_path / "pendulum.pdf", brief=True, paper=paper)
    boxes = re.findall(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)", path.read_bytes())
    assert boxes
    for box in boxes:
        assert [round(float(side)) for side in box] == pytest.approx(POINTS[paper], abs=1)


def test_a_sheet_is_a_value():
    assert Sheet("T", "A4") == Sheet("T", "A4")
