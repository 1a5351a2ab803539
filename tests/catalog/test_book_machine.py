"""Rows of Greenwood's table that hjsolve does from what the book states: constraints, impacts, time, gyroscopic terms.

The other files check the entries, which are stated in coordinates that somebody chose; here the system is typed as the
book has it.
"""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp
from mpmath import mp, mpf

import hjsolve
from hjsolve.extended.stability_limit import stability_ranges
from tests.support.book import RESULTS, Result, exact, result

SPACE = {"x": "line", "y": "line", "z": "line"}
T3 = "m/2*(dot(x)**2 + dot(y)**2 + dot(z)**2)"
L1 = {"x": "line"}
RHOMBUS = hjsolve.System({"q1": "line", "q2": "line"}, "2*m*dot(q1)**2 + m/3*dot(q2)**2", 0, {"m": 1})
ROD = hjsolve.System(
    {"x": "line", "y": "line", "theta": "angle"},
    "m/2*(dot(x)**2 + dot(y)**2) + m*l**2/24*dot(theta)**2",
    0,
    {"m": 1, "l": 2},
)
BAR = hjsolve.System({"x": "line", "y": "line", "theta": "angle"}, "(dot(x)**2 + dot(y)**2)/2 + 5*dot(theta)**2", 0)


def values(found: dict[str, Any], **expected: Any) -> int:
    """Velocities are those of the book."""
    return exact(*(found[name] - sp.sympify(value) for name, value in expected.items()))


@result("C40", "P2-10, constraint typed")
def plane_velocity() -> int:
    """The constraint 2x' + 3y' + 4z' + 5 = 0 is integrated; the frame found has the velocity (-10, -15)/29 in x, y."""
    system = hjsolve.System(SPACE, T3, "k/2*(x**2 + y**2 + z**2)", {"m": 1, "k": 1},
                            constraints=["2*dot(x) + 3*dot(y) + 4*dot(z) + 5 = 0"])  # fmt: skip
    frame = hjsolve.solve(system, coordinates="find").frame
    rates = {name: sp.diff(f, system.time) for name, f in frame.place.items()}
    return values(rates, x=sp.Rational(-10, 29), y=sp.Rational(-15, 29))


@result("C72", "P4-8, constraint typed")
def incline() -> int:
    """x1'' = g/3 and x2'' = -g/3 with the constraint x1' - x2' + x3' = 0 typed."""
    system = hjsolve.System(SPACE, T3, "m*g*z", {"m": 1, "g": 1}, constraints=["dot(x) - dot(y) + dot(z) = 0"])
    s, M = system.symbols, sp.hessian(system.kinetic, [c.velocity for c in system.coordinates])
    force = -sp.Matrix([sp.diff(system.potential, c.symbol) for c in system.coordinates])
    rates = dict(zip((c.name for c in system.coordinates), M.LUsolve(force), strict=True))
    return values(rates, x=s["g"] / 3, y=-s["g"] / 3)


@result("C47", "Ex 3-1, impact()")
def rhombus() -> int:
    """Inelastic on the floor: q1' = -3/5, q2' = -6/5, impulse 8/5, energy lost 4/5, budgets balanced."""
    hit = hjsolve.impact(RHOMBUS, q={"q1": 0, "q2": 0}, velocity={"q1": -1, "q2": 0},
                         constraints=["dot(q1) - dot(q2)/2 = 0"])  # fmt: skip
    more = [hit.multipliers[0] - sp.Rational(8, 5), hit.energy_lost - sp.Rational(4, 5), *hit.budget.values()]
    return values(dict(hit.velocity), q1=sp.Rational(-3, 5), q2=sp.Rational(-6, 5)) + exact(*more)


@result("C48", "Ex 3-2, P3-2, impact()")
def bar() -> int:
    """Slide: (5/4, -1/4), -3/4; stick: (3/4, -3/4), -3/4."""
    place, before = {"x": 1, "y": 1, "theta": 0}, {"x": 0, "y": 1, "theta": -1}
    normal, tangent = "(dot(y) - dot(x))/sqrt(2) - sqrt(2)*dot(theta) = 0", "dot(x) + dot(y) = 0"
    slide = hjsolve.impact(BAR, q=place, velocity=before, constraints=[normal])
    stick = hjsolve.impact(BAR, q=place, velocity=before, constraints=[normal, tangent])
    third = sp.Rational(3, 4)
    return values(dict(slide.velocity), x=sp.Rational(5, 4), y=sp.Rational(-1, 4), theta=-third) + values(
        dict(stick.velocity), x=third, y=-third, theta=-third
    )


@result("C57", "P3-3, impact()")
def oblique_wall() -> int:
    """x' = 4/5*v0, y' = v0/5, theta' = 6v0/(5l), impulse sqrt(2)/5*m*v0."""
    wall = "(dot(y) - dot(x))/sqrt(2) + l/2*cos(theta)*dot(theta)/sqrt(2) = 0"
    rest = dict.fromkeys(("x", "y", "theta"), 0)
    hit = hjsolve.impact(ROD, q=rest, velocity={**rest, "x": 1}, constraints=[wall])
    return values(dict(hit.velocity), x="4/5", y="1/5", theta="3/5") + exact(hit.multipliers[0] - sp.sqrt(2) / 5)


@result("C58", "P3-4, impact()")
def wall_that_starts() -> int:
    """theta'(0+) = 3v0/(2*sqrt(2)*l), x' = 5/8*v0, y' = 3/8*v0, impulse 5/8*m*v0 of the wall."""
    rest = dict.fromkeys(("x", "y", "theta"), 0)
    forms = ["dot(x) + l/2*sin(theta)*dot(theta) = 1", "dot(y) - l/2*cos(theta)*dot(theta) = 0"]
    hit = hjsolve.impact(ROD, q={**rest, "theta": "pi/4"}, velocity=rest, constraints=forms)
    return values(dict(hit.velocity), x="5/8", y="3/8", theta=3 / (4 * sp.sqrt(2))) + exact(
        hit.multipliers[0] - sp.Rational(5, 8)
    )


@result("C51", "Ex 3-4, stability")
def pair_stable() -> int:
    """Case 2 is stable if and only if gamma^2 > 36, case 3 for no gamma."""
    two, three = (hjsolve.gyroscopic_modes("gyroscopic-pair", parameters={"k11": -1, "k12": 1, "k22": k})
                  for k in (-8, 8))  # fmt: skip
    ranges = stability_ranges(two, "gamma")
    assert [r.stable for r in ranges] == [True, False, True]
    assert [r.stable for r in stability_ranges(three, "gamma")] == [False]
    return exact(ranges[1].lower + 6, ranges[1].upper - 6)


@result("C62", "P3-11, stability", 1e-4)
def three_stable() -> Any:
    """Stable if and only if gamma^2 > 4.490*m*k."""
    ranges = stability_ranges(hjsolve.gyroscopic_modes("gyroscopic-three"), "gamma")
    assert [r.stable for r in ranges] == [True, False, True]
    return abs(sp.N(ranges[1].upper ** 2 / sp.Float("4.490") - 1, 20))


@result("C53", "Ex 3-6, symmetric gauge")
def symmetric_gauge() -> Any:
    """In the symmetric gauge too: x = (E/B)*t - (m*E/e*B^2)*sin(e*B*t/m), from rest."""
    rest = dict.fromkeys("xyz", 0)
    state = hjsolve.gyroscopic_modes("crossed-fields-symmetric-gauge", digits=20).motion(q=rest, velocity=rest).at(7)
    with mp.workdps(30):
        expected = mpf(7) / 2 - mp.sin(7) / 2
        return abs(mpf(state.q["x"]) / expected - 1)


@result("C87", "P6-11, motion")
def turning_axes() -> Any:
    """A straight line seen from turning axes: x = (1 + t/10)*cos t + 6t/5*sin t."""
    motion = hjsolve.gyroscopic_modes("free-particle-turning-axes", digits=20).motion(
        q={"x": 1, "y": 0}, velocity={"x": "0.1", "y": "0.2"}
    )
    state = motion.at("2.5")
    with mp.workdps(30):
        expected = (1 + mpf(1) / 4) * mp.cos(mpf("2.5")) + 3 * mp.sin(mpf("2.5"))
        return abs(mpf(state.q["x"]) / expected - 1)


@result("C82", "Ex 6-9, frame found")
def anchor() -> int:
    """The Galilean frame Q = q - t is found, and K has the potential k*Q^2/2."""
    frame = hjsolve.solve(hjsolve.System(L1, "m/2*dot(x)**2", "k/2*(t - x)**2", {"m": 1, "k": 1})).frame
    X, k = frame.system.coordinates[0].symbol, frame.system.symbols["k"]
    return exact(frame.place["x"] - X - frame.time, frame.system.potential - k * X**2 / 2)


@result("C88", "P6-13, frame found")
def drifting_gauge() -> int:
    """The force -m from the gauge m*t*q moves the anchor: q = Q - m/k."""
    frame = hjsolve.solve(hjsolve.System(L1, "m/2*(dot(x) + t)**2", "k/2*x**2", {"m": 1, "k": 1})).frame
    X, s = frame.system.coordinates[0].symbol, frame.system.symbols
    return exact(frame.place["x"] - X + s["m"] / s["k"], frame.system.potential - s["k"] * X**2 / 2)


@pytest.mark.parametrize("checked", RESULTS[__name__], ids=lambda r: r.name)
def test_the_result_of_the_book_is_reproduced(checked: Result) -> None:
    assert checked.error() <= checked.tolerance
