"""The functions of ``double_double``, compiled for the lanes of the machine, with fused products."""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any

from hjsolve.arithmetic import double_double
from hjsolve.arithmetic.machine import elementary
from hjsolve.arithmetic.machine.compiling import available, exactly
from hjsolve.arithmetic.machine.intrinsics import fma


@exactly
def chosen(condition: bool, one: float, other: float) -> float:
    """Return one of two numbers."""
    return one if condition else other


@exactly
def two_product(a: float, b: float) -> tuple[float, float]:
    """Return a·b exactly.

    Args:
        a, b: doubles.
    """
    p = a * b
    return p, fma(a, b, -p)


def _compiled() -> dict[str, Callable[..., Any]]:
    """Return the functions of ``double_double`` by name, with the words of the machine for its globals."""
    own = {name: f for name, f in vars(elementary).items() if callable(f) and hasattr(double_double, name)}
    words: dict[str, Any] = {**vars(double_double), **own, "chosen": chosen, "two_product": two_product}
    for name, text in vars(double_double).items():
        if isinstance(text, FunctionType) and words[name] is text:
            words[name] = exactly(FunctionType(text.__code__, words, name))
    return words


FUNCTIONS: dict[str, Callable[..., Any]] = _compiled() if available() else vars(double_double)
"""By name; numpy's where plain Python runs the machine."""
