"""The section of closed forms: what is shown, what is too long, what there was no time for."""

from __future__ import annotations

import pytest

import hjsolve
from hjsolve.reports.document import Section
from hjsolve.reports.formats.text import text_page
from hjsolve.reports.sections import closed_forms
from hjsolve.reports.sections.closed_forms import closed_form_report
from tests.support.reports import report_of


def _motion(name: str) -> hjsolve.Motion:
    return hjsolve.solve(name).motion(**hjsolve.catalog.describe(name).motions["default"].arguments)


def _text(sections: list[Section]) -> str:
    return " ".join(map(str, sections))


def test_the_motions_own_regime_is_shown_after_its_integrals() -> None:
    page = text_page(report_of("kepler-planar"))
    assert page.index("Time law") < page.index("Closed forms") < page.index("E < 0") < page.index("Kepler's equation")
    assert "hjsolve solve kepler-planar --closed" in page.replace("\n", " ")


def test_a_solution_without_a_motion_shows_its_first_regimes() -> None:
    found = closed_form_report(hjsolve.solve("harmonic-oscillator"))
    assert [section.key for section in found] == ["closed-forms"]
    assert "first regimes" in _text(found)


def test_what_is_too_long_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closed_forms, "LONGEST_SHOWN", 5)
    assert "take more than a page" in _text(closed_form_report(_motion("harmonic-oscillator")))


@pytest.mark.nightly
def test_a_report_does_not_wait_for_long_derivations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(closed_forms, "SECONDS", 0.05)
    assert "took longer than 0.05 s" in _text(closed_form_report(_motion("kepler-prolate")))


def test_a_system_with_nothing_to_integrate_has_no_section() -> None:
    assert closed_form_report(hjsolve.solve("free-particle")) == []
