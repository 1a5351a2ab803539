"""Sparse polynomials with integer coefficients in a growing list of generators.

A polynomial is a ``dict`` from a packed monomial to a non-zero ``int``. A monomial is one Python integer with 32 bits
per generator (generator k in bits 32k … 32k+31, the highest one always clear), so that multiplying monomials is
adding integers and a new generator can join at any time. This is several times faster than polynomials over a fixed
ring and, unlike calls into sympy, it can be stopped: every product is counted against a ``Budget``. Exponents run
up to MAX_DEGREE, which powers observe: products of up to 128 such factors have room.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import gcd

from hjsolve.errors import HJSolveError

BITS = 32
FIELD = (1 << BITS) - 1
MAX_DEGREE = 1 << (BITS - 8)

Poly = dict[int, int]


class WorkLimitError(HJSolveError, ArithmeticError):
    """An exact computation was given up because it outgrew its budget; the answer is unknown, not negative."""


@dataclass
class Budget:
    """What an exact computation may cost: seconds until a deadline and terms in one product.

    A user's seconds are those of the clock on the wall. Limits of our own are processor time of the thread, so that
    other threads and other programs do not change what is decided.

    Attributes:
        deadline: value of ``time.monotonic()`` at which work stops, or None.
        processor: value of ``time.thread_time()`` at which work stops, or None; of the thread that made the budget.
        terms: largest number of term-by-term products in one polynomial product.
    """

    deadline: float | None = None
    processor: float | None = None
    terms: int = 4_000_000
    _spent: int = field(default=0, repr=False)

    @classmethod
    def seconds(cls, seconds: float, terms: int = 4_000_000) -> Budget:
        """Make a budget that ends this many seconds from now.

        Args:
            seconds: from now on.
            terms: largest number of term-by-term products in one polynomial product.
        """
        return cls(time.monotonic() + seconds, terms=terms)

    @classmethod
    def processor_seconds(cls, seconds: float) -> Budget:
        """Make a budget of so many seconds of the processor, in the present thread, from now on."""
        return cls(processor=time.thread_time() + seconds)

    def part(self, seconds: float, terms: int) -> Budget:
        """Return a smaller budget that ends with this one at the latest.

        Args:
            seconds: of the processor, from now on.
            terms: largest number of term-by-term products in one polynomial product.
        """
        ends = (self.processor, time.thread_time() + seconds)
        return Budget(self.deadline, min(end for end in ends if end is not None), min(terms, self.terms))

    @property
    def left(self) -> float:
        """Seconds left; infinite without a deadline."""
        pairs = ((self.deadline, time.monotonic), (self.processor, time.thread_time))
        return min((end - clock() for end, clock in pairs if end is not None), default=float("inf"))

    def charge(self, work: int) -> None:
        """Count ``work`` term products.

        Raises:
            WorkLimitError: too many at once, or the deadline is past.
        """
        if work > self.terms:
            raise WorkLimitError(f"a product of polynomials needs {work} terms; {self.terms} are allowed")
        self._spent += work
        if self._spent > 20_000:
            self._spent = 0
            self.check()

    def check(self) -> None:
        """Raise ``WorkLimitError`` when the deadline is past.

        Raises:
            WorkLimitError: the deadline is past.
        """
        if self.left < 0:
            raise WorkLimitError("the time budget of the exact computation is used up")


def variable(k: int) -> Poly:
    """Return generator number k as a polynomial."""
    return {1 << (BITS * k): 1}


def constant(n: int) -> Poly:
    """Return an integer as a polynomial."""
    return {0: n} if n else {}


def exponent(monomial: int, k: int) -> int:
    """Exponent of generator k in a packed monomial."""
    return (monomial >> (BITS * k)) & FIELD


def exponents(monomial: int) -> list[tuple[int, int]]:
    """Pairs (generator, exponent) of a packed monomial, exponents positive."""
    found, k = [], 0
    while monomial:
        if e := monomial & FIELD:
            found.append((k, e))
        monomial >>= BITS
        k += 1
    return found


def add(a: Poly, b: Poly, scale: int = 1) -> Poly:
    """Return the sum a + scale·b."""
    total = dict(a)
    for m, c in b.items():
        value = total.get(m, 0) + scale * c
        if value:
            total[m] = value
        else:
            total.pop(m, None)
    return total


def scale(a: Poly, n: int) -> Poly:
    """n·a."""
    return {m: n * c for m, c in a.items()} if n else {}


def mul(a: Poly, b: Poly, budget: Budget) -> Poly:
    """a·b, charged to the budget.

    Args:
        a, b: polynomials with integer coefficients.
        budget: charged with the products.
    """
    if len(a) > len(b):
        a, b = b, a
    budget.charge(len(a) * len(b))
    if len(a) == 1:
        ((m1, c1),) = a.items()
        return {m1 + m: c1 * c for m, c in b.items()}
    total: Poly = {}
    get = total.get
    terms = list(b.items())
    for m1, c1 in a.items():
        for m2, c2 in terms:
            m = m1 + m2
            total[m] = get(m, 0) + c1 * c2
    return {m: c for m, c in total.items() if c}


def with_square(a: Poly, k: int, square: Poly, budget: Budget) -> Poly:
    """Replace every square of generator k by a polynomial, so that at most its first power is left.

    Args:
        square: what its square is.
        budget: charged with the products.
    """
    total: Poly = {}
    for m, n in a.items():
        pairs = exponent(m, k) // 2
        term: Poly = {m - ((2 * pairs) << (BITS * k)): n}
        for _ in range(pairs):
            term = mul(term, square, budget)
        total = add(total, term)
    return total


def content(a: Poly) -> int:
    """Return the greatest common divisor of the coefficients, with the sign of the leading one; 0 for zero."""
    if not a:
        return 0
    g = 0
    for c in a.values():
        g = gcd(g, c)
        if g == 1:
            break
    return g if a[max(a)] > 0 else -g


def monomial_content(a: Iterable[int]) -> int:
    """Return the greatest monomial that divides every monomial given.

    Args:
        a: packed monomials.
    """
    monomials = iter(a)
    common = next(monomials, 0)
    for m in monomials:
        if not common:
            return 0
        common = _common(common, m)
    return common


def _common(a: int, b: int) -> int:
    """Return the greatest common divisor of two packed monomials."""
    out, shift = 0, 0
    while a and b:
        out |= min(a & FIELD, b & FIELD) << shift
        a, b, shift = a >> BITS, b >> BITS, shift + BITS
    return out


def divides(a: int, b: int, guard: int) -> bool:
    """Return whether monomial a divides monomial b; guard has the top bit of every generator's field set.

    Args:
        a: a packed monomial.
        b: a packed monomial.
        guard: the mask, see ``guard_bits``.
    """
    return ((b | guard) - a) & guard == guard


def guard_bits(generators: int) -> int:
    """Return the guard mask for this many generators."""
    return sum(1 << (BITS * k + BITS - 1) for k in range(generators))


def exact_quotient(a: Poly, b: Poly, guard: int, budget: Budget) -> Poly | None:
    """a/b where b divides a exactly over the integers, else None; by a heap of leading monomials.

    Args:
        a, b: polynomials with integer coefficients.
        guard: ``guard_bits`` of as many generators as they have.
        budget: charged with the products.
    """
    lead = max(b)
    lead_c, tail = b[lead], [(m, c) for m, c in b.items() if m != lead]
    if not divides(lead, max(a), guard) or not divides(min(b), min(a), guard):
        return None
    rest, quotient = dict(a), {}
    heap = [-m for m in rest]
    heapq.heapify(heap)
    while heap:
        m = -heapq.heappop(heap)
        c = rest.pop(m, 0)
        if not c:
            continue
        if c % lead_c or not divides(lead, m, guard):
            return None
        dm, dc = m - lead, c // lead_c
        quotient[dm] = dc
        budget.charge(len(b))
        for bm, bc in tail:
            t = bm + dm
            value = rest.get(t)
            if value is None:
                rest[t] = -bc * dc
                heapq.heappush(heap, -t)
            else:
                rest[t] = value - bc * dc
    return quotient


def value_modulo(a: Poly, n: int) -> int:
    """Return the value modulo n at one fixed integer point; generator k is put to a number that depends on k only."""
    total = 0
    for m, c in a.items():
        for k, e in exponents(m):
            c = c * pow(_POINT[k % len(_POINT)] + k, e, n) % n
        total += c
    return total % n


def value(a: Poly) -> int:
    """Return the value at the same fixed integer point."""
    total = 0
    for m, c in a.items():
        for k, e in exponents(m):
            c *= (_POINT[k % len(_POINT)] + k) ** e
        total += c
    return total


_POINT = (10007, 20021, 30047, 40093, 50129, 60161, 70199, 80231, 90281, 100343)


def partial(a: Poly, k: int) -> Poly:
    """∂a/∂(generator k)."""
    unit = 1 << (BITS * k)
    return {m - unit: c * e for m, c in a.items() if (e := exponent(m, k))}


def support(a: Poly) -> int:
    """Packed monomial with a non-zero field for every generator that occurs in a."""
    seen = 0
    for m in a:
        seen |= m
    return seen


def generators(a: Poly) -> list[int]:
    """Return the indices of the generators that occur in a, ascending."""
    return [k for k, _ in exponents(support(a))]


def key(a: Poly) -> tuple[tuple[int, int], ...]:
    """Return a hashable form."""
    return tuple(sorted(a.items()))
