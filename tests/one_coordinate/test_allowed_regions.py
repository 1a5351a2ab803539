"""Other wells of one potential, the nearest regions of an impossible motion, and starts from the constants of the motion."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from mpmath import mp, mpf

import hjsolve
from hjsolve.errors import ForbiddenMotionError, InvalidInputError, MissingValueError


@cache
def line(potential: str, domain: str = "line") -> Any:
    return hjsolve.solve(hjsolve.System({"x": domain}, "dot(x)**2/2", potential))


def matches(found: Any, true: list[tuple[Any, Any]]) -> bool:
    """Every end is right to within what is claimed for it; None where there is no turning point."""
    pairs = [(e, t) for region, ends in zip(found, true, strict=True) for e, t in zip(region, ends, strict=True)]
    return all(t is None if e is None else abs(mpf(e.value) - t) <= mpf(e.error) + mpf(10) ** -30 for e, t in pairs)


def test_the_other_well_is_listed() -> None:
    motion = line("x**4/4 - x**2/2").motion(q={"x": "1.2"}, velocity={"x": 0})

    with mp.workdps(40):
        inner = mp.sqrt(2 - mpf("1.2") ** 2)
        assert matches(motion.other_regions["x"], [(-mpf("1.2"), -inner)])
        assert matches([motion.turning_points["x"]], [(inner, mpf("1.2"))])


def test_over_the_barrier_there_is_one_region() -> None:
    assert line("x**4/4 - x**2/2").motion(q={"x": "1.5"}, velocity={"x": 0}).other_regions == {"x": ()}


def test_at_the_barrier_the_regions_touch() -> None:
    motion = line("x**4/4 - x**2/2").motion(q={"x": "sqrt(2)"}, velocity={"x": 0})

    with mp.workdps(40):
        ((low, high),) = motion.other_regions["x"]
        assert matches([(low,)], [(-mp.sqrt(2),)])
        assert abs(mpf(high.value)) <= high.error < 1e-20, "a place at zero has an absolute error"


@pytest.mark.parametrize(("potential", "x", "v", "true"), [
    ("x**2*(x - 3)**2", 0, 0, [(3, 3)]),
    ("(x - 1)**2*(x - 4)**2*(x + 2)**2", 1, 0, [(-2, -2), (4, 4)]),
    ("-x**2/2", 2, 0, [(None, -2)]),
    ("x**3", 0, 1, []),
])  # fmt: skip
def test_isolated_places_of_rest_and_open_ends(potential: str, x: int, v: int, true: list[Any]) -> None:
    motion = line(potential).motion(q={"x": x}, velocity={"x": v})

    assert matches(motion.other_regions["x"], true)


@pytest.mark.nightly
def test_wells_on_a_circle_are_counted_once() -> None:
    """cos 2x has two wells a turn; the second is a half turn on."""
    motion = line("cos(2*x)", "angle").motion(q={"x": "pi/2"}, velocity={"x": "1/2"})

    with mp.workdps(40):
        half = mp.acos(1 - mpf(1) / 8) / 2  # cos 2x = −1 + 1/8
        assert matches(motion.other_regions["x"], [(3 * mp.pi / 2 - half, 3 * mp.pi / 2 + half)])


def test_a_turning_point_at_zero_claims_an_absolute_error() -> None:
    motion = line("(x - sqrt(2))**2 + (x - sqrt(2))**4").motion(q={"x": "2*sqrt(2)"}, velocity={"x": 0}, digits=30)

    low, _ = motion.turning_points["x"]
    assert abs(low.value) <= low.error < 1e-29


@pytest.mark.parametrize(("x", "E", "regions"), [
    ("0.1", "-1/8", [(0.541196100146197, 1.3065629648763766), (-1.3065629648763766, -0.541196100146197)]),
    ("3", "-1/8", [(0.541196100146197, 1.3065629648763766)]),
    ("3", "-1/4", [(1.0, 1.0)]),
    ("0", "-1", []),
])  # fmt: skip
def test_an_impossible_motion_names_the_nearest_regions(x: str, E: str, regions: list[tuple[float, float]]) -> None:
    """x² = 1 ± √(1 + 4E) at the ends."""
    with pytest.raises(ForbiddenMotionError) as caught:
        line("x**4/4 - x**2/2").motion(q={"x": x}, constants={"E": E}, signs={"x": 1})

    assert caught.value.name == "x"
    assert len(caught.value.regions) == len(regions)
    for found, true in zip(caught.value.regions, regions, strict=True):
        assert found == pytest.approx(true, rel=1e-15, abs=0)
        assert all(f"{end:.12g}" in str(caught.value) for end in true)


def test_a_motion_started_from_its_constants_is_the_same_motion() -> None:
    kepler = hjsolve.solve(hjsolve.catalog.load("kepler-spherical"))
    q = {"r": "1", "theta": "pi/3", "phi": "0"}
    given = kepler.motion(q=q, velocity={"r": "-0.2", "theta": "0.3", "phi": "-1.1"})
    constants = {name: str(value) for name, value in given.initial.constants.items()}
    again = kepler.motion(q=q, constants=constants, signs={"r": -1, "theta": 1})

    for t in ("0", "7", "-1000"):
        for name in q:
            assert again.at(t).q[name] == given.at(t).q[name]
            assert again.at(t).p[name] == given.at(t).p[name]


def test_no_sign_is_needed_at_a_turning_point() -> None:
    well = line("x**4/4 - x**2/2")

    assert well.motion(q={"x": "sqrt(2)"}, constants={"E": 0}).kinds == {"x": "asymptotic"}


@pytest.mark.parametrize(("arguments", "error", "words"), [
    ({"constants": {}}, MissingValueError, "no value for E"),
    ({"constants": {"E": 1}}, MissingValueError, "signs={'x': 1}"),
    ({"constants": {"E": 1, "L": 2}, "signs": {"x": 1}}, InvalidInputError, "'L' is not known"),
    ({"constants": {"E": 1}, "signs": {"y": 1}}, InvalidInputError, "'y' is not known"),
    ({"constants": {"E": 1}, "signs": {"x": 2}}, InvalidInputError, "1 or -1"),
    ({"constants": {"E": 1}, "velocity": {"x": 1}}, InvalidInputError, "either"),
    ({"p": {"x": 1}, "signs": {"x": 1}}, InvalidInputError, "signs already"),
    ({}, InvalidInputError, "constants={"),
])  # fmt: skip
def test_an_incomplete_start_is_told_what_is_missing(arguments: Any, error: type, words: str) -> None:
    with pytest.raises(error, match=words.replace("{", r"\{").replace("}", r"\}")):
        line("x**4/4 - x**2/2").motion(q={"x": 0}, **arguments)


def test_all_wells_in_a_row_are_had_to_thirty_digits():
    """Each end was sought from the one before it, which was asked for twice the bits: 8 ends away, beyond all bounds."""
    system = hjsolve.System({"x": "line"}, "dot(x)**2/2", "-cos(x)")
    motion = hjsolve.solve(system).motion(q={"x": 0}, velocity={"x": "1"}, digits=30, want=["turning_points"])
    low, wells = motion.turning_points["x"][0].value, motion.other_regions["x"]
    assert len(wells) == 8
    turns = [(well[0].value - low) / (2 * low.context.pi) for well in wells]
    assert all(abs(turn - round(float(turn))) < 1e-27 for turn in turns)


def test_a_pendulum_released_at_rest_has_no_other_wells():
    """Its p² is zero at the start, and again a turn later: rounding of zero made it look as if it had no period."""
    pendulum = hjsolve.solve(hjsolve.catalog.load("pendulum"))
    for place in ("pi/2", "1"):
        motion = pendulum.motion(q={"theta": place}, velocity={"theta": 0}, want=["turning_points"])
        assert motion.other_regions["theta"] == ()
