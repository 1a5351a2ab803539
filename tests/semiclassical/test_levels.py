"""Semiclassical levels: against closed forms where they are exact, exact spectra elsewhere, and plain motions."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from mpmath import mp

import hjsolve
from tests.support import entries

BOX = hjsolve.System({"x": "0 < x < 1"}, "dot(x)**2/2", "0")
BOUNCER = hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "x")
HALF_OSCILLATOR = hjsolve.System({"x": "0 < x"}, "dot(x)**2/2", "x**2/2")
CALLS = {"morse": {"hbar": "0.1", "up_to": "0.99"}, "pendulum": {"up_to": 20}}


def energies(found):
    return [level.energy.value for level in found]


def agree(found, expected):
    """Whether energies are those expected within their own errors."""
    assert len(found) == len(expected)
    for level, E in zip(found, expected, strict=True):
        assert abs(level.energy.value - E) <= level.energy.error + 2e-16 * abs(E), (dict(level.numbers), E)


def test_oscillator_has_its_exact_levels():
    agree(hjsolve.levels("harmonic-oscillator", up_to=5), [0.5, 1.5, 2.5, 3.5, 4.5])


def test_morse_is_exact():
    """E = ħω (n + ½) − (ħω (n + ½))²/4D with ω = a √(2D/m) (Morse 1929)."""
    found = hjsolve.levels("morse", **CALLS["morse"])
    quantum = [0.1 * np.sqrt(2) * (n + 0.5) for n in range(len(found))]
    agree(found, [w - w**2 / 4 for w in quantum])
    assert len(found) == 13


@pytest.mark.nightly
def test_hydrogen_has_bohrs_energies_and_degeneracies():
    found = hjsolve.levels("kepler-spherical", up_to="-0.1")
    agree(found, [-1 / 2] + 4 * [-1 / 8])
    assert sorted(tuple(level.numbers.values()) for level in found) == [
        (0, 0, -1), (0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0),
    ]  # fmt: skip
    assert not any(level.near_separatrix for level in found)


@pytest.mark.nightly
def test_plane_oscillator_counts_both_senses_and_the_lines_through_the_centre():
    found = hjsolve.levels("isotropic-oscillator-polar", up_to=4)
    agree(found, [float(n) for n in (1, 2, 2, 3, 3, 3, 4, 4, 4, 4)])


def test_sphere_has_the_square_of_l_plus_a_half():
    found = hjsolve.levels("sphere-geodesics", up_to=4)
    agree(found, [(l + 0.5) ** 2 / 2 for l in range(3) for _ in range(2 * l + 1)])


@pytest.mark.parametrize(
    ("system", "up_to", "expected", "maslov"),
    [
        (BOX, 100, [np.pi**2 * n**2 / 2 for n in (1, 2, 3, 4)], 4),
        (BOUNCER, 5, [(3 * np.pi * (n + 0.75) / np.sqrt(8)) ** (2 / 3) for n in range(3)], 3),
        (HALF_OSCILLATOR, 6, [1.5, 3.5, 5.5], 3),
    ],
)
def test_hard_walls_add_two(system, up_to, expected, maslov):
    found = hjsolve.levels(system, up_to=up_to)
    np.testing.assert_allclose(energies(found), expected, rtol=1e-15, atol=0)
    assert {level.maslov["x"] for level in found} == {maslov}


@pytest.mark.nightly
def test_pendulum_rotations_come_twice_and_the_separatrix_is_marked():
    found = hjsolve.levels("pendulum", **CALLS["pendulum"])
    librations = [level for level in found if level.kinds["theta"] == "libration"]
    turns = [level for level in found if level.kinds["theta"] == "rotation"]
    assert [level.numbers["theta"] for level in librations] == list(range(8))
    assert [level.numbers["theta"] for level in turns] == [-4, 4, -5, 5, -6, 6]
    assert all(level.energy.value > 9.81 for level in turns)
    marked = [(level.kinds["theta"], level.numbers["theta"]) for level in found if level.near_separatrix]
    assert marked == [("libration", 7), ("rotation", -4), ("rotation", 4)]
    for level in found:  # the same actions by a plain motion with these constants
        with mp.workdps(30):
            E = mp.mpf(level.energy.value)
            m = (1 + E / mp.mpf("9.81")) / 2
            root = mp.sqrt(mp.mpf("9.81"))
            K = mp.ellipe(m) - (1 - m) * mp.ellipk(m) if m < 1 else mp.sqrt(m) * mp.ellipe(1 / m)
            J = 8 * root / mp.pi * K * (1 if m < 1 else mp.mpf(1) / 2)
            assert abs(abs(level.actions["theta"].value) - J) < 1e-14 * J


@pytest.mark.nightly
def test_wells_of_a_double_well_have_a_level_each():
    found = hjsolve.levels("double-well", hbar="0.05", up_to="0.02")
    below = [level for level in found if level.energy.value < 0]
    assert [level.numbers["x"] for level in below] == [0, 0, 1, 1, 2, 2, 3, 3]
    assert {np.sign(level.wells["x"][0] + level.wells["x"][1]) for level in below} == {-1.0, 1.0}
    assert [level.numbers["x"] for level in found if level.near_separatrix] == [3, 3, 8]


def test_actions_are_those_of_the_motion_with_the_same_constants():
    """Stark: a torus found from J = (½, ½, 1) is one on which J is measured to be that."""
    solution = entries.solved("stark")
    (level,) = hjsolve.levels(solution, numbers={"u": 0, "v": 1, "phi": 1}, parameters={"F": "0.0005"})
    again = solution.motion(actions={"u": "0.5", "v": "1.5", "phi": 1}, parameters={"F": "0.0005"})
    assert again.constants["E"].agrees(level.energy)
    q, p = again.at(0).q, again.at(0).p
    plain = solution.motion(q=dict(q), p=dict(p), parameters={"F": "0.0005"})
    for name, J in level.actions.items():
        assert plain.actions[name].value == pytest.approx(J.value, rel=1e-13)
    assert dict(level.maslov) == {"u": 2, "v": 2, "phi": 0}


def spectrum(m, g, size=40):
    """Exact levels of −½Δ − g cos θ on the sphere with ħ = 1, for one m: a matrix over spherical harmonics."""
    l = np.arange(abs(m), abs(m) + size)
    coupling = np.sqrt((l[1:] ** 2 - m**2) / (4 * l[1:] ** 2 - 1.0))
    return np.linalg.eigvalsh(np.diag(l * (l + 1) / 2) - g * (np.diag(coupling, 1) + np.diag(coupling, -1)))


@pytest.mark.nightly
def test_spherical_pendulum_is_near_the_exact_levels():
    """With ħ = ½ and g = 9.81: E/ħ² are the levels of g/ħ² = 39.24; EBK is good to about ħ²/8."""
    found = hjsolve.levels("spherical-pendulum", hbar="0.5", up_to="-5")
    assert len(found) > 4
    for level in found:
        exact = 0.25 * spectrum(level.numbers["phi"], 9.81 / 0.25)[level.numbers["theta"]]
        assert abs(level.energy.value - exact) < 0.05
    worst = max(abs(lv.energy.value - 0.25 * spectrum(lv.numbers["phi"], 39.24)[lv.numbers["theta"]]) for lv in found)
    assert worst > 1e-4  # the method is semiclassical, not exact here


def test_what_falls_into_a_centre_is_told():
    found = hjsolve.levels("kepler-planar", up_to="-0.1")
    assert [level.numbers["theta"] for level in found] == [-1, 1]
    assert "r falls into an end" in found.skipped[0]


def test_numbers_choose():
    found = hjsolve.levels("kepler-spherical", numbers={"r": range(2), "theta": 1, "phi": -2})
    np.testing.assert_allclose(energies(found), [-1 / 32, -1 / 50], rtol=1e-15, atol=0)


def test_thirty_digits():
    """J of a rotating pendulum is (4/π) √(g m) E(1/m), m = (1 + E/g)/2."""
    found = hjsolve.levels("pendulum", up_to=15, numbers={"theta": (5, -5)}, digits=30)
    assert [level.numbers["theta"] for level in found] == [5, -5, 5]
    level = found[1]
    with mp.workdps(50):
        m = (1 + level.energy.value / mp.mpf("9.81")) / 2
        assert abs(4 * mp.sqrt(mp.mpf("9.81") * m) * mp.ellipe(1 / m) / mp.pi - 5) < 1e-28


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"up_to": 1, "hbar": 0}, "hbar: a positive number"),
        ({}, "no up_to and no numbers of theta"),
        ({"numbers": {"r": 1}}, "'r' is not a coordinate"),
        ({"numbers": {"theta": "1"}}, r"numbers\[theta\]"),
    ],
)
def test_bad_input_names_what_is_wrong(arguments, words):
    with pytest.raises(hjsolve.InvalidInputError, match=words):
        hjsolve.levels("pendulum", **arguments)


def test_a_line_has_no_tori():
    with pytest.raises(hjsolve.InvalidInputError, match="does not come back"):
        hjsolve.levels("projectile", up_to=1)


def test_table_and_ladder():
    found = hjsolve.levels("pendulum", up_to=12, numbers={"theta": (6, 7, 4, -4)})
    lines = found.table().split("\n")
    assert len(lines) == 1 + len(found) == 6
    assert lines[3].endswith("near a separatrix (theta)")
    mpl.use("Agg")
    axes = found.plot()
    assert len(axes.lines) == 5
    assert sum(line.get_linestyle() == "--" for line in axes.lines) == 3


def in_many_digits(found, exact):
    """Whether energies are those of a closed form of n within their errors, atol = 0."""
    with mp.workdps(40):
        for n, level in enumerate(found):
            assert abs(level.energy.value - exact(n)) <= level.energy.error, n


HBAR = "1.054571817e-34"
ATOM = {"k": 500, "m": "1.6e-27"}


@pytest.mark.nightly
def test_oscillators_in_si_units_have_all_their_levels():
    """No level was found of an atom in metres: all places that were looked at lay above the greatest energy."""
    system = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "k*x**2/2", ATOM)
    found = hjsolve.levels(system, HBAR, up_to="2e-19")
    with mp.workdps(40):
        quantum = mp.mpf(HBAR) * mp.sqrt(500 / mp.mpf("1.6e-27"))
    assert len(found) == 3
    in_many_digits(found, lambda n: quantum * (n + mp.mpf(1) / 2))


@pytest.mark.nightly
def test_quartic_levels_in_si_units_are_those_of_the_closed_form():
    """J = (2/π) √(2m) E^¾ (1/k)^¼ B(¼, ³⁄₂)/4 of V = k x⁴."""
    system = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "k*x**4", {"k": "2.5e22", "m": "1.6e-27"})
    found = hjsolve.levels(system, HBAR, up_to="1e-19")
    with mp.workdps(40):
        unit = 2 / mp.pi * mp.sqrt(2 * mp.mpf("1.6e-27")) / mp.root(mp.mpf("2.5e22"), 4)
        unit *= mp.beta(mp.mpf(1) / 4, mp.mpf(3) / 2) / 4
    assert len(found) == 4
    in_many_digits(found, lambda n: mp.power((n + mp.mpf(1) / 2) * mp.mpf(HBAR) / unit, mp.mpf(4) / 3))


def test_morse_levels_in_si_units():
    values = {"D": "7.4e-19", "a": "1.9e10", "m": "1.6e-27"}
    system = hjsolve.System({"x": "line"}, "m*dot(x)**2/2", "D*(1 - exp(-a*x))**2", values)
    found = hjsolve.levels(system, HBAR, up_to="2e-19")
    with mp.workdps(40):
        D, a, m = (mp.mpf(values[name]) for name in values)
        w = mp.mpf(HBAR) * a * mp.sqrt(2 * D / m)
    assert len(found) == 4
    in_many_digits(found, lambda n: w * (n + mp.mpf(1) / 2) - (w * (n + mp.mpf(1) / 2)) ** 2 / (4 * D))


@pytest.mark.parametrize(("stiffness", "up_to", "count"), [("500", "20", 1), ("500", "200", 6), ("5e5", "2e4", 20)])
def test_a_narrow_well_far_from_zero_has_all_its_levels(stiffness, up_to, count):
    """No place that was looked at lay below the greatest energy, and no level was found."""
    found = hjsolve.levels(hjsolve.System({"x": "line"}, "dot(x)**2/2", f"{stiffness}*(x - 10)**2"), up_to=up_to)
    assert len(found) == count
    in_many_digits(found, lambda n: mp.sqrt(2 * mp.mpf(stiffness)) * (n + mp.mpf(1) / 2))


@pytest.mark.nightly
def test_a_steep_well_does_not_end_the_count_of_those_that_join_above_a_barrier():
    """With ħ = ¼ the steep well has E₁ > 3, and two shallow ones join at n = 2: their levels from there on were lost."""
    V = "50*(x + 4)**2*(x**2 - 1)**2/(100*(x + 4)**2 + (x**2 - 1)**2/2)"
    found = hjsolve.levels(hjsolve.System({"x": "line"}, "dot(x)**2/2", V), "0.25", up_to=3)
    assert [level.numbers["x"] for level in found] == [0, 0, 2, 3, 4, 5, 6, 0, 7, 8, 9]
    anomaly = (np.arange(4000) + 0.5) * np.pi / 4000
    for level in found:
        low, high = level.wells["x"]
        x = (low + high) / 2 - (high - low) / 2 * np.cos(anomaly)
        p = np.sqrt(np.maximum(2 * (level.energy.value - eval(V, {"x": x})), 0))
        J = np.mean(p * np.sin(anomaly)) * (high - low) / 2
        np.testing.assert_allclose(J, (level.numbers["x"] + 0.5) / 4, rtol=1e-10, atol=0)


def test_a_flux_through_a_ring_moves_the_numbers_of_low_energy():
    """E = (m − 5.3)²/2: m = 0 lies far above, and no level was found."""
    found = hjsolve.levels(hjsolve.System({"phi": "angle"}, "dot(phi)**2/2 + 53/10*dot(phi)", "0"), up_to=1)
    assert [level.numbers["phi"] for level in found] == [5, 6, 4]
    np.testing.assert_allclose(energies(found), [0.045, 0.245, 0.845], rtol=1e-15, atol=0)


def test_a_flux_besides_an_oscillator():
    ring = hjsolve.System({"x": "line", "phi": "angle"}, "(dot(x)**2 + dot(phi)**2)/2 + 3*dot(phi)", "x**2/2")
    found = hjsolve.levels(ring, up_to="1.01")
    assert [(level.numbers["phi"], level.energy.value) for level in found] == [(3, 0.5), (2, 1.0), (4, 1.0)]


def test_angles_that_T_couples_have_their_levels_along_a_line():
    """E = n + ½ + k²/1.99 for m = (k, k); m = (1, 0) has E = 25 and is no way from (0, 0) to (1, 1)."""
    T = "dot(x)**2/2 + (dot(a)**2 + dot(b)**2)/2 + 99/100*dot(a)*dot(b)"
    found = hjsolve.levels(hjsolve.System({"x": "line", "a": "angle", "b": "angle"}, T, "x**2/2"), up_to=3)
    exact = sorted(n + 0.5 + k * k / 1.99 for n in range(3) for k in range(-3, 4) if n + 0.5 + k * k / 1.99 <= 3)
    assert all(level.numbers["a"] == level.numbers["b"] for level in found)
    np.testing.assert_allclose(energies(found), exact, rtol=1e-15, atol=0)
