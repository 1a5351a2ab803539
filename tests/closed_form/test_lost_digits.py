"""Where a form cancels in doubles its numbers keep their digits: the right values are made by mpmath, in 50 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.arithmetic.error_free import Pair
from hjsolve.closed_form.closed_forms import closed_forms
from hjsolve.closed_form.compiled_forms import CompiledRegime
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.programs import Program
from hjsolve.closed_form.two_arithmetics import PairsOfForms

_ULP = 2.0**-52


def _of_motion(entry: str, **numbers: float) -> RegimeForms:
    exact = {n: sp.Rational(v) for n, v in numbers.items()}
    return next(
        form
        for form in closed_forms(hjsolve.solve(entry))
        if not form.regime.special and form.regime.holds({s: exact[s.name] for s in form.regime.example})
    )


def test_a_turning_point_of_a_morse_potential_next_to_the_bottom() -> None:
    """Ln(1 ± √(E/D)) with E/D = 1e-9: 1e6 units of the last place were lost."""
    numbers = {"m": 1.0, "D": 3.0, "a": 0.75, "E": 3e-9}
    form = _of_motion("morse", **numbers)
    with mpmath.workdps(50):
        root = mpmath.sqrt(mpmath.mpf(3e-9) / 3)
        right = [-mpmath.log(1 + s * root) / mpmath.mpf(0.75) for s in (1, -1)]
    for side, there in zip(("lower", "upper"), right, strict=True):
        name = f"turning_points.x.{side}"
        made = form.lambdify("numpy")[name]
        value = float(made(**{n: v for n, v in numbers.items() if n in made.names}))
        np.testing.assert_allclose(value, float(there), rtol=4 * _ULP, atol=0)


@pytest.mark.parametrize("small", [1e-5, 1e-8])
def test_a_sum_that_cancels_is_taken_by_two_doubles(small: float) -> None:
    """Of x − sin x a part of x³ is left next to zero."""
    form = _of_motion("morse", m=1.0, D=3.0, a=0.75, E=1.0)
    E, D = (next(s for s in form.regime.example if s.name == n) for n in ("E", "D"))
    made = CompiledRegime(form, numpy=True).function((E / D - sp.sin(E / D)) * D)
    with mpmath.workdps(50):
        ratio = mpmath.mpf(small)
        there = ratio - mpmath.sin(ratio)
    value = float(made(E=small, D=1.0, m=1.0))
    np.testing.assert_allclose(value, float(there), rtol=4 * _ULP, atol=0)


@pytest.mark.parametrize(("name", "x"), [("asin", 1e-20), ("acos", 1e-20), ("acosh", -1e-20), ("atanh", 1e-20)])
def test_inverse_functions_next_to_one(name: str, x: float) -> None:
    found = PairsOfForms().unary(name, Pair(np.array([1.0]), np.array([-x])))
    with mpmath.workdps(60):
        there = getattr(mpmath, name)(1 - mpmath.mpf(x))
        value = mpmath.mpf(float(found.high[0])) + mpmath.mpf(float(found.low[0]))
        assert abs(value - there) <= 1e-28 * abs(there)


def test_angles_of_points_in_all_quadrants() -> None:
    y, x = sp.symbols("y x", real=True)
    program = Program(sp.atan2(y, x), {}, [y, x])
    angle = np.linspace(-3.1, 3.1, 25)
    points = [Pair(f(angle), np.zeros(25)) for f in (np.sin, np.cos)]
    found = program.run(PairsOfForms(), points)
    with mpmath.workdps(50):
        for k in range(25):
            there = mpmath.atan2(mpmath.mpf(float(points[0].high[k])), mpmath.mpf(float(points[1].high[k])))
            value = mpmath.mpf(float(found.high[k])) + mpmath.mpf(float(found.low[k]))
            assert abs(value - there) <= 1e-28 * abs(there)


@pytest.mark.parametrize("small", [1e-9, 1e-20])
@pytest.mark.parametrize("letter", ["m", "E"])
def test_a_sum_that_cancels_in_two_doubles_is_taken_in_digits_enough(letter: str, small: float) -> None:
    """Of exp x − 1 − x − x²/2 a part of x³ is left: 1e-28 with few digits in two doubles, 1e-61 with none in 50 digits.

    With E small the motion is next to a border of regimes, and two doubles are not asked.
    """
    form = _of_motion("morse", m=1.0, D=3.0, a=0.75, E=1.0)
    x = next(s for s in form.regime.example if s.name == letter)
    made = CompiledRegime(form, numpy=True).function(sp.exp(x) - 1 - x - x**2 / 2)
    with mpmath.workdps(200):
        X = mpmath.mpf(small)
        there = mpmath.exp(X) - 1 - X - X**2 / 2
    value = float(made(**{"E": 0.5, "D": 1.0, "m": 1.0, letter: small}))
    np.testing.assert_allclose(value, float(there), rtol=_ULP, atol=0)


@pytest.mark.nightly
def test_an_orbit_next_to_escape_in_prolate_coordinates() -> None:
    """With E = −1e−72 two doubles lose all digits of terms with 1/E; the right time is a quadrature in 60 digits."""
    solution = hjsolve.solve("kepler-prolate")
    numbers = {"m": 1.0, "a": 1.0, "k": 1.0, "E": -1e-72, "alpha_2": 2.82, "p_phi": -0.35, "phi": 0.0, "t_0": 0.0}
    numbers |= {"xi_0": 2.6, "xi": 3.5, "eta_0": 1.1, "eta": 1.3}
    form = next(f for f in closed_forms(solution, seconds=60.0) if not f.regime.special and "E < 0" in f.regime.words)
    equations = {"time_law": solution.time_law, "orbit_equations.alpha_2": solution.orbit_equations["alpha_2"]}
    for name, equation in equations.items():
        made = CompiledRegime(form, numpy=True).function(form.named()[name])
        value = float(made(**{n: numbers[n] for n in made.names if n in numbers}))
        np.testing.assert_allclose(value, float(_quadrature(equation.rhs, numbers)), rtol=2 * _ULP, atol=0)


def _quadrature(total: sp.Expr, numbers: dict[str, float]) -> mpmath.mpf:
    with mpmath.workdps(60):
        value = mpmath.mpf(0)
        for integral in total.atoms(sp.Integral):
            ((x, *ends),) = integral.limits
            plain = integral.function.xreplace(
                {s: sp.Rational(numbers[s.name]) for s in integral.function.free_symbols if s != x}
            )
            places = mpmath.linspace(*(mpmath.mpf(numbers[end.name]) for end in ends), 9)
            part = mpmath.quad(sp.lambdify(x, plain, "mpmath"), places)
            value += mpmath.mpf(int(sp.Poly(total, integral).coeff_monomial(integral))) * part
        return value
