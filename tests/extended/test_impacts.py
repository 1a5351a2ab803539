"""Impacts with unknown impulses: the book's values, budgets of momentum and energy, arcs before and after."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

import hjsolve
from hjsolve.errors import CatalogError

SQRT2 = sp.sqrt(2)
RHOMBUS = hjsolve.System({"q1": "line", "q2": "line"}, "2*m*dot(q1)**2 + m/3*dot(q2)**2", 0, {"m": 1})
ROD = hjsolve.System(
    {"x": "line", "y": "line", "theta": "angle"},
    "m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2",
    0,
    {"m": 3, "l": 2},
)
BAR = hjsolve.System(
    {"x": "line", "y": "line", "theta": "angle"}, "(dot(x)**2 + dot(y)**2)/2 + I*dot(theta)**2/2", 0, {"I": 10}
)
"""A bar pivoted at the origin (its angle from the downward diagonal) and a particle of unit mass."""
FLOOR = "dot(q1) - dot(q2)/2 = 0"
ACROSS, ALONG = "(dot(y) - dot(x))/sqrt(2) - sqrt(2)*dot(theta) = 0", "dot(x) + dot(y) = 0"
HITS: dict[str, tuple[Any, ...]] = {
    "Ex 3-1, floor (C47)": (
        RHOMBUS, {"q1": 0, "q2": 0}, {"q1": -1, "q2": 0}, [FLOOR], 0,
        {"q1": sp.Rational(-3, 5), "q2": sp.Rational(-6, 5)}, [sp.Rational(8, 5)], sp.Rational(4, 5)),
    "Ex 3-2, slide (C48)": (
        BAR, {"x": 1, "y": 1, "theta": 0}, {"x": 0, "y": 1, "theta": -1}, [ACROSS], 0,
        {"x": sp.Rational(5, 4), "y": sp.Rational(-1, 4), "theta": sp.Rational(-3, 4)}, [-5 / (2 * SQRT2)], None),
    "P3-2, stick (C48)": (
        BAR, {"x": 1, "y": 1, "theta": 0}, {"x": 0, "y": 1, "theta": -1}, [ACROSS, ALONG], 0,
        {"x": sp.Rational(3, 4), "y": sp.Rational(-3, 4), "theta": sp.Rational(-3, 4)}, None, None),
    "P3-3, oblique wall (C57)": (
        ROD, {"x": 0, "y": 0, "theta": 0}, {"x": 1, "y": 0, "theta": 0},
        ["(dot(y) - dot(x))/sqrt(2) + l/2*dot(theta)/sqrt(2) = 0"], 0,
        {"x": sp.Rational(4, 5), "y": sp.Rational(1, 5), "theta": sp.Rational(6, 10)}, [3 * SQRT2 / 5], None),
    "P3-4, a wall that starts (C58)": (
        ROD, {"x": 0, "y": 0, "theta": "pi/4"}, {"x": 0, "y": 0, "theta": 0},
        ["dot(x) + l/2*sin(theta)*dot(theta) = 1", "dot(y) - l/2*cos(theta)*dot(theta) = 0"], 0,
        {"x": sp.Rational(5, 8), "y": sp.Rational(3, 8), "theta": 3 / (4 * SQRT2)}, [sp.Rational(15, 8), None], None),
}  # fmt: skip


@pytest.mark.parametrize("name", HITS)
def test_an_impact_has_the_books_values_and_balanced_budgets(name: str) -> None:
    system, q, velocity, constraints, e, after, multipliers, lost = HITS[name]
    hit = hjsolve.impact(system, q=q, velocity=velocity, constraints=constraints, restitution=e)
    assert {n: sp.simplify(v - after[n]) for n, v in hit.velocity.items()} == dict.fromkeys(after, 0)
    for found, expected in zip(hit.multipliers, multipliers or [], strict=False):
        assert expected is None or sp.simplify(found - expected) == 0
    assert lost is None or hit.energy_lost == lost
    assert set(hit.budget.values()) == {0}
    assert hit.energy_lost.is_negative if "starts" in name else hit.energy_lost.is_positive


@pytest.mark.parametrize("e", ["0", "1/2", "1"])
def test_restitution_turns_the_speed_against_the_constraint_round(e: str) -> None:
    """q1' − q2'/2 becomes −e times itself; what it costs is (1 − e²) of the energy against the constraint."""
    hit = hjsolve.impact(
        RHOMBUS, q={"q1": 0, "q2": 0}, velocity={"q1": -1, "q2": "1/3"}, constraints=[FLOOR], restitution=e
    )
    before, after = -1 - sp.Rational(1, 6), hit.velocity["q1"] - hit.velocity["q2"] / 2
    assert after == -sp.Rational(e) * before
    assert hit.energy_lost == (1 - sp.Rational(e) ** 2) * sp.Rational(4, 5) * before**2
    assert set(hit.budget.values()) == {0}


def test_the_arc_after_the_impact_lasts_in_fewer_coordinates() -> None:
    """P3-3 goes on along the wall: with the tip on y = x the centre keeps its velocity along it, (4/5 + 1/5)/√2."""
    wall = "dot(y) - dot(x) + l/2*cos(theta)*dot(theta) = 0"
    hit = hjsolve.impact(ROD, q={"x": 0, "y": 0, "theta": 0}, velocity={"x": 1, "y": 0, "theta": 0}, constraints=[wall])
    system, data = hit.next_arc()
    assert len(system.coordinates) == 2  # separable: the rod with a sliding end
    motion = hjsolve.solve(system).motion(**data)
    assert motion.at(0).q.keys() == {c.name for c in system.coordinates}
    ((gone, formula),) = system.eliminated
    values = {p.symbol: data["parameters"][p.name] for p in system.parameters}
    for t in (0, 1, 3):
        state = motion.at(t)
        place = {c.symbol: state.unwrapped(c.name) for c in system.coordinates} | values
        own = {**{c.name: place[c.symbol] for c in system.coordinates}, gone: formula.subs(place)}
        assert abs(float(own["x"] + own["y"]) - t) < 1e-12  # x + y = (4/5 + 1/5) t
    E = float(hit.kinetic)
    assert abs(motion.constants["E"].value - E) < 1e-14 * E
    bounced = hjsolve.impact(ROD, q={"x": 0, "y": 0, "theta": 0}, velocity={"x": 1, "y": 0, "theta": 0},
                             constraints=["dot(x) = 2"], restitution="1/2")  # fmt: skip
    with pytest.raises(hjsolve.InvalidSystemError, match="restitution 0"):
        bounced.next_arc()


def test_a_string_that_becomes_taut_makes_a_pendulum() -> None:
    """x**2 + y**2 = 25 at (3, 4): the part of the velocity along the string goes, L = x y' - y x' stays."""
    ball = hjsolve.System({"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", 0, {"m": 2})
    call = {"velocity": {"x": 5, "y": 0}, "constraints": ["x**2 + y**2 = 25"]}
    hit = hjsolve.impact(ball, q={"x": 3, "y": 4}, **call)
    assert (hit.velocity["x"], hit.velocity["y"]) == (sp.Rational(16, 5), sp.Rational(-12, 5))
    assert set(hit.budget.values()) == {0}
    system, data = hit.next_arc()
    assert data["velocity"]["theta"] == sp.Rational(-20, 25)
    assert data["q"]["theta"] == sp.atan(sp.Rational(4, 3))
    assert hjsolve.solve(system).motion(**data).constants["E"].value == float(hit.kinetic) == 16
    with pytest.raises(hjsolve.InvalidInputError, match="not satisfied here"):
        hjsolve.impact(ball, q={"x": 3, "y": 3}, **call)


def test_the_arc_after_a_wall_that_starts_goes_on_with_the_wall() -> None:
    """P3-4, the wall keeps its velocity: x = l/2 cos(theta) + t + c, and the system left does not hold the time."""
    system, q, velocity, constraints, *_ = HITS["P3-4, a wall that starts (C58)"]
    hit = hjsolve.impact(system, q=q, velocity=velocity, constraints=constraints)
    left, data = hit.next_arc()
    assert left.time is None
    assert [c.name for c in left.coordinates] == ["theta"]
    assert sp.simplify(data["velocity"]["theta"] - 3 / (4 * SQRT2)) == 0
    motion = hjsolve.solve(left).motion(**data)
    values = {p.symbol: data["parameters"][p.name] for p in left.parameters}
    clock = next(s for s in dict(left.eliminated)["x"].free_symbols if s.name == "t")
    for t in (0, 1, 3):
        here = {left.coordinate("theta").symbol: motion.at(t).unwrapped("theta"), clock: t} | values
        x, y = (float(dict(left.eliminated)[n].subs(here)) for n in "xy")
        turned = float(motion.at(t).unwrapped("theta"))
        # the end of the rod is on the wall and on the floor: x - cos(theta) = t - cos(pi/4)
        assert abs(x - float(sp.cos(turned)) - t + float(sp.cos(sp.pi / 4))) < 1e-13
        assert abs(y - float(sp.sin(turned)) + float(sp.sin(sp.pi / 4))) < 1e-13


def test_an_impact_in_a_scene_separates_the_arcs_on_both_sides() -> None:
    """A rod falls flat on a floor that its left end meets at t = 1, inelastically: then it falls on, turning."""
    system = {"coordinates": [{"name": "y", "domain": "line"}, {"name": "theta", "domain": "line"}],
              "parameters": [{"name": "l", "value": "2"}], "kinetic": "dot(y)**2/2 + l**2/24*dot(theta)**2",
              "potential": "y"}  # fmt: skip
    scene = {
        "system": system, "initial": {"q": {"y": "1/2", "theta": "0"}, "velocity": {"y": "0", "theta": "0"}},
        "want": ["trajectory", "constants"], "times": ["1/2", "1", "3/2"],
        "events": [{"kind": "impact", "at": {"t": "1"}, "constraints": ["dot(y) - l/2*cos(theta)*dot(theta) = 0"]}],
    }  # fmt: skip
    run = hjsolve.Scene.load(scene).run()
    assert len(run.arcs) == 2
    y, speed = run.trajectory.q["y"], run.trajectory.velocity
    assert abs(y[0] - 3 / 8) < 1e-14
    assert abs(speed["y"][1] + 3 / 4) < 1e-14  # 1 → 3/4: λ = 1/4 of the momentum
    assert abs(speed["theta"][1] + 3 / 4) < 1e-14
    assert abs(y[2] - (0 - 3 / 8 - 1 / 8)) < 1e-14
    lost = run.arcs[0].quantities["constants"]["E"].value - run.arcs[1].quantities["constants"]["E"].value
    assert abs(lost - 1 / 8) < 1e-14
    for change, words in (({"constraints": []}, "missing"), ({"momentum": {"y": "1"}}, "not the jump"),
                          ({"constraints": ["dot(y)**2 = 0"]}, "linear in the velocities")):  # fmt: skip
        with pytest.raises((CatalogError, hjsolve.InvalidInputError), match=words):
            hjsolve.Scene.load({**scene, "events": [{**scene["events"][0], **change}]})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"constraints": ["dot(x)**2 = 1"]}, "linear in the velocities"),
        ({"constraints": ["dot(x) = 0", "2*dot(x) = 0"]}, "dependent at this position"),
        ({"constraints": ["dot(x) = 0"], "restitution": 2}, "from 0"),
        ({"constraints": ["dot(x) = 0"], "restitution": [0, 1]}, "1 constraints and 2"),
        ({"constraints": 3}, "texts"),
    ],
)
def test_what_cannot_be_an_impact_is_refused(change: dict[str, Any], words: str) -> None:
    rest = dict.fromkeys(("x", "y", "theta"), 0)
    with pytest.raises((hjsolve.InvalidInputError, TypeError), match=words):
        hjsolve.impact(ROD, q=rest, velocity=rest, **change)
