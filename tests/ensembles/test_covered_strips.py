"""The disks of a strip hold it: places drawn anywhere in the strip lie in one of them."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.ensembles.engine.nodes import libration_nodes
from hjsolve.ensembles.engine.strips_of_analyticity import covered_strip, disks, half_width, squares

_POINTS = 4000


def _lower_parts(level: int, dice: np.random.Generator) -> np.ndarray:
    """ρ_d with (1 + ρ_d)(1 + ρ_c) = 4^level, divided anyhow between the ends, and all at one of them."""
    return 4.0 ** (level * np.concatenate([[0.0, 1.0], dice.uniform(0, 1, 10)])) - 1


@pytest.mark.rotating(4)
@pytest.mark.parametrize("count", [16, 24, 80, 320])
@pytest.mark.parametrize(
    ("level", "node_map"),
    [
        (0, 0),
        (0, 1),
        (0, 5),
        (1, 0),
        (4, 0),
        (9, 1),
        (9, 3),
        (9, 5),
        (23, 1),
        (23, 2),
        (23, 4),
        (23, 5),
        (40, 3),
        (40, 4),
    ],
)
def test_every_place_of_the_strip_lies_in_a_disk(level: int, node_map: int, count: int) -> None:
    """Where a rectangle may hold q = ∞ or a pole of sn, too: there radii have to be infinite."""
    dice = np.random.default_rng(count + level)
    table = libration_nodes(count, level, node_map)
    over = covered_strip(table)
    χ = dice.uniform(0, np.pi, _POINTS) + 1j * half_width(count, 1) * dice.uniform(0, 1, _POINTS)
    sn2, cn2 = squares(χ, table)
    for d in _lower_parts(level, dice):
        low, high, radii = disks(over, d)
        x, y = sn2 / (1 + d * cn2), (1 + d) * cn2 / (1 + d * cn2)
        near = np.minimum(np.abs(x[:, None] - low), np.abs(y[:, None] - high)) <= radii * (1 + 1e-9)
        assert near.any(axis=1).all()


@pytest.mark.parametrize("level", [2, 6, 12, 30])
def test_the_disks_are_not_much_larger_than_they_have_to_be(level: int) -> None:
    """Infinite disks would hold everything: with enough nodes they are finite, and small in all."""
    table = libration_nodes(320, level, 3 * (level > 4))
    _, _, radii = disks(covered_strip(table), _lower_parts(level, np.random.default_rng(level))[:, None])
    assert np.isfinite(radii).all(axis=1).mean() > 0.8
    assert (radii[np.isfinite(radii).all(axis=1)].max(axis=1) < 0.5).all()
