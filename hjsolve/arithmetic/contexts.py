"""Contexts of mpmath for the numeric rooms: one for each precision, the same in every thread."""

from __future__ import annotations

from hjsolve import precision
from hjsolve.arithmetic.number_types import Context, Elementwise


def multiprecision(bits: int) -> Context:
    """Return an mpmath context of its own with this precision, so that no global is touched.

    Args:
        bits: binary digits.
    """
    context: Context = precision.multiprecision(bits)
    return context


def context_of(x: Elementwise) -> Context | None:
    """Return where a number of many digits is computed with; None of doubles and arrays of them.

    Args:
        x: one number of any plain arithmetic, or an array of doubles.
    """
    return getattr(x, "context", None)
