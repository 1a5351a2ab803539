"""The rules that any arithmetic shares: differences and powers; Φ′, Φ″ of functions, quotients.

Jets, disks, intervals, running errors and divided differences all take them from here. Each rule is arranged so that it
keeps its relative accuracy where the function is flat: 1/cosh² and not 1 − tanh² far out, √(x − 1) √(x + 1) and not
√(x² − 1) next to 1, which is also the branch of arcosh on both half planes (DLMF 4.20, 4.34, 4.37.19).
"""

from __future__ import annotations

from hjsolve.arithmetic.floats import by_squaring
from hjsolve.arithmetic.number_types import N
from hjsolve.arithmetic.tape import Arithmetic

QUOTIENTS = {"tan": ("sin", "cos"), "tanh": ("sinh", "cosh"), "sech": ("", "cosh")}
"""Functions that are quotients: what stands above, 1 where that is empty, and what stands below the line."""
BY_VALUE = frozenset({"abs", "exp", "sqrt", "tan", "sech"})
"""Functions whose derivative is written by their value."""
OF_ITSELF = frozenset({"exp", "sin", "cos", "sinh", "cosh"})
"""Functions whose second derivative is ± their value."""


class ByOthers:
    """What an arithmetic makes of its other operations: x − y as x + (−y), and xⁿ as products."""

    __slots__ = ()

    def sub(self: Arithmetic[N], x: N, y: N) -> N:
        """Return x − y, as x + (−y)."""
        return self.add(x, self.unary("neg", y))

    def power(self: Arithmetic[N], x: N, n: int) -> N:
        """Return xⁿ, by squaring."""
        if n <= 0:
            return self.rational(1, 1) if n == 0 else self.div(self.rational(1, 1), self.power(x, -n))
        return by_squaring(self.mul, x, n)


def quotient(a: Arithmetic[N], name: str, x: N) -> N:
    """Return one of ``QUOTIENTS`` by its parts, where an arithmetic has a rule for those alone.

    Args:
        a: the arithmetic of x.
        name: of the function.
        x: a number of it.
    """
    above, below = QUOTIENTS[name]
    return a.div(a.unary(above, x) if above else a.rational(1, 1), a.unary(below, x))


def slope(a: Arithmetic[N], name: str, x: N, f: N) -> N:
    """Return Φ′(x).

    Args:
        a: the arithmetic of x.
        name: of Φ, one of ``tape.UNARY`` but ``neg``.
        x: a number of it.
        f: Φ(x); of meaning for ``BY_VALUE`` alone.
    """
    match name:
        case "exp":
            return f
        case "sin" | "sinh" | "cosh":
            return a.unary({"sin": "cos", "sinh": "cosh", "cosh": "sinh"}[name], x)
        case "cos":
            return a.unary("neg", a.unary("sin", x))
        case "log":
            return a.div(a.rational(1, 1), x)
        case "sqrt":
            return a.div(a.rational(1, 2), f)
        case "tan":
            return a.add(a.rational(1, 1), a.power(f, 2))
        case "tanh":
            return a.power(a.unary("sech", x), 2)
        case "sech":
            return a.unary("neg", a.mul(f, a.unary("tanh", x)))
        case "abs":
            return a.div(f, x)
        case "acos":
            return a.unary("neg", slope(a, "asin", x, f))
        case _:
            w = _below(a, name, x)
            return a.div(a.rational(1, 1), w if name in {"atan", "atanh", "acosh"} else a.unary("sqrt", w))


def bend(a: Arithmetic[N], name: str, x: N, f: N, first: N) -> N:
    """Return Φ″(x).

    Args:
        a: the arithmetic of x.
        name: of Φ, one of ``tape.UNARY`` but ``neg``.
        x: a number of it.
        f, first: Φ(x) and Φ′(x); the second is of no meaning for ``OF_ITSELF``.
    """
    match name:
        case "exp" | "sinh" | "cosh":
            return f
        case "sin" | "cos":
            return a.unary("neg", f)
        case "log":
            return a.unary("neg", a.power(first, 2))
        case "sqrt":
            return a.unary("neg", a.div(first, a.mul(a.rational(2, 1), x)))
        case "tan" | "tanh":
            return a.mul(a.rational(2 if name == "tan" else -2, 1), a.mul(f, first))
        case "sech":
            return a.mul(f, a.sub(a.rational(1, 1), a.mul(a.rational(2, 1), a.power(f, 2))))
        case "abs":
            return a.rational(0, 1)
        case _:  # Φ′ = ±w⁻¹ or ±w^(−½) with w′ = ±2x
            w = a.power(_below(a, name, x), 2) if name == "acosh" else _below(a, name, x)
            turn = a.mul(a.rational(2 if name in {"atan", "atanh"} else 1, 1), a.mul(x, a.div(first, w)))
            return a.unary("neg", turn) if name in {"atan", "asinh", "acosh"} else turn


def _below(a: Arithmetic[N], name: str, x: N) -> N:
    """Return 1 + x² of atan and asinh, 1 − x² of asin, acos and atanh, √(x − 1) √(x + 1) of acosh."""
    one = a.rational(1, 1)
    if name == "acosh":
        return a.mul(a.unary("sqrt", a.sub(x, one)), a.unary("sqrt", a.add(x, one)))
    square = a.power(x, 2)
    return a.add(one, square) if name in {"atan", "asinh"} else a.sub(one, square)
