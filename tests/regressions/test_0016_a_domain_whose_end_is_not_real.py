"""Kerr with a > M has no horizon: the message was "I has no numerical value here"."""

from __future__ import annotations

import pytest

import hjsolve
from hjsolve.errors import InvalidInputError


@pytest.mark.parametrize("certified", [False, True])
def test_a_naked_singularity_is_refused_with_its_parameters(certified):
    entry = hjsolve.catalog.describe("kerr")
    solution = hjsolve.solve(entry.system)
    with pytest.raises(
        InvalidInputError, match=r"domain of r begins at .* not a real number for M = 1, a = 3/2; choose"
    ):
        solution.motion(**entry.initial.arguments, parameters={"a": "1.5"}, certified=certified)


def test_an_extreme_hole_has_its_horizon_at_a_rational_place():
    entry = hjsolve.catalog.describe("kerr")
    motion = hjsolve.solve(entry.system).motion(**entry.initial.arguments, parameters={"a": 1}, want=["turning_points"])
    assert motion.kinds["theta"] == "libration"
