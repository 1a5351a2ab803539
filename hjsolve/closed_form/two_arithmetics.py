"""Forms with bounds on their rounding in doubles, and in two doubles: where the first are wide, the second are taken.

A form of general constants has no arrangement that keeps all digits everywhere: turning points meet, angles are next to
a whole turn, roots next to poles. What doubles lose is bounded by running errors; of elliptic functions by how they
grow, R_F with the power −½ of its arguments, R_D and R_J with −3/2, F and Π by their integrands at the amplitude.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hjsolve.arithmetic.carlson_complex_pairs import part_at_a_complex_pole
from hjsolve.arithmetic.carlson_pairs import PI, TwoDoubles, arcsin, arctan, elliptic_function
from hjsolve.arithmetic.double_double import DoubleDouble
from hjsolve.arithmetic.error_free import Pair
from hjsolve.arithmetic.floats import EPS, Float64
from hjsolve.arithmetic.number_types import Mask, Reals
from hjsolve.arithmetic.running_error import RunningError, WithErrorBound
from hjsolve.functions.tables import modules

_POWERS = {"CarlsonRF": 0.5, "CarlsonRC": 1.0, "CarlsonRD": 1.5, "CarlsonRJ": 1.5}
"""How fast an integral grows with all of its arguments: |∂ log R/∂ log x| is not more of each."""
_OWN = 8.0
"""Units of rounding of an elliptic function with exact arguments."""
Bounded = WithErrorBound[Any]


@dataclass(frozen=True, slots=True)
class DoublesWithBounds(RunningError[Any]):
    """Doubles, elementwise, each with a bound on its error; that of a function is what a first order rule says."""

    plain: Any = field(default_factory=Float64)
    functions: dict[str, Any] = field(default_factory=lambda: dict(modules("numpy")[0]))  # type: ignore[arg-type]

    def atan2(self, y: Bounded, x: Bounded) -> Bounded:
        """Return the angle of a point; its bound is (|x| δy + |y| δx)/(x² + y²) and roundings."""
        value, size = np.arctan2(y.value, x.value), np.hypot(x.value, y.value)
        passed = (abs(x.value / size) * _error(y) + abs(y.value / size) * _error(x)) / size
        return WithErrorBound(value, passed + EPS * abs(value))

    def sign(self, x: Bounded) -> Bounded:
        """Return the sign, whose error is none."""
        return WithErrorBound(np.sign(x.value))

    def positive(self, x: Bounded) -> Mask:
        """Return where the value is positive."""
        return np.asarray(x.value > 0)

    def either(self, condition: Mask, x: Bounded, y: Bounded) -> Bounded:
        """Return one of both with its own bound."""
        return WithErrorBound(np.where(condition, x.value, y.value), np.where(condition, _error(x), _error(y)))

    def elliptic(self, name: str, *arguments: Bounded) -> Bounded:
        """Return an elliptic function with a bound to first order."""
        values, errors = [np.asarray(a.value, dtype=float) for a in arguments], [_error(a) for a in arguments]
        value = self.functions[name](*values)
        if name in _POWERS:
            parts = [np.where(e == 0, 0.0, e / abs(v)) for v, e in zip(values, errors, strict=True)]
            bound = abs(value) * (_POWERS[name] * np.max(np.broadcast_arrays(*parts), axis=0) + _OWN * EPS)
        elif name.startswith("Jacobi"):
            bound = _of_jacobi(name, value, values, errors)
        elif name.startswith("elliptic"):
            bound = _of_legendre(name, value, values, errors)
        else:
            bound = _of_complex_pole(self.functions, name, values, errors)
        return WithErrorBound(value, bound)


def _error(x: Bounded) -> Reals | float:
    return 0.0 if x.error is None else x.error


def _of_jacobi(name: str, value: Reals, values: list[Reals], errors: list[Reals | float]) -> Reals:
    """Of am, sn, cn, dn and ℰ: by u with a slope of at most 1 or √(1 − m), by m with what the phase moves."""
    (u, m), (δu, δm) = values, errors
    steep = np.sqrt(np.fmax(1.0, np.fmax(abs(m), 1 - m)))
    phase = steep * (δu + 2 * EPS * abs(u)) + (1 + abs(u) * steep) * np.fmax(1.0, 1 / abs(1 - m)) * δm
    return phase * (steep if name in ("JacobiDN", "JacobiEpsilon") else 1.0) + _OWN * EPS * abs(value)


def _of_legendre(name: str, value: Reals, values: list[Reals], errors: list[Reals | float]) -> Reals:
    """Of K, F, E and Π: their integrands, and those of their derivatives, are largest at the amplitude."""
    m, δm = values[-1], errors[-1]
    amplitude = len(values) - (name == "elliptic_pi") == 2
    φ, δφ = (values[-2], errors[-2]) if amplitude else (np.full_like(m, np.pi / 2), 0.0)
    square = np.where(abs(φ) > np.pi / 2, 1.0, np.sin(φ) ** 2)
    least = np.fmin(1.0, 1 - m * square)
    bound = abs(value) * ((0.5 * δm + EPS) / least + _OWN * EPS)
    slope = np.sqrt(1 - m * np.sin(φ) ** 2)
    slope = slope if name == "elliptic_e" else 1 / slope
    if name == "elliptic_pi":
        n, δn = values[0], errors[0]
        pole = np.where(n > 0, 1 - n * square, 1.0)
        bound = bound + abs(value) * (δn / np.where(n > 0, pole, 1 - n) + EPS * np.fmax(1.0, abs(n)) / pole)
        slope = slope / (1 - n * np.sin(φ) ** 2)
    return bound + abs(slope) * δφ


def _of_complex_pole(functions: dict[str, Any], name: str, values: list[Reals], errors: list[Reals | float]) -> Reals:
    """Of parts of R_C and R_J at a complex place: by the modulus of both parts."""
    size = np.hypot(functions[f"{name[:-2]}Re"](*values), functions[f"{name[:-2]}Im"](*values))
    pole = (np.asarray(errors[-2]) + errors[-1]) / np.hypot(values[-2], values[-1])
    parts = [np.where(e == 0, 0.0, e / abs(v)) for v, e in zip(values[:-2], errors[:-2], strict=True)]
    return size * (1.5 * np.max(np.broadcast_arrays(pole, *parts), axis=0) + _OWN * EPS)


@dataclass(frozen=True, slots=True)
class PairsOfForms(DoubleDouble):
    """Two doubles, elementwise, with all that forms have."""

    def unary(self, name: str, x: Pair) -> Pair:
        """Return a function of x; inverse ones next to the ends of their domains by products, which lose nothing."""
        own = TwoDoubles(*x)
        if name == "asin":
            return _pair(arcsin(own))
        if name == "acos":
            # half of the angle by its tangent: next to 1 the difference 1 − x is exact, 1 − x² is not
            half = arctan(((1.0 - own) / (1.0 + own)).root())
            return _pair(2.0 * half)
        if name == "acosh":
            return self.unary("asinh", _pair(((own - 1.0) * (own + 1.0)).root()))
        if name == "atanh":
            return self.unary("asinh", _pair(own / ((1.0 - own) * (1.0 + own)).root()))
        return super(PairsOfForms, self).unary(name, x)

    def atan2(self, y: Pair, x: Pair) -> Pair:
        """Return the angle of a point, by the smaller of both quotients."""
        a, b = TwoDoubles(*y), TwoDoubles(*x)
        # the greater quotient is infinite on an axis
        flat = abs(np.asarray(y.high)) <= abs(np.asarray(x.high))
        side = np.where(np.asarray(y.high) < 0, -1.0, 1.0)
        top, low = np.where(flat, y.high, x.high), np.where(flat, y.low, x.low)
        bottom, bottom_low = np.where(flat, x.high, y.high), np.where(flat, x.low, y.low)
        part = arctan(TwoDoubles(top, low) / TwoDoubles(bottom, bottom_low))
        turned = part + PI.scaled(np.where(np.asarray(b.high) < 0, side, 0.0))
        upright = PI.scaled(np.where(np.asarray(a.high) < 0, -0.5, 0.5)) - part
        return Pair(np.where(flat, turned.high, upright.high), np.where(flat, turned.low, upright.low))

    def sign(self, x: Pair) -> Pair:
        """Return 1, 0 or −1."""
        return Pair(np.sign(x.high), np.zeros_like(x.high))

    def positive(self, x: Pair) -> Mask:
        """Return where x is positive."""
        return np.asarray(x.high) > 0

    def either(self, condition: Mask, x: Pair, y: Pair) -> Pair:
        """Return one of both."""
        return Pair(np.where(condition, x.high, y.high), np.where(condition, x.low, y.low))

    def elliptic(self, name: str, *arguments: Pair) -> Pair:
        """Return an elliptic function."""
        if name.endswith(("Re", "Im")):
            return _pair(part_at_a_complex_pole(name, *(TwoDoubles(*a) for a in arguments)))
        return elliptic_function(name, *arguments)


def _pair(x: TwoDoubles) -> Pair:
    return Pair(x.high, x.low)
