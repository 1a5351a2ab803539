"""The Taylor series that trajectories are measured against: every function, symmetric starts, deadlines."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import pytest
import sympy as sp
from mpmath import mp

import hjsolve
from hjsolve.arithmetic.floats import Multi
from hjsolve.arithmetic.power_series import ConstantSeries, FixedPoint, FloatingPoint, SeriesNumbers, SeriesProgram
from hjsolve.costs.taylor import follow
from hjsolve.lowering import lower
from hjsolve.mechanics.system import hamiltonian, velocities
from hjsolve.motion.initial_data import to_bits

X = sp.Symbol("x")
FUNCTIONS = [
    sp.sin(X), sp.cos(X), sp.tan(X), sp.sinh(X), sp.cosh(X), sp.tanh(X), sp.exp(X), sp.log(X), sp.sqrt(X), sp.asin(X),
    sp.acos(X), sp.atan(X), sp.asinh(X), sp.acosh(2 + X), sp.atanh(X), X**5, X**-3, 1 / (1 + X), sp.pi - X * (X + 2),
    (1 + X) ** sp.Rational(3, 2), (1 + X) ** sp.Rational(1, 3),
]  # fmt: skip


@pytest.mark.rotating(3)
@pytest.mark.parametrize("numbers", [FixedPoint(400), FloatingPoint(Multi(400))], ids=["fixed", "floating"])
@pytest.mark.parametrize("formula", FUNCTIONS, ids=str)
def test_every_function_has_its_series(formula: sp.Expr, numbers: SeriesNumbers[Any]) -> None:
    program = SeriesProgram(numbers)
    inner = program.new()
    out = lower([formula], [X]).run(program, [inner])[0]
    assert not isinstance(out, ConstantSeries)
    given = [sp.Rational(3, 10), sp.Rational(1, 7), sp.Rational(-1, 11), sp.Rational(1, 13), sp.Rational(1, 17)]
    h = sp.Symbol("h")
    path = formula.subs(X, sum(c * h**k for k, c in enumerate(given)))
    with mp.workdps(80):
        for k, coefficient in enumerate(given):
            inner.append(numbers.of(to_bits(coefficient)(400)))
            program.extend(k)
            expected = sp.N(sp.diff(path, h, k).subs(h, 0) / sp.factorial(k), 60)
            assert abs(mp.mpf(numbers.real(out[k])) - mp.mpf(expected)) < mp.mpf(10) ** -55, k


def flow_of(name: str, digits: int, times: list[int]) -> tuple[list[list[object]], object]:
    entry = hjsolve.catalog.describe(name)
    system = entry.system
    motion = hjsolve.solve(system).motion(**entry.initial.arguments, digits=digits)
    H, speeds = hamiltonian(system), velocities(system)
    variables = [c.symbol for c in system.coordinates] + [c.momentum for c in system.coordinates]
    slopes = [speeds[c.name] for c in system.coordinates] + [-sp.diff(H, c.symbol) for c in system.coordinates]
    parameters = [p.symbol for p in system.parameters]
    values = [to_bits(motion.initial.values[s])(400) for s in (*variables, *parameters)]
    n = len(variables)
    moments = [to_bits(sp.Integer(t))(400) for t in times]
    states = follow(lower(slopes, [*variables, *parameters]), moments[0] * 0, values[:n], values[n:], moments, digits)
    return states, motion


@pytest.mark.parametrize("name", ["pendulum", "kepler-planar", "morse"])
def test_it_agrees_with_the_quadratures(name: str) -> None:
    """The pendulum starts at 90°, where three of four coefficients vanish."""
    states, motion = flow_of(name, 40, [1, 7, 20])
    state = motion.at([1, 7, 20])  # type: ignore[attr-defined]
    names = [c.name for c in motion.solution.system.coordinates]  # type: ignore[attr-defined]
    for k, reached in enumerate(states):
        truth = [state.unwrapped(n)[k] for n in names] + [state.p[n][k] for n in names]
        assert max(abs(a - b) for a, b in zip(reached, truth, strict=True)) < 1e-37  # type: ignore[operator]


def test_backwards_undoes_forwards() -> None:
    there, _ = flow_of("pendulum", 30, [3])
    back, _ = flow_of("pendulum", 30, [-3])
    assert abs(there[0][0] - back[0][0]) < 1e-28  # type: ignore[operator]
    assert abs(there[0][1] + back[0][1]) < 1e-28  # type: ignore[operator]


@pytest.mark.timeout(120)
def test_it_stops_when_it_cannot_be_done_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes on by a second whenever it is read: ten steps of millions are taken at most."""
    readings = itertools.count(1.0)
    monkeypatch.setattr("hjsolve.costs.taylor.time", SimpleNamespace(perf_counter=lambda: next(readings)))
    slope = lower([sp.cos(X)], [X])
    start, far = to_bits(sp.S.Zero)(800), to_bits(sp.Integer(10) ** 6)(800)
    assert follow(slope, start, [start + 1], [], [far], 120, deadline=10) == []
    assert next(readings) < 12
