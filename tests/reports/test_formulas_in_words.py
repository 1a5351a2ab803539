"""Formulas inside sentences of a report are set as formulas; words, units, initials and regions of a map are not."""

import pytest

from hjsolve.reports.formulas.in_words import formulas_in_words
from hjsolve.reports.formulas.mathml import mathml_of
from hjsolve.reports.formulas.one_line_text import plain


def _marked(text):
    return "".join(piece if isinstance(piece, str) else f"⟦{plain(piece)}⟧" for piece in formulas_in_words(text))


@pytest.mark.parametrize(
    ("text", "marked"),
    [
        ("H(q, ∂W/∂q) = E identically in q", "⟦H (q, ∂W/∂q) = E⟧ identically in ⟦q⟧"),
        ("proved: t(r) is Kepler's equation", "proved: ⟦t (r)⟧ is Kepler's equation"),
        ("A lower limit q₀ is a simple zero of p².", "A lower limit ⟦q₀⟧ is a simple zero of ⟦p²⟧."),
        ("the parameter m = k², the square of k;", "the parameter ⟦m = k²⟧, the square of ⟦k⟧;"),
        ("With g = 9.81 m/s², 5 m", "With ⟦g = 9.81⟧ m/s², 5 m"),
        ("E. T. Whittaker, H. Goldstein and E. M. Lifshitz", "E. T. Whittaker, H. Goldstein and E. M. Lifshitz"),
        ("A: θ librates. B (see above)", "A: ⟦θ⟧ librates. B (see above)"),
        ("Ex 2-7, P4-8, C47; d'Alembert and (a, b)", "Ex 2-7, P4-8, C47; d'Alembert and (a, b)"),
    ],
)
def test_formulas_are_found_by_their_signs(text, marked):
    assert _marked(text) == marked


def test_a_sentence_with_derivatives_is_set_upright_and_in_italics():
    words, box = list(formulas_in_words("Since dq/dt = ∂H/∂p"))
    assert words == "Since "
    set_ = mathml_of(box)
    assert '<mi mathvariant="normal">d</mi><mi>q</mi>' in set_
    assert '<mo lspace="0" rspace="0">∂</mo><mi>H</mi>' in set_


def test_a_sign_after_an_equals_sign_belongs_to_its_term():
    (box,) = formulas_in_words("V = −k")
    assert '<mo form="prefix">−</mo>' in mathml_of(box)
    (box,) = formulas_in_words("V = E − k")
    assert "prefix" not in mathml_of(box)
