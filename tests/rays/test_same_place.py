"""The family of one place against the envelopes and fronts that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError


def place_of(curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and a bound on how far the place may be off, where the curve is known."""
    known = np.isfinite(next(iter(curve.q.values())))
    x, y = curve.place["x"], curve.place["y"]
    return x[known], y[known], (curve.error.place["x"] + curve.error.place["y"])[known]


@pytest.mark.nightly
@pytest.mark.slow
def test_the_envelope_of_throws_is_the_parabola_of_safety() -> None:
    motion = hjsolve.solve("projectile").motion(q={"x": 0, "y": 0}, velocity={"x": 3, "y": 4}, parameters={"g": 10})
    family = hjsolve.wavefronts(motion, "place", fronts=3, orbits=32)
    (envelope,) = family.caustics
    x, y, error = place_of(envelope)
    assert len(x) >= 6
    steepness = 1 + 10 * np.abs(x) / 25
    miss = np.abs(y - (25 / 20 - 10 * x**2 / 50))
    assert np.all(miss <= steepness * error)
    assert np.median(error) < 1e-4
    for front in family.fronts:  # W = ∫ m v² dt along x = vx t, y = vy t − 5 t²
        vx = front.p["x"]
        t = front.q["x"] / vx
        vy = front.q["y"] / t + 5 * t
        W = (vx**2 + vy**2) * t - 10 * vy * t**2 + 100 * t**3 / 3
        assert np.all(np.abs(W[np.abs(vx) > 0.1] - front.value) <= 1e-12 * front.value)


@pytest.mark.nightly
@pytest.mark.slow
def test_the_envelope_of_kepler_orbits_is_an_ellipse_about_the_sun_and_the_place() -> None:
    """r + |q − q₀| = 4a − r₀: the empty foci lie on a circle about q₀."""
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    family = hjsolve.wavefronts(motion, "place", fronts=2, orbits=46)
    (envelope,) = family.caustics
    x, y, error = place_of(envelope)
    assert len(x) >= 10
    sums = np.hypot(x, y) + np.hypot(x - 1, y)
    assert np.all(np.abs(sums - (4 / 0.56 - 1)) <= 2 * error + 1e-13)
    assert np.median(error) < 1e-2


@pytest.mark.nightly
@pytest.mark.slow
def test_the_envelope_of_oscillations_is_an_ellipse_about_the_places_at_rest_on_either_side() -> None:
    """q = q₀ cos ωt + v/ω sin ωt n: |q − q₀| + |q + q₀| = 2 √(2E/(m ω²)), since r₀² + v²/ω² = 2E/(m ω²)."""
    system = hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="m/2*(dot(x)**2 + dot(y)**2)",
        potential="k/2*(x**2 + y**2)", parameters={"m": 2, "k": 3}, place={"x": "x", "y": "y"},
    )  # fmt: skip
    motion = hjsolve.solve(system).motion(q={"x": "0.3", "y": "0.1"}, velocity={"x": "0.4", "y": "0.5"})
    family = hjsolve.wavefronts(motion, "place", fronts=2, orbits=32)
    (envelope,) = family.caustics
    x, y, error = place_of(envelope)
    assert len(x) >= 30
    sums = np.hypot(x - 0.3, y - 0.1) + np.hypot(x + 0.3, y + 0.1)
    E = float(motion.constants["E"].value)
    assert np.all(np.abs(sums - 2 * np.sqrt(2 * E / 3)) <= 2 * error + 1e-14)
    assert error.max() < 1e-3


def test_fronts_of_a_free_particle_are_circles() -> None:
    system = hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="m/2*(dot(x)**2 + dot(y)**2)", potential="0",
        parameters={"m": 2}, place={"x": "x", "y": "y"},
    )  # fmt: skip
    motion = hjsolve.solve(system).motion(q={"x": 1, "y": 2}, velocity={"x": "0.6", "y": "0.8"})
    with pytest.raises(InvalidInputError, match="two coordinates are needed"):
        hjsolve.wavefronts(motion, "place", orbits=16)
    oscillator = hjsolve.System(
        coordinates={"x": "line", "y": "line"}, kinetic="m/2*(dot(x)**2 + dot(y)**2)", potential="x**2/10**12",
        parameters={"m": 2}, place={"x": "x", "y": "y"},
    )  # fmt: skip
    nearly = hjsolve.solve(oscillator).motion(q={"x": 1, "y": 2}, velocity={"x": "0.6", "y": "0.8"})
    family = hjsolve.wavefronts(nearly, "place", fronts=1, orbits=16)
    front = family.front(3)
    assert np.all(np.abs(np.hypot(front.q["x"] - 1, front.q["y"] - 2) - 1.5) < 1e-9)


def test_too_few_directions_are_refused() -> None:
    motion = hjsolve.solve("kepler-planar").motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"})
    with pytest.raises(InvalidInputError, match="at least 16"):
        hjsolve.wavefronts(motion, "place", orbits=8)
