"""pint and astropy as hjsolve sees them: conversions against exact fractions, wrong kinds refused."""

import random
from fractions import Fraction

import astropy.units
import pint
import pytest

import hjsolve
from hjsolve.units.libraries import ROUNDING, library, library_of

REGISTRY = pint.UnitRegistry()
EXACT = {"m": Fraction(1), "km": Fraction(1000), "au": Fraction(149597870700), "s": Fraction(1), "hour": Fraction(3600),
         "kg": Fraction(1), "g": Fraction(1, 1000), "min": Fraction(60), "day": Fraction(86400)}  # fmt: skip
KINDS = (("m", "km", "au"), ("s", "hour", "min", "day"), ("kg", "g"))


@pytest.mark.parametrize("wanted", [astropy.units, REGISTRY], ids=["astropy", "pint"])
def test_a_conversion_is_within_its_rounding_of_the_exact_one(wanted):
    chosen, rng = library(wanted), random.Random(5)
    for _ in range(200):
        kinds = [(rng.choice(kind), rng.choice(kind), Fraction(rng.randint(-3, 3))) for kind in KINDS]
        here, there = ({pair[k]: pair[2] for pair in kinds} for k in (0, 1))
        value = rng.uniform(-9, 9) * 10.0 ** rng.randint(-5, 5)
        number = chosen.number(chosen.quantity(value, chosen.unit(here)), chosen.unit(there))
        exact = Fraction(value)
        for one, other, power in kinds:
            exact *= (EXACT[one] / EXACT[other]) ** int(power)
        assert abs(Fraction(float(number)) - exact) <= Fraction(ROUNDING) * abs(exact)


@pytest.mark.parametrize(
    "wanted", ["astropy", "pint", astropy.units, pint, REGISTRY, astropy.units.m, REGISTRY.m, 1 * REGISTRY.m]
)
def test_a_library_is_named_in_many_ways(wanted):
    assert library(wanted).name in str(type(wanted)) + str(wanted) + getattr(wanted, "__name__", "")


def test_what_is_no_quantity_has_no_library():
    assert [library_of(x) for x in (1, 1.5, "1 kpc", None, [1], astropy.units, pint)] == [None] * 7
    with pytest.raises(hjsolve.InvalidInputError, match='write "astropy", "pint"'):
        library("unyt")


@pytest.mark.parametrize("wanted", ["astropy", "pint"])
def test_an_unknown_unit_is_one_clear_error(wanted):
    with pytest.raises(hjsolve.InvalidInputError, match=f'"furlongz" is not a unit of {wanted}'):
        library(wanted).unit({"furlongz": 1})


def test_radians_are_pure_numbers():
    units = astropy.units
    assert library("astropy").number(3 * units.km / units.s / units.rad, units.m / units.s) == 3000
    assert library("pint").number(180 * REGISTRY.degree, REGISTRY.rad) == pytest.approx(3.141592653589793, rel=1e-15)
