"""Constants of the motion of many orbits, in doubles with a running error bound, or from 32 digits.

E = T + V of a nearly unbound orbit, or the slope of p² at the start of a nearly circular one, is a small difference of
large numbers. In ``precise`` mode they are computed with 32 digits from the inputs as the exact numbers they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import UNIT, Float64
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Reals
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.ensembles.engine.lowered_solution import LoweredFormula, Model
from hjsolve.ensembles.engine.radicand_views import Knowns
from hjsolve.ensembles.engine.starts import Starts


@dataclass(frozen=True)
class InitialConstants:
    """Initial data of n orbits.

    Attributes:
        q: positions of the separated coordinates.
        P: their shell momenta.
        starts: as they were taken, of all coordinates.
        knowns: constants and parameters.
        pairs: the constants in two doubles, None where they were computed in doubles.
        rounding: bounds on the relative errors of P where p comes from velocities, shape of P. Next to a turning point
            χ is read off P and grows no faster.
    """

    q: Reals
    P: Reals
    starts: Starts
    knowns: Knowns
    pairs: tuple[Pair, ...] | None
    rounding: Reals


def momentum_errors(model: Model, starts: Starts) -> Reals:
    """Bounds on the relative errors of the momenta of the separated coordinates, shape (separated, n).

    Args:
        model: of the system.
        starts: of n orbits.
    """
    places = [c.index for c in model.separated]
    uncertainty, p = starts.uncertainty[places], starts.p[places]
    with np.errstate(all="ignore"):
        return np.where(uncertainty > 0, uncertainty / np.abs(p), 0.0)


def initial_constants(model: Model, starts: Starts, *, precise: bool) -> InitialConstants:
    """Work out the constants.

    Args:
        model: of the system.
        starts: of n orbits.
        precise: with 32 digits.
    """
    starts = starts.precise() if precise else starts
    q, p = starts.q, starts.p
    numbers = [pair.high for pair in model.numbers]
    shape = q.shape[1:]
    with np.errstate(all="ignore"):
        bounded = [WithErrorBound(x) for x in q]
        bounded += [WithErrorBound(x, e if e.any() else None) for x, e in zip(p, starts.spread, strict=True)]
        bounded += [WithErrorBound(x, UNIT * abs(x)) for x in numbers]
        running = model.rule.run(RunningError(Float64()), bounded)
        uncertainties = [np.broadcast_to((0.0 if r.error is None else r.error), shape) for r in running]
        values = [np.broadcast_to(r.value, shape) for r in running]
        places = [c.index for c in model.separated]
        pairs = None
        if precise:
            inputs = [Pair(x, 0.0 * x) for x in q]
            inputs += [Pair(x, low) for x, low in zip(p, starts.low, strict=True)] + list(model.numbers)
            pairs = tuple(_full(pair, shape) for pair in model.rule.run(DoubleDouble(), inputs))
            values = [pair.high for pair in pairs]
            uncertainties = [UNIT * np.abs(v) + 2.0**-44 * e for v, e in zip(values, uncertainties, strict=True)]
            shifts = model.shift.run(DoubleDouble(), inputs)
            P = [_sum(Pair(p[k], starts.low[k]), shift) for k, shift in zip(places, shifts, strict=True)]
        else:
            shifts = model.shift.run(Float64(), [*q, *p, *numbers])
            P = [p[k] + shift for k, shift in zip(places, shifts, strict=True)]
    knowns = Knowns(tuple(values), tuple(uncertainties), tuple(numbers))
    lost = momentum_errors(model, starts)
    return InitialConstants(q[places], np.stack(P) if P else p[:0], starts, knowns, pairs, lost)


def _full(pair: Pair, shape: tuple[int, ...]) -> Pair:
    return Pair(np.broadcast_to(pair.high, shape), np.broadcast_to(pair.low, shape))


def _sum(p: Pair, shift: Pair) -> Reals:
    return DoubleDouble().add(p, shift).high + 0.0 * p.high


def slope(formula: LoweredFormula, pairs: tuple[Pair, ...], parameters: tuple[Pair, ...], q: Reals) -> Reals:
    """Return F′(q) to full relative accuracy, from 32 digits.

    Args:
        formula: F(q) and how it was lowered.
        pairs: constants as two doubles, arrays of shape (n,).
        parameters: as two doubles.
        q: places, shape (n,).
    """
    jets = Jets(DoubleDouble())
    inputs = [jets.variable(Pair(q, 0.0 * q)), *(Jet(pair) for pair in (*pairs, *parameters))]
    first = formula.squared.run(jets, inputs)[0].first
    return 0.0 * q if first is None else first.high + 0.0 * q
