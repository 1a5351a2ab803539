"""Rational functions of several letters from their values modulo a prime.

The degrees in each letter alone and along a line in general position come from rational interpolation in one variable
(the extended Euclidean algorithm; von zur Gathen and Gerhard, Modern Computer Algebra, §5.8). With these degrees the
coefficients of numerator and denominator are the solution of one linear system, and rational reconstruction gives the
fractions that they are the images of (Wang, Guy, Davenport, SIGSAM Bull. 16 (1982) 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product, zip_longest
from math import isqrt
from random import Random

from hjsolve.algebra.time_limit import check_time

PRIMES = (2**127 - 1, 2**521 - 1)
"""Where one is too small for the fractions, the next is tried."""
_MOST_DEGREE, _MOST_UNKNOWNS = 16, 260

Point = tuple[int, ...]
Values = Sequence[int]
BlackBox = Callable[[Point], Values]
"""Values of some rational functions at a point, modulo the prime."""
Terms = dict[tuple[int, ...], Fraction]
"""A polynomial: exponents of the letters → coefficient."""
Fractional = tuple[Terms, Terms]
"""Numerator and denominator."""


class Interpolation:
    """The search for some rational functions.

    Attributes:
        box: their values.
        letters: how many letters there are.
        prime: p.
        seed: of the points.
    """

    def __init__(self, box: BlackBox, letters: int, prime: int, seed: int = 0):
        self.box, self.letters, self.prime = box, letters, prime
        self._dice = Random(41 + seed)  # noqa: S311
        self._seen: list[tuple[Point, Values]] = []
        self.here = self._point()

    def _point(self) -> Point:
        return tuple(self._dice.randrange(2, self.prime - 1) for _ in range(self.letters))

    def _value(self, point: Point) -> Values:
        check_time()
        return self.box(point)

    def found(self) -> list[Fractional] | None:
        """Return the functions; None where one has too many terms, or coefficients too large for the prime."""
        origin, start = self._value(self.here), self._point()
        depends = [self._depends(j, origin) for j in range(self.letters)]
        varied = [[j for j in range(self.letters) if depends[j][k]] for k in range(len(origin))]
        axes = [self._degrees(self._axis(j), depends[j], origin) for j in range(self.letters)]
        several = [len(letters) > 1 for letters in varied]
        line = [tuple((a + t * b) % self.prime for a, b in zip(self.here, start, strict=True)) for t in _LINE_STEPS]
        total = self._degrees(line, several, origin)
        if total is None or any(axis is None for axis in axes):
            return None
        result = []
        for k, letters in enumerate(varied):
            own = [axes[j][k] for j in letters]  # type: ignore[index]
            most = total[k] if several[k] else own[0] if own else (0, 0)
            top, bottom = (
                _monomials(self.letters, letters, [d[part] for d in own], most[part]) for part in (0, 1)
            )  # fmt: skip
            one = self._solved(k, top, bottom) if letters else _reconstructed([origin[k], 1], [()], [()], self.prime)
            if one is None:
                return None
            if letters:
                result.append(one)
            else:  # a number: one coefficient, or none where it is 0
                zeros = (0,) * self.letters
                result.append(({zeros: next(iter(one[0].values()))} if one[0] else {}, {zeros: Fraction(1)}))
        return result

    def _axis(self, j: int) -> list[Point]:
        return [(*self.here[:j], (self.here[j] + t) % self.prime, *self.here[j + 1 :]) for t in _LINE_STEPS]

    def _depends(self, j: int, origin: Values) -> list[bool]:
        return [a != b for a, b in zip(self._value(self._axis(j)[0]), origin, strict=True)]

    def _degrees(self, line: list[Point], wanted: list[bool], origin: Values) -> list[tuple[int, int]] | None:
        """Return the degrees of numerator and denominator along a line; None where they are too large."""
        result = [(0, 0)] * len(origin)
        left = [k for k, w in enumerate(wanted) if w]
        t, rows = [0], [origin]
        for place, step in zip(line, _LINE_STEPS, strict=True):
            if not left:
                return result
            t, rows = [*t, step], [*rows, self._value(place)]
            for k in list(left):
                degrees = _rational_degrees(t, [row[k] for row in rows], self.prime)
                if degrees is not None:
                    result[k] = degrees
                    left.remove(k)
        return None if left else result

    def _solved(self, k: int, top: list[Point], bottom: list[Point]) -> Fractional | None:
        """Solve Σ n_m θ^m = f Σ d_m θ^m for the coefficients, from one more point than is needed."""
        size, p = len(top) + len(bottom), self.prime
        if size > _MOST_UNKNOWNS:
            return None
        while len(self._seen) < size + 1:
            point = self._point()
            self._seen.append((point, self._value(point)))
        rows = []
        for point, values in self._seen[: size + 1]:
            powers = [_power(point, m, p) for m in top]
            rows.append([*powers, *(-values[k] * _power(point, m, p) % p for m in bottom)])
        kernel = _one_solution(rows, p)
        return None if kernel is None else _reconstructed(kernel, top, bottom, p)


_LINE_STEPS = tuple(range(1, 2 * _MOST_DEGREE + 4))


def _monomials(letters: int, inside: Sequence[int], own: Sequence[int], most: int) -> list[Point]:
    found = []
    for exponents in product(*(range(d + 1) for d in own)):
        if sum(exponents) <= most:
            whole = [0] * letters
            for j, e in zip(inside, exponents, strict=True):
                whole[j] = e
            found.append(tuple(whole))
    return found


def _power(point: Point, exponents: Point, p: int) -> int:
    value = 1
    for x, e in zip(point, exponents, strict=True):
        if e:
            value = value * pow(x, e, p) % p
    return value


def _rational_degrees(t: Sequence[int], values: Sequence[int], p: int) -> tuple[int, int] | None:
    """Return the degrees of the simplest rational function through some points; None where it is not overdetermined.

    Of the remainders r of the Euclidean algorithm for Π (t − tᵢ) and the interpolating polynomial, and the cofactors s
    of the latter, r/s with the least deg r + deg s is that function.
    """
    whole, through = [1], [0]
    for x, y in zip(t, values, strict=True):
        gap = (y - _at(through, x, p)) * pow(_at(whole, x, p), -1, p) % p
        through = _plus(through, whole, gap, p)
        whole = _plus([0, *whole], whole, -x, p)
    older, newer, s_old, s_new = whole, through, [0], [1]
    best = None
    while newer != [0]:
        degrees = (len(newer) - 1, len(s_new) - 1)
        if best is None or sum(degrees) < sum(best):
            best = degrees
        quotient, rest = _divided(older, newer, p)
        older, newer = newer, rest
        s_old, s_new = s_new, _minus_product(s_old, quotient, s_new, p)
    best = best or (0, 0)
    return best if sum(best) + 2 < len(t) else None


def _trimmed(a: list[int]) -> list[int]:
    while len(a) > 1 and not a[-1]:
        a.pop()
    return a


def _plus(a: Sequence[int], b: Sequence[int], factor: int, p: int) -> list[int]:
    return _trimmed([(x + factor * y) % p for x, y in zip_longest(a, b, fillvalue=0)])


def _at(a: Sequence[int], x: int, p: int) -> int:
    value = 0
    for c in reversed(a):
        value = (value * x + c) % p
    return value


def _divided(a: Sequence[int], b: Sequence[int], p: int) -> tuple[list[int], list[int]]:
    rest, lead = list(a), pow(b[-1], -1, p)
    quotient = [0] * max(len(a) - len(b) + 1, 1)
    for k in range(len(a) - len(b), -1, -1):
        c = rest[k + len(b) - 1] * lead % p
        quotient[k] = c
        for i, y in enumerate(b):
            rest[k + i] = (rest[k + i] - c * y) % p
    return _trimmed(quotient), _trimmed(rest[: max(len(b) - 1, 1)])


def _minus_product(a: Sequence[int], b: Sequence[int], c: Sequence[int], p: int) -> list[int]:
    result = [*a, *([0] * max(len(b) + len(c) - 1 - len(a), 0))]
    for i, x in enumerate(b):
        for j, y in enumerate(c):
            result[i + j] = (result[i + j] - x * y) % p
    return _trimmed(result)


def _one_solution(rows: list[list[int]], p: int) -> list[int] | None:
    """Return the solution of a homogeneous system that has exactly one but for a factor; None where it has not."""
    width = len(rows[0])
    echelon: dict[int, list[int]] = {}
    for row in rows:
        check_time()
        for column, other in echelon.items():
            if c := row[column]:
                row = [(a - c * b) % p for a, b in zip(row, other, strict=True)]
        pivot = next((k for k, a in enumerate(row) if a), None)
        if pivot is not None:
            lead = pow(row[pivot], -1, p)
            echelon[pivot] = [a * lead % p for a in row]
    free = [k for k in range(width) if k not in echelon]
    if len(free) != 1:
        return None
    solution = [0] * width
    solution[free[0]] = 1
    for pivot, row in reversed(echelon.items()):
        solution[pivot] = -sum(a * b for k, (a, b) in enumerate(zip(row, solution, strict=True)) if k != pivot) % p
    return solution


def _reconstructed(vector: list[int], top: Sequence[Point], bottom: Sequence[Point], p: int) -> Fractional | None:
    """Return the fractions whose images are the coefficients; None where they are too large."""
    lead = next((c for c in reversed(vector) if c), None)
    if lead is None:
        return None
    scale = pow(lead, -1, p)
    fractions = [_fraction(c * scale % p, p) for c in vector]
    if any(f is None for f in fractions):
        return None
    numbers = [f for f in fractions if f is not None]
    terms = list(zip((*top, *bottom), numbers, strict=True))
    n = len(top)
    return {m: c for m, c in terms[:n] if c}, {m: c for m, c in terms[n:] if c}


def _fraction(image: int, p: int) -> Fraction | None:
    """Return the fraction a/b ≡ image with |a|, b well below √p; None where there is none."""
    bound = isqrt(p) >> 12
    older, newer, s_old, s_new = p, image, 0, 1
    while newer > bound:
        q = older // newer
        older, newer, s_old, s_new = newer, older - q * newer, s_new, s_old - q * s_new
    return Fraction(newer, s_new) if abs(s_new) <= bound and s_new else None
