"""Motions that stay on an axis of their web and pass its foci, where V is regular: against Taylor series in x, y, z."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from mpmath import mp

import hjsolve
from hjsolve.motion.charted.in_a_plane import MotionInPlane
from tests.reference.taylor import Flow

GARNIER = "(x**2 + y**2)**2 + x**2 + 3/2*y**2"
TURNED = "(x**2 + y**2)**2 + (3*x - 4*y)**2/25 + 3*(4*x + 3*y)**2/50"
KDV = "(x**2 + 4*y**2)/2 + x**2*y + 2*y**3"
KUZMIN_KUTUZOV = "-3/sqrt(x**2 + y**2 + z**2 + 5 + 2*sqrt(4 + x**2 + y**2 + 4*z**2))"


def solved(potential: str) -> hjsolve.Solution:
    names = "xyz" if "z" in potential else "xy"
    kinetic = " + ".join(f"dot({q})**2/2" for q in names)
    return hjsolve.solve(hjsolve.System(dict.fromkeys(names, "line"), kinetic, potential), coordinates="find")


def start(place: str, speed: str) -> dict[str, dict[str, str]]:
    """Places and velocities written with spaces between."""
    return {
        "q": dict(zip("xyz", place.split(), strict=False)),
        "velocity": dict(zip("xyz", speed.split(), strict=False)),
    }


@pytest.mark.rotating(3)
@pytest.mark.nightly_cases("-3/sqrt(x**2 + y**2 + z**2 + 5 + 2*sqrt(4 + x**2 + y**2 + 4*z**2))-0 0 1-0 0 1-kinds6")
@pytest.mark.parametrize(
    ("potential", "place", "speed", "kinds"),
    [
        (GARNIER, "-0.772 0", "0.5 0", {"X": "libration"}),
        (TURNED, "0.6 -0.8", "1.2 -1.6", {"X": "libration"}),  # its axis is not an axis of x, y
        (KDV, "0 0.06", "0 0.03", {"X": "libration"}),
        (KDV, "0 0", "0 -0.07", {"X": "libration"}),  # from the focus
        ("x**4 + 12*x**2*y**2 + 16*y**4", "-0.565 0", "0 0", {"Y": "libration"}),  # across the axis of the parabolas
        pytest.param(
            f"{GARNIER} + z**4",
            "-0.849 0 -0.047",
            "0 0 -0.226",
            {"X": "libration", "Z": "libration"},
            marks=pytest.mark.slow,
        ),
        pytest.param(KUZMIN_KUTUZOV, "0 0 1", "0 0 1", {"Z": "libration"}, marks=pytest.mark.slow),
    ],
)
def test_motions_pass_foci_where_v_is_regular(potential: str, place: str, speed: str, kinds: dict[str, str]) -> None:
    solution, given = solved(potential), start(place, speed)
    motion = solution.motion(**given)
    assert isinstance(motion, MotionInPlane)
    assert motion.kinds == kinds
    period = max(p.value for p in motion.periods.values())
    times = [0.0, 0.4 * period, 0.9 * period]
    state = motion.at(times)
    assert list(state.status) == ["ok"] * 3
    system = solution.chart.original
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    with mp.workdps(40):
        begin = [mp.mpf(x) for x in (place + " " + speed).split()]
        flow = Flow(sum(p**2 for p in momenta) / 2 + system.potential, places, momenta, {}, begin, digits=22)
        for k, t in enumerate(times):
            exact = flow.at(mp.mpf(t))
            for i, c in enumerate(system.coordinates):
                assert abs(mp.mpf(state.q[c.name][k]) - exact[i]) <= state.error.q[c.name][k] <= 1e-11
                speed_off = abs(mp.mpf(state.velocity[c.name][k]) - exact[len(places) + i])
                assert speed_off <= state.error.velocity[c.name][k] <= 1e-11


def test_a_motion_that_leaves_the_axis_from_a_focus_comes_back_to_the_focus() -> None:
    """The force points away from the axis along which it starts; it was refused. Against Taylor series."""
    solution = solved(KDV)
    motion = solution.motion(**start("0 0", "0.1 0"))
    assert not isinstance(motion, MotionInPlane)
    system = solution.chart.original
    places, momenta = [c.symbol for c in system.coordinates], [c.momentum for c in system.coordinates]
    times = [0.5, 4.0, 9.0]
    state = motion.at(times)
    with mp.workdps(40):
        begin = [mp.mpf(0), mp.mpf(0), mp.mpf("0.1"), mp.mpf(0)]
        flow = Flow(sum(p**2 for p in momenta) / 2 + system.potential, places, momenta, {}, begin, digits=22)
        for k, t in enumerate(times):
            exact = flow.at(mp.mpf(t))
            for i, c in enumerate(system.coordinates):
                assert abs(mp.mpf(state.q[c.name][k]) - exact[i]) <= state.error.q[c.name][k] <= 1e-11
                off = abs(mp.mpf(state.velocity[c.name][k]) - exact[2 + i])
                assert off <= state.error.velocity[c.name][k] <= 1e-11


def test_rest_at_a_focus_is_rest() -> None:
    motion = solved(KDV).motion(**start("0 0", "0 0"))
    assert set(motion.kinds.values()) == {"equilibrium"}
    assert motion.at(7).q == {"x": 0.0, "y": 0.0}


@pytest.mark.slow
def test_it_can_be_asked_for_digits_passages_and_reports_and_pickled(tmp_path) -> None:
    motion = solved(TURNED).motion(**start("0.6 -0.8", "1.2 -1.6"))
    again = pickle.loads(pickle.dumps(motion))
    assert again.at(1.5).q == motion.at(1.5).q
    fine = solved(TURNED).motion(**start("0.6 -0.8", "1.2 -1.6"), digits=30)
    assert abs(fine.at(1.5).q["x"] - motion.at(1.5).q["x"]) <= motion.at(1.5).error.q["x"]
    assert fine.at(1.5).error.q["x"] < 1e-25
    assert motion.time_at("X", 0).value > 0
    assert motion.chart.transformation["x"].free_symbols == {motion.solution.system.symbols["X"]}
    hjsolve.report(motion, tmp_path / "axis.txt")
    assert "X" in (tmp_path / "axis.txt").read_text()


@pytest.mark.nightly
@pytest.mark.slow
def test_in_ensembles_they_get_a_status_and_stop_nobody() -> None:
    x, y = np.array([-0.7, 0.3, 0.7071067811865476]), np.zeros(3)  # the focus is at √½
    vx, vy = np.array([0.5, 0.1, 0.2]), np.array([0.0, 0.2, 0.1])
    batch = hjsolve.ensemble(solved(GARNIER), q={"x": x, "y": y}, velocity={"x": vx, "y": vy})
    assert batch.status.tolist()[:2] == ["asymptotic", "ok"]
    assert batch.status.tolist()[2] in ("ok", "not_converged")
