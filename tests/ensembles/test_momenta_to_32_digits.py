"""Momenta of starts in x, y, z to 32 digits, against the same formulas in 120 digits; what doubles lose is bounded."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import hjsolve
from hjsolve.arithmetic.floats import Float64, Multi
from hjsolve.ensembles.charted import chart_map
from hjsolve.ensembles.charted.chart_map import ChartMap
from hjsolve.ensembles.charted.charted_starts import charted_starts
from hjsolve.ensembles.charted.momenta_to_32_digits import (
    ExactStarts,
    exact_point,
    exact_starts,
    exactly,
    formulas_of,
)
from hjsolve.ensembles.engine import build
from hjsolve.motion.initial_data import parameter_values

SPACE = {"x": "line", "y": "line", "z": "line"}
CENTRES = "-1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)"
GARNIER = "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 7*z**2/3"
MANY = Multi(400)


def map_of(coordinates: dict[str, str], potential: str, kind: str) -> ChartMap:
    kinetic = "(" + " + ".join(f"dot({name})**2" for name in coordinates) + ")/2"
    solution = hjsolve.solve(hjsolve.System(coordinates, kinetic, potential), coordinates="find")
    model = build(solution, frozenset({"actions"})).model
    return chart_map(solution, model, parameter_values(solution.system, {}), kind)


def evaluated(chart: ChartMap, plain: Any, *blocks: np.ndarray) -> tuple[list[Any], ...]:
    """Positions, momenta, constants and √F of one orbit, in many digits or in doubles."""
    take = MANY.convert if plain is MANY else float
    rows = [[take(float(value)) for value in block] for block in blocks]
    known = [[take(p.high) + take(p.low) for p in pairs] for pairs in (chart.numbers, chart.model.numbers)]
    return exactly(formulas_of(chart), plain, *known, *rows, moved=plain.add)


def off(high: float, low: float, true: Any) -> Any:
    return abs(MANY.convert(float(high)) + MANY.convert(float(low)) - true)


def check(
    chart: ChartMap, found: ExactStarts, q: np.ndarray, x: np.ndarray, rates: np.ndarray, which: list[int]
) -> None:
    """Doubles lose no more than the bounds say, and 32 digits 2⁻⁴⁴ of it."""
    points = exact_point(chart, q, x, rates)
    for j in which:
        rows = q[:, j], x[:, j], rates[:, j]
        places, momenta, _, roots = evaluated(chart, MANY, *rows)
        _, doubles, _, _ = evaluated(chart, Float64(), *rows)
        for k, (u, p) in enumerate(zip(places, momenta, strict=True)):
            assert off(points[k].high[j], points[k].low[j], u) <= 2.0**-90 * (1 + abs(u))
            assert off(found.high[k, j], found.low[k, j], p) <= 2.0**-44 * found.lost[k, j]
            assert abs(doubles[k] - p) <= found.lost[k, j] <= 1e-11 * (1 + abs(p))
        for k, root in enumerate(roots):
            assert off(found.roots[k, j], found.roots_low[k, j], root) <= 2.0**-44 * found.uncertainties[k, j] / (
                2 * root
            )


@pytest.mark.nightly_cases(
    "coordinates0--1/sqrt((x - 1)**2 + (y - 2)**2) - 3/sqrt((x - 3)**2 + (y + 1)**2)-velocity",
    "coordinates1--1/sqrt(x**2 + y**2 + z**2) + x/7 + z/5-p",
)  # fmt: skip
@pytest.mark.parametrize(("coordinates", "potential", "kind"), [
    ({"x": "line", "y": "line"}, CENTRES, "velocity"),
    (SPACE, "-1/sqrt(x**2 + y**2 + z**2) + x/7 + z/5", "p"),
    pytest.param(SPACE, GARNIER, "velocity", marks=pytest.mark.nightly),
])  # fmt: skip
def test_momenta_are_those_of_many_digits(coordinates: dict[str, str], potential: str, kind: str) -> None:
    chart = map_of(coordinates, potential, kind)
    x, rates = np.random.default_rng(8).uniform(-1, 1, (2, len(coordinates), 500))
    starts = charted_starts(chart, x, rates)
    found = exact_starts(chart, starts.q, x, rates)
    fine = np.isfinite(found.high).all(axis=0) & np.isfinite(found.roots).all(axis=0)
    assert fine.mean() > 0.9
    check(chart, found, starts.q, x, rates, np.flatnonzero(fine)[:20].tolist())
    precise = starts.precise()
    calm = (starts.off < 1e-12) & np.isfinite(starts.spread) & np.isfinite(precise.uncertainty)  # the others were moved
    assert (np.abs(starts.p - precise.p) <= starts.uncertainty + precise.uncertainty)[calm].all()


def test_positions_far_from_the_true_ones_are_computed_without_those_nearby() -> None:
    """Beyond 2⁻³⁴ sines do not come from those nearby; that an orbit is far changes no bit of the others."""
    chart = map_of({"x": "line", "y": "line"}, CENTRES, "velocity")
    x, rates = np.random.default_rng(9).uniform(-1, 1, (2, 2, 40))
    q = charted_starts(chart, x, rates).q
    near = exact_starts(chart, q, x, rates)
    q = q.copy()
    q[0, ::2] += 2.0**-30
    found = exact_starts(chart, q, x, rates)
    for a, b in zip(near, found, strict=True):
        assert a[:, 1::2].tobytes() == b[:, 1::2].tobytes()
    far = [j for j in range(0, 40, 2) if np.isfinite(found.roots[:, j]).all()]
    assert len(far) > 10
    for j in far[:5]:
        _, momenta, _, _ = evaluated(chart, MANY, q[:, j], x[:, j], rates[:, j])
        for k, p in enumerate(momenta):
            assert off(found.high[k, j], found.low[k, j], p) <= 2.0**-95 * (1 + abs(p))
