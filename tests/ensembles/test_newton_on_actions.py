"""Newton's method on actions: how fast it comes back from far away."""

import numpy as np
import pytest

import hjsolve
from hjsolve.ensembles.engine.lowered_solution import lowered_model
from hjsolve.ensembles.engine.programs import system_programs
from hjsolve.ensembles.to_states.newton_on_actions import SOON, Asked, constants_of_tori
from hjsolve.ensembles.to_states.tori import AngleTask, Tori
from hjsolve.motion.initial_data import parameter_values


@pytest.mark.parametrize("far", [1e-6, 1e-10, 1e-14])
def test_from_the_energy_of_escape(far):
    """J_r = 1/√(−2E) − L is a million times too large where E = −1e-14; E = −1/(2 (J_r + L)²)."""
    solution = hjsolve.solve("kepler-planar")
    model = lowered_model(solution, parameter_values(solution.system, {}))
    task = AngleTask(model, system_programs(model, kernels=True))
    L, J = np.array([1.3, 0.2, 0.7]), np.array([[0.4, 1.7, 0.02]])
    values = np.empty((len(model.constants), 3))
    (unknown,) = Asked.of(model, J, L[None], (False,)).goals.unknown
    values[:] = L
    values[unknown] = -far
    begin = Tori(values, np.zeros_like(values), L[None] ** 2, np.full((1, 4, 3), np.nan))
    goals = Asked.of(model, J, L[None], (False,)).goals
    found = constants_of_tori(task, (begin, np.zeros((1, 3))), goals, 2 * SOON)
    assert found.good.all()
    np.testing.assert_allclose(found.tori.values[unknown], -1 / (2 * (J[0] + L) ** 2), rtol=1e-13, atol=0)
