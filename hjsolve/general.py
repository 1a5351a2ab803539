"""One degree of freedom with a given H(q, p) that is no T + V: solved for p.

    H(q, p) = a(q) p + b(q) = E:        p = (E − b)/a,     W = ∫ p dq,     t − β = ∂W/∂E = ∫ dq/a      (Greenwood P5-1)

is linear in p: no square root, one branch, and no turning point; q moves one way for ever, at the rate a(q).

    H(q, p) = a(q) p² + b(q) p + c(q):  L = (q̇ − b)²/(4a) − c

is a natural system with a term linear in the velocity, and becomes a ``System``. Other dependences on p are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from hjsolve.errors import InvalidInputError, InvalidSystemError, OutsideMotionError
from hjsolve.expressions import number, parse
from hjsolve.initial import to_bits
from hjsolve.lowering import lower
from hjsolve.numeric.arithmetic import Multi, multiprecision
from hjsolve.system import Coordinate, System

_ENERGY = sp.Symbol("E", real=True)


@dataclass(frozen=True)
class LinearHamiltonian:
    """H = a(q) p + b(q), solved.

    Attributes:
        coordinate: q. hamiltonian: H. rate: a(q). rest: b(q).
        momentum: p(q; E).
        characteristic_function: W(q; E), by quadrature.
        principal_function: S = W − E t.
        time_law: ∂W/∂E = t − β, the integral of dq/a; both without constants of integration.
        values: parameters by symbol.
    """

    coordinate: Coordinate
    hamiltonian: sp.Expr
    rate: sp.Expr
    rest: sp.Expr
    values: Mapping[sp.Symbol, sp.Expr]

    @property
    def momentum(self) -> sp.Expr:
        """p(q; E) = (E − b)/a."""
        return (_ENERGY - self.rest) / self.rate

    @property
    def characteristic_function(self) -> sp.Expr:
        """W(q; E) = ∫ p dq."""
        return sp.expand(sp.integrate(sp.expand(self.momentum), self.coordinate.symbol))

    @property
    def principal_function(self) -> sp.Expr:
        """S(q, t; E) = W − E t."""
        return self.characteristic_function - _ENERGY * sp.Symbol("t", real=True)

    @property
    def time_law(self) -> sp.Expr:
        """The time t − β as a function of q."""
        return sp.integrate(1 / self.rate, self.coordinate.symbol)

    def at(self, t: Any, *, q: Any, p: Any, t0: Any = 0, digits: int = 15) -> tuple[Any, Any]:
        """Return (q, p) at a time.

        Args:
            t: the time.
            q: position at t0.
            p: momentum at t0.
            t0: initial time.
            digits: relative digits wanted.

        Raises:
            OutsideMotionError: a(q) vanishes at the start (then q rests), or q reaches infinity before.
        """
        bits = int(3.33 * digits) + 64
        context = multiprecision(bits)
        time = number(t, source="t") - number(t0, source="t0")
        given = (number(q, source="q"), number(p, source="p"), time)
        start, first, elapsed = (to_bits(x)(bits) for x in given)
        tape = lower([self.rate, self.rest], [self.coordinate.symbol, *self.values])
        numbers = [to_bits(v)(bits) for v in self.values.values()]

        def rate(x: Any) -> Any:
            return tape.run(Multi(bits), [x, *numbers])[0]

        place = self._moved(rate, start, elapsed, context)
        a0, b0 = tape.run(Multi(bits), [start, *numbers])
        a, b = tape.run(Multi(bits), [place, *numbers])
        momentum = (a0 * first + b0 - b) / a
        return (place, momentum) if digits > 15 else (float(place), float(momentum))

    def _moved(self, rate: Any, start: Any, elapsed: Any, context: Any) -> Any:
        """Solve ∫ dq/a = elapsed by Newton's method: the derivative of the left side is 1/a itself."""
        speed = rate(start)
        if not speed:
            raise OutsideMotionError(f"{self.coordinate.name} rests: the rate a(q) vanishes at the start")
        place, left = start, elapsed
        while left:
            longest = (1 + abs(place)) / abs(rate(place)) / 2
            if abs(place) > 2**30 and longest < abs(left) / 2**20:
                raise OutsideMotionError(f"{self.coordinate.name} reaches infinity in a finite time")
            step = left if abs(left) <= longest else (longest if left > 0 else -longest)
            place, left = self._step(rate, place, step, context), left - step
        return place

    def _step(self, rate: Any, place: Any, step: Any, context: Any) -> Any:
        guess = place + rate(place) * step
        for _ in range(60):
            time = context.quad(lambda x: 1 / rate(x), [place, guess])
            change = (step - time) * rate(guess)
            guess += change
            if abs(change) <= context.mpf(2) ** (24 - context.prec) * (abs(guess) + 1):
                return guess
        raise OutsideMotionError(f"{self.coordinate.name} comes to a place where a(q) vanishes, in infinite time")


def from_hamiltonian(
    hamiltonian: str, coordinates: Mapping[str, str], parameters: Mapping[str, Any] | None = None, *, title: str = ""
) -> System | LinearHamiltonian:
    """Take a system of one degree of freedom from H(q, p), written with ``p``.

    Args:
        hamiltonian: H, a polynomial of first or second degree in the momentum ``p``.
        coordinates: one name → domain.
        parameters: name → value, as for ``System``.
        title: for display.

    Returns:
        A ``System`` where H is quadratic in p, a ``LinearHamiltonian`` where it is linear.

    Raises:
        InvalidSystemError: more than one coordinate, or another dependence on p.

    Example:
        >>> problem = from_hamiltonian("q + p", {"q": "line"})
        >>> problem.principal_function
        E*q - E*t - q**2/2
    """
    if len(coordinates) != 1:
        raise InvalidSystemError("H(q, p): one coordinate only; more need T and V")
    (name, domain), = coordinates.items()
    if name == "p" or "p" in (parameters or {}):
        raise InvalidSystemError("H(q, p): p is the momentum; rename the coordinate or parameter")
    shape = System(coordinates, f"dot({name})**2/2", "0", parameters)
    q = shape.coordinate(name)
    H = parse(hamiltonian, {**shape.symbols, "p": q.momentum}, source="hamiltonian")
    if not H.is_polynomial(q.momentum) or sp.degree(H, q.momentum) not in (1, 2):
        raise InvalidSystemError("H(q, p): must be a polynomial of first or second degree in p, with p in it")
    coefficients = sp.Poly(H, q.momentum).all_coeffs()
    if len(coefficients) == 2:
        if any(p.value is None for p in shape.parameters):
            raise InvalidInputError("H(q, p): give every parameter a value")
        values = {p.symbol: p.value for p in shape.parameters if p.value is not None}
        return LinearHamiltonian(q, H, coefficients[0], coefficients[1], values)
    a, b, c = coefficients
    kinetic = sp.expand((q.velocity - b) ** 2 / (4 * a))
    return System({name: domain}, kinetic, c, parameters, title=title)
