"""A live report in a browser: sliders move orbit, point and numbers, which are those of the engine; nothing is fetched."""

from __future__ import annotations

import math

import numpy as np
import pytest

import hjsolve


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, browser):
    path = hjsolve.report("kepler-planar", tmp_path_factory.mktemp("live") / "live.html", live=True, brief=True)
    browser.set_window_size(1200, 900)
    browser.get(path.as_uri())
    return browser


def slide(page, number: int, fraction: float) -> list[float]:
    return page.execute_script(
        "const s = document.getElementById(`live-slider-${arguments[0]}`); s.value = 1000 * arguments[1];"
        "s.dispatchEvent(new Event('input')); return hjsolveLive.settings;", number, fraction,
    )  # fmt: skip


@pytest.mark.nightly
def test_nothing_goes_wrong_and_no_request_leaves_the_page(page):
    assert [e for e in page.get_log("browser") if e["level"] in {"SEVERE", "WARNING"}] == []
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.nightly_cases("0.2-0.9")
@pytest.mark.parametrize(("p", "E"), [(0.2, 0.9), (0.71, 0.35)])
def test_a_slider_moves_orbit_point_and_numbers_to_those_of_the_engine(page, p, E):
    pictures = page.execute_script(
        "return ['well-0', 'phase-0', 'orbit'].map(k => document.getElementById('live-' + k).toDataURL())"
    )
    told = page.find_element("id", "live-numbers").text
    slide(page, 0, p)
    momentum, energy = slide(page, 1, E)
    after = page.execute_script(
        "return ['well-0', 'phase-0', 'orbit'].map(k => document.getElementById('live-' + k).toDataURL())"
    )
    assert all(a != b for a, b in zip(pictures, after))
    assert page.find_element("id", "live-numbers").text != told
    bounds = page.execute_script("return hjsolveLive.bounds")
    motion = hjsolve.solve("kepler-planar").motion(
        q={"r": 1 / (1 / momentum**2), "theta": 0}, constants={"E": energy, "p_theta": momentum}, signs={"r": 1}
    )
    low, high = (end.value for end in motion.turning_points["r"])
    # the start is the lower turning point; r from there on by Kepler's equation: nothing of hjsolve
    a, T = (low + high) / 2, motion.periods["r"].value
    e = (high - low) / (high + low)
    for fraction in (0.11, 0.5, 0.83, 1.37):
        M = 2 * math.pi * fraction
        u = M
        for _ in range(100):
            u -= (u - e * math.sin(u) - M) / (1 - e * math.cos(u))
        shown = page.execute_script("return hjsolveLive.state(arguments[0])", fraction * T)["q"]
        assert abs(shown["r"] - a * (1 - e * math.cos(u))) <= bounds["r"]
        ν = 2 * math.atan2(math.sqrt(1 + e) * math.sin(u / 2), math.sqrt(1 - e) * math.cos(u / 2))
        turned = shown["theta"] - ν
        assert abs(turned - 2 * math.pi * round(turned / (2 * math.pi))) <= bounds["theta"]
    rows = dict(line.rsplit(" ", 1) for line in page.find_element("id", "live-numbers").text.splitlines())
    assert abs(float(rows["lower turning point of r"]) - low) <= bounds["r"] + 1e-6  # seven digits are shown
    assert abs(float(rows["period"]) - T) <= bounds["r"] * T / (high - low) + 1e-5


def test_the_link_restores_sliders_and_time_and_the_table_says_why_sliders_end(page):
    address = page.current_url.split("#")[0]
    wanted = [slide(page, 0, 0.25), slide(page, 1, 0.75)][-1]
    page.execute_script("hjsolveLive.seek(3.25)")
    page.find_element("id", "live-share").click()
    link = page.current_url
    assert link.startswith(address + "#p_theta=")
    page.get("about:blank")
    page.get(link)
    assert page.execute_script("return hjsolveLive.settings") == pytest.approx(wanted, rel=1e-7)
    assert page.find_element("id", "live-time").text == "t = 3.250"
    page.get("about:blank")
    page.get(address + "#E=12&p_theta=nothing")
    assert "E = 12, beyond the slider" in page.find_element("id", "live-shared").text
    rows = page.execute_script("return [...document.querySelectorAll('.live-ends tbody tr')].map(r => r.textContent)")
    assert len(rows) == 2
    page.get("about:blank")
    page.get(address)


def pixel_of(page, momentum: float, energy: float) -> tuple[float, float]:
    """Where on the map two constants are, from its window and the margins of its frame."""
    return page.execute_script(
        "const {map, sliders} = JSON.parse(document.getElementById('live-data').textContent);"
        "const c = document.getElementById('live-map'), box = c.getBoundingClientRect(), [x, y] = map.window;"
        "return [46 + (box.width - 54) * (arguments[0] - x[0]) / (x[1] - x[0]) + box.left,"
        "22 + (box.height - 56) * (y[1] - arguments[1]) / (y[1] - y[0]) + box.top];", momentum, energy,
    )  # fmt: skip


def test_a_click_on_the_map_chooses_the_motion_there(page):
    ranges = page.execute_script("return JSON.parse(document.getElementById('live-data').textContent).sliders")
    wanted = [s["low"] + fraction * (s["high"] - s["low"]) for s, fraction in zip(ranges, (0.3, 0.6))]
    page.execute_script("document.getElementById('live-map').scrollIntoView()")
    x, y = pixel_of(page, *wanted)
    page.execute_script(
        "document.getElementById('live-map').dispatchEvent("
        "new PointerEvent('pointerdown', {clientX: arguments[0], clientY: arguments[1], bubbles: true}))", x, y,
    )  # fmt: skip
    found = page.execute_script("return hjsolveLive.settings")
    for value, goal, s in zip(found, wanted, ranges):
        assert abs(value - goal) < 1e-9 * (s["high"] - s["low"])
    shown = page.execute_script("return hjsolveLive.ends()")
    motion = hjsolve.solve("kepler-planar").motion(
        q={"r": found[0] ** 2, "theta": 0}, constants={"E": found[1], "p_theta": found[0]}, signs={"r": 1}
    )
    bounds = page.execute_script("return hjsolveLive.bounds")
    for value, end in zip(shown["r"], motion.turning_points["r"]):
        assert abs(value - end.value) <= bounds["r"]


def test_arrow_keys_on_the_map_move_the_constants_and_the_sliders(page):
    before = page.execute_script("return [...hjsolveLive.settings]")
    knob = page.find_element("id", "live-slider-1").get_attribute("value")
    page.find_element("id", "live-map").send_keys("\ue013" * 4)  # the up arrow
    after = page.execute_script("return hjsolveLive.settings")
    assert after[1] > before[1]
    assert after[0] == before[0]
    assert page.find_element("id", "live-slider-1").get_attribute("value") != knob


def test_nothing_beyond_the_tables_can_be_chosen_on_the_map(page):
    ranges = page.execute_script("return JSON.parse(document.getElementById('live-data').textContent).sliders")
    x, y = pixel_of(page, 10 * ranges[0]["high"], 10 * ranges[1]["high"])
    page.execute_script(
        "document.getElementById('live-map').dispatchEvent("
        "new PointerEvent('pointerdown', {clientX: arguments[0], clientY: arguments[1], bubbles: true}))", x, y,
    )  # fmt: skip
    for value, s in zip(page.execute_script("return hjsolveLive.settings"), ranges):
        assert s["low"] <= value <= s["high"]


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
    """What is drawn for one frame takes less than a million sines, which take some 16 ms: 60 frames a second."""
    frame, sines = page.execute_script(
        "const timed = (f) => { const begin = performance.now(); f(); return performance.now() - begin; };"
        "let total = 0; const rounds = [...Array(9).keys()].map((r) => ["
        "timed(() => { for (let k = 0; k < 10; k++) hjsolveLive.seek((k + r) / 7); }) / 10,"
        "timed(() => { for (let k = 0; k < 1e6; k++) total += Math.sin(k); })]);"
        "return [0, 1].map((i) => rounds.map((r) => r[i]).sort((a, b) => a - b)[4]);"
    )
    print(f"{frame:.2f} ms a frame, {sines:.2f} ms for a million sines")
    assert frame < sines


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


SYSTEMS = {
    "two-centres-plane": {"subject": "two-centres-plane"},
    "spherical-pendulum": {"subject": "spherical-pendulum"},
    "pendulum": {"subject": "pendulum", "sliders": {"g": (5.0, 15.0)}},
    "typed, in space": {
        "subject": hjsolve.System(
            coordinates={"r": "0 < r", "phi": "angle", "z": "line"},
            kinetic="(dot(r)**2 + r**2*dot(phi)**2 + dot(z)**2)/2", potential="log(r) + z**2 + z**4/3",
            place={"x": "r*cos(phi)", "y": "r*sin(phi)", "z": "z"},
        ),
        "initial": {"q": {"r": 1, "phi": 0, "z": "0.4"}, "velocity": {"r": "0.3", "phi": "1.1", "z": "0.2"}},
    },
}  # fmt: skip


@pytest.fixture(scope="module", params=SYSTEMS)
def other(request, tmp_path_factory: pytest.TempPathFactory, browser):
    """A page of another system, and the motion it begins with."""
    told = SYSTEMS[request.param]
    path = hjsolve.report(path=tmp_path_factory.mktemp("live") / "live.html", live=True, brief=True, **told)
    assert path.stat().st_size < 1_500_000
    browser.set_window_size(1200, 900)
    browser.get(path.as_uri())
    start = told.get("initial") or hjsolve.catalog.describe(told["subject"]).motions["default"].arguments
    return browser, hjsolve.solve(told["subject"]).motion(**start)


@pytest.mark.nightly
def test_point_and_numbers_are_those_of_the_engine_wherever_the_sliders_stand(other):
    page, base = other
    solution, rng = base.solution, np.random.default_rng(20)
    ranges = page.execute_script("return JSON.parse(document.getElementById('live-data').textContent).sliders")
    bounds = page.execute_script("return hjsolveLive.bounds")
    separated = solution.coordinates
    for _ in range(3):
        before = page.execute_script("return document.getElementById('live-orbit').toDataURL()")
        for k, fraction in enumerate(rng.random(len(ranges))):
            slide(page, k, fraction)
        values = dict(zip((s["name"] for s in ranges), page.execute_script("return hjsolveLive.settings")))
        assert page.execute_script("return document.getElementById('live-orbit').toDataURL()") != before
        rates = page.execute_script("return hjsolveLive.rates()")
        longest = 2 * math.pi / min(map(abs, rates))
        shown = page.execute_script(
            "return arguments[0].map((t) => hjsolveLive.state(t))", list(np.linspace(0.07, 1.95, 12) * longest)
        )
        moves = [min(abs(s["p"][n]) / max(abs(r["p"][n]) for r in shown) for n in separated) for s in shown[:6]]
        first = int(np.argmax(moves))  # where no coordinate turns: a place and constants tell the phase there
        motion = solution.motion(
            q={c.name: shown[first]["q"][c.name] if c.name in separated else 0 for c in solution.system.coordinates},
            constants={n: values.get(n, base.initial.constants[n]) for n in solution.constants},
            signs={n: int(np.sign(shown[first]["p"][n])) for n in separated},
            parameters={
                c.name: values.get(c.name, base.initial.values[c.symbol]) for c in solution.system.parameters
            },
        )  # fmt: skip
        state = motion.at((np.linspace(0.07, 1.95, 12) - np.linspace(0.07, 1.95, 12)[first]) * longest)
        for c in solution.system.coordinates:
            gained = np.array([s["q"][c.name] - shown[first]["q"][c.name] for s in shown])
            true = np.asarray(state.unwrapped(c.name), float)
            assert np.abs(gained - (true - true[first])).max() <= 2 * bounds[c.name]
        for n in separated:
            momenta = np.array([s["p"][n] for s in shown])
            assert np.abs(momenta - np.asarray(state.p[n], float)).max() <= 2 * bounds[f"p_{n}"]
        for name, rate in zip(separated, rates):
            assert abs(rate - motion.frequencies[name].value) <= 1e-3 * abs(rate)
    assert page.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert [e for e in page.get_log("browser") if e["level"] in {"SEVERE", "WARNING"}] == []


@pytest.mark.nightly
@pytest.mark.nightly_cases("spherical-pendulum")
def test_the_page_makes_sixty_frames_a_second(other):
    page, _ = other
    page.execute_script("document.getElementById('live').scrollIntoView()")
    spent = page.execute_script(
        "const begin = performance.now(); for (let k = 0; k < 60; k++) hjsolveLive.seek(k / 7);"
        "return (performance.now() - begin) / 60;"
    )
    print(f"{spent:.2f} ms a frame")
    assert spent < 16.7


@pytest.mark.nightly
def test_the_point_on_the_torus_goes_by_the_frequencies_of_the_engine(tmp_path_factory, browser):
    """Of the spherical pendulum: two frequencies; the page's angle variables against Ω (t − t₀)."""
    path = hjsolve.report("spherical-pendulum", tmp_path_factory.mktemp("torus") / "live.html", live=True, brief=True)
    browser.get(path.as_uri())
    momentum, energy = slide(browser, 0, 0.35)[0], slide(browser, 1, 0.7)[1]
    (low, high), bounds = browser.execute_script("return [hjsolveLive.ends().theta, hjsolveLive.bounds]")
    motion = hjsolve.solve("spherical-pendulum").motion(
        q={"theta": (low + high) / 2, "phi": 0}, constants={"E": energy, "p_phi": momentum},
        signs={"theta": 1},
    )  # fmt: skip
    T = motion.periods["theta"].value
    begin = browser.execute_script("return hjsolveLive.phases(0)")
    for fraction in (0.2, 0.9, 1.9):
        own, across = browser.execute_script("return hjsolveLive.phases(arguments[0])", fraction * T)
        assert abs(own - begin[0] - 2 * math.pi * fraction) <= 4 * bounds["theta"] / (high - low)
        assert abs(across - begin[1] - motion.frequencies["phi"].value * fraction * T) <= 2 * bounds["phi"]
    turned = [browser.execute_script("return document.getElementById('live-torus').toDataURL()")]
    browser.find_element("id", "live-torus").send_keys("\ue014" * 5)
    turned.append(browser.execute_script("return document.getElementById('live-torus').toDataURL()"))
    assert turned[0] != turned[1]
    assert [e for e in browser.get_log("browser") if e["level"] in {"SEVERE", "WARNING"}] == []
