"""W(q, J) and the angle variables as formulas: along a motion every angle grows by its frequency."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import sympy as sp

import hjsolve

ENTRIES = ("harmonic-oscillator", "kepler-planar", "isotropic-oscillator-polar", "kepler-spherical")


@pytest.mark.nightly_cases(*ENTRIES[1:])
@pytest.mark.parametrize("entry", ENTRIES)
def test_angles_from_w_of_the_actions_grow_by_the_frequencies(entry: str) -> None:
    """w = dW(q, J)/dJ on hjsolve's own motion, which is computed from quadratures; on one way up of every libration."""
    solution = hjsolve.solve(entry)
    motion = solution.motion(**hjsolve.catalog.describe(entry).motions["default"].arguments)
    form = next(f for f in hjsolve.closed_forms(solution, seconds=30) if f.energy is not None)
    angles = form.angle_variables
    assert set(angles) == set(motion.actions)
    fixed = {f"J_{n}": x.value for n, x in motion.actions.items()}
    fixed |= {p.name: motion.initial.values[p.symbol] for p in solution.system.parameters}
    names = [c.name for c in solution.system.coordinates]
    runs: list[list[tuple[float, dict[str, float]]]] = [[]]
    for t in np.linspace(0, 3 * max(x.value for x in motion.periods.values()), 61):
        state = motion.at(t)
        if all(state.p[n] > 0.05 for n in solution.coordinates):
            runs[-1].append((t, {n: float(state.unwrapped(n)) for n in names}))
        elif runs[-1]:
            runs.append([])
    compared = 0
    for run in runs:
        for (t0, first), (t1, second) in itertools.pairwise(run):
            start = {f"{n}_0": first[n] for n in names}
            for name, w in angles.items():
                values = [
                    complex(w.subs({s: {**fixed, **start, **at}[s.name] for s in w.free_symbols}).evalf(20))
                    for at in (first, second)
                ]
                frequency = float(motion.frequencies[name].value)
                assert abs(values[1] - values[0] - frequency * (t1 - t0)) < 1e-10
                compared += 1
    assert compared >= 10


@pytest.mark.nightly
def test_constants_in_the_actions() -> None:
    """Kepler in space: alpha_2 = (J_theta + |J_phi|)**2/2, E by Delaunay's sum."""
    form = next(f for f in hjsolve.closed_forms(hjsolve.solve("kepler-spherical"), seconds=30) if f.energy is not None)
    J = {n: sp.Symbol(f"J_{n}", real=True) for n in ("r", "theta", "phi")}
    L = J["theta"] + sp.Abs(J["phi"])
    assert sp.simplify(form.constants_of_actions["alpha_2"] - L**2 / 2) == 0
    assert form.constants_of_actions["p_phi"] == J["phi"]
    k, m = (s for s in sorted(form.energy.free_symbols, key=str) if s.name in "km")
    assert sp.simplify(form.energy + k**2 * m / (2 * (J["r"] + L) ** 2)) == 0


def test_without_an_energy_in_the_actions_there_is_no_function_of_them() -> None:
    form = next(f for f in hjsolve.closed_forms(hjsolve.solve("pendulum"), seconds=30))
    assert (form.energy, form.function_of_actions, form.angle_variables) == (None, None, {})
