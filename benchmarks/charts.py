"""From x, y, z to x(t), y(t), z(t): motions in coordinates that were found, against Hamilton's equations in x, y, z.

    python benchmarks/charts.py [STARTS] [PERIODS] [NAME …]

For every system: random starts; the state after one and after PERIODS of its longest periods (10 and 10·PERIODS units
of time where it has none) against heyoka's Taylor integration in quadruple precision. A state is right where
|x − reference| and |v − reference| are at most the errors claimed. Printed: how many states were compared, how many are
right, the largest error against its claim, the largest claimed and true errors against the size of the orbit, the kinds
of motion, refusals, seconds to solve and for a motion with its states.
"""

from __future__ import annotations

import random
import sys
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import heyoka as hy
import mpmath
import numpy as np
import sympy as sp

import hjsolve
from benchmarks.quad_twin import _FUNCTIONS, Quad, _built, quad

_FUNCTIONS |= {sp.acos: hy.acos, sp.acosh: hy.acosh}
_MOST_STEPS = 20_000
_SMALL = {"Hénon–Heiles, KdV": 0.15, "Hénon–Heiles, Sawada–Kotera": 0.25, "KdV with a bound z": 0.15}
"""Half-width of the box of starts where it is not 1: a well that is left at a small energy."""
R2, R3 = "sqrt(x**2 + y**2)", "sqrt(x**2 + y**2 + z**2)"
T2, T3 = "(dot(x)**2 + dot(y)**2)/2", "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2"


def _made() -> dict[str, str]:
    """One potential for each web of space, in a frame turned and shifted; written by hand, no chart is used."""
    x, y, z = sp.symbols("x y z", real=True)
    X, Y, Z = sp.Matrix([[2, 1, 2], [1, 2, -2], [-2, 2, 1]]) / 3 * sp.Matrix([x - 1, y + 2, z - 3])
    r2, p2 = sp.expand(X**2 + Y**2 + Z**2), sp.expand(X**2 + Y**2)
    r, ρ = sp.sqrt(r2), sp.sqrt(p2)
    wall = (ρ + X) / ρ**3
    near, far = (sp.sqrt(sp.expand((X + s) ** 2 + Y**2)) for s in (-1, 1))
    low, high = (sp.sqrt(sp.expand(p2 + (Z + s) ** 2)) for s in (-1, 1))
    cone1, cone2 = sp.expand(4 * X**2 + 3 * Y**2 + Z**2) / r2, sp.expand(3 * X**2) / r2
    ell1, ell2, ell3 = 4 + r2, 3 + 4 * X**2 + 3 * Y**2 + Z**2, 3 * X**2
    par1, par2, par3 = 2 * X + 2, 4 * X - Y**2 - Z**2, -2 * Y**2
    spread = sp.sqrt((r2 - 1) ** 2 + 4 * sp.expand(Z**2))
    return {
        "cartesian, turned": sp.expand(X**4 + Y**4 + Z**2),
        "circular cylinder": sp.expand(p2**2 + Z**4) + wall,
        "elliptic cylinder": (
            ((near + far) ** 3 - (near - far) ** 3 + 5 * (near - far)) / (near * far) + sp.expand(Z**4)
        ),
        "parabolic cylinder": ((ρ + X) ** 4 + (ρ - X) ** 3) / ρ + sp.expand(Z**4),
        "spherical": sp.expand(r2**2) + Z / r**3 + wall,
        "prolate": ((low + high) ** 3 + 5 * (low - high)) / (low * high) + wall,
        "oblate (Vinti)": -sp.sqrt((r2 - 1 + spread) / 2) / spread,
        "rotational parabolic": ((r + Z) ** 4 + (r - Z) ** 3) / r + wall,
        "conical": sp.expand(r2**2) + (cone1**2 - cone2) / r2,
        "ellipsoidal, degree 6": sp.expand(ell1**3 - 2 * ell1 * ell2 + ell3),
        "paraboloidal, degree 4": sp.expand(par1**4 - 3 * par1**2 * par2 + par2**2 + 2 * par1 * par3),
    }


PLANE = {
    "two centres, turned": "-1/sqrt((x-1)**2 + (y-2)**2) - 3/sqrt((x-3)**2 + (y+1)**2)",
    "two centres, one repels": "-2/sqrt((x-1)**2 + y**2) + 1/sqrt((x+1)**2 + y**2)",
    "Kepler": f"-1/{R2}",
    "Stark, tilted": f"-1/{R2} + x/50 + y/100",
    "Hénon–Heiles, KdV": "(x**2 + 4*y**2)/2 + x**2*y + 2*y**3",
    "Hénon–Heiles, Sawada–Kotera": "(x**2 + y**2)/2 + x**2*y + y**3/3",
    "quartic 1:6:1": "x**4 + 6*x**2*y**2 + y**4 + (x**2 + y**2)/2",
    "quartic 1:12:16": "x**4 + 12*x**2*y**2 + 16*y**4",
    "oscillator 1:2, sheared": "(x**2 + 4*y**2)/2 + 3/10*x*y",
    "oscillator 1:2 with 1/x²": "(x**2 + y**2)/2 + 3*(4*x + 3*y)**2/50 + 1/(3*x - 4*y)**2",
    "Garnier, turned": "(x**2 + y**2)**2 + (3*x - 4*y)**2/25 + 3*(4*x + 3*y)**2/50",
    "dipole in a spring": f"(x**2 + y**2)/2 + (3/2*{R2} + x + y)/{R2}**3",
    "lens (Danilov–Nagaitsev)": ("(x**2 + y**2)/2 - 1/5*re_lens"),
}
SPACE = {
    "two centres": "-1/sqrt(x**2 + (y-1)**2 + (z-2)**2) - 2/sqrt((x-2)**2 + y**2 + (z+1)**2)",
    "Kepler 3D": f"-1/{R3}",
    "Stark, tilted 3D": f"-1/{R3} + x/100 + y/50 + z/50",
    "Calogero–Moser": "1/(x - y)**2 + 1/(y - z)**2 + 1/(z - x)**2 + (x**2 + y**2 + z**2)/2",
    "Garnier 3D": "(x**2 + y**2 + z**2)**2 + x**2 + 2*y**2 + 5*z**2",
    "KdV with a bound z": "(x**2 + 4*y**2)/2 + x**2*y + 2*y**3 + z**4",
    "springs with a zero mode": "(x - y)**2/2 + (y - z)**2/2",
    **_made(),
}


def _lens() -> str:
    """The integrable lens of Danilov and Nagaitsev, PRST-AB 13, 084002 (2010), eq. (29), in x and y.

    (ξ√(ξ² − 1) acosh ξ + η√(1 − η²)(acos η − π/2))/(ξ² − η²); ξ, η are half the sum and difference of the distances.
    """
    r1, r2 = "sqrt((x+1)**2 + y**2)", "sqrt((x-1)**2 + y**2)"
    ξ, η = f"(({r1} + {r2})/2)", f"(({r1} - {r2})/2)"
    return f"({ξ}*sqrt({ξ}**2 - 1)*acosh({ξ}) + {η}*sqrt(1 - {η}**2)*(acos({η}) - pi/2))/({ξ}**2 - {η}**2)"


def _text(V: Any) -> Any:
    return V.replace("re_lens", _lens()) if isinstance(V, str) else V


def system_named(name: str) -> hjsolve.System:
    """The system of a row."""
    n = 2 if name in PLANE else 3
    potential = _text({**PLANE, **SPACE}[name])
    return hjsolve.System(dict.fromkeys("xyz"[:n], "line"), (T2, T3)[n - 2], potential, title=name)


class Twin:
    """Hamilton's equations in x, y, z, in quadruple precision."""

    def __init__(self, system: hjsolve.System):
        names = [c.name for c in system.coordinates]
        places = [c.symbol for c in system.coordinates]
        known: dict[sp.Symbol, Any] = {s: hy.make_vars(f"x{k}") for k, s in enumerate(places)}
        speeds = [hy.make_vars(f"v{k}") for k in range(len(places))]
        equations = [(known[s], v) for s, v in zip(places, speeds, strict=True)]
        equations += [(v, _built(-sp.diff(system.potential, s), known)) for s, v in zip(places, speeds, strict=True)]
        self.names = names
        self.flow = hy.taylor_adaptive(
            equations, np.array([Quad("0.3")] * len(equations), dtype=Quad), fp_type=Quad, compact_mode=True
        )

    def states(self, start: list[str], times: list[float]) -> list[list[Any] | None]:
        """Places and velocities at rising times; None where the integration did not get there."""
        with mpmath.workdps(45):
            self.flow.state[:] = [quad(mpmath.mpf(sp.Rational(x).p) / sp.Rational(x).q) for x in start]
        self.flow.time = Quad("0")
        found: list[list[Any] | None] = []
        for t in times:
            outcome = self.flow.propagate_until(Quad(t), max_steps=_MOST_STEPS)[0]
            if outcome != hy.taylor_outcome.time_limit:
                return [*found, *[None] * (len(times) - len(found))]
            with mpmath.workdps(45):
                found.append([mpmath.mpf(str(x)) for x in self.flow.state])
        return found


@dataclass
class Row:
    """What was measured of one system."""

    solve: float = 0.0
    chart: str = ""
    compared: int = 0
    right: int = 0
    worst: float = 0.0
    claim: float = 0.0
    error: float = 0.0
    seconds: list[float] = field(default_factory=list)
    kinds: Counter[str] = field(default_factory=Counter)
    others: Counter[str] = field(default_factory=Counter)
    octants: set[tuple[bool, ...]] = field(default_factory=set)


def measure(name: str, starts: int, periods: float, seed: int = 1) -> Row:
    """Run one system."""
    system, row, dice = system_named(name), Row(), random.Random(f"{name} {seed}")
    begin = time.process_time()
    solution = hjsolve.solve(system, coordinates="find")
    row.solve = time.process_time() - begin
    row.chart = solution.chart.kind if solution.chart else "as given"
    twin = Twin(system)
    centre = (1, -2, 3) if name in _made() else (0, 0, 0)
    size = _SMALL.get(name, 1.0)
    for _ in range(starts):
        q = {c.name: f"{dice.uniform(-size, size) + o:.3f}" for c, o in zip(system.coordinates, centre, strict=False)}
        v = {c.name: f"{dice.uniform(-0.8, 0.8) * size:.3f}" for c in system.coordinates}
        _one(row, solution, twin, q, v, periods)
    return row


def _one(row: Row, solution: hjsolve.Solution, twin: Twin, q: Mapping[str, str], v: Mapping[str, str], periods: float):
    begin = time.process_time()
    try:
        motion = solution.motion(q=q, velocity=v)
        lengths = [p.value for p in motion.periods.values()]
        unit = max(lengths) if lengths and len(motion.periods) else 10.0
        times = [unit, periods * unit]
        state = motion.at(times)
        claims = [state.error.q, state.error.velocity]
    except hjsolve.HJSolveError as error:
        row.others[f"{type(error).__name__}: {str(error)[:90]}"] += 1
        return
    row.seconds.append(time.process_time() - begin)
    row.kinds[", ".join(motion.kinds.values())] += 1
    truths = twin.states([*q.values(), *v.values()], times)
    for k, truth in enumerate(truths):
        if str(state.status[k]) != "ok" or truth is None:
            row.others[f"{state.status[k]}{'' if truth else ', twin ended'}"] += 1
            continue
        row.compared += 1
        n, fine = len(twin.names), True
        size = max(abs(x) for x in truth)
        row.octants.add(tuple(x > 0 for x in truth[:n]))
        for group, values, bounds in ((0, state.q, claims[0]), (1, state.velocity, claims[1])):
            for i, c in enumerate(twin.names):
                with mpmath.workdps(45):
                    off = abs(mpmath.mpf(float(values[c][k])) - truth[group * n + i])
                fine &= bool(off <= bounds[c][k])
                row.worst = max(row.worst, float(off / bounds[c][k]))
                row.claim, row.error = max(row.claim, float(bounds[c][k] / size)), max(row.error, float(off / size))
        row.right += fine


def main() -> None:
    """Print the table."""
    arguments = sys.argv[1:]
    starts = int(arguments[0]) if arguments else 10
    periods = float(arguments[1]) if len(arguments) > 1 else 100.0
    names = [n for n in [*PLANE, *SPACE] if len(arguments) < 3 or any(a in n for a in arguments[2:])]
    print("system | web | solve s | motion s median, most | states | right | error/claim | claim | error | octants")
    for name in names:
        try:
            row = measure(name, starts, periods)
        except hjsolve.HJSolveError as error:
            print(f"{name} | {type(error).__name__}: {str(error)[:300]}", flush=True)
            continue
        spent = sorted(row.seconds) or [float("nan")]
        print(
            f"{name} | {row.chart} | {row.solve:.1f} | {spent[len(spent) // 2]:.2f}, {spent[-1]:.2f} | "
            f"{row.compared} | {row.right} | {row.worst:.2g} | {row.claim:.1e} | {row.error:.1e} | {len(row.octants)}",
            flush=True,
        )
        print("    kinds:", dict(row.kinds), "others:", dict(row.others), flush=True)


if __name__ == "__main__":
    main()
