"""When one of two coupled coordinates reaches its end: the motion was followed again for every guess of the time."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)


@pytest.mark.parametrize("digits", [15, 25])
@pytest.mark.parametrize(
    ("entry", "q", "velocity", "name"),
    [
        ("two-centres-plane", {"xi": "1.1", "eta": "0.5"}, {"xi": "-0.4", "eta": "0.3"}, "xi"),
        ("garnier", {"xi": "0.6", "eta": "1.3"}, {"xi": "-1.3", "eta": "0.2"}, "xi"),
    ],
)
def test_the_motion_stands_at_its_end_at_that_time(entry, q, velocity, name, digits):
    """Just before, the way left is speed times time; the states come from another computation than the time."""
    motion = hjsolve.solve(hjsolve.catalog.load(entry)).motion(q=q, velocity=velocity, digits=digits)
    assert motion.kinds[name] == "boundary"
    end = float(motion.boundary_times[name].value)
    early = np.array([1e-3, 1e-5])
    state = motion.at([float(end - δ) for δ in early])
    left = np.array([float(q / abs(v)) for q, v in zip(state.q[name], state.velocity[name], strict=True)])
    assert np.all(np.abs(left / early - 1) < early)  # the change of speed; a time wrong by 1e-10 would show
    assert motion.at(end + 1e-9).status == "reaches_boundary"
    assert motion.boundary_times[name].error <= 1e-12
