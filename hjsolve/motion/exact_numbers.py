"""Exact numbers: any number of their digits, their signs, and whether they are zero.

A ``value`` is an exact number of sympy.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import sympy as sp

from hjsolve.arithmetic.floats import Multi, multiprecision
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.lowering import lower

ZERO_BITS = 2048
"""Digits with which it is decided whether a number is zero."""
_SHORT, _MOST_TERMS = 12, 400
"""Terms up to which a number is short, and up to which it is multiplied out."""
_FACTORED_BITS = 256
"""Binary digits of all integers of a number together up to which sympy, which factors them, is asked for a zero."""
_BITS_OF_SEPARATION = 4
"""Digits of precision for each digit of the integers: a + b √n ≠ 0 is not smaller than 1/(|a| + |b| √n)."""


class InBits:
    """An exact number as a rule: binary digits asked ↦ its value; made by ``to_bits``, and pickled as the number."""

    __slots__ = ("_known", "_tape", "value")

    def __init__(self, value: sp.Expr):
        self.value, self._known = value, dict[int, Mpf]()
        self._tape = None if value.is_Rational else lower([value], [])

    def __call__(self, bits: int) -> Mpf:
        """Return the number, to (about) so many bits."""
        if bits not in self._known:
            # what mild cancellation takes; whether a formula loses more is for ``_agreed`` to say
            more = Multi(bits + 64)
            if self._tape is None:
                exact = more.rational(int(self.value.p), int(self.value.q))
            else:
                exact = self._tape.run(more, [])[0]
            self._known[bits] = multiprecision(bits).convert(exact)
        return self._known[bits]

    def __reduce__(self) -> tuple[Callable[[sp.Expr], InBits], tuple[sp.Expr]]:
        return to_bits, (self.value,)


def to_bits(value: sp.Expr) -> InBits:
    """Return a rule that gives an exact number to any binary precision."""
    return InBits(value)


def number_is_zero(value: sp.Expr) -> bool:
    """Decide whether an exact number is zero.

    A long one that two precisions agree on is not; else by sympy's own rules, which take their time, or to 2048 bits
    (more for long integers): it is zero where it is that small against its largest term, or where two precisions find
    nothing but rounding.
    """
    if value.is_Rational:
        return bool(value == 0)
    # sympy's is_zero multiplies out and factors integers: minutes for those of hundreds of digits
    length = sum(abs(n.p).bit_length() + n.q.bit_length() for n in value.atoms(sp.Rational))
    short = _terms(value) <= _SHORT and length <= _FACTORED_BITS
    # two precisions that agree in 64 bits of a number that is not 0 have seen the number, not its rounding
    if not short and _agreed(value, 128):
        return False
    known = value.is_zero if length <= _FACTORED_BITS else None
    if known is not None:
        return bool(known)
    if value.is_Mul:
        return any(number_is_zero(factor) for factor in value.args)
    if value.is_Pow and value.exp.is_positive:
        return number_is_zero(value.base)
    # a bound on how near to 0 an algebraic number may be grows with the length of its integers
    bits = max(ZERO_BITS, _BITS_OF_SEPARATION * length)
    # rounding is that of the largest term, however much of it cancels
    size = max(abs(to_bits(term)(64)) for term in sp.Add.make_args(value))
    tiny = abs(to_bits(value)(bits)) <= size * multiprecision(64).mpf(2) ** (64 - bits)
    return bool(tiny or not _agreed(value, bits // 2))


def _agreed(value: sp.Expr, bits: int) -> bool:
    """Return True where a number is the same, and not zero, at a precision and at twice as much."""
    near, far = (to_bits(value)(b) for b in (bits, 2 * bits))
    return bool(far and abs(near - far) <= abs(far) * multiprecision(64).mpf(2) ** -64)


def expanded(value: sp.Expr) -> sp.Expr:
    """Multiply an exact number out where that leaves it short; what is left as it is, is only worked out in digits."""
    if value.is_Rational:
        return value
    return sp.expand(value) if _terms(value) <= _MOST_TERMS else value


def _terms(value: sp.Expr) -> int:
    """At least as many terms as the number multiplied out, counted up to a little beyond ``_MOST_TERMS``."""
    if value.is_Add:
        return min(_MOST_TERMS + 1, sum(_terms(part) for part in value.args))
    if value.is_Mul:
        return min(_MOST_TERMS + 1, math.prod(_terms(part) for part in value.args))
    if value.is_Pow:
        power = int(abs(value.exp)) if value.exp.is_Integer else 1
        return min(_MOST_TERMS + 1, _terms(value.base) ** min(power, 64))
    return 1


def sign(value: sp.Expr) -> int:
    """Return −1, 0 or 1.

    Args:
        value: exact real number of sympy.
    """
    if value.is_Rational:
        return (value.p > 0) - (value.p < 0)
    if number_is_zero(value):
        return 0
    return 1 if to_bits(value)(ZERO_BITS) > 0 else -1
