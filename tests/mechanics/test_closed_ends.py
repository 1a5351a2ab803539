"""``0 <= R``: an axis or a pole may be written as included; any other end is refused with what to write."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve import InvalidSystemError, System, ensemble, find_coordinates, solve

pytestmark = pytest.mark.rotating_file(4)

CYLINDER = "(dot(R)**2 + R**2*dot(phi)**2 + dot(z)**2)/2"
SPHERE = "(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)/2"


@pytest.mark.parametrize("domain", ["0 <= R", "R >= 0", "0 ≤ R"])
def test_a_cylindrical_radius_may_include_the_axis(domain: str) -> None:
    included = System({"R": domain, "phi": "angle", "z": "line"}, CYLINDER, "-1/sqrt(R**2 + z**2) + z/10")
    plain = System({"R": "0 < R", "phi": "angle", "z": "line"}, CYLINDER, "-1/sqrt(R**2 + z**2) + z/10")
    assert included == plain
    assert find_coordinates(included).kinds == ("rotational parabolic",)
    start = {"q": {"R": 1, "phi": "0.3", "z": "0.1"}, "velocity": {"R": "0.1", "phi": "0.5", "z": 0}}
    assert solve(included, "find").motion(**start).at(2).q["R"] == solve(plain, "find").motion(**start).at(2).q["R"]


def test_poles_of_a_sphere_may_be_included() -> None:
    system = System({"r": "0 <= r", "theta": "0 <= theta <= pi", "phi": "angle"}, SPHERE, "-1/r")
    assert [c.domain.written(c.name) for c in system.coordinates] == ["0 < r", "0 < theta < pi", "angle"]
    batch = ensemble(system, q={"r": np.ones(2), "theta": 1, "phi": 0}, velocity={"r": 0, "theta": 0.1, "phi": 1})
    assert (batch.status == "ok").all()


@pytest.mark.parametrize(
    ("domain", "says"),
    [
        ("0 <= x", 'domains are open, and x = 0 is not an axis or a pole of T; write "0 < x"'),
        ("0 <= x < 2*pi", 'write "angle" for a full turn'),
        ("x = 0", "is not a domain"),
    ],
)
def test_other_ends_that_are_included_are_refused_with_the_cure(domain: str, says: str) -> None:
    with pytest.raises(InvalidSystemError) as refusal:
        System({"x": domain}, "dot(x)**2/2", "x")
    assert says in str(refusal.value)


def test_an_end_at_two_pi_that_is_open_is_a_domain_as_before() -> None:
    assert System({"x": "-2*pi < x < 2*pi"}, "dot(x)**2/2", "x").coordinates[0].domain.kind == "interval"
