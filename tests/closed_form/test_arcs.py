"""Arcs by tangents in doubles: the same value everywhere, and all digits where the argument is next to 1."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.closed_form.arcs import arcs_by_tangents

r, p, E, k = sp.symbols("r p E k", positive=True)
KEPLER = (k * r - p**2) / (r * sp.sqrt(k**2 - 2 * E * p**2))
"""Of a nearly radial orbit next to 1."""


@pytest.mark.parametrize("arc", [sp.asin, sp.acos])
def test_arcs_of_a_nearly_radial_orbit_keep_their_digits(arc: type[sp.Function]) -> None:
    made = arcs_by_tangents(arc(KEPLER))
    for size in (1e-1, 1e-3, 1e-6):
        at = {r: 0.7, p: size, E: 0.5, k: 1.0}
        plain, better = (float(sp.lambdify([*at], e)(*at.values())) for e in (arc(KEPLER), made))
        right = sp.N(arc(KEPLER).subs({name: sp.Rational(value) for name, value in at.items()}), 40)
        assert abs(better - right) <= 4e-16 * max(abs(right), size)
        if size == 1e-6:
            assert abs(plain - right) > 1e-12


def test_hyperbolic_arcs() -> None:
    x = (2 * E * r + k) / sp.sqrt(k**2 + 2 * E * p**2)
    made = arcs_by_tangents(sp.acosh(x))
    assert made.has(sp.asinh)
    at = {r: sp.Rational(1, 7), p: sp.Rational(1, 9), E: 2, k: 3}
    assert abs(sp.N((made - sp.acosh(x)).subs(at), 40)) < sp.Float("1e-35")


@pytest.mark.parametrize("text", ["asin(x**3 + a*x + b)", "acos(sqrt(a) + sqrt(b)*c)", "acosh(2 + sqrt(a + c*x))"])
def test_other_arcs_keep_their_value(text: str) -> None:
    plain = sp.sympify(text)
    numbers = dict(zip(sp.symbols("a b c x"), (sp.Rational(k, 10) for k in (1, 2, 3, 4)), strict=True))
    assert abs(sp.N((arcs_by_tangents(plain) - plain).subs(numbers), 30)) < sp.Float("1e-25")


def test_arcs_of_numbers_and_long_arcs_are_left() -> None:
    names = sp.symbols("a:30", positive=True)
    for plain in (sp.asin(sp.Rational(1, 3)), sp.asin(sp.Add(*(a**3 for a in names)))):
        assert arcs_by_tangents(plain) == plain


def test_the_apsidal_angle_of_a_nearly_radial_ellipse() -> None:
    form = hjsolve.closed_forms("kepler-planar")[0]
    function = form.lambdify("numpy")["orbit_equations.p_theta"]
    given = {"E": -0.5, "p_theta": 1e-5, "k": 1.0, "m": 1.0, "r": 1.2, "r_0": 0.4, "theta": 0.0}
    right = form.evaluate("orbit_equations.p_theta", {n: repr(v) for n, v in given.items()}, 30).value
    got = function(**{n: np.array([v]) for n, v in given.items()})[0]
    assert abs(got - right) <= 4e-16  # of a radian: both arcs are about π/2


def test_the_characteristic_function_next_to_a_turning_point() -> None:
    """W = ½ q p − (α/2√E) arcosh(q√E/√α) varies as p³ there, each term as p: they round the same p."""
    form = hjsolve.closed_forms("liouville-p5-6")[0]
    W = form.lambdify("numpy")["characteristic_function"]
    at = {"K": 1.0, "q1": 27.943417168044412, "q2": -0.8350361672715274, "E": 0.0012837494537290511,
          "alpha_2": 0.002393925574913237, "q1_0": 27.943396593595725, "q2_0": -2.1026409980558824}  # fmt: skip
    right = form.evaluate("characteristic_function", {n: sp.Rational(v) for n, v in at.items()}, 25).value
    assert abs(float(W(**at)) - right) <= 1e-15  # 1.3e-12 with each rounding its own
