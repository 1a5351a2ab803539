"""Certified numbers: every value a ball that contains the truth (Arb, through the extra ``certified``).

Turning points are proved by the interval Newton test. The integrals over the anomaly, q = a + (b − a) sin²(χ/2), are
enclosed by Arb's own rigorous quadrature (Johansson, arXiv:1802.07942), which asks for the integrand over complex
balls and wants it bounded. It is: on a ball that touches a turning point p²/((q−a)(b−q)) is enclosed by slopes,
F[a, q] lying in the hull of F′ over the segment from a to q, so nothing is divided by zero. A ball that meets a
branch cut gives "not finite".
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

from hjsolve.errors import MissingExtraError, NotConvergedError
from hjsolve.numeric.counting import count
from hjsolve.numeric.jet import Jet, Jets
from hjsolve.numeric.radicand import Radicand
from hjsolve.numeric.tape import Tape

try:
    import flint as flint
except ImportError:  # pragma: no cover - the extra is part of the test installation
    flint = None  # type: ignore[assignment]

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


def working(bits: int) -> AbstractContextManager[Any]:
    """Set Arb's precision for a while."""
    return flint.ctx.workprec(bits)


@dataclass(frozen=True, slots=True)
class Balls:
    """Real or complex ball arithmetic at Arb's current precision."""

    def rational(self, numerator: int, denominator: int) -> Any:
        return flint.arb(flint.fmpq(numerator, denominator))

    def pi(self) -> Any:
        return flint.arb.pi()

    def add(self, x: Any, y: Any) -> Any:
        return x + y

    def sub(self, x: Any, y: Any) -> Any:
        return x - y

    def mul(self, x: Any, y: Any) -> Any:
        return x * y

    def div(self, x: Any, y: Any) -> Any:
        return x / y

    def power(self, x: Any, n: int) -> Any:
        return x * x if n == 2 else x**n

    def unary(self, name: str, x: Any) -> Any:
        if name == "neg":
            return -x
        if name == "abs":
            return abs(x)
        if name in _CUTS and isinstance(x, flint.acb) and _meets_cut(name, x):
            return flint.acb("nan")
        return getattr(x, name)()


def _meets_cut(name: str, x: Any) -> bool:
    """True when a complex ball meets a branch cut of an elementary function."""
    along, across = (x.imag, x.real) if name in {"atan", "asinh"} else (x.real, x.imag)
    if not across.contains(0):
        return False
    if name in {"sqrt", "log"}:
        return not along > 0
    return not along > 1 if name == "acosh" else not abs(along) < 1


def jet(radicand: Radicand, q: Any, inputs: list[Any]) -> Jet:
    """Enclose F, F′, F″ at a ball."""
    jets = Jets(Balls())
    parts = radicand.squared.run(jets, [jets.variable(q), *(Jet(x) for x in inputs)])[0]
    return Jet(*(flint.arb(0) if part is None else part for part in parts))


def turning_point(radicand: Radicand, guess: Any, inputs: list[Any], bits: int) -> Any:
    """Prove a simple zero of F next to a guess (``mpf``), and enclose it to about ``bits``.

    Raises:
        NotConvergedError: the interval Newton test does not contract.
    """
    centre = from_mpf(guess)
    for _ in range(2 * bits.bit_length()):
        parts = jet(radicand, centre, inputs)
        step = (parts.value / parts.first).mid()
        centre = (centre - step).mid()
        if abs(step) < abs(centre) * flint.arb(2) ** (24 - bits):
            break
    for spare in (16, 24, 48, 96, bits // 2):
        around = flint.arb(centre, (abs(centre) + flint.arb(2) ** -bits) * flint.arb(2) ** (spare - bits))
        value = radicand.squared.run(Balls(), [centre, *inputs])[0]
        slope = jet(radicand, around, inputs).first
        if not slope.contains(0):
            newton = centre - value / slope
            if around.contains(newton):
                return newton
    raise NotConvergedError(f"the turning point near {float(guess):.15g} could not be proved to be one")


def from_mpf(x: Any) -> Any:
    """Return an mpf as an exact ball."""
    sign, mantissa, exponent, _ = x._mpf_
    return flint.arb(flint.fmpz(int(-mantissa if sign else mantissa))) * flint.arb(2) ** int(exponent)


@dataclass(frozen=True)
class Integrand:
    """The regular integrands of one coordinate over the anomaly, for real or complex balls χ.

    Attributes:
        radicand: p² and kernels.
        inputs: constants and parameters.
        lower, upper: turning points; None for a rotation (q = χ).
        kernels: one tape a kernel.
    """

    radicand: Radicand
    inputs: list[Any]
    lower: Any | None
    upper: Any | None
    kernels: tuple[Tape, ...]

    def __call__(self, j: int, χ: Any) -> Any:
        """Return kⱼ (dq/dχ)/p, or p dq/dχ for j = −1."""
        count(squares=1, kernels=int(j >= 0))
        if self.lower is None:
            root = Balls().unary("sqrt", self._squared(χ))
            return root if j < 0 else self._weight(j, χ) / root
        width = self.upper - self.lower
        s, c = (χ / 2).sin_cos()
        from_lower, to_upper = width * s * s, width * c * c
        q = self.lower + from_lower
        root = Balls().unary("sqrt", self._regular(q, from_lower, to_upper))
        return from_lower * to_upper * root if j < 0 else self._weight(j, q) / root

    def _weight(self, j: int, q: Any) -> Any:
        return self.kernels[j].run(Balls(), [q, *self.inputs])[0]

    def _regular(self, q: Any, from_lower: Any, to_upper: Any) -> Any:
        """R = p²/((q−a)(b−q)): the quotient away from the ends, a slope on a ball that touches one.

        F[a, q] = F′(a) + ½F″(hull)(q − a) stays sharp where F′(a) is small (near a separatrix).
        """
        at_lower, at_upper = _touches_zero(from_lower), _touches_zero(to_upper)
        if not at_lower and not at_upper:
            return self._squared(q) / (from_lower * to_upper)
        if at_lower and at_upper:
            return q * flint.arb("nan")
        end, offset, distance = (self.lower, from_lower, to_upper) if at_lower else (self.upper, -to_upper, -from_lower)
        slope = jet(self.radicand, end, self.inputs).first
        return (slope + jet(self.radicand, _hull(q, end), self.inputs).second * offset / 2) / distance

    def _squared(self, q: Any) -> Any:
        """F on a ball: directly at a point, by a Taylor polynomial about the middle where the ball is wide."""
        middle = q.mid()
        offset = q - middle
        if abs(offset).upper() < flint.arb(2) ** -40 * abs(middle).upper():
            return self.radicand.squared.run(Balls(), [q, *self.inputs])[0]
        centre = jet(self.radicand, middle, self.inputs)
        return centre.value + centre.first * offset + jet(self.radicand, q, self.inputs).second * offset * offset / 2


def _touches_zero(x: Any) -> bool:
    return bool(x.contains(0))


def _hull(q: Any, end: Any) -> Any:
    """A ball holding q, a real ball and all segments between them."""
    if isinstance(q, flint.arb):
        return q.union(end)
    return flint.acb(q.real.union(end), q.imag.union(flint.arb(0)))


def mean(f: Integrand, j: int, bits: int) -> Any:
    """Enclose (1/π) ∫₀^π of an integrand (over a full turn and divided by 2π for a rotation).

    Args:
        f: the integrands.
        j: which kernel; −1 for p dq/dχ.
        bits: relative precision wanted.

    Returns:
        A real ball at the current precision.

    Raises:
        NotConvergedError: the ball is wide; the motion is too close to a separatrix for the precision asked.
    """
    length = flint.arb.pi() * (2 if f.lower is None else 1)
    size = max(abs(f(j, flint.arb(x))).mid() for x in (0.7, 1.6, 2.3)) * flint.arb(2) ** -(bits + 4)
    total = flint.acb.integral(
        lambda χ, _: f(j, χ),
        0,
        length,
        rel_tol=flint.arb(2) ** -bits,
        abs_tol=size,
        eval_limit=400 * bits + 20000,
        depth_limit=8 * bits,
    )
    result = (total / length).real
    if not result.is_finite() or result.rel_accuracy_bits() < bits - 12:
        raise NotConvergedError(
            "the integral could not be enclosed to the digits asked: the motion is too close to a separatrix"
        )
    return result
