"""Random constants: each form against the quadrature to 40 digits, and in doubles; a handful here, thousands nightly."""

from __future__ import annotations

import pytest

from benchmarks.closed_form_campaign import tried

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
    integrals = [one for one in found if one.kind == "integral"]
    numbers = [one for one in found if one.kind == "number"]
    assert len(integrals) >= motions
    assert numbers
    assert [one for one in found if one.wrong] == []
    assert max(one.value for one in integrals) <= 1
