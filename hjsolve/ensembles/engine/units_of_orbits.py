"""Orbits at extreme scales, each group of them in units of its own.

q = 2^e q̂ and p = 2^(A − e) p̂ is a canonical map of valence 2^A (Greenwood (6-266)–(6-277)); with H = 2^κ Ĥ the time is
t = 2^(A − κ) t̂. Actions are 2^A times those in the new units, frequencies 2^(κ − A) times, angles are the same. So the
passes run as they are on a system whose numbers are of order one, and nothing rounds: the factors are powers of two.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from hjsolve.arithmetic.block_exponents import exponent_of, tape_in_units
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.number_types import Integers, Mask, Reals
from hjsolve.ensembles.engine.columns import Columns
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import UNDECIDED, Status

_STEP_OF_EXPONENTS = 128
"""Exponents of units are multiples of it, so that orbits within 2^64 of a unit share it, and it is 1 for most."""

_SMALLEST = 2.0**-960
"""Results below are not told: what rounding does next to the smallest doubles no claim counts."""


@dataclass(frozen=True)
class UnitsOfOrbits:
    """Units of a group of orbits, as exponents of two.

    Attributes:
        places: of every coordinate; 0 of angles.
        action: of all actions.
    """

    places: tuple[int, ...]
    action: int

    @property
    def momenta(self) -> tuple[int, ...]:
        """Exponents of every momentum."""
        return tuple(self.action - e for e in self.places)


def groups(model: Model, starts: Starts, orbits: Integers) -> Iterator[tuple[UnitsOfOrbits, Integers]]:
    """Yield the units that are not 1, and the orbits that they suit.

    Args:
        model: the lowered solution.
        starts: of all orbits.
        orbits: which of them are asked for.
    """
    q, p = starts.q[:, orbits], starts.p[:, orbits]
    angle = np.array([name in model.angles for name in model.names])
    angle[[c.index for c in model.separated if c.periodic]] = True
    with np.errstate(all="ignore"):
        size = np.where(angle[:, None] | (q == 0), 0.0, np.log2(np.abs(q)))
        action = (size + np.log2(np.abs(p))).max(axis=0)
    action = np.where(np.isfinite(action), action, 0.0)
    exponents = _STEP_OF_EXPONENTS * np.rint(np.vstack([size, action]) / _STEP_OF_EXPONENTS).astype(np.int64)
    kinds, which = np.unique(exponents, axis=1, return_inverse=True)
    for k in np.flatnonzero(kinds.any(axis=0)):
        *places, unit = (int(e) for e in kinds[:, k])
        yield UnitsOfOrbits(tuple(places), unit), orbits[which.ravel() == k]


@lru_cache(maxsize=64)
def model_in_units(model: Model, units: UnitsOfOrbits) -> tuple[Model, tuple[int, ...]]:
    """Return a lowered solution in other units, and the exponents of its constants.

    Args:
        model: the lowered solution.
        units: of places and momenta.
    """
    own = tuple(exponent_of(pair.high) for pair in model.numbers)
    start = (*units.places, *units.momenta, *own)
    rule, constants = tape_in_units(model.rule, start)
    momenta = [units.momenta[c.index] for c in model.separated]
    shift, _ = tape_in_units(model.shift, start, momenta)
    return replace(
        model,
        rule=rule,
        shift=shift,
        separated=tuple(_separated(c, units, constants, own) for c in model.separated),
        numbers=tuple(_over(pair, e) for pair, e in zip(model.numbers, own, strict=True)),
        exact=tuple(x * Fraction(2) ** -e if x else x for x, e in zip(model.exact, own, strict=True)),
    ), tuple(constants)


def _over(pair: Pair, exponent: int) -> Pair:
    return Pair(*(float(np.ldexp(part, -exponent)) if part else 0.0 for part in pair))


def _separated(one: Separated, units: UnitsOfOrbits, constants: Sequence[int], own: tuple[int, ...]) -> Separated:
    place, square = units.places[one.index], 2 * units.momenta[one.index]
    weights = [square - e for e in constants]

    def formula(view: LoweredFormula) -> LoweredFormula:
        inputs = (place, *constants, *own)
        return LoweredFormula(
            _over(view.origin, place),
            view.sign,
            tape_in_units(view.squared, inputs, [square])[0],
            tape_in_units(view.full, inputs, [square, *weights])[0],
            view.clearance.in_units(place, constants),
        )

    lower, upper = (None if view is None else formula(view) for view in (one.lower, one.upper))
    return replace(one, plain=formula(one.plain), lower=lower, upper=upper)


def starts_in_units(starts: Starts, units: UnitsOfOrbits) -> Starts:
    """Return starts in other units; momenta that velocities give become two doubles.

    Args:
        starts: of n orbits.
        units: of places and momenta.
    """
    starts = starts.precise()
    places, momenta = (-np.array(e)[:, None] for e in (units.places, units.momenta))
    rows = {name: np.ldexp(getattr(starts, name), momenta) for name in ("p", "uncertainty", "low", "spread")}
    return replace(starts, q=np.ldexp(starts.q, places), velocity=None, rule=None, **rows)


def columns_in_old_units(columns: Columns, model: Model, units: UnitsOfOrbits, constants: Sequence[int]) -> Columns:
    """Return what was found in the units of the system; undecided where a number has no double.

    Args:
        columns: what was found.
        model: the lowered solution, in either units.
        units: in which it was found.
        constants: exponents of the constants, the energy's first.
    """
    places = dict(zip(model.names, units.places, strict=True))
    rate = constants[0] - units.action
    lost: Mask = np.zeros(len(columns.status), dtype=bool)

    def exponent(quantity: str, name: str) -> int:
        match quantity:
            case "constants":
                return constants[model.constants.index(name)]
            case "turning_points":
                return places[name.rpartition(".")[0]]
            case "actions":
                return units.action
            case "frequencies":
                return rate
            case "periods":
                return -rate
            case _:
                return 0

    def told(x: Reals, e: int) -> Reals:
        with np.errstate(all="ignore"):
            found: Reals = np.ldexp(x, e)
            lost[(x != 0) & ~np.isnan(x) & ~((np.abs(found) > _SMALLEST) & np.isfinite(found))] = True
        return found

    error = {}
    for key, claims in columns.error.items():
        quantity, name = key.split(".", 1)
        e, values = exponent(quantity, name), columns.group(quantity)[name]
        values[:], error[key] = told(values, e), told(claims, e)
    columns.status[lost & (columns.status == Status.OK)] = UNDECIDED
    return replace(columns, error=error)
