"""Exact constants of a start in x, y, z have some 1400 digits: the map of all motions had coefficients beyond doubles."""

from __future__ import annotations

from pathlib import Path

import pytest

import hjsolve

KINETIC = "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"
SPACE = {"x": "line", "y": "line", "z": "line"}


@pytest.mark.nightly
@pytest.mark.parametrize(("potential", "velocity"), [
    ("-1/sqrt(x**2 + y**2 + z**2)", {"x": 0, "y": "0.9", "z": "0.2"}),
    ("-1/sqrt((x - 1)**2 + (y + 1)**2 + (z - 1/3)**2)", {"x": "0.1", "y": "0.7", "z": "-0.3"}),
])  # fmt: skip
def test_a_motion_in_found_coordinates_has_its_report(
    potential: str, velocity: dict[str, str], tmp_path: Path
) -> None:  # fmt: skip
    solution = hjsolve.solve(hjsolve.System(SPACE, KINETIC, potential), coordinates="find")
    motion = solution.motion(q={"x": 1, "y": 0, "z": "0.1"}, velocity=velocity)
    page = hjsolve.report(motion, tmp_path / "kepler.html").read_text(encoding="utf-8")
    assert "Every motion of this system" in page
    own = motion.as_solved
    every = hjsolve.energy_momentum_map(own)
    here = every.kinds_at(*(float(own.constants[name].value) for name in (every.x, every.y)))
    assert here == {name: (own.kinds[name],) for name in own.solution.coordinates}
