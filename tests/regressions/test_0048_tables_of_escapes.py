"""States at many times of an escape, read from a table."""

import numpy as np
import pytest

import hjsolve

KEPLER = hjsolve.solve(hjsolve.catalog.load("kepler-planar"))
LINE = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "1/(1+x**2)"))


@pytest.mark.parametrize(
    ("solution", "start"),
    [
        (KEPLER, {"q": {"r": 1, "theta": "0.1"}, "p": {"r": "1.9", "theta": "1e-3"}}),
        (KEPLER, {"q": {"r": 1, "theta": "0.1"}, "p": {"r": "-1.9", "theta": "1e-3"}}),
        (KEPLER, {"q": {"r": 50, "theta": "0.1"}, "p": {"r": "1.9", "theta": "0.5"}}),
        (LINE, {"q": {"x": 300}, "p": {"x": "0.5"}}),
        (LINE, {"q": {"x": 300}, "p": {"x": "-2"}}),
    ],
)
def test_a_table_begins_where_the_motion_begins(solution, start):
    """It began elsewhere, where the start lies many widths from the place that it is measured from: r(0) was 3e-4."""
    motion, times = solution.motion(**start), np.linspace(0, 14, 2801)
    many, few = motion.at(times), motion.at(times[[0, 100, 600, 2800]])
    for group in ("q", "p", "velocity"):
        for name, values in getattr(few, group).items():
            found, uncertainty = getattr(many, group)[name], getattr(many.error, group)[name]
            for k, i in enumerate((0, 100, 600, 2800)):
                assert abs(found[i] - values[k]) <= uncertainty[i] + getattr(few.error, group)[name][k]
