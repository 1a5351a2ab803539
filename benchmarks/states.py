"""States of orbits from actions and angles: ``python -m benchmarks.states`` prints the table of docs/tori.md.

Actions and angles of the families of ``galaxy_families`` are those of their stars, by the engine; others are drawn. The
price is the time of the public call on a clock, and that of the processor, for 65 536 orbits at once or as many as are
asked for; tables and programs are there already. The last column is what J of the states differs by from the J given,
over max(1e-12, 20 × what a rounding of every q and p does to J).
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

import hjsolve
from benchmarks import galaxy_families
from hjsolve.motion.initial_data import parameter_values

Columns = dict[str, Any]
_IN_THE_GAP = 4096
"""Orbits about two centres of which those that no torus has are counted."""
_DRAWS = 6
"""How often q and p are moved by a rounding."""


def galaxy_states(family: str, count: int) -> tuple[Columns, Columns]:
    """Return positions and momenta of stars."""
    u, w, pu, pw, pφ = galaxy_families.prolate(galaxy_families.family(family, count)).T
    return {"u": u, "w": w, "phi": 0 * u + 0.3}, {"u": pu, "w": pw, "phi": pφ}


def drawn(name: str, count: int) -> tuple[Columns, Columns]:
    """Return actions and angles of one of the systems of the library, spread evenly in their logarithm."""
    dice = np.random.default_rng(3)
    ranges = SYSTEMS[name]
    actions = {c: np.exp(dice.uniform(np.log(low), np.log(high), count)) for c, (low, high) in ranges.items()}
    return actions, {c: dice.uniform(-3, 3, count) for c in ranges}


SYSTEMS: dict[str, dict[str, tuple[float, float]]] = {
    "kepler-planar": {"r": (1e-3, 3.0), "theta": (1e-1, 2.0)},
    "isochrone": {"r": (1e-3, 3.0), "theta": (1e-1, 2.0)},
    "spherical-pendulum": {"theta": (1e-3, 5.0), "phi": (1e-2, 3.0)},
    "two-centres-space": {"xi": (1e-2, 1.0), "eta": (1e-2, 1.0), "phi": (1e-1, 2.0)},
}


def about_two_centres(count: int) -> tuple[Columns, Columns, Columns]:
    """Return actions, angles and places of random bounded motions about two centres."""
    dice, size = np.random.default_rng(5), 3 * count
    q = {"xi": np.exp(dice.uniform(-3, 1.2, size)), "eta": dice.uniform(0.1, 3, size), "phi": dice.uniform(-3, 3, size)}
    p = {"xi": dice.normal(0, 1, size), "eta": dice.normal(0, 1, size), "phi": np.exp(dice.uniform(-3, 1, size))}
    return _of_motions("two-centres-space", q, p, count)


def on_an_ellipsoid(count: int) -> tuple[Columns, Columns, Columns]:
    """Return actions, angles and places of random geodesics on a triaxial ellipsoid."""
    dice = np.random.default_rng(5)
    names = [c.name for c in hjsolve.solve("triaxial-geodesics").system.coordinates]
    q, p = ({name: draw(count) for name in names} for draw in (lambda n: dice.uniform(-3, 3, n), dice.standard_normal))
    return _of_motions("triaxial-geodesics", q, p, count)


def _of_motions(name: str, q: Columns, p: Columns, count: int) -> tuple[Columns, Columns, Columns]:
    forth = hjsolve.ensemble(name, q=q, p=p, want={"actions", "angles"}, fallback=False)
    known = np.flatnonzero(forth.codes == 0)[:count]
    actions, angles, places = ({c: np.array(x)[known] for c, x in g.items()} for g in (forth.actions, forth.angles, q))
    return actions, angles, places


def conditioning(solution: Any, q: Columns, p: Columns, actions: Columns) -> Columns:
    """Return what a rounding of every q and p does to the actions, relatively."""
    dice, found = np.random.default_rng(9), {name: np.zeros(np.shape(J)) for name, J in actions.items()}
    for _ in range(_DRAWS):
        moved = [
            {c: x * (1 + np.finfo(float).eps * dice.choice([-1.0, 1.0], x.shape)) for c, x in group.items()}
            for group in (q, p)
        ]
        other = hjsolve.ensemble(solution, q=moved[0], p=moved[1], want={"actions"}, fallback=False).actions
        for name, J in actions.items():
            with np.errstate(all="ignore"):
                found[name] = np.fmax(found[name], np.abs(other[name] - J) / np.abs(J))
    return found


def row(title: str, solution: Any, actions: Columns, angles: Columns, wells: Columns | None = None) -> str:
    """Measure one family; ``wells`` are places in the wells that are meant."""
    count = len(next(iter(actions.values())))

    def back() -> Any:
        return hjsolve.ensemble(solution, actions=actions, angles=angles, q=wells, want={"state"}, fallback=False)

    back()  # tables and programs
    begin, clock = time.process_time(), time.perf_counter()
    engine = back()
    price, wall = (time.process_time() - begin) / count, (time.perf_counter() - clock) / count
    q, p = ({c: np.array(x) for c, x in group.items()} for group in (engine.q, engine.p))
    hjsolve.ensemble(solution, q=q, p=p, want={"actions", "angles"}, fallback=False)
    clock = time.perf_counter()
    again = hjsolve.ensemble(solution, q=q, p=p, want={"actions", "angles"}, fallback=False)
    forth = (time.perf_counter() - clock) / count
    found = conditioning(solution, q, p, again.actions)
    worst = 0.0
    for name, J in actions.items():
        with np.errstate(all="ignore"):
            off = np.abs(again.actions[name] - J) / np.abs(J) / np.fmax(1e-12, 20 * found[name])
        worst = max(worst, float(np.nanmax(off)))
    several = (engine.status == "ambiguous").sum()
    parts = f"{1e6 * wall:.0f} | {1e6 * price:.0f} | {wall / forth:.0f} | {(engine.codes == 0).sum()} | {several}"
    return f"| {title} | {count} | {parts} | {worst:.2g} |"


def rival(actions: Columns, angles: Columns) -> str:
    """Measure galpy's closed formulas of the isochrone on the orbits of ours, a little out of the plane."""
    try:
        from galpy.actionAngle import actionAngleIsochrone, actionAngleIsochroneInverse
        from galpy.potential import IsochronePotential
    except ImportError:
        return "| isochrone, galpy | not installed |"
    core = IsochronePotential(amp=1.0, b=0.5)
    rule, J, height = actionAngleIsochroneInverse(ip=core), actions["theta"], 1e-3 * actions["theta"]
    count, begin, clock = len(J), time.process_time(), time.perf_counter()
    found = rule(actions["r"], J, height, angles["r"], angles["theta"], 0 * J)
    price, wall = (time.process_time() - begin) / count, (time.perf_counter() - clock) / count
    off = np.abs(actionAngleIsochrone(ip=core)(*found[:5])[0] / actions["r"] - 1)
    lost = int(np.isnan(off).sum())
    title = f"isochrone, galpy's formulas: ΔJ/J up to {np.nanmax(off):.0e}"
    return f"| {title} | {count} | {1e6 * wall:.1f} | {1e6 * price:.1f} | | {count - lost} | | |"


def between_lobes(solution: Any, actions: Columns) -> int:
    """Count orbits about two centres that no torus has: J_η between the larger lobe at the separatrix and both lobes.

    On the separatrix F_η has a double zero between the centres; its energy is found from J_ξ and p_φ, by bisection.
    """
    values = {symbol.name: float(value) for symbol, value in parameter_values(solution.system, {}).items()}
    a, m, k1, k2 = (values[name] for name in ("a", "m", "k1", "k2"))
    η, ξ = np.linspace(1e-4, np.pi - 1e-4, 20_001), np.linspace(1e-4, 9, 20_001)
    found = 0
    for J_ξ, J_η, L in zip(*(actions[n] for n in ("xi", "eta", "phi")), strict=True):
        low, high, lobes = -50.0, -1e-2, None
        for _ in range(50):
            E = -np.sqrt(low * high)
            F = 2 * E * a * a * m * np.sin(η) ** 2 - 2 * a * (k1 - k2) * m * np.cos(η) - (L / np.sin(η)) ** 2
            dips = 1 + np.flatnonzero((F[1:-1] < F[:-2]) & (F[1:-1] < F[2:]))
            if not len(dips):
                high = E
                continue
            top = dips[0]
            other = 2 * E * a * a * m * np.sinh(ξ) ** 2 + 2 * a * (k1 + k2) * m * np.cosh(ξ) - (L / np.sinh(ξ)) ** 2
            root, at = np.sqrt(np.fmax(F - F[top], 0)), np.trapezoid(np.sqrt(np.fmax(other + F[top], 0)), ξ) / np.pi
            lobes = [np.trapezoid(part, η[:n]) / np.pi for part, n in ((root[:top], top), (root[top:], len(η) - top))]
            low, high = (E, high) if at < J_ξ else (low, E)
        found += lobes is not None and max(lobes) < J_η < sum(lobes)
    return found


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 65_536
    print(
        "| family | orbits | µs an orbit | of the processor | × state to actions | ok | several wells | J / allowed |"
    )
    print("|---|---|---|---|---|---|---|---|")
    galaxy = galaxy_families.galaxy()
    for family in galaxy_families.FAMILIES:
        q, p = galaxy_states(family, count)
        forth = hjsolve.ensemble(galaxy, q=q, p=p, want={"actions", "angles"})
        print(row(family, galaxy, dict(forth.actions), dict(forth.angles)), flush=True)
    for name in SYSTEMS:
        print(row(name, hjsolve.solve(name), *drawn(name, count)), flush=True)
        if name == "isochrone":
            print(rival(*drawn(name, count)), flush=True)
    told = about_two_centres(count)
    print(row("two-centres-space, q told", hjsolve.solve("two-centres-space"), *told), flush=True)
    several = on_an_ellipsoid(count)
    print(row("triaxial-geodesics, q told", hjsolve.solve("triaxial-geodesics"), *several), flush=True)
    solution, (actions, angles) = hjsolve.solve("two-centres-space"), drawn("two-centres-space", _IN_THE_GAP)
    states = hjsolve.ensemble(solution, actions=actions, angles=angles, want={"state"}, fallback=False)
    left = np.flatnonzero(states.status == "not_converged")
    gap = between_lobes(solution, {name: J[left] for name, J in actions.items()})
    told = f"of {len(left)} of {_IN_THE_GAP} orbits left over {gap} lie in the gap of a separatrix, where no torus is"
    print(f"\ntwo-centres-space: {told}")


if __name__ == "__main__":
    main()
