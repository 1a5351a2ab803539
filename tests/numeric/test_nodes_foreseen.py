"""Many digits: the nodes they need are told by the decay of the coefficients in few digits."""

import math

import pytest
from mpmath import mp

import hjsolve
from hjsolve.numeric.arithmetic import multiprecision
from hjsolve.numeric.radicand import Radicand
from hjsolve.numeric.series import fit, foreseen


@pytest.mark.parametrize("radius", ["0.2", "0.9"])
@pytest.mark.parametrize("digits", [100, 700])
def test_a_geometric_series_needs_as_many_nodes_as_it_has_terms_above_the_last_digit(radius, digits):
    """(1 − r²)/(1 − 2r cos χ + r²) = 1 + 2 Σ rᵏ cos kχ."""
    context = multiprecision(300)
    r = context.mpf(radius)

    def function(χ):
        return [(1 - r * r) / (1 - 2 * r * context.cos(χ) + r * r)]

    few = [fit(function, even=True, digits=d, bits=300) for d in (15, 30)]
    needed = digits / -math.log10(float(radius))
    assert needed <= foreseen(*few, digits) <= 1.08 * needed + 40


@pytest.mark.parametrize(("name", "q", "velocity"), [("pendulum", "0.3", "1.7"), ("pendulum", "0", "2.5")])
def test_few_values_of_p_squared_are_worked_out_twice(name, q, velocity, monkeypatch):
    """12, 36, 108, … nodes were tried one after the other, all in full digits: nearly twice as many as the last."""
    dear = []
    own = Radicand.value

    def value(self, q, bits):
        dear.append(bits > 300)
        return own(self, q, bits)

    monkeypatch.setattr(Radicand, "value", value)
    solution = hjsolve.solve(hjsolve.catalog.load(name))
    (coordinate,) = (c.name for c in solution.system.coordinates)
    start = {"q": {coordinate: q}, "velocity": {coordinate: velocity}, "want": ["periods"]}
    motion = solution.motion(**start, digits=120)
    assert sum(dear) <= 1.25 * motion.nodes + 40
    with mp.workdps(170):
        better = solution.motion(**start, digits=160).periods[coordinate]
        period = motion.periods[coordinate]
        assert abs(period.value - better.value) <= period.error <= mp.mpf("1e-119") * period.value
