"""Motions at many points of the map: a start for each, and their actions and frequencies from ensembles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import sympy as sp

from hjsolve.arithmetic.floats import Float64
from hjsolve.energy_momentum.coordinate_kinds import CoordinateKinds, Regions
from hjsolve.energy_momentum.isolation import Reals
from hjsolve.ensembles import Batch, ensemble
from hjsolve.lowering import lower
from hjsolve.solution.quadratures import Solution

_NODES = 48


def bounded_orbits(
    solution: Solution, coordinates: Sequence[CoordinateKinds], x: Reals, y: Reals, want: Iterable[str], *,
    every: bool = False,
) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], Batch | None]:  # fmt: skip
    """Compute one motion for every point at which each coordinate has a bounded region; the first region of each.

    Args:
        coordinates: every separated coordinate.
        x, y: the points, shape (m,).
        want: of ``ensemble``.
        every: also those orbits that the vectorised engine hands back, up to some tenths of a second each.

    Returns:
        Which points, and their batch; None where there is none.
    """
    found = [own.at(x, y) for own in coordinates]
    starts = np.array([[_well(regions, i) for regions in found] for i in range(len(x))], float).reshape(len(x), -1)
    good = np.flatnonzero(np.isfinite(starts).all(axis=1))
    if not len(good):
        return good, None
    return good, _batch(solution, coordinates, x[good], y[good], starts[good], want, every=every)


def drawn_actions(own: CoordinateKinds, x: Reals, y: Reals) -> Reals:
    """Return J = (1/2π) ∮ p dq of the first bounded region at many points, to the few digits of a drawing.

    Args:
        own: the coordinate; all NaN where its P² is not a polynomial.
        x, y: the points, shape (m,).
    """
    result = np.full(len(x), np.nan)
    if own.polynomial is None:
        return result
    found = own.at(x, y, every=False)
    low, high = found.first_well()
    good = np.isfinite(low)
    middle, half = (low + high)[good] / 2, (high - low)[good] / 2
    χ = np.pi * (np.arange(_NODES) + 0.5) / _NODES
    turns = found.count[good] == 0
    places = np.where(turns[:, None], χ * 2 - np.pi, middle[:, None] - half[:, None] * np.cos(χ))
    weights = np.where(turns[:, None], 1.0, half[:, None] * np.sin(χ))
    known = {**own.values, own.constants[0]: x[good, None], own.constants[1]: y[good, None]}
    symbol = own.solution.system.coordinate(own.name).symbol
    tape = lower([own.solution.momentum_squared[own.name]], [symbol, *known])
    with np.errstate(all="ignore"):
        square = np.asarray(tape.run(Float64(), [places, *map(_number, known.values())])[0], float)
        result[good] = (np.sqrt(np.maximum(square, 0)) * weights).mean(axis=1)
    return result


def _well(regions: Regions, i: int) -> float:
    place = None if regions.coordinate.polynomial is None else regions.well(i)
    return np.nan if place is None else place


def _batch(
    solution: Solution, coordinates: Sequence[CoordinateKinds], x: Reals, y: Reals, starts: Reals, want: Iterable[str],
    *, every: bool,
) -> Batch:  # fmt: skip
    first = coordinates[0]
    known = {**first.values, first.constants[0]: x, first.constants[1]: y}
    q = {c.name: np.zeros(len(x)) for c in solution.system.coordinates}
    p = {
        c.name: np.broadcast_to(np.asarray(_number(known[c.momentum]), float), x.shape)
        for c in solution.system.coordinates if c.momentum in known
    }  # fmt: skip
    for k, own in enumerate(coordinates):
        symbol = solution.system.coordinate(own.name).symbol
        rest = {s: _number(value) for s, value in known.items()}
        symbols = [symbol, *rest]
        tape = lower([solution.momentum_squared[own.name], solution.shift[own.name]], symbols)
        with np.errstate(all="ignore"):
            square, shift = tape.run(Float64(), [starts[:, k], *rest.values()])
        q[own.name] = starts[:, k]
        p[own.name] = np.sqrt(np.maximum(np.asarray(square, float), 0)) - np.asarray(shift, float) + np.zeros(len(x))
    parameters = {s.name: first.values[s.symbol] for s in solution.system.parameters}
    subject = solution.system if solution.chart is not None else solution
    threads = 1 if every else None  # a report holds the lock that single orbits ask for
    return ensemble(subject, q=q, p=p, want=want, parameters=parameters, fallback=every, threads=threads)


def _number(value: sp.Expr | Reals) -> float | Reals:
    return value if isinstance(value, np.ndarray) else float(sp.N(value, 30))
