"""What people type in their first ten minutes, and what they are told to write instead."""

from __future__ import annotations

import numpy as np
import pytest

import hjsolve

LINE, T = {"x": "line"}, "m/2*dot(x)**2"


def kepler(**changes):
    start = {"q": {"r": 1, "theta": 0}, "velocity": {"r": 0, "theta": "1.2"}} | changes
    return hjsolve.solve("kepler-planar").motion(**start)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: hjsolve.System(LINE, T=T, V="0"), r'System: no argument "T"; known are coordinates, kinetic, potential'),
        (lambda: hjsolve.System(LINE), r"System: missing a required argument: 'kinetic'; write System\("),
        (lambda: hjsolve.solve("kepler-planar", coordinate="find"), r'solve: no argument "coordinate"; known are system'),
        (lambda: hjsolve.ensemble("isochrone", q={}, velocities={}), r'ensemble: no argument "velocities"; known are'),
        (lambda: hjsolve.System(LINE, T, "k*x^2/2", {"m": 1}), r'declared are m, x; declare a parameter, \{"k": 1\} or'),
        (lambda: hjsolve.System(LINE, "p^2/(2*m)", "0", {"m": 1}), r"write T with dot\(x\), or give H\(q, p\) to from_ham"),
        (lambda: hjsolve.System(LINE, "p_x^2/(2*m)", "0", {"m": 1}), r"write T with dot\(x\), or give H\(q, p\) to"),
        (lambda: kepler(q={"r": 1, "theta": "30 deg"}), r"without a unit; write 30\*pi/180 for 30 degrees"),
        (lambda: kepler(parameters={"k": "1 km^3/s^2"}), r"without a unit; convert it to the units of the system"),
        (lambda: kepler().at("2026-01-31"), r"a date is not a number; write the time since t0"),
        (lambda: kepler().at("2026-01-31T12:00"), r"a date is not a number; write the time since t0"),
        (lambda: hjsolve.catalog.load("kepler-planar").rhs()(np.ones(4), 0.0), r"y: a state \[r, theta, p_r, p_theta\]"),
        (lambda: hjsolve.catalog.load("kepler-planar").rhs()(0.0, np.ones(3)), r"y: 4 rows are needed, .* not 3"),
        (lambda: hjsolve.catalog.load("kepler-planar").hamiltonian_function()("abc"), r"y: a state .*, not 'abc'"),
        (lambda: hjsolve.ensemble("isochrone", q={"r": ["8 kpc"], "theta": 0}, p={"r": 0, "theta": 1}), r"must hold real numbers, not text"),
    ],
)
def test_a_first_attempt_is_told_what_to_write(call, message):
    with pytest.raises(hjsolve.InvalidInputError, match=message):
        call()


def test_a_difference_that_is_not_a_date_is_a_number():
    assert kepler().at("2026-13").t == "2026-13"
    assert kepler().at("2026 - 01").q["r"] == kepler().at(2025).q["r"]
