"""Momenta of starts in x, y, z to 32 digits: compiled they are those of numpy, and bounds are no less."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles.charted import chart_map
from hjsolve.ensembles.charted.charted_starts import charted_starts
from hjsolve.ensembles.charted.momenta_to_32_digits import exact_starts
from hjsolve.ensembles.engine import build
from hjsolve.motion.initial_data import parameter_values

SPACE = {"x": "line", "y": "line", "z": "line"}
CENTRES = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)"
GARNIER = "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 7*z**2/3"


@pytest.mark.nightly_cases(
    "coordinates0--1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)-velocity",
    "coordinates1--1/sqrt(x**2 + y**2 + z**2) + x/7 + z/5-p",
)  # fmt: skip
@pytest.mark.parametrize(("coordinates", "potential", "kind"), [
    ({"x": "line", "y": "line"}, CENTRES, "velocity"),
    (SPACE, "-1/sqrt(x**2 + y**2 + z**2) + x/7 + z/5", "p"),
    pytest.param(SPACE, GARNIER, "velocity", marks=pytest.mark.nightly),
])  # fmt: skip
def test_compiled_starts_are_those_of_numpy(coordinates: dict[str, str], potential: str, kind: str) -> None:
    pytest.importorskip("numba")
    kinetic = "(" + " + ".join(f"dot({name})**2" for name in coordinates) + ")/2"
    solution = hjsolve.solve(hjsolve.System(coordinates, kinetic, potential), coordinates="find")
    model = build(solution, frozenset({"actions"}), compiled=False).model
    chart = chart_map(solution, model, parameter_values(solution.system, {}), kind)
    dice = np.random.default_rng(8)
    x, rates = dice.uniform(-1, 1, (2, len(coordinates), 500))
    starts = charted_starts(chart, x, rates)
    with np.errstate(all="ignore"):
        plain, fast = (exact_starts(chart, starts.q, x, rates, compiled=c) for c in (False, True))
    assert np.isfinite(plain.high).all(axis=0).mean() > 0.9
    for high, low in (("high", "low"), ("roots", "roots_low")):
        a, b = getattr(plain, high), getattr(fast, high)
        assert np.array_equal(np.isnan(a), np.isnan(b))
        known = np.isfinite(a)
        apart = np.abs((a - b) + (getattr(plain, low) - getattr(fast, low)))[known]
        lost = (plain.lost if high == "high" else plain.doubts / (2 * plain.roots))[known]
        assert (apart <= 2.0**-44 * lost).all()
    for name in ("lost", "doubts"):
        a, b = getattr(plain, name), getattr(fast, name)
        known = np.isfinite(a)
        assert (b[known] >= a[known] * (1 - 1e-6)).all()
        assert (b[known] <= 8 * a[known]).all()
    whole = charted_starts(chart, x, rates, compiled=True)
    assert (np.isfinite(starts.q) == np.isfinite(whole.q)).all()
    for name, bound in (("q", "off"), ("p", "spread")):
        a, b = (np.nan_to_num(getattr(s, name)) for s in (starts, whole))
        claims = [np.nan_to_num(getattr(s, bound)) for s in (starts, whole)]
        calm = starts.off < 1e-12  # the others were moved into their motions
        assert (np.abs(a - b) <= claims[0] + claims[1])[calm].all()


@pytest.mark.nightly
def test_places_far_from_the_true_ones_are_left_to_numpy() -> None:
    """Beyond 2⁻³⁴ sines are not had from those nearby: the numbers are numpy's, to the bit."""
    pytest.importorskip("numba")
    kinetic = "(dot(x)**2 + dot(y)**2)/2"
    system = hjsolve.System({"x": "line", "y": "line"}, kinetic, CENTRES)
    solution = hjsolve.solve(system, coordinates="find")
    model = build(solution, frozenset({"actions"}), compiled=False).model
    chart = chart_map(solution, model, parameter_values(solution.system, {}), "velocity")
    x, rates = np.random.default_rng(9).uniform(-1, 1, (2, 2, 40))
    q = charted_starts(chart, x, rates).q.copy()
    q[0, ::2] += 2.0**-20
    with np.errstate(all="ignore"):
        plain, fast = (exact_starts(chart, q, x, rates, compiled=c) for c in (False, True))
    for a, b in zip(plain, fast, strict=True):
        assert a[:, ::2].tobytes() == b[:, ::2].tobytes()
