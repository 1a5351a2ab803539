"""The tables of nodes serve every orbit and every thread."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles.engine import node_maps
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.node_maps import NodeMap
from hjsolve.ensembles.engine.nodes import MOST_LEVEL, libration_nodes
from hjsolve.ensembles.engine.strips_of_analyticity import squares


@pytest.mark.parametrize("lower", [0, 2, 53, 54, 55, 2 * MOST_LEVEL])
def test_a_map_is_divided_where_it_should_however_steep_an_end_is(lower: int) -> None:
    # 1/(1 + 2^54) is nothing next to 1: a nearly radial orbit ended the whole batch with ZeroDivisionError
    for low, high in ((lower, 2 * MOST_LEVEL - lower), (2 * MOST_LEVEL - lower, lower)):
        key = NodeMap(1, low, high)
        table = libration_nodes(node_maps.COUNTS[0], key.level, key.node_map)
        for fraction, ratio in enumerate((1.0, 2.0**high, 2.0**-low)):
            χ = node_maps._at_half(key, key.dividing(fraction))
            x, y = key.stretched(*(square.real for square in squares(np.array([χ + 0j]), table)))
            assert abs(np.log2(x[0] / y[0]) - np.log2(ratio)) < 0.1


def test_all_threads_that_come_first_get_the_same_maps() -> None:
    # each had an object of its own: indices of one were looked up in the tables of another, without bounds checks
    node_maps._of_this_process.cache_clear()
    together = Barrier(8)

    def first(_: int) -> node_maps.NodeMaps:
        together.wait()
        return node_maps.node_maps()

    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(first, range(8)))
    assert all(one is found[0] for one in found)


def test_cells_that_a_loop_reads_do_not_change_when_another_thread_divides_more() -> None:
    system = hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "exp(1234*x/567)/x")  # no other test looks at its functions
    (separated,) = lowered_model(hjsolve.solve(system), {}).separated
    shared = separated.plain.clearance
    shared.radius(np.array([1.234e3]))
    before = shared.table()
    assert before is not None
    shared.radius(np.array([1.234e-3, 5.6e7, 8.9e12]))
    assert before.start.max() < len(before.radii)
    assert shared.table() is not before
