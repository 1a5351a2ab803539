"""Ensembles of systems typed in polar, cylindrical and spherical coordinates that separate in others."""

from __future__ import annotations

import numpy as np
import pytest

from hjsolve import System, ensemble, solve

POLAR = ({"r": "0 < r", "phi": "angle"}, "m*(dot(r)**2 + r**2*dot(phi)**2)/2")
CYLINDER = ({"R": "0 <= R", "phi": "angle", "z": "line"}, "m*(dot(R)**2 + R**2*dot(phi)**2 + dot(z)**2)/2")
SPHERE = (
    {"r": "0 < r", "theta": "0 < theta < pi", "phi": "angle"},
    "m*(dot(r)**2 + r**2*dot(theta)**2 + r**2*sin(theta)**2*dot(phi)**2)/2",
)
LATITUDE = (
    {"r": "0 < r", "b": "-pi/2 < b < pi/2", "phi": "angle"},
    "m*(dot(r)**2 + r**2*dot(b)**2 + r**2*cos(b)**2*dot(phi)**2)/2",
)
SYSTEMS = {
    "polar, Stark": (*POLAR, "-2/r + r*cos(phi)/10"),
    "cylindrical, Stark": (*CYLINDER, "-2/sqrt(R**2 + z**2) + z/10"),
    "cylindrical, oblique": (*CYLINDER, "-2/sqrt(R**2 + z**2) + R*cos(phi)/10"),
    "spherical, Stark": (*SPHERE, "-2/r + r*cos(theta)/10"),
    "spherical, latitude": (*LATITUDE, "-2/r + r*sin(b)/10"),
}
LENGTHS = {
    "polar": lambda q: [1, q[0]],
    "cylindrical": lambda q: [1, q[0], 1],
    "spherical, Stark": lambda q: [1, q[0], q[0] * np.sin(q[1])],
    "spherical, latitude": lambda q: [1, q[0], q[0] * np.cos(q[1])],
}


@pytest.mark.rotating(2)
@pytest.mark.parametrize("name", SYSTEMS)
def test_columns_are_those_of_single_motions_in_every_frame(name: str) -> None:
    coordinates, T, V = SYSTEMS[name]
    system = System(coordinates, T, V, {"m": "3/2"})
    dice, n = np.random.default_rng(7), 6
    q = np.array([dice.uniform(0.7, 1.3, n), *(dice.uniform(0.3, 1.2, n) for _ in range(len(coordinates) - 1))])
    v = np.array([dice.uniform(-0.3, 0.3, n) for _ in coordinates])
    scales = next(rule for key, rule in LENGTHS.items() if name.startswith(key))(q)
    lengths = np.array([v[k] * scales[k] for k in range(len(v))])
    solution, want = solve(system, "find"), {"actions", "frequencies", "angles"}
    assert solution.chart is not None
    names = list(coordinates)

    def batch(group: str, values: np.ndarray, **more: str):
        given = {"q": dict(zip(names, q)), group: dict(zip(names, values))}
        return ensemble(solution, **given, want=want, shown=False, **more)

    plain = batch("velocity", v)
    others = [
        batch("velocity", lengths, velocity_frame="orthonormal"),
        batch("p", np.array([1.5 * v[k] * scales[k] ** 2 for k in range(len(v))])),
    ]
    assert (plain.status == "ok").all()
    assert not plain.recomputed.all()
    for k in range(2):
        start = {"q": {name: float(x) for name, x in zip(names, q[:, k])}}
        motion = solution.motion(**start, velocity={name: float(x) for name, x in zip(names, v[:, k])}, digits=25)
        angles = motion.angles(0)
        for found, quantity in ((motion.actions, "actions"), (motion.frequencies, "frequencies")):
            for key, estimate in found.items():
                gap = abs(float(estimate.value - plain.columns[f"{quantity}.{key}"][k]))
                assert gap <= plain.error[quantity][key][k], (quantity, key)
        for key, angle in angles.items():
            gap = (float(angle) - plain.angles[key][k] + np.pi) % (2 * np.pi) - np.pi
            assert abs(gap) <= plain.error["angles"][key][k], key
    for other in others:  # the same starts but for their rounding
        for column in plain.layout.values():
            gap = plain.columns[column] - other.columns[column]
            assert np.max(np.abs((gap + np.pi) % (2 * np.pi) - np.pi)) < 1e-12, column
