"""False claims that the campaign of random motions found, each with the draw that showed it."""

import mpmath
import numpy as np
import pytest

import hjsolve


def solved(name):
    return hjsolve.solve(hjsolve.catalog.load(name))


def test_a_mean_rate_that_cancels_is_zero_and_has_no_period():
    """A charge circling next to the axis: its azimuth comes back, Ω_θ = 0; it was 4e-53 ± 1e-68 with a period 1e53."""
    start = {
        "q": {"r": "2.43", "theta": "0.2", "z": "-0.199"},
        "velocity": {"r": "0.203", "theta": "0.591", "z": "0.865"},
    }
    for digits in (15, 30):
        motion = solved("charge-in-uniform-field").motion(**start, parameters={"B": "0.857"}, digits=digits)
        rate = motion.frequencies["theta"]
        assert rate.value == 0
        assert 0 < rate.error < 10.0 ** (-2 * digits + 2)
        assert "theta" not in motion.periods


@pytest.mark.nightly
def test_a_momentum_that_varies_by_many_orders_claims_the_rounding_of_its_logarithm():
    """Past the pole at a distance of 1e-3: p_θ = ±√(2α) nearly all the time, ln(p/(dq/dχ)) has many terms."""
    start = {
        "q": {"r": 0.8948554556193501, "theta": 0.0009495702595396734, "phi": 0.1},
        "velocity": {"r": 1.3959072947394027e-05, "theta": 0.15099257650176162, "phi": -0.20771324657125373},
    }
    times = np.array([-0.5392105913805363, 2.971426308221399, -0.2])
    solution = solved("free-particle-spherical")
    state, truth = (solution.motion(**start, digits=digits).at(times) for digits in (15, 25))
    with mpmath.workdps(40):
        for name in ("r", "theta", "phi"):
            for group in ("q", "p"):
                ours, theirs = getattr(state, group)[name], getattr(truth, group)[name]
                claimed = getattr(state.error, group)[name]
                assert all(abs(mpmath.mpf(x) - y) <= c for x, y, c in zip(ours, theirs, claimed))
