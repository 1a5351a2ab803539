"""The quick proof of both turning points: the same places as the search that serves any motion, or none."""

from __future__ import annotations

import math

import pytest

import hjsolve
from hjsolve.arithmetic.ball import between
from hjsolve.motion import certified

flint = pytest.importorskip("flint")


def line(potential, **given):
    """A certified motion of unit mass on a line."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", potential)
    return hjsolve.solve(system).motion(certified=True, want=["turning_points"], **given)


@pytest.mark.parametrize(
    "entry", ["pendulum", "kepler-planar", "spherical-pendulum", "lagrange-top", "two-centres-plane"]
)
def test_the_walk_and_the_search_find_the_same_ends(entry, monkeypatch):
    described = hjsolve.catalog.describe(entry)
    solution = hjsolve.solve(described.system)

    def started():
        return solution.motion(**described.initial.arguments, certified=True, want=["turning_points"], digits=30)

    quick = started()
    monkeypatch.setattr(certified, "prove_turning_points", lambda *_: None)
    slow = started()
    assert quick.kinds == slow.kinds
    for name, ends in slow.turning_points.items():
        for one, other in zip(ends, quick.turning_points[name], strict=True):
            assert abs(one.value - other.value) <= one.error + other.error
    if entry == "pendulum":
        assert quick.other_regions == slow.other_regions


@pytest.mark.parametrize("width", ["1e-2", "1e-4", "1e-7"])
def test_a_thin_barrier_is_not_stepped_over(width):
    """The well about −0.3 reaches from −1 to 0.4 but for a spike at 0 whose foot is a few widths wide."""
    found = line(f"(x + 3/10)**2 + 1/(1 + (x/{width})**2)", q={"x": "-0.3"}, velocity={"x": 1}, digits=20)
    low, high = found.turning_points["x"]
    assert -5 * float(width) < high.value < 0
    assert -1.05 < low.value < -0.95


@pytest.mark.parametrize("height", ["0.999999999999", "1.000000000001"])
def test_the_top_of_a_barrier_is_passed_or_not_by_one_part_in_a_million_millions(height):
    """(x² − 1)² with energy just below or above 1, from the bottom of the right well."""
    found = line("(x**2-1)**2", q={"x": 1}, velocity={"x": f"sqrt(2*{height})"}, digits=20)
    assert (found.turning_points["x"][0].value < 0) == (height > "1")


def test_a_start_at_rest_goes_where_the_force_points():
    found = line("x**4/4 - x**2/2", q={"x": "0.5"}, velocity={"x": 0}, digits=20)
    low, high = found.turning_points["x"]
    assert low.value == 0.5
    assert abs(high.value**2 - 1.75) < 1e-18


@pytest.mark.parametrize("low", [0.1, 1 / 3, 0.7, 1e9 / 7])
def test_the_ball_of_a_short_step_holds_both_of_its_ends(low):
    """The middle of two neighbouring doubles rounds to one of them: half of their distance does not reach the other."""
    high = math.nextafter(low, math.inf)
    ball = between(low, high)
    assert ball.contains(flint.arb(low))
    assert ball.contains(flint.arb(high))
