"""Motions and ensembles of quantities: the same numbers as without units, in units; wrong ones refused."""

import math
import random

import astropy.units as u
import numpy as np
import pint
import pytest

import hjsolve

REGISTRY = pint.UnitRegistry()
UNITS = {"r": "kpc", "t": "Myr", "m": "kg"}
KEPLER = hjsolve.System(
    {"r": "0 < r", "theta": "angle"}, "m/2*(dot(r)**2 + r**2*dot(theta)**2)", "-k/r", {"m": 1, "k": "1/2"}, units=UNITS,
    place={"x": "r*cos(theta)", "y": "r*sin(theta)"},
)  # fmt: skip
LIBRARIES = pytest.mark.parametrize("units", [u, REGISTRY], ids=["astropy", "pint"])


@LIBRARIES
def test_a_motion_of_quantities_is_that_of_their_numbers_and_is_told_in_units(units):
    kepler, rng = hjsolve.solve(KEPLER), random.Random(3)
    for _ in range(4):
        r, spin = rng.uniform(0.8, 2), rng.uniform(0.2, 0.4)
        plain = kepler.motion(q={"r": r, "theta": 0}, velocity={"r": 0, "theta": spin})
        motion = kepler.motion(
            q={"r": r * 1000 * units.pc, "theta": 0 * units.rad},
            velocity={"r": 0 * units.km / units.s, "theta": spin * 1000 * units.rad / units.Gyr},
        )  # fmt: skip
        told = motion.to_units(units)
        for name in ("constants", "actions", "frequencies", "periods"):
            for key, number in getattr(plain, name).items():
                assert math.isclose(getattr(told, name)[key].estimate().value, number.value, rel_tol=1e-12)
        period = told.periods["r"].to("Gyr").estimate()
        assert abs(period.value - motion.periods["r"].value / 1000) <= period.error < 1e-14
        energy, turn = told.constants["E"], told.turning_points["r"][0]
        assert energy.to("kg*kpc^2/Myr^2").estimate().value == motion.constants["E"].value
        assert turn.to("pc").estimate().agrees(motion.turning_points["r"][0].value * 1000)
        state, own = told.at(0.002 * units.Gyr), motion.at(2.0)
        assert math.isclose(
            state.velocity["theta"].to("rad/yr").estimate().value, own.velocity["theta"] / 1e6, rel_tol=1e-12
        )
        assert math.isclose(state.place["x"].to("pc").estimate().value, own.place["x"] * 1000, rel_tol=1e-12)
        assert state.p["r"].error is not None
        assert len(repr(told).splitlines()) <= 20


@LIBRARIES
def test_an_ensemble_takes_arrays_of_quantities(units):
    r = np.array([0.8, 1.0, 1.3])
    plain = hjsolve.ensemble(KEPLER, q={"r": r, "theta": 0}, velocity={"r": 0, "theta": 0.4})
    quantity = units.Quantity(r * 1000, units.pc)
    batch = hjsolve.ensemble(
        KEPLER, q={"r": quantity, "theta": 0}, velocity={"r": [0 * units.km / units.s] * 3, "theta": 0.4},
        parameters={"k": 0.5 * units.kg * units.kpc**3 / units.Myr**2},
    )  # fmt: skip
    told = batch.to_units(units)
    for name in ("actions", "frequencies", "periods", "constants", "angles"):
        for key, values in getattr(plain, name).items():
            np.testing.assert_allclose(getattr(told, name)[key].estimate().value, values, rtol=1e-12, atol=0)
    near, far = told.turning_points["r"]
    np.testing.assert_allclose(far.to("pc").estimate().value, plain.turning_points["r"][1] * 1000, rtol=1e-12, atol=0)


@pytest.mark.nightly
def test_columns_of_stars_may_have_units():
    system = hjsolve.System(
        dict.fromkeys("xyz", "line"), "(dot(x)**2 + dot(y)**2 + dot(z)**2)/2", "-GM/sqrt(x**2 + y**2 + z**2)", {"GM": 1},
        units={"x": "kpc", "y": "kpc", "z": "kpc", "t": "Myr"},
    )  # fmt: skip
    ask = {"coordinates": "find", "want": "actions"}
    plain = hjsolve.ensemble(
        system, q={"R": [1.0], "z": [0.1]}, velocity={"vR": [0.1], "vT": [0.9], "vz": [0.05]}, **ask
    )
    speed = [1] * u.kpc / u.Myr
    told = hjsolve.ensemble(
        system, q={"R": [1000] * u.pc, "z": [100] * u.pc}, velocity={"vR": 0.1 * speed, "vT": 0.9 * speed, "vz": 0.05 * speed}, **ask
    )  # fmt: skip
    for name, values in plain.actions.items():
        np.testing.assert_allclose(
            told.to_units(u).actions[name].to(u.kpc**2 / u.Myr).estimate().value, values, rtol=1e-12, atol=0
        )


def test_a_charted_motion_is_told_in_the_units_of_its_chart():
    system = hjsolve.System(
        {"x": "line", "y": "line"}, "m/2*(dot(x)**2 + dot(y)**2)", "k/2*(x**2 + y**2) + c*x*y", {"m": 2, "k": 2, "c": "1/2"},
        units={"x": "m", "y": "m", "t": "s", "m": "kg"},
    )  # fmt: skip
    motion = hjsolve.solve(system, coordinates="find").motion(q={"x": 3 * u.cm, "y": 0}, velocity={"x": 0, "y": 2})
    told = motion.to_units(u)
    assert all(J.to("J*s").estimate() == motion.actions[name] for name, J in told.actions.items())
    assert told.at(1 * u.min).q["x"].to(u.cm).estimate().value == pytest.approx(100 * motion.at(60.0).q["x"], rel=1e-12)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda s: s.motion(q={"r": 1 * u.s, "theta": 0}, p={"r": 0, "theta": 1}), r"q\[r\]: is in s; a quantity in kpc"),
        (lambda s: s.motion(q={"r": 1, "theta": 0}, p={"r": 1 * REGISTRY.m, "theta": 1}), r"p\[r\]: is in meter"),
        (lambda s: s.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": "0.6"}).at(1 * u.Myr), r'to_units\("astropy"\).at'),
        (lambda s: s.motion(q={"r": 1, "theta": 0}, p={"r": 0, "theta": "0.6"}).to_units(u).at(1 * u.kpc), "t: is in kpc"),
        (lambda s: hjsolve.ensemble("liouville-three", q={"q1": [1.0] * u.m, "q2": 0, "q3": 0}, p=dict.fromkeys(("q1", "q2", "q3"), 0)), "declares none"),
        (lambda s: hjsolve.ensemble(s, q={"r": [1.0] * u.s, "theta": 0}, p={"r": 0, "theta": 1}), r"q\[r\]: is in s"),
        (lambda s: hjsolve.ensemble("liouville-three", q=dict.fromkeys(("q1", "q2", "q3"), 0), p=dict.fromkeys(("q1", "q2", "q3"), 1.0)).to_units(u), "declares no units"),
    ],
)  # fmt: skip
def test_a_wrong_dimension_and_a_system_without_units_are_refused(call, says):
    with pytest.raises(hjsolve.InvalidInputError, match=says):
        call(hjsolve.solve(KEPLER))


def test_constants_may_be_quantities():
    kepler = hjsolve.solve(KEPLER)
    plain = kepler.motion(q={"r": 1, "theta": 0}, constants={"E": -0.25, "p_theta": 0.5}, signs={"r": 1})
    energy = -0.25 * u.kg * u.kpc**2 / u.Myr**2
    told = kepler.motion(
        q={"r": 1, "theta": 0},
        constants={"E": energy.to(u.J), "p_theta": 0.5 * u.kg * u.kpc**2 / u.Myr},
        signs={"r": 1},
    )
    assert told.periods["r"].value == pytest.approx(plain.periods["r"].value, rel=1e-12)
