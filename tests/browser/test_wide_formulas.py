"""Wide formulas break, labels never stand over them, tables keep every column in sight: on the screen and on paper."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)

CUT = """return [...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 2)
.map(e => e.textContent.slice(0, 60))"""
COVERED = """return [...document.querySelectorAll('.formula')].filter(f => {
const tag = f.querySelector('.tag'), math = f.querySelector('math');
if (!tag) return false;
const a = tag.getBoundingClientRect(), b = math.getBoundingClientRect();
return a.left < b.right - 1 && a.right > b.left + 1 && a.top < b.bottom - 1 && a.bottom > b.top + 1;
}).map(f => f.textContent.slice(0, 60))"""
OUTSIDE = """return [...document.querySelectorAll('table, math[display=block]')].filter(e =>
e.getBoundingClientRect().right > window.innerWidth + 1).map(e => e.textContent.slice(0, 60))"""
PAPER = 673  # CSS pixels of A4 less its margins


@pytest.fixture(scope="module", params=["kerr", "kuzmin-kutuzov", "lagrange-top"])
def page(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, browser) -> Iterator[object]:
    path: Path = tmp_path_factory.mktemp("wide") / "report.html"
    hjsolve.report(request.param, path)
    browser.get(path.as_uri())
    return browser


@pytest.mark.nightly
def test_no_formula_and_no_table_is_cut_on_a_screen(page):
    page.set_window_size(1200, 900)
    assert page.execute_script(CUT) == []
    assert page.execute_script(COVERED) == []


@pytest.mark.nightly_cases(
    "kerr-800", "lagrange-top-800", "kerr-500", "kuzmin-kutuzov-500", "kuzmin-kutuzov-800", "lagrange-top-500"
)
@pytest.mark.parametrize("width", [500, 800])
def test_on_narrow_screens_formulas_take_shorter_lines_and_tables_stand_in_one_column(page, width):
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    )
    try:
        assert page.execute_script(CUT) == []
        assert page.execute_script("return document.documentElement.scrollWidth <= window.innerWidth")
        shown = "return [...document.querySelectorAll('.formula')].map(f => [...f.querySelectorAll('.scroll')].filter(e => e.offsetWidth).length)"
        assert set(page.execute_script(shown)) == {1}
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.nightly_cases("kerr", "kuzmin-kutuzov", "lagrange-top")
def test_on_paper_labels_stand_beside_their_formulas_and_nothing_leaves_the_page(page):
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": PAPER, "height": 950, "deviceScaleFactor": 1, "mobile": False},
    )
    try:
        assert page.execute_script(COVERED) == []
        assert page.execute_script(OUTSIDE) == []
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@pytest.mark.nightly
def test_yes_and_no_do_not_look_alike(tmp_path, browser):
    looks = []
    for name in ("pendulum", "henon-heiles"):
        browser.get(hjsolve.report(name, tmp_path / f"{name}.html").as_uri())
        strong = browser.find_element("css selector", ".answer strong")
        sign = browser.find_element("css selector", ".answer .sign")
        looks.append((strong.value_of_css_property("color"), sign.text))
    assert looks[0][0] != looks[1][0]
    assert [sign for _, sign in looks] == ["✓", "✗"]
