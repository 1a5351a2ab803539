"""Declared frames and gauges (Ex 2-5, Ex 6-9, P6-13): verified, solved, and expressed in the original coordinates."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp
from mpmath import mp, mpf

from hjsolve import catalog, frames
from hjsolve.errors import CatalogError, InvalidInputError, InvalidSystemError, MissingValueError
from hjsolve.mechanics.system import hamiltonian, momenta
from hjsolve.separation.zero_test.zero_test import Zero, is_zero
from tests.reference.taylor import Flow

IDS = ["spring-moving-anchor", "oscillator-drifting-gauge", "spring-turning-anchor"]
DATA: dict[str, dict[str, Any]] = {
    "spring-moving-anchor": {"q": {"q": "0.3"}, "velocity": {"q": "-0.4"}, "parameters": {"m": 2, "k": 3}},
    "oscillator-drifting-gauge": {"q": {"q": "0.3"}, "velocity": {"q": "0.4"}, "parameters": {"m": 2}},
    "spring-turning-anchor": {"q": {"x": "0.3", "y": "1"}, "velocity": {"x": "0.4", "y": "0"},
                              "parameters": {"w": "0.7"}},
}  # fmt: skip


@pytest.mark.parametrize("name", IDS)
def test_the_frame_is_verified_and_the_new_system_holds_no_time(name: str) -> None:
    frame = frames.load(name)
    assert isinstance(is_zero(frame.residual()), Zero)
    assert "t" not in {s.name for s in hamiltonian(frame.system).free_symbols}
    assert frame.time in hamiltonian(frame.original).free_symbols


def test_the_books_new_hamiltonians() -> None:
    """P6-13: K = P²/2m + kq²/2 + mq, by F2 = (P + mt)q; Ex 6-9: the oscillator of Q = q − t."""
    frame = frames.load("oscillator-drifting-gauge")
    q, m, k = (frame.system.symbols[n] for n in ("Q", "m", "k"))
    P, t, p = frame.system.coordinate("Q").momentum, frame.time, frame.original.coordinate("q").momentum
    assert sp.expand(hamiltonian(frame.system) - (P**2 / (2 * m) + k * q**2 / 2 + m * q)) == 0
    assert frame.new_momenta() == {P: p - m * t}
    old = frame.original.symbols["q"]
    assert sp.expand(hamiltonian(frame.original) - (p**2 / (2 * m) - t * p + k * old**2 / 2)) == 0
    moving = frames.load("spring-moving-anchor")
    assert moving.inverse() == {moving.system.symbols["Q"]: moving.original.symbols["q"] - moving.time}


@pytest.mark.parametrize("name", IDS)
def test_the_constants_are_constant_in_the_original_variables(name: str) -> None:
    """∂f/∂t + (f, H) = 0, (6-235)."""
    frame = frames.load(name)
    for constant in frame.constants(frame.solve()).values():
        assert frame.time in constant.free_symbols
        assert sp.simplify(frames.drift(frame, constant)) == 0


@pytest.mark.parametrize("name", IDS)
def test_the_motion_is_that_of_a_taylor_integration_with_explicit_time(name: str) -> None:
    """The time made a coordinate τ with momentum p_τ: H + p_τ (6-296)."""
    frame, given = frames.load(name), DATA[name]
    moved = frame.motion(**given, t0="0.5", digits=25)
    system = frame.original
    values = {**moved.motion.initial.values, frame.time: sp.Rational(1, 2)}
    with mp.workdps(50):
        τ, p_τ = sp.Symbol("tau"), sp.Symbol("p_tau")
        H = hamiltonian(system).subs(frame.time, τ) + p_τ
        q, p = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
        at = {c.symbol: sp.Rational(str(given["q"][c.name])) for c in system.coordinates}
        at |= {c.velocity: sp.Rational(str(given["velocity"][c.name])) for c in system.coordinates}
        starts = [f.subs({**values, **at}) for f in momenta(system).values()]
        begin = [*(at[s] for s in q), sp.Rational(1, 2), *starts, 0]
        parameters = {s.symbol: mpf(sp.N(values[s.symbol], 50)) for s in frame.system.parameters}
        flow = Flow(H, [*q, τ], [*p, p_τ], parameters, [mpf(sp.N(x, 50)) for x in begin], digits=30)
        for t in ("0.5", "2", "5"):
            expected, state = flow.at(mpf(t) - mpf("0.5")), moved.at(t)
            for k, c in enumerate(system.coordinates):
                assert abs(mp.mpf(state.q[c.name]) - expected[k]) < mpf(10) ** -22
                assert abs(mp.mpf(state.p[c.name]) - expected[len(q) + 1 + k]) < mpf(10) ** -22


@pytest.mark.parametrize("name", IDS)
def test_in_doubles_the_error_is_a_bound(name: str) -> None:
    frame, times = frames.load(name), [0.5, 1.25, 3.0, 40.0]
    plain, sharp = (frame.motion(**DATA[name], t0="0.5", digits=d).at(times) for d in (15, 30))
    for part in ("q", "p", "velocity"):
        for coordinate, values in getattr(plain, part).items():
            better, bounds = getattr(sharp, part)[coordinate], getattr(plain.error, part)[coordinate]
            for a, b, e in zip(values, better, bounds, strict=True):
                assert abs(mpf(float(a)) - b) <= e < 1e-11


def test_a_false_frame_is_refused_with_what_is_left_over() -> None:
    table, source = catalog.read("spring-moving-anchor")
    system = catalog.from_table(table, source=source)
    for change, text in (
        ({"place": {"q": "Q + 2*t"}}, "not zero"), ({"gauge": "m*Q"}, r"L - L' - dΛ/dt is m/2, not zero"),
        ({"place": {"q": "Q**3 + t"}}, "affine"), ({"place": {"q": "t"}}, "not invertible"),
    ):  # fmt: skip
        with pytest.raises(InvalidSystemError, match=text):
            frames.from_table({**table, "frame": {**table["frame"], **change}}, system, source)
    with pytest.raises(CatalogError, match="frame: missing"):
        frames.load("pendulum")


def test_initial_data_are_checked() -> None:
    frame = frames.load("spring-turning-anchor")
    with pytest.raises(InvalidInputError, match="either velocity"):
        frame.motion(q={"x": 0, "y": 0})
    with pytest.raises(MissingValueError, match="q: no value for y; every coordinate needs one"):
        frame.motion(q={"x": 0}, velocity={"x": 0, "y": 0})


def test_the_command_line_speaks_both_coordinates_of_a_frame(capsys: pytest.CaptureFixture[str]) -> None:
    """The entry's own motion, at rest at first: q = Q + t for the anchor that moves with the speed 1."""
    from hjsolve.command_line.main import main

    assert main(["motion", "spring-moving-anchor", "--times", "0,1.5"]) == 0
    header, _, row = capsys.readouterr().out.splitlines()
    at = dict(zip(header.split(","), row.split(","), strict=True))
    assert {"q.Q", "q.q", "p.Q", "p.q", "error.q.q"} <= set(at)
    assert abs(float(at["q.q"]) - float(at["q.Q"]) - 1.5) <= float(at["error.q.q"]) + float(at["error.q.Q"])
