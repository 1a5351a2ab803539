"""∫ L dt along paths and ∮ p dq of loops: closed forms, the principal function of a motion, invariance."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

import hjsolve
from hjsolve.command_line.main import main

FALL = hjsolve.System({"y": "line"}, "m/2*dot(y)**2", "m*g*y", {"m": 1, "g": 10})
OSCILLATOR = hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2")
PENDULUM = hjsolve.System({"theta": "angle"}, "dot(theta)**2/2", "-cos(theta)")


@pytest.mark.parametrize(("path", "value"), [("-5*t", "37.5"), ("-5*t**2", "100/3"), ("-5*t**3", "35")])
def test_the_action_of_a_fall(path: str, value: str) -> None:
    """The integral of y'**2/2 - 10 y over the unit of time; it is least for the motion."""
    found = hjsolve.action_integral(FALL, {"y": path}, between=(0, 1)).value
    numerator, _, denominator = value.partition("/")
    expected = mpf(numerator) / mpf(denominator or 1)
    assert abs(found.value - expected) <= found.error <= 1e-14


def test_the_action_of_a_path_through_functions_at_thirty_digits() -> None:
    """x = exp(-t) sin(3 t): L by hand, integrated by Gauss and Legendre's rule in 50 digits."""
    found = hjsolve.action_integral(OSCILLATOR, {"x": "exp(-t)*sin(3*t)"}, between=("-1/2", "2"), digits=30)
    with mp.workdps(50):

        def L(t: mpf) -> mpf:
            x, v = mp.exp(-t) * mp.sin(3 * t), mp.exp(-t) * (3 * mp.cos(3 * t) - mp.sin(3 * t))
            return (v**2 - x**2) / 2

        expected = mp.quad(L, [mpf(-1) / 2, 0, 1, 2])
        assert abs(mpf(found.value.value) - expected) <= found.value.error <= mpf(10) ** -28


def test_the_action_along_the_motion_is_its_principal_function() -> None:
    """x = cos t: S(t) = W - E t, which hjsolve computes from quadratures."""
    motion = hjsolve.solve(OSCILLATOR).motion(q={"x": 1}, velocity={"x": 0})
    S = motion.principal_function(2)
    found = hjsolve.action_integral(OSCILLATOR, {"x": "cos(t)"}, between=(0, 2)).value
    assert abs(found.value - S.value) <= found.error + S.error
    driven = hjsolve.System({"x": "line"}, "dot(x)**2/2", "-x*t")
    assert abs(hjsolve.action_integral(driven, {"x": "t"}, between=(1, 2)).value.value - (0.5 + 7 / 3)) < 1e-15


LOOPS: dict[str, tuple[Any, dict[str, str], dict[str, str], float | None]] = {
    "oscillator": (OSCILLATOR, {"x": "1 + cos(s)/5"}, {"x": "-sin(s)/5"}, np.pi / 25),
    "pendulum": (PENDULUM, {"theta": "1 + sin(s)/5"}, {"theta": "cos(s)/5"}, np.pi / 25),
    "pendulum, whole turns": (PENDULUM, {"theta": "s"}, {"theta": "3 + sin(s)/10"}, 6 * np.pi),
    "Kepler": ("kepler-planar", {"r": "1 + sin(s)/20", "theta": "cos(s)/20"},
               {"r": "cos(s)/20", "theta": "1 + sin(s)/20"}, 0.0),
}  # fmt: skip


@pytest.mark.nightly_cases(*list(LOOPS)[1:])
@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_integral_stays(name: str) -> None:
    """The value at t = 0 is known in closed form."""
    system, q, p, value = LOOPS[name]
    found = hjsolve.loop_integral(hjsolve.solve(system), q=q, p=p, times=[0, 2, 7])
    assert found
    assert np.all(np.abs(found.value - value) <= found.error)
    assert np.all(found.error < 1e-10)


def test_an_area_that_is_wrong_is_seen() -> None:
    """q and p of two different systems: the area does not stay, and the answer is false."""
    found = hjsolve.loop_integral(hjsolve.solve(OSCILLATOR), q={"x": "cos(s)"}, p={"x": "-sin(s)"}, times=[0, 1])
    assert found
    assert not hjsolve.LoopIntegral(found.times, found.value * [1, 1.001], found.error, found.points)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ({"q": {"x": "s"}, "p": {"x": "0"}}, "not closed"),
        ({"q": {"x": "cos(s)"}, "p": {"y": "0"}}, "a formula of each of x"),
        ({"q": {"x": "cos(s/2)"}, "p": {"x": "0"}}, "not closed"),
        ({"q": {"x": "cos(s)"}, "p": {"x": "sin(s)"}, "tolerance": 0}, "tolerance"),
    ],
)
def test_a_curve_that_cannot_be_used(call: dict[str, Any], words: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=words):
        hjsolve.loop_integral(hjsolve.solve(OSCILLATOR), **call)


@pytest.mark.nightly
def test_both_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    fall = ["--coordinate", "y: line", "-T", "dot(y)**2/2", "-V", "10*y"]
    assert main(["action", *fall, "--path", "y = -5*t", "--between", "0:1"]) == 0
    assert "37.5" in capsys.readouterr().out
    assert main(["action", *fall, "--path", "y = -5*t", "--between", "0:1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["value"]["value"] == 37.5
    assert main(["action", *fall, "--path", "y = -5*t"]) == 2
    capsys.readouterr()
    own = ["--coordinate", "x: line", "-T", "dot(x)**2/2", "-V", "x**2/2"]
    curve = ["--q", "x=1 + cos(s)/5", "--momentum", "x=-sin(s)/5", "--times", "0,2"]
    assert main(["loop", *own, *curve]) == 0
    assert "They agree" in capsys.readouterr().out
    assert main(["loop", *own, *curve, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["value"] == pytest.approx([np.pi / 25] * 2, abs=1e-13)


def test_a_path_that_is_no_formula_is_one_error():
    fall = hjsolve.System({"y": "line"}, "m/2*dot(y)**2", "m*g*y", {"m": 1, "g": 10})
    with pytest.raises(hjsolve.HJSolveError, match=r"path\.y: a formula is needed, as text or of sympy, not dict"):
        hjsolve.action_integral(fall, {"y": {"t": 1}}, between=(0, 1))
    with pytest.raises(hjsolve.InvalidInputError, match="path: a formula of each of y is needed"):
        hjsolve.action_integral(fall, {"x": "t"}, between=(0, 1))
