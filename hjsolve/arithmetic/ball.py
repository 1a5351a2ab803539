"""Ball arithmetic (Arb, through the extra ``certified``): every value a ball that contains the truth.

Turning points are proved in ``certified.ball_radicand`` and ``certified.proved_turning_points``, integrals in
``certified.strip_bound`` and ``certified.arb_integral``.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from hjsolve.arithmetic.floats import ByOperators
from hjsolve.arithmetic.jet import Jet, Jets
from hjsolve.arithmetic.number_types import Mpf
from hjsolve.errors import MissingExtraError
from hjsolve.precision import shared_libraries

try:
    import flint as flint
except ImportError:  # pragma: no cover - the extra is part of the test installation
    flint = None  # type: ignore[assignment]


Operand = Any
"""What arithmetic of balls takes: python-flint lists its own types of numbers for each kind of ball by itself."""


class Ball(Protocol):
    """A real or a complex ball: what ``flint.arb`` and ``flint.acb`` have in common."""

    @property
    def real(self) -> flint.arb: ...
    @property
    def imag(self) -> flint.arb: ...
    def __add__(self, other: Operand, /) -> Ball: ...
    def __radd__(self, other: Operand, /) -> Ball: ...
    def __sub__(self, other: Operand, /) -> Ball: ...
    def __rsub__(self, other: Operand, /) -> Ball: ...
    def __mul__(self, other: Operand, /) -> Ball: ...
    def __rmul__(self, other: Operand, /) -> Ball: ...
    def __truediv__(self, other: Operand, /) -> Ball: ...
    def __rtruediv__(self, other: Operand, /) -> Ball: ...
    def __pow__(self, exponent: Operand, /) -> Ball: ...
    def __neg__(self) -> Ball: ...
    def __abs__(self) -> flint.arb: ...
    def mid(self) -> Ball: ...
    def rad(self) -> flint.arb: ...
    def sqrt(self) -> Ball: ...
    def sin_cos(self) -> tuple[Ball, Ball]: ...
    def sinh_cosh(self) -> tuple[Ball, Ball]: ...
    def is_finite(self) -> bool: ...
    def contains(self, other: Operand, /) -> bool: ...
    def rel_accuracy_bits(self) -> int: ...


if TYPE_CHECKING:
    PowerSeries = flint.arb_series | flint.acb_series
    """A power series with real or complex balls as coefficients."""

_IN_SERIES = {"sqrt", "exp", "log", "sin", "cos", "tan", "atan"}
_CUTS = {"sqrt", "log", "asin", "acos", "atanh", "acosh", "atan", "asinh"}


def require_flint() -> None:
    """Check that the extra is there.

    Raises:
        MissingExtraError: python-flint is not installed.
    """
    if flint is None:
        raise MissingExtraError(
            "certified numbers need python-flint: install the extra with `pip install hjsolve[certified]`"
        )


@contextmanager
def working(bits: int) -> Iterator[None]:
    """Set Arb's precision for a block, which one thread at a time enters: python-flint has one precision per process.

    Args:
        bits: binary digits.
    """
    with shared_libraries, flint.ctx.workprec(bits):
        yield


@dataclass(frozen=True, slots=True)
class Balls(ByOperators):
    """Real or complex ball arithmetic at Arb's current precision."""

    quick: ClassVar[dict[str, Callable[[Ball], Ball]]] = {
        "neg": operator.neg, **{name: operator.methodcaller(name) for name in ("exp", "sin", "cos", "sinh", "cosh")}
    }  # fmt: skip
    """Functions that are entire: nothing has to be asked before."""

    def rational(self, numerator: int, denominator: int) -> flint.arb:
        """Return a ball that holds a fraction."""
        return flint.arb(flint.fmpq(numerator, denominator))

    def pi(self) -> flint.arb:
        return flint.arb.pi()

    def power(self, x: Ball, n: int) -> Ball:
        """Return a ball that holds every xⁿ."""
        return x * x if n == 2 else x**n

    def unary(self, name: str, x: Ball) -> Ball:
        """Return a ball that holds every value of a function over x; nan where a complex ball meets a cut."""
        if name in self.quick:
            return self.quick[name](x)
        if name == "abs":
            return _absolute(x)
        if name in _CUTS and isinstance(x, flint.acb) and _meets_cut(name, x):
            return flint.acb("nan")
        return getattr(x, name)()


@dataclass(frozen=True, slots=True)
class BallSeries(ByOperators):
    """Power series a₀ + a₁h + … whose coefficients are balls: a value with its derivatives, in one pass."""

    def rational(self, numerator: int, denominator: int) -> flint.arb:
        """Return a ball that holds a fraction: a series of one term."""
        return Balls().rational(numerator, denominator)

    def pi(self) -> flint.arb:
        return flint.arb.pi()

    def div(self, x: Ball | PowerSeries, y: Ball | PowerSeries) -> Ball | PowerSeries:
        """Return x/y; y⁻¹ is not finite where a₀ of it holds zero."""
        return x / y if isinstance(y, flint.arb | flint.acb) else x * y**-1  # Arb's own division raises at a zero

    def power(self, x: Ball | PowerSeries, n: int) -> Ball | PowerSeries:
        """Return xⁿ."""
        return x * x if n == 2 else x**n

    def unary(self, name: str, x: Ball | PowerSeries) -> Ball | PowerSeries:
        """Return a function of x; what Arb has no series of is composed from the derivatives."""
        if not isinstance(x, flint.arb_series | flint.acb_series):
            return Balls().unary(name, x)
        if name == "neg":
            return -x
        if name in _IN_SERIES and not (name in _CUTS and isinstance(x[0], flint.acb) and _meets_cut(name, x[0])):
            return getattr(x, name)()
        return _composed(name, x)


def _composed(name: str, x: PowerSeries) -> PowerSeries:
    """Return a function that Arb's series lack, up to h²."""
    parts: list[Any] = list(Jets(Balls()).unary(name, Jet(x[0], x[1], 2 * x[2])))
    return type(x)([parts[0], parts[1], parts[2] / 2], prec=min(3, x.prec))


def _absolute(x: Ball) -> Ball:
    """|x|, continued into the complex plane as ±x where that is analytic."""
    if isinstance(x, flint.arb):
        return abs(x)
    return x if x.real > 0 else -x if x.real < 0 else flint.acb("nan")


def _meets_cut(name: str, x: Ball) -> bool:
    """Return True when a complex ball meets a branch cut of an elementary function."""
    along, across = (x.imag, x.real) if name in {"atan", "asinh"} else (x.real, x.imag)
    if not across.contains(0):
        return False
    if name in {"sqrt", "log"}:
        return not along > 0
    return not along > 1 if name == "acosh" else not abs(along) < 1


def between(low: float, high: float) -> flint.arb:
    """Return a real ball that holds an interval, its ends included.

    Args:
        low, high: the ends, doubles.
    """
    return flint.arb(low).union(flint.arb(high))


def hull(q: Ball, end: flint.arb) -> Ball:
    """Return a ball that holds another one, a real ball and all segments between them.

    Args:
        q: a real or a complex ball.
        end: a real one.
    """
    # the union of two real balls is the hull
    if isinstance(q, flint.arb):
        return q.union(end)
    return flint.acb(q.real.union(end), q.imag.union(flint.arb(0)))


def from_mpf(x: Mpf) -> flint.arb:
    """Return an mpf as an exact ball."""
    sign, mantissa, exponent, _ = x._mpf_
    return flint.arb(flint.fmpz(int(-mantissa if sign else mantissa))) * flint.arb(2) ** int(exponent)
