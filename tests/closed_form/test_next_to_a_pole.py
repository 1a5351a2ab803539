"""Turning points next to a pole: cos θ is next to ±1 where p_φ is small, and θ in doubles keeps all its digits.

50 digits say what θ is. The printed form stays arccos of the root.
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.complements import ForDoubles
from hjsolve.closed_form.forms import RegimeForms
from tests.support.entries import forms

ENTRIES = ["kerr", "two-centres-space", "kepler-prolate", "schwarzschild", "spherical-pendulum", "sphere-geodesics",
           "kepler-spherical", "charge-in-monopole-field", "rod-spherical-pendulum", "vinti"]  # fmt: skip
SMALLER = [1, 1e-1, 1e-2, 1e-4, 1e-6, 1e-8]
ULP = 2.0**-52


def _near_the_pole(form: RegimeForms, part: float) -> dict[str, sp.Rational] | None:
    """The motion of the regime with a part of its p_φ, in doubles; None where it is not of the regime."""
    at = {s.name: sp.Rational(float(v)) for s, v in form.regime.example.items()}
    at["p_phi"] = sp.Rational(float(at["p_phi"]) * part)
    return at if form.regime.holds({s: at[s.name] for s in form.regime.example}) else None


def _turning_points(form: RegimeForms) -> list[str]:
    angles = {c.name for c in form.solution.system.coordinates if c.domain.kind != "line"}
    return [n for n in form.named() if n.startswith("turning_points.") and n.split(".")[1] in angles]


@pytest.mark.nightly_cases("kerr", "two-centres-space", "kepler-prolate", "schwarzschild", "vinti")
@pytest.mark.parametrize("entry", ENTRIES)
def test_turning_points_next_to_a_pole_have_all_their_digits(entry: str) -> None:
    compared = 0
    for form in forms(entry):
        if form.regime.special or not any(s.name == "p_phi" for s in form.regime.example):
            continue
        motions = [at for part in SMALLER if (at := _near_the_pole(form, part)) is not None]
        functions = form.lambdify("numpy")
        for name in _turning_points(form):
            function = functions[name]
            got = function(**{n: np.array([float(at[n]) for at in motions]) for n in function.names})
            for value, at in zip(got, motions, strict=True):
                truth = form.evaluate(name, {n: str(v) for n, v in at.items()}, 50).value
                with mpmath.workdps(50):
                    off = abs(mpmath.mpf(float(value)) - truth) / abs(truth)
                assert off <= 8 * ULP, (form.regime.words, name, at)
                compared += 1
    assert compared >= 4


def test_a_root_in_radicals_is_divided_out_of_its_distance_from_one() -> None:
    # x² = (u + √D)/v with 1 − x² = 1e-30, as cos² θ of Kerr's field for a small p_φ
    u, p = sp.symbols("u p", real=True)
    x = sp.Symbol("x_1", positive=True)
    meaning = sp.sqrt((1 - u - p + sp.sqrt((1 + u + p) ** 2 - 4 * p)) / 2)
    numbers = {u: mpmath.mpf(2), p: mpmath.mpf("0.25")}
    example = {**numbers, x: mpmath.sqrt((-mpmath.mpf("1.25") + mpmath.sqrt(mpmath.mpf("3.25") ** 2 - 1)) / 2)}
    made = ForDoubles({x: meaning}, example).form(1 - x)
    with mpmath.workdps(80):
        at = {u: mpmath.mpf(2), p: mpmath.mpf("1e-30")}
        root = sp.lambdify((u, p), meaning, "mpmath")(at[u], at[p])
        truth = 1 - root
    rounded = sp.lambdify((u, p, x), made, "numpy")(2.0, 1e-30, float(root))
    assert abs(float(rounded) - float(truth)) <= 4 * ULP * float(truth)
