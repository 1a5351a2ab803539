"""The HTML report as a browser shows it: no errors, formulas and drawings of a real size, nothing wider than the window."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import hjsolve


@pytest.fixture(scope="module", params=["kepler-planar", "kepler-spherical", "henon-heiles"])
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, browser) -> Iterator[object]:
    path: Path = tmp_path_factory.mktemp("report") / "report.html"
    hjsolve.report(request.param, path)
    browser.get(path.as_uri())
    return browser


@pytest.mark.nightly_cases("henon-heiles", "kepler-spherical")
def test_nothing_is_reported_to_the_console(page):
    assert [entry for entry in page.get_log("browser") if entry["level"] in {"SEVERE", "WARNING"}] == []


@pytest.mark.nightly_cases("henon-heiles")
def test_every_section_heading_is_visible(page):
    headings = page.find_elements("css selector", "h2")
    assert len(headings) >= 3
    assert all(h.is_displayed() and h.text.strip() for h in headings)


@pytest.mark.nightly_cases(
    "kepler-planar-500-.wide math, .stack thead math", "kepler-spherical-1200-.narrow math",
    "kepler-spherical-500-.wide math, .stack thead math", "henon-heiles-1200-.narrow math",
    "henon-heiles-500-.wide math, .stack thead math",
)  # fmt: skip
@pytest.mark.parametrize(("width", "other"), [(1200, ".narrow math"), (500, ".wide math, .stack thead math")])
def test_formulas_and_drawings_have_a_size(page, width, other):
    """But for those that are meant for the other width."""
    page.set_window_size(width, 900)
    formulas = page.find_elements("css selector", f"math:not({other})")
    assert len(formulas) >= 5
    assert all(f.size["width"] > 0 and f.size["height"] > 0 for f in formulas)
    drawings = page.find_elements("css selector", "figure svg")
    assert all(d.size["width"] >= 150 and d.size["height"] >= 100 for d in drawings)


@pytest.mark.nightly_cases("henon-heiles-500", "henon-heiles-1200")
@pytest.mark.parametrize("width", [500, 1200])
def test_the_page_is_not_wider_than_the_window(page, width):
    page.set_window_size(width, 900)
    inner, scroll = page.execute_script("return [window.innerWidth, document.documentElement.scrollWidth]")
    assert scroll <= inner


def test_the_motion_is_drawn_and_its_numbers_are_there(page):
    if "kepler-planar" not in page.page_source:
        pytest.skip("this check is of the plane Kepler report")
    assert len(page.find_elements("css selector", "figure svg")) >= 3
    assert "14.9933206" in page.find_element("css selector", "body").text
