"""The published numbers of the extended entries: made again, and reached by hjsolve."""

import functools
from typing import Any

import pytest
from mpmath import mp

from hjsolve import catalog
from hjsolve.catalog import Reference
from hjsolve.extended.gyroscopic import gyroscopic_modes
from hjsolve.solution.quadratures import solve
from tests.reference import extended
from tests.support.entries import described as entry

IDS = catalog.ids("extended")
MOTIONS = [(name, motion) for name in IDS for motion in entry(name).motions]


@functools.cache
def motion_of(name: str, motion: str) -> Any:
    """Whatever solves this kind of entry: a motion, the normal modes, or H(q, p)."""
    given, system = entry(name).motions[motion].arguments, entry(name).system
    problem = entry(name).hamiltonian
    if problem is not None:
        return problem.motion(**given)
    assert system is not None
    if entry(name).expect["verdict"] == "refused":
        return gyroscopic_modes(system, digits=20).motion(q=given["q"], velocity=given["velocity"])
    return solve(system).motion(**given)


@functools.cache
def state_of(name: str, motion: str, t: str) -> Any:
    return motion_of(name, motion).at(t)


def measured(name: str, reference: Reference) -> tuple[Any, Any]:
    """hjsolve's value and its error; the normal modes state none, and get 20 digits to be compared."""
    motion, (kind, coordinate, *end) = str(reference.at["motion"]), reference.quantity.split(".")
    found = motion_of(name, motion)
    if kind in ("q", "p"):
        state = state_of(name, motion, str(reference.at["t"]))
        if isinstance(state, tuple):
            return mp.mpf(state[kind == "p"][coordinate]), mp.mpf("1e-18")
        return getattr(state, kind)[coordinate], getattr(state.error, kind)[coordinate]
    if kind == "turning_point":
        estimate = found.turning_points[coordinate][0 if end == ["lower"] else 1]
    else:
        tables = {"period": "periods", "action": "actions", "frequency": "frequencies", "constant": "constants"}
        estimate = getattr(found, tables[kind])[coordinate]
    return estimate.value, estimate.error


@pytest.mark.parametrize("name", IDS)
def test_every_extended_entry_has_values_for_every_motion(name: str) -> None:
    references = entry(name).references
    assert len(references) >= 7
    assert {r.at["motion"] for r in references} == set(entry(name).motions)
    for reference in references:
        digits = reference.value.lstrip("-0.").replace(".", "")
        assert len(digits) >= 30 or len(digits) <= 12, reference


@pytest.mark.entries
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_the_values_are_made_again(name: str, motion: str) -> None:
    """The closed forms, exponentials and Taylor series of tests/reference/extended.py, at 30 digits."""
    with mp.workdps(40):
        data = next(d for d in extended.motions(name) if d.name == motion)
        values, at = extended.FORMS[name](data)
        times = sorted({str(r.at["t"]) for r in entry(name).references if "t" in r.at})[:1]
        known = {q: v for q, (v, _) in values.items()} | at(mp.mpf(times[0]))
        for r in entry(name).references:
            if r.at["motion"] == motion and str(r.at.get("t", times[0])) == times[0]:
                off = known[r.quantity] - mp.mpf(r.value)
                if r.quantity in extended.ANGLES:
                    off -= 2 * mp.pi * mp.nint(off / (2 * mp.pi))
                assert abs(off) <= mp.mpf("1e-22") * abs(mp.mpf(r.value)), r.quantity


@pytest.mark.entries
@pytest.mark.parametrize("name", IDS)
def test_hjsolve_reaches_the_published_values_to_1e13(name: str) -> None:
    """Relative, atol = 0; the reported error must cover the true one."""
    with mp.workdps(50):
        for reference in entry(name).references:
            value, error = measured(name, reference)
            value = mp.mpf(float(value)) if isinstance(value, float) else mp.mpf(value)
            off = abs(value - mp.mpf(reference.value))
            assert off <= 1e-13 * abs(mp.mpf(reference.value)), reference
            assert off <= mp.mpf(error), (reference, mp.nstr(off, 3), error)


@pytest.mark.entries
@pytest.mark.parametrize(("name", "motion"), MOTIONS)
def test_the_kinds_are_those_of_the_entry(name: str, motion: str) -> None:
    kinds = entry(name).motions[motion].kinds
    if entry(name).expect["verdict"] == "refused":
        assert not kinds
        return
    assert dict(motion_of(name, motion).kinds) == dict(kinds)
