"""A function of another program was taken for one left undetermined, and an index below the line was told as that of x."""

import pytest

import hjsolve
from hjsolve.errors import ExpressionError


def refusal(potential: str) -> str:
    with pytest.raises(ExpressionError) as caught:
        hjsolve.System({"x": "line"}, "dot(x)**2/2", potential)
    return str(caught.value)


@pytest.mark.parametrize(
    ("potential", "advice"),
    [
        ("Heaviside(x)", "give each side its own domain"),
        ("max(x, 0)", "give each side its own domain"),
        ("erf(x)", "only elementary functions are accepted"),
        ("interp(x)", "a table is not accepted"),
    ],
)
def test_functions_of_other_programs_are_not_advised_to_be_left_undetermined(potential: str, advice: str) -> None:
    """Declared undetermined, erf(x) would be any function of x, and no result could be computed."""
    said = refusal(potential)
    assert advice in said
    assert "undetermined" not in said


def test_a_name_nobody_knows_may_still_be_left_undetermined() -> None:
    assert 'functions=["v1(x)"]' in refusal("v1(x)")


@pytest.mark.parametrize(("potential", "name"), [("ω₀*x**2", "ω0"), ("k₁*x", "k1"), ("m_a₂*x", "m_a2"), ("₃", "x3")])
def test_an_index_below_the_line_is_told_with_its_own_name(potential: str, name: str) -> None:
    assert f"part of the name, {name} " in refusal(potential)


def test_a_forgotten_gamma_is_not_taken_for_eulers_function() -> None:
    assert "elementary" not in refusal("gamma*x")
