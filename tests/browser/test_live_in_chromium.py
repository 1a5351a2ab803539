"""A live report in a browser: sliders move orbit, point and numbers, which are those of the engine; nothing is fetched."""

from __future__ import annotations

import math

import pytest

import hjsolve


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, browser):
    path = hjsolve.report("kepler-planar", tmp_path_factory.mktemp("live") / "live.html", live=True)
    browser.set_window_size(1200, 900)
    browser.get(path.as_uri())
    return browser


def slide(page, number: int, share: float) -> list[float]:
    return page.execute_script(
        "const s = document.getElementById(`live-slider-${arguments[0]}`); s.value = 1000 * arguments[1];"
        "s.dispatchEvent(new Event('input')); return hjsolveLive.settings;", number, share,
    )  # fmt: skip


def test_nothing_goes_wrong_and_no_request_leaves_the_page(page):
    assert [e for e in page.get_log("browser") if e["level"] in {"SEVERE", "WARNING"}] == []
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.parametrize(("p", "E"), [(0.2, 0.9), (0.71, 0.35)])
def test_a_slider_moves_orbit_point_and_numbers_to_those_of_the_engine(page, p, E):
    pictures = page.execute_script("return ['well', 'phase', 'orbit'].map(k => document.getElementById('live-' + k).toDataURL())")
    told = page.find_element("id", "live-numbers").text
    slide(page, 0, p)
    momentum, energy = slide(page, 1, E)
    after = page.execute_script("return ['well', 'phase', 'orbit'].map(k => document.getElementById('live-' + k).toDataURL())")
    assert all(a != b for a, b in zip(pictures, after))
    assert page.find_element("id", "live-numbers").text != told
    bounds = page.execute_script("return hjsolveLive.bounds")
    motion = hjsolve.solve("kepler-planar").motion(
        q={"r": 1 / (1 / momentum**2), "theta": 0}, constants={"E": energy, "p_theta": momentum}, signs={"r": 1}
    )
    low, high = (end.value for end in motion.turning_points["r"])
    # r from the lower turning point on, by Kepler's equation: nothing of hjsolve
    a, T = (low + high) / 2, motion.periods["r"].value
    e = (high - low) / (high + low)
    for share in (0.11, 0.5, 0.83, 1.37):
        M = 2 * math.pi * share
        u = M
        for _ in range(100):
            u -= (u - e * math.sin(u) - M) / (1 - e * math.cos(u))
        shown = page.execute_script("return hjsolveLive.state(arguments[0])", share * T)
        assert abs(shown["q"] - a * (1 - e * math.cos(u))) <= bounds["r"]
        ν = 2 * math.atan2(math.sqrt(1 + e) * math.sin(u / 2), math.sqrt(1 - e) * math.cos(u / 2))
        turned = shown["angles"]["theta"] - ν
        assert abs(turned - 2 * math.pi * round(turned / (2 * math.pi))) <= bounds["theta"]
    rows = dict(line.rsplit(" ", 1) for line in page.find_element("id", "live-numbers").text.splitlines())
    assert abs(float(rows["lower turning point of r"]) - low) <= bounds["r"] + 1e-6  # seven digits are shown
    assert abs(float(rows["period"]) - T) <= bounds["r"] * T / (high - low) + 1e-5


def test_play_and_pause_by_the_keyboard(page):
    page.execute_script("document.getElementById('live-play').focus()")
    button = page.find_element("id", "live-play")
    button.send_keys(" ")
    assert button.get_attribute("aria-pressed") == "true"
    before = page.find_element("id", "live-time").text
    page.execute_async_script("setTimeout(arguments[0], 300)")
    assert page.find_element("id", "live-time").text != before
    button.send_keys(" ")
    assert button.get_attribute("aria-pressed") == "false"


def test_sliders_work_by_the_keyboard_and_tell_their_value(page):
    slider = page.find_element("id", "live-slider-0")
    before = slider.get_attribute("aria-valuetext")
    slider.send_keys("\ue012" * 3)  # the left arrow
    assert slider.get_attribute("aria-valuetext") != before
    assert slider.get_attribute("aria-valuetext").startswith("p_θ = ")


def test_a_frame_takes_little_time(page):
    """What is drawn for one frame, on whatever machine runs this; at 60 frames a second there are 16.7 ms."""
    spent = page.execute_script(
        "const begin = performance.now(); for (let k = 0; k < 100; k++) hjsolveLive.seek(k / 7);"
        "return (performance.now() - begin) / 100;"
    )
    print(f"{spent:.2f} ms a frame")
    assert spent < 16.7


def test_printed_it_is_the_static_report(page):
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not page.find_element("id", "live").is_displayed()
    assert page.find_element("id", "motion").is_displayed()
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@pytest.mark.parametrize("width", [500, 1200])
def test_the_page_is_not_wider_than_the_window(page, width):
    page.set_window_size(width, 900)
    inner, scroll = page.execute_script("return [window.innerWidth, document.documentElement.scrollWidth]")
    assert scroll <= inner
