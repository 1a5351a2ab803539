"""A velocity that is 0 came out as 8e-34 from differences in two doubles, and was claimed to 7e-49."""

import numpy as np

import hjsolve


def test_a_velocity_that_cancels_to_nothing_has_the_error_of_what_cancelled():
    """Found by benchmarks/campaign.py --seed 72, draw 256."""
    solution = hjsolve.solve("planetary-disk")
    motion = solution.motion(
        q={"theta": 0.1, "psi": 0.7960009422198548},
        velocity={"theta": 0.47948854835206817, "psi": 0},
        parameters={"l": 4.061197577069684, "r": 1.222957223500631},
    )
    state = motion.at([0.0, 1.0, 1e4])
    assert np.all(np.abs(state.velocity["psi"]) <= state.error.velocity["psi"])
    assert np.all(state.error.velocity["psi"] < 1e-27)
    assert np.all(np.abs(state.velocity["theta"] - 0.47948854835206817) <= state.error.velocity["theta"])
