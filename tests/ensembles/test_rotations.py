"""Rotations that are slow at two places: double wells on a circle, and orbits about two centres in their plane."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles.engine import nodes, turned_circle
from hjsolve.ensembles.engine.strips_of_analyticity import covered_turn

COUNT = 24


def double_well(seed: int) -> tuple[hjsolve.System, np.ndarray, np.ndarray]:
    """A random potential on a circle with two tops, and starts from far above them to 1e-5 above the higher one."""
    dice = np.random.default_rng(seed)
    a, b, c, d = (int(x) for x in dice.integers(-40, 41, 4))
    text = f"{70 + abs(d)}/100*cos(2*q + {a}/40) + {b}/100*cos(q) + {c}/100*sin(q)"
    system = hjsolve.System({"q": "angle"}, "dot(q)**2/2", text)

    def potential(q: np.ndarray) -> np.ndarray:
        return (70 + abs(d)) / 100 * np.cos(2 * q + a / 40) + b / 100 * np.cos(q) + c / 100 * np.sin(q)

    q = dice.uniform(-np.pi, np.pi, COUNT)
    energy = potential(np.linspace(0, 2 * np.pi, 200_001)).max() + 10.0 ** dice.uniform(-5, 1, COUNT)
    return system, q, np.sqrt(2 * (energy - potential(q))) * dice.choice([-1, 1], COUNT)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [3, 17, 29])
def test_double_wells_on_a_circle(seed: int) -> None:
    """Nothing is left to single motions, and actions, frequencies and angles agree with them to 30 digits."""
    system, q, p = double_well(seed)
    want = {"actions", "frequencies", "angles"}
    batch = hjsolve.ensemble(system, {"q": q}, {"q": p}, want=want, fallback=False)
    assert batch.summary()["ok"] == COUNT
    solution = hjsolve.solve(system)
    for k in range(COUNT):
        motion = solution.motion(q={"q": float(q[k])}, p={"q": float(p[k])}, digits=30, want=sorted(want))
        for quantity, truth in (("actions", motion.actions), ("frequencies", motion.frequencies)):
            exact, claim = truth["q"].value, batch.error[quantity]["q"][k]
            assert abs(mpmath.mpf(float(getattr(batch, quantity)["q"][k])) - exact) <= claim <= 1e-10 * abs(exact)
        gap = float(batch.angles["q"][k]) - float(motion.angles(0)["q"])  # a double, of size up to 2π
        assert abs(gap - 2 * np.pi * np.rint(gap / (2 * np.pi))) <= batch.error["angles"]["q"][k] + 4e-15
        assert batch.error["angles"]["q"][k] <= 1e-9


@pytest.mark.nightly
def test_orbits_about_two_centres() -> None:
    """Most orbits that go round both are slow on either side: hardly one takes a single motion."""
    system = hjsolve.System(
        {"x": "line", "y": "line"},
        "dot(x)**2/2 + dot(y)**2/2",
        "-1/sqrt((x - 1)**2 + y**2) - 2/sqrt((x + 1)**2 + y**2)",
    )
    dice = np.random.default_rng(5)
    angle, r = dice.uniform(-np.pi, np.pi, 60), dice.uniform(1.8, 2.6, 60)
    speed = 0.85 * np.sqrt(3 / r)
    q = {"x": r * np.cos(angle), "y": r * np.sin(angle)}
    velocity = {"x": -speed * np.sin(angle), "y": speed * np.cos(angle)}
    how = {"want": {"actions", "frequencies", "angles"}, "coordinates": "find"}
    batch = hjsolve.ensemble(system, q, velocity=velocity, fallback=False, **how)
    assert batch.summary()["ok"] >= 58
    solution = hjsolve.solve(system, coordinates="find")
    for k in np.flatnonzero(batch.codes == 0)[:6]:
        start = {name: float(x[k]) for name, x in q.items()}
        motion = solution.motion(q=start, velocity={n: float(v[k]) for n, v in velocity.items()}, digits=30)
        for name in solution.coordinates:
            exact = motion.frequencies[name].value
            assert abs(float(batch.frequencies[name][k] - exact)) <= batch.error["frequencies"][name][k]
            gap = float(batch.angles[name][k]) - float(motion.angles(0)[name])  # either barrier is as high as the other
            assert abs(gap - 2 * np.pi * np.rint(gap / (2 * np.pi))) <= batch.error["angles"][name][k] + 4e-15


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 0.9, 1.7])
def test_the_strip_lies_in_its_disks(ratio: float, coarse: bool) -> None:
    """Random points of the strip, carried over by 20 digits of the map itself."""
    table = nodes.rotation_nodes(256, 4, 2)
    over, m = covered_turn(table, coarse=coarse), np.array([[ratio]])
    assert over.inside
    centres, spread = turned_circle.moved_disks(over.angle, over.reach, m)
    assert np.isfinite(spread).all()
    dice = np.random.default_rng(1)
    for x, y in zip(dice.uniform(0, 2 * np.pi, 50), dice.uniform(-1, 1, 50) * 36 / 256, strict=True):
        turn = 2 * (x % np.pi) + 2j * abs(y)
        u = mpmath.mpmathify(turn) * table.quarter / mpmath.pi
        sn, cn = (mpmath.ellipfun(name, u, m=1 - table.complement) for name in ("sn", "cn"))
        θ = (-2j * mpmath.log(cn + 1j * sn) - mpmath.pi) / 2 + (mpmath.pi / 2 if x > np.pi else -mpmath.pi / 2)
        place = complex(2 * mpmath.atan(ratio * mpmath.tan(θ / 2)))
        gap = np.abs((centres[0].real - place.real + np.pi) % (2 * np.pi) - np.pi + 1j * (centres[0].imag - place.imag))
        assert (gap <= spread[0]).any()


@pytest.mark.parametrize(("V", "alone"), [("-cos(x)", False), ("-cos(3*x)/3", True)])
def test_rotations_along_a_line_are_those_of_single_motions(V: str, alone: bool) -> None:
    # they were unbounded in a batch, and rotations one by one
    solution = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", V))
    q, p = {"x": [0.1, -40.0, 13.0]}, {"x": [2.5, -3.0, 0.1]}
    batch = hjsolve.ensemble(solution, q=q, p=p, want={"actions", "frequencies", "angles", "turning_points"})
    assert batch.status.tolist() == ["ok"] * 3
    assert batch.recomputed.tolist() == [alone, alone, False]
    for k in range(3):
        motion = solution.motion(q={"x": q["x"][k]}, p={"x": p["x"][k]}, digits=20)
        θ = float(motion.angles(0).value["x"])
        pairs = {"actions": float(motion.actions["x"]), "frequencies": float(motion.frequencies["x"]), "angles": θ}
        for name, value in pairs.items():
            off = getattr(batch, name)["x"][k] - value
            off -= 2 * np.pi * round(off / (2 * np.pi)) if name == "angles" else 0
            assert abs(off) <= batch.error[name]["x"][k] + 1e-15 * abs(value) < 1e-11, name
