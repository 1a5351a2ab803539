"""Contexts of mpmath, one for each precision: numbers of them can be pickled, and no global is touched."""

from __future__ import annotations

import copyreg
from collections.abc import Callable
from functools import cache

import mpmath

from hjsolve.arithmetic.number_types import Context, Elementwise, Mpc, Mpf, MpfMatrix


@cache
def multiprecision(bits: int) -> Context:
    """Return an mpmath context of its own with this precision, so that no global is touched.

    Args:
        bits: binary digits.
    """
    context = mpmath.ctx_mp.MPContext()
    context.prec = bits
    for kind in (context.mpf, context.mpc):  # classes of their own, which pickle does not find by their names
        copyreg.pickle(kind, _reduced)
    copyreg.pickle(context.matrix, _reduced_matrix)
    return context


def context_of(x: Elementwise) -> Context | None:
    """Return where a number of many digits is computed with; None of doubles and arrays of them.

    Args:
        x: one number of any plain arithmetic, or an array of doubles.
    """
    return getattr(x, "context", None)


def _reduced(x: Mpf | Mpc) -> tuple[Callable[..., Mpf | Mpc], tuple[object, ...]]:
    """What a number of one of our contexts is pickled as: its precision and its parts."""
    parts = (x._mpf_,) if hasattr(x, "_mpf_") else x._mpc_
    return _restored, (x.context.prec, *(tuple(int(part) for part in number) for number in parts))


_Restoring = Callable[[int, list[list["Mpf"]]], "MpfMatrix"]


def _reduced_matrix(matrix: MpfMatrix) -> tuple[_Restoring, tuple[int, list[list[Mpf]]]]:
    return _restored_matrix, (matrix.ctx.prec, matrix.tolist())


def _restored_matrix(bits: int, rows: list[list[Mpf]]) -> MpfMatrix:
    matrix: MpfMatrix = multiprecision(bits).matrix(rows)
    return matrix


def _restored(bits: int, *parts: tuple[int, ...]) -> Mpf | Mpc:
    context = multiprecision(bits)
    numbers = tuple((sign, mpmath.libmp.MPZ(whole), exponent, count) for sign, whole, exponent, count in parts)
    return context.make_mpf(numbers[0]) if len(parts) == 1 else context.make_mpc(numbers)
