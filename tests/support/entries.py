"""Entries of the catalog, their systems, verdicts, solutions, closed forms and motions: made once a process and shared by all tests.

All of them are frozen values, so sharing them changes no test.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import hjsolve
from hjsolve import catalog
from hjsolve.catalog import Entry
from hjsolve.closed_form.forms import RegimeForms
from hjsolve.mechanics.system import System
from hjsolve.separation import Obstruction, Separation, Undecided, separate
from hjsolve.solution.quadratures import Solution, solve


@functools.cache
def table(name: str) -> dict[str, Any]:
    """The entry as its file has it: lists of cases are made from it, so that collecting builds no system."""
    return catalog.read(name)[0]


def kinds_of_motions(name: str) -> dict[str, dict[str, str]]:
    """Motion of an entry → the kind of motion of each coordinate, where the file says it."""
    motions = {"default": table(name)["initial"]} if "initial" in table(name) else {}
    return {motion: data.get("kinds", {}) for motion, data in (motions | table(name).get("motions", {})).items()}


def with_closed_form() -> tuple[list[str], list[tuple[str, str]]]:
    """Entries with a closed form in their file, and their motions that have one: of the kind it is for."""
    names = [name for name in catalog.ids("separable") if table(name).get("closed")]
    return names, [
        (name, motion)
        for name in names
        for motion, kinds in kinds_of_motions(name).items()
        if any(form.get("kinds", kinds) == kinds for form in table(name)["closed"])
    ]


@functools.cache
def described(name: str) -> Entry:
    """The entry, its system built without effects."""
    return catalog.describe(name)


@functools.cache
def separable() -> tuple[str, ...]:
    """Every entry with T and V that is expected to separate: those of ``extended`` too, relativistic or in a frame."""
    names = (*catalog.ids("separable"), *catalog.ids("extended"))
    return tuple(n for n in names if (e := described(n)).system is not None and e.expect["verdict"] != "refused")


@functools.cache
def separable_with_effects() -> tuple[str, ...]:
    """The same, and each with every effect that leaves it separable: ``name`` and ``name+effect``."""
    more = (f"{n}+{e.name}" for n in separable() for e in described(n).effects.values() if e.verdict != "refused")
    return (*separable(), *more)


def solved(name: str) -> Solution:
    """The solution of an entry, effects after plus signs."""
    entry, *effects = name.split("+")
    return solution(entry, tuple(effects))


def given(name: str) -> dict[str, Any]:
    """The arguments of the default motion of an entry, effects after plus signs."""
    entry, *_ = name.split("+")
    return {**described(entry).motions["default"].arguments}


@functools.cache
def loaded(name: str, effects: tuple[str, ...] = ()) -> System:
    """The system of an entry with some effects."""
    if effects:
        return catalog.load(name, effects=effects)
    system = described(name).system
    assert system is not None
    return system


@functools.cache
def verdict(name: str, effects: tuple[str, ...] = ()) -> Separation | Obstruction | Undecided:
    """What ``separate`` says of it."""
    return separate(loaded(name, effects))


@functools.cache
def solution(name: str, effects: tuple[str, ...] = ()) -> Solution:
    """Its solution by quadratures."""
    found = verdict(name, effects)
    return solve(found if isinstance(found, Separation) else loaded(name, effects))


@functools.cache
def forms(name: str) -> tuple[RegimeForms, ...]:
    """The closed forms of its regimes: all of them, as how many 20 s of a busy processor give is not a fact to test."""
    return hjsolve.closed_forms(name, seconds=math.inf)


@functools.cache
def motion(name: str, which: str = "default") -> Any:
    """A motion of the entry, in doubles."""
    return solution(name).motion(**described(name).motions[which].arguments)


@functools.cache
def state(name: str, which: str, t: str) -> Any:
    """Where that motion is at a time."""
    return motion(name, which).at(t)
