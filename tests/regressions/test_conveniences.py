"""Small things people looked for: a verdict in a sentence, y = [q, p], H and its flow as functions, a table of astropy."""

from __future__ import annotations

import pickle
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import hjsolve
from hjsolve.errors import InvalidInputError, InvalidSystemError, MissingValueError

KEPLER = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}}


def test_a_verdict_is_one_sentence():
    def told(coordinates, kinetic, potential, **more):
        return str(hjsolve.separate(hjsolve.System(coordinates, kinetic, potential, **more)))

    plane = {"x": "line", "y": "line"}
    assert str(hjsolve.separate("kepler-planar")) == (
        "Separates in r and theta: it is of Liouville form, and theta is ignorable."
    )
    assert told(plane, "x'^2/2 + y'^2/2", "c*x^2*y^2", parameters={"c": None}) == (
        "Does not separate in x and y: the potential couples x and y, since 4*c*x*y is not zero everywhere."
    )
    assert "ignorable" in str(hjsolve.separate("lagrange-top"))
    for entry in hjsolve.catalog.ids("refused")[:12]:
        sentence = str(hjsolve.separate(entry))
        assert "\n" not in sentence
        assert sentence.startswith("Does not separate in ")
        assert sentence.endswith(".")


def test_a_state_is_an_array_of_coordinates_and_momenta():
    motion = hjsolve.solve("kepler-planar").motion(**KEPLER)
    state, one = motion.at(np.linspace(0, 30, 7)), motion.at(2)
    array = state.as_array()
    assert array.shape == (7, 4)
    assert array.dtype == float
    for column, values in enumerate((state.q["r"], state.q["theta"], state.p["r"], state.p["theta"])):
        assert np.array_equal(array[:, column], values)
    assert one.as_array().shape == (4,)
    turning = state.as_array(unwrapped=True)
    assert np.array_equal(turning[:, 1], state.unwrapped("theta"))
    assert turning[-1, 1] > np.pi
    many = hjsolve.solve("kepler-planar").motion(**KEPLER, digits=30).at(["1", "2"]).as_array()
    assert many.shape == (2, 4)
    assert isinstance(many[0, 0], type(motion.at("1").q["r"])) or hasattr(many[0, 0], "_mpf_")
    assert pickle.loads(pickle.dumps(state)).as_array().shape == (7, 4)


@pytest.mark.parametrize("entry", ["kepler-spherical", "lagrange-top", "relativistic-kepler"])
def test_the_flow_is_the_rate_of_change_of_the_motion(entry):
    """Central differences of the quadratures at 40 digits, of step 1e-13, against Hamilton's equations."""
    described = hjsolve.catalog.describe(entry)
    solution = hjsolve.solve(entry)
    motion = solution.motion(**described.initial.arguments, digits=40)
    values = dict(described.initial.parameters)
    rate = described.system.rhs(values, module="mpmath")
    middle, step = Fraction(37, 100), Fraction(1, 10**13)
    states = motion.at([middle - step, middle, middle + step]).as_array(unwrapped=True)
    with mpmath.workdps(40):
        difference = [(b - a) * 10**13 / 2 for a, b in zip(states[0], states[2])]
        got = rate(0, list(states[1]))
        size = max(abs(x) for x in difference)
        assert all(abs(a - b) <= 1e-20 * size for a, b in zip(got, difference))
    energy = described.system.hamiltonian_function(values)
    first, last = (energy(np.array([float(x) for x in row])) for row in (states[0], states[2]))
    assert abs(first - last) <= 1e-12 * abs(first) + 1e-14


def test_the_functions_of_a_system_take_many_states_at_once_and_lists():
    system = hjsolve.System({"x": "line", "z": "line"}, "m/2*(x'^2 + z'^2)", "m*g*z", {"m": 2, "g": None})
    rate, energy = system.rhs({"g": 3}), system.hamiltonian_function({"g": 3})
    y = np.array([[0.0, 1.0], [1.0, 2.0], [2.0, 4.0], [6.0, 8.0]])
    assert rate(0.0, y).tolist() == [[1.0, 2.0], [3.0, 4.0], [0.0, 0.0], [-6.0, -6.0]]
    assert rate(0.0, [0, 1, 2, 6]) == [1.0, 3.0, 0, -6]
    assert energy(y).tolist() == [6 + 1 + 9, 12 + 4 + 16]
    assert np.shape(energy(y[:, 0])) == ()
    with pytest.raises(MissingValueError, match="no value for g"):
        system.rhs()
    with pytest.raises(InvalidSystemError, match="not a parameter"):
        system.rhs({"h": 1})
    with pytest.raises(InvalidInputError, match='"numpy" or "mpmath"'):
        system.rhs({"g": 3}, module="math")
    unknown = hjsolve.System({"x": "line"}, "x'^2/2", "v(x)", functions=["v(x)"])
    with pytest.raises(InvalidInputError, match="left undetermined"):
        unknown.hamiltonian_function()


def test_an_integrator_takes_the_flow_as_it_is():
    integrate = pytest.importorskip("scipy.integrate")
    motion = hjsolve.solve("kepler-planar").motion(**KEPLER)
    start, end = motion.at(0).as_array(), motion.at(5).as_array(unwrapped=True)
    found = integrate.solve_ivp(motion.solution.system.rhs(), (0, 5), start, method="DOP853", rtol=1e-12, atol=1e-12)
    assert np.allclose(found.y[:, -1], end, rtol=1e-9, atol=0)


def test_a_batch_is_a_table_of_astropy_with_the_units_of_the_system():
    pytest.importorskip("astropy.table")
    kinetic, potential = "r'^2/2 + r^2*theta'^2/2", "-k/r"
    units = {"r": "kpc", "t": "Myr"}
    galaxy = hjsolve.System({"r": "0 < r", "theta": "angle"}, kinetic, potential, {"k": 1}, units=units)
    r, speed = np.array([[1.0, 2.0], [1.5, 0.7]]), np.array([[1.0, 0.4], [9.0, 1.1]])
    start = {"q": {"r": r, "theta": 0 * r}, "velocity": {"r": 0 * r, "theta": speed}}
    want = {"actions", "periods", "turning_points", "angles"}
    batch = hjsolve.ensemble(galaxy, **start, want=want)
    table = batch.to_table()
    assert type(table).__name__ == "QTable"
    assert len(table) == 4
    assert table.meta["shape"] == [2, 2]
    assert list(zip(table["axis_0"], table["axis_1"])) == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert str(table["periods.r"].unit) == "Myr"
    assert str(table["error.turning_points.r.upper"].unit) == "kpc"
    assert table["actions.r"].unit.is_equivalent("kpc2 / Myr")
    assert np.array_equal(table["periods.r"].value, batch.periods["r"].reshape(-1), equal_nan=True)
    assert list(table["status"]) == list(batch.status.reshape(-1))
    bare = hjsolve.System({"r": "0 < r", "theta": "angle"}, kinetic, potential, {"k": 1})
    plain = hjsolve.ensemble(bare, **start, want=want)
    assert getattr(plain.to_table()["periods.r"], "unit", None) is None


def test_a_file_of_ones_own_has_any_id(tmp_path):
    path = tmp_path / "halo.toml"
    path.write_text(
        'id = "my-halo"\ntitle = "A halo"\ncoordinates = [{name = "r", domain = "0 < r"}, {name = "theta", domain = "angle"}]\n'
        'kinetic = "(r\'^2 + r^2*theta\'^2)/2"\npotential = "-1/r"\n'
        '[initial]\nq = {r = "1", theta = "0"}\nvelocity = {r = "0", theta = "1"}\n',
        encoding="utf-8",
    )
    assert hjsolve.catalog.describe(path).id == hjsolve.catalog.load(path).id == "my-halo"
    assert hjsolve.Scene.load({"system": str(path), "want": ["periods"]}).run().quantity("periods")["theta"]
    assert hjsolve.report(path, tmp_path / "halo.txt", brief=True).exists()
