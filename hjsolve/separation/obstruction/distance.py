"""How far from separable: how badly the base-point construction rebuilds a shell that does not separate.

Every separable metric is given back exactly from its values on the n lines through one point (``stackel``); one that
is not is given back wrongly, and the relative error says by how much. It measures; it decides nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import islice
from statistics import median

import mpmath
import sympy as sp

from hjsolve.algebra.intervals import NoEnclosureError, Walk, finite
from hjsolve.precision import mp
from hjsolve.separation.zero_test.interval_evaluation import UNKNOWNS, Region

SAMPLES = 6
ATTEMPTS = 60
PRECISION = 160
OPERATIONS = 60_000
"""Operations of balls that the samples may take, some 0.4 s: counted, since what a clock allows differs each time."""
Point = dict[sp.Expr, sp.Rational]


def distance_from_separable(
    symbols: Sequence[sp.Symbol], metric: Sequence[sp.Expr], potential: sp.Expr, part: str, region: Region
) -> float | None:
    """Relative error with which the base-point construction rebuilds the metric, or the potential, of a shell.

    With s the matrix of the axis-line formula, Σᵢ gⁱⁱ sᵢ⁽ᵃ⁾ = 1 for every a determines g, and V = V(q⁰) + Σ gⁱⁱ uᵢ.

    Args:
        symbols: essential coordinates.
        metric: gᵃᵃ.
        potential: V_eff.
        part: ``metric`` or ``potential``: which of them is compared.
        region: domain, and the parameters' values.

    Returns:
        The median over sample points of the largest relative error of a gᵃᵃ; for the potential, of the error of V as a
        fraction of its median change between the points. Parameters have their default values, or simple ones. None
        where the expressions cannot be evaluated.
    """
    whole = sp.Tuple(*metric, potential)
    if whole.atoms(*UNKNOWNS):
        return None
    points = list(islice(_points(symbols, whole, region), ATTEMPTS))
    for base in points:
        try:
            errors = _errors(symbols, [*metric, potential], part, base, [p for p in points if p is not base])
        except (NoEnclosureError, ZeroDivisionError):
            continue
        if errors:
            return float(median(errors))
    return None


def _points(symbols: Sequence[sp.Symbol], whole: sp.Tuple, region: Region) -> Iterator[Point]:
    """Points that differ in the coordinates only."""
    held = next(region.points(whole), None)
    if held is None:
        return
    fixed = {s: v for s, v in held.items() if s not in symbols}
    bounds = {q: tuple(None if end is None else end.xreplace(fixed) for end in region.bounds[q]) for q in symbols}
    for point in Region(bounds).points(sp.Tuple(*symbols), anywhere=False):  # type: ignore[arg-type]
        yield {**fixed, **point}


def _errors(
    symbols: Sequence[sp.Symbol], functions: Sequence[sp.Expr], part: str, base: Point, points: Sequence[Point]
) -> list[mpmath.mpf]:
    """Return errors at up to ``SAMPLES`` points, fewer where the functions are long, with the base point given."""
    samples = min(SAMPLES, max(1, OPERATIONS // ((len(symbols) + 1) * _operations(functions))))
    with mp.workprec(PRECISION):
        g0 = _values(functions, base)
        found = []
        for point in points:
            try:
                found.append(_rebuilt(symbols, functions, base, g0, point))
            except (NoEnclosureError, ZeroDivisionError):
                continue
            if len(found) == samples:
                break
        if part == "metric":
            return [max(abs(a / b - 1) for a, b in zip(new[:-1], old[:-1])) for new, old in found]
        scale = median([abs(old[-1] - g0[-1]) for _, old in found]) if found else mp.mpf(0)
        return [abs(new[-1] - old[-1]) / scale for new, old in found]


def _rebuilt(
    symbols: Sequence[sp.Symbol], functions: Sequence[sp.Expr], base: Point, g0: list[mpmath.mpf], point: Point
) -> tuple[list[mpmath.mpf], list[mpmath.mpf]]:
    """Return metric and the potential at a point as rebuilt from the lines through the base point, and as they are."""
    n = len(symbols)
    s, u = mp.matrix(n, n), mp.matrix(n, 1)
    for i, q in enumerate(symbols):
        on_line = _values(functions, {**base, q: point[q]})
        u[i] = (on_line[-1] - g0[-1]) / on_line[i]
        for j in range(n):
            s[j, i] = 1 / on_line[i] if i == j else (1 - on_line[j] / g0[j]) / on_line[i]
    g = mp.lu_solve(s, mp.ones(n, 1))
    return [*g, g0[-1] + mp.fdot(g, u)], _values(functions, point)


def _operations(functions: Sequence[sp.Expr]) -> int:
    return len({e for f in functions for e in sp.preorder_traversal(f)})


def _values(functions: Sequence[sp.Expr], point: Point) -> list[mpmath.mpf]:
    """Return the values of several functions at a point; what they share is evaluated once."""
    walk = Walk(point, PRECISION)
    return [sum(finite(partial(walk, f))) / 2 for f in functions]
