"""Wrong kinds of arguments: no public call ends in an error from deep inside; what it says when it refuses."""

import ast
import inspect

import numpy as np
import pytest
import sympy as sp

import hjsolve

WRONG = [
    None, 3, 2.5, "nonsense", "", [], {}, [1, 2], {"x": 1}, float("nan"), object(), True, b"x", 1j, sp.Symbol("x"),
    np.array([1.0, 2.0]),
]  # fmt: skip
KEPLER = hjsolve.catalog.load("kepler-planar")
SOLUTION = hjsolve.solve(KEPLER)
START = {"q": {"r": 1, "theta": 0}, "p": {"r": "0.1", "theta": 1}}
MOTION = SOLUTION.motion(**START)
SYSTEM = {"coordinates": {"x": "line"}, "kinetic": "dot(x)**2/2", "potential": "x**2", "parameters": {}}

CONTACT = {
    "system": hjsolve.System({"x": "line", "y": "line"}, "(dot(x)**2 + dot(y)**2)/2", "y"),
    "q": {"x": "3/5", "y": "4/5"}, "velocity": {"x": 0, "y": 0}, "constraints": ["x**2 + y**2 >= 1"],
}  # fmt: skip

DOORS = {
    "solve": hjsolve.solve,
    "separate": hjsolve.separate,
    "separate: budget": lambda value: hjsolve.separate(KEPLER, budget=value),
    "find_coordinates": hjsolve.find_coordinates,
    "normal_modes": hjsolve.normal_modes,
    "gyroscopic_modes": hjsolve.gyroscopic_modes,
    "from_hamiltonian": lambda value: hjsolve.from_hamiltonian(value, {"q": "line"}),
    "torus: ratio": lambda value: hjsolve.solve("kepler-planar").torus(ratio=value, fixed={"E": -1}),
    "torus: frequencies": lambda value: hjsolve.solve("kepler-planar").torus(frequencies=value, fixed={"E": -1}),
    "torus: fixed": lambda value: hjsolve.solve("kepler-planar").torus(ratio={"r": 2, "theta": 1}, fixed=value),
    "torus: between": lambda value: hjsolve.solve("pendulum").torus(frequencies={"theta": 99}, between=value),
    "torus: kinds": lambda value: hjsolve.solve("pendulum").torus(frequencies={"theta": 99}, kinds=value),
    "separatrices: fixed": lambda value: hjsolve.solve("kepler-planar").separatrices(fixed=value),
    "action_integral": lambda value: hjsolve.action_integral(value, {"r": "1", "theta": "t"}, between=(0, 1)),
    "action_integral: path": lambda value: hjsolve.action_integral("kepler-planar", value, between=(0, 1)),
    "action_integral: between": lambda value: hjsolve.action_integral(
        "kepler-planar", {"r": "1", "theta": "t"}, between=value
    ),
    "constraint_forces": hjsolve.constraint_forces,
    "constraint_forces: constraints": lambda value: hjsolve.constraint_forces(CONTACT["system"], value),
    **{
        f"contact: {key}": lambda value, key=key: hjsolve.contact(**{**CONTACT, key: value})
        for key in ("system", "q", "velocity", "constraints", "parameters", "t0", "until", "digits")
    },
    "loop_integral": lambda value: hjsolve.loop_integral(value, q={}, p={}),
    "loop_integral: q": lambda value: hjsolve.loop_integral(SOLUTION, q=value, p={"r": "0", "theta": "1"}),
    "loop_integral: most": lambda value: hjsolve.loop_integral(
        SOLUTION, q={"r": "1", "theta": "s"}, p={"r": "0", "theta": "1"}, most=value
    ),
    "separatrix": lambda value: hjsolve.separatrix(value, 0, 1),
    "from_hamiltonian: coordinates": lambda value: hjsolve.from_hamiltonian("p", value),
    "catalog.load": hjsolve.catalog.load,
    "Scene.load": hjsolve.Scene.load,
    "cost": hjsolve.cost,
    "report": lambda value: hjsolve.report(value, "never-written.html"),
    "sweep": lambda value: hjsolve.sweep(value, "never-written"),
    "ensemble": lambda value: hjsolve.ensemble(value, **START),
    "ensemble: compiled": lambda value: value is True or hjsolve.ensemble(SOLUTION, **START, compiled=value),
    "at": MOTION.at,
    "angles": MOTION.angles,
    "characteristic_function": MOTION.characteristic_function,
    "principal_function": MOTION.principal_function,
    "time_at": lambda value: MOTION.time_at(value, 1),
    "time_at: value": lambda value: MOTION.time_at("r", value),
    "time_at: passage": lambda value: MOTION.time_at("r", 1, value),
    "orbit": lambda value: MOTION.orbit(value, along="r", values=[1]),
    "orbit: along": lambda value: MOTION.orbit("theta", along=value, values=[1]),
    "orbit: values": lambda value: MOTION.orbit("theta", along="r", values=value),
    **{f"System: {key}": lambda value, key=key: hjsolve.System(**{**SYSTEM, key: value}) for key in SYSTEM},
    **{
        f"motion: {key}": lambda value, key=key: SOLUTION.motion(**{**START, key: value})
        for key in ("q", "p", "velocity", "constants", "signs", "parameters", "t0", "digits", "certified", "want")
    },
    **{
        f"ensemble: {key}": lambda value, key=key: hjsolve.ensemble("kepler-planar", **{**START, key: value})
        for key in ("q", "p", "velocity", "parameters", "want", "threads", "fallback")
    },
}


@pytest.mark.nightly_cases("torus: kinds", "torus: between")
@pytest.mark.parametrize("door", DOORS)
def test_wrong_kinds_of_arguments_never_end_in_a_foreign_error(door):
    for value in WRONG:
        try:
            DOORS[door](value)
        except hjsolve.HJSolveError as error:
            assert "\n" not in str(error)[:60]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: hjsolve.solve(3), "solve: a System is needed, made by .*the id of a catalog entry.*, not 3"),
        (lambda: hjsolve.separate(KEPLER, budget=-1), "budget: a number of seconds, from 0 on, is needed, not -1"),
        (lambda: SOLUTION.motion(q=1, p={}), 'q: a table name → value is needed, such as {"r": 1}, not 1'),
        (lambda: SOLUTION.motion(**START, want=3), r'want: words are needed, such as \["actions", "periods"\], not 3'),
        (lambda: SOLUTION.motion(**START, digits=True), "digits: a whole number from 1 to 2000 is needed, not True"),
        (lambda: MOTION.time_at("r", 1, 0.5), "passage: a whole number is needed, not 0.5"),
        (lambda: MOTION.orbit("s", along="r", values=[1]), "s"),
        (
            lambda: hjsolve.Scene.load([]),
            "scene: the path of a TOML file or its table, a System or a catalog id is needed",
        ),
    ],
)
def test_the_message_says_what_to_write(call, says):
    with pytest.raises(hjsolve.InvalidInputError, match=says):
        call()


@pytest.mark.parametrize("name", [n for n in hjsolve.__all__ if inspect.isfunction(getattr(hjsolve, n))])
def test_a_name_that_a_function_does_not_have_is_answered_with_those_it_has_and_a_call_that_works(name):
    function = getattr(hjsolve, name)
    with pytest.raises(hjsolve.InvalidInputError, match=f'^{name}: no argument "nonsense"; known are ') as refused:
        function(nonsense=1)
    known, _, example = str(refused.value).partition("known are ")[2].partition("; write ")
    assert known.split(", ") == list(inspect.signature(function).parameters)
    call = ast.parse(example, mode="eval").body
    assert isinstance(call, ast.Call)
    assert ast.unparse(call.func) == name
    inspect.signature(function).bind(*call.args, **{word.arg: word.value for word in call.keywords})
