"""Impulses and walls against Hamilton's equations integrated by Taylor series, 30 digits and more, event by event."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import mpmath
import pytest
import sympy as sp
from mpmath import mp

from hjsolve import catalog
from hjsolve.mechanics.system import hamiltonian
from hjsolve.scenes import Run, Scene
from hjsolve.solution.quadratures import solve
from tests.reference.taylor import Flow
from tests.support.scene_files import example

FLOOR = {"kind": "wall", "at": {"coordinate": "y", "value": "0"}}
CASES: dict[str, dict[str, Any]] = {
    "ellipse": {
        "system": "kepler-planar", "effects": ["precession"],
        "initial": {"q": {"r": "1", "theta": "0.5"}, "velocity": {"r": "0.1", "theta": "1.1"}},
        "times": ["1", "2.5", "6.5", "11", "14"], "events": [
            {"kind": "impulse", "at": {"t": "2"}, "momentum": {"theta": "0.1", "r": "-0.05"}},
            {"kind": "wall", "at": {"coordinate": "r", "value": "1.4"}},
            {"kind": "impulse", "at": {"t": "12"}, "velocity": {"theta": "-0.2"}}]},
    "oscillator": {
        "system": "isotropic-oscillator-polar", "effects": ["magnetic-field"],
        "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0.3", "theta": "0.8"}},
        "times": ["0.9", "3", "7"], "events": [
            {"kind": "impulse", "at": {"t": "1.5"}, "momentum": {"theta": "-0.2"}},
            {"kind": "wall", "at": {"coordinate": "r", "value": "1.02"}},
            {"kind": "impulse", "at": {"coordinate": "theta", "value": "3"}, "momentum": {"r": "0.25"}}]},
    "projectile": {
        "system": "projectile", "initial": {"q": {"x": "0", "y": "1"}, "velocity": {"x": "1", "y": "2"}},
        "times": ["0.4", "1", "2.2", "4"], "events": [
            FLOOR, {"kind": "impulse", "at": {"t": "0.5"}, "momentum": {"x": "0.5", "y": "-0.3"}},
            {"kind": "impulse", "at": {"coordinate": "x", "value": "2"}, "velocity": {"y": "0.7"}}]},
    "sphere": {
        "system": "spherical-pendulum",
        "initial": {"q": {"theta": "1", "phi": "0"}, "velocity": {"theta": "0.2", "phi": "2"}},
        "times": ["0.5", "1.6", "3.1"], "events": [
            {"kind": "impulse", "at": {"t": "0.75"}, "velocity": {"theta": "0.4", "phi": "0.3"}},
            {"kind": "wall", "at": {"coordinate": "theta", "value": "1.1"}},
            {"kind": "impulse", "at": {"coordinate": "phi", "value": "-2.5"}, "momentum": {"phi": "-0.1"}}]},
}  # fmt: skip


class Reference:
    """The same scene by the Taylor flow: events found by Newton's method on the series, momenta changed by hand."""

    def __init__(self, scene: Scene):
        self.scene, self.system = scene, scene.system
        self.q = [c.symbol for c in self.system.coordinates]
        self.p = [c.momentum for c in self.system.coordinates]
        self.names = [c.name for c in self.system.coordinates]
        self.values = {
            p.symbol: mp.mpf(sp.N(sp.Rational(str(scene.parameters.get(p.name, p.value))), 60))
            for p in self.system.parameters
        }
        self.H = hamiltonian(self.system)
        self.speed = [sp.diff(self.H, p).xreplace({s: sp.Float(v, 60) for s, v in self.values.items()}) for p in self.p]
        L = {c.velocity: sp.Rational(str(scene.initial.velocity[c.name])) for c in self.system.coordinates}
        places = {c.symbol: sp.Rational(str(scene.initial.q[c.name])) for c in self.system.coordinates}
        exact = {p.symbol: sp.Rational(str(scene.parameters.get(p.name, p.value))) for p in self.system.parameters}
        momenta = [
            sp.diff(self.system.kinetic, c.velocity).xreplace(L).xreplace({**places, **exact})
            for c in self.system.coordinates
        ]
        self.state = [mp.mpf(sp.N(places[s], 60)) for s in self.q] + [mp.mpf(sp.N(p, 60)) for p in momenta]

    def velocity(self, state: list[Any], i: int) -> Any:
        at = dict(zip([*self.q, *self.p], (sp.Float(x, 60) for x in state), strict=True))
        return mp.mpf(sp.N(self.speed[i].xreplace(at), 55))

    def flow(self, time: Any, state: list[Any]) -> Callable[[Any], list[Any]]:
        flow = Flow(self.H, self.q, self.p, self.values, state, digits=32)
        return lambda t: flow.at(t - time)

    def jump(self, kind: str, event: Any, state: list[Any]) -> list[Any]:
        """(3-24): Δp = Q̂; a velocity jump through m(q), differenced from q̇(p), which is linear in p."""
        n, new = len(self.q), list(state)
        if kind == "wall":
            i = self.names.index(event.coordinate)
            unit = [*state[: n + i], state[n + i] + 1, *state[n + i + 1 :]]
            slope = self.velocity(unit, i) - self.velocity(state, i)
            new[n + i] -= 2 * self.velocity(state, i) / slope
        elif event.momentum is not None:
            for name, amount in event.momentum.items():
                new[n + self.names.index(name)] += mp.mpf(sp.N(amount, 60))
        else:
            base = [self.velocity(state, i) for i in range(n)]
            M = mp.matrix(n, n)
            for j in range(n):
                unit = [*state[: n + j], state[n + j] + 1, *state[n + j + 1 :]]
                for i in range(n):
                    M[i, j] = self.velocity(unit, i) - base[i]
            wanted = mp.matrix([mp.mpf(sp.N(event.velocity.get(name, 0), 60)) for name in self.names])
            for i, amount in enumerate(mp.lu_solve(M, wanted)):
                new[n + i] += amount
        return new

    def at(self, times: list[str], run: Run) -> list[list[Any]]:
        """States at the times. Which events happen, and roughly when, is taken from the run; when exactly, is not."""
        found, state, begin = [], self.state, mp.zero
        for arc in run.arcs:
            flow = self.flow(begin, state)
            last = mp.inf if arc.ends is None else mp.mpf(arc.ends.value)
            found += [flow(mp.mpf(t)) for t in times if begin <= mp.mpf(t) < last]
            if arc.ends is None:
                return found
            begin = self._moment(flow, arc)
            state = flow(begin)
            for event in arc.events:
                state = self.jump(event.kind, event, state)
        return found

    def _moment(self, flow: Any, arc: Any) -> Any:
        event, time = arc.events[0], mp.mpf(arc.ends.value)
        if event.time is not None:
            return mp.mpf(sp.N(event.time, 60))
        i = self.names.index(event.coordinate)
        target = mp.mpf(sp.N(event.value, 60))
        for _ in range(3):
            there = flow(time)
            off = there[i] - target
            if self.system.coordinate(event.coordinate).domain.kind == "angle":
                off -= 2 * mp.pi * mp.nint(off / (2 * mp.pi))
            time -= off / self.velocity(there, i)
        return time


@functools.cache
def sharp(name: str) -> Run:
    """The scene to 20 digits."""
    return Scene.load({**CASES[name], "want": ["trajectory"], "accuracy": {"digits": 20}}).run()


@pytest.mark.nightly_cases("oscillator", "sphere")
@pytest.mark.parametrize("name", CASES)
def test_two_impulses_and_a_wall_agree_with_a_thirty_digit_integration(name: str) -> None:
    case, run = CASES[name], sharp(name)
    kinds = [event.kind for arc in run.arcs for event in arc.events]
    assert kinds.count("impulse") == 2
    assert kinds.count("wall") >= 1
    with mp.workdps(55):
        reference = Reference(run.scene)
        expected = reference.at(case["times"], run)
        assert len(expected) == len(case["times"])
        n = len(reference.names)
        for k, state in enumerate(expected):
            for i, coordinate in enumerate(reference.names):
                assert abs(run.trajectory.unwrapped(coordinate)[k] - state[i]) < mp.mpf(10) ** -18
                assert abs(run.trajectory.p[coordinate][k] - state[n + i]) < mp.mpf(10) ** -18


@pytest.mark.nightly_cases("sphere")
@pytest.mark.parametrize("name", CASES)
def test_in_doubles_the_same_scene_is_within_its_error_and_1e_12(name: str) -> None:
    exact = sharp(name).trajectory
    approximate = Scene.load({**CASES[name], "want": ["trajectory"]}).run().trajectory
    for coordinate in exact.q:
        for part in ("q", "p", "velocity"):
            better, plain = getattr(exact, part)[coordinate], getattr(approximate, part)[coordinate]
            bound = getattr(approximate.error, part)[coordinate]
            for a, b, e in zip(better, plain, bound, strict=True):
                assert abs(a - mpmath.mpf(float(b))) <= min(e, 1e-12)


def test_energy_and_momenta_jump_as_the_impulse_says() -> None:
    """(3-24): Δp = Q̂ and ΔT = Q̂·q̇ + ½ Q̂ m⁻¹ Q̂, positions unchanged."""
    scene = Scene.load({
        "system": "kepler-planar", "initial": {"q": {"r": "1", "theta": "0"}, "velocity": {"r": "0", "theta": "1.2"}},
        "want": ["constants"], "accuracy": {"digits": 30},
        "events": [{"kind": "impulse", "at": {"t": "0"}, "momentum": {"theta": "0.25", "r": "0.5"}}],
    })  # fmt: skip
    run = scene.run()
    before, after = (run.quantity("constants", arc=k) for k in (0, 1))
    assert abs(after["p_theta"].value - before["p_theta"].value - mpmath.mpf("0.25")) < 1e-29
    expected = sp.Rational("0.25") * sp.Rational("1.2") + (sp.Rational("0.25") ** 2 + sp.Rational("0.5") ** 2) / 2
    with mp.workdps(40):
        assert abs(after["E"].value - before["E"].value - mp.mpf(sp.N(expected, 40))) < mp.mpf(10) ** -29


def test_a_wall_keeps_every_constant_and_the_states_are_reflected() -> None:
    run = example("bouncing-ball")
    energies = [arc.quantities["constants"]["E"].value for arc in run.arcs]
    assert len(run.arcs) == 11
    assert max(abs(e - 12.5) for e in energies) < 1e-13
    # z = 5/4, g = 10: the floor is reached after 1/2, then every 1
    for k, arc in enumerate(run.arcs[:-1]):
        assert abs(arc.ends.value - (0.5 + k)) < 1e-14
    t, z = run.trajectory.t, run.trajectory.q["z"]
    phase = (t + 0.5) % 1.0 - 0.5
    assert max(abs(z - (1.25 - 5 * phase**2))) < 1e-13


def test_a_billiard_folds_straight_lines() -> None:
    run = example("billiard")
    for name, start, speed, width in (("x", 0.2, 0.7, 2.0), ("y", 0.1, 0.45, 1.0)):
        line = start + speed * run.trajectory.t
        reduced = width - abs(line % (2 * width) - width)
        assert max(abs(run.trajectory.q[name] - reduced)) < 1e-13
        assert max(abs(abs(run.trajectory.velocity[name]) - speed)) < 1e-15


def test_two_walls_met_at_once_turn_both_momenta() -> None:
    run = Scene.load({
        "system": {"coordinates": [{"name": "x", "domain": "line"}, {"name": "y", "domain": "line"}],
                   "kinetic": "dot(x)**2/2 + dot(y)**2/2"},
        "initial": {"q": {"x": "1/3", "y": "1/3"}, "velocity": {"x": "1", "y": "1"}}, "want": ["trajectory"],
        "times": ["0.5", "1"], "events": [{"kind": "wall", "at": {"coordinate": c, "value": "1"}} for c in ("x", "y")],
    }).run()  # fmt: skip
    assert len(run.arcs) == 2
    assert len(run.arcs[0].events) == 2
    assert abs(run.trajectory.q["x"][1] - 2 / 3) < 1e-15
    assert abs(run.trajectory.q["y"][1] - 2 / 3) < 1e-15


def test_passages_are_counted_over_other_events() -> None:
    """theta = 0 is passed every half period; an impulse of zero strength at t = 1 does not disturb the count."""
    base = {"system": "pendulum", "initial": {"q": {"theta": "0.3"}, "velocity": {"theta": "0"}}, "want": ["periods"]}  # fmt: skip
    third = {"kind": "impulse", "at": {"coordinate": "theta", "value": "0", "passage": 2}, "momentum": {"theta": "1"}}
    idle = {"kind": "impulse", "at": {"t": "1"}, "momentum": {"theta": "0"}}
    period = Scene.load(base).run().quantity("periods")["theta"].value
    base["times"] = [5]
    alone = Scene.load({**base, "events": [third]}).run().arcs
    both = Scene.load({**base, "events": [idle, third]}).run().arcs
    assert abs(alone[0].ends.value - 1.25 * period) < 1e-14
    assert len(both) == 3
    assert abs(both[1].ends.value - 1.25 * period) < 1e-14


def test_a_far_passage_is_found_without_the_ones_before_it() -> None:
    """r = 1.5 is passed twice a period: passage 2n comes n periods after passage 0, at the same cost."""
    table = {"system": "kepler-planar", "want": ["trajectory"], "times": ["1e6"], "accuracy": {"digits": 20}}

    def event(passage: int) -> Any:
        at = {"coordinate": "r", "value": "1.5", "passage": passage}
        return Scene.load({**table, "events": [{"kind": "impulse", "at": at, "momentum": {"theta": "0.1"}}]}).run()

    near, far = event(0), event(20000)
    given = catalog.describe("kepler-planar").initial.arguments
    period = solve(catalog.load("kepler-planar")).motion(**given, digits=30).periods["r"].value
    with mp.workdps(40):
        apart = mp.mpf(far.arcs[0].ends.value) - mp.mpf(near.arcs[0].ends.value)
        assert abs(apart - 10000 * mp.mpf(period)) < mp.mpf(10) ** -13
    assert far.work.places <= near.work.places + 10


def test_a_velocity_jump_goes_through_the_mass_matrix_where_t_is_not_orthogonal() -> None:
    """(3-24)-(3-29): dp = m(q)*dq', and the energy changes by the impulse times the mean of the velocities."""
    scene = Scene.load({
        "system": "pendulum-on-block", "want": ["constants"], "accuracy": {"digits": 25}, "times": [3],
        "initial": {"q": {"x": "0", "theta": "0.7"}, "velocity": {"x": "0.3", "theta": "0.4"}},
        "events": [{"kind": "impulse", "at": {"t": "0"}, "velocity": {"x": "0.5", "theta": "-1.1"}}],
    })  # fmt: skip
    before, after = (arc.quantities["constants"] for arc in scene.run().arcs)
    system = scene.system
    at = {c.symbol: v for c, v in zip(system.coordinates, (0, sp.Rational("0.7")), strict=True)}
    at |= {p.symbol: p.value for p in system.parameters}
    m = sp.hessian(system.kinetic, [c.velocity for c in system.coordinates]).subs(at)
    assert m[0, 1] != 0
    old, jump = (sp.Matrix([sp.Rational(x) for x in pair]) for pair in (("0.3", "0.4"), ("0.5", "-1.1")))
    impulse = m * jump
    with mp.workdps(35):
        assert abs(mp.mpf(after["p_x"].value) - before["p_x"].value - mp.mpf(sp.N(impulse[0], 35))) < mp.mpf(10) ** -24
        energy = (impulse.T * (old + jump / 2))[0]
        assert abs(mp.mpf(after["E"].value) - before["E"].value - mp.mpf(sp.N(energy, 35))) < mp.mpf(10) ** -24


def test_a_pendulum_is_pushed_over_the_top_and_back() -> None:
    run = example("pendulum-over-the-top")
    assert [arc.quantities["kinds"]["theta"] for arc in run.arcs] == ["libration", "rotation", "libration"]
    jumps = [run.quantity("constants", arc=k)["E"].value for k in range(3)]
    assert jumps[1] > 9.81 > jumps[0]


def test_a_pendulum_at_rest_stays_exactly_at_rest_until_it_is_pushed() -> None:
    run = Scene.load({
        "system": "pendulum", "initial": {"q": {"theta": "0"}, "velocity": {"theta": "0"}}, "times": ["0.5", "1.5"],
        "want": ["kinds", "trajectory"], "events": [{"kind": "impulse", "at": {"t": "1"}, "velocity": {"theta": "1e-3"}}],
    }).run()  # fmt: skip
    assert [arc.quantities["kinds"]["theta"] for arc in run.arcs] == ["equilibrium", "libration"]
    assert run.trajectory.q["theta"][0] == 0
    assert run.trajectory.arc.tolist() == [0, 1]


def test_an_angle_keeps_counting_its_turns_through_events() -> None:
    quiet = {"system": "kepler-planar", "want": ["trajectory"], "times": {"start": 0, "stop": 100, "count": 51}}
    idle = [{"kind": "impulse", "at": {"t": str(t)}, "momentum": {"theta": "0"}} for t in (20, 41, 77)]
    plain, cut = Scene.load(quiet).run().trajectory, Scene.load({**quiet, "events": idle}).run().trajectory
    assert max(abs(plain.unwrapped("theta") - cut.unwrapped("theta"))) < 1e-12
    assert plain.turns["theta"][-1] > 5
