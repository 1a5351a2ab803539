"""A number that carries how good it is, and goes on doing so when it is computed with."""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

from hjsolve.arithmetic import propagation
from hjsolve.arithmetic.printed_digits import decimal, with_last_digits
from hjsolve.errors import InvalidInputError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from hjsolve.arithmetic.number_types import Mpf


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Estimate:
    """A value with a bound on its error; a number to compute with.

    What is integrated over a bounded coordinate rests on as many nodes as a proved strip of analyticity asks for
    (``one_coordinate.resolution``, docs/theory.md): no feature of a potential is too narrow to be counted. The error is
    the rounding of the value and what is known to be lost on the way to it.

    The operations + − · / ** % // abs, numpy's functions of one and two variables (``np.sqrt(e)``, ``np.sin(e)``, …)
    and arrays times an Estimate give Estimates. Their error is that of the worst case over value ± error of each
    operand, the rounding of the result included: it bounds the true error also where the slope changes within that
    interval, and where operands depend on each other (e − e is 0 ± 2 error). What of an interval lies outside the
    domain of a function is left out (√ of 0 ± error); where there is no bound, ``InvalidInputError`` says so.

    ``<``, ``<=``, ``>``, ``>=`` are True where they hold for all numbers within the errors; where that cannot be said,
    they are False, and so are their opposites. ``==`` asks whether value and error are the same; whether two numbers
    may be the same is asked by ``agrees``.

    ``f"{e:.6f}"`` writes the value, ``f"{e:S}"`` the short form 7.4162987(3), ``f"{e:L}"`` the same in LaTeX.

    Attributes:
        value: the number; float up to 15 digits, ``mpf`` above.
        error: absolute error, never below the true one unless the input itself was in doubt.
        certified: True where ``error`` is a proved bound (ball arithmetic), False where it is measured.
        nodes: quadrature nodes used, 0 where none were needed.

    Example:
        >>> period = Estimate(6.25, 0.5)
        >>> 2 * period, period**2, period - period
        (Estimate(12.5, error=1.0e+0), Estimate(39.0625, error=6.5e+0), Estimate(0.0, error=1.0e+0))
        >>> f"{Estimate(7.41629871, 2.4e-7):S}"
        '7.4162987(3)'
    """

    value: Any
    error: Any
    certified: bool = False
    nodes: int = 0

    # -------------------------------------------------------------------------------------------- as a number
    def __float__(self) -> float:
        return float(self.value)

    @property
    def interval(self) -> tuple[Any, Any]:
        """Lower and upper end of value ± error, rounded outward."""
        return propagation.interval((self.value, self.error))

    def agrees(self, other: object) -> bool:
        """Return whether this and another number may be the same: value ± error of the two meet.

        Args:
            other: an ``Estimate``, or a real number of any kind.

        Raises:
            InvalidInputError: it is neither.
        """
        term = _term(other)
        if term is None:
            raise InvalidInputError(f"agrees: a number or an Estimate is needed, not {type(other).__name__}")
        return propagation.meet((self.value, self.error), term)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Estimate):
            return bool(self.value == other.value and self.error == other.error)
        if _term(other) is None:
            return NotImplemented
        return bool(self.error == 0 and self.value == other)

    def __hash__(self) -> int:
        return hash(self.value)

    def __lt__(self, other: object) -> bool:
        return self._below(other, operator.lt)

    def __le__(self, other: object) -> bool:
        return self._below(other, operator.le)

    def __gt__(self, other: object) -> bool:
        return self._above(other, operator.gt)

    def __ge__(self, other: object) -> bool:
        return self._above(other, operator.ge)

    def _below(self, other: object, compare: Callable[[float | Mpf, float | Mpf], bool]) -> bool:
        term = _term(other)
        if term is None:
            return NotImplemented
        return bool(compare(propagation.exact_ends((self.value, self.error))[1], propagation.exact_ends(term)[0]))

    def _above(self, other: object, compare: Callable[[float | Mpf, float | Mpf], bool]) -> bool:
        term = _term(other)
        if term is None:
            return NotImplemented
        return bool(compare(propagation.exact_ends((self.value, self.error))[0], propagation.exact_ends(term)[1]))

    # -------------------------------------------------------------------------------------------- operations
    def __neg__(self) -> Estimate:
        return combined("neg", self)

    def __pos__(self) -> Estimate:
        return self

    def __abs__(self) -> Estimate:
        return combined("abs", self)

    def __add__(self, other: object) -> Estimate:
        return combined("add", self, other)

    def __radd__(self, other: object) -> Estimate:
        return combined("add", other, self)

    def __sub__(self, other: object) -> Estimate:
        return combined("subtract", self, other)

    def __rsub__(self, other: object) -> Estimate:
        return combined("subtract", other, self)

    def __mul__(self, other: object) -> Estimate:
        return combined("multiply", self, other)

    def __rmul__(self, other: object) -> Estimate:
        return combined("multiply", other, self)

    def __truediv__(self, other: object) -> Estimate:
        return combined("divide", self, other)

    def __rtruediv__(self, other: object) -> Estimate:
        return combined("divide", other, self)

    def __floordiv__(self, other: object) -> Estimate:
        return combined("floor_divide", self, other)

    def __rfloordiv__(self, other: object) -> Estimate:
        return combined("floor_divide", other, self)

    def __mod__(self, other: object) -> Estimate:
        return combined("remainder", self, other)

    def __rmod__(self, other: object) -> Estimate:
        return combined("remainder", other, self)

    def __pow__(self, other: object) -> Estimate:
        return combined("power", self, other)

    def __rpow__(self, other: object) -> Estimate:
        return combined("power", other, self)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """Return the value alone, for numpy: a double, or an object that keeps every digit."""
        import numpy as np

        return np.array(self.value, dtype=dtype)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: object, **options: object) -> object:
        from hjsolve.arithmetic.ufuncs import of_estimates

        return of_estimates(Estimate, combined, ufunc, method, inputs, options)

    def _sympy_(self) -> NoReturn:
        """Decline to become sympy's number, which would lose the error: sympy's rationals then ask ``__radd__``."""
        raise sys.modules["sympy"].SympifyError("an Estimate; write its .value")

    # -------------------------------------------------------------------------------------------- as text
    def __repr__(self) -> str:
        more = (", certified=True" if self.certified else "") + (f", nodes={self.nodes}" if self.nodes else "")
        return f"Estimate({self.value!r}, error={propagation.short_bound(self.error)}{more})"

    def __str__(self) -> str:
        return f"{self.value} ± {propagation.short_bound(self.error)}"

    def __format__(self, spec: str) -> str:
        if not spec:
            return str(self)
        if spec in {"S", "L"}:
            mantissa, power = with_last_digits(self.value, self.error)
            if spec == "L":
                return f"{mantissa} \\times 10^{{{power}}}" if power else mantissa
            return f"{mantissa}e{power}" if power else mantissa
        return format(self.value if isinstance(self.value, float) else decimal(self.value), spec)

    def _repr_latex_(self) -> str:
        """Return what a notebook shows."""
        return f"${self:L}$"


def _term(x: object) -> propagation.Term | None:
    """Return the value and error of an operand; None for what is not a real number."""
    if isinstance(x, Estimate):
        return x.value, x.error
    return (x, 0.0) if propagation.is_real(x) else None


def combined(name: str, *operands: object) -> Estimate:
    """Return a function of numbers, of which at least one is an Estimate.

    Args:
        name: of ``ranges.FUNCTIONS`` or ``ranges.OF_TWO``.
        operands: one or two.

    Returns:
        The Estimate; ``NotImplemented`` where an operand is not a real number, so that Python can ask the operand.

    Raises:
        InvalidInputError: the function is not real there, or has no bound.
    """
    terms = [_term(x) for x in operands]
    if any(term is None for term in terms):
        return NotImplemented
    estimates = [x for x in operands if isinstance(x, Estimate)]
    value, error = propagation.propagated(name, [term for term in terms if term is not None])
    return Estimate(value, error, all(e.certified for e in estimates), max(e.nodes for e in estimates))
