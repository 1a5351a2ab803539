"""Claims that were too small, found by the campaigns with seeds 31, 32 (10 000 motions) and 41.

- What is rounded is an angle before whole turns are taken from it, not the small angle that is left.
- An ignorable angle read from a table is rounded against all it sweeps in an oscillation, 40 turns for a relativistic
  orbit that precesses fast.
- A table samples the phase in doubles; where time runs fast with the phase (near apoapsis of a fall) that is a delay.
- Next to a pole p is a product of two factors that change fast with the phase, though p does not.
- A velocity may cancel inside of its formula (1 − cos θ next to an axis); that is what it is rounded against.
- The integrals of an open motion are rounded against the largest value on their panel.
"""

from __future__ import annotations

import warnings

import pytest
from mpmath import mp, mpf

from tests.support import entries

pytestmark = pytest.mark.rotating_file(2)

TURNS = 2 * mp.pi

CASES = {
    "a libration through pi": (
        "elliptic-trammel", {"theta": 2.8634672661392835}, {"theta": 0.2952816513063167},
        {"m": 1.5452769564132014, "l": 2.0637989254745603}, [5.874396764656581, 5.87, 5.88],
    ),
    "a rotation back at its start": (
        "bead-on-turning-wire", {"theta": -0.06786027906314596}, {"theta": 0.06972513817015392},
        {"m": 1.728601177050165, "w": 1.0155740504505097}, [15.284710340750898, 3.068457836815374],
    ),
    "forty turns of precession": (
        "relativistic-kepler", {"r": 2.130957390058609, "theta": 0.2},
        {"r": -0.2840345687065517, "theta": 0.05418792784383006},
        {"m0": 0.7461615525789498, "k": 0.1928392519198212}, [30.792254504885392, 3829.2293550327013],
    ),
    "apoapsis of a fall": (
        "kepler-planar", {"r": "1.06", "theta": "2.36"}, {"r": "1.36", "theta": "-6.36e-06"}, {},
        [535.054644319604, 2287.6330517678807, 591.3, 604.4],
    ),
    "next to the pole of a sphere": (
        "sphere-geodesics", {"theta": 0.7464878516720145, "phi": 0.3},
        {"theta": 0.21432633780862795, "phi": 5.718785680361126e-08}, {}, [24.336234059077906, 24.3362350, 26.0, 5.02],
    ),
    "a monopole's field next to its axis": (
        "charge-in-monopole-field", {"r": "0.859", "theta": "0.000451", "phi": "-2.54"},
        {"r": "5.22e-05", "theta": "0", "phi": "-0.179"}, {"m": "1.07"}, [0.0, -0.84, 0.853, 2.5255],
    ),
    "fields that nearly balance": (
        "relativistic-crossed-fields", {"x": "0.15", "y": "0.428"}, {"x": "0.419", "y": "-0.0742"},
        {"m0": "1.21", "eB": "0.578", "eF": "0.579"}, [-0.8365275062916704, 0.3, -0.2],
    ),
}  # fmt: skip


@pytest.mark.nightly_cases("next to the pole of a sphere")
@pytest.mark.parametrize("case", CASES)
def test_the_claimed_error_holds_the_true_one(case: str) -> None:
    entry, q, velocity, parameters, times = CASES[case]
    solution = entries.solution(entry)
    given = {"q": q, "velocity": velocity, "parameters": parameters}
    ours, exact = solution.motion(**given).at(times), solution.motion(**given, digits=25).at(times)
    error = ours.error
    with mp.workdps(40):
        for name in q:
            for k in range(len(times)):
                place = mpf(float(ours.q[name][k]))
                missed = [place - exact.q[name][k]]
                if name in ours.turns:
                    missed[0] += TURNS * int(ours.turns[name][k] - exact.turns[name][k])
                missed += [mpf(float(ours.p[name][k])) - exact.p[name][k]]
                missed += [mpf(float(ours.velocity[name][k])) - exact.velocity[name][k]]
                claims = (error.q[name][k], error.p[name][k], error.velocity[name][k])
                for miss, claim in zip(missed, claims, strict=True):
                    assert abs(miss) <= claim, (name, times[k])
                assert claims[0] <= 1e-11 * (1 + abs(place))


@pytest.mark.nightly
def test_a_place_without_kinetic_energy_that_takes_for_ever_in_its_own_time_but_not_in_ours() -> None:
    """At u = v = 0 the factor u² + v² of T is 0: p_u dies away there, and the motion passes it in a finite time.

    The phase ran on to 1e156 (a warning in doubles, a division by zero with more digits), and u was 0 for ever. On the
    axis Y = (u² − v²)/2 obeys Newton's law with a cubic V(Y), and goes from the side of u to that of v.
    """
    solution = entries.solution("henon-heiles-kdv")
    given = {"q": {"u": 0.4584200338927364, "v": 0.0}, "velocity": {"u": -0.7127505417326647, "v": 0.0},
             "parameters": {"A": 0.8964352355468879, "c": 0.6980278928608176}}  # fmt: skip
    motion, exact = solution.motion(**given), solution.motion(**given, digits=25)
    assert motion.kinds == {"u": "asymptotic", "v": "equilibrium"}
    times = [-4.459609329548381, -0.7, 0.0, 0.19, 0.5974920590183384, 2.553835207760711]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ours, theirs = motion.at(times), exact.at(times)
    assert list(ours.status) == list(theirs.status) == ["ok"] * 6
    with mp.workdps(30):
        A, c, s = mpf(0.8964352355468879), mpf(0.6980278928608176), mpf(1) / 10

        def force(Y: mpf) -> mpf:
            return -4 * (A + 2 * c * s) * Y - 6 * c * Y**2 - 2 * (2 * A * s + c * s**2)

        u, rate = mpf(given["q"]["u"]), mpf(given["velocity"]["u"])
        after, before = (
            mp.odefun(lambda t, y: [y[1], force(y[0])], 0, [u**2 / 2, direction * u * rate]) for direction in (1, -1)
        )
        for k, t in enumerate(times):
            Y = after(t)[0] if t >= 0 else before(-t)[0]
            name = "u" if Y > 0 else "v"
            truth = mp.sqrt(2 * abs(Y))
            assert abs(abs(mpf(float(ours.q[name][k]))) - truth) <= ours.error.q[name][k] <= 1e-15
            assert abs(abs(theirs.q[name][k]) - truth) <= theirs.error.q[name][k] <= 1e-24
            assert ours.q["v" if Y > 0 else "u"][k] == 0


def test_the_frequency_of_an_angle_that_rests_while_the_radius_rests_is_zero() -> None:
    """A charge that moves along the field: its angle's rate is a difference of equal terms; it was 3.6e-44 ± 8e-60."""
    given = {"q": {"r": "0.677", "theta": "-0.944", "z": "0.0317"}, "velocity": {"r": 0, "theta": 0, "z": "-0.464"},
             "parameters": {"m": "0.681", "q": "0.938", "B": "1.43"}}  # fmt: skip
    motion = entries.solution("charge-in-uniform-field").motion(**given)
    assert motion.kinds["r"] == "equilibrium"
    assert motion.frequencies["theta"].value == 0
    assert 0 < motion.frequencies["theta"].error <= 1e-25
    assert "theta" not in motion.periods
