"""Coordinates that end at a crease of V got new symbols, and the place was still expressed in the old ones."""

import pytest

import hjsolve

R2 = "(x**2 + y**2 + z**2 - 1)"


@pytest.mark.nightly
def test_states_in_coordinates_that_end_at_a_crease_know_where_they_are():
    """Found by benchmarks/charts.py: errors of a motion in Vinti's potential could not be computed."""
    spread = f"sqrt({R2}**2 + 4*z**2)"
    system = hjsolve.System(
        dict.fromkeys("xyz", "line"), "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", f"-sqrt(({R2} + {spread})/2)/{spread}"
    )
    solution = hjsolve.solve(system, coordinates="find")
    assert solution.chart.kind == "oblate spheroidal"
    own = {solution.system.symbols[name] for name in solution.chart.coordinates}
    assert set().union(*(e.free_symbols for e in solution.chart.transformation.values())) == own
    start = {"x": "1.1", "y": "-0.2", "z": "0.7"}
    motion = solution.motion(q=start, velocity={"x": "0.1", "y": "0.5", "z": "-0.2"})
    for state in (motion.at([0.0, 1.0]), motion.as_solved.at([0.0, 1.0])):
        for name, value in start.items():
            assert abs(state.place[name][0] - float(value)) <= state.error.place[name][0] <= 1e-12
            assert state.error.place[name][1] <= 1e-12
