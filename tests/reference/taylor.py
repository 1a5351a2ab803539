"""Hamilton's equations integrated by Taylor series at many digits.

An independent witness for q(t) and p(t): no quadrature, no separation, no turning points. The right-hand side is
compiled once to a tape of power-series operations; each step sums the series of every coordinate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import sympy
from mpmath import mp, mpf

Tape = list[tuple[str, int, tuple[int, ...], object]]


class _Compiler:
    """Turns sympy expressions into a tape; slot numbers stand for power series."""

    def __init__(self, variables: Sequence[sympy.Symbol], values: Mapping[sympy.Symbol, mpf]):
        self.tape: Tape = []
        self.slots: dict[sympy.Expr, int] = {symbol: slot for slot, symbol in enumerate(variables)}
        self.values = values
        self.count = len(variables)

    def emit(self, op: str, args: tuple[int, ...], extra: object = None, width: int = 1) -> int:
        """Append one operation and give back its (first) slot."""
        slot = self.count
        self.count += width
        self.tape.append((op, slot, args, extra))
        return slot

    def slot(self, expr: sympy.Expr) -> int:
        """The slot that holds the series of ``expr``."""
        if expr not in self.slots:
            self.slots[expr] = self._new(expr)
        return self.slots[expr]

    def _new(self, expr: sympy.Expr) -> int:
        if (value := self._constant(expr)) is not None:
            return self.emit("constant", (), value)
        if expr.is_Add or expr.is_Mul:
            numbers = [value for argument in expr.args if (value := self._constant(argument)) is not None]
            first, *rest = [self.slot(argument) for argument in expr.args if self._constant(argument) is None]
            for other in rest:
                first = self.emit("add" if expr.is_Add else "multiply", (first, other))
            if not numbers:
                return first
            return (
                self.emit("shift", (first,), mp.fsum(numbers))
                if expr.is_Add
                else self.emit("scale", (first,), mp.fprod(numbers))
            )
        if expr.is_Pow:
            return self._power(expr.base, expr.exp)
        if isinstance(expr, sympy.sin | sympy.cos):
            pair = self.emit("sincos", (self.slot(expr.args[0]),), width=2)
            self.slots[sympy.sin(expr.args[0])], self.slots[sympy.cos(expr.args[0])] = pair, pair + 1
            return self.slots[expr]
        if isinstance(expr, sympy.sinh | sympy.cosh):
            pair = self.emit("sinhcosh", (self.slot(expr.args[0]),), width=2)
            self.slots[sympy.sinh(expr.args[0])], self.slots[sympy.cosh(expr.args[0])] = pair, pair + 1
            return self.slots[expr]
        if isinstance(expr, sympy.exp):
            return self.emit("exp", (self.slot(expr.args[0]),))
        if isinstance(expr, sympy.log):
            return self.emit("log", (self.slot(expr.args[0]),))
        if isinstance(expr, sympy.atan):
            inner = expr.args[0]
            return self.emit("atan", (self.slot(inner), self.slot(1 + inner**2)))
        if isinstance(expr, sympy.tanh):
            return self.slot(sympy.sinh(expr.args[0]) / sympy.cosh(expr.args[0]))
        if isinstance(expr, sympy.tan):
            return self.slot(sympy.sin(expr.args[0]) / sympy.cos(expr.args[0]))
        message = f"no power series rule for {expr}"
        raise TypeError(message)

    def _constant(self, expr: sympy.Expr) -> mpf | None:
        """The value of an expression of parameters and numbers, or None."""
        if not expr.free_symbols <= self.values.keys():
            return None
        return mp.mpf(sympy.N(expr.xreplace(dict(self.values)), mp.dps + 10))

    def _power(self, base: sympy.Expr, exponent: sympy.Expr) -> int:
        if exponent.is_Integer and exponent > 0:
            rest = self.slot(base if exponent == 2 else base ** (exponent - 1))
            return self.emit("multiply", (self.slot(base), rest))
        return self.emit("power", (self.slot(base),), mp.mpf(exponent.p) / exponent.q)


def _coefficient(op: str, args: list[list[mpf]], out: list[list[mpf]], k: int, extra: object) -> None:
    """Append the k-th coefficient of one tape operation to ``out``."""
    if op == "constant":
        out[0].append(extra if k == 0 else mp.zero)
    elif op == "add":
        out[0].append(args[0][k] + args[1][k])
    elif op == "shift":
        out[0].append(args[0][k] + extra if k == 0 else args[0][k])
    elif op == "scale":
        out[0].append(args[0][k] * extra)
    elif op == "multiply":
        out[0].append(mp.fdot(args[0][: k + 1], args[1][k::-1]))
    elif op == "power":
        base, power = args[0], out[0]
        if k == 0:
            power.append(base[0] ** extra)
        else:
            total = mp.fdot([(extra * (k - j) - j) * base[k - j] for j in range(k)], power[:k])
            power.append(total / (k * base[0]))
    elif op == "exp":
        _exponential(args[0], out[0], k)
    elif op in ("log", "atan"):
        _quotient_integral(op, args, out[0], k)
    elif op in ("sincos", "sinhcosh"):
        if op == "sinhcosh":
            _hyperbolic(args[0], out, k)
            return
        inner, sine, cosine = args[0], out[0], out[1]
        if k == 0:
            sine.append(mp.sin(inner[0]))
            cosine.append(mp.cos(inner[0]))
        else:
            slopes = [j * inner[j] for j in range(1, k + 1)]
            sine.append(mp.fdot(slopes, cosine[k - 1 :: -1]) / k)
            cosine.append(-mp.fdot(slopes, sine[k - 1 :: -1]) / k)


def _exponential(inner: list[mpf], out: list[mpf], k: int) -> None:
    """E′ = f′E."""
    out.append(mp.exp(inner[0]) if k == 0 else mp.fdot([j * inner[j] for j in range(1, k + 1)], out[k - 1 :: -1]) / k)


def _hyperbolic(inner: list[mpf], out: list[list[mpf]], k: int) -> None:
    """S′ = f′C, C′ = f′S."""
    if k == 0:
        out[0].append(mp.sinh(inner[0]))
        out[1].append(mp.cosh(inner[0]))
        return
    slopes = [j * inner[j] for j in range(1, k + 1)]
    new = [mp.fdot(slopes, out[1][k - 1 :: -1]) / k, mp.fdot(slopes, out[0][k - 1 :: -1]) / k]
    out[0].append(new[0])
    out[1].append(new[1])


def _quotient_integral(op: str, args: list[list[mpf]], out: list[mpf], k: int) -> None:
    """L′ = f′/g with g = f (log) or 1 + f² (atan)."""
    inner, below = args[0], args[-1]
    if k == 0:
        out.append(mp.log(inner[0]) if op == "log" else mp.atan(inner[0]))
        return
    known = mp.fdot([j * out[j] for j in range(1, k)], below[k - 1 : 0 : -1]) if k > 1 else mp.zero
    out.append((k * inner[k] - known) / (k * below[0]))


class Flow:
    """The motion of H(q, p) through one initial state.

    Args:
        hamiltonian: H as a sympy expression in the symbols of ``q``, ``p`` and ``values``.
        q: coordinate symbols. p: their momenta, in the same order.
        values: parameter symbol → mpf.
        state: initial q's then p's, mpf.
        digits: local error per step, in decimal digits; ``mp.dps`` should be about 15 larger.
    """

    def __init__(
        self,
        hamiltonian: sympy.Expr,
        q: Sequence[sympy.Symbol],
        p: Sequence[sympy.Symbol],
        values: Mapping[sympy.Symbol, mpf],
        state: Sequence[mpf],
        digits: int = 55,
    ):
        slopes = [sympy.diff(hamiltonian, s) for s in p] + [-sympy.diff(hamiltonian, s) for s in q]
        compiler = _Compiler([*q, *p], values)
        self.slopes = [compiler.slot(slope) for slope in slopes]
        self.tape, self.count = compiler.tape, compiler.count
        self.order = math.ceil(digits * math.log(10) / 2) + 2
        self.state, self.time = list(state), mp.zero

    def _series(self) -> list[list[mpf]]:
        series: list[list[mpf]] = [[] for _ in range(self.count)]
        for slot, value in enumerate(self.state):
            series[slot].append(value)
        for k in range(self.order):
            for op, slot, args, extra in self.tape:
                width = 2 if op in ("sincos", "sinhcosh") else 1
                _coefficient(op, [series[a] for a in args], series[slot : slot + width], k, extra)
            for slot, slope in enumerate(self.slopes):
                series[slot].append(series[slope][k] / (k + 1))
        return series[: len(self.state)]

    def _longest_step(self, series: list[list[mpf]]) -> mpf:
        """Radius of convergence seen by the last two terms, over e² (Jorba & Zou 2005); infinite for polynomials."""
        scale = max(mp.one, *(abs(value) for value in self.state))
        last = [(n, max(abs(s[n]) for s in series)) for n in (self.order - 1, self.order)]
        return min((scale / size) ** (mp.one / n) if size else mp.inf for n, size in last) / mp.e**2

    def at(self, time: mpf) -> list[mpf]:
        """Advance to ``time`` (either direction) and give back q's then p's."""
        while self.time != time:
            series = self._series()
            left, longest = time - self.time, self._longest_step(series)
            step = left if abs(left) <= longest else mp.sign(left) * longest
            self.state = [mp.polyval(s[::-1], step) for s in series]
            self.time = time if step == left else self.time + step
        return list(self.state)
