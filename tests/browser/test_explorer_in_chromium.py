"""The explorer in a browser: type, drag, two tabs, many requests, hostile text, a computation beyond its limit."""

from __future__ import annotations

import base64
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import hjsolve

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 60.0
ENDLESS = "x**2/2 + exp(x)*(" + " + ".join(f"sin({2500 + 37 * k}*x)" for k in range(12)) + ")/100000"
"""A minute of proofs that nothing hides between tens of thousands of nodes."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    pytest.importorskip("nicegui")
    command = [sys.executable, "-m", "hjsolve", "explore", "--no-browser", "--seconds", "8"]
    with subprocess.Popen(
        command, cwd=ROOT, env={k: v for k, v in os.environ.items() if not k.startswith("PYTEST")},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    ) as server:  # fmt: skip
        assert server.stdout is not None
        line = server.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:\d+/\?token=[\w-]+", line)
        assert found, line
        yield found.group()
        assert server.poll() is None, "the server ended by itself"
        server.terminate()
        server.wait(20)


WebDriverException = pytest.importorskip("selenium.common").WebDriverException


def until(condition: Callable[[], Any], what: str) -> Any:
    for _ in range(int(PATIENCE / 0.1)):
        try:
            if result := condition():
                return result
        except (WebDriverException, StopIteration, ValueError, IndexError) as error:  # the page is being rebuilt
            what = f"{what} ({type(error).__name__})"[:200]
        time.sleep(0.1)
    raise AssertionError(f"waited in vain for: {what}")


class Page:
    def __init__(self, driver: Any, address: str):
        self.driver = driver
        until(lambda: driver.get(address) is None, "the server")
        self.ready()

    def ready(self) -> None:
        until(
            lambda: self.verdict().startswith(("Separates", "✓")) or "separates" in self.verdict().lower(), "a verdict"
        )

    def field(self, label: str) -> Any:
        return self.driver.find_element("css selector", f'[aria-label^="{label}"]')

    def type(self, label: str, text: str) -> None:
        from selenium.webdriver.common.keys import Keys

        field = self.field(label)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(text or Keys.DELETE)

    def text(self, css: str) -> str:
        return str(self.driver.find_element("css selector", css).text)

    def verdict(self) -> str:
        return self.text(".lead")

    def problem(self) -> str:
        return self.text(".problem")

    def energy(self) -> float:
        rows = self.driver.find_elements("css selector", ".explorer table tr")
        row = next(r.text for r in rows if r.text.startswith("E"))
        return float(row.split()[1].replace("−", "-"))


@pytest.fixture
def page(browser: Any, address: str) -> Iterator[Page]:
    first = browser.current_window_handle
    yield Page(browser, address)
    for handle in set(browser.window_handles) - {first}:  # of a test that failed
        browser.switch_to.window(handle)
        browser.close()
    browser.switch_to.window(first)
    browser.get("about:blank")  # or it would tell other tests' console that the server ended
    browser.get_log("browser")


@pytest.mark.nightly
def test_what_is_typed_is_judged_and_moved_with_the_numbers_of_the_library(page: Page) -> None:
    page.type("V", "x**2/2")
    until(lambda: page.energy() == pytest.approx(0.72), "the energy of the oscillator")

    page.type("V", "x**4/4")
    exact = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4/4")).motion(
        q={"x": "1.2"}, velocity={"x": 0}
    )
    until(lambda: page.energy() == pytest.approx(float(exact.constants["E"].value)), "the energy of the quartic")
    assert f"{exact.periods['x'].value:.10f}"[:10] in page.text(".explorer")


@pytest.mark.nightly
def test_the_start_is_dragged_and_everything_follows(page: Page) -> None:
    from selenium.webdriver import ActionChains

    before = page.energy()
    plane = page.driver.find_element("css selector", ".portraits .drag")
    width, height = plane.size["width"], plane.size["height"]
    chain = ActionChains(page.driver).move_to_element_with_offset(plane, int(0.1 * width), int(-0.1 * height))
    chain.click_and_hold().move_by_offset(12, -9).release().perform()

    until(lambda: page.energy() != before, "another energy")
    time.sleep(1.5)
    x, speed = (float(page.field(label).get_attribute("value")) for label in ("x", "dot(x)"))
    assert (x, speed) != (1.2, 0.0)
    until(lambda: page.energy() == pytest.approx(speed**2 / 2 + x**4 / 4 - x**2 / 2, rel=1e-9), "E of the place shown")


@pytest.mark.nightly
@pytest.mark.parametrize(
    "text", ["__import__('os').system('true')", "<script>window.broken = 1</script>", "1/0", "((((", "x**1000000", "\\"]
)
def test_hostile_text_is_answered_with_a_line(page: Page, text: str) -> None:
    page.type("V", text)

    until(lambda: "potential" in page.problem(), "a message")
    assert page.driver.execute_script("return window.broken") is None
    page.type("V", "x**2/2")
    until(lambda: not page.problem() and page.energy() == pytest.approx(0.72), "the next answer")


@pytest.mark.nightly
def test_a_new_system_is_judged_as_a_whole_and_a_stale_verdict_is_named(page: Page) -> None:
    page.type("T, with", "m*dot(s)**2/2")
    until(lambda: "T uses m" in page.text(".unfinished"), "what is missing")
    assert not page.problem()
    assert "Out of date" in page.text(".stale")
    assert "T = dot(x)**2/2" in page.text(".stale")
    page.type("Coordinates", "s: line")
    page.type("V", "k*s**2/2")
    until(lambda: "V uses k" in page.text(".unfinished"), "what is missing still")
    page.driver.find_element("xpath", "//button[contains(., 'Check the system')]").click()
    until(lambda: "is not declared" in page.problem() and "The whole system" in page.problem(), "the faults")
    page.type("Parameters", "m = 1; k = 1")
    until(lambda: not page.text(".stale") and not page.problem() and not page.text(".unfinished"), "a verdict")


@pytest.mark.nightly
def test_a_link_restores_what_was_typed(page: Page, address: str) -> None:
    page.type("V", "3*x**2/2")
    until(lambda: page.energy() == pytest.approx(2.16), "the energy")
    page.driver.find_element("xpath", "//button[contains(., 'Copy link')]").click()
    until(lambda: "#" in page.driver.current_url, "the link")
    link = page.driver.current_url
    page.driver.get("about:blank")
    page.driver.get(link)
    until(lambda: page.energy() == pytest.approx(2.16), "the energy again")
    assert page.field("V").get_attribute("value") == "3*x**2/2"
    page.driver.get("about:blank")
    page.driver.get(link[:-6])
    until(lambda: "cannot be read" in page.text("[role=status].hint"), "what is wrong with the link")


@pytest.mark.nightly
def test_fifty_quick_changes_end_at_the_last(page: Page) -> None:
    for k in range(1, 51):
        page.type("V", f"{k}*x**2/2")

    until(lambda: page.energy() == pytest.approx(36.0), "the fiftieth energy")


@pytest.mark.nightly
def test_two_tabs_do_not_know_of_each_other_and_a_computation_over_its_limit_ends_alone(
    page: Page, address: str
) -> None:
    driver = page.driver
    first = driver.current_window_handle
    driver.switch_to.new_window("tab")
    other = Page(driver, address)
    other.type("V", ENDLESS)
    driver.switch_to.window(first)
    page.type("V", "x**2/2")
    until(lambda: page.energy() == pytest.approx(0.72), "an answer while the other tab computes")
    driver.switch_to.window(driver.window_handles[-1])
    until(lambda: "more than 8 s" in other.problem(), "the message of the limit")
    other.type("V", "x**2/2")
    until(lambda: not other.problem() and other.energy() == pytest.approx(0.72), "an answer afterwards")
    driver.close()
    driver.switch_to.window(first)


@pytest.mark.nightly
def test_nothing_is_fetched_from_elsewhere(page: Page, address: str) -> None:
    fetched = page.driver.execute_script("return performance.getEntriesByType('resource').map(e => e.name)")

    assert fetched
    own = address.partition("?")[0]
    assert all(name.startswith((own, own.replace("http", "ws"), "data:", "blob:")) for name in fetched)
    assert not [entry for entry in page.driver.get_log("browser") if entry["level"] == "SEVERE"]


@pytest.mark.nightly
def test_it_is_dark_where_the_browser_is(page: Page) -> None:
    look = (
        "return [document.querySelector('.explorer h1'), document.body].map((e, k) => "
        "getComputedStyle(e)[k ? 'backgroundColor' : 'color'].match(/[0-9]+/g).slice(0, 3).map(Number))"
    )

    def turned(scheme: str) -> tuple[int, int]:
        feature = {"name": "prefers-color-scheme", "value": scheme}
        page.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
        time.sleep(0.5)
        ink, paper = page.driver.execute_script(look)
        return sum(ink), sum(paper)

    ink, paper = turned("dark")
    assert ink > 500 > 150 > paper
    ink, paper = turned("light")
    assert ink < 200


@pytest.mark.nightly
def test_printed_it_fills_two_pages_and_no_empty_one(page: Page) -> None:
    until(lambda: page.energy() < 0, "the motion of the double well")
    printed = page.driver.execute_cdp_cmd("Page.printToPDF", {"paperWidth": 8.27, "paperHeight": 11.69})
    assert len(re.findall(rb"/Type\s*/Page\b", base64.b64decode(printed["data"]))) == 2


def test_on_a_telephone_sentences_wrap_and_only_formulas_and_tables_scroll(page: Page) -> None:
    until(lambda: page.energy() < 0, "the motion of the double well")
    size = {"width": 400, "height": 900, "deviceScaleFactor": 1, "mobile": True}
    page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        widest = page.driver.execute_script(
            "return Math.max(...[...document.querySelectorAll('.explorer p')].map((p) => p.getBoundingClientRect().right))"
        )
        assert 200 < widest <= 400
        assert page.driver.execute_script("return document.documentElement.scrollWidth") <= 400
    finally:
        page.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
