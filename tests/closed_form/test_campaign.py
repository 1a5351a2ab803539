"""Random constants: each form against the quadrature to 40 digits, and in doubles; a handful here, thousands nightly."""

from __future__ import annotations

import math

import pytest

from benchmarks.closed_form_campaign import FAR, tried

pytestmark = pytest.mark.rotating_file(1)


@pytest.mark.parametrize(("entry", "motions"), [
    ("kepler-planar", 4), ("double-well", 4), ("isotropic-oscillator-polar", 4),
    *(pytest.param(name, 60, marks=pytest.mark.nightly) for name in (
        "pendulum", "spherical-pendulum", "lagrange-top", "morse", "poeschl-teller", "isochrone", "cone", "stark",
        "kepler-parabolic", "henon-heiles-separable", "sphere-geodesics", "parabola", "ladder", "kepler-prolate", "kerr",
        "lagrange-top-turning-frame", "spherical-staeckel", "torus-geodesics", "vinti",
    )),
])  # fmt: skip
def test_forms_at_random_constants(entry: str, motions: int) -> None:
    found = list(tried(entry, motions, 11))
    assert sum(math.isnan(one.ulps) for one in found) >= motions
    assert [one for one in found if one.flaw] == []
    numbers = [one for one in found if not math.isnan(one.ulps)]
    assert numbers
    assert [(one.name, one.ulps, one.condition) for one in numbers if one.excess > FAR] == []
