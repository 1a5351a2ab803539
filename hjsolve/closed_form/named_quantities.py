"""Names for the quantities of which a form is made: amplitude, eccentricity, modulus, frequency, phase.

A form is written in few quantities that carry the physics; each is defined once, in ``where``, by the constants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import mpmath
import sympy as sp

from hjsolve.closed_form.evaluation import number_of
from hjsolve.closed_form.tidy import ELLIPTIC, elliptic, longer_than, multiplied_out, shortened_powers
from hjsolve.functions.printing import Printable
from hjsolve.precision import mp

Where = dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
"""Symbol → its definition: an expression, or (polynomial, index of the real root)."""
LONG_FORM, LONG_PART = 150, 8
"""Operations of a form whose constant parts get names, and of such a part."""
SHORT, LONG_FACTOR = 2, 12
"""Operations up to which a quantity, or a factor that may cancel, is written where it stands."""


class NamedQuantities:
    """The names given in the forms of one regime.

    Args:
        taken: names that have another meaning.
        variables: on which coordinates depend: the time, the parameter τ, ignorable coordinates.
        places: separated coordinates.
        where: known definitions, of roots; new ones are added.
        numbers: symbol → value at a motion of the regime, of constants and roots.
    """

    def __init__(
        self, taken: Iterable[str], variables: Iterable[sp.Symbol], places: Iterable[sp.Symbol], where: Where,
        numbers: Mapping[sp.Symbol, mpmath.mpf],
    ):  # fmt: skip
        self.roots, self.numbers = frozenset(where), dict(numbers)
        self.moduli = dict[sp.Expr, sp.Expr]()  # parameter or characteristic → its name
        self.rates = dict[sp.Symbol, sp.Expr]()  # moduli and rates of elliptic integrals → what they are
        self.located = dict[sp.Symbol, mpmath.mpf]()  # coordinates and lower limits → where a motion is
        self.where, self.variables, self.places = where, frozenset(variables), frozenset(places)
        self._taken = {*taken, *(s.name for s in where)}
        self._pairs = list[tuple[sp.Expr, sp.Expr]]()

    def named(self, letter: str, meaning: sp.Expr, *, short: int = 0, positive: bool | None = None) -> sp.Expr:
        """Return a symbol for a quantity, the same for the same meaning; the quantity itself where it is short.

        Args:
            letter: wished for; a number is added where it is taken.
            meaning: the definition.
            short: operations up to which the quantity needs no name; of numbers and symbols none has.
            positive: whether it is known to be positive.
        """
        # a reader looks each name up: what is as short as its name has none
        if meaning.is_number or meaning.is_Symbol or (short and sp.count_ops(meaning) <= short):
            return meaning
        known = next((s for s, m in self.where.items() if not isinstance(m, tuple) and m == meaning), None)
        if known is not None:
            return known
        name, number = letter, 0
        while name in self._taken:
            number += 1
            name = f"{letter}_{number}"
        self._taken.add(name)
        symbol = sp.Symbol(name, positive=True) if positive else sp.Symbol(name, real=True)
        self.where[symbol] = meaning
        return symbol

    def same(self, letter: str, meaning: sp.Expr) -> sp.Expr:
        """As ``named``, the name of what has the same value at a motion of the regime where there is one.

        Args:
            letter: wished for.
            meaning: the definition.
        """
        # two formulas of one number are not the same to sympy; to 40 digits at a motion of the regime they are
        value = self._value(meaning)
        known = (s for s, m in self.where.items() if s.name.startswith(letter) and not isinstance(m, tuple))
        for symbol in known:
            other = self._value(sp.sympify(self.where[symbol]))
            if abs(value - other) <= abs(value) * mp.mpf(10) ** -40:
                return symbol
        return self.named(letter, meaning)

    def _value(self, meaning: sp.Expr) -> mpmath.mpf:
        """Return a number for a quantity: at the motion of the regime, what else it holds anywhere."""
        explicit = self.written_out(meaning)
        with mp.workdps(60):
            numbers = self.numbers | self.located
            free = sorted(explicit.free_symbols - set(numbers), key=str)
            return number_of(explicit, numbers | {s: mp.mpf(k + 3) / 7 for k, s in enumerate(free)})

    def oriented(self, expression: sp.Expr) -> sp.Expr:
        """Return a form with the greater one first in each difference of roots, as the regime orders them.

        A minus sign of a product goes into a sum that is negative at the regime's motion: k/2(E − c), not −k/2(c − E).
        """
        return expression.replace(lambda e: e.is_Mul or e.is_Pow, self._oriented)

    def _oriented(self, expression: sp.Expr) -> sp.Expr:
        factors, turned, numbers = list[sp.Expr](), 1, self.numbers | self.located
        for factor in sp.Mul.make_args(expression):
            base, power = factor.as_base_exp()
            held = base.free_symbols
            difference = base.is_Add and power.is_Integer and held & self.roots and held <= numbers.keys()
            # roots keep their order in a regime: x₃ − x₂ is positive everywhere, if it is so at one motion
            if difference and number_of(base, numbers) < 0:
                factor, turned = sp.Add(*(-term for term in base.args)) ** power, turned * (-1) ** int(power)
            factors.append(factor)
        lead = turned * sp.Mul(*(f for f in factors if f.is_number))
        if lead.is_negative:
            for n, factor in enumerate(factors):
                base, power = factor.as_base_exp()
                odd = base.is_Add and power.is_Integer and power % 2 and base.free_symbols <= self.numbers.keys()
                if odd and not elliptic(base) and number_of(base, self.numbers) < 0:
                    factors[n], turned = sp.Add(*(-term for term in base.args)) ** power, -turned
                    break
        whole = sp.Mul(*factors) if turned > 0 else sp.Mul(-1, *factors)
        return expression if tuple(factors) == sp.Mul.make_args(expression) else whole

    def amplitudes(self, value: sp.Expr, q: sp.Symbol, start: sp.Symbol) -> tuple[sp.Expr, sp.Expr]:
        """Return an integral at a place and at its lower limit, with long angles in it by names, χ and χ₀.

        Args:
            value: as a function of q.
            q: the place.
            start: the lower limit.
        """
        table = dict[sp.Expr, sp.Expr]()
        for angle in sorted(_angles(value, q), key=sp.default_sort_key):
            if sp.count_ops(angle) <= (3 if elliptic(value) else LONGEST_ANGLE):
                continue
            if not isinstance(angle, _ARCS) or isinstance(angle, sp.atan2):
                table[angle] = angle
                continue
            function, (inside,) = angle.func, angle.args
            # arcsin √s has the same name for either way to write s, if its differences are oriented
            even = inside.as_base_exp()[1] == sp.S.Half
            plain = function(sp.sqrt(self.oriented(sp.factor(inside.base)))) if even else function(inside)
            table[angle] = plain
        return self._paired(value, table, q, start)

    def _paired(
        self, value: sp.Expr, table: Mapping[sp.Expr, sp.Expr], q: sp.Symbol, start: sp.Symbol
    ) -> tuple[sp.Expr, sp.Expr]:  # fmt: skip
        here, there = dict[sp.Expr, sp.Expr](), dict[sp.Expr, sp.Expr]()
        for angle, plain in table.items():
            number = 0
            # F, E and Π of a coordinate have one amplitude: one χ for all of them, and χ₀ at the lower limit
            pair = next(((χ, χ_0) for χ, χ_0 in self._pairs if self.where[χ] == plain), None)
            while pair is None:
                letter = f"chi_{number}" if number else "chi"
                number += 1
                if not {letter, f"{letter}_0"} & self._taken:
                    pair = (self.named(letter, plain), self.named(f"{letter}_0", plain.xreplace({q: start})))
                    self._pairs.append(pair)
            here[angle], there[angle] = pair
        return value.xreplace(here), value.xreplace(there).xreplace({q: start})

    def shortest(self, value: sp.Expr) -> sp.Expr:
        """Return a constant in names or written by the constants, as it is shorter."""
        if longer_than(value, LONG_FACTOR * 4):
            return value
        return min((shortened_powers(sp.factor(e)) for e in (value, self.written_out(value))), key=sp.count_ops)

    def with_named_parts(self, value: sp.Expr) -> sp.Expr:
        """Return a long form with its constant parts by names.

        Args:
            value: of a form; a short one is given back.
        """
        if not longer_than(value, LONG_FORM):
            return value
        varying = {*self.variables, *self.places, *self.located, *(χ for pair in self._pairs for χ in pair)}
        varying |= {s for s in value.free_symbols if s.name in ("xi", "chi", "xi_1")}
        return self._parts(value, _Dependence(varying))

    def _parts(self, e: sp.Expr, depends: _Dependence) -> sp.Expr:
        if not depends.moves(e):
            return e if not e.args or sp.count_ops(e) < LONG_PART else self.named("c", e)
        if not e.args or not depends.has_constants(e):
            return e
        # only sums and products may be parted into what varies and what does not
        if not (e.is_Add or e.is_Mul):
            return e.func(*(self._parts(part, depends) for part in e.args))
        constant = e.func(*(part for part in e.args if not depends.moves(part)))
        moving = [part for part in e.args if depends.moves(part)]
        return e.func(self._parts(constant, depends), *(self._parts(part, depends) for part in moving))

    def in_brackets(self, value: sp.Expr) -> sp.Expr:
        """Return a sum with c (χ − χ₀) in place of c χ − c χ₀.

        Args:
            value: of a form.
        """
        for χ, χ_0 in self._pairs:
            c = value.coeff(χ)
            if c != 0 and not c.has(χ, χ_0) and sp.expand(c + value.coeff(χ_0)) == 0:
                # c (χ − χ₀) and what is left, which must be free of both: else one of them stands elsewhere, too
                rest = value - c * χ + c * χ_0
                if not rest.has(χ, χ_0):
                    value = rest + sp.factor(c) * (χ - χ_0)
        return value

    def short_rates(self) -> dict[sp.Symbol, sp.Expr]:
        """Moduli and rates that are as well written by the constants."""
        return {
            s: e
            for s, e in self.rates.items()
            if not e.free_symbols & set(self.where) and min(sp.count_ops(e), sp.count_ops(e**2)) <= SHORT_RATE
        }

    def kept(self, forms: Iterable[sp.Expr], written: Callable[[sp.Expr], sp.Expr]) -> Where:
        """Return the definitions of roots, and those that forms use, each after those that it uses.

        Args:
            forms: of the regime.
            written: how a definition is written.
        """
        held = {s for form in forms for s in form.free_symbols}
        angles = {
            self.where[χ_0]: χ_0 for _, χ_0 in self._pairs if χ_0 in held
        }  # those that forms use stand for theirs
        where = {
            s: meaning
            if isinstance(meaning, tuple) or s in self.roots or s in angles.values()
            else meaning.xreplace(angles)
            for s, meaning in self.where.items()
        }
        ordered = needed_names(self.roots, where)[0] | needed_names(held, where)[0]
        return {
            s: meaning if isinstance(meaning, tuple) or s in self.roots else written(meaning)
            for s, meaning in ordered.items()
        }

    def written_out(self, expression: sp.Expr) -> sp.Expr:
        """Return an expression with the definitions in place of the names.

        Args:
            expression: of a form.
        """
        return written_out(expression, self.where)

    def at(self, expression: sp.Expr, numbers: Mapping[sp.Symbol, mpmath.mpf]) -> dict[sp.Symbol, mpmath.mpf]:
        """Return numbers with those of the names that an expression rests on, roots excepted, which must be there.

        Written out in full, a form of Vinti's takes sympy ten seconds.

        Args:
            expression: of a form.
            numbers: symbol → number, in mpmath's present precision.
        """
        known = dict(numbers)
        for symbol, meaning in needed_names(expression.free_symbols, self.where)[0].items():
            if not isinstance(meaning, tuple) and meaning.free_symbols <= known.keys():
                known[symbol] = number_of(meaning, known)
        return known


class _Dependence:
    """What parts of one form depend on; each part is asked once, where sympy's sets of symbols go down every time.

    Args:
        varying: the symbols that vary along a motion.
    """

    def __init__(self, varying: set[sp.Symbol]):
        self.varying = varying
        self._moves, self._constants = dict[sp.Expr, bool](), dict[sp.Expr, bool]()

    def moves(self, e: sp.Expr) -> bool:
        """Whether it varies along a motion, or has an elliptic function, which no constant part takes over."""
        if e not in self._moves:
            self._moves[e] = e in self.varying or isinstance(e, ELLIPTIC) or any(map(self.moves, e.args))
        return self._moves[e]

    def has_constants(self, e: sp.Expr) -> bool:
        """Whether it has a symbol that does not vary."""
        if e not in self._constants:
            self._constants[e] = e not in self.varying if e.is_Symbol else any(map(self.has_constants, e.args))
        return self._constants[e]


def written_out(expression: sp.Expr, where: Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]) -> sp.Expr:
    """Return an expression with definitions in place of names; roots of polynomials stay by name.

    Args:
        expression: of a form.
        where: symbol → definition.
    """
    table = {s: meaning for s, meaning in where.items() if not isinstance(meaning, tuple)}
    # names are defined by names
    while held := expression.free_symbols & set(table):
        expression = expression.xreplace({s: table[s] for s in held})
    return expression


def needed_names(
    held: Iterable[sp.Symbol], where: Mapping[sp.Symbol, sp.Expr | tuple[sp.Poly, int]]
) -> tuple[dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]], set[sp.Symbol]]:
    """Return the definitions that symbols rest on, each after those that it uses, and the symbols without a definition.

    Args:
        held: symbols of a form.
        where: symbol → definition.
    """
    ordered: dict[sp.Symbol, sp.Expr | tuple[sp.Poly, int]] = {}
    plain = set[sp.Symbol]()

    def visit(symbol: sp.Symbol) -> None:
        if symbol not in where:
            plain.add(symbol)
        elif symbol not in ordered:
            meaning = where[symbol]
            inner = (
                {s for c in meaning[0].all_coeffs() for s in c.free_symbols}
                if isinstance(meaning, tuple)
                else meaning.free_symbols
            )
            for s in sorted(inner, key=str):
                visit(s)
            ordered[symbol] = meaning

    for s in sorted(held, key=str):
        visit(s)
    return ordered, plain


_ARCS = (sp.asin, sp.acos, sp.atan, sp.atan2, sp.asinh, sp.acosh, sp.atanh, sp.log)
SHORT_RATE = 12
"""Operations of a modulus or a rate that is written by the constants in a period."""
LONGEST_ANGLE = 10
"""Operations of an arc function that is written where it stands."""


def _angles(value: sp.Expr, q: sp.Symbol) -> set[sp.Expr]:
    """Return the arc functions of a place in a formula that are in no other, and arguments of Carlson's integrals."""
    if isinstance(value, _ARCS):
        return {value} if value.has(q) else set()
    if isinstance(value, Printable) and elliptic(value):
        return {part for part in value.args if part.has(q)}
    return set().union(*(_angles(part, q) for part in value.args if part.has(q)))


class Phase:
    """The argument α(v − v_p) of a periodic or hyperbolic function, by the place v_p at which it is zero.

    Args:
        names: of the regime.
        amount: what the integral from the lower limit is, an expression in v.
        factor: of the amount in the argument.
        begin: the argument where the amount is zero.
        even: whether the function does not see the sign of its argument.
    """

    def __init__(self, names: NamedQuantities, amount: sp.Expr, factor: sp.Expr, begin: sp.Expr, *, even: bool):
        self.names, self.even = names, even
        running = sp.expand(multiplied_out(amount), deep=False)
        moving = [v for v in names.variables if running.has(v)]
        # linear in one variable, α v + β: the argument is ω (v − v_p), with the place of the turning point in it
        if len(moving) == 1 and not running.has(*names.places) and (α := running.coeff(moving[0])) != 0:
            self.argument = self._about(moving[0], factor * α, running / α, begin)
            return
        held = [*moving, *(q for q in names.places if running.has(q))]
        size, sign = without_sign(shortened_powers(factor))
        rate = sign * names.named("kappa", size, short=LONG_FACTOR, positive=True)
        parts = [shortened_powers(rate * term) for term in sp.Add.make_args(running)]
        # of an integral over another coordinate nothing is linear: what is constant in it is one phase δ
        δ = names.named("delta", -sp.Add(*(part for part in parts if not part.has(*held)), begin))
        self.argument = sp.Add(*(part for part in parts if part.has(*held))) - δ

    def _about(self, v: sp.Symbol, α: sp.Expr, running: sp.Expr, begin: sp.Expr) -> sp.Expr:
        size, sign = without_sign(shortened_powers(sp.factor_terms(α)))
        rate = self.names.named("omega" if v.name in ("t", "tau") else "kappa", size, short=SHORT, positive=True)
        terms = sp.Add.make_args(sp.expand(running, deep=False))
        start = sp.Add(*(shortened_powers(sp.cancel(-term)) for term in terms if not term.has(v)))
        # ω (v − start) + begin = ω (v − v_p)
        passed = self.names.named(f"{v.name}_p", start - begin * sign / rate)
        return (sp.S.One if self.even else sign) * rate * (v - passed)


def without_sign(α: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return a factor without −1 and signs of constants, and those.

    The former is positive where the constants' signs are.

    Args:
        α: a product, real and not zero.
    """
    sign = sp.S.One
    size = sp.S.One
    for factor in sp.Mul.make_args(α):
        if isinstance(factor, sp.sign):
            sign *= factor
        elif factor.is_number and factor.is_negative:
            sign, size = -sign, -factor * size
        elif factor.is_nonnegative or factor.is_number or _is_root(factor):
            size *= factor
        else:  # a sum, or a symbol of either sign: its absolute value
            base, power = factor.as_base_exp()
            sign, size = sign * sign_of_factors(factor), size * sp.Abs(base) ** power
    return size, sign


def sign_of_factors(product: sp.Expr) -> sp.Expr:
    """Return the sign of a product as that of its factors, even powers left out.

    Args:
        product: real, not zero.
    """
    sign = sp.S.One
    for factor in sp.Mul.make_args(product):
        base, power = factor.as_base_exp()
        whole = power.is_Integer and not base.is_number
        sign *= (sp.sign(base) if power % 2 else sp.S.One) if whole else sp.sign(factor)
    return sign


def _is_root(factor: sp.Expr) -> bool:
    """Return whether a factor is a root with an even denominator: real, and so positive, where its form holds."""
    return isinstance(factor, sp.Pow) and factor.exp.is_Rational and not factor.exp.is_Integer and factor.exp.q % 2 == 0
