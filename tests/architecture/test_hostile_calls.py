"""Three hundred hostile and odd calls of public doors: each gives a result or one clear error, and no warning.

The calls are all pairs of a value and a door (an argument of a public call), taken in turn by a fixed rule.
"""

import math
import warnings
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp

import hjsolve

NUMBERS = {
    "huge": 1e300, "huge text": "1e300", "least": 5e-324, "least text": "5e-324", "denormal": -3e-310,
    "tiny text": "1e-300", "beyond": "1e4000", "beneath": "1e-4000", "huge int": 10**400, "nan": math.nan,
    "inf": -math.inf, "nan text": "nan", "inf text": "oo", "minus zero": -0.0, "bool": True, "complex": 1j,
    "real complex": 1 + 0j, "none": None, "empty text": "", "blank": "  ", "formula": "sqrt(2)-1", "imaginary": "sqrt(-1)",
    "foreign": "x+1", "code": "__import__('os')", "division": "1/0", "tower": "9**9**9**9", "unit": "3 m", "comma": "1,5",
    "digits": "0." + "3" * 5000, "unicode": "１", "decimal": Decimal("0.1"), "bad decimal": Decimal("NaN"),
    "endless decimal": Decimal("Infinity"), "fraction": Fraction(1, 3), "mpf": mpmath.mpf("0.3"), "mpc": mpmath.mpc(0, 1),
    "mp nan": mpmath.mpf("nan"), "sympy": sp.sqrt(2) / 3, "symbol": sp.Symbol("x"), "sympy zoo": sp.zoo,
    "sympy complex": sp.I, "sympy float": sp.Float("0.2", 40), "numpy int": np.int8(1), "numpy uint": np.uint64(2**63),
    "numpy half": np.float16(0.3), "numpy long": np.longdouble("0.1"), "numpy bool": np.bool_(False),
    "numpy complex": np.complex128(1), "date": np.datetime64("2020-01-01"), "bytes": b"1", "set": {1}, "type": float,
}  # fmt: skip
ARRAYS = {
    "0-d": np.array(0.25), "empty": np.array([]), "empty list": [], "no rows": np.zeros((0, 3)), "deep": np.zeros((1, 1, 2)),
    "ragged": [[1, 2], [3]], "masked": np.ma.array([0.1, 0.2], mask=[True, False]), "objects": np.array([1, None]),
    "fractions": np.array([Fraction(1, 3), Fraction(1, 2)]), "texts": np.array(["0.1", "0.2"]), "bools": [True, False],
    "with nan": [0.1, math.nan], "with inf": np.array([0.1, math.inf]), "complexes": np.array([1j, 0.2]),
    "half": np.array([0.1, 0.3], dtype=np.float16), "long": np.array([0.1, 0.3], dtype=np.longdouble),
    "unsigned": np.array([1, 2], dtype=np.uint8), "far apart": [1e-300, 1e15], "least ones": [5e-324, -5e-324],
    "huge ones": np.array([1e300, -1e300]), "backwards": np.array([0.1, 0.2, 0.3])[::-1], "swapped": np.array([0.1], ">f8"),
    "dates": np.array(["2020-01-01"], dtype="datetime64[D]"), "structured": np.zeros(2, dtype=[("a", float)]),
    "mpfs": [mpmath.mpf("0.1"), mpmath.mpf("0.2")], "mixed": [0.1, "0.2", Fraction(1, 3)], "decimals": [Decimal("0.1")],
    "frozen": (0.1, 0.2), "range": range(3), "iterator": iter([0.1]), "dict": {0: 0.1}, "matrix": sp.Matrix([1, 2]),
}  # fmt: skip

LINE = hjsolve.solve(hjsolve.System({"x": "line"}, "dot(x)**2/2", "k*x**2/2", {"k": 1}))
KEPLER = hjsolve.solve("kepler-planar")
LINEAR = hjsolve.from_hamiltonian("q*p", {"q": "line"})
QUARTIC = hjsolve.from_hamiltonian("p**4 + q**2", {"q": "line"})
ROUND = QUARTIC.motion(q={"q": 1}, p={"q": 0})
LIBRATION, ORBIT = (
    LINE.motion(q={"x": 1}, velocity={"x": 0}),
    KEPLER.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": "1.1"}),
)
PENDULUM = hjsolve.solve("pendulum")
SWAY = PENDULUM.motion(q={"theta": "0.3"}, p={"theta": 0})
FRAME = hjsolve.frames.load("spring-moving-anchor")
MODES = hjsolve.gyroscopic_modes("gyroscopic-pair")
NAMES = [c.name for c in MODES.system.coordinates]


def _scene(**changed):
    table = {
        "system": "harmonic-oscillator", "initial": {"q": {"x": 1}, "velocity": {"x": 0}},
        "times": {"start": 0, "stop": 1, "count": 3}, "want": ["trajectory"],
    }  # fmt: skip
    return hjsolve.Scene.load({**table, **changed}).run()


def _ensemble(**changed):
    return hjsolve.ensemble(KEPLER, **{"q": {"r": 1.0, "theta": 0.0}, "p": {"r": 0.1, "theta": 1.0}, **changed})


DOORS = {
    "line: q": lambda v: LINE.motion(q={"x": v}, velocity={"x": 0}).at(0.5).q,
    "line: velocity": lambda v: LINE.motion(q={"x": 1}, velocity={"x": v}).at(0.5).p,
    "line: parameter": lambda v: LINE.motion(q={"x": 1}, p={"x": 1}, parameters={"k": v}).periods,
    "line: energy": lambda v: LINE.motion(q={"x": 0}, constants={"E": v}, signs={"x": 1}).turning_points,
    "line: t0": lambda v: LINE.motion(q={"x": 1}, p={"x": 1}, t0=v).at(0.5).error.q,
    "line: at": lambda v: LIBRATION.at(v).error.q,
    "kepler: r": lambda v: KEPLER.motion(q={"r": v, "theta": 0}, p={"r": 0, "theta": 1}).kinds,
    "kepler: p": lambda v: KEPLER.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": v}).kinds,
    "kepler: at": lambda v: ORBIT.at(v).velocity,
    "kepler: angles": lambda v: ORBIT.angles(v),
    "kepler: time_at": lambda v: ORBIT.time_at("r", v),
    "kepler: orbit": lambda v: ORBIT.orbit("theta", along="r", values=v),
    "digits": lambda v: LINE.motion(q={"x": 1}, p={"x": 1}, digits=v).periods,
    "linear: at": lambda v: LINEAR.motion(q={"q": 1}, p={"q": 1}).at(v),
    "linear: q": lambda v: LINEAR.motion(q={"q": v}, p={"q": 1}).at(1),
    "level: q": lambda v: QUARTIC.motion(q={"q": v}, p={"q": "0.5"}).periods,
    "level: p": lambda v: QUARTIC.motion(q={"q": "0.5"}, p={"q": v}).actions,
    "level: at": lambda v: ROUND.at(v).error.q,
    "ensemble: q": lambda v: _ensemble(q={"r": v, "theta": 0.0}).columns,
    "ensemble: p": lambda v: _ensemble(p={"r": 0.1, "theta": v}).columns,
    "ensemble: parameters": lambda v: _ensemble(parameters={"k": v}).columns,
    "system: parameter": lambda v: hjsolve.System({"x": "line"}, "dot(x)**2/2", "k*x**2", {"k": v}),
    "system: potential": lambda v: hjsolve.System({"x": "line"}, "dot(x)**2/2", v),
    "system: domain": lambda v: hjsolve.System({"x": v}, "dot(x)**2/2", "x**2"),
    "hamiltonian": lambda v: hjsolve.from_hamiltonian(v, {"q": "line"}),
    "sweep": lambda v: hjsolve.sweep("harmonic-oscillator", v),
    "budget": lambda v: hjsolve.separate("kepler-planar", budget=v),
    "20 digits: q": lambda v: LINE.motion(q={"x": v}, velocity={"x": 1}, digits=20).at(1).p,
    "20 digits: at": lambda v: LINE.motion(q={"x": 1}, velocity={"x": 1}, digits=20).at(v).error.q,
    "certified: velocity": lambda v: LINE.motion(q={"x": 1}, velocity={"x": v}, certified=True).periods,
    "pendulum: angle": lambda v: PENDULUM.motion(q={"theta": v}, p={"theta": "0.1"}).at(0.5).turns,
    "pendulum: time_at": lambda v: SWAY.time_at("theta", v),
    "passage": lambda v: SWAY.time_at("theta", "0.1", v),
    "signs": lambda v: LINE.motion(q={"x": 0}, constants={"E": 1}, signs={"x": v}).kinds,
    "frame: t0": lambda v: FRAME.motion(q={"q": "0.3"}, velocity={"q": "0.4"}, t0=v).at(1),
    "modes: q": lambda v: MODES.motion(q=dict.fromkeys(NAMES, v), velocity=dict.fromkeys(NAMES, 0)).at(1),
    "modes: parameter": lambda v: hjsolve.gyroscopic_modes("gyroscopic-pair", parameters={"k11": v}),
    "scene: q": lambda v: _scene(initial={"q": {"x": v}, "velocity": {"x": 0}}),
    "scene: stop": lambda v: _scene(times={"start": 0, "stop": v, "count": 3}),
    "scene: count": lambda v: _scene(times={"start": 0, "stop": 1, "count": v}),
    "scene: times": lambda v: _scene(times=v),
    "report: path": lambda v: hjsolve.report("harmonic-oscillator", v) if not isinstance(v, str) else None,
}
PAIRS = [(door, name) for name in (*NUMBERS, *ARRAYS) for door in DOORS]
FOUND = """
line: q: huge; line: velocity: huge text; line: parameter: least; kepler: r: least; line: q: huge int;
line: parameter: huge int; line: t0: huge int; kepler: r: huge int; ensemble: q: huge; ensemble: p: huge;
ensemble: q: tiny text; ensemble: parameters: huge int; budget: huge int; linear: at: huge ones; passage: huge int;
scene: stop: huge int; signs: real complex; signs: digits; signs: numpy complex; signs: with inf; signs: structured;
scene: count: digits; pendulum: angle: numpy uint; report: path: nan; report: path: bytes
"""
"""Door and value of what was a warning, another error, or no answer at all."""
CHOSEN = sorted({*PAIRS[::11], *(tuple(pair.strip().rsplit(": ", 1)) for pair in FOUND.split(";"))})


def test_they_are_three_hundred_and_leave_out_no_value_and_no_door():
    assert len(CHOSEN) >= 300
    assert {door for door, _ in CHOSEN} == set(DOORS)
    assert {name for _, name in CHOSEN} == {*NUMBERS, *ARRAYS}


@pytest.mark.rotating(40)
@pytest.mark.nightly_cases("ensemble: p-least ones", "linear: at-huge text")
@pytest.mark.parametrize(("door", "name"), CHOSEN)
def test_a_hostile_call_gives_a_result_or_one_clear_error(door, name):
    value = {**NUMBERS, **ARRAYS}[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            DOORS[door](value)
        except hjsolve.HJSolveError as error:
            assert not isinstance(error, hjsolve.InternalError)
            assert 8 < len(str(error)) < 600, str(error)
