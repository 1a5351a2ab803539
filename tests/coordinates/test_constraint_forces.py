"""Lagrange's multipliers: the book's forces, and the equations of motion solved another way at random states."""

from __future__ import annotations

import pickle
import random

import numpy as np
import pytest
import sympy as sp

import hjsolve
from hjsolve.mechanics.system import mass_matrix

LINE2, LINE3 = {"x": "line", "y": "line"}, {"x": "line", "y": "line", "z": "line"}
T2, T3 = "m/2*(dot(x)**2 + dot(y)**2)", "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
ROD = {"x": "line", "y": "line", "theta": "angle"}, "m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2"
POSITIVE = {n: hjsolve.parameter(n, v, assume="positive") for n, v in (("m", 2), ("g", "9.81"), ("l", 3), ("R", 5))}
CASES = {
    "P2-9, a parabola": (LINE2, T2, "m*g*y", ["y = 3*x**2"]),
    "a circle": (LINE2, T2, "m*g*y", ["x**2 + y**2 = R**2"]),
    "a sphere": (LINE3, T3, "m*g*z", ["x**2 + y**2 + z**2 = R**2"]),
    "a ladder, two constraints": (*ROD, "m*g*y", ["x - l/2*cos(theta) = 0", "y - l/2*sin(theta) = 0"]),
    "P4-8 (C72)": (LINE3, T3, "m*g*z", ["dot(x) - dot(y) + dot(z) = 0"]),
    "P2-10 (C40)": (LINE3, T3, "m*g*(x**2 + y**2 + z**2)", ["2*dot(x) + 3*dot(y) + 4*dot(z) + 5 = 0"]),
    "P2-3 (C35), a knife edge": (*ROD, 0, ["sin(theta)*dot(x) - cos(theta)*dot(y) + l/2*dot(theta) = 0"]),
    "P4-4 (C70), one that turns": (LINE2, T2, 0, ["sin(t**2)*dot(x) - cos(t**2)*dot(y) = 0"]),
    "mass that depends on the place": (LINE2, "m/2*((1 + x**2)*dot(x)**2 + dot(x)*dot(y) + dot(y)**2)", "g*x*y", ["y = x**3"]),
    "polar": ({"r": "0 < r", "phi": "angle"}, "m/2*(dot(r)**2 + r**2*dot(phi)**2)", "m*g*r*sin(phi)", ["r = R"]),
    "a bead on a rod that turns": (LINE2, T2, 0, ["x*sin(t) - y*cos(t) = 0"]),
}  # fmt: skip


def _free(name: str) -> hjsolve.System:
    domains, kinetic, potential, _ = CASES[name]
    return hjsolve.System(domains, kinetic, potential, POSITIVE)


@pytest.mark.parametrize("name", CASES)
def test_forces_and_accelerations_solve_newtons_equations(name: str) -> None:
    """[M −aᵀ; a 0] (q̈, λ) = (−r, −b) by numpy, with r and b from differences of p, L and the constraint along q(t)."""
    system, found = _free(name), hjsolve.constraint_forces(_free(name), CASES[name][3])
    t, generator = sp.Symbol("t", real=True), random.Random(len(name))
    for _ in range(3):
        at = {s: generator.randint(2, 40) / 16 for c in system.coordinates for s in (c.symbol, c.velocity)}
        values = {**at, t: generator.randint(2, 40) / 16} | system.defaults
        M = np.array(mass_matrix(system).subs(values), dtype=float)
        a = np.array([[float(sp.sympify(x).subs(values)) for x in row] for row in found.rows])
        moved = {c.symbol: c.symbol + t * c.velocity for c in system.coordinates}  # q(t) with q̈ = 0
        rates = [sp.diff(sp.diff(system.kinetic, c.velocity).subs(moved), t).subs(t, 0) for c in system.coordinates]
        slopes = [sp.diff(system.kinetic - system.potential, c.symbol) for c in system.coordinates]
        r = np.array([float((x - y).subs(values)) for x, y in zip(rates, slopes, strict=True)])
        s, clock = sp.Symbol("s"), values[t]
        along = {c.symbol: at[c.symbol] + s * at[c.velocity] for c in system.coordinates} | {t: clock + s}
        b = []
        for text in CASES[name][3]:
            left, right = (*text.split("="), "0")[:2]
            names = {**system.symbols, "t": t, "dot": lambda q: sp.Symbol(f"dot({q})", real=True)}
            g = sp.sympify(f"({left}) - ({right})", locals=names).subs(system.defaults)
            fixed = {c.velocity: at[c.velocity] for c in system.coordinates}
            times = 1 if g.has(*fixed) else 2
            b.append(float(sp.diff(g.subs(fixed).subs(along, simultaneous=True), s, times).subs(s, 0)))
        n, m = len(r), len(b)
        whole = np.block([[M, -a.T], [a, np.zeros((m, m))]])
        expected = np.linalg.solve(whole, np.concatenate([-r, -np.array(b)]))
        told = [float(x.subs(values)) for x in (*found.accelerations.values(), *found.multipliers)]
        assert np.allclose(told, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())
        forces = [float(x.subs(values)) for x in found.forces.values()]
        assert np.allclose(forces, a.T @ expected[n:], rtol=1e-11, atol=1e-11 * np.abs(expected).max())
        own = {sp.Symbol(f"ddot({c.name})", real=True): x for c, x in zip(system.coordinates, expected, strict=False)}
        own |= dict(zip(found.symbols, expected[n:], strict=True))
        for e in found.equations.values():
            assert abs(float((e.lhs - e.rhs).subs(own).subs(values))) < 1e-10 * np.abs(expected).max() * np.abs(M).max()


def test_forces_of_eliminated_constraints_in_the_coordinates_left() -> None:
    """P2-9: the greatest force is m g (1 + 12 y₀), at the bottom; C40: k (c − 5 t)/29 along (2, 3, 4), from ∑ k x a."""
    domains, kinetic, potential, texts = CASES["P2-9, a parabola"]
    bead = hjsolve.System(domains, kinetic, potential, {"m": 1, "g": 1}, constraints=texts)
    (λ,) = hjsolve.constraint_forces(bead).reduced
    m, g = (bead.symbols[name] for name in "mg")
    y0, x = sp.Symbol("y0"), bead.coordinates[0]
    assert sp.simplify(λ.subs({x.velocity: sp.sqrt(2 * g * y0), x.symbol: 0}) - m * g * (1 + 12 * y0)) == 0
    space = hjsolve.System(LINE3, T3, "k/2*(x**2 + y**2 + z**2)", {"m": 1, "k": 4}, constraints=CASES["P2-10 (C40)"][3])
    (λ,) = hjsolve.constraint_forces(space).reduced
    k, c, t = space.symbols["k"], space.symbols["c_1"], space.time
    assert sp.expand(λ - k * (c - 5 * t) / 29) == 0
    assert pickle.loads(pickle.dumps(bead)).unconstrained == bead.unconstrained


def test_the_books_multipliers_of_nonholonomic_systems() -> None:
    """P4-4: λ = −2 m v₀ t at ẋ = v₀ cos t², ẏ = v₀ sin t². P2-3: m ẍ = λ sin θ, m ÿ = −λ cos θ, m l²/12 θ̈ = λ l/2."""
    turning = hjsolve.constraint_forces(_free("P4-4 (C70), one that turns"), CASES["P4-4 (C70), one that turns"][3])
    t, v0, m = sp.Symbol("t", real=True), sp.Symbol("v0"), turning.system.symbols["m"]
    x, y = (c.velocity for c in turning.system.coordinates)
    assert sp.simplify(turning.multipliers[0].subs({x: v0 * sp.cos(t**2), y: v0 * sp.sin(t**2)}) + 2 * m * v0 * t) == 0
    name = "P2-3 (C35), a knife edge"
    rod = hjsolve.constraint_forces(_free(name), CASES[name][3])
    theta, l, (λ,) = rod.system.symbols["theta"], rod.system.symbols["l"], rod.symbols
    m = rod.system.symbols["m"]
    assert [e.rhs for e in rod.equations.values()] == [λ * sp.sin(theta), -λ * sp.cos(theta), l * λ / 2]
    ddot = [sp.Symbol(f"ddot({n})", real=True) for n in ("x", "y", "theta")]
    left = [m * ddot[0], m * ddot[1], m * l**2 * ddot[2] / 12]
    assert [sp.simplify(e.lhs - x) for e, x in zip(rod.equations.values(), left, strict=True)] == [0, 0, 0]


def test_a_refusal_has_the_equations_with_multipliers() -> None:
    """C03: x = (v₀/ω)(cos ω t − 1), y = (v₀/ω) sin ω t, θ = ω t is a motion of the accelerations, and survives a pickle."""
    texts = ["dot(x)*cos(theta) + dot(y)*sin(theta) = 0"]
    with pytest.raises(hjsolve.NonholonomicError, match="not integrable") as refused:
        hjsolve.System(*ROD, 0, POSITIVE, constraints=texts)
    found = pickle.loads(pickle.dumps(refused.value)).equations
    t, v, w = sp.symbols("t v w", positive=True)
    path = {"x": v / w * (sp.cos(w * t) - 1), "y": v / w * sp.sin(w * t), "theta": w * t}
    put = {s: f for n, q in path.items() for s, f in (
        (found.system.symbols[n], q), (found.system.coordinate(n).velocity, sp.diff(q, t)))}  # fmt: skip
    for n, q in path.items():
        assert sp.simplify(found.accelerations[n].subs(put, simultaneous=True) - sp.diff(q, t, 2)) == 0
    holonomic_too = [*texts, "x + y = 1"]
    with pytest.raises(hjsolve.InvalidSystemError) as refused:
        hjsolve.System({**ROD[0], "phi": "angle"}, ROD[1] + " + dot(phi)**2/2", 0, POSITIVE,
                       constraints=["dot(theta) = sin(x)*dot(phi)", *holonomic_too[1:]])  # fmt: skip
    assert len(refused.value.equations.multipliers) == 2


@pytest.mark.parametrize("name", ["skate", "rod-with-knife-edge", "rolling-disk-vertical", "knife-edges-turning",
                                  "constraint-sin-t-squared"])  # fmt: skip
def test_a_refused_entry_has_its_equations(name: str) -> None:
    """Ex 2-6: λ = −2 m v₀ ω with x = (v₀/ω)(cos ω t − 1), y = (v₀/ω) sin ω t; the disk rolls on a circle evenly."""
    entry = hjsolve.catalog.describe(name)
    found = entry.equations
    assert found.texts == tuple(c.form for c in entry.constraints)
    assert list(found.equations) == list(entry.stated.coordinates)
    assert hjsolve.catalog.describe("kepler-planar").equations is None
    symbols, t = found.system.symbols, sp.Symbol("t", real=True)
    v, w = sp.symbols("v w", positive=True)
    if name == "knife-edges-turning":
        path = {"x": v / w * (sp.cos(w * t) - 1), "y": v / w * sp.sin(w * t)}
        values = {symbols["omega"]: w}
    elif name == "rolling-disk-vertical":
        path = {"phi": v * t, "alpha": w * t, "x": -symbols["r"] * v / w * sp.cos(w * t)}
        path, values = path | {"y": symbols["r"] * v / w * sp.sin(w * t)}, {}
    else:
        return
    put = {found.system.coordinate(n).velocity: sp.diff(q, t) for n, q in path.items()}
    put |= {symbols[n]: q for n, q in path.items()} | values
    for n, q in path.items():
        assert sp.simplify(found.accelerations[n].subs(put, simultaneous=True) - sp.diff(q, t, 2)) == 0
    if name == "knife-edges-turning":
        assert sp.simplify(found.multipliers[0].subs(put, simultaneous=True) + 2 * symbols["m"] * v * w) == 0


@pytest.mark.parametrize(("constraints", "message"), [
    ([], "give constraints"),
    (["dot(x)**2 = 1"], "linear"),
    (["x = 1", "2*x = 2"], "not independent"),
    ([3], "one equation"),
    (["x = w"], "'w'"),
])  # fmt: skip
def test_constraints_without_forces_are_refused(constraints: list[object], message: str) -> None:
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        hjsolve.constraint_forces(_free("a circle"), constraints)
