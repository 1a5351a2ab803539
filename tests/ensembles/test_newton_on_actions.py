"""Newton's method on actions: how fast it comes back from far away, and rough integrals on its way."""

import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles.engine.constants import initial_constants
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.programs import system_programs
from hjsolve.ensembles.engine.starts import given_momenta
from hjsolve.ensembles.to_states.newton_on_actions import SOON, Asked, Solved, constants_of_tori
from hjsolve.ensembles.to_states.tori import APPROXIMATE, DOUBLES, AngleTask, Tori, actions_of
from hjsolve.motion.initial_data import parameter_values
from tests.ensembles.test_rotations import double_well

ANGULAR = np.array([1.3, 0.2, 0.7])


def kepler_by_newton(J: np.ndarray, energies: np.ndarray, rounds: int) -> tuple[Solved, int]:
    """Search for E of Kepler motions with radial actions J, from other energies; also which constant E is."""
    solution = hjsolve.solve("kepler-planar")
    model = lowered_model(solution, parameter_values(solution.system, {}))
    task = AngleTask(model, system_programs(model, kernels=True))
    asked = Asked.of(model, J[None], ANGULAR[None], (False,))
    (energy,) = asked.goals.unknown
    values = np.tile(ANGULAR, (len(model.constants), 1))
    values[energy] = energies
    begin = Tori(values, np.zeros_like(values), ANGULAR[None] ** 2, np.full((1, 4, 3), np.nan))
    return constants_of_tori(task, (begin, np.zeros((1, 3))), asked.goals, rounds), energy


@pytest.mark.parametrize("far", [1e-6, 1e-10, 1e-14])
def test_from_the_energy_of_escape(far):
    """J_r = 1/√(−2E) − L is a million times too large where E = −1e-14; E = −1/(2 (J_r + L)²)."""
    J = np.array([0.4, 1.7, 0.02])
    found, energy = kepler_by_newton(J, np.full(3, -far), 2 * SOON)
    assert found.good.all()
    np.testing.assert_allclose(found.tori.values[energy], -1 / (2 * (J + ANGULAR) ** 2), rtol=1e-13, atol=0)


@pytest.mark.parametrize("part", [1e-8, 1e-14, 1e-20])
def test_to_a_circle(part):
    """Small actions are linear in E: from J_r = L/100 nine rounds find one 1e18 times smaller."""
    found, energy = kepler_by_newton(part * ANGULAR, -1 / (2 * (1.01 * ANGULAR) ** 2), SOON)
    assert found.good.all()
    np.testing.assert_allclose(found.tori.values[energy], -1 / (2 * ((1 + part) * ANGULAR) ** 2), rtol=1e-13, atol=0)


@pytest.mark.parametrize("seed", [3, 17, 29])
def test_rough_integrals_of_rotations(seed):
    """A search that begins with rough integrals and none of whose nodes are proved ends at J from the engine."""
    system, q, p = double_well(seed)
    solution = hjsolve.solve(system)
    model = lowered_model(solution, {})
    programs = system_programs(model, kernels=True)
    start = initial_constants(model, programs, given_momenta(q[None], p[None]))
    tori = Tori(start.values, start.low, q[None], np.full((1, 4, len(q)), np.nan))
    going = np.ones((1, len(q)), dtype=bool)
    rough, fine = (actions_of(model, programs, tori, ~going, going, how)[0] for how in (APPROXIMATE, DOUBLES))
    assert rough.good.all()
    assert fine.good.all()
    np.testing.assert_allclose(rough.values, fine.values, rtol=1e-8, atol=0)
    np.testing.assert_allclose(rough.slopes, fine.slopes, rtol=1e-7, atol=0)
    assert not (rough.values == fine.values).all()  # else nothing was rough
