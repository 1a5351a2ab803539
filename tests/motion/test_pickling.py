"""Motions, states and runs travel: pickled and copied they give the same numbers, bit for bit, in another process too."""

import copy
import dataclasses
import pickle
import subprocess
import sys

import mpmath
import numpy as np
import pytest

import hjsolve
from tests.support import entries

KEPLER = {"q": {"r": 1, "theta": 0}, "p": {"r": "0.1", "theta": "1.1"}}
FIELDS = (
    "constants", "kinds", "turning_points", "actions", "frequencies", "periods", "boundary_times", "mean_velocities",
)  # fmt: skip


def kepler(**changed):
    return entries.solution("kepler-planar").motion(**{**KEPLER, **changed})


def pendulum(speed, **more):
    return entries.solution("pendulum").motion(q={"theta": 0}, velocity={"theta": speed}, **more)


def linear(digits):
    return hjsolve.from_hamiltonian("q + p", {"q": "line"}).motion(q={"q": "0.5"}, p={"q": 1}, digits=digits)


def modal():
    rest = {"q1": 0, "q2": 0, "q3": 0}
    return hjsolve.gyroscopic_modes(hjsolve.catalog.load("gyroscopic-three")).motion(q={**rest, "q1": 1}, velocity=rest)


MOTIONS = {
    "libration": lambda: kepler(),
    "in 30 digits": lambda: kepler(digits=30),
    "certified": lambda: kepler(certified=True),
    "from numbers of all kinds": lambda: kepler(p={"r": np.float32(0.1), "theta": mpmath.mpf("1.1")}),
    "escape": lambda: kepler(p={"r": "0.1", "theta": 2}),
    "to an end": lambda: kepler(p={"r": "0.1", "theta": 0}),
    "to an end, in 30 digits": lambda: kepler(p={"r": "0.1", "theta": 0}, digits=30),
    "at rest": lambda: kepler(p={"r": 0, "theta": 1}),
    "rotation": lambda: pendulum("2.5"),
    "separatrix": lambda: pendulum(2),
    "three coordinates": lambda: entries.motion("lagrange-top"),
    "two coupled": lambda: entries.motion("kuzmin-kutuzov"),
    "any H(q, p)": lambda: hjsolve.from_hamiltonian("p**4 + q**2", {"q": "line"}).motion(q={"q": 1}, p={"q": 0}),
    "linear in p": lambda: linear(15),
    "linear in p, in 30 digits": lambda: linear(30),
    "framed": lambda: hjsolve.frames.load("spring-moving-anchor").motion(q={"q": "0.3"}, velocity={"q": "0.4"}),
    "modes": modal,
}


def numbers(motion):
    """All that a motion says, as text that shows every bit."""
    told = [repr(getattr(motion, name)) for name in FIELDS if hasattr(motion, name)]
    many = isinstance(motion, hjsolve.motion.motion.Motion) and motion.digits <= 15
    for times in ("0.7", [0.25, 2.5], np.linspace(0, 1, 2100 if many else 2)):
        try:
            told.append(shown(motion.at(times)))
        except hjsolve.HJSolveError as error:
            told.append(str(error))
    return told


def shown(state):
    if isinstance(state, tuple):
        return repr(state)
    groups = [state.q, state.p, state.velocity, state.turns, *(getattr(state.error, n) for n in ("q", "p", "velocity"))]
    return repr([{name: np.asarray(x).tolist() for name, x in group.items()} for group in groups]) + repr(state.status)


@pytest.mark.rotating(6)
@pytest.mark.nightly_cases("to an end", "two coupled")
@pytest.mark.parametrize("name", MOTIONS)
def test_a_copy_gives_the_same_numbers_bit_for_bit(name):
    motion = MOTIONS[name]()
    before = pickle.dumps(motion)
    expected = numbers(motion)
    for again in (pickle.loads(before), pickle.loads(pickle.dumps(motion)), copy.deepcopy(motion), copy.copy(motion)):
        assert numbers(again) == expected
        with pytest.raises(dataclasses.FrozenInstanceError):
            again.digits = 3


@pytest.mark.nightly
def test_another_process_gives_the_same_numbers_bit_for_bit(tmp_path):
    names = ["libration", "in 30 digits", "certified", "escape", "to an end, in 30 digits", "separatrix", "framed"]
    motions = [MOTIONS[name]() for name in names]
    path = tmp_path / "motions"
    path.write_bytes(pickle.dumps(motions))
    program = (
        "import pickle, pathlib, sys; from tests.motion.test_pickling import numbers; "
        "print([numbers(m) for m in pickle.loads(pathlib.Path(sys.argv[1]).read_bytes())])"
    )
    done = subprocess.run([sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == repr([numbers(motion) for motion in motions])


@pytest.mark.parametrize("name", ["libration", "in 30 digits", "to an end", "linear in p", "framed"])
@pytest.mark.parametrize("times", [0.5, [0.5, 50.0], np.linspace(0, 1, 2100)])
def test_a_state_travels_with_its_errors(name, times):
    motion = MOTIONS[name]()
    if not isinstance(motion, hjsolve.motion.motion.Motion) or motion.digits > 15:
        times = np.ravel(times)[:2]
    state = motion.at(times)
    for again in (pickle.loads(pickle.dumps(state)), copy.deepcopy(state)):
        assert shown(again) == shown(state)
        names = list(state.q)
        assert repr(again.unwrapped(names[0])) == repr(state.unwrapped(names[0]))


def test_an_estimate_in_many_digits_travels():
    estimate = kepler(digits=40).periods["r"]
    again = pickle.loads(pickle.dumps(estimate))
    assert again == estimate
    assert again.value.context.prec == estimate.value.context.prec
    assert again.value + estimate.value == 2 * estimate.value


def test_a_run_of_a_scene_travels():
    for name in ("bouncing-ball", "damped-pendulum"):
        run = hjsolve.Scene.load(f"scenes/{name}.toml").run()
        for again in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
            assert shown(again.trajectory) == shown(run.trajectory)
            assert repr([dict(arc.quantities) for arc in again.arcs]) == repr(
                [dict(arc.quantities) for arc in run.arcs]
            )


def test_what_was_given_may_be_changed_afterwards():
    place = {"r": 1, "theta": 0}
    motion = kepler(q=place)
    expected = motion.again(30, {}).periods["r"].value
    place["r"] = 7
    assert motion.again(30, {}).periods["r"].value == expected
