"""Charges in uniform fields in any gauge, traps, drifts, repeated exponents: every linear system has its motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.command_line.main import main
from hjsolve.extended.stability_limit import stability_ranges

SPACE = {"x": "line", "y": "line", "z": "line"}
T = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
VALUES = {"m": "2", "e": "3", "B": "1/2", "F": "1/5"}
GAUGES = {
    "Landau": "- e*B*y*dot(x)",
    "Landau, the other": "+ e*B*x*dot(y)",
    "symmetric": "+ e*B/2*(x*dot(y) - y*dot(x))",
    "with a gradient": "+ e*B/2*(x*dot(y) - y*dot(x)) + 7*(x*dot(y) + y*dot(x)) + z*dot(z) + 4*dot(x)",
}
TIMES = [0, "0.5", "3", "40"]


def crossed(gauge: str) -> hjsolve.System:
    return hjsolve.System(SPACE, f"{T} {GAUGES[gauge]}", "-e*F*y", VALUES)


@pytest.mark.parametrize("gauge", GAUGES)
def test_a_charge_in_crossed_fields_moves_the_same_in_every_gauge(gauge: str) -> None:
    """C55: x = (E/B) t − (m E/e B²) sin(e B t/m), y = (m E/e B²)(1 − cos(e B t/m)), from rest."""
    modes = hjsolve.gyroscopic_modes(crossed(gauge), digits=25)
    rest = dict.fromkeys("xyz", 0)
    motion = modes.motion(q=rest, velocity=rest)
    state = motion.at(TIMES)
    with mp.workdps(40):
        m, e, B, F = mpf(2), mpf(3), mpf(1) / 2, mpf(1) / 5
        for k, t in enumerate(map(mpf, TIMES)):
            a, phase = m * F / (e * B**2), e * B * t / m
            for name, expected in (("x", F / B * t - a * mp.sin(phase)), ("y", a * (1 - mp.cos(phase))), ("z", 0)):
                assert abs(mpf(state.q[name][k]) - expected) <= mpf(state.error.q[name][k]) <= mpf(10) ** -22
            assert abs(mpf(state.velocity["y"][k]) - a * e * B / m * mp.sin(phase)) <= mpf(state.error.velocity["y"][k])
    assert motion.kinds == {"x": "escape", "y": "libration", "z": "equilibrium"}
    assert (modes.drifts, modes.complete, len(modes.frequencies)) == (2, False, 1)


def test_a_penning_trap_has_its_three_frequencies_and_a_mode_of_negative_energy() -> None:
    """ω± = (ω_c ± √(ω_c² − 2 ω_z²))/2 and ω_z (Brown and Gabrielse 1986, (2.12)); the magnetron mode is slow."""
    trap = hjsolve.System(
        SPACE, "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2 + w/2*(x*dot(y) - y*dot(x))", "k/2*(z**2 - (x**2 + y**2)/2)",
        {"w": 3, "k": 2},
    )  # fmt: skip
    modes = hjsolve.gyroscopic_modes(trap, digits=30)
    with mp.workdps(40):
        expected = sorted([(3 - mp.sqrt(5)) / 2, mp.sqrt(2), (3 + mp.sqrt(5)) / 2])
        assert all(abs(mpf(f) - e) < mpf(10) ** -28 for f, e in zip(modes.frequencies, expected, strict=True))
    assert modes.stable
    assert modes.signs == (-1, 1, 1)
    ranges = stability_ranges(modes, "w")
    assert [r.stable for r in ranges] == [True, False, True]
    assert (ranges[0].upper, ranges[1].upper) == (-2, 2)  # ω_c² > 2 ω_z²


def test_repeated_exponents_with_a_complete_set_of_modes_are_stable() -> None:
    """Two equal springs, a turn of the axes added: H = Σ (q² + p²)/2 in every frame, the signs from the eigenspace."""
    equal = hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "(x**2 + y**2)/2")
    modes = hjsolve.gyroscopic_modes(equal)
    assert (modes.stable, modes.complete, [float(f) for f in modes.frequencies]) == (True, True, [1.0, 1.0])
    four = hjsolve.System(
        {"a": "line", "b": "line", "c": "line", "d": "line"},
        "(dot(a)**2 + dot(b)**2 + dot(c)**2 + dot(d)**2)/2 + a*dot(b) - b*dot(a) + c*dot(d) - d*dot(c)",
        "-(a**2 + b**2 + c**2 + d**2)/8",
    )
    modes = hjsolve.gyroscopic_modes(four, digits=25)
    assert (modes.stable, modes.signs) == (True, (-1, -1, 1, 1))
    n = 8
    with mp.workdps(40):
        N, J = mp.matrix(modes.matrix.tolist()), mp.matrix(n)
        for i in range(4):
            J[i, 4 + i], J[4 + i, i] = 1, -1
        assert mp.norm(N.T * J * N - J, mp.inf) < mpf(10) ** -23


def test_repeated_exponents_with_too_few_modes_are_not_stable_and_drift_with_t() -> None:
    """C87: a free particle seen from turning axes, X = (1 + t/5) cos t + …: λ = ±i twice, one mode each."""
    modes = hjsolve.gyroscopic_modes("free-particle-turning-axes", digits=20)
    assert (modes.stable, modes.complete, modes.frequencies) == (False, False, ())
    state = modes.motion(q={"x": 1, "y": 0}, velocity={"x": "0.1", "y": "0.2"}).at(["2.5"])
    X, Y, t = 1 + mpf("0.1") * mpf("2.5"), mpf("1.2") * mpf("2.5"), mpf("2.5")  # velocity in space (0.1, 0.2 + w x)
    with mp.workdps(30):
        expected = mp.cos(t) * X + mp.sin(t) * Y, -mp.sin(t) * X + mp.cos(t) * Y
        for name, value in zip("xy", expected, strict=True):
            assert abs(mpf(state.q[name][0]) - value) <= mpf(state.error.q[name][0]) + mpf(10) ** -18


@pytest.mark.parametrize("digits", [15, 30])
def test_an_unstable_motion_grows_as_its_exponents_say(digits: int) -> None:
    """ẍ = 2 ẏ + 3 x, ÿ = −2 ẋ + 3 y: with w = x + i y, ẅ = −2 i ẇ + 3 w, exponents −i ± √2."""
    hill = hjsolve.System(
        {"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2 + x*dot(y) - y*dot(x)", "-3*(x**2 + y**2)/2"
    )
    modes = hjsolve.gyroscopic_modes(hill, digits=digits)
    assert not modes.stable
    state = modes.motion(q={"x": 1, "y": 0}, velocity={"x": 0, "y": 0}).at(np.array([0.0, 7.5]))
    with mp.workdps(50):
        for k, t in enumerate((mpf(0), mpf("7.5"))):
            r, s = mp.mpc(mp.sqrt(2), -1), mp.mpc(-mp.sqrt(2), -1)
            w = (r * mp.exp(s * t) - s * mp.exp(r * t)) / (r - s)
            assert abs(mpf(state.q["x"][k]) - w.real) <= mpf(state.error.q["x"][k])
            assert abs(mpf(state.q["y"][k]) - w.imag) <= mpf(state.error.q["y"][k])
            assert mpf(state.error.q["x"][k]) <= abs(w) * mpf(10) ** (1 - digits)


@pytest.mark.parametrize(
    ("name", "given", "parameter", "squares"),
    [
        ("gyroscopic-pair", {"k11": -1, "k12": 1, "k22": -8}, "gamma", 36),
        ("gyroscopic-pair", {"k22": 8}, "gamma", None),
    ],
)
def test_the_stability_limit_of_example_3_4(name: str, given: dict[str, Any], parameter: str, squares: Any) -> None:
    """(3-129): case 2 is stable if and only if γ² > 36; case 1 for every γ."""
    ranges = stability_ranges(hjsolve.gyroscopic_modes(name, parameters=given), parameter)
    if squares is None:
        assert [r.stable for r in ranges] == [True]
    else:
        assert [(r.lower, r.upper, r.stable) for r in ranges] == [
            (-sp.oo, -6, True), (-6, 6, False), (6, sp.oo, True)
        ]  # fmt: skip


@pytest.mark.nightly
def test_the_stability_limit_of_problem_3_11() -> None:
    """Stable iff γ² > 4.490 m k, where the discriminant vanishes."""
    ranges = stability_ranges(hjsolve.gyroscopic_modes("gyroscopic-three"), "gamma")
    assert [r.stable for r in ranges] == [True, False, True]
    assert abs(sp.N(ranges[1].upper ** 2, 20) - sp.Float("4.49004")) < 1e-5
    assert str(ranges[1]).endswith("not stable")
    with pytest.raises(hjsolve.InvalidInputError, match="do not depend on a parameter"):
        stability_ranges(hjsolve.gyroscopic_modes("gyroscopic-three"), "g")


def test_the_command_line_answers_with_modes_and_motions(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "gyroscopic-pair"]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("Its modes", "±0.5825873576 i", "positive energy", "H = ½ ω₁", "(3-118)"))
    assert main(["check", "gyroscopic-pair"]) == 1
    assert "Its modes" in capsys.readouterr().out
    assert main(["motion", "crossed-fields-symmetric-gauge", "--times", "0,1"]) == 0
    header, first, second = capsys.readouterr().out.splitlines()
    assert header.startswith("t,q.x,q.y,q.z,p.x")
    x, y = (float(second.split(",")[k]) for k in (1, 2))
    assert abs(x - 0.5 * (1 - float(mp.sin(1)))) < 1e-15
    assert abs(y - 0.5 * (1 - float(mp.cos(1)))) < 1e-15
    assert first.endswith("ok")


@pytest.mark.nightly_cases("free-particle-turning-axes", "gyroscopic-three")
@pytest.mark.parametrize("name", ["free-particle-turning-axes", "crossed-fields-symmetric-gauge", "gyroscopic-three"])
def test_the_report_of_a_linear_system_has_its_modes(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", name, "-o", "-", "--brief"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert "Its modes" in out
    assert "The motion, to ten digits" in out
    words = {"free-particle-turning-axes": "grows with t", "crossed-fields-symmetric-gauge": "it drifts"}
    assert words.get(name, "2.118971421 to ∞") in out
    assert "surface of section" not in out


@pytest.mark.nightly
def test_no_advice_leads_to_a_dead_end() -> None:
    """What the advice of a refused linear system names gives its motion."""
    for name in hjsolve.catalog.ids("refused"):
        verdict = hjsolve.separate(name)
        if "gyroscopic_modes" in verdict.advice:
            start = {c.name: "0.1" for c in verdict.system.coordinates}
            motion = hjsolve.gyroscopic_modes(verdict.system).motion(q=start, velocity=start)
            assert list(motion.at([0, 1]).status) == ["ok", "ok"]
