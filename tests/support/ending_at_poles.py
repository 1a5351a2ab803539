"""Motions that end where their coordinates do, poles and axes included: what lies beneath the motions of users."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hjsolve.formulas.read import number
from hjsolve.motion.initial_data import read_initial_data
from hjsolve.motion.motion import Motion
from hjsolve.motion.starting import started
from hjsolve.motion.wanted import parts_of
from hjsolve.solution.quadratures import Solution


def ending_at_poles(
    solution: Solution,
    *,
    q: Mapping[str, Any],
    velocity: Mapping[str, Any],
    parameters: Mapping[str, Any] | None = None,
    digits: int = 15,
) -> Motion:
    """Start a motion that is not continued through the poles of its coordinates, as ``Solution.motion`` would.

    Args:
        solution, q, velocity, parameters, digits: as of ``Solution.motion``.
    """
    initial = read_initial_data(solution, q=q, velocity=velocity, parameters=parameters)
    return started(solution, initial, number(0, source="t0"), digits, parts_of(None))
