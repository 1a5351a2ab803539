"""Letters for sums that come again and again."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import sympy as sp

from hjsolve.reports.document import Document
from hjsolve.reports.formats.html import html_page
from hjsolve.reports.formats.latex_document import tex
from hjsolve.reports.formats.text import text_page
from hjsolve.reports.formulas.abbreviations import abbreviated, abbreviating, letters_for_sums
from hjsolve.reports.formulas.from_sympy import box, constants_outside
from hjsolve.reports.formulas.one_line_text import plain
from tests.support.reports import report_of

r, θ, a, M, v = sp.symbols("r theta a M v", real=True)
Σ, Δ = r**2 + a**2 * sp.cos(θ) ** 2, r**2 - 2 * M * r + a**2


def test_kerrs_sums_are_found_with_their_signs_and_factors() -> None:
    shown = [v**2 * Σ / Δ + v * (Σ / 2) + sp.sqrt(Σ) * Δ**2 + sp.exp(Σ), Σ / (-Δ) + 1 / Δ + (3 * Δ) ** 2 + v * Σ]
    table = letters_for_sums(shown, [r, θ], [a, M])
    assert {letter.name: sp.expand(e) for e, letter in table.items()} == {"Sigma": sp.expand(Σ), "Delta": sp.expand(Δ)}
    letters = {letter.name: letter for letter in table.values()}
    with abbreviating(table):
        for e in shown:
            short = abbreviated(e)
            assert not short.has(sp.cos)
            back = short.xreplace({letters["Sigma"]: Σ, letters["Delta"]: Δ})
            assert sp.simplify(back - e) == 0
        assert plain(box(1 / (2 * M * r - a**2 - r**2))) == "−1/Δ"
    assert "Δ" not in plain(box(1 / Δ))  # outside nothing is abbreviated


def test_what_comes_seldom_or_is_short_or_has_its_letter_taken_stays() -> None:
    assert letters_for_sums([Σ**2, Σ], [r, θ], [a, M]) == {}
    assert letters_for_sums([(r + a) ** k for k in range(2, 9)], [r, θ], [a, M]) == {}
    taken = sp.Symbol("Delta", real=True)
    assert letters_for_sums([taken * Δ**k for k in range(2, 9)], [r, θ], [a, M]) == {}
    assert letters_for_sums([Σ**k * v for k in range(2, 9)], [r, θ], [a]) != {}
    assert letters_for_sums([Σ**k * v for k in range(2, 9)], [r, θ], []) == {}  # a may not stand in it


def test_a_letter_stays_under_the_integral_over_what_it_contains_and_gives_no_double_sign() -> None:
    table = letters_for_sums([Δ**k * v for k in range(2, 9)], [r, θ], [a, M])
    lower = sp.Symbol("r_0")
    with abbreviating(table):
        assert plain(box(constants_outside(v - sp.Integral(3 * r / Δ, (r, lower, r))))) == "v − 3 ∫[r₀, r] r/Δ dr"
        assert plain(box(v - sp.Integral(r / (-Δ), (r, lower, r)))) == "v + ∫[r₀, r] r/Δ dr"
        assert "Δ" not in plain(box(sp.Derivative(v * Δ**2, r)))


@pytest.mark.parametrize(("written", "sum_"), [(text_page, "Σ = "), (tex, r"\Sigma="), (html_page, ">Σ<")])
def test_kerrs_report_defines_its_letters_once(written: Callable[[Document], str], sum_: str) -> None:
    text = written(report_of("kerr", brief=True))
    assert sum_ in text.replace("\n", "")
    assert text.count("in everything that follows") == 1
