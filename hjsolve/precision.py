"""Numbers of many digits whose precision belongs to one thread, and the lock around what has one for all threads.

mpmath keeps its working precision in a context. Its global context (``mpmath.mp``) is shared by every thread of the
process and belongs to the user, so hjsolve neither uses nor changes it; a test of the architecture forbids it by name.
Two kinds of contexts take its place:

- ``mp``: the context of the symbolic rooms. Its precision is raised for a block (``with mp.workdps(50):``), and every
  thread has its own.
- ``multiprecision(bits)``: contexts of one fixed precision, whose numbers are shared by threads and can be pickled.

sympy evaluates through the global context, numbers its dummies with one counter and notes half-finished assumptions on
shared symbols; python-flint has one precision for the process. ``shared_libraries`` is the one lock around both.
"""

from __future__ import annotations

import copyreg
import functools
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar

import mpmath
from mpmath import libmp
from mpmath.ctx_mp import MPContext

_P = ParamSpec("_P")
_R = TypeVar("_R")
_DOUBLE = 53
_WARM = 4096
"""Binary digits to which π, e and logarithms are computed at once: libmp extends its stored values without a lock."""


# ------------------------------------------------------------------------------------------------ one lock
shared_libraries = threading.RLock()
"""Held while sympy or python-flint compute: both keep their precision in one variable of the process."""


def one_at_a_time(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Let one thread at a time run a function that computes with sympy; a call inside such a call is not held up.

    Nothing is lost by it: Python runs one thread of pure Python code at a time anyway.

    Args:
        function: a public one. It may not wait for another thread that computes with sympy.
    """

    @functools.wraps(function)
    def alone(*args: _P.args, **named: _P.kwargs) -> _R:
        with shared_libraries:
            return function(*args, **named)

    return alone


def _released() -> None:
    """Give a forked process a lock that no thread of its parent holds."""
    shared_libraries._at_fork_reinit()  # type: ignore[attr-defined]


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_released)


# ------------------------------------------------------------------------------------------------ a thread's precision
class _Precision(threading.local):
    """Working precision and rounding of the present thread, in the place of mpmath's list of the two."""

    def __init__(self) -> None:
        self.pair: list[int | str] = [_DOUBLE, libmp.round_nearest]
        self.dps = 15

    def __iter__(self) -> Iterator[int | str]:
        return iter(self.pair)

    def __getitem__(self, k: int) -> int | str:
        return self.pair[k]

    def __setitem__(self, k: int, value: int | str) -> None:
        self.pair[k] = value


class ThreadContext(MPContext):
    """A context whose precision is raised and restored for the present thread alone."""

    def __init__(self) -> None:
        self._state = _Precision()
        super().__init__()

    @property
    def _prec_rounding(self) -> _Precision:
        return self._state

    @_prec_rounding.setter
    def _prec_rounding(self, pair: list[int | str]) -> None:
        self._state.pair[:] = pair

    @property
    def _prec(self) -> int:
        return int(self._state.pair[0])

    @_prec.setter
    def _prec(self, bits: int) -> None:
        self._state.pair[0] = bits

    @property
    def _dps(self) -> int:
        return self._state.dps

    @_dps.setter
    def _dps(self, digits: int) -> None:
        self._state.dps = digits


# ------------------------------------------------------------------------------------------------ fixed precisions
class FixedContext(MPContext):
    """A context whose precision never changes.

    mpmath's special functions raise the precision of their context while they run, which another thread would notice
    in the numbers that it shares. Here they run in ``mp`` at the same precision, and the result comes back as a number
    of this context.
    """

    def __init__(self, bits: int) -> None:
        super().__init__()
        self._prec = self._prec_rounding[0] = bits
        self._dps = libmp.prec_to_dps(bits)

    @property
    def prec(self) -> int:
        """Binary digits."""
        return int(self._prec)

    @prec.setter
    def prec(self, bits: int) -> None:
        raise AttributeError(f"the precision of this context is fixed to {self._prec} bits; {bits} were asked")

    @property
    def dps(self) -> int:
        """Decimal digits."""
        return int(self._dps)

    @dps.setter
    def dps(self, digits: int) -> None:
        self.prec = libmp.dps_to_prec(digits)

    @classmethod
    def _wrap_specfun(cls, name: str, f: Callable[..., object], wrap: bool) -> None:  # noqa: ARG003 - mpmath's signature
        if name not in cls.__dict__:  # it is called again for every context that is made
            setattr(cls, name, _elsewhere(name))

    def log(self, x: object, b: object = None) -> mpmath.mpf:
        """Return the logarithm; the natural one raises no precision.

        Args:
            b: the base; None for e.
        """
        return self.ln(x) if b is None else _in_own_context(self, "log", (x, b), {})

    def fprod(self, factors: Iterable[object]) -> mpmath.mpf:
        """Return a product; mpmath's own writes the precision back that it never changed."""
        product = self.one
        for factor in factors:
            product *= factor
        return +product


def _elsewhere(name: str) -> Callable[..., object]:
    def function(context: FixedContext, *args: object, **named: object) -> object:
        return _in_own_context(context, name, args, named)

    function.__name__ = name
    return function


_RAISING = (
    "chebyfit", "cholesky_solve", "det", "diff", "diffs", "expm", "findroot", "inverse", "logm", "lu_solve", "nprod",
    "nsum", "odefun", "polyroots", "powm", "qr", "qr_solve", "quad", "quadsubdiv", "sqrtm", "sumap", "sumem", "taylor",
)  # fmt: skip
"""The methods, apart from special functions, that raise the precision of their context (mpmath 1.3)."""
for _name in _RAISING:
    setattr(FixedContext, _name, _elsewhere(_name))


def _in_own_context(context: FixedContext, name: str, args: tuple[object, ...], named: dict[str, object]) -> object:
    with mp.workprec(context.prec):
        return _moved(getattr(mp, name)(*(_moved(a, mp, context) for a in args), **named), context, mp)


def _moved(x: object, to: MPContext, home: MPContext) -> object:
    """Return a number, matrix, sequence or function of numbers of one context as that of another."""
    if hasattr(x, "_mpf_") or hasattr(x, "_mpc_"):
        return to.convert(x)
    if isinstance(x, list | tuple):
        return type(x)(_moved(part, to, home) for part in x)
    if isinstance(x, home.matrix):
        return to.matrix([[_moved(part, to, home) for part in row] for row in x.tolist()])
    if callable(x):
        return lambda *args: _moved(x(*(_moved(a, home, to) for a in args)), to, home)
    return x


# ------------------------------------------------------------------------------------------------ the contexts
mp = ThreadContext()
"""The context of the symbolic rooms: 53 bits in every thread, until it says ``with mp.workdps(…):``."""

for _constant in (libmp.pi_fixed, libmp.e_fixed, libmp.ln2_fixed, libmp.ln10_fixed):
    _constant(_WARM)

NUMBERS: dict[str, Any] = {n: getattr(mp, n) for n in dir(mp) if not n.startswith("_")}
"""What ``mp`` offers, by name."""

NAMES: list[dict[str, object] | str] = [NUMBERS, "mpmath"]
"""The ``modules`` of ``sympy.lambdify`` for functions of ``mp`` numbers."""

_made: dict[int, FixedContext] = {}
_making = threading.Lock()


def multiprecision(bits: int) -> FixedContext:
    """Return the mpmath context of one fixed precision; the same one in every thread."""
    context = _made.get(bits)
    if context is None:
        with _making:
            context = _made.get(bits) or FixedContext(bits)
            for kind in (context.mpf, context.mpc):  # classes of their own, which pickle does not find by their names
                copyreg.pickle(kind, _reduced)
            copyreg.pickle(context.matrix, _reduced_matrix)
            _made[bits] = context
    return context


@contextmanager
def users_precision() -> Iterator[None]:
    """Compute at the precision that the user has set in ``mpmath.mp``, which is read here and nowhere else."""
    with mp.workprec(mpmath.mp.prec):
        yield


def for_the_user(x: object) -> Any:
    """Return a number of ``mp``, or a tuple of such numbers, as numbers of the user's ``mpmath.mp``.

    Args:
        x: what a function of the user's numbers has as its value.
    """
    return tuple(map(for_the_user, x)) if isinstance(x, tuple) else mpmath.mp.convert(x)


def for_any_context(function: Callable[..., _R]) -> Callable[..., _R]:
    """Let a function of ``mp`` numbers take the user's as well, at the user's precision.

    Args:
        function: of numbers of ``mp``, at its present precision.
    """

    @functools.wraps(function)
    def of_numbers(*numbers: Any) -> Any:
        if any(getattr(x, "context", None) is mp for x in numbers):
            return function(*numbers)
        with users_precision():
            return for_the_user(function(*map(mp.convert, numbers)))

    return of_numbers


# ------------------------------------------------------------------------------------------------ pickling
def _reduced(x: mpmath.mpf | mpmath.mpc) -> tuple[Callable[..., object], tuple[object, ...]]:
    """Return what a number is pickled as: the precision of its context, None of ``mp``, and its parts."""
    parts = (x._mpf_,) if hasattr(x, "_mpf_") else x._mpc_
    return _restored, (_bits(x.context), *(tuple(int(part) for part in number) for number in parts))


def _reduced_matrix(matrix: mpmath.matrix) -> tuple[Callable[..., object], tuple[int | None, list[list[mpmath.mpf]]]]:
    return _restored_matrix, (_bits(matrix.ctx), matrix.tolist())


def _bits(context: MPContext) -> int | None:
    return None if context is mp else int(context.prec)


def _home(bits: int | None) -> MPContext:
    return mp if bits is None else multiprecision(bits)


def _restored_matrix(bits: int | None, rows: list[list[mpmath.mpf]]) -> mpmath.matrix:
    return _home(bits).matrix(rows)


def _restored(bits: int | None, *parts: tuple[int, ...]) -> mpmath.mpf | mpmath.mpc:
    context = _home(bits)
    numbers = tuple((sign, libmp.MPZ(whole), exponent, count) for sign, whole, exponent, count in parts)
    return context.make_mpf(numbers[0]) if len(parts) == 1 else context.make_mpc(numbers)


for _kind in (mp.mpf, mp.mpc):
    copyreg.pickle(_kind, _reduced)
copyreg.pickle(mp.matrix, _reduced_matrix)
