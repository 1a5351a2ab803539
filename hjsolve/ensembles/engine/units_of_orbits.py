"""Orbits at extreme scales or deep in a core, each group of them in units of its own.

q = 2^e q̂ and p = 2^(A − e) p̂ is a canonical map of valence 2^A (Greenwood (6-266)–(6-277)); with H = 2^κ Ĥ the time is
t = 2^(A − κ) t̂. Actions are 2^A times those in the new units, frequencies 2^(κ − A) times, angles are the same. So the
passes run as they are on a system whose numbers are of order one, and nothing rounds: the factors are powers of two.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from hjsolve.arithmetic.block_exponents import Unit, exponent_of, over_power_of_two, tape_in_units, unit_of
from hjsolve.arithmetic.floats import EPS
from hjsolve.arithmetic.number_types import Integers, Mask, Mpf, Reals
from hjsolve.ensembles.engine.columns import Columns
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model, Separated
from hjsolve.ensembles.engine.starts import Starts
from hjsolve.ensembles.engine.status import UNDECIDED, Status

_FEWEST_BITS = 4
"""Numbers within 2^4 of 1 stay as they are."""

LARGE_BITS = 64
"""Beyond 2^64 units of their own keep orbits in the range of doubles; small ones keep differences apart."""

_SMALLEST = 2.0**-960
"""Results below are not reported: what rounding does next to the smallest doubles no claim counts."""


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
    """Yield units that are not 1 and may help, and the orbits that they suit.

    Args:
        starts: of all orbits.
        orbits: which of them are asked for.
    """
    q, p = starts.q[:, orbits], starts.p[:, orbits]
    angle = np.array([name in model.angles for name in model.names])
    angle[[c.index for c in model.separated if c.periodic]] = True
    with np.errstate(all="ignore"):
        size = np.log2(np.abs(q))
        size = np.where(np.isfinite(size) & ~angle[:, None], size, 0.0)
        # the unit of q p: one for all coordinates, as a canonical map of valence has
        action = (size + np.log2(np.abs(p))).max(axis=0)
    action = np.where(np.isfinite(action), action, 0.0)
    # each group costs programs of its own: exponents are rounded so that there are few
    kinds, which = np.unique(rounded_exponents(np.vstack([size, action])), axis=1, return_inverse=True)
    for k in np.flatnonzero((kinds[:-1] < 0).any(axis=0) | (np.abs(kinds) > LARGE_BITS).any(axis=0)):
        *places, unit = (int(e) for e in kinds[:, k])
        yield UnitsOfOrbits(tuple(places), unit), orbits[which.ravel() == k]


def rounded_exponents(exponents: Reals) -> Integers:
    """Round exponents to an eighth of themselves, so that few groups hold all orbits, and 2^e is known to 2^(e/8).

    Args:
        exponents: logarithms to the base 2, any shape.
    """
    size = np.abs(exponents)
    step = 2.0 ** np.maximum(np.floor(np.log2(np.maximum(size, 1.0))) - 2, 0)
    return np.where(size < _FEWEST_BITS, 0, step * np.rint(exponents / step)).astype(np.int64)


@dataclass(frozen=True)
class ModelInUnits:
    """A lowered solution in other units.

    Attributes:
        model: the solution.
        bases, exponents: constant c of the system is base + ĉ·2^exponent, the energy first.
    """

    model: Model
    bases: tuple[Mpf, ...]
    exponents: tuple[int, ...]


@lru_cache(maxsize=64)
def model_in_units(model: Model, units: UnitsOfOrbits) -> ModelInUnits:
    """Return a lowered solution in other units.

    Args:
        units: of places and momenta.
    """
    own = tuple(map(unit_of, model.numbers))
    start = (*map(Unit, units.places), *map(Unit, units.momenta), *own)
    rule = tape_in_units(model.rule, start)
    constants = tuple(Unit(e, base) for e, base in zip(rule.exponents, rule.bases, strict=True))
    shift = tape_in_units(model.shift, start, [units.momenta[c.index] for c in model.separated])
    made = replace(
        model,
        rule=rule.tape,
        shift=shift.tape,
        separated=tuple(_separated(c, units, constants, own) for c in model.separated),
        numbers=tuple(map(over_power_of_two, model.numbers)),
        exact=tuple(x * Fraction(2) ** -exponent_of(p.high) for x, p in zip(model.exact, model.numbers, strict=True)),
    )
    return ModelInUnits(made, tuple(rule.bases), tuple(rule.exponents))


def _separated(one: Separated, units: UnitsOfOrbits, constants: tuple[Unit, ...], own: tuple[Unit, ...]) -> Separated:
    place, square = units.places[one.index], 2 * units.momenta[one.index]
    # p² in units of P², its kernels ∂p²/∂c in those over the unit of c
    wanted = [square, *(square - c.exponent for c in constants)]

    def formula(view: LoweredFormula) -> LoweredFormula:
        inputs = (Unit(place), *constants, *own)
        return LoweredFormula(
            over_power_of_two(view.origin, place),
            view.sign,
            tape_in_units(view.squared, inputs, wanted[:1]).tape,
            tape_in_units(view.full, inputs, wanted).tape,
            view.clearance.in_units(place, constants),
        )

    lower, upper = (None if view is None else formula(view) for view in (one.lower, one.upper))
    return replace(one, plain=formula(one.plain), lower=lower, upper=upper)


def starts_in_units(starts: Starts, units: UnitsOfOrbits) -> Starts:
    """Return starts in other units; momenta that velocities give become two doubles.

    Args:
        units: of places and momenta.
    """
    starts = starts.precise()
    places, momenta = (-np.array(e)[:, None] for e in (units.places, units.momenta))
    # powers of two: nothing is rounded
    rows = (np.ldexp(row, momenta) for row in (starts.p, starts.uncertainty, starts.low, starts.spread))
    return Starts(np.ldexp(starts.q, places), *rows)


def columns_in_old_units(columns: Columns, made: ModelInUnits, units: UnitsOfOrbits) -> Columns:
    """Return what was found in the units of the system; undecided where a number has no double.

    Args:
        columns: what was found.
        units: of places and momenta.
    """
    model = made.model
    places, rate = dict(zip(model.names, units.places, strict=True)), made.exponents[0] - units.action
    of_all = {"actions": units.action, "frequencies": rate, "periods": -rate, "angles": 0}
    lost: Mask = np.zeros(len(columns.status), dtype=bool)

    def in_given_units(x: Reals, exponent: int) -> Reals:
        with np.errstate(all="ignore"):
            found: Reals = np.ldexp(x, exponent)
            # a result that has no double in the user's units is not given
            lost[(x != 0) & ~np.isnan(x) & ~((np.abs(found) > _SMALLEST) & np.isfinite(found))] = True
        return found

    error = {}
    for key, claims in columns.error.items():
        quantity, name = key.split(".", 1)
        values = columns.group(quantity)[name]
        if quantity == "constants":
            j = model.constants.index(name)
            values[:], error[key] = in_given_units(values, made.exponents[j]), in_given_units(claims, made.exponents[j])
            values += float(made.bases[j])
            error[key] += 2 * EPS * np.abs(values) if made.bases[j] else 0.0
            continue
        exponent = of_all[quantity] if quantity in of_all else places[name.rpartition(".")[0]]
        values[:], error[key] = in_given_units(values, exponent), in_given_units(claims, exponent)
    columns.status[lost & (columns.status == Status.OK)] = UNDECIDED
    return replace(columns, error=error)
