"""How kernels are compiled: by numba once per installation, or not at all, the same text run as plain Python.

A kernel works on arrays and bundles of arrays that come in; it allocates nothing and raises nothing. Plain Python runs
it without numba (extra ``fast``), and where ``NUMBA_DISABLE_JIT=1`` or ``HJSOLVE_COMPILED=0`` asks for it. Machine code
stays on disk (``kept_code.py``).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., object])

PLAIN: dict[str, Any] = {"error_model": "numpy", "nogil": True, "_nrt": False}
"""Without numba's memory: views of arrays are not counted, which would take as long as the arithmetic."""


@cache
def available() -> bool:
    """Tell whether kernels are compiled."""
    if os.environ.get("HJSOLVE_COMPILED") == "0":
        return False
    try:
        import numba
    except ImportError:  # not installed, or not for this version of numpy
        return False
    settings: Any = numba.config
    return not settings.DISABLE_JIT


def kernel(function: F) -> F:
    """Compile a function that Python calls, when it is first called; its machine code is kept on disk.

    Args:
        function: over arrays and bundles of arrays.
    """
    if not available():
        return function
    from hjsolve.arithmetic.machine import bundles
    from hjsolve.arithmetic.machine.kept_code import keep

    within = _compiled_within(function, fastmath={"contract"}, forceinline=True)
    by_address: Any = bundles.by_address

    def entered(*arguments: object) -> None:
        within(*by_address(arguments))

    entered.__name__, entered.__qualname__ = function.__name__, function.__qualname__
    made: Any = _compiled_alone(entered, fastmath={"contract"})
    keep(made, function)
    kept: F = made
    return kept


def inlined(function: F) -> F:
    """Compile a helper into the kernels that call it.

    Args:
        function: over numbers, arrays and bundles of arrays.
    """
    return _compiled_within(function, fastmath={"contract"}, forceinline=True)


def of_numbers(function: F) -> F:
    """Compile an elementary function into the kernels that call it.

    Args:
        function: over numbers.
    """
    return _compiled_alone(function, fastmath={"contract"}, forceinline=True)


def helper(function: F) -> F:
    """Compile a function that kernels call and do not contain: what is large and called a few times an orbit.

    What is inlined is optimised again at every place, and at every level above it: that took most of the time. Bundles
    of arrays come by address (``bundles.py``). Whatever is not said here numba takes from the function that calls.

    Args:
        function: over numbers, arrays and bundles of arrays.
    """
    return _compiled_within(function, fastmath={"contract"}, forceinline=False)


def reducing(function: F) -> F:
    """Compile a helper whose sums may be taken in the order that suits vector instructions.

    Args:
        function: over numbers and arrays.
    """
    return _compiled_within(function, fastmath={"contract", "reassoc"}, forceinline=False)


def exactly(function: F) -> F:
    """Compile a helper in which nothing is contracted or reordered: error-free transformations.

    Args:
        function: over numbers.
    """
    return _compiled_alone(function, forceinline=True)


def _compiled_within(function: F, **options: Any) -> F:
    """Let kernels contain or call a function; Python runs it as it stands.

    No code is made that takes apart what comes from Python: for bundles of arrays it took a quarter of all time.
    """
    if not available():
        return function
    from numba.extending import register_jitable

    kept: F = register_jitable(**PLAIN, **options, no_cfunc_wrapper=True)(function)
    return kept


def _compiled_alone(function: F, **options: Any) -> F:
    """Compile a function once for all that call it, whatever their own options, and for Python too."""
    if not available():
        return function
    import numba

    njit: Any = numba.njit
    kept: F = njit(**PLAIN, **options, no_cfunc_wrapper=True)(function)
    return kept
