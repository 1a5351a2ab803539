"""The two plain arithmetics answer alike: what one does to an array, the other does to each of its numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.one_coordinate.anomaly import barrier_anomaly, libration_anomaly, rotation_anomaly, two_barrier_anomaly
from hjsolve.one_coordinate.stretched_anomaly import stretched

FLOAT, MANY = Float64(), Multi(160)
X = np.array([-2.75, -0.4, -0.0, 0.0, 0.3, 1.25, 6.9])
Y = np.array([1.0, -2.0, 3.0, -0.5, 0.7, 0.2, -4.0])


def each(rule, *arrays):
    return [float(rule(*(MANY.convert(float(v)) for v in values))) for values in zip(*arrays, strict=True)]


@pytest.mark.parametrize("name", ["rint", "atan2"])
def test_methods_of_both_give_the_same(name: str) -> None:
    arrays = (X,) if name == "rint" else (X, Y)
    found = np.asarray(getattr(FLOAT, name)(*arrays))
    np.testing.assert_allclose(np.abs(found), np.abs(each(getattr(MANY, name), *arrays)), rtol=1e-15, atol=0)


def test_choices_are_made_element_by_element_and_one_number_stays_one() -> None:
    assert FLOAT.where(X < Y, X, Y).tolist() == [min(x, y) for x, y in zip(X, Y, strict=True)]
    assert each(lambda x, y: MANY.where(x < y, x, y), X, Y) == np.minimum(X, Y).tolist()
    assert isinstance(FLOAT.where(np.float64(1) < 2, 1.0, 2.0), float)


def test_a_size_takes_the_sign_of_another_number() -> None:
    assert FLOAT.copysign(np.abs(Y), X).tolist() == [math.copysign(abs(y), x) for x, y in zip(X, Y, strict=True)]
    signs = np.where(X < 0, -1.0, 1.0)  # zeros of many digits have no sign
    assert each(lambda x, y: MANY.copysign(abs(y), x), X, Y) == (signs * np.abs(Y)).tolist()


def maps():
    a, b = MANY.convert(1), MANY.convert(3)
    usual = libration_anomaly(a, b, MANY.convert("0.9"), MANY.convert(4), MANY)
    return [
        usual,
        barrier_anomaly(a, b, MANY.convert("1.7"), MANY.convert("0.2"), MANY),
        rotation_anomaly(MANY.convert("0.4"), -1, MANY.convert("0.3"), MANY),
        two_barrier_anomaly(MANY.convert("0.4"), MANY.convert("0.3"), MANY.convert(3), MANY.convert("0.5"), 1, MANY),
        stretched(usual, [(1.0, 0.05)]),
    ]


@pytest.mark.parametrize("number", range(5))
def test_a_map_in_doubles_is_that_of_many_digits(number: int) -> None:
    anomaly = maps()[number]
    χ = np.array([-2.9, -1.2, 0.4, 1.5, 3.0])
    found = anomaly.in_doubles().place(χ, FLOAT)
    exact = [anomaly.place(MANY.convert(float(x)), MANY) for x in χ]
    for part in ("q", "speed", "stretch"):
        np.testing.assert_allclose(getattr(found, part), [float(getattr(p, part)) for p in exact], rtol=3e-13, atol=0)


@pytest.mark.parametrize("number", range(5))
def test_a_map_yields_its_places_at_the_midpoints(number: int) -> None:
    anomaly, nodes = maps()[number], 7
    turn = math.pi if anomaly.even else 2 * math.pi
    for m, place in enumerate(anomaly.places(nodes, MANY)):
        χ = np.array([turn * (m + 0.5) / nodes])
        again = anomaly.in_doubles().place(χ - 2 * np.pi * np.rint(χ / (2 * np.pi)), FLOAT)
        turns = 0 if anomaly.even else round(float(place.q - again.q[0]) / (2 * math.pi))
        assert float(place.q) == pytest.approx(float(again.q[0]) + 2 * math.pi * turns, rel=1e-12, abs=0)


@pytest.mark.parametrize("number", range(5))
def test_the_slope_of_a_map_is_that_of_its_phase(number: int) -> None:
    anomaly, h = maps()[number], 1e-5
    χ = np.array([-2.0, -0.3, 1.0, 2.2])
    inner = getattr(anomaly, "unstretched", lambda x, _: (x, 1.0))
    slope = (inner(χ + h, FLOAT)[0] - inner(χ - h, FLOAT)[0]) / (2 * h)
    np.testing.assert_allclose(np.broadcast_to(anomaly.slope_at(χ), χ.shape), slope, rtol=1e-7, atol=0)
    assert np.all(anomaly.rounding(χ) >= 0)
