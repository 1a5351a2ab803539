"""From formulas to functions of numbers: the only bridge between sympy and the numeric half."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import sympy as sp

from hjsolve.arithmetic.tape import UNARY, Operation, Tape
from hjsolve.errors import InvalidInputError
from hjsolve.formulas.removable_poles import without_removable_poles
from hjsolve.precision import one_at_a_time

_FUNCTIONS = {
    getattr(sp, name.capitalize() if name == "abs" else name): name for name in UNARY if name not in {"neg", "sqrt"}
}

_LARGEST_POWER = 6
_OF_A_DOUBLE = 1000
"""Binary digits of a numerator or denominator that is a double; longer ones are not taken apart."""


@one_at_a_time
def lower(expressions: Sequence[sp.Expr], arguments: Sequence[sp.Symbol]) -> Tape:
    """Compile formulas to one tape, common parts computed once.

    Args:
        expressions: the outputs, in order.
        arguments: the inputs, in order; every free symbol must be among them.

    Returns:
        The tape; exact numbers stay exact rationals until an arithmetic rounds them.

    Raises:
        InvalidInputError: a function or symbol that has no numerical value.
    """
    writer = TapeWriter(tuple(arguments))
    outputs = tuple(writer.slot(without_inverse_functions(expression)) for expression in expressions)
    return Tape(tuple(str(s) for s in arguments), tuple(writer.operations), outputs)


def without_inverse_functions(expression: sp.Expr) -> sp.Expr:
    """Write 1/tan and cot as cos/sin, 1/cot as sin/cos, 1/sec as cos and 1/csc as sin.

    Where tan has a pole, 1/tan is regular and zero: a motion passes there, so its formula must not divide by infinity.
    """
    inverse = {sp.tan: lambda u: sp.cos(u) / sp.sin(u), sp.cot: sp.tan, sp.sec: sp.cos, sp.csc: sp.sin}

    def is_inverse(e: sp.Expr) -> bool:
        return e.is_Pow and e.base.func in inverse and bool(e.exp.could_extract_minus_sign())

    found = sp.sympify(expression).replace(is_inverse, lambda e: inverse[e.base.func](e.base.args[0]) ** -e.exp)
    return found.replace(sp.cot, lambda u: sp.cos(u) / sp.sin(u))


def spread_exponentials(e: sp.Expr) -> sp.Expr:
    """Write e as a sum over products of exponentials where it is a polynomial in them.

    (exp(x) − 1)²·exp(−2x) cannot be enclosed over a wide interval of x: both factors change by many orders.
    Each term of 1 − 2 exp(−x) + exp(−2x) can. What is free of exponentials is left as it stands.
    """
    hidden: dict[sp.Dummy, sp.Expr] = {}

    def kept(x: sp.Expr) -> sp.Expr:
        name = sp.Dummy()
        hidden[name] = x
        return name

    def opened(x: sp.Expr) -> sp.Expr:
        if isinstance(x, sp.exp) or x.is_Number or x.is_Symbol:
            return x
        if not x.has(sp.exp):
            return kept(x)
        if x.is_Add or x.is_Mul:
            return x.func(*map(opened, x.args))
        if x.is_Pow and x.exp.is_Integer and 0 < x.exp <= _LARGEST_POWER:
            return opened(x.base) ** x.exp
        return kept(x)

    if not e.has(sp.exp):
        return e
    spread = sp.powsimp(sp.expand(opened(e), power_exp=False, power_base=False, log=False), combine="exp")
    return spread.xreplace(hidden) if sp.count_ops(spread) <= 4 * sp.count_ops(e) else e


def recentred(e: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Write polynomials in q inside functions and below the line about the place where they are shortest.

    exp(−10⁶q² + 38·10⁵q − 361·10⁴) is narrow, but its terms are not: over an interval, or in doubles, nothing is known
    of their sum. (q − 19/10)² is known. Exponentials in a product become one, so that none of them overflows.
    """
    if not e.has(q) or e.is_Atom:
        return e
    parts = [recentred(part, q) for part in e.args]
    if e.is_Mul and sum(isinstance(part, sp.exp) for part in parts) > 1:
        powers = [part.args[0] for part in parts if isinstance(part, sp.exp)]
        rest = [part for part in parts if not isinstance(part, sp.exp)]
        return sp.Mul(*rest, sp.exp(_shortest(sp.Add(*(sp.expand(x) for x in powers)), q)))
    if e.is_Pow and not (e.exp.is_Integer and e.exp > 0):
        return _shortest(parts[0], q) ** parts[1]
    if isinstance(e, sp.Function):
        return e.func(*(_shortest(part, q) for part in parts))
    return e.func(*parts)


def _shortest(e: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Return a polynomial in q of degree 2 or more about −cₙ₋₁/(n cₙ), where that leaves fewer terms.

    Else as it stands.
    """
    if not e.is_Add or not e.is_polynomial(q):
        return e
    polynomial = sp.Poly(e, q)
    n, terms = polynomial.degree(), polynomial.all_coeffs()
    if n < 2 or terms[1] == 0:
        return e
    place = -terms[1] / (n * terms[0])
    moved = [sp.cancel(c) for c in polynomial.compose(sp.Poly(q + place, q)).all_coeffs()]
    if sum(c != 0 for c in moved) >= sum(c != 0 for c in terms):
        return e
    return sp.Add(*(c * (q - place) ** (n - k) for k, c in enumerate(moved)))


def over_one_denominator(e: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Write a sum as one quotient where a sum in q is a denominator of all of its terms.

    Next to a zero of that denominator the terms are large and cancel: over an interval nothing is known of them.
    """
    terms = sp.Add.make_args(e)
    if len(terms) < 2 or not set.intersection(*(_denominators(term, q) for term in terms)):
        return e
    return sp.factor_terms(e)


def _denominators(term: sp.Expr, q: sp.Symbol) -> set[sp.Expr]:
    """Return sums with q below the line of a product, without their constant factors."""
    bases = (factor.as_base_exp()[0] for factor in sp.Mul.make_args(sp.fraction(term)[1]))
    return {sp.factor_terms(base).as_coeff_Mul()[1] for base in bases if base.is_Add and base.has(q)}


def _tamed(e: sp.Expr) -> sp.Expr:
    """Return a product without huge numbers over huge ones.

    Tanh for sinh/cosh, 1/(1 + exp(−x)) for exp(x)/(1 + exp(x)).

    Far out both overflow, and over an interval nothing would be known of the quotient.
    """
    for sine, m in e.as_powers_dict().items():
        if isinstance(sine, sp.sinh) and m.is_Integer:
            cosine = sp.cosh(sine.args[0])
            n = -e.as_powers_dict().get(cosine, sp.S.Zero)
            if n.is_Integer and m * n > 0:
                k = min(m, n, key=abs)
                e = e * cosine**k / sine**k * sp.tanh(sine.args[0]) ** k
    for factor in sp.Mul.make_args(e):
        if factor.is_Pow and factor.base.is_Add and factor.exp.is_Integer and factor.exp < 0:
            e = _shared_exponential(e, factor.base, int(-factor.exp))
    return e


def _shared_exponential(e: sp.Expr, below: sp.Add, n: int) -> sp.Expr:
    """Divide an exponential of the numerator, and a sum in the denominator with power n, by that of the sum."""
    above = next((factor.args[0] for factor in sp.Mul.make_args(e) if isinstance(factor, sp.exp)), None)
    found = [node.args[0] for term in below.args for node in sp.Mul.make_args(term) if isinstance(node, sp.exp)]
    if above is None or not found:
        return e
    fractions = [(ratio, a) for a in found if (ratio := sp.cancel(above / a)).is_Rational and ratio >= 1]
    if not fractions:
        return e
    ratio, a = min(fractions, key=lambda fraction: fraction[0])
    k = min(n, int(ratio))
    return _times_exponential(e * below**k, -k * a) / sp.Add(*(_times_exponential(t, -a) for t in below.args)) ** k


def _times_exponential(term: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """Return a product times exp(exponent), its exponentials made one."""
    factors = sp.Mul.make_args(term)
    rest = [factor for factor in factors if not isinstance(factor, sp.exp)]
    return sp.Mul(*rest, sp.exp(sp.expand(exponent + sum(f.args[0] for f in factors if isinstance(f, sp.exp)))))


class TapeWriter:
    """Gives each different subexpression one slot.

    Args:
        arguments: the inputs, in order.
    """

    def __init__(self, arguments: tuple[sp.Symbol, ...]):
        self.known: dict[sp.Expr, int] = {symbol: i for i, symbol in enumerate(arguments)}
        self.lines: dict[Operation, int] = {}
        self.operations: list[Operation] = []
        self.inputs = len(arguments)

    def slot(self, e: sp.Expr) -> int:
        """Return the slot of a subexpression, which is written where it is new.

        Args:
            e: of the inputs, or of what has a slot.
        """
        if e not in self.known:
            self.known[e] = self._write(e)
        return self.known[e]

    def _emit(self, code: str, operands: tuple[int, ...] = (), payload: tuple[int, ...] = ()) -> int:
        operation = Operation(code, operands, payload)
        if operation not in self.lines:
            self.lines[operation] = self.inputs + len(self.operations)
            self.operations.append(operation)
        return self.lines[operation]

    def _write(self, e: sp.Expr) -> int:
        if e.is_Rational:
            return self._emit("rational", payload=(int(e.p), int(e.q)))
        if e is sp.pi:
            return self._emit("pi")
        if e is sp.E:
            return self._emit("exp", (self.slot(sp.Integer(1)),))
        if e.is_Add:
            return self._sum(e)
        if e.is_Mul:
            return self._product(e)
        if isinstance(e, sp.exp):
            return self._emit("exp", (self.slot(e.args[0]),))
        if e.is_Pow:
            return self._power(*e.as_base_exp())
        name = _FUNCTIONS.get(e.func)
        if name is None:
            raise InvalidInputError(
                f"{e} has no numerical value here: give every symbol a value, and use only "
                "the functions that formulas may contain"
            )
        return self._emit(name, (self.slot(e.args[0]),))

    def _sum(self, e: sp.Add) -> int:
        positive = [t for t in e.args if not t.could_extract_minus_sign()]
        negative = [-t for t in e.args if t.could_extract_minus_sign()]
        if positive:
            total = self.slot(positive[0])
        else:
            total = self._emit("neg", (self.slot(negative.pop(0)),))
        for term in positive[1:]:
            total = self._emit("add", (total, self.slot(term)))
        for term in negative:
            total = self._emit("sub", (total, self.slot(term)))
        return total

    def _product(self, e: sp.Mul) -> int:
        if e.could_extract_minus_sign():
            return self._emit("neg", (self.slot(-e),))
        together = _tamed(e)
        if not together.is_Mul:
            return self.slot(together)
        e = together
        above, below = [], []
        for factor in e.args:
            if factor.is_Rational and max(abs(factor.p), factor.q).bit_length() <= _OF_A_DOUBLE:
                above.append(sp.Integer(factor.p))
                below.append(sp.Integer(factor.q))
            elif isinstance(factor, sp.Pow) and isinstance(factor.base, sp.cosh) and factor.exp.is_negative:
                above.append(sp.sech(*factor.base.args) ** -factor.exp)  # does not overflow
            elif isinstance(factor, sp.Pow) and factor.exp.could_extract_minus_sign():  # exp(−x) stays above
                below.append(1 / factor)
            else:
                above.append(factor)
        numerator, denominator = sp.Mul(*above), sp.Mul(*below)
        if denominator is sp.S.One:
            return self._factors(e)
        return self._emit("div", (self._factors(numerator), self._factors(denominator)))

    def _factors(self, e: sp.Expr) -> int:
        if not e.is_Mul:
            return self.slot(e)
        slots = [self.slot(factor) for factor in e.args]
        product = slots[0]
        for other in slots[1:]:
            product = self._emit("mul", (product, other))
        return product

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if base is sp.E:
            return self._emit("exp", (self.slot(exponent),))
        if exponent.is_Integer:
            if isinstance(base, sp.cosh) and exponent < 0:
                return self.slot(sp.sech(*base.args) ** -exponent)
            if exponent == -1:
                return self._emit("div", (self.slot(sp.Integer(1)), self.slot(base)))
            return self._emit("power", (self.slot(base),), (int(exponent),))
        if exponent.is_Rational and exponent.q == 2:
            root = self._emit("sqrt", (self.slot(base),))
            if exponent.p == 1:
                return root
            if exponent.p == -1:
                return self._emit("div", (self.slot(sp.Integer(1)), root))
            return self._emit("power", (root,), (int(exponent.p),))
        logarithm = self._emit("log", (self.slot(base),))
        return self._emit("exp", (self._emit("mul", (self.slot(exponent), logarithm)),))


def with_plain_exponents(e: sp.Expr, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Write xᶜ with the number of c where xᶜ is then a power or a root.

    The tape of a power with a letter in the exponent goes by exp(c log x), of which all arithmetics know less.
    """

    def plain(power: sp.Pow) -> sp.Expr:
        exponent = power.exp.subs(values)
        return power.base**exponent if (2 * exponent).is_Integer else power

    return e.replace(lambda x: x.is_Pow and not x.exp.is_number, plain)


@lru_cache(maxsize=256)
def momentum_squared_tapes(
    F: sp.Expr,
    q: sp.Symbol,
    constants: tuple[sp.Symbol, ...],
    parameters: tuple[sp.Symbol, ...],
    exact: tuple[sp.Expr, ...] | None = None,
) -> tuple[Tape, Tape, tuple[bool, ...], bool]:
    """p² and its kernels ½ ∂F/∂κⱼ as tapes; which kernels are zero everywhere; whether p² has period 2π by its form.

    Args:
        F: p²(q; κ).
        constants: symbols of the κⱼ.
        parameters: symbols of the parameters.
        exact: p² and then the kernels, with numbers for coefficients that nearly cancel; where they are not F's own.
    """
    inputs, kernels = [q, *constants, *parameters], [sp.diff(F, c) / 2 for c in constants]
    absent, periodic = tuple(k == 0 for k in kernels), bool(F.xreplace({q: q + 2 * sp.pi}) == F)
    if exact is not None:
        F, *kernels = exact
    F, *kernels = (without_removable_poles(e, q) for e in (F, *kernels))
    squared = recentred(spread_exponentials(over_one_denominator(F, q)), q)
    return lower([squared], inputs), lower([recentred(k, q) for k in kernels], inputs), absent, periodic
