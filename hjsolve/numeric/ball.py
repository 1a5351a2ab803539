"""Certified numbers: every value a ball that contains the truth (Arb, through the extra ``certified``).

Turning points are proved by the interval Newton test. The integrals over the anomaly, q = a + (b − a) sin²(χ/2), are
enclosed by Arb's own rigorous quadrature (Johansson, arXiv:1802.07942), which asks for the integrand over complex
balls and wants it bounded. It is: on a ball that touches a turning point p²/((q−a)(b−q)) is enclosed by slopes,
F[a, q] lying in the hull of F′ over the segment from a to q, so nothing is divided by zero. A ball that meets a
branch cut gives "not finite".
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from hjsolve.errors import MissingExtraError, NotConvergedError
from hjsolve.numeric.arithmetic import ByOperators
from hjsolve.numeric.counting import count
from hjsolve.numeric.jet import Jet, Jets
from hjsolve.numeric.radicand import Radicand
from hjsolve.numeric.tape import Tape

try:
    import flint as flint
except ImportError:  # pragma: no cover - the extra is part of the test installation
    flint = None  # type: ignore[assignment]

_WIDTHS = (0.4, 0.2, 0.1)
"""Half widths of the strip tried for the midpoint rule, one after the other."""
_MOST_NODES, _MOST_BOXES = 12, 100
"""Nodes for each bit, and boxes that cover the strip, beyond which Arb's own quadrature is the better way."""
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
class Balls(ByOperators):
    """Real or complex ball arithmetic at Arb's current precision."""

    def rational(self, numerator: int, denominator: int) -> Any:
        return flint.arb(flint.fmpq(numerator, denominator))

    def pi(self) -> Any:
        return flint.arb.pi()

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
        """R = p²/((q−a)(b−q)): the quotient on a small ball, a slope on one that is wide or touches an end.

        F[a, q] = F′(a) + ½F″(hull)(q − a) stays sharp where F′(a) is small (near a separatrix).
        """
        at_lower, at_upper = _touches_zero(from_lower), _touches_zero(to_upper)
        if at_lower and at_upper:
            return q * flint.arb("nan")
        if at_lower or (not at_upper and _wide(q) and abs(from_lower) < abs(to_upper)):
            found = self._sloped(q, 0, from_lower, to_upper)
        elif at_upper or _wide(q):
            found = self._sloped(q, 1, -to_upper, -from_lower)
        else:
            return self._squared(q) / (from_lower * to_upper)
        if at_lower or at_upper or found.real > 0:
            return found
        return self._squared(q) / (from_lower * to_upper)

    def _sloped(self, q: Any, end: int, offset: Any, distance: Any) -> Any:
        place = (self.lower, self.upper)[end]
        bend = jet(self.radicand, _hull(q, place), self.inputs).second
        return (self._end_slopes[end] + bend * offset / 2) / distance

    @cached_property
    def _end_slopes(self) -> tuple[Any, Any]:
        """F′ at both turning points."""
        return jet(self.radicand, self.lower, self.inputs).first, jet(self.radicand, self.upper, self.inputs).first

    def _squared(self, q: Any) -> Any:
        """F on a ball: directly at a point, by a Taylor polynomial about the middle where the ball is wide."""
        middle = q.mid()
        offset = q - middle
        if abs(offset).upper() < flint.arb(2) ** -40 * abs(middle).upper():
            return self.radicand.squared.run(Balls(), [q, *self.inputs])[0]
        centre = jet(self.radicand, middle, self.inputs)
        return centre.value + centre.first * offset + jet(self.radicand, q, self.inputs).second * offset * offset / 2


def _wide(q: Any) -> bool:
    """True for a ball so wide that the quotient of F and its factors says little."""
    return isinstance(q, flint.acb) and bool(q.rad() > 2.0**-6 * (1 + abs(q).upper()))


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
    size = max(abs(f(j, flint.arb(x))).mid() for x in (0.7, 1.6, 2.3))
    found = _midpoints(f, j, bits, size)
    result = _integral(f, j, bits, size) if found is None else found
    if not result.is_finite() or result.rel_accuracy_bits() < bits - 12:
        raise NotConvergedError(
            "the integral could not be enclosed to the digits asked: the motion is too close to a separatrix"
        )
    return result


def _integral(f: Integrand, j: int, bits: int, size: Any) -> Any:
    """The mean by Arb's adaptive quadrature, which finds its way around singularities close to the path."""
    length = flint.arb.pi() * (2 if f.lower is None else 1)
    total = flint.acb.integral(
        lambda χ, _: f(j, χ),
        0,
        length,
        rel_tol=flint.arb(2) ** -bits,
        abs_tol=size * flint.arb(2) ** -(bits + 4),
        eval_limit=400 * bits + 20000,
        depth_limit=8 * bits,
    )
    return (total / length).real


def _midpoints(f: Integrand, j: int, bits: int, size: Any) -> Any | None:
    """The mean by the midpoint rule with its proved error; None where it would need too many nodes.

    Where an integrand with period 2π is analytic and at most M in the strip |Im χ| ≤ a, N nodes miss its mean by no
    more than 2M/(e^(aN) − 1) (Trefethen & Weideman, SIAM Review 56 (2014) 385, theorem 3.2).
    """
    strip = next(((a, most) for a in _WIDTHS if (most := _most(f, j, a)) is not None), None)
    if strip is None:
        return None
    a, most = strip
    turns = float((4 * most / size).log().upper()) + (bits + 4) * 0.6931471805599453
    count, step = 2 * math.ceil(turns / (2 * a)) + 2, 1
    if f.lower is not None:  # even: half of the nodes are the mirror image of the others
        count, step = count // 2, 2
    if count > _MOST_NODES * bits:
        return None
    angle = 2 * flint.arb.pi() / (step * count)
    total = sum((f(j, angle * (2 * m + 1) / 2) for m in range(count)), flint.arb(0))
    radius = 2 * most / ((flint.arb(a) * count * step).exp() - 1)
    return total / count + flint.arb(0, radius.upper())


def _most(f: Integrand, j: int, a: float) -> Any | None:
    """A bound on an integrand over the strip |Im χ| ≤ a, proved to be free of singularities; None where that fails.

    By f(χ̄) = f̄(χ), and by evenness for a libration, a part of the strip stands for the whole.
    """
    length = 3.1416 if f.lower is not None else 6.2832
    todo = [(length * k / 8, length * (k + 1) / 8, 0.0, a) for k in range(8)]
    most, work = flint.arb(0), _MOST_BOXES
    with working(64):
        while todo:
            if (work := work - 1) < 0:
                return None
            x0, x1, y0, y1 = todo.pop()
            value = f(j, flint.acb(_between(x0, x1), _between(y0, y1)))
            if value.is_finite():
                most = most.max(abs(value).upper())
                continue
            x, y = (x0 + x1) / 2, (y0 + y1) / 2
            todo += [(x0, x, y0, y), (x, x1, y0, y), (x0, x, y, y1), (x, x1, y, y1)]
    return most


def _between(low: float, high: float) -> Any:
    """A real ball that holds an interval."""
    return flint.arb((low + high) / 2, (high - low) / 2 * (1 + 1e-12) + 1e-15)
