"""States of escaping motions at finite times, whatever is known of their way to infinity: against Taylor series."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from tests.reference.taylor import Flow

TIMES = (0.4, 1.3, 3.0)
PARABOLIC = (  # in r + y and r − y there are logarithms of fourth powers, and z has the time for itself
    "((sqrt(x**2 + y**2) - y)**3 + 7*log((sqrt(x**2 + y**2) + y)**2 + 2)/10)/sqrt(x**2 + y**2) + 3*z**2/10"
    " - 3*log(z**2 + 7/10)/10"
)


def check(solution: hjsolve.Solution, system: hjsolve.System, place: str, speed: str, times: list[float]) -> None:
    """Compare the states at some times with Hamilton's equations."""
    names = [c.name for c in system.coordinates]
    q, velocity = (dict(zip(names, text.split(), strict=True)) for text in (place, speed))
    motion = solution.motion(q=q, velocity=velocity)
    assert "escape" in motion.kinds.values()
    state = motion.at(times)
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    with mp.workdps(40):
        begin = [mp.mpf(x) for x in (place + " " + speed).split()]
        flow = Flow(sum(p**2 for p in momenta) / 2 + system.potential, places, momenta, {}, begin, digits=22)
        for k, t in enumerate(times):
            assert state.status[k] == "ok"
            exact = flow.at(mp.mpf(t))
            for i, c in enumerate(names):
                pairs = (
                    (state.q, state.error.q, exact[i]),
                    (state.velocity, state.error.velocity, exact[i + len(names)]),
                )
                for values, errors, truth in pairs:
                    assert abs(mp.mpf(values[c][k]) - truth) <= errors[c][k] <= 1e-9 * (1 + abs(truth))


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "speed"),
    [("0.3 0.4 0.1", "0.2 -0.1 0.5"), ("-0.7 0.2 -0.3", "0.1 0.6 0"), ("0.1 -0.9 0.2", "-0.4 0.3 -0.6")],
)
def test_one_without_a_part_in_the_time_escapes_where_v_overflows_far_away(place: str, speed: str) -> None:
    system = hjsolve.System(dict.fromkeys("xyz", "line"), "dot(x)**2/2 + dot(y)**2/2 + dot(z)**2/2", PARABOLIC)
    check(hjsolve.solve(system, coordinates="find"), system, place, speed, [*TIMES, 12.0])


def made(number: int) -> str:
    """A random potential of algebraic, logarithmic or exponential growth or decay, on which a motion escapes."""
    dice, q = random.Random(f"escape {number}"), sp.Symbol("q")
    a, b = sp.Rational(dice.randint(1, 12), 10), sp.Rational(dice.randint(3, 20), 10)
    told = (
        -a * sp.log(b + q ** dice.choice((2, 4, 6)) / 4),
        -a * (b + q**2) ** sp.Rational(dice.randint(1, 7), 4),
        -a * q**2 * (1 + sp.exp(-b * q**2)),
        -a * q / (b + q**2) - 2,
        -a * sp.log(2 + sp.log(b + 1 + q**2)),
        -a * sp.sqrt(1 + sp.exp(2 * q)) - q,
        -a * q * sp.log(1 + q**2) - a * q**2,
        -a * sp.sqrt(b + q**6) / (1 + q**2),
    )
    return str(told[number % len(told)])


@pytest.mark.parametrize("number", range(8))
def test_random_escapes_at_early_times(number: int) -> None:
    system = hjsolve.System({"q": "line"}, "dot(q)**2/2", made(number))
    check(hjsolve.solve(system), system, "0.3", "1.5", [0.2, 0.6])


@pytest.mark.nightly
@pytest.mark.slow
def test_a_way_that_is_not_known_to_its_end_is_no_end() -> None:
    """The last panels that can be computed are short, and integrals do not grow over them: that is not a finite time."""
    system = hjsolve.System({"q": "line"}, "dot(q)**2/2", "-q**2*(1 + exp(-2*q**2))/5 - 9*atan(q**3)/10")
    motion = hjsolve.solve(system).motion(q={"q": "0.3"}, velocity={"q": "1"})
    late = motion.at([10, 1000, 1e6])
    assert list(late.status) == ["ok", "not_converged", "not_converged"]
    assert np.isfinite(late.q["q"][0])
    assert np.isnan(late.q["q"][1:]).all()
    assert motion.at(1000).status == "not_converged"
