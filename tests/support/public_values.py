"""Values of every public class, out of calls that a user would make, and all that is reached from them by public names."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pint

import hjsolve

SCENES = Path(__file__).resolve().parents[2] / "scenes"
PUBLIC = (hjsolve.Estimate, hjsolve.EstimateArray, hjsolve.Measured, hjsolve.BatchDerivatives)
MACHINERY = ("arithmetic.", "one_coordinate.", "time_law.", "certified.", "algebra.", "ensembles.")
"""Rooms whose values are parts of a computation, but for ``Estimate``; those of ensembles have texts of their own."""


def made(folder: Path) -> dict[str, Any]:
    """Value by what it is.

    Args:
        folder: for the files of a sweep.
    """
    load, describe, solve = hjsolve.catalog.load, hjsolve.catalog.describe, hjsolve.solve
    kepler, start = solve("kepler-planar"), {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}
    motion, kerr = kepler.motion(**start), solve("kerr")
    sweep = {
        "system": "kepler-planar", "want": ["actions"],
        "sweep": {"q": {"r": ["1", "1.1"], "theta": "0"}, "p": {"r": "0", "theta": "1.1"}},
    }  # fmt: skip
    scene = hjsolve.Scene.load(SCENES / "precessing-ellipse.toml")
    oscillator = hjsolve.System({"x": "line"}, "m/2*dot(x)**2", "k/2*x**2", {"m": 1, "k": 1})
    complete, wrong = (
        hjsolve.verify(oscillator, W=f"integral(sqrt(2*m*E {sign} m*k*x**2), x)", constants="E") for sign in "-+"
    )
    orbits = {"q": {"r": [1, 2.0], "theta": [0, 0.0]}, "p": {"r": [0, 0.0], "theta": [1, 1.0]}}
    return {
        "closed forms": hjsolve.closed_forms(kepler)[0],
        "estimates": motion.characteristic_function([1, 2]),
        "system": load("kepler-planar"), "a system without a name": hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**4"),
        "a wide system": load("kerr"), "separation": kepler.separation, "obstruction": hjsolve.separate("henon-heiles"),
        "undecided": hjsolve.separate("triaxial-geodesics", budget=0.0),
        "solution": kepler, "a wide solution": kerr, "motion": motion, "50 digits": kepler.motion(**start, digits=50),
        "certified": kepler.motion(**start, certified=True),
        "kerr's motion": kerr.motion(**describe("kerr").motions["default"].arguments),
        "the top's motion": solve("lagrange-top").motion(**describe("lagrange-top").motions["default"].arguments),
        "state": motion.at(1), "states": motion.at(np.linspace(0, 9, 10_000)), "estimate": motion.periods["r"],
        "measured": hjsolve.Measured.of(motion.periods["r"], (registry := pint.UnitRegistry()).s),
        "in units": (told := motion.to_units(registry)), "state in units": told.at([1, 2]), "batch in units": hjsolve.ensemble(kepler, q={"r": [1.0], "theta": 0}, p={"r": 0, "theta": 1}).to_units(registry),
        "coordinates": hjsolve.find_coordinates(load("henon-heiles-separable")),
        "modes": hjsolve.normal_modes(load("small-oscillations")),
        "entry": describe("kepler-planar"), "outside": describe("skate"), "refused": describe("henon-heiles"),
        "gyroscopic": hjsolve.gyroscopic_modes(describe("gyroscopic-pair").system),
        "frame": hjsolve.frames.load("spring-moving-anchor"),
        "level": hjsolve.from_hamiltonian("p**4 + q**2", {"q": "line"}).motion(q={"q": 1}, p={"q": 1}),
        "linear": hjsolve.from_hamiltonian("q + p", {"q": "line"}).motion(q={"q": 1}, p={"q": 1}),
        "in time": (moving := hjsolve.from_hamiltonian("p**4 + (q + t)**2", {"q": "line"})), "motion in time": moving.motion(q={"q": 1}, p={"q": 0}),
        "sum": (total := hjsolve.from_hamiltonian("p_x**4 + x**2 + p_y**2 + y**2", {"x": "line", "y": "line"})), "motion of a sum": total.motion(q={"x": 1, "y": 1}, p={"x": 0, "y": 0}),
        "levels": (levels := hjsolve.levels("harmonic-oscillator", up_to=2)), "level of a table": levels[0],
        "map": hjsolve.energy_momentum_map(motion), "turned": hjsolve.energy_momentum_map(motion).monodromy((1.2, -0.2), 0.05),
        "isolated": hjsolve.energy_momentum_map(solve("spherical-pendulum")).isolated[0],
        "fronts": (fronts := hjsolve.wavefronts(motion, fronts=3, orbits=2)), "front": fronts.fronts[0],
        "scene": scene, "run": scene.run(), "rest": hjsolve.Scene.load(SCENES / "ball-that-stays.toml").run(),
        "cost": hjsolve.cost("kepler-planar", seconds=1), "sweep": hjsolve.sweep(sweep, folder / "out"),
        "batch": hjsolve.ensemble(kepler, **orbits), "derivatives of a batch": hjsolve.ensemble_derivatives(kepler, **orbits),
        "derivatives": motion.derivatives(), "complete integral": complete, "flaw": wrong,
        "own motion": complete.along(solve(oscillator).motion(q={"x": "0.3"}, velocity={"x": "1"})),
        "canonical map": hjsolve.canonical({"Q": "p", "P": "-q"}), "proof": hjsolve.is_integral("p_theta", load("kepler-planar")),
        "action of a path": hjsolve.action_integral(oscillator, {"x": "t"}, between=(0, 1)),
        "loop": hjsolve.loop_integral(solve(oscillator), q={"x": "cos(s)"}, p={"x": "sin(s)"}, times=[0, 1]),
        "impact": hjsolve.impact(hjsolve.System({"x": "line"}, "dot(x)**2/2", 0), q={"x": 0}, velocity={"x": -1}, constraints=["dot(x) = 0"]),
        "contact": hjsolve.contact(hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "y"), q={"x": "3/5", "y": "4/5"}, velocity={"x": 0, "y": 0}, constraints=["x**2 + y**2 >= 1"]),
        "forces": hjsolve.constraint_forces(hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "y", constraints=["y = x**2"])),
    }  # fmt: skip


def reached(values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """One value of each class of the package that public names lead to, with the path to it.

    Args:
        values: where to begin.
    """
    seen: set[type] = set()
    waiting = list(values.items())
    while waiting:
        path, value = waiting.pop(0)
        if isinstance(value, Mapping):
            waiting += [(f"{path}[{key!r}]", item) for key, item in list(value.items())[:4]]
        elif isinstance(value, (tuple, list)):
            waiting += [(f"{path}[{i}]", item) for i, item in enumerate(value[:4])]
        kind = type(value)
        where = kind.__module__.removeprefix("hjsolve.")
        inside = where.startswith(MACHINERY) and kind not in PUBLIC
        if kind.__module__ == where or callable(value) or inside:
            continue
        if path in values or kind not in seen:
            seen.add(kind)
            yield path, value
            waiting += [(f"{path}.{name}", item) for name, item in _attributes(value)]


def _attributes(value: Any) -> Iterator[tuple[str, Any]]:
    names = {field.name for field in dataclasses.fields(value)} if dataclasses.is_dataclass(value) else set()
    names |= {name for name, member in inspect.getmembers(type(value)) if isinstance(member, property)}
    for name in sorted(name for name in names if not name.startswith("_")):
        try:
            yield name, getattr(value, name)
        except hjsolve.HJSolveError:
            continue
