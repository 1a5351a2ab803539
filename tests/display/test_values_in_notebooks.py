"""What a terminal and a notebook show of every public value: a few short lines, a piece of HTML that fetches nothing."""

from __future__ import annotations

import inspect
import re
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import sympy as sp

import hjsolve
from hjsolve.display.shown import MOST_LINES, WIDEST, Shown, brief
from tests.support.public_values import made, reached


@pytest.fixture(scope="module")
def values(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return dict(reached(made(tmp_path_factory.mktemp("sweep"))))


@pytest.mark.nightly
def test_one_value_of_every_public_class_is_looked_at(values: dict[str, Any]) -> None:
    classes = {
        value
        for name in hjsolve.__all__
        if inspect.isclass(value := getattr(hjsolve, name)) and not issubclass(value, Exception)
    } - {hjsolve.AnyMotion, hjsolve.Status}  # a protocol, and a number with a name
    assert not classes - {type(value) for value in values.values()} - {hjsolve.Batch}
    assert len({type(value) for value in values.values()}) > 45


@pytest.mark.nightly
def test_every_public_value_is_told_in_a_few_short_lines(values: dict[str, Any]) -> None:
    wrong = {}
    for path, value in values.items():
        lines = repr(value).splitlines()
        letters = max(map(len, lines))
        if len(lines) > MOST_LINES or letters > WIDEST or re.search(r"0x[0-9a-f]{6}|object at|<function", repr(value)):
            wrong[path] = (len(lines), letters, repr(value)[:200])
    assert not wrong


@pytest.mark.nightly
def test_every_value_has_html_of_its_own(values: dict[str, Any]) -> None:
    for path, value in values.items():
        if isinstance(value, Shown):
            text = value._repr_html_()
            ET.fromstring(text.replace("&nbsp;", " "))
            assert text.startswith('<div class="hjsolve">'), path
            assert not re.search(r"<script|src=|url\((?!#)|@import|<link", text), path
            assert "0x" not in text, path


def test_a_motion_shows_its_numbers_and_its_orbit() -> None:
    start = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}
    text = hjsolve.solve("kepler-planar").motion(**start)._repr_html_()
    assert "14.993320610381375" in text
    assert "<svg" in text
    assert "Orbit" in text


@pytest.mark.nightly
def test_a_verdict_is_told_in_its_first_sentence(values: dict[str, Any]) -> None:
    assert "Does not separate" in values["obstruction"]._repr_html_()
    assert "<strong>Separates</strong>" in values["separation"]._repr_html_()


def test_what_is_long_is_cut_and_counted() -> None:
    assert brief(tuple(range(100)), 80) == "(0, 1, 2, 3, 4, 5, … 100 in all)"
    assert len(brief("x" * 500, 40)) == 40
    assert brief({"r": hjsolve.Estimate(2.5, 1e-3)}, 40) == "{r: 2.5000(11)}"
    assert brief((sp.Rational(0.1), sp.Rational(1, 3), sp.Rational(1, 8)), 80) == "(0.1, 1/3, 1/8)"
    assert brief(sp.Rational(1, 10**9), 40) == "1/1000000000"
    assert brief(-2 + 3 / (1 + 3 * sp.cos(sp.Rational(0.3)) ** 2), 80) == "-2 + 3/(1 + 3*cos(0.3)**2)"
    assert brief(sp.sqrt(2) / 2, 40) == "sqrt(2)/2"
    x = sp.Symbol("x")
    assert brief((sp.Rational(-0.1), x + sp.Rational(0.3)), 80) == "(-0.1, x + 0.3)"
    assert brief(x**10001 / 16384, 40) == "x**10001/16384"
    assert brief(sp.Rational(10**400, 10**5 + 3), 40) == "1" + "0" * 37 + " …"
    assert brief(sp.Rational(5e-324), 40) == "5e-324"


@pytest.mark.parametrize("name", ["kepler-planar", "kerr", "top-of-nothing"])
def test_the_text_of_a_system_makes_it_again(name: str) -> None:
    functions: dict[str, Any] = {"functions": ["v1(x)", "v2(y)"], "title": 'It\'s "free"'}
    free = hjsolve.System({"x": "line", "y": "0 < y"}, "(dot(x)**2 + dot(y)**2)/2", "v1(x) + v2(y)", **functions)
    system = free if name == "top-of-nothing" else hjsolve.catalog.load(name)
    again = eval(repr(system), {"System": hjsolve.System})
    for part in ("kinetic", "potential", "title", "id", "relativity", "signature"):
        assert str(getattr(again, part)) == str(getattr(system, part))
    assert [c.name for c in again.coordinates] == [c.name for c in system.coordinates]


@pytest.mark.nightly
def test_maps_wavefronts_and_entries_are_shown_as_what_they_are(values: dict[str, Any]) -> None:
    for name in ("map", "fronts"):
        assert "<svg" in values[name]._repr_html_()
    assert "<math" in values["entry"]._repr_html_()
    assert re.search(r"±.* second<", values["in units"]._repr_html_())
