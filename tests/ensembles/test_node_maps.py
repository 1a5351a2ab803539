"""The tables of the compiled pass serve every orbit."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve.ensembles.engine import node_maps
from hjsolve.ensembles.engine.node_maps import NodeMap
from hjsolve.ensembles.engine.nodes import MOST, libration_nodes
from hjsolve.ensembles.engine.strips_of_analyticity import squares


@pytest.mark.parametrize("lower", [0, 2, 53, 54, 55, 2 * MOST])
def test_a_map_is_divided_where_it_should_however_steep_an_end_is(lower: int) -> None:
    # 1/(1 + 2^54) is nothing beside 1: a nearly radial orbit ended the whole batch with ZeroDivisionError
    for low, high in ((lower, 2 * MOST - lower), (2 * MOST - lower, lower)):
        key = NodeMap(1, low, high)
        table = libration_nodes(node_maps.COUNTS[0], key.level, key.node_map)
        for share, ratio in enumerate((1.0, 2.0**high, 2.0**-low)):
            χ = node_maps._half_way(key, key.dividing(share))
            x, y = key.stretched(*(square.real for square in squares(np.array([χ + 0j]), table)))
            assert abs(np.log2(x[0] / y[0]) - np.log2(ratio)) < 0.1
