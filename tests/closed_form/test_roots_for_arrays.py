"""Roots and regimes of arrays of constants are those that 50 digits find one by one, wherever doubles prove them.

Of every entry whose forms rest on roots of polynomials; next to double roots, too.
"""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import numpy as np
import pytest
import sympy as sp

from hjsolve.closed_form.curves import MomentumCurve
from hjsolve.closed_form.doubles import CurveForArrays, roots_of
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.closed_form.regions import holds_place, ordered_real_roots, real_roots, region_exists
from tests.support.entries import forms

ENTRIES = ["pendulum", "spherical-pendulum", "cone", "double-well", "henon-heiles-separable", "stark", "lagrange-top",
           "kepler-prolate", "two-centres-plane", "two-centres-space", "schwarzschild", "kerr", "ladder", "garnier",
           "bead-on-turning-wire", "disk-on-turning-rod", "liouville-three", "torus-geodesics", "oblate-geodesics",
           "perfect-oblate-spheroid", "vinti", "neumann", "lagrange-top-turning-frame", "whirling-tube"]  # fmt: skip
DRAWN = 60
Constants = Mapping[sp.Symbol, float]


def _drawn(form: RegimeForms, dice: np.random.Generator) -> list[Constants]:
    """Constants about those of the regime, over four decades; half of them with small differences."""
    fixed = {p.symbol for p in form.solution.system.parameters if p.assume == "integer"}
    found = []
    for k in range(DRAWN):
        wide = 2.0 if k % 2 else 0.05
        signs = dice.choice((-1.0, 1.0), len(form.regime.example))
        found.append({
            s: float(v) if s in fixed
            else (float(v) or 1.0) * 10 ** dice.uniform(-wide, wide) * (sign if k % 4 == 3 and not s.is_positive else 1)
            for (s, v), sign in zip(form.regime.example.items(), signs, strict=True)
        })  # fmt: skip
    return found


def _nearly_double(curve: MomentumCurve, one: Constants, other: Constants) -> list[Constants]:
    """Constants between two sets with different numbers of real roots, ever nearer to where two of them meet."""

    def between(part: float) -> Constants:
        return {s: one[s] + (other[s] - one[s]) * part for s in one}

    def count(part: float) -> int:
        return len(real_roots(curve, {s: mpmath.mpf(v) for s, v in between(part).items()})[0])

    low, high, first = 0.0, 1.0, count(0.0)
    if first == count(1.0):
        return []
    found = []
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if count(middle) == first else (low, middle)
        found += [between(low), between(high)]
    return found


def _table(constants: list[Constants]) -> dict[sp.Symbol, np.ndarray]:
    return {s: np.array([c[s] for c in constants]) for s in constants[0]}


def _compare(
    curve: MomentumCurve, form: RegimeForms, constants: list[Constants], places: np.ndarray
) -> tuple[int, int]:
    """Return how many were compared, and how many are not proved."""
    q = curve.coordinate.symbol
    prepared, table = CurveForArrays(curve), _table(constants)
    found = prepared.at(table, (len(constants),), {})
    if found is None:
        return 0, 0
    (region,) = (r for c, r in form.regime.regions if c is curve)
    exists, unsure = found.has(region)
    place = prepared.place(q)
    assert place is not None
    holds, doubtful = found.holds(region, place({**table, q: places}, (len(constants),)))
    rest, _ = prepared.without_ends
    compared = 0
    for k, own in enumerate(constants):
        numbers = {s: mpmath.mpf(v) for s, v in own.items()}
        if not found.roots.unsure[k]:
            compared += 1
            exact = ordered_real_roots(rest, numbers, 50)
            roots = found.roots.roots[:, k]
            assert np.isfinite(roots).sum() == len(exact), (own, roots, exact)
            for root, off, truth in zip(roots, found.roots.errors[:, k], exact, strict=False):
                with mpmath.workdps(50):
                    # the roots by 50 digits are as exact as that; those of doubles as far as they claim
                    assert abs(mpmath.mpf(float(root)) - truth) <= off + abs(truth) * mpmath.mpf(10) ** -40, (
                        own,
                        root,
                        truth,
                    )
        if not unsure[k]:
            assert exists[k] == region_exists(curve, region, numbers), own
            if exists[k] and not doubtful[k]:
                exact_place = holds_place(
                    curve, region, mpmath.mpf(float(places[k])), {**numbers, q: mpmath.mpf(float(places[k]))}
                )
                assert holds[k] == exact_place, (own, places[k])
    return compared, int((unsure | found.roots.unsure).sum())


@pytest.mark.nightly_cases(*(e for e in ENTRIES if e not in ("pendulum", "spherical-pendulum")))
@pytest.mark.parametrize("name", ENTRIES)
def test_arrays_agree_with_fifty_digits(name: str) -> None:
    dice, compared, unproved, close = np.random.default_rng(7), 0, 0, 0
    for form in forms(name):
        constants = _drawn(form, dice)
        for curve, _ in form.regime.regions:
            if curve.degree < 3:
                continue
            places = dice.uniform(-3, 3, len(constants))
            one, none = _compare(curve, form, constants, places)
            compared, unproved = compared + one, unproved + none
            near = _nearly_double(curve, constants[0], constants[1]) or _nearly_double(
                curve, constants[0], constants[3]
            )
            if near:
                one, none = _compare(curve, form, near, dice.uniform(-3, 3, len(near)))
                close += one
    assert compared == 0 or unproved <= compared // 20  # those without a form of degree 3 have nothing to compare
    if name in ("pendulum", "spherical-pendulum", "cone", "stark", "kerr"):
        assert compared >= 60
        assert close >= 20


@pytest.mark.nightly_cases("cone", "kerr", "lagrange-top", "stark")
@pytest.mark.parametrize("name", ["spherical-pendulum", "cone", "lagrange-top", "stark", "kerr"])
def test_named_roots_have_all_their_digits(name: str) -> None:
    dice = np.random.default_rng(11)
    compared = 0
    for form in forms(name):
        polynomials = {m[0] for m in form.where.values() if isinstance(m, tuple)}
        constants = _drawn(form, dice)
        for polynomial in polynomials:
            prepared = roots_of(polynomial)
            assert prepared is not None
            roots, unsure = prepared.rounded(_table(constants), (len(constants),), {})
            for k, own in enumerate(constants):
                if unsure[k]:
                    continue
                compared += 1
                exact = ordered_real_roots(polynomial, {s: mpmath.mpf(v) for s, v in own.items()}, 50)
                assert np.isfinite(roots[:, k]).sum() == len(exact)
                for root, truth in zip(roots[:, k], exact, strict=False):
                    assert abs(root - float(truth)) <= 4 * 2.0**-52 * abs(root)
    assert compared >= 60
