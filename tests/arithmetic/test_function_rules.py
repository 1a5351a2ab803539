"""The shared rules of elementary functions, against mpmath's numerical derivatives and where they are flat."""

import mpmath
import numpy as np
import pytest

from hjsolve.arithmetic.complex_disks import Disk, Disks
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.arithmetic.function_rules import BY_VALUE, QUOTIENTS, bend, quotient, slope
from hjsolve.arithmetic.power_series import FloatingPoint, SeriesProgram
from hjsolve.arithmetic.tape import UNARY

FUNCTIONS = [name for name in UNARY if name != "neg"]


def of_mpmath(name, x):
    return abs(x) if name == "abs" else getattr(mpmath, name)(x)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_both_derivatives_are_those_of_numerical_differentiation(name):
    a = Multi(200)
    place = a.context.mpf("1.7" if name == "acosh" else "0.3")
    value = a.unary(name, place)
    first = slope(a, name, place, value if name in BY_VALUE else None)
    with mpmath.workdps(70):
        expected = [mpmath.diff(lambda y: of_mpmath(name, y), mpmath.mpf(place), n) for n in (1, 2)]
    assert abs(first - expected[0]) < 1e-30
    assert abs(bend(a, name, place, value, first) - expected[1]) < 1e-25


@pytest.mark.parametrize("name", sorted(QUOTIENTS))
def test_quotients_are_the_functions(name):
    a = Multi(200)
    x = a.context.mpf("0.7")
    assert abs(quotient(a, name, x) - a.unary(name, x)) < 1e-55


@pytest.mark.parametrize(("name", "x"), [("tanh", 40.0), ("tanh", -300.0), ("acosh", 1 + 2.0**-40), ("sech", 300.0)])
def test_derivatives_keep_their_digits_where_a_function_is_flat_or_steep(name, x):
    a = Float64()
    value = a.unary(name, x)
    first = slope(a, name, x, value)
    with mpmath.workdps(400):
        expected = [mpmath.diff(lambda y: of_mpmath(name, y), mpmath.mpf(x), n) for n in (1, 2)]
        if name == "tanh":  # differences of 1 − e^(−2x) would need more digits than these
            expected = [mpmath.sech(x) ** 2, -2 * mpmath.tanh(x) * mpmath.sech(x) ** 2]
        assert abs(first / expected[0] - 1) < 1e-14
        if name != "acosh":  # its Φ″ has x − 1 twice more: still all digits but a few
            assert abs(bend(a, name, x, value, first) / expected[1] - 1) < 1e-14


@pytest.mark.parametrize("name", FUNCTIONS)
def test_disks_hold_both_derivatives_at_their_places(name):
    """Next to and far from the axes, on both half planes: −1.6 + 0.4i is where √(x² − 1) has the other sign."""
    disks = Disks()
    for centre in (0.3 + 0.2j, 1.9 - 0.3j, -1.6 + 0.4j, 0.1 - 1.4j):
        where = centre + 0.01 * np.exp(2j * np.pi * np.linspace(0, 1, 7))
        disk = Disk(np.complex128(centre), np.float64(0.0101))
        for order, found in ((1, disks.derivative(name, disk)), (2, disks.bend(name, disk))):
            if not found.known:
                continue
            for z in where:
                h = 1e-4
                points = [disks.unary(name, Disk(np.complex128(z + k * h), np.float64(0.0))).centre for k in (-1, 0, 1)]
                step = (points[2] - points[0]) / (2 * h) if order == 1 else np.diff(points, 2)[0] / h**2
                assert abs(step - found.centre) <= found.radius + 1e-6 * (1 + abs(step)), (name, centre, order)


@pytest.mark.parametrize("name", sorted(QUOTIENTS))
def test_power_series_have_the_quotients_by_the_same_rule(name):
    series = SeriesProgram(FloatingPoint(Multi(200)))
    inner = series.new()
    found = series.unary(name, inner)
    for k, x in enumerate((Multi(200).context.mpf("0.4"), 1, 0, 0, 0, 0, 0)):
        inner.append(Multi(200).convert(x))
        series.extend(k)
    with mpmath.workdps(80):
        expected = mpmath.taylor(lambda y: of_mpmath(name, y), mpmath.mpf(inner[0]), 6)
    assert all(abs(a - b) < 1e-30 for a, b in zip(found, expected, strict=True))
