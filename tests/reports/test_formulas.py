"""Formulas look as in the mechanics books, in every format, and lose nothing."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from hjsolve.reports.formulas.from_sympy import box, constants_outside
from hjsolve.reports.formulas.latex import latex_of
from hjsolve.reports.formulas.layout import Glyph, Grid, width
from hjsolve.reports.formulas.line_breaks import display, narrowed
from hjsolve.reports.formulas.mathml import mathml_of
from hjsolve.reports.formulas.names import name_box
from hjsolve.reports.formulas.one_line_text import plain

r, θ, m, k, E = sp.Symbol("r", positive=True), sp.Symbol("theta", real=True), *sp.symbols("m k E")
pr, pθ, vr, t = sp.symbols("p_r p_theta dot(r) t")


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (m * vr**2 / 2, "½ m ṙ²"),
        (-k / r, "−k/r"),
        (pr**2 / (2 * m) - k / r, "pᵣ²/(2 m) − k/r"),
        (sp.sqrt(2 * m * E + 2 * m * k / r), "√(2 m E + 2 m k/r)"),
        (sp.sin(θ) ** 2, "sin² θ"),
        (sp.sin(2 * θ), "sin(2 θ)"),
        (1 / sp.sin(θ) ** 2, "1/sin² θ"),
        (sp.Symbol("alpha_2") ** 2, "α₂²"),
        (sp.Symbol("omega0"), "ω₀"),
        (sp.Symbol("lambda_"), "λ"),
        (pθ * θ, "p_θ θ"),
        (sp.exp(-r / k), "exp(−r/k)"),
        (r ** sp.Rational(3, 2), "r^(3/2)"),
        (3 * 2**r, "3⋅2^r"),
        (k * (1 - r), "k (1 − r)"),
        (-(1 - r) / k, "(r − 1)/k"),
        (sp.log(r), "ln r"),
        (sp.Abs(r - k), "|k − r|"),
        (sp.Derivative(sp.Function("W")(r, θ), r), "∂W(r, θ)/∂r"),
        (sp.Eq(E, m * r), "E = m r"),
        (sp.pi / 2, "π/2"),
        (sp.Float("0.5"), "0.5"),
        (sp.Float("1.5e-20"), "1.5×10⁻²⁰"),
        (-sp.oo, "−∞"),
        (sp.Matrix([[m, 0], [0, 1]]), "[m, 0; 0, 1]"),
        (sp.sqrt(2) * sp.sqrt(E) / sp.sqrt(k), "√(2 E/k)"),
        (sp.sqrt(2) * sp.sqrt(k) * r / (2 * sp.sqrt(m)), "r √(k/(2 m))"),
        (sp.sqrt(2) / (2 * sp.sqrt(m) * sp.sqrt(k)), "1/√(2 m k)"),
        (sp.sqrt(6) / 12, "√6/12"),
        (r / (sp.sqrt(m) * sp.sqrt(k)), "r/√(m k)"),
        (sp.sqrt(2) * r * sp.sqrt(-E), "r √(−2 E)"),
        (sp.sqrt(1 + 2 * E * pθ**2 / (m * k**2)), "√(1 + 2 E p_θ²/(m k²))"),
        (r - k * t**2 / 2 + m * t, "r + m t − ½ k t²"),
        (sp.sin(2 * θ) * (k - r), "(k − r) sin(2 θ)"),
        (sp.sin(θ) * (k - r), "sin(θ) (k − r)"),
        (r * sp.sign(pθ) * (k - r), "r (k − r) sgn p_θ"),
    ],
)
def test_a_formula_reads_like_the_book(expression: sp.Basic, expected: str) -> None:
    assert plain(box(expression)) == expected


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        (-k / r, r"-\frac{k}{r}"),
        (sp.sqrt(r), r"\sqrt{r}"),
        (θ * k, r"k\theta"),
        (sp.sin(θ) * k, r"k\,\sin\theta"),
        (sp.log(r), r"\ln r"),
        (vr**2, r"\dot{r}^{2}"),
        (pθ, r"p_{\theta}"),
    ],
)
def test_latex_keeps_control_words_apart(expression: sp.Basic, expected: str) -> None:
    assert latex_of(box(expression)) == expected


def test_mathml_has_stretchy_fences_and_no_elements_that_browsers_dropped() -> None:
    text = mathml_of(
        display(sp.Eq(sp.Symbol("W"), sp.Integral(sp.sqrt(2 * m * E + k / r), (r, sp.Symbol("r_0"), r)))), block=True
    )
    root = ET.fromstring(text)
    names = {element.tag.rpartition("}")[2] for element in root.iter()}
    assert names <= {
        "math",
        "mrow",
        "mi",
        "mn",
        "mo",
        "msqrt",
        "mfrac",
        "msup",
        "msub",
        "msubsup",
        "mover",
        "mspace",
        "mtable",
        "mtr",
        "mtd",
    }
    assert root.get("aria-label") == "W = ∫[r₀, r] √(2 m E + k/r) dr"


def test_a_name_that_is_markup_is_escaped() -> None:
    text = mathml_of(Glyph("<script>&", "text"))
    assert "<script>" not in text
    assert ET.fromstring(text) is not None


def test_a_sum_before_an_integral_keeps_its_parentheses() -> None:
    """A factor a − b before ∫ is one factor, with or without numbers next to it."""
    integral = sp.Integral(r, (r, sp.Symbol("r_0"), r))
    for factor in (m - k, 5 * sp.sqrt(26) - 63, 3 * (m - k)):
        assert "(" in plain(box(factor * integral)).split("∫")[0], factor


def test_constants_come_out_of_integrals_and_the_value_stays() -> None:
    integral = sp.Integral(-k * m * r / sp.sqrt(E), (r, 0, 1))
    tidied = constants_outside(integral)
    assert tidied.doit() == integral.doit()
    assert tidied == -k * m / sp.sqrt(E) * sp.Integral(r, (r, 0, 1))


def test_a_long_equation_is_set_on_several_lines_with_every_term() -> None:
    terms = [sp.Symbol(f"a{i}") * sp.cos(i * θ) for i in range(1, 30)]
    shown = display(sp.Eq(sp.Symbol("W"), sp.Add(*terms)))
    assert isinstance(shown, Grid)
    assert len(shown.rows) > 2
    assert plain(shown).count("cos") == 29
    assert max(sum(map(width, row)) for row in shown.rows) < 90


symbols = st.sampled_from([r, θ, m, k, E, pr, pθ, vr, sp.Symbol("alpha_2"), sp.Symbol("x1")])
numbers = st.fractions(min_value=-20, max_value=20, max_denominator=9).map(
    lambda q: sp.Rational(q.numerator, q.denominator)
)
functions = st.sampled_from(
    [sp.sin, sp.exp, sp.log, lambda e: sp.sqrt(e**2 + 1), lambda e: 1 / e, lambda e: e**2, sp.sqrt]
)
atoms = symbols | st.tuples(functions, symbols).map(lambda pair: pair[0](pair[1]))
expressions = st.recursive(
    atoms | numbers,
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda pair: pair[0] + pair[1]),
        st.tuples(inner, inner).map(lambda pair: pair[0] * pair[1]),
        st.tuples(functions, atoms, numbers).map(lambda triple: triple[0](triple[1] + triple[2])),
        st.tuples(inner, atoms, numbers).map(lambda triple: triple[0] / (triple[1] + triple[2])),
    ),
    max_leaves=8,
)  # numbers stay outside functions: towers of exponentials are sympy's to evaluate, and take for ever


@given(expressions)
def test_every_expression_is_well_formed_in_every_format(expression: sp.Expr) -> None:
    shown = box(expression)
    ET.fromstring(mathml_of(shown))
    text, code = plain(shown), latex_of(shown)
    assert text
    assert code.count("{") == code.count("}")
    assert code.count(r"\left") == code.count(r"\right")
    for symbol in expression.free_symbols:
        assert plain(name_box(symbol.name)) in text


@given(st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,12}", fullmatch=True))
def test_every_name_has_a_box(name: str) -> None:
    ET.fromstring(mathml_of(name_box(name)))
    assert plain(name_box(name))


@pytest.mark.parametrize("line", [34.0, 20.0])
def test_a_formula_that_was_broken_is_broken_anew_for_shorter_lines_and_keeps_every_letter(line: float) -> None:
    x = sp.Symbol("x")
    sums = sp.Add(*(sp.Symbol(f"a_{i}") * x**i for i in range(12)), evaluate=False)
    for whole in (sp.Eq(sp.Symbol("W"), sums, evaluate=False), sums, sp.Eq(sums, sums + 1, evaluate=False)):
        wide = display(whole)
        shown = narrowed(wide, line)
        assert width(shown) < max(width(wide), line)
        letters = lambda box: sorted(re.findall(r">([^<>]+)<", mathml_of(box)))  # noqa: E731
        assert letters(shown) == letters(wide)
