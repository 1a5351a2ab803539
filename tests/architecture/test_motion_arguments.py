"""``solution.motion`` tells what it takes, in ``help`` and in its errors."""

import inspect

import pytest

import hjsolve
from tests.support import entries

LINE = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "x**2/2"))
DOORS = {
    "Solution": LINE.motion,
    "LinearHamiltonian": hjsolve.from_hamiltonian("q + p", {"q": "line"}).motion,
    "GeneralHamiltonian": hjsolve.from_hamiltonian("p**4 + q**2", {"q": "line"}).motion,
    "HamiltonianInTime": hjsolve.from_hamiltonian("p**4 + (q + t)**2", {"q": "line"}).motion,
    "SumOfHamiltonians": hjsolve.from_hamiltonian("p_x**4 + x**2 + p_y**2 + y**2", {"x": "line", "y": "line"}).motion,
    "Frame": hjsolve.frames.load("spring-moving-anchor").motion,
    "LinearModes": hjsolve.gyroscopic_modes(hjsolve.catalog.load("gyroscopic-three")).motion,
}


@pytest.mark.parametrize("door", DOORS)
def test_the_signature_names_its_arguments(door):
    names = list(inspect.signature(DOORS[door]).parameters)
    assert names[:3] == ["q", "velocity", "p"]
    assert "position" in inspect.getdoc(DOORS[door])


def test_the_arguments_of_the_method_are_those_that_a_motion_is_started_from():
    from hjsolve.motion.charted.begin import StartGiven

    method, given = (inspect.signature(f).parameters for f in (LINE.motion, StartGiven))
    assert {name: a.default for name, a in method.items()} == {name: a.default for name, a in given.items()}


@pytest.mark.parametrize("door", DOORS)
def test_arguments_by_position_are_refused_with_what_to_write(door):
    with pytest.raises(hjsolve.InvalidInputError, match=r"motion: arguments go by name; write motion\(q=\{"):
        DOORS[door]({"x": 1}, {"x": 0})


@pytest.mark.parametrize("door", DOORS)
def test_unknown_and_missing_names_are_refused_with_what_to_write(door):
    with pytest.raises(hjsolve.InvalidInputError, match=r'motion: no argument "E"; known are q, velocity, p'):
        DOORS[door](E=1)
    with pytest.raises(hjsolve.InvalidInputError, match=r"motion: no q=\{…\}; write motion\(q=\{"):
        DOORS[door](p={"x": 1})


def test_the_example_of_the_message_runs():
    kepler = entries.solution("kepler-planar")
    assert kepler.motion(q={"r": 1, "theta": 0}, velocity={"r": 0, "theta": "1.2"}).kinds["r"] == "libration"
