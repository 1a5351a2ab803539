"""Is T positive definite on the domain? Proved from the symbols where sympy can, else tried at many points."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence

import mpmath
import sympy as sp
from sympy.core.function import AppliedUndef

from hjsolve.errors import InvalidSystemError
from hjsolve.formulas.point_values import CONTEXT, BeyondRangeError, NoValueError, evaluate
from hjsolve.mechanics.coordinates_and_parameters import Coordinate, Parameter
from hjsolve.mechanics.domains import Domain
from hjsolve.precision import mp

_POINTS = 16
_TRIALS = 6
_ATTEMPTS = 200
_CANCELLED = CONTEXT.mpf(10) ** -65
Point = Mapping[sp.Symbol, mpmath.mpf]


def check_mass_matrix(
    matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate], parameters: Sequence[Parameter], signature: str
) -> None:
    """Refuse a mass matrix that is singular, or not positive definite where it must be.

    A diagonal matrix whose entries sympy proves positive passes at once. Otherwise the leading principal minors are
    computed at points inside the domain, with the parameters' values. Where parameters have none, values that agree
    with their assumptions are tried: the matrix passes if some values make it positive definite at every point, for
    it is checked again when values are given. An undetermined function is tried as a positive one.

    Args:
        matrix: M(q), symmetric, shape (n, n).
        coordinates, parameters: as declared; their domains and values say where M is tried.
        signature: ``definite`` where M must be positive definite, ``indefinite`` where it must only be regular.

    Raises:
        InvalidSystemError: with the minor, its value and the point.
    """
    matrix = _determined(matrix)
    diagonal = matrix.is_diagonal()
    if signature == "definite" and diagonal and all(matrix[i, i].is_positive for i in range(matrix.rows)):
        return
    faults = []
    for values in _parameter_values(parameters):
        points = _points(coordinates, values)
        if not points:
            continue
        fault = _fault(matrix, coordinates, points) if signature == "definite" else _degeneracy(matrix, points)
        if not fault:
            return
        faults.append(fault)
        if len(faults) == _TRIALS:
            break
    if faults:
        raise InvalidSystemError(f"kinetic: {faults[0]}")
    free = ", ".join(p.name for p in parameters if p.value is None)
    raise InvalidSystemError(f"no values of {free} were found that leave every domain non-empty; give default values")


def _determined(matrix: sp.ImmutableMatrix) -> sp.ImmutableMatrix:
    """Return the matrix with each undetermined function replaced by a positive one, different for every name."""
    functions = sorted({f.func for f in matrix.atoms(AppliedUndef)}, key=str)
    for k, f in enumerate(functions):
        matrix = matrix.replace(f, lambda *x, k=k: 1 + sp.Rational(k + 1, 7) + sp.Add(*(a**2 / (k + 3) for a in x)))
    return matrix


def _degeneracy(matrix: sp.ImmutableMatrix, points: Sequence[Point]) -> str:
    known = False
    for point in points:
        try:
            entries = _evaluated(matrix, point)
        except NoValueError:
            continue
        known = True
        if _is_regular(entries):
            return ""
    if not known:
        return f"T is not real {_at(matrix, points[0])}; narrow the domain"
    return "T is degenerate: the determinant of its matrix is zero, so that the momenta do not give the velocities"


def _fault(matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate], points: Sequence[Point]) -> str:
    """Return what keeps the matrix from being positive definite, or nothing.

    A negative minor at one point is a fault; a minor that is zero there, to rounding, only if it is so at every point.
    """
    vanishing, passed = "", False
    for point in points:
        try:
            entries = _evaluated(matrix, point)
        except BeyondRangeError:
            continue
        except NoValueError:
            return f"T is not real {_at(matrix, point)}; narrow the domain"
        k, pivot = next(((k, pivot) for k, pivot in enumerate(_pivots(entries)) if pivot <= 0), (0, None))
        if pivot is None:
            passed = True
            continue
        vanishing = _described(matrix, coordinates, entries, point, k)
        if pivot < -_CANCELLED:
            return vanishing
    return "" if passed else vanishing


def _described(
    matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate], entries: mpmath.matrix, point: Point, k: int
) -> str:
    """Return the fault of the minor that ends at the coordinate k."""
    names = [c.velocity.name for c in coordinates[: k + 1]]
    minor, part = CONTEXT.det(entries[: k + 1, : k + 1]), matrix[: k + 1, : k + 1]
    what = f"the leading minor of {', '.join(names)}"
    if matrix[k, :k].is_zero_matrix:
        what, minor, part = f"the coefficient of {names[-1]}**2/2, {matrix[k, k]!s:.80},", entries[k, k], matrix[k, k]
    place = f" {_at(part, point)}" if part.free_symbols else ""
    return (
        f"T must be positive definite: {what} is {_short(minor)}{place}; "
        'correct T, the values or the domain (signature="indefinite" allows it)'
    )


def _pivots(entries: mpmath.matrix) -> Iterator[mpmath.mpf]:
    """D of M = L D Lᵀ: quotients of successive leading principal minors; exact 0 for what has cancelled."""
    work = entries.copy()
    for k in range(work.rows):
        pivot = work[k, k] if abs(work[k, k]) > _CANCELLED * abs(entries[k, k]) else CONTEXT.zero
        yield pivot
        if pivot == 0:
            return
        for i in range(k + 1, work.rows):
            ratio = work[i, k] / pivot
            for j in range(k + 1, work.rows):
                work[i, j] -= ratio * work[k, j]


def _is_regular(entries: mpmath.matrix) -> bool:
    """Whether the determinant is not zero to rounding: elimination with the largest pivot of all that is left."""
    left = [[entries[i, j] for j in range(entries.cols)] for i in range(entries.rows)]
    largest = max((abs(x) for row in left for x in row), default=CONTEXT.zero)
    while left:
        size, i, j = max((abs(x), i, j) for i, row in enumerate(left) for j, x in enumerate(row))
        if size <= _CANCELLED * largest:
            return False
        pivot = left.pop(i)
        rest = [k for k in range(len(pivot)) if k != j]
        left = [[row[k] - row[j] / pivot[j] * pivot[k] for k in rest] for row in left]
    return True


def _evaluated(matrix: sp.ImmutableMatrix, point: Point) -> mpmath.matrix:
    return CONTEXT.matrix([[evaluate(entry, point) for entry in row] for row in matrix.tolist()])


def _at(part: sp.Basic, point: Point) -> str:
    """Return the place, of the symbols that the part depends on."""
    used = [symbol for symbol in point if symbol in part.free_symbols]
    return "at " + ", ".join(f"{symbol.name} = {_short(point[symbol])}" for symbol in used)


def _short(value: mpmath.mpf) -> str:
    return str(mp.nstr(value, 4)).removesuffix(".0")


def _parameter_values(parameters: Sequence[Parameter]) -> Iterator[Point]:
    """Values of all parameters: the defaults, and for the rest values that agree with what is assumed."""
    source = random.Random(1)  # noqa: S311 - sample points, the same at every run
    free = [p for p in parameters if p.value is None]
    for trial in range(_ATTEMPTS if free else 1):
        values = {p.symbol: evaluate(p.value, {}) for p in parameters if p.value is not None}
        for p in free:
            size = CONTEXT.mpf(source.randint(3, 29)) / (1 if p.assume == "integer" else 7)
            either = trial > 0 and p.assume in ("real", "nonzero", "integer") and source.random() < 0.5
            values[p.symbol] = -size if p.assume == "negative" or either else size
        yield values


def sample_points(coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]) -> Iterator[Point]:
    """Points inside the domain; parameters at their default values, or at others that agree with their assumptions.

    Args:
        coordinates, parameters: as declared.

    Returns:
        Symbol → number, one table a point.
    """
    for _, values in zip(range(_TRIALS), _parameter_values(parameters)):
        yield from _points(coordinates, values)


def _points(coordinates: Sequence[Coordinate], values: Point) -> list[Point]:
    """Return points inside the domain; none where it is empty for these values."""
    source = random.Random(2)  # noqa: S311 - sample points, the same at every run
    try:
        ranges = [end_values(c.domain, values) for c in coordinates]
    except NoValueError:
        return []
    if any(low is not None and high is not None and low >= high for low, high in ranges):
        return []
    symbols = [c.symbol for c in coordinates]
    return [{**values, **dict(zip(symbols, (_place(*ends, source) for ends in ranges)))} for _ in range(_POINTS)]


def end_values(domain: Domain, values: Point) -> tuple[mpmath.mpf | None, mpmath.mpf | None]:
    """Return the ends of the domain, ∓π for an angle, None for an end at infinity.

    Args:
        values: of the parameters that its ends hold, by symbol.

    Returns:
        Lower end, upper end.

    Raises:
        NoValueError: an end is not a finite real number.
    """
    if domain.kind == "angle":
        return -CONTEXT.pi, +CONTEXT.pi
    lower, upper = domain.lower, domain.upper
    return None if lower is None else evaluate(lower, values), None if upper is None else evaluate(upper, values)


def _place(low: mpmath.mpf | None, high: mpmath.mpf | None, source: random.Random) -> mpmath.mpf:
    """Return a point between the ends; beyond one end, or on the line, at distances from 1/500 to 50."""
    if low is not None and high is not None:
        return low + (high - low) * source.randint(1, 996) / 997
    distance = CONTEXT.mpf(source.randint(2, 499)) / 97 * source.choice((1, 1, 1, 10)) / source.choice((1, 1, 1, 10))
    if low is None and high is None:
        return distance * source.choice((-1, 1))
    return low + distance if low is not None else high - distance
