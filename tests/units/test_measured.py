"""A value and its error with a unit."""

from fractions import Fraction

import numpy as np
import pint
import pytest
from astropy import units as u

import hjsolve
from hjsolve.arithmetic.measured import measured_in
from hjsolve.units.libraries import library

REGISTRY = pint.UnitRegistry()


@pytest.mark.parametrize("km", [u.km, REGISTRY.km], ids=["astropy", "pint"])
def test_an_estimate_goes_into_a_unit_and_back_with_its_error(km):
    length = hjsolve.Measured.of(hjsolve.Estimate(1.25, 1e-9), km)
    assert length.estimate() == hjsolve.Estimate(1.25, 1e-9)
    far = length.to("au").estimate()
    low, high = (
        Fraction(x) * Fraction(1000, 149597870700)
        for x in (Fraction(1.25) - Fraction(1e-9), Fraction(1.25) + Fraction(1e-9))
    )
    assert Fraction(far.value) - Fraction(far.error) <= low < high <= Fraction(far.value) + Fraction(far.error)
    assert far.error < 1.001e-9 / 149597870
    assert str(length).startswith("1.2500000000(11) k")
    with pytest.raises(hjsolve.InvalidInputError, match="cannot be converted to"):
        length.to("s")


def test_digits_that_a_double_has_not_go_into_the_error_of_astropy_and_stay_in_pint():
    period = (
        hjsolve.solve("kepler-planar")
        .motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}, digits=40)
        .periods["r"]
    )
    double, many = hjsolve.Measured.of(period, u.s), hjsolve.Measured.of(period, REGISTRY.s)
    assert many.estimate() == period
    assert 0 < abs(period.value - double.value.value) <= double.error.value < 1e-14


@pytest.mark.nightly
def test_arrays_of_numbers_have_units_too():
    lengths = measured_in(np.array([1.0, 2.0]), np.array([1e-9, 0.0]), u.km, library(u))
    assert lengths.to(u.m).estimate().value.tolist() == [1000.0, 2000.0]
    assert "array (2,)" in repr(lengths)
