"""Random one-sided contacts against Newton's equations with a multiplier of their own, integrated by scipy up to its zero.

Cylinders, hoops, cosine hills, quartic bowls, cubics, a bell in a field: which of them end, and when.
"""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import hjsolve

x, y = sp.symbols("x y")
LAST = 8
SEEDS = [1003, 1007, 1016, 1021]


def drawn(seed: int) -> tuple[sp.Expr, sp.Expr, tuple[sp.Expr, ...], sp.Expr]:
    """Mass, V, the start (x, y, ẋ, ẏ) on the curve and along it, and g ≥ 0."""
    r = random.Random(seed)

    def number(low: float, high: float) -> sp.Rational:
        return sp.Rational(r.randint(int(low * 64), int(high * 64)), 64)

    m, g = number(0.5, 3), number(0.5, 3)
    kind = r.choice(["cylinder", "hoop", "hill", "bowl", "cubic", "bell"])
    V = m * g * y + (x**2 / 4 if kind == "bell" else 0)
    if kind in ("cylinder", "hoop"):
        t = sp.Rational(r.randint(1, 12), r.randint(1, 12))
        s, c = 2 * t / (1 + t * t) * r.choice([-1, 1]), (1 - t * t) / (1 + t * t)
        c *= r.choice([-1, 1]) if kind == "hoop" else 1
        radius, v = number(0.5, 2), number(0, 3) * r.choice([-1, 1])
        side = 1 if kind == "cylinder" else -1
        return m, V, (radius * s, radius * c, v * c, -v * s), side * (x**2 + y**2 - radius**2)
    curve = {
        "hill": number(0.3, 1) * sp.cos(x), "bowl": x**4 * number(0.05, 0.2) - x**2 * number(0.2, 1),
        "cubic": x**3 / 3 - x * number(0.2, 2), "bell": 1 / (1 + x**2),
    }[kind]  # fmt: skip
    place, v = number(-2, 2), number(-2, 2)
    return m, V, (place, curve.subs(x, place), v, v * sp.diff(curve, x).subs(x, place)), y - curve


def twin(m: sp.Expr, V: sp.Expr, start: tuple[sp.Expr, ...], g: sp.Expr) -> tuple[float, float | None]:
    """λ at the start, and when it first vanishes."""
    u, w = sp.symbols("u w")
    speeds = ((x, u), (y, w))
    bend = sum(sp.diff(g, s, k) * a * b for s, a in speeds for k, b in speeds)
    normal, force, b = (
        sp.lambdify((x, y, u, w), e) for e in ([sp.diff(g, s) for s in (x, y)], [-sp.diff(V, s) for s in (x, y)], bend)
    )
    mass = float(m)

    def multiplier(_t: float, Y: np.ndarray) -> float:
        a, F = np.array(normal(*Y), dtype=float), np.array(force(*Y), dtype=float)
        return float((-b(*Y) - a @ F / mass) / (a @ a / mass))

    def rates(t: float, Y: np.ndarray) -> np.ndarray:
        a, F = np.array(normal(*Y), dtype=float), np.array(force(*Y), dtype=float)
        return np.concatenate([Y[2:], (F + a * multiplier(t, Y)) / mass])

    multiplier.terminal = True  # type: ignore[attr-defined]
    begin = np.array([float(z) for z in start])
    found = solve_ivp(rates, (0, LAST), begin, "DOP853", rtol=1e-11, atol=1e-12, max_step=0.01, events=multiplier)
    ends = found.t_events[0]
    return multiplier(0, begin), float(ends[0]) if len(ends) else None


@pytest.mark.parametrize(
    "seed", [*SEEDS, *(pytest.param(s, marks=pytest.mark.nightly) for s in range(1000, 1060) if s not in SEEDS)]
)
def test_a_random_contact_ends_when_its_twin_does(seed: int) -> None:
    m, V, start, g = drawn(seed)
    pushed, time = twin(m, V, start, g)
    system = hjsolve.System({"x": "line", "y": "line"}, f"{m}/2*(dot(x)**2 + dot(y)**2)", str(V))
    call = {"q": dict(zip("xy", start[:2], strict=True)), "velocity": dict(zip("xy", start[2:], strict=True))}
    if pushed <= 0:
        with pytest.raises(hjsolve.InvalidInputError, match="does not push"):
            hjsolve.contact(system, **call, constraints=[f"{g} >= 0"])
        return
    found = hjsolve.contact(system, **call, constraints=[f"{g} >= 0"], until=LAST)
    assert found.proved
    assert (found.time is None) == (time is None)
    if time is not None:
        assert abs(found.time.value - time) < 1e-9
        state = found.after.at(found.time.value + 0.01)
        assert float(g.subs({x: state.q["x"], y: state.q["y"]})) > 0
