"""What a scene does not call for is not in H, and not computed: counted, not timed."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

from hjsolve import catalog
from hjsolve.arithmetic.work_counter import counted
from hjsolve.mechanics.system import hamiltonian
from hjsolve.scenes import Scene
from hjsolve.solution.quadratures import solve
from tests.support import entries

SEVEN = (
    "kepler-planar", "kepler-spherical", "spherical-pendulum", "lagrange-top", "harmonic-oscillator",
    "isotropic-oscillator-polar", "pendulum",
)  # fmt: skip
EFFECTS = [(name, effect) for name in SEVEN for effect in entries.described(name).effects]
TIMES = {"start": 0, "stop": 5, "count": 11}


def work(table: dict[str, Any]) -> Any:
    run = Scene.load(table).run()
    if run.trajectory is not None:
        assert all(len(run.trajectory.q[name]) for name in run.trajectory.q)
    return run.work


@pytest.mark.parametrize("name", SEVEN)
def test_there_are_two_effects_and_some_keep_the_system_separable(name: str) -> None:
    effects = entries.described(name).effects
    assert len(effects) >= 2
    assert any(effect.verdict != "refused" for effect in effects.values())


@pytest.mark.parametrize("name", SEVEN)
def test_a_scene_without_effects_is_the_plain_system_and_costs_the_same(name: str) -> None:
    scene = Scene.load({"system": name, "want": ["periods", "actions", "trajectory"], "times": TIMES})
    plain = catalog.load(name)
    assert scene.system == plain
    assert hamiltonian(scene.system) == hamiltonian(plain)
    given = entries.described(name).initial.arguments
    with counted() as alone:
        motion = solve(plain).motion(**given, want=scene.want)
        motion.at([0.5 * k for k in range(11)])
    assert scene.run().work == alone


@pytest.mark.parametrize(("name", "effect"), EFFECTS, ids=[f"{n}+{e}" for n, e in EFFECTS])
def test_an_effect_adds_its_own_terms_and_parameters_and_nothing_else(name: str, effect: str) -> None:
    plain, with_it = catalog.load(name), Scene.load({"system": name, "effects": [effect]})
    entry = entries.described(name).effects[effect]
    new = {p["name"] for p in entry.parameters}
    assert {p.name for p in with_it.system.parameters} == {p.name for p in plain.parameters} | new
    off = {p.symbol: sp.Integer(0) for p in with_it.system.parameters if p.name in new}
    for energy in ("kinetic", "potential"):
        added = sp.expand(getattr(with_it.system, energy) - getattr(plain, energy))
        text = getattr(entry, energy)
        assert (added == 0) == (not text)
        assert sp.simplify(added.xreplace(off)) == 0
    assert (with_it.forces != {}) == bool(entry.force)


def test_no_symbol_of_an_absent_effect_is_in_the_system() -> None:
    scene = Scene.load({"system": "kepler-planar", "effects": ["precession"]})
    assert {s.name for s in scene.system.potential.free_symbols} == {"b", "k", "r"}
    assert {p.name for p in Scene.load({"system": "kepler-planar"}).system.parameters} == {"m", "k"}


@pytest.mark.parametrize("name", SEVEN)
def test_wanting_periods_evaluates_no_trajectory(name: str) -> None:
    periods = work({"system": name, "want": ["periods"]})
    both = work({"system": name, "want": ["periods", "trajectory"], "times": TIMES})
    assert periods.places == 0
    assert both.places >= 11
    assert periods.kernels <= both.kernels


@pytest.mark.parametrize("name", ["kepler-planar", "pendulum", "lagrange-top", "kepler-spherical"])
def test_every_further_wish_costs_and_nothing_else_does(name: str) -> None:
    ends = work({"system": name, "want": ["turning_points", "kinds", "constants"]})
    actions = work({"system": name, "want": ["actions"]})
    periods = work({"system": name, "want": ["periods"]})
    assert ends.kernels == actions.kernels == 0
    assert ends.squares < actions.squares
    assert periods.kernels > 0
    assert ends.places == actions.places == periods.places == 0


def test_a_quantity_that_was_not_wanted_is_refused_by_name() -> None:
    run = Scene.load({"system": "pendulum", "want": ["periods"]}).run()
    with pytest.raises(ValueError, match='"actions" was not computed; add it to want'):
        run.quantity("actions")
    with pytest.raises(ValueError, match='add "trajectory" to want'):
        run.arcs[0].motion.at(1.0)
    assert run.trajectory is None


def test_the_numbers_do_not_depend_on_what_else_is_wanted() -> None:
    few = Scene.load({"system": "lagrange-top", "want": ["periods"]}).run().quantity("periods")
    many = Scene.load({"system": "lagrange-top", "want": ["periods", "actions", "trajectory"], "times": [1]}).run()
    for name, period in few.items():
        other = many.quantity("periods")[name]
        assert abs(period.value - other.value) <= period.error + other.error


def test_angles_and_orbit_are_those_of_the_motion() -> None:
    run = Scene.load({
        "system": "kepler-planar", "want": ["angles", "orbit"], "times": ["1", "2"],
        "orbit": {"of": "theta", "along": "r", "values": ["1.5", "2"]},
    }).run()  # fmt: skip
    given = entries.described("kepler-planar").initial.arguments
    motion = solve(catalog.load("kepler-planar")).motion(**given)
    assert list(run.quantity("angles")["r"]) == list(motion.angles(["1", "2"])["r"])
    # Kepler: r = l/(1 + e cos(theta)), l = 1.44, e = 0.44
    table = run.quantity("orbit")
    for r, angle in zip((1.5, 2.0), table.values, strict=True):
        assert abs(float(sp.acos((1.44 / r - 1) / 0.44)) - angle) < 1e-13
