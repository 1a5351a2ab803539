"""Questions of the page: what follows from them is what the public verbs give, and what is wrong is reported in a line."""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import replace

import pytest

import hjsolve
from hjsolve.explorer.answering import answer_question, scene_text, typed_system
from hjsolve.explorer.first_question import question_about
from hjsolve.explorer.question import Drag, PageQuestion
from hjsolve.explorer.whole_system import unfinished


def test_an_entry_is_answered_with_verdict_numbers_and_a_plane_to_drag_in() -> None:
    told = answer_question(question_about("kepler-planar"))

    assert told.verdict == "yes"
    assert not told.problem
    assert told.coordinates == ("r", "theta")
    assert [p.name for p in told.portraits] == ["r"]
    period = (
        hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}).periods["r"]
    )
    assert f"{period.value:.12f}"[:12] in told.numbers


@pytest.mark.nightly_cases("kerr")
@pytest.mark.parametrize("name", ["spherical-pendulum", "kerr", "relativistic-kepler", "lagrange-top", "henon-heiles"])
def test_what_an_entry_says_is_the_system_of_the_entry(name: str) -> None:
    question = question_about(name)

    read = typed_system(question)
    entry = hjsolve.catalog.load(name)
    assert without_words(read) == without_words(entry)
    assert answer_question(question).verdict in {"yes", "no"}


def without_words(system: hjsolve.System) -> hjsolve.System:
    table = hjsolve.catalog.table_of(system)
    for part in (*table["coordinates"], *table["parameters"]):
        part.pop("unit", None), part.pop("meaning", None)
    table.pop("title", None), table.pop("id", None), table.pop("units", None)
    return hjsolve.catalog.from_table(table)


def test_a_drag_changes_one_momentum_and_keeps_the_others() -> None:
    question = question_about("lagrange-top")
    solution = hjsolve.solve("lagrange-top")
    before = solution.motion(q=question.q, velocity=question.velocity).at(0)

    dragged = answer_question(replace(question, drag=Drag("theta", 0.7, 0.25)))

    after = solution.motion(q=dragged.q, velocity=dragged.velocity).at(0)
    assert dragged.q["theta"] == "0.7"
    assert float(after.p["theta"]) == pytest.approx(0.25, rel=1e-11)
    for name in ("phi", "psi"):
        assert float(after.p[name]) == pytest.approx(float(before.p[name]), rel=1e-11)


def test_the_pixel_under_the_start_is_the_start() -> None:
    portrait = answer_question(question_about("kepler-planar")).portraits[0]
    left, right, top, bottom = portrait.box
    x = left + (1 - portrait.q[0]) / (portrait.q[1] - portrait.q[0]) * (right - left)
    y = bottom - (0 - portrait.p[0]) / (portrait.p[1] - portrait.p[0]) * (bottom - top)

    assert portrait.at(x, y) == pytest.approx((1.0, 0.0))
    assert f'cx="{x:.1f}'[:8] in portrait.svg
    assert portrait.at(-1e9, 1e9) == pytest.approx((portrait.q[0], portrait.p[0]))


def test_a_refused_system_shows_its_obstruction_and_coordinates_are_found_when_asked() -> None:
    stark = PageQuestion(
        "x: line; y: line", "(dot(x)**2 + dot(y)**2)/2", "-1/sqrt(x**2 + y**2) + y/20",
        q={"x": "1", "y": "0.1"}, velocity={"x": "0", "y": "0.9"},
    )  # fmt: skip

    plain, found = answer_question(stark), answer_question(replace(stark, find=True))

    assert plain.verdict == "no"
    assert plain.details
    assert not plain.numbers
    assert found.verdict == "yes"
    assert found.numbers
    assert found.portraits


def test_a_system_that_separates_nowhere_says_so_and_shows_its_motion() -> None:
    quartic = PageQuestion(
        "x: line; y: line", "(x'^2 + y'^2)/2", "k/2*(x^2 + y^2) + c*x^2*y^2", "k = 1; c = 1",
        q={"x": "0.5", "y": "0.3"}, velocity={"x": "0", "y": "0.1"}, find=True,
    )  # fmt: skip

    told, asked_less = answer_question(quartic), answer_question(replace(quartic, find=False))
    at_rest = answer_question(replace(quartic, q={"x": "", "y": ""}, velocity={"x": "", "y": ""}))

    assert told.verdict == "no"
    assert "none found" in told.lead
    assert "none found" not in asked_less.lead
    assert "<svg" in told.drawings
    assert "integrated numerically" in told.drawings
    assert not told.problem
    assert at_rest.drawings == at_rest.problem == ""


def test_a_motion_of_more_than_two_coordinates_that_is_refused_is_not_drawn_and_that_is_said() -> None:
    told = answer_question(PageQuestion(
        "x: line; y: line; z: line", "(x'^2 + y'^2 + z'^2)/2", "x^2*y^2*z^2 + x*y + x^4*z^2",
        q={"x": "1", "y": "0", "z": "0"}, velocity={"x": "0", "y": "1", "z": "0"},
    ))  # fmt: skip

    assert told.verdict == "no"
    assert "two coordinates" in told.drawings
    assert "<svg" not in told.drawings


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"potential": "__import__('os')"}, "potential"),
        ({"potential": "x*"}, "ends too early"),
        ({"potential": "y"}, "not declared"),
        ({"potential": "x" * 5000}, "at most 4000 letters"),
        ({"coordinates": "x"}, "a name, a colon and a domain"),
        ({"parameters": "k == 2"}, "parameter"),
        ({"q": {"x": "a"}}, "x"),
        ({"velocity": {"x": ""}}, "x"),
        ({"kinetic": "<img src=x onerror=alert(1)>"}, "kinetic"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(changed: dict[str, object], words: str) -> None:
    told = answer_question(replace(question_about(None), **changed))

    assert words in told.problem
    assert "\n" not in told.problem


@pytest.mark.nightly_cases("kerr")
@pytest.mark.parametrize("name", [None, "kepler-planar", "kerr", "two-centres-plane"])
def test_a_scene_taken_away_runs_to_the_same_numbers(name: str | None, tmp_path) -> None:
    if name is not None and name not in hjsolve.catalog.ids():
        pytest.skip("no such entry")
    question = question_about(name)
    path = tmp_path / "scene.toml"
    path.write_text(scene_text(question, typed_system(question)), encoding="utf-8")

    constants = hjsolve.Scene.load(path).run().quantity("constants")

    assert question_about(path).q == question.q
    motion = hjsolve.solve(typed_system(question)).motion(q=question.q, velocity=question.velocity)
    for key, estimate in motion.constants.items():
        assert abs(float(constants[key].value) - float(estimate.value)) <= estimate.error + constants[key].error


def test_a_report_is_a_whole_page() -> None:
    text = answer_question(replace(question_about("pendulum"), wanted="report")).file

    assert text.startswith(("<!DOCTYPE html>", "<!doctype html>"))
    assert "</html>" in text


KEPLER = PageQuestion(
    "r: 0 < r\nphi: angle", "m*(dot(r)**2 + r**2*dot(phi)**2)/2", "-k/r", "m = 1 : positive\nk = 1 : positive"
)


@pytest.mark.parametrize(("typed", "words"), [
    (replace(KEPLER, parameters=""), ("T uses m", "V uses k")),
    (replace(KEPLER, parameters="m = 1"), ("V uses k",)),
    (replace(KEPLER, coordinates=""), ("the coordinates are missing", "T uses dot(phi)")),
    (replace(KEPLER, coordinates="r: a < r\nphi: angle"), ("the domain of r uses a",)),
    (replace(KEPLER, kinetic="m*dot(r)**2/2"), ("dot(phi) does not occur in T",)),
    (replace(KEPLER, kinetic="m*phidot**2/2"), ("dot(r) does not occur in T",)),
    (replace(KEPLER, kinetic=""), ("T is missing",)),
])  # fmt: skip
def test_what_other_boxes_may_still_bring_is_no_fault_until_the_whole_is_submitted(typed, words) -> None:
    told = answer_question(replace(typed, submitted=False))
    assert not told.problem
    assert told.unfinished.startswith("Not complete yet: ")
    assert all(word in told.unfinished for word in words)
    whole = answer_question(typed)
    assert whole.problem
    assert not whole.unfinished
    if len(words) > 1:
        assert all(word in whole.problem for word in words)


@pytest.mark.parametrize(("typed", "message"), [
    (replace(KEPLER, kinetic="m*(dot(r)**2", parameters=""), "kinetic"),
    (replace(KEPLER, potential="-k/r + Pi", parameters=""), "write pi"),
    (replace(KEPLER, parameters="m = 1 : posi"), "posi"),
    (replace(KEPLER, coordinates="r"), "write a name, a colon and a domain"),
])  # fmt: skip
def test_a_fault_of_one_box_is_named_while_the_rest_is_still_missing(typed, message: str) -> None:
    told = answer_question(replace(typed, submitted=False))
    assert message in told.problem
    assert not told.unfinished


def test_each_entry_is_complete_and_goes_through_a_link() -> None:
    for name in ("kepler-planar", "relativistic-kepler", "lagrange-top"):
        question = question_about(name)
        assert unfinished(question) == ()
        again = PageQuestion.from_fragment("#" + question.fragment())
        assert typed_system(again) == typed_system(question)
        assert (again.q, again.velocity, again.title) == (question.q, question.velocity, question.title)


def test_a_start_that_was_typed_for_other_coordinates_is_none_of_these() -> None:
    told = answer_question(replace(KEPLER, q={"x": "1"}, velocity={"x": "0"}))
    assert (told.verdict, told.problem) == ("yes", "")
    assert told.q == {"r": "", "phi": ""}


def packed(value: object) -> str:
    return base64.urlsafe_b64encode(zlib.compress(json.dumps(value).encode())).decode()


@pytest.mark.parametrize("fragment", [
    "x", "####", KEPLER.fragment()[:-9], packed([1]), packed({"wanted": "report"}), packed({"kinetic": 3}),
    packed({"q": {"r": 1}}), packed({"find": "yes"}), packed({"title": "x" * 100_000}), "A" * 9000,
])  # fmt: skip
def test_a_link_that_is_cut_or_holds_anything_else_is_refused(fragment: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match="link"):
        PageQuestion.from_fragment(fragment)
