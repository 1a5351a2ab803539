"""One square root of a wave in p²: the variables in which it is rational, and the genus that they prove."""

from __future__ import annotations

import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.involutions import why_no_curve
from hjsolve.closed_form.root_of_a_wave import conic_variables
from hjsolve.closed_form.why_not import Contains, HighGenus, NotFound, OfCoordinate
from hjsolve.mechanics.coordinates_and_parameters import Coordinate

E, k, a, b = sp.symbols("E k a b", positive=True)
x = sp.Symbol("x", real=True)


def _coordinate() -> Coordinate:
    return hjsolve.solve("pendulum").system.coordinate("theta")


q = _coordinate().symbol


@pytest.mark.parametrize("square", [
    2 * E + k * sp.sqrt(a + b * sp.cosh(2 * q) ** 2) + sp.sinh(2 * q) ** 2, E - k * sp.sqrt(a + b * sp.sin(q) ** 2),
    E * sp.cos(q) + sp.sqrt(a + b * sp.cos(q) ** 2) - sp.sin(q) ** 4, E + sp.sinh(q) * sp.sqrt(a + b * sp.sinh(q) ** 2),
    E - k / sp.sqrt(a + b * sp.sinh(q) ** 2) / sp.cosh(q) ** 2,
])  # fmt: skip
def test_variables_are_what_they_say(square: sp.Expr) -> None:
    (found,) = conic_variables(square, q, x)
    numbers = {E: sp.Rational(9, 7), k: sp.Rational(5, 3), a: sp.Rational(4, 5), b: sp.Rational(11, 8)}
    assert found.function.is_rational_function(x)
    assert found.slope_squared.is_rational_function(x)
    for there in (sp.Rational(2, 7), sp.Rational(-5, 4)):
        place = found.place.xreplace(numbers).subs(q, there)
        slope = sp.diff(found.place, q).xreplace(numbers).subs(q, there)
        function, squared = (e.xreplace(numbers).subs(x, place) for e in (found.function, found.slope_squared))
        assert abs(sp.N(function - square.xreplace(numbers).subs(q, there), 30)) < sp.Float("1e-25")
        assert abs(sp.N(squared - slope**2, 30)) < sp.Float("1e-25")


def test_two_roots_and_two_arguments_are_left() -> None:
    for square in (
        sp.sqrt(a + sp.cos(q) ** 2) + sp.sqrt(b + sp.cos(q) ** 2), sp.sqrt(a + sp.cos(q) ** 2) + sp.cos(2 * q),
        sp.sqrt(a + sp.cos(q) ** 3) + E, sp.sqrt(a + b * sp.cos(q) ** 2) * sp.sin(q), sp.sqrt(a + q**2) + sp.cos(q),
    ):  # fmt: skip
        assert list(conic_variables(square, q, x)) == []


@pytest.mark.parametrize(("entry", "genus"), [("kuzmin-kutuzov", 2), ("a-frame", 6)])
def test_entries_without_a_form_have_a_proof(entry: str, genus: int) -> None:
    form = hjsolve.closed_forms(entry)[0]
    inverses = [name for name in form.why_not if name.startswith("inverse.")]
    assert inverses
    for name in ("time_law", *inverses):  # q(t) has none for the same reason, and says so
        why = form.why_not[name]
        why = why.reason if isinstance(why, Contains) else why
        assert isinstance(why, OfCoordinate)
        assert isinstance(why.reason, HighGenus)
        assert why.reason.genus == genus
        assert why.proved
        assert why.holds()


def test_what_is_elementary_in_the_variable_is_not_proved_to_have_no_form() -> None:
    root = sp.sqrt(a + b * sp.cos(q) ** 2)
    square = (E + k * root) * root**2 / (sp.cos(q) ** 2 * sp.sin(q) ** 2)  # y² = (E + kx) x b²/b² …
    assert isinstance(why_no_curve(square, [sp.S.One], _coordinate()), NotFound)
