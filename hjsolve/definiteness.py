"""Is T positive definite on the domain? Proved from the symbols where sympy can, else tried at many points."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence

import mpmath
import sympy as sp

from hjsolve.declarations import Coordinate, Parameter
from hjsolve.domains import Domain
from hjsolve.errors import InvalidSystemError

_POINTS = 16
_TRIALS = 6
_ATTEMPTS = 200
_DIGITS = 80
_CANCELLED = sp.Float("1e-70")
Point = Mapping[sp.Symbol, sp.Expr]


def check_mass_matrix(
    matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate], parameters: Sequence[Parameter], signature: str
) -> None:
    """Refuse a mass matrix that is singular, or not positive definite where it must be.

    A diagonal matrix whose entries sympy proves positive passes at once. Otherwise the leading principal minors are
    computed at points inside the domain, with the parameters' values. Where parameters have none, values that agree
    with their assumptions are tried: the matrix passes if some values make it positive definite at every point, for
    it is checked again when values are given.

    Raises:
        InvalidSystemError: with the minor, its value and the point.
    """
    diagonal = matrix.is_diagonal()
    if signature == "definite" and diagonal and all(matrix[i, i].is_positive for i in range(matrix.rows)):
        return
    faults = []
    for values in _parameter_values(parameters):
        points = list(_points(coordinates, values))
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


def _degeneracy(matrix: sp.ImmutableMatrix, points: Sequence[Point]) -> str:
    if any(_is_regular(matrix, point) for point in points):
        return ""
    return "T is degenerate: the determinant of its matrix is zero, so that the momenta do not give the velocities"


def _fault(matrix: sp.ImmutableMatrix, coordinates: Sequence[Coordinate], points: Sequence[Point]) -> str:
    """What keeps the matrix from being positive definite at one of the points, or nothing."""
    for point in points:
        entries = _evaluated(matrix, point)
        if entries is None:
            return f"T is not real {_at(point)}; narrow the domain"
        for k, pivot in enumerate(_pivots(entries)):
            if pivot <= 0:
                names = [c.velocity.name for c in coordinates[: k + 1]]
                minor = entries[: k + 1, : k + 1].det() if pivot else pivot
                what = f"the leading minor of {', '.join(names)}"
                if matrix[k, :k].is_zero_matrix:
                    what, minor = f"the coefficient of {names[-1]}**2/2, {matrix[k, k]},", entries[k, k]
                return (
                    f"T must be positive definite: {what} is {_short(minor)} {_at(point)}; "
                    'correct T, the values or the domain (signature="indefinite" allows it)'
                )
    return ""


def _pivots(entries: sp.Matrix) -> Iterator[sp.Expr]:
    """D of M = L D Lᵀ: quotients of successive leading principal minors; exact 0 for what has cancelled."""
    work = entries.copy()
    for k in range(work.rows):
        pivot = work[k, k] if abs(work[k, k]) > _CANCELLED * abs(entries[k, k]) else sp.S.Zero
        yield pivot
        if pivot == 0:
            return
        for i in range(k + 1, work.rows):
            ratio = work[i, k] / pivot
            for j in range(k + 1, work.rows):
                work[i, j] -= ratio * work[k, j]


def _is_regular(matrix: sp.ImmutableMatrix, point: Point) -> bool:
    entries = _evaluated(matrix, point)
    if entries is None:
        return False
    scale = sp.Mul(*(max(abs(x) for x in entries[i, :]) for i in range(entries.rows)))
    return bool(abs(entries.det()) > _CANCELLED * scale)


def _evaluated(matrix: sp.ImmutableMatrix, point: Point) -> sp.Matrix | None:
    """The matrix at the point, 80 digits; None where an entry is not a finite real number there."""
    entries = matrix.applyfunc(lambda entry: entry.evalf(_DIGITS, subs=point)).as_mutable()
    return entries if all(x.is_number and x.is_real and x.is_finite for x in entries) else None


def _at(point: Point) -> str:
    return "at " + ", ".join(f"{symbol.name} = {_short(value)}" for symbol, value in point.items())


def _short(value: sp.Expr) -> str:
    return mpmath.nstr(mpmath.mpmathify(value.evalf(15)), 4)


def _parameter_values(parameters: Sequence[Parameter]) -> Iterator[dict[sp.Symbol, sp.Expr]]:
    """Values of all parameters: the defaults, and for the rest values that agree with what is assumed."""
    source = random.Random(1)  # noqa: S311 - sample points, the same at every run
    free = [p for p in parameters if p.value is None]
    for trial in range(_ATTEMPTS if free else 1):
        values = {p.symbol: p.value for p in parameters if p.value is not None}
        for p in free:
            size = sp.Rational(source.randint(3, 29), 7)
            either = trial > 0 and p.assume in ("real", "nonzero") and source.random() < 0.5
            values[p.symbol] = -size if p.assume == "negative" or either else size
        yield values


def _points(coordinates: Sequence[Coordinate], values: dict[sp.Symbol, sp.Expr]) -> Iterator[Point]:
    """Points inside the domain, or none where it is empty for these values."""
    source = random.Random(2)  # noqa: S311 - sample points, the same at every run
    ranges = [_range(c.domain, values) for c in coordinates]
    if any(low is not None and high is not None and low >= high for low, high in ranges):
        return
    for _ in range(_POINTS):
        places = {c.symbol: _place(low, high, source) for c, (low, high) in zip(coordinates, ranges)}
        yield {**values, **places}


def _range(domain: Domain, values: dict[sp.Symbol, sp.Expr]) -> tuple[sp.Rational | None, sp.Rational | None]:
    if domain.kind == "angle":
        return sp.Rational(-22, 7), sp.Rational(22, 7)
    low, high = (None if end is None else _rational(end, values) for end in (domain.lower, domain.upper))
    return low, high


def _rational(end: sp.Expr, values: dict[sp.Symbol, sp.Expr]) -> sp.Rational:
    return sp.Rational(end.evalf(30, subs=values))


def _place(low: sp.Rational | None, high: sp.Rational | None, source: random.Random) -> sp.Rational:
    """A point between the ends; beyond one end, or on the line, at distances from 1/50 to 50."""
    if low is not None and high is not None:
        return low + (high - low) * sp.Rational(source.randint(1, 996), 997)
    distance = sp.Rational(source.randint(2, 499), 97) * sp.Rational(source.choice((1, 1, 1, 10, sp.Rational(1, 10))))
    if low is None and high is None:
        return distance * source.choice((-1, 1))
    return low + distance if low is not None else high - distance
