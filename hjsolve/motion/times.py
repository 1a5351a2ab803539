"""Arrays of times and places as users give them: numbers of any kind, in any shape."""

from __future__ import annotations

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from hjsolve.arguments import described
from hjsolve.arithmetic.number_types import Counts, Integers, Reals
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.read import number
from hjsolve.motion.initial_data import InBits, to_bits
from hjsolve.units.libraries import library_of


def grid(values: object, source: str) -> NDArray[np.generic]:
    """Return numbers as an array; what they are is not looked at yet.

    Args:
        values: a number, or a list or array of numbers, nested to any depth.
        source: the name of the argument.

    Raises:
        InvalidInputError: rows of different lengths, a masked array, or something else that is not an array.
    """
    if isinstance(values, np.ma.MaskedArray):
        raise InvalidInputError(f"{source}: is masked; leave out what is masked, with {source}.compressed()")
    if isinstance(values, str | bytes):
        return np.array(values, dtype=object)
    if isinstance(values, dict | set | frozenset) or hasattr(values, "__next__"):
        raise InvalidInputError(f"{source}: a number or an array of numbers is needed, not {described(values)}")
    if (library := library_of(values)) is not None:
        raise InvalidInputError(f'{source}: has a unit; motion.to_units("{library.name}").at(t) takes such times')
    try:
        return np.asarray(values)
    except (ValueError, TypeError, OverflowError) as error:
        raise InvalidInputError(
            f"{source}: a number or an array of numbers is needed; the rows of this one have different lengths"
        ) from error


def exact_numbers(values: object, source: str) -> tuple[tuple[int, ...], list[sp.Expr]]:
    """Return the shape of an array of numbers and each of them exact, in order.

    Args:
        values: a number or an array of numbers.
        source: what they are called in errors.

    Raises:
        InvalidInputError: no array, or something in it that is not a finite real number.
    """
    array = grid(values, source)
    return array.shape, [number(x.item() if hasattr(x, "item") else x, source=source) for x in array.ravel()]


def read_times(t: object) -> tuple[tuple[int, ...] | None, Reals | None, list[InBits]]:
    """Return shape (None for a scalar), a float array where all times are finite floats, and exact rules otherwise.

    Args:
        t: a time or an array of times.
    """
    array = grid(t, "t")
    shape = None if array.ndim == 0 else array.shape
    if array.dtype.kind == "f" and array.dtype.itemsize <= 8 and np.isfinite(array).all():
        return shape, np.ascontiguousarray(array.ravel(), dtype=float), []
    return shape, None, [to_bits(x) for x in exact_numbers(array, "t")[1]]


LONGEST = 1e290  # Dekker's products hold below about 10²⁹²
MOST_TURNS = 2.0**60
"""Of an angle, and cycles of a coordinate: beyond, two doubles do not tell a phase."""


def whole_numbers(whole: Counts) -> Integers:
    """Whole turns as integers.

    Args:
        whole: turns, an array of floats or of numbers of many digits.

    Raises:
        InvalidInputError: more than can be distinguished.
    """
    sizes = np.abs(whole.astype(float))
    if sizes.size and not np.max(sizes) < MOST_TURNS:
        raise InvalidInputError(
            "t: more than 2**60 turns or cycles after t0; take a time nearer to t0, or a later t0 with its own q and p"
        )
    return whole.astype(int)


def within_doubles(time: tuple[Reals, Reals]) -> tuple[Reals, Reals]:
    """Return times relative to t₀ as two doubles, once they and their products are finite.

    Args:
        time: t − t₀ as two doubles, shape (m,).

    Raises:
        InvalidInputError: one is too long.
    """
    if not np.all(np.abs(time[0]) < LONGEST):
        raise InvalidInputError(f"t: a time beyond {LONGEST:.0e} after t0; write times in another unit")
    return time
