"""The work-precision figure as a browser shows it: nothing overlaps, nothing hangs over, failures are marked."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from hjsolve.costs import Cost, Row
from hjsolve.reports.sections.cost import cost_document
from hjsolve.reports.write_cost import save_cost


def row(
    method: str, digits: float, error: float | None, seconds: float | None, status: str = "ok", note: str = ""
) -> Row:
    claimed = None if error is None or method in ("DOP853", "heyoka") else 10 * error
    return Row(method, digits, claimed, error, claimed is not None or None, 1234, "evaluations", seconds, 3, status,
               "all", note)  # fmt: skip


FULL = (
    row("float64", 15, 3.8e-16, 0.08), row("mpmath", 20, 1.3e-25, 0.55), row("mpmath", 30, 2.4e-36, 0.7),
    row("mpmath", 50, 1.7e-55, 1.2, "extrapolated", "time for 2001 times from 15"),
    row("mpmath", 100, None, None, "too slow", "about 12 s"), row("certified", 15, 7e-17, 0.26),
    row("certified", 100, 0.0, 0.79), row("closed form", 15, 7e-17, 6e-4), row("closed form", 100, 0.0, 6.1e-4),
    row("DOP853", 4, 4e-2, 0.019), row("DOP853", 8, 6.7e-7, 0.05), row("DOP853", 13.6, 1e-11, 0.16),
    row("heyoka", 6, 2e4, 3e-4, "lost"), row("heyoka", 12, 2.4e-10, 3.4e-4),
)  # fmt: skip
LITTLE = (
    row("integrate", 4, 1e-6, 0.5), row("DOP853", 4, None, None, "missing", "needs scipy"),
    row("heyoka", 6, None, None, "not converged", "the state became infinite"),
)  # fmt: skip


@pytest.fixture(scope="module", params=[FULL, LITTLE], ids=["full", "little"])
def table(request: pytest.FixtureRequest) -> Cost:
    want = ("turning_points", "actions", "frequencies", "periods", "trajectory")
    return Cost("A table", "kepler-planar", want, 101, 4, request.param, "Taylor series at 115 digits", 1e-110, 10, 9.5)


@pytest.fixture(scope="module")
def page(table: Cost, tmp_path_factory: pytest.TempPathFactory, browser) -> Iterator[object]:
    path: Path = tmp_path_factory.mktemp("cost") / "cost.html"
    save_cost(table, path)
    browser.set_window_size(1000, 1400)
    browser.get(path.as_uri())
    return browser


BOXES = """
return [...document.querySelectorAll('figure svg text')].map(t => {
  const b = t.getBoundingClientRect(); return [t.textContent, b.left, b.top, b.right, b.bottom];
});
"""


@pytest.mark.nightly_cases("full")
def test_no_words_of_the_figure_overlap(page):
    boxes = page.execute_script(BOXES)
    assert len(boxes) > 12
    for i, (text, left, top, right, bottom) in enumerate(boxes):
        for other, l, t, r, b in boxes[i + 1 :]:
            apart = right <= l + 0.5 or r <= left + 0.5 or bottom <= t + 0.5 or b <= top + 0.5
            assert apart, (text, other)


def test_nothing_of_the_figure_hangs_over(page):
    outer = page.execute_script(
        "const b=document.querySelector('figure svg').getBoundingClientRect();return [b.left,b.top,b.right,b.bottom]"
    )
    inner = page.execute_script("""
      return [...document.querySelectorAll('figure svg text, figure svg path')].map(e => {
        const b = e.getBoundingClientRect(); return [e.outerHTML.slice(0, 80), b.left, b.top, b.right, b.bottom]; });""")
    for what, left, top, right, bottom in inner:
        assert left >= outer[0] - 1, what
        assert right <= outer[2] + 1, what
        assert top >= outer[1] - 1, what
        assert bottom <= outer[3] + 1, what


def test_every_row_has_its_mark(page, table):
    """One mark a row, with its numbers as a tooltip; a row that never ran is a cross in the legend."""
    said = [
        t.get_attribute("textContent")
        for t in page.find_elements("css selector", "figure svg g g title, figure svg > g > title")
    ]
    drawn = [r for r in table.rows if r.answered or r.status in ("too slow", "not converged")]
    assert len(said) == len(drawn)
    crosses = page.find_elements("css selector", "figure svg .cross")
    failed = [r for r in table.rows if r.status in ("too slow", "not converged", "lost")]
    unstarted = [m for m in table.methods if not any(r.answered for r in table.of(m))]
    assert len(crosses) == len(failed) + len(unstarted)
    assert len(page.find_elements("css selector", "figure svg .hollow")) == sum(
        r.status == "extrapolated" for r in table.rows
    )


@pytest.mark.parametrize("width", [500, 1200])
def test_the_page_is_not_wider_than_the_window(page, width):
    page.set_window_size(width, 900)
    inner, scroll = page.execute_script("return [window.innerWidth, document.documentElement.scrollWidth]")
    assert scroll <= inner


def test_the_answer_names_a_method_that_covers_everything(table):
    words = str(cost_document(table).answer[0])
    assert "closed form" in words or "No method" in words
