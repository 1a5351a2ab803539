"""The maps from a phase to a coordinate are analytic off the line, and those of the line on it."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.one_coordinate.anomaly import barrier_anomaly, libration_anomaly, rotation_anomaly, two_barrier_anomaly
from hjsolve.one_coordinate.complex_anomaly import complex_place
from hjsolve.one_coordinate.fourier_series import FourierSeries
from hjsolve.one_coordinate.stretched_anomaly import Inner, Stretched

MANY = Multi(128)
ONE = MANY.context.mpf(1)
LIBRATION = libration_anomaly(0.3 * ONE, 1.7 * ONE, 0.1 * ONE, 1.9 * ONE, MANY)
MAPS: dict[str, Inner | Stretched] = {
    "libration": LIBRATION,
    "a libration without zeros nearby": libration_anomaly(-ONE, 2 * ONE, None, None, MANY),
    "over a barrier": barrier_anomaly(-ONE, 1.3 * ONE, 0.1 * ONE, 0.1 * ONE, MANY),
    "rotation": rotation_anomaly(0.4 * ONE, 1, 0.2 * ONE, MANY),
    "rotation over two barriers": two_barrier_anomaly(0.2 * ONE, 0.1 * ONE, 2.5 * ONE, 0.3 * ONE, -1, MANY),
    "stretched": Stretched(LIBRATION, FourierSeries(ONE, np.array([0.2, -0.1]), np.array([0.0, 0.05]), 0, 0.0)),
}
PHASES = np.linspace(-3.1, 3.1, 40)  # not 0: 1 − cos ψ of the stretched map is rounding there


def apart(q: np.ndarray, other: np.ndarray, name: str) -> np.ndarray:
    """Distances, of an angle up to whole turns."""
    off = q - other
    return np.abs(off - 2 * np.pi * np.rint(off.real / (2 * np.pi))) if name.startswith("rotation") else np.abs(off)


@pytest.mark.parametrize("name", MAPS)
def test_on_the_line_the_complex_map_is_the_real_one(name: str) -> None:
    found, place = complex_place(MAPS[name], PHASES + 0j), MAPS[name].in_doubles().place(PHASES, Float64())
    assert (apart(found.q, place.q, name) < 1e-13).all()
    np.testing.assert_allclose(found.stretch, np.abs(place.stretch * place.rate), rtol=1e-12, atol=0)
    if found.from_lower is not None:
        np.testing.assert_allclose(found.from_lower, place.below, rtol=1e-10, atol=0)
        np.testing.assert_allclose(found.to_upper, place.above, rtol=1e-10, atol=0)


@pytest.mark.parametrize("name", MAPS)
def test_the_mean_over_a_circle_is_the_value_in_its_middle(name: str) -> None:
    """Of an analytic function: one that jumps, as a modulus taken for ±z would make it, has another mean."""
    middle = PHASES + 0.1j
    circle = middle + 0.05 * np.exp(2j * np.pi * np.arange(64) / 64)[:, None]
    at, around = complex_place(MAPS[name], middle).q, complex_place(MAPS[name], circle).q
    off = around - at
    off -= 2 * np.pi * np.rint(off.real / (2 * np.pi)) if name.startswith("rotation") else 0.0
    assert (np.abs(off.mean(axis=0)) < 1e-12).all()
