"""The angle variable of a rotation has its origin at a place of the system, not of the initial data."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve

pytestmark = pytest.mark.rotating_file(2)


@pytest.mark.parametrize("potential", ["cos(2*x)", "cos(3*x)", "cos(x)", "sin(x) + cos(4*x)/3"])
def test_the_origin_does_not_jump_with_the_place_a_rotation_starts_from(potential):
    system = hjsolve.System({"x": "angle"}, "dot(x)**2/2", potential)
    solution = hjsolve.solve(system)
    first = solution.motion(q={"x": "0.1"}, velocity={"x": "2.5"}, digits=25)
    times = [0, "0.3", "0.9", "1.7", "2.2"]
    angles, states = first.angles(times)["x"], first.at(times)
    for k, t in enumerate(times):
        later = solution.motion(q={"x": states.q["x"][k]}, velocity={"x": states.velocity["x"][k]}, t0=t)
        here = later.angles(t)["x"]
        assert abs(np.exp(1j * float(here)) - np.exp(1j * float(angles[k]))) < 1e-13
