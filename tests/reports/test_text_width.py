"""Text reports are at most 100 columns wide: formulas and tables are broken, labels go below."""

import pytest

import hjsolve

LONGEST = 100


@pytest.mark.nightly_cases("henon-heiles", "kepler-spherical", "lagrange-top", "two-centres-space")
@pytest.mark.parametrize(
    "name", ["projectile", "henon-heiles", "kepler-spherical", "lagrange-top", "two-centres-space"]
)
def test_a_text_report_fits_a_hundred_columns(name, tmp_path):
    text = hjsolve.report(name, tmp_path / "report.txt").read_text(encoding="utf-8")
    wide = [line for line in text.splitlines() if len(line) > LONGEST]
    assert wide == []


def test_a_wide_table_keeps_every_word():
    from hjsolve.reports.formats.text import _narrowed, _widths

    words = [f"word{k}" for k in range(60)]
    cells = [[["name"], ["meaning"]], [["a"], [" ".join(words)]]]
    assert sum(_widths(_narrowed(cells))) <= LONGEST
    assert " ".join(cells[1][1]).split() == words
